//! Based on: C. Han, B. Sun, R. Ramamoorthi, E. Grinspun, "Frequency Domain Normal Map Filtering", 2007;
//! D. Neubelt, M. Pettineo, "Crafting a Next-Gen Material Pipeline for The Order: 1886", 2013.

use super::{Fold, Method, MomentFold, rows::unit};
use crate::moments::{Moments, Needs};

/// A von Mises-Fisher lobe of the mean normal, convolved with the base lobe: `alpha'^2 = alpha^2 + 2/kappa`.
/// Constants of 1/2, 3/4 and 1 are in use elsewhere; 2 is the one that agrees to first order with the slopes'
/// variance (`1/kappa` is the variance per axis, and alpha^2 twice that).
pub const FOLD: Fold = Fold {
    name: "vmf",
    cite: "Han et al. 2007; Banerjee et al. 2005, eq. 4.4",
    about: "von Mises-Fisher lobe of the mean normal, alpha^2 + 2/kappa",
    method: Method::Moments(MomentFold {
        needs: Needs::NORMAL_VARIANCE.and(Needs::TENSOR),
        isotropic: |row, out| {
            row.isotropic(out, |m| (unit(m.normal()), m.tensor().mean() + 2.0 * inverse_concentration(m)));
        },
        anisotropic: None,
    }),
};

/// `1/kappa = (1 - r^2) / (3 r - r^3)`: Banerjee's approximation, inverted so that equal normals give 0.
#[inline(always)]
fn inverse_concentration(m: &Moments) -> f32 {
    let lost = m.lost_length2();
    let r = (1.0 - lost).max(1e-8).sqrt();
    lost / (r * (2.0 + lost))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moments::plane;
    use crate::roughness::Concentration;

    #[test]
    fn worked_by_hand_and_equal_to_the_unit_type() {
        // r^2 = 0.64: kappa = 0.8 (3 - 0.64) / 0.36 = 5.2444, 1/kappa = 0.190678.
        let mut m = Moments::default();
        m.values[plane::NORMAL_COV] = 0.36;
        let inverse = inverse_concentration(&m);
        assert!((inverse - 0.190_678).abs() < 1e-6);
        assert!((inverse - 1.0 / Concentration::from_mean_length(0.8).0).abs() < 1e-6);
    }
}
