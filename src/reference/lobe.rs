//! One lobe of a footprint, ready to be evaluated many times.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::ndf::Lobe;
use crate::roughness::Alpha;

/// A symmetric 3x3 matrix: xx, yy, zz, then twice the mixed terms xy, xz, yz, so that a quadratic form is a dot product
/// with the products of a vector's components.
type Form = [f64; 6];

/// A GGX lobe as an ellipsoid (Heitz et al. 2015, SGGX): with `S = R.xx t t' + R.xy (t b' + b t') + R.yy b b' + n n'`,
/// `D(m) = 1 / (pi sqrt(det S) (m' S^-1 m)^2)` and Smith's `1 + 2 Lambda(w) = sqrt(w' S w) / (n . w)`.
#[derive(Clone, Debug)]
pub(super) struct PreparedLobe {
    /// Share of the footprint's area, times whatever its sum is.
    pub weight: f64,
    pub normal: DVec3,
    /// S.
    pub ellipsoid: Form,
    /// S^-1.
    pub inverse: Form,
    /// `1 / (pi sqrt(det S))`.
    pub scale: f64,
    /// alpha of the isotropic lobe of the same peak, `sqrt(alpha_x alpha_y)`.
    pub alpha: f64,
    tangent: DVec3,
    bitangent: DVec3,
    /// Lower left factor of R: it stretches a unit lobe's slopes to this one's.
    factor: [f64; 3],
}

fn form(t: DVec3, b: DVec3, n: DVec3, [xx, xy, yy]: [f64; 3]) -> Form {
    let at = |i: usize, j: usize| xx * t[i] * t[j] + xy * (t[i] * b[j] + b[i] * t[j]) + yy * b[i] * b[j] + n[i] * n[j];
    [at(0, 0), at(1, 1), at(2, 2), 2.0 * at(0, 1), 2.0 * at(0, 2), 2.0 * at(1, 2)]
}

/// The products that a [`Form`] is multiplied with.
pub(super) fn products(v: DVec3) -> [f64; 6] {
    [v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z]
}

/// `v' M v`.
pub(super) fn quadratic(form: &Form, v: DVec3) -> f64 {
    form.iter().zip(products(v)).map(|(a, b)| a * b).sum()
}

impl PreparedLobe {
    pub fn new(lobe: &Lobe, weight: f64) -> Self {
        let n = lobe.normal.as_dvec3().normalize();
        // The +u axis made orthogonal to n; -z where n is u itself.
        let t = (DVec3::X - n * n.x).try_normalize().unwrap_or(DVec3::NEG_Z);
        let b = n.cross(t);
        let r = lobe.roughness.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
        let [xx, xy, yy] = [r.xx, r.xy, r.yy].map(f64::from);
        let det = xx * yy - xy * xy;
        let l11 = xx.sqrt();
        let l21 = xy / l11;
        Self {
            weight,
            normal: n,
            ellipsoid: form(t, b, n, [xx, xy, yy]),
            inverse: form(t, b, n, [yy / det, -xy / det, xx / det]),
            scale: 1.0 / (PI * det.sqrt()),
            alpha: det.sqrt().sqrt(),
            tangent: t,
            bitangent: b,
            factor: [l11, l21, (yy - l21 * l21).max(0.0).sqrt()],
        }
    }

    /// The same lobe with another weight.
    pub fn weighing(self, weight: f64) -> Self {
        Self { weight, ..self }
    }

    /// A normal with density `D(m) (m . n)`. Slopes of GGX have the radius `sqrt(u / (1 - u))`.
    pub fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let radius = (u / (1.0 - u).max(f64::MIN_POSITIVE)).sqrt();
        let (sin, cos) = (TAU * v).sin_cos();
        let [l11, l21, l22] = self.factor;
        let (x, y) = (l11 * radius * cos, l21 * radius * cos + l22 * radius * sin);
        (self.normal - x * self.tangent - y * self.bitangent).normalize()
    }
}
