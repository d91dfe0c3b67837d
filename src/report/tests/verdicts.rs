//! What the figures mean.

use super::super::{Matters, UNSEEN};
use super::{Stage, usual};

#[test]
fn verdict_that_folding_matters() {
    let found = usual().verdict();
    assert_eq!((found.matters, found.level), (Matters::Yes, Some(4)));
    assert_eq!(
        found.text,
        "Folding matters here: at level 4 plain mips are 4.1 x further from the truth than 'mine' (lobe error 0.62 \
         against 0.15)."
    );
}

#[test]
fn verdict_that_nothing_is_needed() {
    let found = Stage::new(&[("plain", "average", 0.0312), ("mine", "projected", 0.001)]).verdict();
    assert_eq!(found.matters, Matters::NotNeeded);
    let text = "This material needs nothing: plain mips stay within 0.032 of the truth at every level.";
    assert_eq!(found.text, text);
}

#[test]
fn verdict_counts_standard_errors() {
    let with = |mine: f64, stderr: f64| {
        let mut stage = Stage::new(&[("plain", "average", 0.3), ("mine", "projected", mine)]);
        stage.judgement.chains.iter_mut().for_each(|c| c.levels[4].lobe_error.stderr = stderr);
        stage.verdict()
    };
    // Two combined errors are 2 sqrt(2) 0.02 = 0.057.
    assert_eq!(with(0.24, 0.02).matters, Matters::Yes);
    let same = with(0.25, 0.02);
    assert_eq!(same.matters, Matters::NoHelp);
    assert!(
        same.text.starts_with("Folding does not help here: ") && same.text.contains("equally far"),
        "{}",
        same.text
    );
    let worse = with(0.5, 0.02);
    assert_eq!(worse.matters, Matters::NoHelp);
    assert!(worse.text.contains("further from the truth than plain mips (0.5 against 0.3)"), "{}", worse.text);
    // An error that is not known proves nothing.
    assert_eq!(with(0.1, f64::NAN).matters, Matters::NoHelp);
}

#[test]
fn verdict_without_what_it_needs() {
    let alone = Stage::new(&[("mine", "projected", 0.12)]).verdict();
    assert_eq!((alone.matters, alone.level), (Matters::Unknown, Some(4)));
    assert!(alone.text.starts_with("'mine' stays within 0.12 of the truth, worst at level 4"), "{}", alone.text);
    let two = Stage::new(&[("a", "lean", 0.2), ("b", "projected", 0.1)]).verdict();
    assert!(two.text.starts_with("The closest chain, 'b', stays within 0.1 "), "{}", two.text);
    let plain = Stage::new(&[("plain", "average", 0.4)]).verdict();
    assert!(plain.text.contains("0.4 from the truth at level 4; no other chain"), "{}", plain.text);
    // Level 0 alone decides nothing, and an error that is not a number is not a small one.
    let mut stage = usual();
    stage.judgement.chains.iter_mut().for_each(|c| c.levels.truncate(1));
    assert!(stage.verdict().text.contains("no level below the first"));
    let mut stage = usual();
    stage.judgement.chains[0].levels[2].lobe_error.mean = f64::NAN;
    assert_eq!((stage.verdict().matters, stage.verdict().level), (Matters::Unknown, Some(2)));
    let mut stage = usual();
    stage.judgement.chains[1].levels[4].lobe_error.mean = f64::NAN;
    assert!(stage.verdict().text.contains("'theirs'"));
}

/// The derivation of [`UNSEEN`]: lobe error d for alphas that differ by d.
#[test]
fn unseen_is_a_small_change_of_roughness() {
    let share = |r: f64, alpha: f64| r * r / (r * r + alpha * alpha);
    let differ = (1..4000).map(|i| 0.001 * f64::from(i)).map(|r| share(r, 0.25) - share(r, 0.25 * (1.0 + UNSEEN)));
    let lobe_error = 2.0 * differ.fold(0.0, f64::max);
    assert!((lobe_error / UNSEEN - 1.0).abs() < 0.05, "{lobe_error}");
    let steps = 255.0 * 0.5 * ((1.0 + UNSEEN).sqrt() - 1.0);
    assert!((steps - 3.0).abs() < 0.3, "{steps}");
}
