//! Perceptual roughness of every level, before and after.

use super::svg::{Svg, cut, number};
use crate::ndf::{Lobe, Lobes};
use crate::roughness::Alpha;

const BINS: usize = 50;

/// Texels counted in a level, about; a regular choice where there are more.
const MOST_TEXELS: usize = 1 << 16;

/// Perceptual roughness of a level, of several lobes each by its weight.
#[derive(Clone)]
pub(super) struct Spread {
    /// Share of the texels in each 50th of 0 to 1.
    pub bins: [f64; BINS],
    pub mean: f64,
    pub p5: f64,
    pub p95: f64,
}

impl Spread {
    pub fn of(lobes: &Lobes) -> Self {
        let size = lobes.size();
        // An odd step does not keep to the columns of an even texture.
        let step = (size.texels() / MOST_TEXELS).max(1) | 1;
        let roughness = |(lobe, weight): (Lobe, f32)| {
            (f64::from(Alpha::from_squared(lobe.roughness.mean()).perceptual().0), f64::from(weight))
        };
        let texels = (0..size.texels()).step_by(step);
        let all = texels.flat_map(|i| lobes.mixture(i % size.width, i / size.width)).map(roughness);
        let mut values: Vec<(f64, f64)> = all.filter(|(r, _)| r.is_finite()).collect();
        if values.is_empty() {
            values.push((1.0, 1.0));
        }
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = values.iter().map(|(_, weight)| weight).sum();
        let mut bins = [0.0; BINS];
        values.iter().for_each(|(r, weight)| bins[((r * BINS as f64) as usize).min(BINS - 1)] += weight / total);
        let at = |q: f64| {
            let mut left = q * total;
            let place = values.iter().position(|(_, weight)| {
                left -= weight;
                left < 0.0
            });
            values[place.unwrap_or(values.len() - 1)].0
        };
        let mean = values.iter().map(|(r, weight)| r * weight).sum::<f64>() / total;
        Self { bins, mean, p5: at(0.05), p95: at(0.95) }
    }
}

const WIDTH: f64 = 336.0;
const LEFT: f64 = 24.0;
const RIGHT: f64 = WIDTH - 10.0;
const ROW: f64 = 27.0;
const TOP: f64 = 6.0;

/// One row a level, finest above: filled what a chain has, outlined what it had before.
pub(super) fn ridges(id: &str, name: &str, before: &[Spread], after: &[Spread]) -> String {
    let title = format!("Roughness of {name}, level by level");
    let last = after.len().saturating_sub(1);
    let (from, to) = (after.first().map_or(0.0, |s| s.mean), after.last().map_or(0.0, |s| s.mean));
    let description = format!(
        "Histograms of perceptual roughness. The mean goes from {from:.2} at level 0 to {to:.2} at level {last}."
    );
    let bottom = TOP + after.len() as f64 * ROW;
    let mut svg = Svg::new(id, "ridges", (WIDTH, bottom + 32.0), &title, &description);
    let x = |r: f64| LEFT + (RIGHT - LEFT) * r;
    for tick in [0.0, 0.25, 0.5, 0.75, 1.0] {
        svg.line((x(tick), TOP), (x(tick), bottom), "grid");
        svg.text((x(tick), bottom + 14.0), "tick", "middle", &number(tick));
    }
    svg.text((x(0.5), bottom + 29.0), "axis", "middle", "perceptual roughness");
    for (k, spread) in after.iter().enumerate() {
        let floor = TOP + (k + 1) as f64 * ROW - 2.0;
        svg.text((LEFT - 8.0, floor - 4.0), "tick", "end", &k.to_string());
        svg.line((LEFT, floor), (RIGHT, floor), "floor");
        svg.path(&shape(&spread.bins, floor, true), "after");
        if let Some(before) = before.get(k) {
            svg.path(&shape(&before.bins, floor, false), "before");
        }
    }
    svg.finish()
}

/// The steps of a histogram, its largest bin as high as the row.
fn shape(bins: &[f64; BINS], floor: f64, closed: bool) -> String {
    let most = bins.iter().copied().fold(0.0, f64::max).max(1e-9);
    let (first, last) = (bins.iter().position(|b| *b > 0.0), bins.iter().rposition(|b| *b > 0.0));
    let (Some(first), Some(last)) = (first, last) else { return String::new() };
    let x = |i: usize| number(LEFT + (RIGHT - LEFT) * i as f64 / BINS as f64);
    let mut path = format!("M{} {}", x(first), number(floor));
    for i in first..=last {
        path += &format!("V{}H{}", number(floor - (ROW - 6.0) * bins[i] / most), x(i + 1));
    }
    path += &format!("V{}", number(floor));
    if closed {
        path.push('Z');
    }
    path
}

/// Name, what it had before, and what it has.
pub(super) struct Panel {
    pub name: String,
    pub svg: String,
}

/// One panel a chain. `before` is plain mips, or nothing.
pub(super) fn panels(names: &[&str], spreads: &[Vec<Spread>], plain: Option<usize>) -> Vec<Panel> {
    let before = plain.map_or(&[][..], |i| &spreads[i][..]);
    let chains = names.iter().zip(spreads).enumerate().filter(|(i, _)| Some(*i) != plain || names.len() == 1);
    chains
        .map(|(i, (name, spread))| Panel {
            name: cut(name, 40),
            svg: ridges(&format!("ridges-{i}"), name, if Some(i) == plain { &[] } else { before }, spread),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;
    use crate::ndf::Form;
    use crate::roughness::PerceptualRoughness;
    use glam::Vec3;

    #[test]
    fn texels_are_counted_where_they_belong() {
        let lobes = Lobes::from_fn(Form::Isotropic, Size::new(10, 10), |x, _| {
            Lobe::isotropic(Vec3::Z, PerceptualRoughness(if x < 3 { 0.31 } else { 1.0 }).alpha())
        });
        let spread = Spread::of(&lobes);
        assert!((spread.bins[15] - 0.3).abs() < 1e-9 && (spread.bins[BINS - 1] - 0.7).abs() < 1e-9);
        assert!((spread.mean - 0.793).abs() < 1e-5);
        assert!((spread.p5 - 0.31).abs() < 1e-6 && spread.p95 == 1.0);
        assert!((spread.bins.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        // The same shares as lobes of every texel.
        let part = |r: f32| Lobe::isotropic(Vec3::Z, PerceptualRoughness(r).alpha());
        let mixed = Lobes::mixed_from_fn(Form::Isotropic, 2, Size::new(3, 3), |j, _, _| {
            [(part(1.0), 0.7), (part(0.31), 0.3)][j]
        });
        let mixed = Spread::of(&mixed);
        assert!(mixed.bins.iter().zip(spread.bins).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!((mixed.mean - spread.mean).abs() < 1e-6 && mixed.p5 == spread.p5 && mixed.p95 == spread.p95);
    }
}
