//! Based on: D. Baker, "Spectacular Specular: LEAN and CLEAN Specular Highlights", GDC 2011.

use super::{Fold, Method, MomentFold, lean::normal};
use crate::moments::{Moments, Needs};

/// LEAN with one variance: the mean of both axes, so `alpha'^2 = alpha^2 + trace of the covariance`. (Using the
/// trace as the variance of each axis, as some ports do, is twice as much.)
pub const FOLD: Fold = Fold {
    name: "clean",
    cite: "Baker 2011",
    about: "isotropic LEAN: slope variance averaged over both axes",
    method: Method::Moments(MomentFold {
        needs: Needs::SLOPE_COV.and(Needs::TENSOR),
        isotropic: |row, out| row.isotropic(out, |m| (normal(m.slope()), alpha2(m))),
        anisotropic: None,
    }),
};

#[inline(always)]
pub(super) fn alpha2(m: &Moments) -> f32 {
    m.tensor().mean() + 2.0 * m.slope_cov().mean()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::plane;

    #[test]
    fn worked_by_hand() {
        let mut m = Moments::default();
        (m.values[plane::TENSOR], m.values[plane::TENSOR + 2]) = (0.01, 0.01);
        (m.values[plane::SLOPE_COV], m.values[plane::SLOPE_COV + 2]) = (0.04, 0.02);
        assert!((alpha2(&m) - 0.07).abs() < 1e-7);
    }
}
