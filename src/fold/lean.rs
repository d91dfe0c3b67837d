//! Based on: M. Olano, D. Baker, "LEAN Mapping", 2010; J. Dupuy et al., "Linear Efficient Antialiased Displacement
//! and Reflectance Mapping", 2013.

use glam::{Vec2, Vec3};

use super::{Fold, Method, rows::tensor_fold, rows::unit};
use crate::moments::{Moments, Needs};
use crate::ndf::RoughnessTensor;

/// Mean and covariance of the slopes; the lobe is `base + 2 covariance` about the mean slope's normal, the
/// covariance carried into that normal's tangent plane. Normals steeper than 78.5 degrees count as that steep
/// ([`crate::moments::STEEPEST_Z`]), so a texture that is steeper everywhere is flattened to it.
pub const FOLD: Fold = Fold {
    name: "lean",
    cite: "Olano & Baker 2010; Dupuy et al. 2013",
    about: "slope moments, alpha^2 + 2 covariance",
    method: Method::Moments(tensor_fold!(Needs::SLOPE_COV.and(Needs::TENSOR), lobe)),
};

/// The normal of a slope.
#[inline(always)]
pub(super) fn normal(slope: Vec2) -> Vec3 {
    unit(Vec3::new(-slope.x, -slope.y, 1.0))
}

#[inline(always)]
fn lobe(m: &Moments) -> (Vec3, RoughnessTensor) {
    let n = normal(m.slope());
    (n, m.tensor() + in_tangent_plane(m.slope_cov(), m.slope(), n.z) * 2.0)
}

/// `J C J^T`: a covariance of slopes about a mean slope s, seen from the tangent plane there (transported frame).
/// J shrinks by cos^2 along the tilt and by cos across it: `J = cos (I - cos^2 / (1 + cos) s s^T)`.
#[inline(always)]
fn in_tangent_plane(cov: RoughnessTensor, s: Vec2, cos: f32) -> RoughnessTensor {
    let k = cos * cos / (1.0 + cos);
    let (a, b, d) = (cos * (1.0 - k * s.x * s.x), -cos * k * s.x * s.y, cos * (1.0 - k * s.y * s.y));
    let (ax, ay) = (a * cov.xx + b * cov.xy, a * cov.xy + b * cov.yy);
    let (bx, by) = (b * cov.xx + d * cov.xy, b * cov.xy + d * cov.yy);
    RoughnessTensor { xx: ax * a + ay * b, xy: ax * b + ay * d, yy: bx * b + by * d }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tilt_shrinks_by_the_fourth_and_second_power_of_the_cosine() {
        // Slope (1, 0): cos^2 = 1/2. Along the tilt cos^4 = 1/4, across it cos^2 = 1/2, mixed cos^3.
        let cov = RoughnessTensor { xx: 0.4, xy: 0.1, yy: 0.2 };
        let local = in_tangent_plane(cov, Vec2::new(1.0, 0.0), 0.5f32.sqrt());
        assert!((local.xx - 0.1).abs() < 1e-6 && (local.yy - 0.1).abs() < 1e-6);
        assert!((local.xy - 0.1 * 0.5f32.powf(1.5)).abs() < 1e-6);
        assert_eq!(in_tangent_plane(cov, Vec2::ZERO, 1.0), cov);
    }
}
