//! Based on: C. Hery, M. Kass, J. Ling, "Geometry into Shading", Pixar technical memo 14-04, 2014.

use super::{Fold, Method, MomentFold, clean, lean::normal};
use crate::moments::Needs;

/// Pixar's read-out of the slope moments: LEAN's sum, read in the plane of the texture and not in that of the
/// bent normal. For matching RenderMan's and OpenImageIO's shaders; wider than `lean` where the mean is tilted.
pub const FOLD: Fold = Fold {
    name: "bump-to-roughness",
    cite: "Hery, Kass & Ling 2014, eq. 3",
    about: "Pixar's read-out of LEAN moments, to match RenderMan and OpenImageIO",
    method: Method::Moments(MomentFold {
        needs: Needs::SLOPE_COV.and(Needs::TENSOR),
        isotropic: |row, out| row.isotropic(out, |m| (normal(m.slope()), clean::alpha2(m))),
        anisotropic: Some(|row, out| row.anisotropic(out, |m| (normal(m.slope()), m.tensor() + m.slope_cov() * 2.0))),
    }),
};
