//! Based on: Y. Tokuyoshi, A. Kaplanyan, "Stable Geometric Specular Antialiasing with Projected-Space NDF
//! Filtering", 2021.

use glam::Vec3;

use super::{Fold, Method, MomentFold, rows::unit, toksvig::widened};
use crate::moments::{Moments, Needs, tangential};
use crate::ndf::RoughnessTensor;

/// The covariance of the normals projected on the tangent plane of their mean: bounded by 1, so no texel can own
/// a footprint. A GGX lobe projected on its disk has the matrix `B = (R^-1 - I)^-1`; the fold is `B' = B + 2 C`.
#[expect(clippy::redundant_closure, reason = "a named function is not always inlined into the rows' loops")]
pub const FOLD: Fold = Fold {
    name: "projected",
    cite: "Tokuyoshi & Kaplanyan 2021",
    about: "covariance of projected normals, added in projected space",
    method: Method::Moments(MomentFold {
        needs: Needs::NORMAL_COV.and(Needs::TENSOR),
        isotropic: |row, out| {
            row.isotropic(out, |m| {
                let n = unit(m.normal());
                (n, widened(m.tensor().mean(), tangential(m.normal_cov(), n).mean()))
            });
        },
        anisotropic: Some(|row, out| {
            row.anisotropic(
                out,
                #[inline(always)]
                |m| lobe(m),
            )
        }),
    }),
};

#[inline(always)]
fn lobe(m: &Moments) -> (Vec3, RoughnessTensor) {
    let n = unit(m.normal());
    (n, added(m.tensor(), tangential(m.normal_cov(), n)))
}

/// `R' = (I + B'^-1)^-1`. With `K = 2 C (I - R)` this is `(R + K) (I + K)^-1`, which divides by nothing that
/// vanishes: not by alpha, nor by 1 - alpha.
#[inline(always)]
pub(super) fn added(r: RoughnessTensor, c: RoughnessTensor) -> RoughnessTensor {
    let (px, pxy, py) = (1.0 - r.xx, -r.xy, 1.0 - r.yy);
    let kxx = 2.0 * (c.xx * px + c.xy * pxy);
    let kxy = 2.0 * (c.xx * pxy + c.xy * py);
    let kyx = 2.0 * (c.xy * px + c.yy * pxy);
    let kyy = 2.0 * (c.xy * pxy + c.yy * py);
    let inverse = 1.0 / ((1.0 + kxx) * (1.0 + kyy) - kxy * kyx);
    let (ax, bx) = (r.xx + kxx, r.xy + kxy);
    let (ay, by) = (r.xy + kyx, r.yy + kyy);
    RoughnessTensor {
        xx: (ax * (1.0 + kyy) - bx * kyx) * inverse,
        // Symmetric in exact arithmetic: the mean of both off-diagonal entries.
        xy: 0.5 * (bx * (1.0 + kxx) - ax * kxy + ay * (1.0 + kyy) - by * kyx) * inverse,
        yy: (by * (1.0 + kxx) - ay * kxy) * inverse,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagonal_case_worked_by_hand() {
        // R = diag(0.1, 0.5): B = diag(1/9, 1). C = diag(0.25, 0.5): B' = diag(11/18, 2), R' = B'/(1 + B').
        let r = added(RoughnessTensor { xx: 0.1, xy: 0.0, yy: 0.5 }, RoughnessTensor { xx: 0.25, xy: 0.0, yy: 0.5 });
        assert!((r.xx - 11.0 / 29.0).abs() < 1e-6 && (r.yy - 2.0 / 3.0).abs() < 1e-6 && r.xy == 0.0);
        assert!((widened(0.1, 0.25) - r.xx).abs() < 1e-7, "one axis alone is the isotropic form");
    }

    #[test]
    fn turning_both_turns_the_result() {
        let (r, c) = (RoughnessTensor { xx: 0.1, xy: 0.0, yy: 0.5 }, RoughnessTensor { xx: 0.25, xy: 0.1, yy: 0.5 });
        let (sin, cos) = 0.7f32.sin_cos();
        let (a, b) = (added(r, c).rotated(cos, sin), added(r.rotated(cos, sin), c.rotated(cos, sin)));
        assert!((a.xx - b.xx).abs() < 1e-6 && (a.xy - b.xy).abs() < 1e-6 && (a.yy - b.yy).abs() < 1e-6);
    }
}
