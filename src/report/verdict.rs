//! What the figures mean, in one sentence.

use serde::Serialize;

use super::Subject;
use crate::compare::{ChainScore, LevelScore};

/// Lobe errors up to this are not worth a chain of its own.
///
/// Two GGX lobes whose alphas differ by a small share d have a lobe error of about d: the shares of their normals with
/// slopes below r, `r^2 / (r^2 + alpha^2)`, differ by d/2 at most, and the error counts what is missing and what is in
/// excess. 0.05 is therefore 2.5 percent of perceptual roughness: three steps of an 8-bit map at 0.5, finer than
/// roughness is painted.
pub const UNSEEN: f64 = 0.05;

/// Differences below so many combined standard errors may be chance: 1 in 20 for one comparison of equals.
pub const SIGNIFICANT: f64 = 2.0;

/// Ratios above are not written out: the smaller figure is then mostly noise.
const LARGEST_RATIO: f64 = 100.0;

/// Whether folding changes how the material looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Matters {
    /// Plain mips can be seen to be wrong, and a chain is closer to the truth.
    Yes,
    /// Plain mips stay within [`UNSEEN`] of the truth.
    NotNeeded,
    /// Plain mips can be seen to be wrong, but no chain is closer beyond the error of the measurement.
    NoHelp,
    /// There is nothing to compare: no plain mips, only plain mips, or no figures.
    Unknown,
}

/// The findings in one sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The answer.
    pub matters: Matters,
    /// The sentence, in an artist's language.
    pub text: String,
    /// The level that decided, if one did; never 0, which every chain shares.
    pub level: Option<usize>,
    /// Lobe error of plain mips over that of the best chain, at that level.
    pub ratio: Option<f64>,
}

impl Verdict {
    fn unknown(text: impl Into<String>, level: Option<usize>) -> Self {
        Self { matters: Matters::Unknown, text: text.into(), level, ratio: None }
    }
}

/// The levels that a verdict rests on: all but the first, which is the input itself.
pub(super) fn decisive(chain: &ChainScore) -> impl Iterator<Item = &LevelScore> {
    chain.levels.iter().filter(|level| level.level > 0)
}

/// The decisive level with the largest lobe error; one that is not a number is the largest.
pub(super) fn worst(chain: &ChainScore) -> Option<&LevelScore> {
    decisive(chain).max_by(|a, b| order(error(a)).total_cmp(&order(error(b))))
}

fn error(level: &LevelScore) -> f64 {
    level.lobe_error.mean
}

/// A key that puts what is not a number last.
fn order(error: f64) -> f64 {
    if error.is_nan() { f64::INFINITY } else { error }
}

/// What the figures say about plain mips and the best chain, at the level where plain mips are furthest from the truth.
pub fn verdict(subject: &Subject) -> Verdict {
    let chains = &subject.judgement.chains;
    if chains.iter().all(|chain| decisive(chain).next().is_none()) {
        return Verdict::unknown("Nothing can be said yet: no level below the first was judged.", None);
    }
    let others: Vec<&ChainScore> =
        chains.iter().enumerate().filter(|(i, _)| Some(*i) != subject.plain).map(|(_, chain)| chain).collect();
    let Some(plain) = subject.plain.and_then(|i| chains.get(i)) else { return without_plain(&others) };
    let Some(worst) = worst(plain) else {
        return Verdict::unknown("Nothing can be said yet: plain mips were not judged below the first level.", None);
    };
    let at = Some(worst.level);
    if !error(worst).is_finite() {
        let text = format!("Nothing can be said: the error of plain mips at level {} is not a number.", worst.level);
        return Verdict::unknown(text, at);
    }
    if error(worst) <= UNSEEN {
        let text = format!(
            "This material needs nothing: plain mips stay within {} of the truth at every level.",
            bound(error(worst))
        );
        return Verdict { matters: Matters::NotNeeded, text, level: at, ratio: None };
    }
    let here = |chain: &'_ ChainScore| decisive(chain).find(|l| l.level == worst.level).map(|l| l.lobe_error);
    let best = others.iter().filter_map(|chain| Some((chain, here(chain)?)));
    let best = best.filter(|(_, e)| e.mean.is_finite()).min_by(|a, b| a.1.mean.total_cmp(&b.1.mean));
    match best {
        Some((chain, found)) => compared(worst, chain, found.mean, found.stderr),
        None => Verdict::unknown(
            format!(
                "Plain mips are {} from the truth at level {}; no other chain was judged there.",
                short(error(worst)),
                worst.level
            ),
            at,
        ),
    }
}

fn compared(plain: &LevelScore, best: &ChainScore, error: f64, stderr: f64) -> Verdict {
    let (p, k, name) = (plain.lobe_error.mean, plain.level, &best.name);
    let margin = SIGNIFICANT * plain.lobe_error.stderr.hypot(stderr);
    let ratio = Some(p / error).filter(|ratio| ratio.is_finite());
    let figures = format!("lobe error {} against {}", short(p), short(error));
    // Without standard errors the margin is 0 or not a number: then only a real difference counts.
    let margin = if margin.is_finite() { margin } else { f64::INFINITY };
    let (matters, text) = if p - error > margin {
        let times = match ratio {
            Some(ratio) if ratio <= LARGEST_RATIO => format!("{ratio:.1}"),
            _ => format!("more than {LARGEST_RATIO:.0}"),
        };
        let text = format!(
            "Folding matters here: at level {k} plain mips are {times} x further from the truth than '{name}' ({figures})."
        );
        (Matters::Yes, text)
    } else if error - p > margin {
        let text = format!(
            "Folding does not help here: at level {k} the best chain, '{name}', is further from the truth than plain mips ({} against {}).",
            short(error),
            short(p)
        );
        (Matters::NoHelp, text)
    } else {
        let text = format!(
            "Folding does not help here: at level {k} plain mips and the best chain, '{name}', are equally far from the truth ({figures})."
        );
        (Matters::NoHelp, text)
    };
    Verdict { matters, text, level: Some(k), ratio }
}

/// Without plain mips there is no telling what a fold gains; what can be told is how close the chains are.
fn without_plain(chains: &[&ChainScore]) -> Verdict {
    let mut worst: Vec<_> = chains.iter().filter_map(|chain| Some((&chain.name, worst(chain)?))).collect();
    worst.sort_by(|a, b| order(error(a.1)).total_cmp(&order(error(b.1))));
    let (name, level) = worst[0];
    let k = level.level;
    if !error(level).is_finite() {
        return Verdict::unknown(
            format!("Nothing can be said: the error of '{name}' at level {k} is not a number."),
            Some(k),
        );
    }
    let who = if worst.len() == 1 { format!("'{name}' stays") } else { format!("The closest chain, '{name}', stays") };
    let text = format!(
        "{who} within {} of the truth, worst at level {k}; there are no plain mips to compare with.",
        bound(error(level))
    );
    Verdict::unknown(text, Some(k))
}

/// Two decimals, or three for small figures.
pub(super) fn short(v: f64) -> String {
    if v.is_nan() {
        return "n/a".into();
    }
    let text = if v.abs() < 0.0995 { format!("{v:.3}") } else { format!("{v:.2}") };
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".into() } else { text.into() }
}

/// As [`short`], rounded up: "within" has to hold.
fn bound(v: f64) -> String {
    short((v * 1000.0 - 1e-6).ceil().max(0.0) / 1000.0)
}
