//! An estimate of a footprint's lobe: where it lies in the slope plane, what it overlaps, and how it is read out.

use glam::{Vec2, Vec3};

use super::chunk::{Atom, Fitted};
use super::lanes::{LANES, Lanes};
use crate::ndf::{Form, RoughnessTensor, SlopeLobe};

/// A lobe of each footprint by its slopes.
#[derive(Clone, Copy, Default)]
pub struct Estimate {
    /// Centre.
    pub x: Lanes,
    /// Centre.
    pub y: Lanes,
    /// Scatter.
    pub xx: Lanes,
    /// Scatter.
    pub xy: Lanes,
    /// Scatter.
    pub yy: Lanes,
}

impl Estimate {
    /// Root of the scatter's determinant.
    #[inline(always)]
    pub fn area(&self) -> Lanes {
        (self.xx * self.yy - self.xy * self.xy).max(0.0).sqrt()
    }

    /// The overlap with an atom, 0 to 1, given the own area: `sqrt(sqrt(det P det Q) / det((P + Q + d d^T) / 2))`. Among
    /// lobes of one centre and shape that is near the overlap of the densities, `2 / (1 + sqrt r)` for areas of the ratio r.
    #[inline(always)]
    pub fn overlap(&self, area: Lanes, atom: &Atom) -> Lanes {
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
    pub fn where_above(self, value: Lanes, least: Lanes, other: Self) -> Self {
        let pick = |own: Lanes, other: Lanes| value.above(least, own, other);
        Self {
            x: pick(self.x, other.x),
            y: pick(self.y, other.y),
            xx: pick(self.xx, other.xx),
            xy: pick(self.xy, other.xy),
            yy: pick(self.yy, other.yy),
        }
    }

    /// Becomes the estimate, of one width if that is asked for, where there is more weight than `least`. `up` is the z of a
    /// normal near the lobe's.
    #[inline(always)]
    pub fn settle(mut self, form: Form, up: Lanes, weight: Lanes, least: Lanes, out: &mut Self) {
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
    fn round(&mut self, up2: Lanes) {
        let Self { x, y, xx, xy, yy } = *self;
        let (zero, length2) = (Lanes::default(), x * x + y * y);
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
    pub fn direction(&self) -> [Lanes; 3] {
        let mut near = [-self.x, -self.y, Lanes::all(1.0)];
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

/// Reads an estimate out as lobes, given unit normals near theirs.
///
/// The wider a lobe, the less its slopes say of its normal, and the more its shading depends on that: by alpha^3 it is taken
/// from the given one. Where steep and rough texels meet that lies closer in lobe error.
#[inline(always)]
pub fn read_out(e: &Estimate, form: Form, near: &[Lanes; 3], weight: Lanes) -> Fitted {
    let mut out = Fitted { weight, ..Fitted::default() };
    for i in 0..LANES {
        let scatter = RoughnessTensor { xx: e.xx.0[i], xy: e.xy.0[i], yy: e.yy.0[i] };
        let near = Vec3::from(near.map(|v| v.0[i]));
        let (n, r) = SlopeLobe { centre: Vec2::new(e.x.0[i], e.y.0[i]), scatter }.near(near);
        let alpha2 = r.mean().clamp(0.0, 1.0);
        let n = (n + alpha2 * alpha2.sqrt() * (near - n)).normalize();
        // That of a lobe of one width is round but for rounding.
        let r = if form == Form::Isotropic { RoughnessTensor { xx: r.mean(), xy: 0.0, yy: r.mean() } } else { r };
        (out.normal[0].0[i], out.normal[1].0[i], out.normal[2].0[i]) = (n.x, n.y, n.z);
        (out.tensor[0].0[i], out.tensor[1].0[i], out.tensor[2].0[i]) = (r.xx, r.xy, r.yy);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::Entry;

    fn atom(x: f32, y: f32, alpha2: f32) -> Atom {
        let mut atom = Atom::default();
        let lobe = SlopeLobe { centre: Vec2::new(x, y), scatter: RoughnessTensor { xx: alpha2, xy: 0.0, yy: alpha2 } };
        (0..LANES).for_each(|i| atom.set_lane(i, &Entry { weight: 1.0, lobe }));
        atom
    }

    #[test]
    fn overlaps_of_mirrors_are_not_those_of_rounding() {
        for (alpha2, x) in [(1e-12, 0.5), (1e-10, 1.7), (1e-8, 0.3), (1e-4, 0.2)] {
            let (one, other) = (atom(-x, -x, alpha2), atom(x, x, alpha2));
            let of = |atom: &Atom| {
                let [xx, xy, yy] = atom.scatter();
                Estimate { x: atom.x, y: atom.y, xx, xy, yy }
            };
            let e = of(&one);
            let (own, far) = (e.overlap(e.area(), &one).0[0], e.overlap(e.area(), &other).0[0]);
            assert!((own - 1.0).abs() < 1e-3, "{own}");
            // det(P + d d^T / 2) = alpha^4 + alpha^2 d^2 / 2, for d^2 = 8 x^2.
            let expected = (alpha2 / (alpha2 + 4.0 * x * x)).sqrt();
            assert!((far / expected - 1.0).abs() < 1e-3, "{far} {expected}");
        }
    }
}
