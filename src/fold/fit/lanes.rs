//! Numbers of footprints side by side, with the arithmetic of one.
//!
//! What works on them is inlined into a clone for the processor's vector registers. A closure that is handed to an iterator
//! may be compiled on its own, for no processor in particular: such code is written in loops.

use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub};

use pulp::Simd;

/// Most footprints of a chunk, a multiple of what a register holds.
pub const FOOTPRINTS: usize = 64;

/// A number for each footprint of a chunk, as it is kept.
pub type Row = [f32; FOOTPRINTS];

/// Numbers for each footprint of a chunk.
#[derive(Clone, Copy, Debug)]
pub struct Rows<const N: usize>(pub [Row; N]);

/// Footprints of a chunk, as many as a register holds.
#[derive(Clone, Copy)]
pub enum Which<'a> {
    /// From this one on.
    From(usize),
    /// These; missing ones repeat the last.
    These(&'a [usize]),
}

impl<const N: usize> Default for Rows<N> {
    fn default() -> Self {
        Self([[0.0; FOOTPRINTS]; N])
    }
}

impl<const N: usize> Rows<N> {
    /// Those of footprint `i`.
    #[inline(always)]
    pub fn at(&self, i: usize) -> [f32; N] {
        let mut values = [0.0; N];
        for (value, row) in values.iter_mut().zip(&self.0) {
            *value = row[i];
        }
        values
    }

    /// Puts those of footprint `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, values: [f32; N]) {
        for (row, value) in self.0.iter_mut().zip(values) {
            row[i] = value;
        }
    }

    /// Those of some footprints.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, which: Which) -> [Lanes<S>; N] {
        let mut out = [Lanes::all(simd, 0.0); N];
        for (out, row) in out.iter_mut().zip(&self.0) {
            *out = match which {
                Which::From(first) => Lanes::load(simd, &row[first..]),
                Which::These(chosen) => {
                    let mut picked = [0.0; FOOTPRINTS];
                    for i in 0..S::F32_LANES {
                        picked[i] = row[chosen[i.min(chosen.len() - 1)]];
                    }
                    Lanes::load(simd, &picked)
                }
            };
        }
        out
    }

    /// Puts those of some footprints in their places.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, which: Which, values: [Lanes<S>; N]) {
        for (row, value) in self.0.iter_mut().zip(values) {
            match which {
                Which::From(first) => value.store(&mut row[first..]),
                Which::These(chosen) => {
                    let picked = value.row();
                    for (i, to) in chosen.iter().enumerate() {
                        row[*to] = picked[i];
                    }
                }
            }
        }
    }
}

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

    /// The first numbers.
    #[inline(always)]
    pub fn load(simd: S, from: &[f32]) -> Self {
        const { assert!(FOOTPRINTS.is_multiple_of(S::F32_LANES)) };
        let (whole, _) = S::as_simd_f32s(from);
        Self { simd, v: whole[0] }
    }

    /// Becomes the first numbers.
    #[inline(always)]
    pub fn store(self, to: &mut [f32]) {
        let (whole, _) = S::as_mut_simd_f32s(to);
        whole[0] = self.v;
    }

    /// As a row, of which the first ones are filled.
    #[inline(always)]
    pub fn row(self) -> Row {
        let mut row = [0.0; FOOTPRINTS];
        self.store(&mut row);
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

    /// Appends the footprints, of those from `first` to below `end`, of which it is above 0.
    #[inline(always)]
    pub fn append_positive(self, first: usize, end: usize, out: &mut Vec<usize>) {
        let row = self.row();
        for i in 0..S::F32_LANES.min(end - first) {
            if row[i] > 0.0 {
                out.push(first + i);
            }
        }
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
