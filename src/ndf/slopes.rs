//! GGX lobes in the slope plane.
//!
//! Seen in the slopes about **any** axis, a GGX lobe is exactly a bivariate Student-t density with two degrees of
//! freedom: with the ellipsoid matrix `S = n n^T + T R T^t` (Heitz et al. 2015) its D is proportional to
//! `(m^T S^-1 m)^-2`, and with `m ~ (-s, 1)` that is the square of a quadratic in the slope s. The homogeneous second
//! moments of the slopes are those of S: `S / S_zz = [[P + u u^T, -u], [-u^T, 1]]` for the centre u and the scatter P.
//! So mixtures of lobes are mixtures of shifted Student-t densities in one plane, with no frames to carry along.

use glam::{Vec2, Vec3};

use super::{Frame, Lobe, RoughnessTensor};

/// A GGX lobe as the density `1 / (pi sqrt(det P) (1 + (s - u)^T P^-1 (s - u))^2)` of the slopes of its normals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopeLobe {
    /// u: where the density is highest and about which it is symmetric.
    pub centre: Vec2,
    /// P: slope squared, along +u and +v of the texture. That of an upright lobe is its roughness tensor.
    pub scatter: RoughnessTensor,
}

/// Enough for widths up to 0.9 at any tilt below 60 degrees.
const POWER_STEPS: usize = 12;

/// Squared width up to which normals are told exactly.
pub(crate) const WIDEST: f32 = 0.95;

/// Steps of Rayleigh quotient iteration, each of which trebles the digits.
pub(crate) const EIGEN_STEPS: usize = 4;

/// Least determinant of its equations, over the squared eigenvalue.
pub(crate) const SINGULAR: f32 = 1e-6;

/// Least z of a normal, before it is made unit.
pub(crate) const LEAST_Z: f32 = 1e-4;

impl SlopeLobe {
    /// From a lobe; `n.z > 0`.
    pub fn new(lobe: &Lobe) -> Self {
        let Frame { tangent, bitangent } = Frame::bent(lobe.normal);
        Self::in_frame(lobe.normal, tangent, bitangent, lobe.roughness)
    }

    /// From a normal and a tensor along a tangent and a bitangent of it.
    #[inline(always)]
    fn in_frame(n: Vec3, t: Vec3, b: Vec3, r: RoughnessTensor) -> Self {
        let form = |x: f32, y: f32, xx: f32, xy: f32, yy: f32| xx * x * x + 2.0 * xy * x * y + yy * y * y;
        let mixed = |a: usize| {
            let (ta, ba) = (t[a], b[a]);
            r.xx * ta * t.z + r.xy * (ta * b.z + ba * t.z) + r.yy * ba * b.z
        };
        let inverse = 1.0 / (n.z * n.z + form(t.z, b.z, r.xx, r.xy, r.yy));
        let centre = Vec2::new(-(n.x * n.z + mixed(0)) * inverse, -(n.y * n.z + mixed(1)) * inverse);
        // P = (S_pp S_zz - S_pz S_pz^T) / S_zz^2 holds 2x2 minors of S: entries of its cofactor matrix
        // `det R n n^T + T adj(R) T^t`, in which nothing cancels.
        let det = r.determinant();
        let cofactor = |i: usize, j: usize| {
            let (ti, bi, tj, bj) = (t[i], b[i], t[j], b[j]);
            det * n[i] * n[j] + r.yy * ti * tj - r.xy * (ti * bj + bi * tj) + r.xx * bi * bj
        };
        let k = inverse * inverse;
        let scatter = RoughnessTensor { xx: k * cofactor(1, 1), xy: -k * cofactor(0, 1), yy: k * cofactor(0, 0) };
        Self { centre, scatter }
    }

    /// From a lobe of one width: normal and alpha^2.
    #[inline(always)]
    pub fn isotropic(n: Vec3, alpha2: f32) -> Self {
        let rest = 1.0 - alpha2;
        let zz = alpha2 + rest * n.z * n.z;
        let inverse = 1.0 / zz;
        let (k, scale) = (-rest * n.z * inverse, alpha2 * inverse * inverse);
        Self {
            centre: Vec2::new(k * n.x, k * n.y),
            scatter: RoughnessTensor {
                xx: scale * (zz + rest * n.x * n.x),
                xy: scale * rest * n.x * n.y,
                yy: scale * (zz + rest * n.y * n.y),
            },
        }
    }

    /// The lobe with these slopes: its normal is the eigenvector of S with the largest eigenvalue, and the other
    /// eigenvalues over that one are alpha_x^2 and alpha_y^2. Of a scatter too wide for that, the normal is an eigenvector
    /// near that of the centre, and widths lie above 1.
    pub fn lobe(self) -> Lobe {
        let (normal, transported) = self.transported();
        Lobe { normal, roughness: transported.to_bent(normal) }
    }

    /// The same as a normal and a tensor in its transported frame.
    pub(crate) fn transported(self) -> (Vec3, RoughnessTensor) {
        let mut near = self.round_normal();
        // Wide and flat tilted lobes lie far from round ones: a few steps of power iteration towards them.
        let (u, p) = (self.centre, self.scatter);
        for _ in 0..POWER_STEPS {
            let up = near.z - u.x * near.x - u.y * near.y;
            let (x, y) = (p.xx * near.x + p.xy * near.y, p.xy * near.x + p.yy * near.y);
            let next = Vec3::new(x - up * u.x, y - up * u.y, up);
            near = if next.z > 0.0 { next.normalize() } else { near };
        }
        self.near(near)
    }

    /// The normal of the lobe of one width with this centre and, across it, this scatter; exact for those.
    fn round_normal(self) -> Vec3 {
        let (u, p) = (self.centre, self.scatter);
        let length = u.length();
        let along = if length > 0.0 { u / length } else { Vec2::X };
        let on = |a: Vec2| p.xx * a.x * a.x + 2.0 * p.xy * a.x * a.y + p.yy * a.y * a.y;
        let (a, c) = (on(along), on(along.perp()));
        // Along the tilt the scatter is alpha^2 / S_zz^2, across it alpha^2 / S_zz.
        let alpha2 = (c * c / a.max(f32::MIN_POSITIVE)).min(1.0);
        // |u| = (1 - alpha^2) t / (1 + alpha^2 t^2) for the slope t of the normal.
        let rest = 1.0 - alpha2;
        let root = (rest * rest - 4.0 * alpha2 * length * length).max(0.0).sqrt();
        let t = 2.0 * length / (rest + root).max(1e-6);
        Vec3::new(-along.x * t, -along.y * t, 1.0).normalize()
    }

    /// Normal, and tensor in its transported frame, of the eigenvector of S near a unit vector with z above 0.
    #[inline(always)]
    pub(crate) fn near(self, n0: Vec3) -> (Vec3, RoughnessTensor) {
        let (u, p) = (self.centre, self.scatter);
        // S = P + u' u'^T for u' = (-u, 1).
        let on = |a: Vec3, c: Vec3| p.xx * a.x * c.x + p.xy * (a.x * c.y + a.y * c.x) + p.yy * a.y * c.y;
        let up = |a: Vec3| a.z - u.x * a.x - u.y * a.y;
        let s = |a: Vec3, c: Vec3| on(a, c) + up(a) * up(c);
        let Frame { tangent: t, bitangent: b } = Frame::transported(n0);
        let (tn, bn, nn) = (s(t, n0), s(b, n0), s(n0, n0));
        // Wider than nearly 1, the tensor would leave the normal to rounding, or to a direction near the horizon.
        let spread = RoughnessTensor { xx: s(t, t), xy: s(t, b), yy: s(b, b) }.clamped(0.0, WIDEST * nn);
        let RoughnessTensor { xx: tt, xy: tb, yy: bb } = spread;
        // The eigenvector (x, y, 1) by Rayleigh quotient iteration, `(lambda - S_pp) x = S_pn`.
        let (mut x, mut y, mut lambda) = (0.0, 0.0, nn);
        for _ in 0..EIGEN_STEPS {
            let (a, d) = (lambda - tt, lambda - bb);
            let det = a * d - tb * tb;
            let scale = 1.0 / det.max(SINGULAR * lambda * lambda);
            (x, y) = ((d * tn + tb * bn) * scale, (tb * tn + a * bn) * scale);
            let form = nn + 2.0 * (tn * x + bn * y) + tt * x * x + 2.0 * tb * x * y + bb * y * y;
            lambda = form / (1.0 + x * x + y * y);
        }
        let v = Vec3::new(t.x * x + b.x * y + n0.x, t.y * x + b.y * y + n0.y, (t.z * x + b.z * y + n0.z).max(LEAST_Z));
        let n = v * (1.0 / (v.x * v.x + v.y * v.y + v.z * v.z).sqrt());
        let Frame { tangent: t, bitangent: b } = Frame::transported(n);
        let scale = 1.0 / s(n, n);
        (n, RoughnessTensor { xx: s(t, t) * scale, xy: s(t, b) * scale, yy: s(b, b) * scale })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::ndf::{Axes, Ndf, ShapeInvariant};
    use crate::roughness::Alpha;

    prop_compose! {
        fn lobe()(x in -1.2f32..1.2, y in -1.2f32..1.2, a in 0.02f32..0.9, ratio in 0.1f32..1.0, angle in -1.5f32..1.5) -> Lobe {
            let axes = Axes { alpha_x: Alpha(a), alpha_y: Alpha(a * ratio), angle };
            Lobe { normal: Vec3::new(-x, -y, 1.0).normalize(), roughness: RoughnessTensor::from_axes(axes) }
        }
    }

    proptest! {
        /// `D(m) cos^4 = P22(s)`, times the part of the two-sided density that belongs to the other side.
        #[test]
        fn a_lobe_is_a_shifted_student_t(lobe in lobe(), x in -2.0f64..2.0, y in -2.0f64..2.0) {
            let SlopeLobe { centre, scatter: p } = SlopeLobe::new(&lobe);
            let (dx, dy) = (x - f64::from(centre.x), y - f64::from(centre.y));
            let (xx, xy, yy) = (f64::from(p.xx), f64::from(p.xy), f64::from(p.yy));
            let det = xx * yy - xy * xy;
            let q = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / det;
            let density = 1.0 / (PI * det.sqrt() * (1.0 + q).powi(2));
            let m = DVec3::new(-x, -y, 1.0).normalize();
            prop_assume!(m.dot(lobe.normal.as_dvec3()) > 0.0);
            // Projected area of the ellipsoid over that of the normal: 1 for an upright lobe.
            let t = lobe.local(DVec3::Z);
            let r = lobe.roughness;
            let zz = f64::from(r.xx) * t.x * t.x + 2.0 * f64::from(r.xy) * t.x * t.y + f64::from(r.yy) * t.y * t.y;
            let both = (t.z * t.z + zz).sqrt() / t.z;
            let expected = lobe.d(m) * m.z.powi(4) / t.z / both;
            prop_assert!((density / expected - 1.0).abs() < 1e-3, "{density} {expected}");
        }

        #[test]
        fn and_back(lobe in lobe()) {
            let back = SlopeLobe::new(&lobe).lobe();
            prop_assert!((back.normal - lobe.normal).length() < 3e-6, "{back:?}");
            let (a, b) = (back.roughness, lobe.roughness);
            let close = |x: f32, y: f32| (x - y).abs() < 2e-5 * b.mean();
            prop_assert!(close(a.xx, b.xx) && close(a.xy, b.xy) && close(a.yy, b.yy), "{a:?} {b:?}");
        }

        #[test]
        fn one_width_in_closed_form(lobe in lobe(), alpha in 0.001f32..1.0) {
            let round = Lobe::isotropic(lobe.normal, Alpha(alpha));
            let (a, b) = (SlopeLobe::new(&round), SlopeLobe::isotropic(round.normal, alpha * alpha));
            prop_assert!((a.centre - b.centre).length() < 1e-5);
            let close = |x: f32, y: f32| (x - y).abs() < 1e-5 * a.scatter.mean();
            prop_assert!(close(a.scatter.xx, b.scatter.xx) && close(a.scatter.xy, b.scatter.xy) && close(a.scatter.yy, b.scatter.yy));
        }
    }
}
