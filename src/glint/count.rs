//! How many flakes answer: counts of given mean as functions of one uniform number.
//!
//! Inverting the distribution function is exact and monotonic, so that the same uniform number gives nearly the same
//! count when the mean changes a little. The gated normal distributions of the literature are neither: their means are
//! up to 32 percent off where a handful of flakes is expected.

use super::gauss::normal_quantile;

/// Counts of at most this mean are exact; above, a normal distribution with the skewness of the count (Cornish & Fisher
/// 1938, first term) stands for it, its mean and variance exact before rounding.
pub const EXACT_MEAN: f64 = 12.0;

/// More steps than an exact count can need: the chance to pass them is below 1e-40.
const MOST_STEPS: u32 = 100;

/// `ln(1 - p)` without log1p, which shading languages lack: within 1e-9, relatively, for p from 0 to 1.
///
/// Where `1 - p` would lose the digits of p it is the series; two terms, `-(p + p^2/2)`, are enough for f32 below 0.001.
pub fn ln_one_minus(p: f64) -> f64 {
    if p < 1e-2 { -p * (1.0 + p * (0.5 + p * (1.0 / 3.0 + p * (0.25 + p * 0.2)))) } else { (1.0 - p).ln() }
}

/// A count of `n` trials of chance `p` each, for a uniform u in (0, 1): mean `n p`, variance `n p (1 - p)`.
///
/// n is 0 or more and need not be whole: `ceil(n)` trials of chance `p n / ceil(n)` have the same mean. p is clamped to
/// 0..1. Not a number counts as 0.
pub fn binomial(n: f64, p: f64, u: f64) -> f64 {
    let trials = n.max(0.0).ceil();
    let p = p.clamp(0.0, 1.0) * (n / trials.max(1.0));
    if trials.is_nan() || p.is_nan() || p <= 0.0 || trials < 1.0 {
        return 0.0;
    }
    // Chances above a half by their failures, so that the recursion starts from a number that is not 0.
    if p > 0.5 {
        return trials - at_most_half(trials, 1.0 - p, 1.0 - u);
    }
    at_most_half(trials, p, u)
}

fn at_most_half(trials: f64, p: f64, u: f64) -> f64 {
    let mean = trials * p;
    if mean > EXACT_MEAN {
        let skewed = skewed_normal(mean, (mean * (1.0 - p)).sqrt(), 1.0 - 2.0 * p, normal_quantile(u));
        return (skewed + 0.5).floor().clamp(0.0, trials);
    }
    let odds = p / (1.0 - p);
    invert((trials * ln_one_minus(p)).exp(), u, |k| odds * (trials - k) / (k + 1.0))
}

/// A Poisson count for a uniform u in (0, 1): mean and variance `mean`, 0 or more. Not a number counts as 0.
pub fn poisson(mean: f64, u: f64) -> f64 {
    if mean.is_nan() || mean <= 0.0 {
        return 0.0;
    }
    if mean > EXACT_MEAN {
        return (skewed_normal(mean, mean.sqrt(), 1.0, normal_quantile(u)) + 0.5).floor().max(0.0);
    }
    invert((-mean).exp(), u, |k| mean / (k + 1.0))
}

/// Counts until the probabilities pass u: the first is `none`, `next(k)` is the ratio of that of k + 1 to that of k.
#[inline(always)]
fn invert(none: f64, u: f64, next: impl Fn(f64) -> f64) -> f64 {
    let (mut k, mut probability, mut sum) = (0.0, none, none);
    for _ in 0..MOST_STEPS {
        if u < sum {
            break;
        }
        probability *= next(k);
        // Rounding may keep the sum below u.
        if probability < 1e-30 {
            break;
        }
        sum += probability;
        k += 1.0;
    }
    k
}

/// `skew` is the skewness times the deviation.
fn skewed_normal(mean: f64, deviation: f64, skew: f64, z: f64) -> f64 {
    mean + deviation * z + skew * (z * z - 1.0) / 6.0
}

/// Poisson counts that change continuously with their mean, so that glints fade instead of popping.
///
/// The mean lies between two neighbours of a series, four to an octave; the counts of both, for the same uniform number,
/// are mixed by shares that give the mean exactly, and a known part of the variance is lost. Above [`EXACT_MEAN`] the
/// normal distribution is used unrounded.
#[derive(Clone, Copy, Debug)]
pub struct SmoothPoisson {
    mean: f64,
    low: f64,
    high: f64,
    share: f64,
    none: [f64; 2],
    normal: f64,
}

impl SmoothPoisson {
    /// Neighbouring means in an octave: more would make glints fade faster.
    pub const STEPS: f64 = 4.0;

    /// Prepares counts of a mean, which is more than 0 and finite.
    pub fn new(mean: f64) -> Self {
        let (low, high) = Self::neighbours(mean);
        let normal = Self::normal(mean);
        Self { mean, low, high, share: (mean - low) / (high - low), none: [(-low).exp(), (-high).exp()], normal }
    }

    /// Equal steps between powers of two, which are numbers without their fraction bits: no logarithm, no power.
    fn neighbours(mean: f64) -> (f64, f64) {
        let octave = f64::from_bits(mean.to_bits() & 0xFFF0_0000_0000_0000).max(f64::MIN_POSITIVE);
        let step = f64::from((Self::STEPS * (mean / octave - 1.0)) as u32);
        (octave * (1.0 + step / Self::STEPS), octave * (1.0 + (step + 1.0) / Self::STEPS))
    }

    /// Share of the normal distribution, from three quarters of [`EXACT_MEAN`] to all of it.
    fn normal(mean: f64) -> f64 {
        (mean / EXACT_MEAN - 0.75).clamp(0.0, 0.25) * 4.0
    }

    /// Variance of the counts over their mean: 0.94 to 1, within 0.012. Few flakes are counted by both neighbours or by
    /// one, so that the covariance of the two is the lower mean; many vary together.
    pub fn variance_share(mean: f64) -> f64 {
        let (low, high) = Self::neighbours(mean);
        let t = (mean - low) / (high - low);
        let together = low + ((low * high).sqrt() - low) * mean / (mean + 1.0);
        let mixed = ((1.0 - t) * (1.0 - t) * low + t * t * high + 2.0 * t * (1.0 - t) * together) / mean;
        mixed + Self::normal(mean) * (1.0 - mixed)
    }

    /// The count for a uniform u in (0, 1), whole or between two whole numbers.
    #[inline(always)]
    pub fn count(&self, u: f64) -> f64 {
        // Few flakes: most counts are none.
        if self.normal == 0.0 {
            if u < self.none[1] { 0.0 } else { self.mixed(u) }
        } else {
            let normal = skewed_normal(self.mean, self.mean.sqrt(), 1.0, normal_quantile(u)).max(0.0);
            if self.normal == 1.0 { normal } else { self.mixed(u) + self.normal * (normal - self.mixed(u)) }
        }
    }

    fn mixed(&self, u: f64) -> f64 {
        let of = |mean: f64, none: f64| invert(none, u, |k| mean / (k + 1.0));
        (1.0 - self.share) * of(self.low, self.none[0]) + self.share * of(self.high, self.none[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glint::hash::{pcg4d, unit};

    /// Mean and variance over `count` values of u, one in each interval of equal length.
    fn moments(count: u32, value: impl Fn(f64) -> f64) -> (f64, f64) {
        let (mut sum, mut squares) = (0.0, 0.0);
        let shift = value(0.5);
        for i in 0..count {
            let k = value((f64::from(i) + unit(pcg4d([i, 1, 2, 3])[0])) / f64::from(count)) - shift;
            sum += k;
            squares += k * k;
        }
        let mean = sum / f64::from(count);
        (mean + shift, squares / f64::from(count) - mean * mean)
    }

    /// Over n from 0.1 to 1e9 and means from 1e-3 to 100: the mean within 1e-3, the variance within 1 percent of that of
    /// the trials, with the error that the intervals leave.
    fn binomial_moments(samples: u32) {
        let mut cases = 0;
        for n in [0.1, 0.5, 1.0, 1.5, 2.0, 3.7, 10.0, 100.0, 1e4, 1e6, 1e9] {
            for mean in [1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0, 5.0, 11.0, 20.0, 100.0] {
                let p: f64 = mean / n;
                if p > 1.0 {
                    continue;
                }
                cases += 1;
                let whole = p * n / n.ceil();
                let variance = mean * (1.0 - whole);
                let (m, v) = moments(samples, |u| binomial(n, p, u));
                // Only u's interval where the count steps is random: the steps' number limits the error.
                let slack = 8.0 * (mean.sqrt() + 1.0) / f64::from(samples);
                assert!((m - mean).abs() < 1e-3 * mean + slack, "n {n}, p {p}: mean {m}");
                assert!(
                    (v - variance).abs() < 0.01 * variance + 8.0 * slack,
                    "n {n}, p {p}: variance {v} for {variance}"
                );
            }
        }
        assert_eq!(cases, 76);
    }

    #[test]
    fn binomial_has_its_mean_and_variance() {
        binomial_moments(40_000);
    }

    #[test]
    #[ignore = "the sample of the plan"]
    fn binomial_has_its_mean_and_variance_at_length() {
        binomial_moments(400_000);
    }

    #[test]
    fn poisson_has_its_mean_and_variance_whole_or_smooth() {
        for mean in [
            1e-3, 0.01, 0.1, 0.14, 0.31, 0.56, 1.0, 1.1, 1.7, 2.2, 2.7, 4.5, 8.0, 9.5, 11.0, 11.9, 12.1, 40.0, 1e3, 1e6,
        ] {
            let slack = 8.0 * (f64::sqrt(mean) + 1.0) / 4e4;
            let (m, v) = moments(40_000, |u| poisson(mean, u));
            assert!((m - mean).abs() < 1e-3 * mean + slack, "{mean}: {m}");
            assert!((v / mean - 1.0).abs() < 0.012 + 8.0 * slack / mean, "{mean}: variance {v}");
            let smooth = SmoothPoisson::new(mean);
            let (m, v) = moments(40_000, |u| smooth.count(u));
            assert!((m - mean).abs() < 1e-3 * mean + slack, "smooth {mean}: {m}");
            let expected = SmoothPoisson::variance_share(mean);
            assert!(
                (v / mean - expected).abs() < 0.012 + 8.0 * slack / mean,
                "smooth {mean}: {} for {expected}",
                v / mean
            );
        }
    }

    #[test]
    fn no_digits_are_lost_in_rare_chances() {
        for (n, p) in [(1e7, 1e-7), (1e9, 1e-9), (3e8, 3e-9)] {
            let none = (n * f64::ln_1p(-p)).exp();
            assert_eq!(binomial(n, p, none * (1.0 - 1e-8)), 0.0);
            assert_eq!(binomial(n, p, none * (1.0 + 1e-8)), 1.0);
        }
        for i in 0..1000 {
            let p = 10f64.powf(-9.0 + 0.009 * f64::from(i));
            assert!((ln_one_minus(p) / (-p).ln_1p() - 1.0).abs() < 1e-9, "{p}");
        }
    }

    #[test]
    fn counts_are_whole_monotonic_and_at_most_the_trials() {
        for (n, p) in [(1.0, 0.7), (3.2, 0.9), (20.0, 0.5), (1e3, 0.3), (1e4, 0.9999)] {
            let mut last = 0.0;
            for i in 0..4000 {
                let k = binomial(n, p, (f64::from(i) + 0.5) / 4000.0);
                assert!(k >= last && k.fract() == 0.0 && k <= n.ceil(), "n {n}, p {p}: {k} after {last}");
                last = k;
            }
        }
        assert_eq!(binomial(5.0, 1.0, 0.3), 5.0);
    }

    #[test]
    fn bad_numbers_count_as_none() {
        for (n, p) in [(0.0, 0.5), (-3.0, 0.5), (f64::NAN, 0.5), (5.0, f64::NAN), (5.0, -1.0), (5.0, 0.0)] {
            assert_eq!(binomial(n, p, 0.999), 0.0);
        }
        assert_eq!(poisson(f64::NAN, 0.5), 0.0);
        assert_eq!(poisson(-1.0, 0.5), 0.0);
    }

    /// In steps of a thousandth of the mean no count moves by more than a 50th of a flake for few flakes, or of their
    /// deviation.
    #[test]
    fn smooth_counts_are_smooth() {
        for u in [0.03, 0.4, 0.77, 0.991, 0.999_9] {
            let mut last = SmoothPoisson::new(1e-3).count(u);
            let mut mean = 1e-3;
            while mean < 100.0 {
                mean *= 1.001;
                let k = SmoothPoisson::new(mean).count(u);
                assert!((k - last).abs() < 0.02 * f64::max(1.0, mean.sqrt()), "mean {mean}, u {u}: {last} to {k}");
                last = k;
            }
        }
    }
}
