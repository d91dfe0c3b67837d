//! What the lobes have in common: slopes of a round lobe of unit width, stretched by a tensor.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::{Frame, Ndf, RoughnessTensor};
use crate::roughness::Alpha;

/// A lobe whose slopes are those of a round lobe of unit width, stretched by its tensor: a shape-invariant
/// distribution (Heitz 2014, section 5). Its density of slopes is `P22(s) = f(s^T R^-1 s) / sqrt(det R)`, and
/// `D(m) = P22(s) / (m . n)^4`.
///
/// A shape says three things of its round lobe of unit width; everything else follows from them, [`Ndf`] too.
pub trait ShapeInvariant {
    /// Unit, z out of the surface.
    fn normal(&self) -> Vec3;

    /// Width, in the bent frame of the normal ([`Frame::bent`]).
    fn roughness(&self) -> RoughnessTensor;

    /// D of the round lobe of unit width, as it continues off the unit sphere (of degree -4), where the squared length
    /// of the tangential part is `p2` and the normal part is `z`, above 0.
    fn unit_d(&self, p2: f64, z: f64) -> f64;

    /// The radius within which a share `u` of the slopes of the round lobe of unit width lies, `u` below 1.
    fn unit_radius(&self, u: f64) -> f64;

    /// Smith's Lambda of the round lobe of unit width for a direction with this squared tangent of its angle to the
    /// normal.
    fn unit_lambda(&self, tan2: f64) -> f64;

    /// `v` in the lobe's own frame: (tangent, bitangent, normal).
    fn local(&self, v: DVec3) -> DVec3 {
        let frame = Frame::bent(self.normal());
        DVec3::new(v.dot(frame.tangent.as_dvec3()), v.dot(frame.bitangent.as_dvec3()), v.dot(self.normal().as_dvec3()))
    }

    /// Smith's Lambda for a direction `v` (any length): that of the round lobe of unit width for the direction whose
    /// tangential part is stretched by R (Heitz 2014, section 5).
    fn lambda(&self, v: DVec3) -> f64 {
        let v = self.local(v);
        let [xx, xy, yy] = evaluated(self.roughness());
        let form = xx * v.x * v.x + 2.0 * xy * v.x * v.y + yy * v.y * v.y;
        self.unit_lambda(form / (v.z * v.z))
    }

    /// Specular BRDF times cosine for unit view and light, with F = 1 and height-correlated Smith masking:
    /// `D G2 / (4 n.v)` with `G2 = 1 / (1 + Lambda(v) + Lambda(l))` (Heitz 2014, eq. 99). 0 below the lobe's
    /// horizon.
    fn specular(&self, v: DVec3, l: DVec3) -> f64 {
        let n = self.normal().as_dvec3();
        let (nv, nl) = (n.dot(v), n.dot(l));
        if nv <= 0.0 || nl <= 0.0 {
            return 0.0;
        }
        let h = (v + l).normalize();
        self.d(h) / (4.0 * nv * (1.0 + self.lambda(v) + self.lambda(l)))
    }
}

/// xx xy yy of the tensor that is evaluated: no width below [`Alpha::SMOOTHEST`].
fn evaluated(roughness: RoughnessTensor) -> [f64; 3] {
    let r = roughness.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
    [r.xx, r.xy, r.yy].map(f64::from)
}

impl<L: ShapeInvariant + ?Sized> Ndf for L {
    fn d(&self, m: DVec3) -> f64 {
        let m = self.local(m);
        if m.z <= 0.0 {
            return 0.0;
        }
        let [xx, xy, yy] = evaluated(self.roughness());
        let det = xx * yy - xy * xy;
        let p2 = (yy * m.x * m.x - 2.0 * xy * m.x * m.y + xx * m.y * m.y) / det;
        self.unit_d(p2, m.z) / det.sqrt()
    }

    fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        // The Cholesky factor of R stretches the slopes of the round lobe.
        let [xx, xy, yy] = evaluated(self.roughness());
        let radius = self.unit_radius(u);
        let (sin, cos) = (TAU * v).sin_cos();
        let l11 = xx.sqrt();
        let l21 = xy / l11;
        let l22 = (yy - l21 * l21).max(0.0).sqrt();
        let (sx, sy) = (l11 * radius * cos, l21 * radius * cos + l22 * radius * sin);
        let frame = Frame::bent(self.normal());
        let m = self.normal().as_dvec3() - sx * frame.tangent.as_dvec3() - sy * frame.bitangent.as_dvec3();
        m.normalize()
    }

    fn pdf(&self, m: DVec3) -> f64 {
        self.d(m) * m.dot(self.normal().as_dvec3()).max(0.0)
    }
}
