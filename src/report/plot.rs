//! Curves over levels, as inline SVG.

use super::svg::{Svg, cut, number, ticks};

/// One curve.
pub(super) struct Line {
    pub name: String,
    /// Class of colour, dash and marker.
    pub style: Style,
    /// Level, mean, standard error.
    pub points: Vec<(usize, f64, f64)>,
}

/// How a chain is told from the others without its colour alone: by marker and dash.
#[derive(Clone, Copy)]
pub(super) struct Style {
    colour: Option<usize>,
    marker: usize,
    dash: usize,
}

/// Colours of the style sheet.
const COLOURS: usize = 6;
const MARKERS: usize = 5;

impl Style {
    /// Plain mips: gray, dashed, crosses.
    pub const PLAIN: Self = Self { colour: None, marker: 4, dash: 1 };

    /// Of the `index`-th chain that is not plain. Colours, markers and dashes go round at different speeds: twelve chains
    /// differ by more than colour, and all 6 x 4 x 3 looks come before one returns.
    pub fn chain(index: usize) -> Self {
        let round = index / 12;
        let dash = [0, 2, 3][(index / 2 + round / 2) % 3];
        Self { colour: Some(index % COLOURS), marker: (index + round) % (MARKERS - 1), dash }
    }

    fn class(self) -> String {
        self.colour.map_or("sp".into(), |colour| format!("s{colour}"))
    }

    /// Path of the marker about a point.
    fn marker(self, (x, y): (f64, f64)) -> String {
        let at = |points: &[(f64, f64)]| -> String {
            let points: Vec<_> =
                points.iter().map(|(dx, dy)| format!("{} {}", number(x + dx), number(y + dy))).collect();
            format!("M{}Z", points.join("L"))
        };
        match self.marker {
            0 => format!("M{} {}a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0 -7.2 0Z", number(x - 3.6), number(y)),
            1 => at(&[(-3.3, -3.3), (3.3, -3.3), (3.3, 3.3), (-3.3, 3.3)]),
            2 => at(&[(0.0, -4.4), (4.2, 3.2), (-4.2, 3.2)]),
            3 => at(&[(0.0, -4.8), (4.8, 0.0), (0.0, 4.8), (-4.8, 0.0)]),
            _ => {
                let arms = [((-3.2, -3.2), (3.2, 3.2)), ((-3.2, 3.2), (3.2, -3.2))];
                arms.iter().map(|((a, b), (c, d))| at(&[(*a, *b), (*c, *d)])).collect()
            }
        }
    }

    /// Line and marker for a legend, where the name stands beside them.
    pub fn swatch(self) -> String {
        let mut svg = Svg::ornament("swatch", (34.0, 12.0));
        svg.open("g", &[("class", &self.class())]);
        svg.line((1.0, 6.0), (33.0, 6.0), &format!("line d{}", self.dash));
        svg.path(&self.marker((17.0, 6.0)), "mark");
        svg.close("g");
        svg.finish()
    }
}

/// A limit: first level, last level, height, and the number that was set.
pub(super) type LimitLine = (usize, usize, f64, f64);

/// What to draw.
pub(super) struct Chart<'a> {
    pub id: &'a str,
    pub title: &'a str,
    pub description: &'a str,
    pub lines: &'a [Line],
    pub limits: &'a [LimitLine],
    /// Whether 1 is right, and not 0.
    pub ratio: bool,
    pub size: (f64, f64),
    /// Whether the curves are named at their ends.
    pub named: bool,
}

/// Letters of a curve's name at its end, and the pixels they take.
const NAME_LETTERS: usize = 20;
const NAME_WIDTH: f64 = 164.0;
/// Least distance between two names.
const NAME_PITCH: f64 = 15.0;

/// Draws it. Figures that are not numbers leave gaps.
pub(super) fn draw(chart: &Chart) -> String {
    let (width, height) = chart.size;
    let (left, top) = (44.0, 12.0);
    let (right, bottom) = (width - if chart.named { NAME_WIDTH } else { 12.0 }, height - 38.0);
    let right_answer = f64::from(u8::from(chart.ratio));

    let points = || chart.lines.iter().flat_map(|line| &line.points).filter(|p| p.1.is_finite());
    let last = points().map(|p| p.0).max().unwrap_or(1).max(1);
    let (mut low, mut high) = (right_answer, right_answer);
    for (_, mean, stderr) in points() {
        let reach = if stderr.is_finite() { 2.0 * stderr } else { 0.0 };
        (low, high) = (low.min(mean - reach), high.max(mean + reach));
    }
    chart.limits.iter().for_each(|limit| (low, high) = (low.min(limit.2), high.max(limit.2)));
    // Means cannot be negative; error bars at 0 are cut.
    (low, high) = (if chart.ratio { low.min(0.95) } else { 0.0 }, high.max(right_answer + 0.05));
    let (steps, decimals) = ticks(low, high, if chart.named { 6 } else { 4 });
    let (low, high) = (steps[0], steps[steps.len() - 1]);

    let x = |level: f64| left + (right - left) * (level + 0.25) / (last as f64 + 0.5);
    let y = |v: f64| bottom - (bottom - top) * ((v - low) / (high - low)).clamp(0.0, 1.0);

    let mut svg = Svg::new(chart.id, "chart", chart.size, chart.title, chart.description);
    for &step in &steps {
        svg.line((left, y(step)), (right, y(step)), "grid");
        svg.text((left - 8.0, y(step) + 4.0), "tick", "end", &format!("{step:.decimals$}"));
    }
    let stride = last / 14 + 1;
    for level in (0..=last).step_by(stride) {
        svg.text((x(level as f64), bottom + 17.0), "tick", "middle", &level.to_string());
    }
    svg.text((0.5 * (left + right), height - 4.0), "axis", "middle", "mip level");
    svg.line((left, y(right_answer)), (right, y(right_answer)), "truth");

    let mut names = Vec::new();
    for &(first, end, at, most) in chart.limits.iter().filter(|limit| limit.0 <= last) {
        let end = end.min(last) as f64;
        svg.line((x(first as f64 - 0.25), y(at)), (x(end + 0.25), y(at)), "limit");
        let name = if chart.ratio { format!("limit \u{b1}{most}") } else { format!("limit {most}") };
        names.push(((x(first as f64 - 0.25) + 4.0, y(at) - 5.0), name));
    }
    for line in chart.lines {
        svg.open("g", &[("class", &line.style.class())]);
        let mut path = String::new();
        let mut pen = 'M';
        for &(level, mean, stderr) in &line.points {
            if !mean.is_finite() {
                pen = 'M';
                continue;
            }
            let (px, py) = (x(level as f64), y(mean));
            path += &format!("{pen}{} {}", number(px), number(py));
            pen = 'L';
            if stderr > 0.0 && stderr.is_finite() {
                let (up, down) = (y(mean + 2.0 * stderr), y(mean - 2.0 * stderr));
                svg.line((px, up), (px, down), "bar");
                svg.line((px - 3.0, up), (px + 3.0, up), "bar");
                svg.line((px - 3.0, down), (px + 3.0, down), "bar");
            }
        }
        svg.path(&path, &format!("line d{}", line.style.dash));
        for &(level, mean, _) in line.points.iter().filter(|p| p.1.is_finite()) {
            svg.path(&line.style.marker((x(level as f64), y(mean))), "mark");
        }
        svg.close("g");
    }
    // Above the curves, which they may cross.
    names.iter().for_each(|(place, name)| svg.text(*place, "limit-name", "start", name));
    if chart.named {
        name_lines(&mut svg, chart.lines, (top, bottom), right, &|level, mean| (x(level as f64), y(mean)));
    }
    svg.finish()
}

/// Names beside the ends of the curves, pushed apart where they would meet, with a thin line to the curve.
fn name_lines(
    svg: &mut Svg,
    lines: &[Line],
    (top, bottom): (f64, f64),
    right: f64,
    place: &dyn Fn(usize, f64) -> (f64, f64),
) {
    let end = |line: &Line| line.points.iter().rev().find(|p| p.1.is_finite()).map(|p| place(p.0, p.1));
    let mut ends: Vec<_> = lines.iter().filter_map(|line| Some((end(line)?, line))).collect();
    ends.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
    let mut heights: Vec<f64> = ends.iter().map(|(end, _)| end.1).collect();
    for i in 1..heights.len() {
        heights[i] = heights[i].max(heights[i - 1] + NAME_PITCH);
    }
    // What was pushed below the axis pushes back up.
    let mut floor = bottom;
    for height in heights.iter_mut().rev() {
        *height = height.min(floor).max(top);
        floor = *height - NAME_PITCH;
    }
    for ((end, line), height) in ends.into_iter().zip(heights) {
        svg.line((end.0 + 7.0, end.1), (right + 6.0, height), "leader");
        let class = format!("name {}", line.style.class());
        svg.text((right + 10.0, height + 4.0), &class, "start", &cut(&line.name, NAME_LETTERS));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(lines: &[Line], limits: &[LimitLine]) -> String {
        let size = (400.0, 200.0);
        draw(&Chart { id: "c", title: "t", description: "d", lines, limits, ratio: false, size, named: true })
    }

    fn line(points: Vec<(usize, f64, f64)>) -> Line {
        Line { name: "a".into(), style: Style::chain(0), points }
    }

    #[test]
    fn figures_that_are_not_numbers_leave_gaps() {
        let svg = chart(&[line(vec![(0, 0.0, 0.0), (1, f64::NAN, 0.1), (2, 0.3, f64::NAN)])], &[]);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let curve = svg.split("d=\"").find(|part| part.contains("class=\"line d0\"")).unwrap();
        assert_eq!(curve.matches('M').count(), 2, "{curve}");
    }

    #[test]
    fn limits_are_drawn_over_their_levels_and_in_sight() {
        let lines = [line((0..5).map(|k| (k, 0.01, 0.001)).collect())];
        let svg = chart(&lines, &[(1, usize::MAX, 0.5, 0.5), (9, 9, 0.1, 0.1)]);
        assert_eq!(svg.matches("class=\"limit\"").count(), 1);
        assert!(svg.contains("limit 0.5") && svg.contains(">0.5</text>"));
    }

    #[test]
    fn styles_differ_by_more_than_colour() {
        let looks: Vec<_> = (0..12).map(Style::chain).chain([Style::PLAIN]).map(|s| (s.marker, s.dash)).collect();
        assert!((0..looks.len()).all(|i| !looks[..i].contains(&looks[i])), "{looks:?}");
        let all = |i| {
            let Style { colour, marker, dash } = Style::chain(i);
            (colour, marker, dash)
        };
        assert_eq!((0..72).map(all).collect::<std::collections::HashSet<_>>().len(), 72);
    }

    #[test]
    fn an_empty_chart_is_sound() {
        assert!(chart(&[], &[]).ends_with("</svg>"));
    }
}
