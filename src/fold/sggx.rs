//! Based on: E. Heitz, J. Dupuy, C. Crassin, C. Dachsbacher, "The SGGX Microflake Distribution", 2015.

use glam::Vec3;

use super::{Fold, Method, rows::tensor_fold, rows::unit};
use crate::moments::{Moments, Needs, tangential};
use crate::ndf::RoughnessTensor;

/// The mean of the lobes' ellipsoid matrices `S = n n^T + T R T^t`, cut by the tangent plane of the mean normal.
/// Linear in the squared projected area, though not in D: to first order it adds half of what LEAN adds.
pub const FOLD: Fold = Fold {
    name: "sggx",
    cite: "Heitz et al. 2015",
    about: "average of ellipsoid matrices",
    method: Method::Moments(tensor_fold!(Needs::NORMAL_COV.and(Needs::FORM).and(Needs::TENSOR), lobe)),
};

#[inline(always)]
fn lobe(m: &Moments) -> (Vec3, RoughnessTensor) {
    let n = unit(m.normal());
    let cov = m.normal_cov();
    let mut spread = m.form();
    for i in 0..6 {
        spread[i] += cov[i];
    }
    let along = m.normal().dot(m.normal()) + on_axis(spread, n);
    (n, tangential(spread, n) * (1.0 / along))
}

/// `n^T F n`.
#[inline(always)]
fn on_axis([xx, xy, xz, yy, yz, zz]: [f32; 6], n: Vec3) -> f32 {
    xx * n.x * n.x + yy * n.y * n.y + zz * n.z * n.z + 2.0 * (xy * n.x * n.y + xz * n.x * n.z + yz * n.y * n.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_mirrors_worked_by_hand() {
        // Two mirrors at (+-0.6, 0, 0.8): S = diag(0.36, 0, 0.64), so alpha_x^2 = 0.36 / 0.64 and alpha_y = 0.
        let texel = |x| Moments::texel(1.0, Vec3::new(x, 0.0, 0.8), 0.0, RoughnessTensor::default());
        let (n, r) = lobe(&(texel(0.6) + texel(-0.6)));
        assert!((n - Vec3::Z).length() < 1e-6);
        assert!((r.xx - 0.5625).abs() < 1e-6 && r.yy.abs() < 1e-6 && r.xy.abs() < 1e-6);
    }
}
