//! The README's table of folds and their errors, from the sample materials.
//!
//! `BLESS=1 cargo test --test fold_table -- --ignored` writes it again; without `BLESS` it is compared.

mod common;

use std::fs;
use std::path::Path;

use mipfold::compare::{Candidate, Settings, judge};
use mipfold::fold::{DEFAULT_FOLD, FOLDS, Options, chain};
use mipfold::material::base_lobes;
use mipfold::ndf::{Form, lobes_in_words};
use mipfold::roughness::Alpha;
use mipfold::sample::SAMPLES;

const BEGIN: &str = "<!-- errors: written by `BLESS=1 cargo test --test fold_table -- --ignored` -->\n";
const END: &str = "<!-- /errors -->\n";
const ALPHAS: [f32; 4] = [0.05, 0.1, 0.2, 0.4];

/// Largest difference between a figure of the table and one that is measured, over the figure: half of its last digit, and
/// what another machine's library functions change in what a search or a draw finds.
const SAME: f64 = 0.03;

/// Every fold with one width, with two where it has them, and the default with more lobes.
fn rows() -> Vec<(String, Options)> {
    let row = |options: Options| {
        let words = lobes_in_words(options.form, options.lobes, options.shared_normal);
        (format!("`{}`{words}", options.fold.name), options)
    };
    let one = FOLDS.iter().map(|fold| Options { fold, ..Options::default() });
    let two = FOLDS.iter().filter(|fold| fold.has_two_widths());
    let two = two.map(|fold| Options { fold, form: Form::Anisotropic, ..Options::default() });
    let several = [Form::Isotropic, Form::Anisotropic]
        .into_iter()
        .flat_map(|form| [2, 3, 4].map(|lobes| Options { fold: DEFAULT_FOLD, form, lobes, ..Options::default() }));
    let haze = Options { lobes: 2, shared_normal: true, ..Options::default() };
    one.chain(two).chain(several).chain([haze]).map(row).collect()
}

/// Mean lobe error of each row over samples and levels.
fn measure(alpha: f32, rows: &[(String, Options)]) -> Vec<f64> {
    let settings = Settings { texels: Some(16), directions: 40, levels: vec![1, 2, 4, 6], ..Settings::default() };
    let mut means = vec![0.0; rows.len()];
    for sample in SAMPLES {
        let material = common::sample_of_width(sample, 256, Alpha(alpha), 1.0);
        let candidate = |(name, options): &(String, Options)| Candidate {
            name: name.clone(),
            fold: None,
            levels: chain(&material, options).into_lobes(base_lobes(&material, options.form)),
        };
        let chains: Vec<_> = rows.iter().map(candidate).collect();
        let judgement = judge(&material, &chains, &settings, &|_| ()).unwrap();
        for (mean, score) in means.iter_mut().zip(&judgement.chains) {
            let levels = score.levels.iter().map(|level| level.lobe_error.mean);
            *mean += levels.sum::<f64>() / (score.levels.len() * SAMPLES.len()) as f64;
        }
    }
    means
}

#[test]
#[ignore = "minutes; .ci/run does it"]
fn errors_of_the_folds_are_those_of_the_readme() {
    let rows = rows();
    let columns = ALPHAS.map(|alpha| measure(alpha, &rows));
    let figures: Vec<[f64; 4]> = (0..rows.len()).map(|i| columns.each_ref().map(|column| column[i])).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let readme = fs::read_to_string(&path).unwrap();
    let (before, rest) = readme.split_once(BEGIN).expect("the table's first line");
    let (table, after) = rest.split_once(END).expect("the table's last line");
    if std::env::var_os("BLESS").is_some() {
        let head = format!("| fold | alpha {} |\n|---|---|---|---|---|\n", ALPHAS.map(|a| a.to_string()).join(" | "));
        let line = |((name, _), figures): (&(String, Options), &[f64; 4])| {
            format!("| {name} | {} |\n", figures.map(|f| format!("{f:.3}")).join(" | "))
        };
        let lines: String = rows.iter().zip(&figures).map(line).collect();
        fs::write(path, [before, BEGIN, &head, &lines, END, after].concat()).unwrap();
        return;
    }
    let lines: Vec<&str> = table.lines().skip(2).collect();
    assert_eq!(lines.len(), rows.len(), "a row for every fold");
    for ((line, (name, _)), figures) in lines.iter().zip(&rows).zip(&figures) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        assert_eq!(cells[0], name);
        for (cell, figure) in cells[1..].iter().zip(figures) {
            let stated: f64 = cell.parse().unwrap();
            assert!((stated - figure).abs() < 0.0005 + SAME * figure, "{name}: stated {stated}, measured {figure:.4}");
        }
    }
}
