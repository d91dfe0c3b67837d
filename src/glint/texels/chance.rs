//! Sums over many texels, most of them by an estimate.
//!
//! What stands for a part of the map, a block's moments or a few points in a cell, is off by an amount of known size e
//! (`texels/errors`: root mean square, measured). Of many parts only some are looked into, each with the probability
//! `p = min(1, e / tau)`, and what it was off by counts `1 / p` times: a control variate under Russian roulette. So the
//! expected sum is the exact one, with a variance of `sum of e tau (1 - p)` at a cost of `sum of e / tau`, which is the
//! least for that variance. One tolerance tau serves all levels of the quadtree and the pieces of cells; tau = 0 is
//! the exact sum.
//!
//! The dice are hashes of the parts alone: from one half vector or frame to the next the same parts are looked into, but
//! for those whose p crosses their die, and these change the sum by about tau.

use super::query::Query;
use super::ways::Visits;

/// Standard deviation of a sum, over the sum.
pub(super) const SPREAD: f64 = 4.5e-3;
/// Tolerance of the first look, over a rough guess of the sum.
const FIRST: f64 = 0.02;
/// Width of the pixel, in texels, below which every texel is looked into.
const EXACT: f64 = 5.0;
/// Looks after the first.
const LOOKS: usize = 4;

/// A uniform number in 0..1 (SplitMix64's finaliser).
#[inline]
fn unit(key: u64) -> f64 {
    let z = (key ^ (key >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Another key from a key and an integer.
#[inline]
pub(super) fn key(of: u64, part: u64) -> u64 {
    (of ^ part.wrapping_mul(0xD1B5_4A32_D192_ED03)).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31)
}

/// How coarse a query may be, and how coarse it was.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Chance {
    /// Error of a part, in the units of the sum, above which it is looked into for certain.
    pub(super) tau: f64,
    /// Of the sum, as expected.
    pub(super) variance: f64,
    /// What the sum may be.
    pub(super) guess: f64,
}

impl Query<'_> {
    /// D(h), and what was visited.
    pub(super) fn evaluate(mut self) -> (f64, Visits) {
        if self.footprint.width().0 < EXACT {
            let sum = self.sum();
            return (sum, self.visits);
        }
        self.spread(SPREAD)
    }

    /// The same with this standard deviation, over the sum.
    pub(super) fn spread(mut self, spread: f64) -> (f64, Visits) {
        // Estimates alone.
        self.chance.tau = f64::INFINITY;
        let guess = self.sum();
        self.chance = Chance { tau: FIRST * guess, variance: 0.0, guess };
        let mut sum = self.sum();
        for _ in 0..LOOKS {
            // A first look may be far off: as far as the guess.
            let share = guess * guess / (guess * guess + 4.0 * self.chance.variance);
            let about = share * sum + (1.0 - share) * guess;
            let allowed = (spread * about).powi(2);
            if self.chance.variance <= 1.3 * allowed {
                break;
            }
            // The variance goes with tau, if not quite.
            self.chance.tau *= (0.9 * allowed / self.chance.variance).max(0.01);
            self.chance.variance = 0.0;
            sum = self.sum();
        }
        (sum, self.visits)
    }

    /// The sum of a part for which `estimate` stands, off by about `error`; `weight` is 1 over the probability that led
    /// here.
    #[inline]
    pub(super) fn settle(
        &mut self,
        error: f64,
        (key, weight): (u64, f64),
        estimate: impl FnOnce(&mut Self) -> f64,
        exact: impl FnOnce(&mut Self, f64) -> f64,
    ) -> f64 {
        let Chance { tau, .. } = self.chance;
        let expected = weight * error;
        // Not a number neither.
        if expected.is_nan() || expected >= tau {
            return exact(self, weight);
        }
        let p = expected / tau;
        self.chance.variance += expected * tau * (1.0 - p);
        let estimate = estimate(self);
        if unit(key) >= p { estimate } else { estimate + (exact(self, weight / p) - estimate) / p }
    }
}
