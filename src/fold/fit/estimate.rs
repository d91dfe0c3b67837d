//! An estimate of a footprint's lobe: where it lies in the slope plane, and what it overlaps.

use pulp::Simd;

use super::chunk::Atom;
use super::lanes::Lanes;
use crate::ndf::Form;

/// A lobe of each footprint by its slopes.
#[derive(Clone, Copy)]
pub struct Estimate<S: Simd> {
    /// Centre.
    pub x: Lanes<S>,
    /// Centre.
    pub y: Lanes<S>,
    /// Scatter.
    pub xx: Lanes<S>,
    /// Scatter.
    pub xy: Lanes<S>,
    /// Scatter.
    pub yy: Lanes<S>,
}

impl<S: Simd> Estimate<S> {
    /// From its centre x y and scatter xx xy yy.
    #[inline(always)]
    pub fn new([x, y, xx, xy, yy]: [Lanes<S>; 5]) -> Self {
        Self { x, y, xx, xy, yy }
    }

    /// Centre and scatter 0, as sums begin.
    #[inline(always)]
    pub fn nothing(zero: Lanes<S>) -> Self {
        Self::new([zero; 5])
    }

    /// Its centre x y and scatter xx xy yy.
    #[inline(always)]
    pub fn values(self) -> [Lanes<S>; 5] {
        [self.x, self.y, self.xx, self.xy, self.yy]
    }

    /// Root of the scatter's determinant.
    #[inline(always)]
    pub fn area(&self) -> Lanes<S> {
        (self.xx * self.yy - self.xy * self.xy).max(0.0).sqrt()
    }

    /// The overlap with an atom, 0 to 1, given the own area: `sqrt(sqrt(det P det Q) / det((P + Q + d d^T) / 2))`. Among
    /// lobes of one centre and shape that is near the overlap of the densities, `2 / (1 + sqrt r)` for areas of the ratio r.
    #[inline(always)]
    pub fn overlap(&self, area: Lanes<S>, atom: &Atom<S>) -> Lanes<S> {
        let (dx, dy, [xx, xy, yy]) = (atom.x - self.x, atom.y - self.y, atom.scatter());
        let (xx, xy, yy) = (xx + self.xx, xy + self.xy, yy + self.yy);
        // With d d^T in them, the products of what is narrow and far would differ by their rounding alone.
        let both = (xx * yy - xy * xy) + (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy);
        // By Minkowski's inequality no less than this.
        let own = atom.l11 * atom.l22;
        let least = (area + own) * (area + own);
        let both = both.above(least, both, least).max(f32::MIN_POSITIVE);
        (4.0 * area * own * both.inverse()).sqrt()
    }

    /// This one where `value` is larger than `least`, else the other.
    #[inline(always)]
    pub fn where_above(self, value: Lanes<S>, least: Lanes<S>, other: Self) -> Self {
        Self {
            x: value.above(least, self.x, other.x),
            y: value.above(least, self.y, other.y),
            xx: value.above(least, self.xx, other.xx),
            xy: value.above(least, self.xy, other.xy),
            yy: value.above(least, self.yy, other.yy),
        }
    }

    /// Becomes the estimate, of one width if that is asked for, where there is more weight than `least`. `up` is the z of a
    /// normal near the lobe's.
    #[inline(always)]
    pub fn settle(mut self, form: Form, up: Lanes<S>, weight: Lanes<S>, least: Lanes<S>, out: &mut Self) {
        if form == Form::Isotropic {
            self.round(up * up);
        }
        *out = self.where_above(weight, least, *out);
    }

    /// Takes the scatter of a lobe of one width about this centre: the mean of its own in that one's metric. `up2` is the
    /// squared z of the lobe's normal, or of one near to it.
    ///
    /// Such a lobe has the scatter alpha^2 / S_zz^2 along the tilt and alpha^2 / S_zz across it, `S_zz = alpha^2 +
    /// (1 - alpha^2) n_z^2`.
    #[inline(always)]
    fn round(&mut self, up2: Lanes<S>) {
        let Self { x, y, xx, xy, yy } = *self;
        let (zero, length2) = (x.like(0.0), x * x + y * y);
        let inverse = length2.max(f32::MIN_POSITIVE).inverse();
        let along = (xx * x * x + 2.0 * xy * x * y + yy * y * y) * inverse;
        let along = length2.above(zero, along, 0.5 * (xx + yy));
        let across = xx + yy - along;
        // alpha^2 enters S_zz. Begun from that of a round lobe, which is exact for one, a few rounds settle it.
        let mut zz = (across * along.max(f32::MIN_POSITIVE).inverse()).max(1e-6).min(1.0);
        let mut alpha2 = zero;
        for _ in 0..3 {
            alpha2 = (0.5 * (along * zz * zz + across * zz)).min(1.0);
            zz = up2 + alpha2 * (-up2 + 1.0);
        }
        let inverse_zz = zz.inverse();
        let c = alpha2 * inverse_zz;
        let a = c * inverse_zz;
        let k = length2.above(zero, (a - c) * inverse, zero);
        (self.xx, self.xy, self.yy) = (c + k * x * x, k * x * y, c + k * y * y);
    }

    /// The direction of the lobe's normal, by a few power steps from the centre's own.
    #[inline(always)]
    pub fn direction(&self) -> [Lanes<S>; 3] {
        let mut near = [-self.x, -self.y, self.x.like(1.0)];
        for _ in 0..4 {
            let [x, y, z] = near;
            let up = z - self.x * x - self.y * y;
            let (x, y) = (self.xx * x + self.xy * y - up * self.x, self.xy * x + self.yy * y - up * self.y);
            let scale = (x * x + y * y + up * up).max(f32::MIN_POSITIVE).sqrt().inverse();
            near = [x * scale, y * scale, up * scale];
        }
        near
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::fold::fit::{Chunk, Which};
    use crate::ndf::{RoughnessTensor, SlopeLobe};
    use crate::summary::Entry;

    /// How much a mirror overlaps itself, and one on the other side.
    struct Overlaps {
        alpha2: f32,
        x: f32,
    }

    impl pulp::WithSimd for Overlaps {
        type Output = [f32; 2];

        fn with_simd<S: Simd>(self, simd: S) -> [f32; 2] {
            let scatter = RoughnessTensor { xx: self.alpha2, xy: 0.0, yy: self.alpha2 };
            let entry = |x: f32| Entry { weight: 1.0, lobe: SlopeLobe { centre: Vec2::splat(x), scatter } };
            let chunk = Chunk::of(&[entry(self.x), entry(-self.x)], Vec3::Z);
            let mut atoms = Vec::new();
            chunk.atoms(simd, Which::From(0), &mut atoms);
            let e = atoms[0].estimate();
            [0, 1].map(|k| e.overlap(e.area(), &atoms[k]).row()[0])
        }
    }

    #[test]
    fn overlaps_of_mirrors_are_not_those_of_rounding() {
        for (alpha2, x) in [(1e-12, 0.5), (1e-10, 1.7), (1e-8, 0.3), (1e-4, 0.2)] {
            let [own, far] = pulp::Arch::new().dispatch(Overlaps { alpha2, x });
            assert!((own - 1.0).abs() < 1e-3, "{own}");
            // det(P + d d^T / 2) = alpha^4 + alpha^2 d^2 / 2, for d^2 = 8 x^2.
            let expected = (alpha2 / (alpha2 + 4.0 * x * x)).sqrt();
            assert!((far / expected - 1.0).abs() < 1e-3, "{far} {expected}");
        }
    }
}
