//! Sums over many texels, most of them by an estimate.
//!
//! What stands for a part of the map, a block's moments or a few points in a cell, is off by an amount of known size e
//! (`texels/errors`: root mean square, measured). Of many parts only some are looked into, each with the probability
//! `p = min(1, e / tau)`, and what it was off by counts `1 / p` times: a control variate under Russian roulette. So for a
//! given tolerance tau the expected sum is the exact one, whatever e is, with a variance of `sum of e tau (1 - p)` if e is
//! right, at a cost of `sum of e / tau`, which is the least for that variance. One tolerance serves all levels of the
//! quadtree and the pieces of cells; tau = 0 is the exact sum.
//!
//! The tolerance is not given but chosen, by sums with the same dice as the one that is returned: where those happen to
//! be high, a larger tolerance is taken, or an earlier stop. The mean is then no longer that of the exact sum by
//! construction; a shift was not seen among the dice of the tests (`tests/spread.rs`: within four deviations of a mean of
//! 192 answers). Nor is the deviation kept: up to 1.3 times the variance asked for is accepted, after four more looks any,
//! and the variance itself is an estimate by e.
//!
//! The dice are hashes of the parts alone: from one half vector or frame to the next the same parts are looked into, but
//! for those whose p crosses their die, and these change the sum by about tau.

use glam::DVec2;

use super::query::Query;
use super::ways::Visits;
use crate::glint::hash::{pcg4d, unit};

/// Standard deviation of a sum that is asked for, over the sum.
pub(super) const SPREAD: f64 = 4.5e-3;
/// Tolerance of the first look, over a rough guess of the sum.
const FIRST: f64 = 0.02;
/// Width of the pixel, in texels, below which every texel is looked into.
const EXACT: f64 = 5.0;
/// Most looks after the first. The last is taken as it is.
const LOOKS: usize = 4;
/// Variance that is accepted, over the one asked for. Another look costs a whole sum.
const ENOUGH: f64 = 1.3;

/// Which die: of a block or of a piece of a cell, by its place on the map. Maps repeat, and so do their dice: a pixel
/// that moves across an edge of the map meets those that it knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Die {
    /// Of the block of a level that has this cell, (x, y), at its upper left.
    Block([u32; 2], u32),
    /// Of a piece of this cell.
    Piece([u32; 2], Path),
}

impl Die {
    /// Four words, no two dice the same.
    pub(super) fn words(self, salt: u32) -> [u32; 4] {
        match self {
            Self::Block([x, y], level) => [x, y, level, salt << 1],
            Self::Piece([x, y], Path(path)) => [x, y, path, salt << 1 | 1],
        }
    }
}

/// The way from a cell to one of its pieces, and one of the three dice there: from the lowest bits, two for the die, two
/// for each quarter, and a 1 above them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Path(u32);

impl Path {
    /// The whole cell.
    pub(super) const CELL: Self = Self(1 << 2);

    /// One of the four quarters. Fourteen halvings have room.
    #[inline]
    pub(super) fn quarter(self, k: u32) -> Self {
        Self(self.0 << 2 | k << 2)
    }

    /// One of the dice.
    #[inline]
    pub(super) fn die(self, k: u32) -> Self {
        Self(self.0 | k)
    }
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
    /// Other dice. Tests throw many.
    pub(super) salt: u32,
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
        // Nothing to measure a tolerance by.
        if guess == 0.0 {
            self.chance.tau = 0.0;
            let sum = self.sum();
            return (sum, self.visits);
        }
        (self.chance.tau, self.chance.guess) = (FIRST * guess, guess);
        let mut sum = self.look();
        for _ in 0..LOOKS {
            // A first look may be far off: as far as the guess.
            let share = guess * guess / (guess * guess + 4.0 * self.chance.variance);
            let about = share * sum + (1.0 - share) * guess;
            let allowed = (spread * about).powi(2);
            if self.chance.variance <= ENOUGH * allowed {
                break;
            }
            // The variance goes with tau, if not quite.
            self.chance.tau *= (0.9 * allowed / self.chance.variance).max(0.01);
            sum = self.look();
        }
        (sum, self.visits)
    }

    /// The sum at a tolerance, and its variance.
    pub(super) fn look(&mut self) -> f64 {
        self.chance.variance = 0.0;
        let sum = self.sum();
        self.chance.variance *= self.repetitions();
        sum
    }

    /// How often the kernel's box has a texel. As many parts share their dice, and what they are off by adds up.
    fn repetitions(&self) -> f64 {
        let (columns, rows) = self.map.size();
        let times = 2.0 * self.footprint.bounds().1 / DVec2::new(columns as f64, rows as f64);
        times.x.max(1.0) * times.y.max(1.0)
    }

    /// The sum of a part for which `estimate` stands, off by about `error`; `weight` is 1 over the probability that led
    /// here.
    #[inline]
    pub(super) fn settle(
        &mut self,
        error: f64,
        (die, weight): (Die, f64),
        estimate: impl FnOnce(&mut Self) -> f64,
        exact: impl FnOnce(&mut Self, f64) -> f64,
    ) -> f64 {
        let Chance { tau, salt, .. } = self.chance;
        let expected = weight * error;
        // Not a number neither.
        if expected.is_nan() || expected >= tau {
            return exact(self, weight);
        }
        let p = expected / tau;
        self.chance.variance += expected * tau * (1.0 - p);
        let estimate = estimate(self);
        if unit(pcg4d(die.words(salt))[0]) >= p {
            estimate
        } else {
            estimate + (exact(self, weight / p) - estimate) / p
        }
    }
}
