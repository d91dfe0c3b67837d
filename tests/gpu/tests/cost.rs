//! `kernels/COST.md` says what each helper costs beside a plain GGX evaluation, as counted in its text.
//!
//! `BLESS=1` writes the file anew.

use std::fs;

use mipfold_gpu_tests::cost::{Cost, SPECIAL, costs};
use mipfold_gpu_tests::source::{bundle, kernels, subjects};
use mipfold_gpu_tests::translate::Language;

/// What a light costs in most engines: D, V and F of one width.
const PLAIN: &str = "mf_specular_ggx";

fn table() -> String {
    let mut text = format!(
        "# What the shader helpers cost\n\n\
         Operations in the text of each function and of all that it calls, by `tests/gpu/tests/cost.rs`: both sides of every \
         branch, before any\ncompiler has removed what is not needed; loops as often as a comment in the text says they turn. *Special* are divisions, roots, powers, exponentials, \
         logarithms and angles, weighed as\n{SPECIAL} plain operations, their rate on much graphics hardware. The last column is \
         the weighed sum over that of `{PLAIN}`,\na plain GGX evaluation of one light (D, V and F). **Times on graphics hardware \
         are unmeasured.**\n"
    );
    let of = |subject: &str| bundle(subject, Language::Wgsl).unwrap_or_else(|e| panic!("{e}"));
    let unit = costs(&of("shading").text)[PLAIN].weight();
    for subject in subjects() {
        let bundle = of(&subject);
        let costs = costs(&bundle.text);
        text += &format!("\n## {subject}\n\n| function | plain | special | over a plain GGX |\n|---|---|---|---|\n");
        for name in &bundle.functions {
            let cost = costs[name];
            let over = f64::from(cost.weight()) / f64::from(unit);
            text += &format!("| `{name}` | {} | {} | {over:.2} |\n", cost.plain, cost.special);
        }
    }
    text
}

#[test]
fn the_costs_are_those_of_the_file() {
    let path = kernels().join("COST.md");
    let table = table();
    if std::env::var_os("BLESS").is_some() {
        fs::write(&path, &table).expect("the file");
    }
    let there = fs::read_to_string(&path).unwrap_or_default();
    assert!(there == table, "kernels/COST.md is not up to date: run this test with BLESS=1");
}

#[test]
#[should_panic(expected = "turns: ")]
fn a_loop_without_its_turns_is_refused() {
    costs("fn a() -> f32 { var s: f32 = 0.0;\nfor (var i: u32 = 0u; i < 3u; i = i + 1u) { s = s + 1.0; }\nreturn s; }");
}

#[test]
fn counts_worked_by_hand() {
    let text = "fn a(x: f32) -> f32 { return x * x + 1.0; }
        fn b(v: vec3f) -> vec3f { if (v.x > 0.0) { return normalize(v) * a(v.y); } return -v / sqrt(v.z); }
        fn c(x: f32) -> f32 { var s: f32 = 0.0;
        for (var i: u32 = 0u; i < 3u; i = i + 1u) { // turns: 3
            s = s + a(x);
        } return s; }";
    let costs = costs(text);
    assert_eq!(costs["a"], Cost { plain: 2, special: 0 });
    // A comparison; 8 and a root for the unit vector; a call; a vector times a number; a division of three, and a root.
    assert_eq!(costs["b"], Cost { plain: 1 + 8 + 2 + 3 + 3, special: 1 + 3 + 1 });
    // Each turn: the comparison and the step of i, the sum, and the call.
    assert_eq!(costs["c"], Cost { plain: 3 * (1 + 1 + 1 + 2), special: 0 });
}
