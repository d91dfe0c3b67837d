//! Sufficient statistics of a footprint, and their merge.
//!
//! Moments are kept in central form and merged by the parallel-variance formula (Chan, Golub & LeVeque 1979), so
//! that a variance is never the difference of two large sums: a footprint of equal texels has variance 0 exactly,
//! and alpha 0.02 survives under a mean slope of 1. [`Moments`] is one footprint; a block is a rectangle of them,
//! planar, and merges with the same arithmetic.

mod block;
pub mod diffuse;
mod reduce;

use std::ops::{Add, AddAssign};

use glam::{Vec2, Vec3};

pub(crate) use block::{Block, Layout, Quads, TexelRows};
pub(crate) use reduce::{Scratch, reduce_rows};

use crate::ndf::{Frame, RoughnessTensor};

/// Index of the first plane of each quantity.
pub mod plane {
    /// Weight: area times coverage, in level-0 texels.
    pub const WEIGHT: usize = 0;
    /// Mean unit normal, x y z.
    pub const NORMAL: usize = 1;
    /// Covariance of the unit normals: xx xy xz yy yz zz.
    pub const NORMAL_COV: usize = 4;
    /// Mean slope, x y.
    pub const SLOPE: usize = 10;
    /// Covariance of the slopes: xx xy yy.
    pub const SLOPE_COV: usize = 12;
    /// Mean perceptual roughness.
    pub const PERCEPTUAL: usize = 15;
    /// Mean roughness tensor in transported frames: xx xy yy.
    pub const TENSOR: usize = 16;
    /// Mean roughness form `T R T^t` in texture space: xx xy xz yy yz zz.
    pub const FORM: usize = 19;
    /// Number of planes.
    pub const COUNT: usize = 25;
}
use plane::*;

/// How a plane merges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Weights add.
    Weight,
    /// Weighted mean.
    Mean,
    /// Central second moment of two mean planes.
    Cov(usize, usize),
    /// Mean by area alone: channels that do not depend on the normal's validity.
    Plain,
}

const KINDS: [Kind; COUNT] = {
    use Kind::*;
    let (x, y, z, s, t) = (NORMAL, NORMAL + 1, NORMAL + 2, SLOPE, SLOPE + 1);
    let mut kinds = [Mean; COUNT];
    kinds[WEIGHT] = Weight;
    let covariances = [Cov(x, x), Cov(x, y), Cov(x, z), Cov(y, y), Cov(y, z), Cov(z, z)];
    let mut i = 0;
    while i < 6 {
        kinds[NORMAL_COV + i] = covariances[i];
        i += 1;
    }
    kinds[SLOPE_COV] = Cov(s, s);
    kinds[SLOPE_COV + 1] = Cov(s, t);
    kinds[SLOPE_COV + 2] = Cov(t, t);
    kinds
};

/// The planes that a fold reads, as a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs(u32);

impl Needs {
    /// Mean unit normal.
    pub const NORMAL: Needs = Needs::range(NORMAL, 3);
    /// Covariance of the unit normals, and their mean.
    pub const NORMAL_COV: Needs = Needs::range(NORMAL, 9);
    /// Variances of the unit normals' components, and their mean.
    pub const NORMAL_VARIANCE: Needs = Needs::NORMAL
        .and(Needs::range(NORMAL_COV, 1))
        .and(Needs::range(NORMAL_COV + 3, 1))
        .and(Needs::range(NORMAL_COV + 5, 1));
    /// Mean slope and covariance of the slopes.
    pub const SLOPE_COV: Needs = Needs::range(SLOPE, 5);
    /// Mean perceptual roughness.
    pub const PERCEPTUAL: Needs = Needs::range(PERCEPTUAL, 1);
    /// Mean roughness tensor.
    pub const TENSOR: Needs = Needs::range(TENSOR, 3);
    /// Mean roughness form in texture space.
    pub const FORM: Needs = Needs::range(FORM, 6);
    /// Everything.
    pub const ALL: Needs = Needs::range(0, COUNT);

    const fn range(first: usize, count: usize) -> Self {
        Needs(((1u32 << count) - 1) << first)
    }

    /// Both sets.
    pub const fn and(self, other: Needs) -> Self {
        Needs(self.0 | other.0)
    }

    /// Whether a plane is in the set.
    pub const fn has(self, plane: usize) -> bool {
        self.0 >> plane & 1 == 1
    }
}

/// Normals below this z count as this steep in the slope moments, so that one texel lying on its side cannot own
/// a coarse level: at 0.2 (78.5 degrees) it adds at most `(1 / 0.2^2 - 1) / 4096 = 0.006` to the slope variance
/// of 64x64 texels, where a z of 1/255 (one step of 8 bits) would add 16.
pub const STEEPEST_Z: f32 = 0.2;

/// Weight of a texel whose normal is unusable: footprints with any other texel ignore it to 1 part in 10^12, and
/// footprints without still have a mean.
pub const UNUSABLE_WEIGHT: f32 = 1e-12;

/// Slope of a normal, `-n.xy / n.z`, no steeper than [`STEEPEST_Z`] allows.
#[inline(always)]
pub fn slope(n: Vec3) -> Vec2 {
    let k = -1.0 / n.z.max(STEEPEST_Z);
    Vec2::new(k * n.x, k * n.y)
}

/// The statistics of one footprint.
///
/// `a + b` is the footprint that joins both; a footprint of weight 0 is the identity. Sums agree in any order and
/// grouping up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// By [`plane`].
    pub(crate) values: [f32; COUNT],
}

impl Default for Moments {
    fn default() -> Self {
        Self { values: [0.0; COUNT] }
    }
}

impl Moments {
    /// One texel of area `weight`: a unit normal, a perceptual roughness, and the tensor of its base lobe in the
    /// bent frame of the normal.
    pub fn texel(weight: f32, normal: Vec3, perceptual: f32, roughness: RoughnessTensor) -> Self {
        let mut m = Self::default();
        let v = &mut m.values;
        v[WEIGHT] = weight;
        v[NORMAL..NORMAL + 3].copy_from_slice(&normal.to_array());
        v[SLOPE..SLOPE + 2].copy_from_slice(&slope(normal).to_array());
        v[PERCEPTUAL] = perceptual;
        let r = roughness.to_transported(normal);
        v[TENSOR..TENSOR + 3].copy_from_slice(&[r.xx, r.xy, r.yy]);
        v[FORM..FORM + 6].copy_from_slice(&form(normal, r));
        m
    }

    /// Area times coverage.
    pub fn weight(&self) -> f32 {
        self.values[WEIGHT]
    }

    /// The same footprint, counted `k` times.
    pub fn scaled(mut self, k: f32) -> Self {
        self.values[WEIGHT] *= k;
        self
    }

    /// Mean unit normal; shorter than 1 where normals differ.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        Vec3::new(self.values[NORMAL], self.values[NORMAL + 1], self.values[NORMAL + 2])
    }

    /// Covariance of the unit normals, xx xy xz yy yz zz.
    #[inline(always)]
    pub fn normal_cov(&self) -> [f32; 6] {
        *self.values[NORMAL_COV..].first_chunk().expect("six of them")
    }

    /// `1 - r^2` for the length r of the mean unit normal: the trace of their covariance.
    #[inline(always)]
    pub fn lost_length2(&self) -> f32 {
        self.values[NORMAL_COV] + self.values[NORMAL_COV + 3] + self.values[NORMAL_COV + 5]
    }

    /// Mean slope.
    #[inline(always)]
    pub fn slope(&self) -> Vec2 {
        Vec2::new(self.values[SLOPE], self.values[SLOPE + 1])
    }

    /// Covariance of the slopes.
    #[inline(always)]
    pub fn slope_cov(&self) -> RoughnessTensor {
        let v = &self.values;
        RoughnessTensor { xx: v[SLOPE_COV], xy: v[SLOPE_COV + 1], yy: v[SLOPE_COV + 2] }
    }

    /// Mean perceptual roughness.
    #[inline(always)]
    pub fn perceptual(&self) -> f32 {
        self.values[PERCEPTUAL]
    }

    /// Mean base tensor, in transported frames.
    #[inline(always)]
    pub fn tensor(&self) -> RoughnessTensor {
        let v = &self.values;
        RoughnessTensor { xx: v[TENSOR], xy: v[TENSOR + 1], yy: v[TENSOR + 2] }
    }

    /// Mean base roughness form in texture space, xx xy xz yy yz zz.
    #[inline(always)]
    pub fn form(&self) -> [f32; 6] {
        *self.values[FORM..].first_chunk().expect("six of them")
    }
}

/// `T R T^t` for a tensor in the transported frame of `n`: the roughness as a quadratic form on directions.
#[inline(always)]
pub(crate) fn form(n: Vec3, r: RoughnessTensor) -> [f32; 6] {
    let Frame { tangent: t, bitangent: b } = Frame::transported(n);
    let entry = |ti: f32, bi: f32, tj: f32, bj: f32| r.xx * ti * tj + r.xy * (ti * bj + bi * tj) + r.yy * bi * bj;
    [
        entry(t.x, b.x, t.x, b.x),
        entry(t.x, b.x, t.y, b.y),
        entry(t.x, b.x, t.z, b.z),
        entry(t.y, b.y, t.y, b.y),
        entry(t.y, b.y, t.z, b.z),
        entry(t.z, b.z, t.z, b.z),
    ]
}

/// The part of a symmetric 3x3 form (xx xy xz yy yz zz) in the tangent plane of `n`, in its transported frame.
#[inline(always)]
pub fn tangential(form: [f32; 6], n: Vec3) -> RoughnessTensor {
    let Frame { tangent: t, bitangent: b } = Frame::transported(n);
    let [xx, xy, xz, yy, yz, zz] = form;
    let on = |v: Vec3| {
        Vec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
    };
    let (ft, fb) = (on(t), on(b));
    RoughnessTensor { xx: t.dot(ft), xy: t.dot(fb), yy: b.dot(fb) }
}

/// Share-weighted mean, written so that equal values give themselves back exactly; shares add to 1.
#[inline(always)]
fn merge_mean<const K: usize>(share: [f32; K], value: [f32; K]) -> f32 {
    let mut mean = value[0];
    for k in 1..K {
        mean += share[k] * (value[k] - value[0]);
    }
    mean
}

/// Central second moment of the whole from those of the parts, the parts' means, and the mean of the whole.
#[inline(always)]
fn merge_cov<const K: usize>(share: [f32; K], cov: [f32; K], a: [f32; K], b: [f32; K], mean: [f32; 2]) -> f32 {
    let mut sum = 0.0;
    for k in 0..K {
        sum += share[k] * (cov[k] + (a[k] - mean[0]) * (b[k] - mean[1]));
    }
    sum
}

impl Add for Moments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let weight = self.weight() + other.weight();
        if other.weight() == 0.0 || weight == 0.0 {
            return self;
        }
        if self.weight() == 0.0 {
            return other;
        }
        let share = [self.weight() / weight, other.weight() / weight];
        let mut out = Self::default();
        for (i, kind) in KINDS.iter().enumerate() {
            let pair = |i: usize| [self.values[i], other.values[i]];
            out.values[i] = match *kind {
                Kind::Weight => weight,
                Kind::Mean | Kind::Plain => merge_mean(share, pair(i)),
                Kind::Cov(a, b) => merge_cov(share, pair(i), pair(a), pair(b), [out.values[a], out.values[b]]),
            };
        }
        out
    }
}

impl AddAssign for Moments {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl std::iter::Sum for Moments {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), Add::add)
    }
}

#[cfg(test)]
mod tests;
