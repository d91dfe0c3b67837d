//! Inline SVG, written with all text escaped.

use std::fmt::{Display, Write};

/// An SVG picture in the making. It has a title and a description, which screen readers read out.
pub(super) struct Svg(String);

impl Svg {
    /// A picture `width` x `height` units. `id` is unique on the page.
    pub fn new(id: &str, class: &str, (width, height): (f64, f64), title: &str, description: &str) -> Self {
        let mut svg = Self(String::new());
        let (t, d) = (format!("{id}-title"), format!("{id}-desc"));
        let view = format!("0 0 {} {}", number(width), number(height));
        svg.open(
            "svg",
            &[
                ("id", &id),
                ("class", &class),
                ("viewBox", &view),
                ("role", &"img"),
                ("aria-labelledby", &format!("{t} {d}")),
                ("style", &format!("--w:{}px", number(width))),
            ],
        );
        svg.element("title", &[("id", &t)], title);
        svg.element("desc", &[("id", &d)], description);
        svg
    }

    /// A picture that says nothing beyond the text beside it; screen readers pass over it.
    pub fn ornament(class: &str, (width, height): (f64, f64)) -> Self {
        let mut svg = Self(String::new());
        let view = format!("0 0 {} {}", number(width), number(height));
        svg.open("svg", &[("class", &class), ("viewBox", &view), ("aria-hidden", &"true"), ("focusable", &"false")]);
        svg
    }

    pub fn open(&mut self, name: &str, attributes: &[(&str, &dyn Display)]) {
        write!(self.0, "<{name}").expect("strings grow");
        for (key, value) in attributes {
            write!(self.0, " {key}=\"{}\"", escape(&value.to_string())).expect("strings grow");
        }
        self.0.push('>');
    }

    pub fn close(&mut self, name: &str) {
        write!(self.0, "</{name}>").expect("strings grow");
    }

    /// An element that holds nothing.
    pub fn shape(&mut self, name: &str, attributes: &[(&str, &dyn Display)]) {
        self.open(name, attributes);
        self.close(name);
    }

    pub fn element(&mut self, name: &str, attributes: &[(&str, &dyn Display)], text: &str) {
        self.open(name, attributes);
        self.0.push_str(&escape(text));
        self.close(name);
    }

    /// `anchor` is "start", "middle" or "end".
    pub fn text(&mut self, (x, y): (f64, f64), class: &str, anchor: &str, text: &str) {
        let (x, y) = (number(x), number(y));
        self.element("text", &[("x", &x), ("y", &y), ("class", &class), ("text-anchor", &anchor)], text);
    }

    pub fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), class: &str) {
        let path = format!("M{} {}L{} {}", number(x1), number(y1), number(x2), number(y2));
        self.path(&path, class);
    }

    pub fn path(&mut self, d: &str, class: &str) {
        self.shape("path", &[("d", &d), ("class", &class)]);
    }

    pub fn finish(mut self) -> String {
        self.close("svg");
        self.0
    }
}

/// For text and for attributes in double quotes.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// With two decimals at most.
pub(super) fn number(v: f64) -> String {
    let text = format!("{v:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// Cut to `most` characters.
pub(super) fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.into();
    }
    text.chars().take(most - 1).chain(['\u{2026}']).collect()
}

/// Round numbers that span `low..=high`, about `count` of them, and the decimals they need.
pub(super) fn ticks(low: f64, high: f64, count: usize) -> (Vec<f64>, usize) {
    let rough = (high - low).max(1e-9) / count as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= rough * 0.999).unwrap_or(10.0);
    let (first, last) = ((low / step + 1e-6).floor() as i64, (high / step - 1e-6).ceil() as i64);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    ((first..=last).map(|i| i as f64 * step).collect(), decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_attributes_are_escaped() {
        let mut svg = Svg::new("a", "b", (10.0, 5.5), "<script>", "\"&'");
        svg.text((1.0, 2.0), "c\"", "middle", "</text><b>");
        assert_eq!(
            svg.finish(),
            "<svg id=\"a\" class=\"b\" viewBox=\"0 0 10 5.5\" role=\"img\" aria-labelledby=\"a-title a-desc\" \
             style=\"--w:10px\"><title id=\"a-title\">&lt;script&gt;</title><desc id=\"a-desc\">&quot;&amp;&#39;</desc>\
             <text x=\"1\" y=\"2\" class=\"c&quot;\" text-anchor=\"middle\">&lt;/text&gt;&lt;b&gt;</text></svg>"
        );
    }

    #[test]
    fn ticks_are_round_and_span_the_data() {
        assert_eq!(ticks(0.0, 0.62, 5), (vec![0.0, 0.2, 0.4, 0.6000000000000001, 0.8], 1));
        assert_eq!(ticks(0.0, 0.2, 4), (vec![0.0, 0.05, 0.1, 0.15000000000000002, 0.2], 2));
        assert_eq!(ticks(0.0, 9.0, 10), ((0..10).map(f64::from).collect(), 0));
        let (energy, decimals) = ticks(0.87, 1.02, 4);
        assert!(energy[0] <= 0.87 && *energy.last().unwrap() >= 1.02 && energy.contains(&1.0) && decimals == 2);
    }
}
