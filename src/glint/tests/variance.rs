//! Mean, variance and distribution of the ratio.

use super::{Case, moments, quantile, sample};
use crate::glint::brute::independent_ratio;
use crate::glint::field::{even_variance, layer};
use crate::glint::{EVALUATORS, evaluator};

#[test]
fn even_variance_is_what_is_measured() {
    let mut cases = Vec::new();
    for anisotropy in [1.0, 4.0, 16.0, 64.0] {
        for n_eff in [0.1, 0.3, 1.0, 3.0, 6.0] {
            cases.push((Case { n_eff, area: 0.004, anisotropy, angle: 0.4 }, 4_000));
        }
    }
    for (case, count) in cases {
        let m = moments(count, |n| layer(&case.probe(n, 5), 0, 0.0));
        let (found, error) = (m.variance * case.n_eff, m.variance_error * case.n_eff);
        let fit = even_variance(case.n_eff, case.anisotropy);
        eprintln!(
            "N_eff {:5}, anisotropy {:2}: V* {found:.3} +- {error:.3}, fit {fit:.3}",
            case.n_eff, case.anisotropy
        );
        assert!((found - fit).abs() < 0.025 + 4.0 * error, "{case:?}: {found} +- {error}, fit {fit}");
    }
}

/// Both evaluators over numbers of flakes, phases of the levels of detail, anisotropies and angles.
fn mean_is_one(count: u32) {
    for evaluator in &EVALUATORS[..2] {
        let (mut worst, mut all) = (0.0f64, Vec::new());
        for n_eff in [0.01, 0.1, 1.0, 10.0, 100.0, 3000.0] {
            for anisotropy in [1.0, 4.0, 16.0, 64.0] {
                // Phases and angles take turns, all in the longer sample.
                for turn in 0..if count > 10_000 { 12 } else { 3 } {
                    let phase = 2f64.powf(0.5 * f64::from(turn % 4));
                    let angle = [0.0, 0.6, 1.309][turn as usize % 3];
                    let case = Case { n_eff: n_eff * phase, area: 0.004, anisotropy, angle };
                    let m = moments(count, |n| (evaluator.ratio)(&case.probe(n, 11 + turn)));
                    let limit = (1.0 / (case.n_eff * f64::from(count))).sqrt();
                    let off = (m.mean - 1.0) / (5.0 * limit + 1e-3);
                    worst = worst.max(off.abs());
                    all.push((m.mean - 1.0) / limit);
                    assert!(off.abs() < 1.0, "{}, {case:?}: mean {} with error {limit}", evaluator.name, m.mean);
                }
            }
        }
        // The means as a whole: their average deviation is a normal number of deviation 1 / sqrt(cases).
        let average = all.iter().sum::<f64>() / (all.len() as f64).sqrt();
        eprintln!(
            "{}: {} means, worst {worst:.2} of its limit, together {average:.2} sigma",
            evaluator.name,
            all.len()
        );
        assert!(average.abs() < 5.0, "{}: {average}", evaluator.name);
    }
}

#[test]
fn mean_of_the_ratio_is_one() {
    mean_is_one(1_000);
}

#[test]
#[ignore = "288 cases of 100000: more than four minutes, which .ci/run does not spend"]
fn mean_of_the_ratio_is_one_at_length() {
    mean_is_one(100_000);
}

/// V* within `limit` and 4 standard errors.
fn normalised_variance(name: &str, cases: &[Case], count: u32, limit: f64, variation2: f64) {
    let evaluator = evaluator(name).unwrap();
    for case in cases {
        let m = moments(count, |n| {
            let mut p = case.probe(n, 21);
            p.variation2 = variation2;
            (evaluator.ratio)(&p)
        });
        let scale = case.n_eff / (1.0 + variation2);
        let (found, error) = (m.variance * scale, m.variance_error * scale);
        eprintln!("{name}, {case:?}: mean {:.4} +- {:.4}, V* {found:.3} +- {error:.3}", m.mean, m.mean_error);
        assert!((found - 1.0).abs() < limit + 4.0 * error, "{name}, {case:?}: V* {found} +- {error}");
    }
}

fn cases() -> Vec<Case> {
    let round = [0.1, 0.3, 1.0, 1.5, 2.2, 3.0, 6.0, 10.0, 40.0].map(|n_eff| Case::round(n_eff, 0.004));
    let wide = [0.2, 1.0, 7.0].map(|n_eff| Case::round(n_eff, 0.1));
    let mut cases = [&round[..], &wide[..]].concat();
    for anisotropy in [4.0, 16.0, 64.0] {
        for (n_eff, angle) in [(0.3, 0.0), (1.2, 0.7), (5.0, 1.2)] {
            cases.push(Case { n_eff, area: 0.004, anisotropy, angle });
        }
    }
    cases
}

#[test]
fn field_has_the_variance_of_independent_flakes() {
    normalised_variance("field", &cases(), 4_000, 0.05, 0.0);
}

#[test]
#[ignore = "samples of 200000"]
fn field_has_the_variance_of_independent_flakes_at_length() {
    normalised_variance("field", &cases(), 200_000, 0.05, 0.0);
}

#[test]
fn counts_have_the_variance_of_independent_flakes() {
    normalised_variance("binomial", &cases(), 10_000, 0.02, 0.0);
}

#[test]
#[ignore = "samples of 400000"]
fn counts_have_the_variance_of_independent_flakes_at_length() {
    normalised_variance("binomial", &cases(), 400_000, 0.02, 0.0);
}

#[test]
fn flakes_of_varied_size_vary_more() {
    let cases = [0.3, 1.0, 8.0].map(|n_eff| Case::round(n_eff, 0.004));
    normalised_variance("field", &cases, 10_000, 0.05, 1.0);
    normalised_variance("binomial", &cases, 10_000, 0.02, 1.0);
}

/// Quantiles of 50, 90, 99 and 99.9 percent beside those of a compound Poisson distribution, within these shares of them or
/// a twentieth of the mean, beyond a band of 4 standard errors of the quantiles' ranks. A median close to 0 may be higher by
/// `light` means.
fn quantiles(name: &str, count: u32, limits: [f64; 4], light: f64) {
    let evaluator = evaluator(name).unwrap();
    for n_eff in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0] {
        let case = Case::round(n_eff, 0.004);
        let mut found = sample(count, |n| (evaluator.ratio)(&case.probe(n, 31)));
        let mut truth = sample(4 * count, |n| independent_ratio(n_eff, n, 4));
        for (share, limit) in [0.5, 0.9, 0.99, 0.999].into_iter().zip(limits) {
            // Where sparser nets stand in.
            let limit = if share > 0.995 && n_eff > 1.5 && name == "field" { limit.max(0.25) } else { limit };
            let g = quantile(&mut found, share);
            let spread = 4.0 * (share * (1.0 - share) / f64::from(count)).sqrt() * 1.12;
            let (low, high) = (quantile(&mut truth, share - spread), quantile(&mut truth, (share + spread).min(1.0)));
            eprintln!(
                "{name}, N_eff {n_eff}, {share}: {g:.3}, truth {:.3} ({low:.3} to {high:.3})",
                quantile(&mut truth, share)
            );
            let slack = if share == 0.5 && n_eff < 1.0 { light } else { 0.05 };
            let inside = g > low * (1.0 - limit) - 0.05 && g < high * (1.0 + limit) + slack;
            assert!(inside, "{name}, N_eff {n_eff}: quantile {share} is {g}, not {low} to {high}");
        }
    }
}

/// Evenly filled, fewer pixels are quite dark: a median close to 0 is up to a twentieth of the mean higher.
fn field_quantiles(count: u32) {
    quantiles("field", count, [0.05, 0.05, 0.07, 0.1], 0.05);
}

/// Counts stand for fewer and brighter flakes, and a faint one in the many boxes with little weight lights most pixels: fewer
/// are quite dark, a few are brighter.
fn binomial_quantiles(count: u32) {
    quantiles("binomial", count, [0.07, 0.16, 0.11, 0.24], 0.25);
}

#[test]
fn field_is_distributed_like_independent_flakes() {
    field_quantiles(8_000);
}

#[test]
#[ignore = "samples of 300000"]
fn field_is_distributed_like_independent_flakes_at_length() {
    field_quantiles(300_000);
}

#[test]
fn counts_are_distributed_like_independent_flakes() {
    binomial_quantiles(8_000);
}

#[test]
#[ignore = "samples of 300000"]
fn counts_are_distributed_like_independent_flakes_at_length() {
    binomial_quantiles(300_000);
}
