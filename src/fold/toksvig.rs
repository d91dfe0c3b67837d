//! Based on: Michael Toksvig, "Mipmapping Normal Maps", 2004.

use super::{Fold, Method, MomentFold, rows::unit};
use crate::moments::{Moments, Needs};

/// Toksvig's gloss factor in terms of alpha. With the Blinn-Phong exponent `s = 2/alpha^2 - 2`, his
/// `1/s' = 1/s + V`, `V = (1 - r) / r` for the length r of the mean normal, is [`widened`].
pub const FOLD: Fold = Fold {
    name: "toksvig",
    cite: "Toksvig 2004, gloss factor",
    about: "length of the mean normal as a variance, added to the inverse Blinn-Phong exponent",
    method: Method::Moments(MomentFold {
        needs: Needs::NORMAL_VARIANCE.and(Needs::TENSOR),
        isotropic: |row, out| row.isotropic(out, |m| (unit(m.normal()), widened(m.tensor().mean(), variance(m)))),
        anisotropic: None,
    }),
};

/// `(1 - r) / r`, from the trace of the normals' covariance: of unit normals it is `1 - r^2`, and unlike that
/// difference it is exactly 0 for equal normals.
#[inline(always)]
fn variance(m: &Moments) -> f32 {
    let lost = m.lost_length2();
    let r = (1.0 - lost).max(0.0).sqrt();
    lost / ((1.0 + r) * r.max(SHORTEST))
}

/// Opposed normals have no mean; a length of 1e-4 already stands for alpha 1 to 4 digits.
const SHORTEST: f32 = 1e-4;

/// `X / (1 + X)` with `X = alpha^2 / (1 - alpha^2) + 2 V`, written without the division that fails at alpha 1.
/// The same as adding `2 V` in projected space (Tokuyoshi & Kaplanyan 2021).
#[inline(always)]
pub(super) fn widened(alpha2: f32, variance: f32) -> f32 {
    let added = 2.0 * variance * (1.0 - alpha2);
    (alpha2 + added) / (1.0 + added)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_the_gloss_factor_worked_by_hand() {
        // alpha^2 = 0.1: s = 18. r = 0.8: V = 0.25, 1/s' = 1/18 + 1/4, s' = 36/11, alpha'^2 = 2/(36/11 + 2) = 11/29.
        assert!((widened(0.1, 0.25) - 11.0 / 29.0).abs() < 1e-7);
        assert_eq!(widened(1.0, 0.25), 1.0);
        assert_eq!(widened(4e-4, 0.0), 4e-4);
        assert!(widened(0.01, (1.0 - SHORTEST) / SHORTEST) > 0.9999);
    }
}
