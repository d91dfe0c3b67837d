//! How many flakes answer: counts of given mean as functions of one uniform number.
//!
//! Inverting the distribution function is exact and monotonic, so that the same uniform number gives nearly the same
//! count when the mean changes a little. The gated normal distributions of the literature are neither: their means are
//! up to 32 percent off where a handful of flakes is expected.

use std::f64::consts::LOG2_E;

use super::gauss::normal_quantile;

/// Counts of at most this mean are exact; above, a normal distribution with the skewness of the count (Cornish & Fisher
/// 1938, first term) stands for it; its mean is exact, its variance 1.2 percent large at most.
pub(super) const EXACT_MEAN: f64 = 12.0;

/// More steps than an exact count can need: the chance to pass them is below 1e-40.
const MOST_STEPS: f64 = 100.0;

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
    for _ in 0..MOST_STEPS as u32 {
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

/// Counts of a mean that change continuously with it and with the uniform number, so that glints fade instead of popping
/// and rounding moves none. Mean m, variance [`SmoothPoisson::VARIANCE`] m.
///
/// Few: in place of each step of a Poisson count, from k to k + 1 where v = 1 - u falls to the chance G of more than k,
/// stands `G / (v ln 2) - 1` between 0 and 1, whose integral is G too: a lone flake fades while m changes by a factor of 2, and
/// its count over m never changes faster than 1 over m does. Many: `(a + b z)^2`, never negative, for a number z that is
/// nearly normal, with `a^2 + b^2 = m` and `4 a^2 b^2 + 2 b^4` for the same variance (roots of counts are nearly normal:
/// Bartlett 1936). Between means of 1/2 and 1 both are mixed.
#[derive(Clone, Copy, Debug)]
pub struct SmoothPoisson {
    mean: f64,
    /// Chances of more than 0, 1 and 2, and of 2.
    more: [f64; 3],
    two: f64,
    normal: [f64; 2],
    many: f64,
}

impl SmoothPoisson {
    /// Variance over the mean, within 0.005: the integral of a flake's form squared. Forms do not overlap below a mean of
    /// 1.18, so that the rest of the variance is a Poisson count's.
    pub const VARIANCE: f64 = 2.0 * LOG2_E - 2.0;

    /// Prepares counts of a mean, which is more than 0 and finite.
    #[inline(always)]
    pub fn new(mean: f64) -> Self {
        let many = (2.0 * mean - 1.0).clamp(0.0, 1.0);
        let none = if many < 1.0 { (-mean).exp() } else { 1.0 };
        let two = 0.5 * mean * mean * none;
        let some = 1.0 - none;
        let more = [some, some - mean * none, some - mean * none - two];
        let a2 = (mean * (mean - 0.5 * Self::VARIANCE)).max(0.0).sqrt();
        Self { mean, more, two, normal: [a2.sqrt(), (0.5 * Self::VARIANCE * mean / (mean + a2)).sqrt()], many }
    }

    /// The count for a uniform u in (0, 1).
    pub fn count(&self, u: f64) -> f64 {
        self.counts_above([1.0 - u])[0]
    }

    /// The largest v that counts.
    #[inline(always)]
    pub(super) fn rim(&self) -> f64 {
        if self.many > 0.0 { 1.0 } else { LOG2_E * self.more[0] }
    }

    /// Counts for v = 1 - u, several at a time: small numbers are many flakes and keep all their digits.
    #[inline(always)]
    pub fn counts_above<const N: usize>(&self, v: [f64; N]) -> [f64; N] {
        let few = if self.many < 1.0 { self.few(v) } else { [0.0; N] };
        if self.many == 0.0 {
            return few;
        }
        std::array::from_fn(|n| {
            let root = self.normal[0] + self.normal[1] * nearly_normal(1.0 - 2.0 * v[n]);
            few[n] + self.many * (root * root - few[n])
        })
    }

    #[inline(always)]
    fn few<const N: usize>(&self, v: [f64; N]) -> [f64; N] {
        let scales = v.map(|v| LOG2_E / v);
        let form = |more: f64, scale: f64| (more * scale - 1.0).clamp(0.0, 1.0);
        let mut counts = scales.map(|s| form(self.more[0], s) + form(self.more[1], s));
        if scales.iter().any(|s| self.more[2] * s > 1.0) {
            for (count, s) in counts.iter_mut().zip(scales) {
                let (mut more, mut chance, mut k) = (self.more[2], self.two, 3.0);
                while more * s > 1.0 && k < MOST_STEPS {
                    *count += form(more, s);
                    chance *= self.mean / k;
                    more -= chance;
                    k += 1.0;
                }
            }
        }
        counts
    }
}

/// A number with the first five moments of a standard normal one, within 1e-4, for a uniform t in (-1, 1): within 0.05 of
/// the normal quantile to 2.5, ending at 2.92. Sums of several do not need the quantile itself.
#[inline(always)]
fn nearly_normal(t: f64) -> f64 {
    let s = t * t;
    t * (1.294_576_2 - 0.965_239_5 * s) / (1.0 - 0.887_154_17 * s)
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
            let off = v / mean / SmoothPoisson::VARIANCE - 1.0;
            assert!(off.abs() < 0.006 + 8.0 * slack / mean, "smooth {mean}: variance off by {off}");
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

    /// In steps of a thousandth of the mean no count moves by more than 0.012 flakes, or 0.012 of the mean: the chance of
    /// more than k grows with the power k + 1 of the mean.
    #[test]
    fn smooth_counts_are_smooth() {
        for u in [0.03, 0.4, 0.77, 0.991, 0.999_9] {
            let mut last = SmoothPoisson::new(1e-3).count(u);
            let mut mean = 1e-3;
            while mean < 100.0 {
                mean *= 1.001;
                let k = SmoothPoisson::new(mean).count(u);
                assert!((k - last).abs() < 0.012 * f64::max(1.0, mean), "mean {mean}, u {u}: {last} to {k}");
                last = k;
            }
        }
    }
}
