//! What the figures mean, in one sentence.

use serde::Serialize;

use super::Subject;
use crate::compare::{ChainScore, LevelScore};
use crate::reference::Interpolation;

/// Lobe errors up to this are not worth a chain of its own.
///
/// Two GGX lobes whose alphas differ by a small share d have a lobe error of about d: the shares of their normals with
/// slopes below r, `r^2 / (r^2 + alpha^2)`, differ by d/2 at most, and the error counts what is missing and what is in
/// excess. 0.05 is therefore 2.5 percent of perceptual roughness: three steps of an 8-bit map at 0.5, finer than
/// roughness is painted.
pub const UNSEEN: f64 = 0.05;

/// Differences below so many combined standard errors may be chance: 1 in 20 for one comparison of equals.
pub const SIGNIFICANT: f64 = 2.0;

/// Ratios below are called little: they would be written as 1.0, and a tenth of a highlight is not what folding is for.
pub const LITTLE: f64 = 1.1;

/// Ratios above are not written out: the smaller figure is then mostly noise.
const LARGEST_RATIO: f64 = 100.0;

/// Whether folding changes how the material looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Matters {
    /// Plain mips can be seen to be wrong, and a chain is closer to the truth.
    Yes,
    /// A chain is closer to the truth than plain mips, but by a ratio below [`LITTLE`].
    Little,
    /// Plain mips stay within [`UNSEEN`] of the truth at every judged level.
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
    /// The best chain at that level, where plain mips were compared with one.
    pub chain: Option<String>,
    /// Lobe error of plain mips over that of the best chain, at that level.
    pub ratio: Option<f64>,
}

impl Verdict {
    fn unknown(text: impl Into<String>, level: Option<usize>) -> Self {
        Self { matters: Matters::Unknown, text: text.into(), level, chain: None, ratio: None }
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

/// What the figures say about plain mips and the best chain, at the level where plain mips are furthest from the truth
/// among those that another chain has as well. A chain whose level 0 is not the surface is named first.
pub fn verdict(subject: &Subject) -> Verdict {
    if let Some(mesh) = &subject.material.mesh {
        let text = format!(
            "Nothing can be said: the curvature of {} is in these maps, and only the texture was judged.",
            mesh.about.path
        );
        return Verdict::unknown(text, None);
    }
    // Of a chain of another surface no gain can be told.
    not_this_surface(subject).map_or_else(|| of_levels(subject), |warning| Verdict::unknown(warning, Some(0)))
}

/// A chain of this surface is right at level 0, but for rounding; where the surface is what lies between the texels, no
/// chain is.
pub fn not_this_surface(subject: &Subject) -> Option<String> {
    if subject.settings.reading.interpolation != Interpolation::Constant {
        return None;
    }
    let level_0 = |chain: &ChainScore| chain.levels.iter().find(|level| level.level == 0).map(error);
    let found = subject.judgement.chains.iter().filter_map(|chain| Some((&chain.name, level_0(chain)?)));
    let found: Vec<_> = found.filter(|(_, error)| *error > UNSEEN).collect();
    let names = found.iter().map(|(name, error)| format!("'{name}' (lobe error {})", short(*error)));
    let names = names.collect::<Vec<_>>().join(", ");
    (!found.is_empty()).then(|| {
        format!("Level 0 of {names} is not this surface: is it the wrong green direction, a wrong channel or file?")
    })
}

fn of_levels(subject: &Subject) -> Verdict {
    let chains = &subject.judgement.chains;
    if chains.iter().all(|chain| decisive(chain).next().is_none()) {
        return Verdict::unknown("Nothing can be said yet: no level below the first was judged.", None);
    }
    let others: Vec<&ChainScore> =
        chains.iter().enumerate().filter(|(i, _)| Some(*i) != subject.plain).map(|(_, chain)| chain).collect();
    let Some(plain) = subject.plain.and_then(|i| chains.get(i)) else { return without_plain(&others) };
    let Some(furthest) = worst(plain) else {
        return Verdict::unknown("Nothing can be said yet: plain mips were not judged below the first level.", None);
    };
    let (at, far) = (furthest.level, short(error(furthest)));
    if !error(furthest).is_finite() {
        let text = format!("Nothing can be said: the error of plain mips at level {at} is not a number.");
        return Verdict::unknown(text, Some(at));
    }
    if error(furthest) <= UNSEEN {
        let seen = |chain: &&ChainScore| worst(chain).is_some_and(|level| order(error(level)) > UNSEEN);
        let clauses = others.iter().copied().filter(seen).filter_map(|chain| {
            let clause = behind(plain, chain)?;
            Some(clause.replacen("it is", &format!("'{}' is", chain.name), 1))
        });
        let text = format!(
            "This material needs nothing: plain mips stay within {} of the truth at every judged level{}.",
            bound(error(furthest)),
            clauses.map(|clause| format!(", {clause}")).collect::<String>()
        );
        return Verdict { matters: Matters::NotNeeded, text, level: Some(at), chain: None, ratio: None };
    }
    let best_at = |level: usize| {
        let here = others.iter().filter_map(|chain| Some((*chain, decisive(chain).find(|l| l.level == level)?)));
        here.filter(|(_, l)| error(l).is_finite()).min_by(|a, b| error(a.1).total_cmp(&error(b.1)))
    };
    let shared = decisive(plain).filter_map(|level| Some((level, best_at(level.level)?)));
    match shared.max_by(|a, b| error(a.0).total_cmp(&error(b.0))) {
        None => {
            let text = format!("Plain mips are {far} from the truth at level {at}; no other chain was judged there.");
            Verdict::unknown(text, Some(at))
        }
        Some((level, _)) if error(level) <= UNSEEN => {
            let text = format!(
                "Plain mips stay within {} of the truth at the levels that another chain has; at level {at}, which none \
                 has, they are {far} from it.",
                bound(error(level))
            );
            Verdict::unknown(text, Some(at))
        }
        Some((level, (chain, found))) => compared(plain, level, chain, found),
    }
}

/// How much further `b` is from the truth than `a`, if that is more than chance. Where no standard error is known, only
/// a difference with one counts.
fn further(a: &LevelScore, b: &LevelScore) -> Option<f64> {
    let margin = SIGNIFICANT * a.lobe_error.stderr.hypot(b.lobe_error.stderr);
    let difference = error(b) - error(a);
    (margin.is_finite() && difference > margin).then_some(difference)
}

/// The level where a chain is furthest behind plain mips, if it is anywhere.
fn behind(plain: &ChainScore, chain: &ChainScore) -> Option<String> {
    let behind = decisive(plain).filter_map(|p| {
        let c = decisive(chain).find(|level| level.level == p.level)?;
        Some((further(p, c)?, p, c))
    });
    let (_, p, c) = behind.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!("but at level {} it is further: {} against {}", p.level, short(error(c)), short(error(p))))
}

fn compared(plain: &ChainScore, level: &LevelScore, best: &ChainScore, found: &LevelScore) -> Verdict {
    let (k, name) = (level.level, &best.name);
    let ratio = Some(error(level) / error(found)).filter(|ratio| ratio.is_finite());
    let figures = format!("lobe error {} against {}", short(error(level)), short(error(found)));
    // Of a chain that somebody else made nobody knows whether it was folded.
    let who = if best.fold.is_some() { "Folding".to_owned() } else { format!("'{name}'") };
    let what = if best.fold.is_some() { "folding".to_owned() } else { format!("'{name}'") };
    let (matters, mut text) = if further(found, level).is_some() && ratio.is_some_and(|ratio| ratio < LITTLE) {
        let text = format!(
            "{who} helps little here: at level {k} '{name}' is nearly as far from the truth as plain mips ({} against {})",
            short(error(found)),
            short(error(level))
        );
        (Matters::Little, text)
    } else if further(found, level).is_some() {
        let times = match ratio {
            Some(ratio) if ratio <= LARGEST_RATIO => format!("{ratio:.1}"),
            _ => format!("more than {LARGEST_RATIO:.0}"),
        };
        let gain = if best.fold.is_some() { "Folding matters here".into() } else { format!("{who} is closer here") };
        let than = if best.fold.is_some() { format!("'{name}'") } else { "it is".into() };
        let text =
            format!("{gain}: at level {k} plain mips are {times} x further from the truth than {than} ({figures})");
        (Matters::Yes, text)
    } else if further(level, found).is_some() {
        let text = format!(
            "{who} does not help here: at level {k} the best chain, '{name}', is further from the truth than plain mips \
             ({} against {})",
            short(error(found)),
            short(error(level))
        );
        (Matters::NoHelp, text)
    } else {
        let text = format!(
            "It cannot be told whether {what} helps here: at level {k} plain mips and the best chain, '{name}', are equal \
             within the error of the measurement ({figures}); more texels would tell"
        );
        (Matters::Unknown, text)
    };
    if let Some(clause) = behind(plain, best).filter(|_| matters == Matters::Yes) {
        text = format!("{text}, {clause}");
    }
    Verdict { matters, text: text + ".", level: Some(k), chain: Some(name.clone()), ratio }
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
    let who = if worst.len() == 1 { format!("'{name}' is") } else { format!("The closest chain, '{name}', is") };
    let text = format!(
        "{who} {} from the truth at level {k}, its worst (0 is the truth, 2 nothing in common); there are no plain mips \
         to compare with.",
        short(error(level))
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
