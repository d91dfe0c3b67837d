//! What engines do by themselves: the baseline.

use super::{Fold, Method, MomentFold, rows::unit};
use crate::moments::Needs;

/// The mean normal renormalised, and the mean of what the roughness texture holds: the normals' spread is lost.
pub const FOLD: Fold = Fold {
    name: "average",
    cite: "plain mip filtering",
    about: "mean normal, mean perceptual roughness: what engines do; the baseline",
    method: Method::Moments(MomentFold {
        needs: Needs::NORMAL.and(Needs::PERCEPTUAL),
        isotropic: |row, out| row.isotropic(out, |m| (unit(m.normal()), m.perceptual().powi(4))),
        anisotropic: None,
    }),
};
