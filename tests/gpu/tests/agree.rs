//! Every function of the shader helpers, in every language, against its twin in f64.
//!
//! `MIPFOLD_ONLY=ndf` runs one file, `MIPFOLD_ONLY=mf_d_ggx` one function. Where there is no Vulkan adapter the tests say
//! so and pass, unless `MIPFOLD_NO_SKIP` is set.

use std::fs;
use std::path::Path;

use mipfold_gpu_tests::case::{Bound, Case, Sweep};
use mipfold_gpu_tests::gpu::{Gpu, gpu, has_glslang, say, skipped};
use mipfold_gpu_tests::source::{bundle, is_screen, subjects};
use mipfold_gpu_tests::translate::Language;
use mipfold_gpu_tests::{cases, harness};

/// The file or function that `MIPFOLD_ONLY` names.
fn only() -> Option<String> {
    std::env::var("MIPFOLD_ONLY").ok()
}

/// The device, and the languages that can be compiled.
fn able() -> Option<(&'static Gpu, &'static [Language])> {
    let Some(gpu) = gpu() else {
        skipped("no Vulkan adapter");
        return None;
    };
    if has_glslang() {
        return Some((gpu, &Language::ALL));
    }
    skipped("no glslangValidator: WGSL alone is run");
    Some((gpu, &[Language::Wgsl]))
}

#[test]
fn shaders_agree_with_their_twins() {
    let Some((gpu, languages)) = able() else { return };
    let (mut rows, mut wrong) = (Vec::new(), String::new());
    for (subject, mut cases) in cases::all() {
        if let Some(only) = only().filter(|only| only != subject) {
            cases.retain(|case| case.name == only);
        }
        if cases.is_empty() {
            continue;
        }
        match harness::run(gpu, subject, cases, languages) {
            Ok(more) => rows.extend(more),
            Err(error) => wrong += &(error + "\n"),
        }
    }
    wrong.extend(rows.iter().map(harness::Row::failures));
    say(&format!("\nWorst error as a share of its bound, on {}\n{}\n{wrong}", gpu.name, harness::table(&rows)));
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Twins are found by their text: `pub fn d_ggx(` in `twins/ndf.rs` or a file of the folder `twins/ndf`.
#[test]
fn every_function_has_a_case_and_a_twin() {
    let twins = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src/kernels/twins");
    let all = cases::all();
    let mut missing = String::new();
    for subject in subjects() {
        if only().is_some_and(|only| only != subject) {
            continue;
        }
        let bundle = match bundle(&subject, Language::Wgsl) {
            Ok(bundle) => bundle,
            Err(error) => {
                missing += &format!("{error}\n");
                continue;
            }
        };
        let mut text = fs::read_to_string(twins.join(format!("{subject}.rs"))).unwrap_or_default();
        for file in fs::read_dir(twins.join(&subject)).into_iter().flatten() {
            text += &fs::read_to_string(file.expect("an entry").path()).expect("a twin's text");
        }
        let cases = all.iter().filter(|(name, _)| *name == subject).flat_map(|(_, cases)| cases);
        let names: Vec<&str> = cases.map(|case| case.name).collect();
        for function in bundle.functions {
            if !names.contains(&function.as_str()) {
                missing += &format!("{subject}: no case for {function}\n");
            }
            let twin = format!("pub fn {}(", function.trim_start_matches("mf_"));
            if !is_screen(&subject) && !text.contains(&twin) {
                missing += &format!("{subject}: no twin for {function}\n");
            }
        }
    }
    assert!(missing.is_empty(), "\n{missing}");
}

/// A twin that is wrong by a thousandth, and one that is finite where the shader is not.
#[test]
fn wrong_twins_are_caught() {
    let Some((gpu, languages)) = able() else { return };
    let bound = Bound { absolute: 1e-7, relative: 1e-5 };
    let case = |twin, inputs| Case { name: "mf_alpha_from_perceptual", inputs, twin, bound };
    let inputs = Sweep::new(100).linear(0.1, 1.0).inputs();
    let cases = vec![
        case(|a| vec![a[0] * a[0]], inputs.clone()),
        case(|a| vec![a[0] * a[0] * 1.001], inputs.clone()),
        case(|a| vec![a[0]], vec![vec![f64::NAN], vec![1.0]]),
    ];
    let rows = harness::run(gpu, "roughness", cases, languages).expect("runs");
    let caught: Vec<usize> = rows.iter().map(|row| row.failures().lines().count()).collect();
    assert_eq!(caught, [0, languages.len(), 0], "the right one passes, NaN agrees with NaN");
    let cases = vec![case(|_| vec![1.0], vec![vec![f64::NAN], vec![1.0]])];
    let rows = harness::run(gpu, "roughness", cases, languages).expect("runs");
    assert!(rows[0].failures().contains("not finite") && rows[0].failures().contains("NaN"));
    let missing = Case { name: "mf_no_such", inputs: vec![], twin: |_| vec![], bound };
    assert!(harness::run(gpu, "roughness", vec![missing], languages).is_err());
}
