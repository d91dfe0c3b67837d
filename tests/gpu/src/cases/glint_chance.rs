//! Cases of `glint_chance`. Hashes agree in every bit. Counts are whole numbers and agree where u is not within 2e-6 of a step.

use crate::case::{Bound, Case, SplitMix, Sweep};
use crate::twins::glint_chance as twin;

/// In every bit.
pub const EXACT: Bound = Bound { absolute: 0.0, relative: 0.0 };

/// Vectors that are hashed.
const VECTORS: usize = 100_000;

/// Whole numbers below 2^32.
pub fn words<const N: usize>(a: &[f64]) -> [u32; N] {
    std::array::from_fn(|i| a[i] as u32)
}

/// This many calls.
pub fn draws(count: usize, seed: u64, mut draw: impl FnMut(&mut SplitMix) -> Vec<f64>) -> Vec<Vec<f64>> {
    let mut random = SplitMix(seed);
    (0..count).map(|_| draw(&mut random)).collect()
}

/// A number above 0 with an evenly spread logarithm.
pub fn log(random: &mut SplitMix, low: f64, high: f64) -> f64 {
    (low.ln() + random.unit() * (high / low).ln()).exp()
}

/// A uniform number as hashes give them.
pub fn uniform(random: &mut SplitMix) -> f64 {
    crate::glint::unit((random.bits() >> 32) as u32)
}

/// Whether a count stays the same for numbers that differ by rounding.
fn firm(count: impl Fn(f64, f64) -> f64, mean: f64, u: f64) -> bool {
    let here = count(mean, u);
    let around = [(1.0 - 3e-6, -2e-6), (1.0 + 3e-6, 2e-6), (1.0 - 3e-6, 2e-6), (1.0 + 3e-6, -2e-6)];
    around.iter().all(|(scale, step)| count(mean * scale, (u + step).clamp(1e-9, 1.0 - 1e-9)) == here)
}

/// All of them.
pub fn cases() -> Vec<Case> {
    let word = |sweep: Sweep| sweep.integer(0, u32::MAX).edges(&[1.0, 2_147_483_648.0]);
    let four = |count| word(word(word(word(Sweep::new(count)))));
    let known = [[0.0; 4], [1.0, 2.0, 3.0, 4.0], [4_294_967_295.0, 0.0, 4_294_967_295.0, 911.0]];
    let hashed = known.iter().fold(four(VECTORS), |sweep, call| sweep.and(call)).inputs();
    let mut poisson = draws(4000, 1, |r| vec![log(r, 1e-4, 300.0), uniform(r)]);
    poisson.retain(|a| firm(twin::poisson, a[0], a[1]));
    poisson.extend([vec![0.0, 0.99], vec![-1.0, 0.5]]);
    let mut binomial = draws(6000, 2, |r| {
        let n = if r.unit() < 0.5 { log(r, 0.1, 1e9) } else { log(r, 0.1, 40.0).ceil() };
        vec![n, if r.unit() < 0.5 { r.unit() } else { (log(r, 1e-4, 300.0) / n).min(1.0) }, uniform(r)]
    });
    // The mean near a whole number of trials, and means about the change to the normal distribution, count the same too.
    binomial.retain(|a| firm(|p, u| twin::binomial(a[0], p, u), a[1], a[2]) && a[1] < 1.0 - 1e-5);
    binomial.extend([vec![5.0, 1.0, 0.3], vec![0.0, 0.5, 0.9], vec![7.0, 0.0, 0.9], vec![-2.0, 0.5, 0.9]]);
    vec![
        Case {
            name: "mf_pcg4d",
            inputs: hashed,
            twin: |a| twin::pcg4d(words(a)).map(f64::from).to_vec(),
            bound: EXACT,
        },
        Case {
            name: "mf_unit",
            inputs: word(Sweep::new(2000)).inputs(),
            twin: |a| vec![twin::unit(a[0] as u32)],
            bound: EXACT,
        },
        Case { name: "mf_fifth", inputs: four(2000).inputs(), twin: |a| vec![twin::fifth(words(a))], bound: EXACT },
        Case {
            name: "mf_normal_quantile",
            inputs: {
                let tails = draws(2000, 3, |r| vec![log(r, 1e-16, 0.5)]);
                draws(4000, 4, |r| vec![uniform(r)]).into_iter().chain(tails).collect()
            },
            twin: |a| vec![twin::normal_quantile(a[0])],
            // The logarithm is 5e-7 off near 1, and w to 3 units of its last place.
            bound: Bound { absolute: 5e-7, relative: 2e-6 },
        },
        Case {
            name: "mf_erfc",
            inputs: Sweep::new(2000).linear(-4.0, 9.0).edges(&[0.0, 2.0]).inputs(),
            twin: |a| vec![twin::erfc(a[0])],
            // Exponentials of -81 lose 81 units of the last place.
            bound: Bound { absolute: 3e-7, relative: 1e-5 },
        },
        Case {
            name: "mf_erf",
            inputs: Sweep::new(2000).linear(-5.0, 5.0).edges(&[0.0]).inputs(),
            twin: |a| vec![twin::erf(a[0])],
            bound: Bound { absolute: 5e-7, relative: 0.0 },
        },
        Case {
            name: "mf_ln_one_minus",
            inputs: Sweep::new(2000).log(1e-9, 0.999).edges(&[0.0, 0.03, 0.029_999]).inputs(),
            twin: |a| vec![twin::ln_one_minus(a[0])],
            // 1 - p is rounded by 6e-8, and ln is 0.03.
            bound: Bound { absolute: 1e-15, relative: 4e-6 },
        },
        Case {
            name: "mf_one_minus_exp",
            inputs: Sweep::new(2000).log(1e-9, 90.0).edges(&[0.0, 0.125, 0.124_999]).inputs(),
            twin: |a| vec![twin::one_minus_exp(a[0])],
            bound: Bound { absolute: 1e-15, relative: 2e-6 },
        },
        Case {
            name: "mf_skewed_normal",
            inputs: Sweep::new(1000).linear(0.0, 100.0).linear(0.0, 10.0).linear(-1.0, 1.0).linear(-5.5, 5.5).inputs(),
            twin: |a| vec![twin::skewed_normal(a[0], a[1], a[2], a[3])],
            bound: Bound { absolute: 3e-5, relative: 1e-6 },
        },
        Case { name: "mf_poisson", inputs: poisson, twin: |a| vec![twin::poisson(a[0], a[1])], bound: EXACT },
        Case { name: "mf_binomial", inputs: binomial, twin: |a| vec![twin::binomial(a[0], a[1], a[2])], bound: EXACT },
    ]
}
