//! A judged chain as lines of text.

use crate::compare::{ChainScore, LevelScore};

/// A chain's levels, one a line, figures aligned.
pub fn table(chain: &ChainScore) -> String {
    let (widths, words) = (chain.lobes.widths(), chain.lobes_in_words());
    let mut about: Vec<&str> = chain.fold.iter().filter(|fold| **fold != chain.name).map(String::as_str).collect();
    // A fold's own words may say it, or the name.
    let said = |words: &str| about.iter().any(|fold| fold.contains(words));
    if chain.count > 1 && !said("lobes") && !chain.name.contains("lobes") {
        about.push(&words);
    } else if !said(widths) {
        about.push(widths);
    }
    let mut lines = vec![
        format!("\n{} ({})", chain.name, about.join(", ")),
        format!(
            "{:>5}  {:>11}  {:>7}  {:>15}  {:>6}  {:>6}  {:>6}  {:>7}",
            "level", "size", "samples", "lobe error", "p95", "ndf tv", "energy", "diffuse"
        ),
    ];
    lines.extend(chain.levels.iter().map(line));
    lines.join("\n")
}

fn line(level: &LevelScore) -> String {
    let LevelScore { level, width, height, samples, lobe_error, ndf_tv, energy, diffuse_error, .. } = level;
    format!(
        "{level:>5}  {:>11}  {samples:>7}  {:>15}  {:>6.3}  {:>6.3}  {:>6.3}  {:>7.3}",
        format!("{width}x{height}"),
        format!("{:.3} +- {:.3}", lobe_error.mean, lobe_error.stderr),
        lobe_error.p95,
        ndf_tv.mean,
        energy.mean,
        diffuse_error.mean
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::Form;

    #[test]
    fn columns_are_aligned() {
        let level = |level, side| LevelScore { level, width: side, height: side, samples: 64, ..Default::default() };
        let chain = ChainScore {
            name: "mine".into(),
            fold: Some("lean".into()),
            lobes: Form::Isotropic,
            count: 1,
            levels: vec![level(0, 4096), level(12, 1)],
        };
        let text = table(&chain);
        let lines: Vec<&str> = text.trim_start().lines().collect();
        assert_eq!(lines[0], "mine (lean, one width)");
        let end = |line: &str, word: &str| line.find(word).unwrap() + word.len();
        assert_eq!(lines[1].len(), lines[2].len());
        assert_eq!(lines[2].len(), lines[3].len());
        assert_eq!(end(lines[1], "size"), end(lines[2], "4096x4096"));
        assert_eq!(end(lines[1], "size"), end(lines[3], "1x1"));
        let head = |name: &str, fold: Option<&str>, lobes| {
            let chain =
                ChainScore { name: name.into(), fold: fold.map(String::from), lobes, count: 2, ..chain.clone() };
            table(&chain).trim_start().lines().next().unwrap().to_owned()
        };
        assert_eq!(head("out", Some("ggx, 2 lobes"), Form::Isotropic), "out (ggx, 2 lobes, one width)");
        assert_eq!(head("out", Some("ggx, 2 lobes, two widths"), Form::Anisotropic), "out (ggx, 2 lobes, two widths)");
        assert_eq!(head("ggx, 2 lobes", Some("ggx, 2 lobes"), Form::Isotropic), "ggx, 2 lobes (one width)");
        assert_eq!(head("foreign", None, Form::Anisotropic), "foreign (2 lobes, two widths)");
    }
}
