//! Numbers of footprints side by side, with the arithmetic of one.

use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub};

/// Footprints in a chunk.
pub const LANES: usize = 8;

/// A number for each footprint of a chunk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// The same for all.
    #[inline(always)]
    pub const fn all(v: f32) -> Self {
        Self([v; LANES])
    }

    #[inline(always)]
    fn zip(self, other: Self, op: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = op(self.0[i], other.0[i]);
        }
        Self(out)
    }

    #[inline(always)]
    fn map(self, op: impl Fn(f32) -> f32) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = op(self.0[i]);
        }
        Self(out)
    }

    /// The larger; never NaN if `low` is not.
    #[inline(always)]
    pub fn max(self, low: f32) -> Self {
        self.map(|v| if v > low { v } else { low })
    }

    /// The smaller; never NaN if `high` is not.
    #[inline(always)]
    pub fn min(self, high: f32) -> Self {
        self.map(|v| if v < high { v } else { high })
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    /// `1 / self`.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        self.map(|v| 1.0 / v)
    }

    /// `yes` where this is larger than `other`, else `no`.
    #[inline(always)]
    pub fn above(self, other: Self, yes: Self, no: Self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = if self.0[i] > other.0[i] { yes.0[i] } else { no.0[i] };
        }
        Self(out)
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<Lanes> for f32 {
    type Output = Lanes;

    #[inline(always)]
    fn mul(self, other: Lanes) -> Lanes {
        other.map(|v| self * v)
    }
}

impl Add<f32> for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f32) -> Self {
        self.map(|v| v + other)
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|v| -v)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl MulAssign for Lanes {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
