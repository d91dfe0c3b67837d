//! What the figures mean.

use super::super::{Matters, UNSEEN};
use super::{Stage, usual};
use crate::image::Wrap;
use crate::material::{MeshAbout, MeshUnder};
use crate::reference::Interpolation;

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
    let text = "This material needs nothing: plain mips stay within 0.032 of the truth at every judged level.";
    assert_eq!(found.text, text);
}

#[test]
fn nothing_is_said_of_a_mesh_that_was_not_judged() {
    let mut stage = usual();
    let about = MeshAbout { path: "pipe.glb".into(), sha256: String::new(), uv_set: 0, padding: 8, triangles: 12 };
    stage.material.mesh = Some(MeshUnder { about, added: Vec::new() });
    let found = stage.verdict();
    assert!(found.matters == Matters::Unknown && found.text.contains("curvature of pipe.glb"), "{}", found.text);
}

#[test]
fn verdict_names_a_chain_that_spoils_what_needs_nothing() {
    let found = Stage::new(&[("plain", "average", 0.02), ("mine", "projected", 0.5)]).verdict();
    assert_eq!(found.matters, Matters::NotNeeded);
    assert!(
        found.text.contains("at every judged level, but at level ") && found.text.contains("'mine' is further: "),
        "{}",
        found.text
    );
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
    assert_eq!(same.matters, Matters::Unknown);
    assert!(same.text.starts_with("It cannot be told whether folding helps here: at level 4 "), "{}", same.text);
    let worse = with(0.5, 0.02);
    assert_eq!(worse.matters, Matters::NoHelp);
    assert!(worse.text.contains("further from the truth than plain mips (0.5 against 0.3)"), "{}", worse.text);
    let little = with(0.28, 0.001);
    assert_eq!(little.matters, Matters::Little);
    assert_eq!(
        little.text,
        "Folding helps little here: at level 4 'mine' is nearly as far from the truth as plain mips (0.28 against 0.3)."
    );
    // An error that is not known proves nothing.
    assert_eq!(with(0.1, f64::NAN).matters, Matters::Unknown);
}

#[test]
fn verdict_without_what_it_needs() {
    let alone = Stage::new(&[("mine", "projected", 0.12)]).verdict();
    assert_eq!((alone.matters, alone.level), (Matters::Unknown, Some(4)));
    assert!(
        alone.text.starts_with("'mine' is 0.12 from the truth at level 4, its worst (0 is the truth"),
        "{}",
        alone.text
    );
    let two = Stage::new(&[("a", "lean", 0.2), ("b", "projected", 0.1)]).verdict();
    assert!(two.text.starts_with("The closest chain, 'b', is 0.1 from the truth"), "{}", two.text);
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

/// Plain mips are worst where no other chain goes.
#[test]
fn verdict_rests_on_levels_that_both_have() {
    let mut stage = usual();
    stage.judgement.chains[1..].iter_mut().for_each(|c| c.levels.truncate(3));
    let found = stage.verdict();
    assert_eq!((found.matters, found.level, found.chain.as_deref()), (Matters::Yes, Some(2), Some("mine")));
    stage.judgement.chains[0].levels[1].lobe_error.mean = 0.01;
    stage.judgement.chains[0].levels[2].lobe_error.mean = 0.02;
    let found = stage.verdict();
    assert_eq!(found.matters, Matters::Unknown);
    assert!(found.text.contains("within 0.02") && found.text.contains("level 4, which none has"), "{}", found.text);
}

#[test]
fn verdict_tells_where_the_chain_is_further() {
    let mut stage = usual();
    stage.judgement.chains[0].levels[6].lobe_error.mean = 0.1;
    stage.judgement.chains[1].levels[6].lobe_error.mean = 0.3;
    let found = stage.verdict();
    assert_eq!(found.matters, Matters::Yes);
    assert!(found.text.ends_with(", but at level 6 it is further: 0.3 against 0.1."), "{}", found.text);
    // By less than the error, nothing is said.
    stage.judgement.chains[1].levels[6].lobe_error.stderr = 0.2;
    assert!(!stage.verdict().text.contains("but at"));
}

#[test]
fn verdict_does_not_call_foreign_chains_folds() {
    let mut stage = usual();
    stage.judgement.chains[1].fold = None;
    let text = stage.verdict().text;
    let expected = "'mine' is closer here: at level 4 plain mips are 4.1 x further from the truth than it is (lobe error \
                    0.62 against 0.15).";
    assert_eq!(text, expected);
    assert!(stage.page().contains(">Closer<"));
    stage.judgement.chains[1].levels[4].lobe_error.mean = 0.7;
    stage.judgement.chains[2].levels[4].lobe_error.mean = 0.9;
    assert!(stage.verdict().text.starts_with("'mine' does not help here: "), "{}", stage.verdict().text);
}

#[test]
fn verdict_warns_of_another_surface() {
    let mut stage = usual();
    assert!(!stage.page().contains(">Level 0<"));
    stage.judgement.chains[2].levels[0].lobe_error.mean = 0.41;
    let found = stage.verdict();
    assert!(found.text.starts_with("Level 0 of 'theirs' (lobe error 0.41) is not this surface"), "{}", found.text);
    // Of another surface no gain can be told.
    assert_eq!((found.matters, found.level), (Matters::Unknown, Some(0)));
    let html = stage.page();
    assert!(html.contains(">Level 0<") && html.contains("<td class=\"num\">0.41</td>"));
    assert!(!html.contains("The first level is the input itself"));
    // What lies between the texels is no error of a chain's level 0.
    stage.settings.reading.interpolation = Interpolation::Bilinear { per_side: 4, wrap: Wrap::Repeat };
    assert!(stage.verdict().text.starts_with("Folding"));
    stage.settings.reading.interpolation = Interpolation::Constant;
    // Rounding is no other surface.
    stage.judgement.chains[2].levels[0].lobe_error.mean = 0.02;
    assert!(stage.verdict().text.starts_with("Folding"));
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
