//! Numbers of footprints side by side, with the arithmetic of one.
//!
//! What works on them is inlined into a clone for the processor's vector registers. A closure that is handed to an iterator
//! may be compiled on its own, for no processor in particular, and is then many times slower: such code is written in loops.

use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub};

use pulp::Simd;

/// Footprints in a chunk; what one register holds, or several.
pub const LANES: usize = 8;

/// A number for each footprint of a chunk, as it is kept.
pub type Row = [f32; LANES];

/// A number for each of the footprints that a register holds.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    simd: S,
    v: S::f32s,
}

impl<S: Simd> Lanes<S> {
    /// The same for all.
    #[inline(always)]
    pub fn all(simd: S, v: f32) -> Self {
        Self { simd, v: simd.splat_f32s(v) }
    }

    /// The same for as many.
    #[inline(always)]
    pub fn like(self, v: f32) -> Self {
        Self::all(self.simd, v)
    }

    /// Those of the footprints from `first` on.
    #[inline(always)]
    pub fn load(simd: S, from: &Row, first: usize) -> Self {
        let (whole, _) = S::as_simd_f32s(&from[first..]);
        Self { simd, v: whole[0] }
    }

    /// Puts them in their places.
    #[inline(always)]
    pub fn store(self, to: &mut Row, first: usize) {
        let (whole, _) = S::as_mut_simd_f32s(&mut to[first..]);
        whole[0] = self.v;
    }

    /// As a row, of which the first ones are filled.
    #[inline(always)]
    pub fn row(self) -> Row {
        let mut row = [0.0; LANES];
        self.store(&mut row, 0);
        row
    }

    /// The larger; never NaN if `low` is not.
    #[inline(always)]
    pub fn max(self, low: f32) -> Self {
        let low = self.like(low);
        self.above(low, self, low)
    }

    /// The smaller; never NaN if `high` is not.
    #[inline(always)]
    pub fn min(self, high: f32) -> Self {
        let high = self.like(high);
        high.above(self, self, high)
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { v: self.simd.sqrt_f32s(self.v), ..self }
    }

    /// `1 / self`.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        Self { v: self.simd.div_f32s(self.like(1.0).v, self.v), ..self }
    }

    /// `yes` where this is larger than `other`, else `no`.
    #[inline(always)]
    pub fn above(self, other: Self, yes: Self, no: Self) -> Self {
        Self { v: self.simd.select_f32s(self.simd.greater_than_f32s(self.v, other.v), yes.v, no.v), ..self }
    }

    /// Whether one of them is larger than the other's.
    #[inline(always)]
    pub fn any_above(self, other: Self) -> bool {
        self.simd.first_true_m32s(self.simd.greater_than_f32s(self.v, other.v)) < S::F32_LANES
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { v: self.simd.add_f32s(self.v, other.v), ..self }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { v: self.simd.sub_f32s(self.v, other.v), ..self }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { v: self.simd.mul_f32s(self.v, other.v), ..self }
    }
}

impl<S: Simd> Mul<Lanes<S>> for f32 {
    type Output = Lanes<S>;

    #[inline(always)]
    fn mul(self, other: Lanes<S>) -> Lanes<S> {
        other.like(self) * other
    }
}

impl<S: Simd> Add<f32> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f32) -> Self {
        self + self.like(other)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self * self.like(-1.0)
    }
}

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> MulAssign for Lanes<S> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

/// All of them times one.
#[inline(always)]
pub fn scaled<S: Simd, const N: usize>(mut values: [Lanes<S>; N], by: Lanes<S>) -> [Lanes<S>; N] {
    for value in &mut values {
        *value *= by;
    }
    values
}
