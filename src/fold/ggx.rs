//! Based on: J. T. Kent, D. E. Tyler, Y. Vardi, "A Curious Likelihood Identity for the Multivariate t-Distribution", 1994.

use super::fit::{Chunk, Fitted, Lanes, Shape, estimate, mixture, scatter};
use super::{Fold, Method};
use crate::summary::EXACT;

/// The GGX lobe closest to the footprint's own NDF: see [`super::fit`].
pub const FOLD: Fold = Fold {
    name: "ggx",
    cite: "Kent, Tyler & Vardi 1994; Fujisawa & Eguchi 2008",
    about: "the closest GGX lobe, by robust likelihood",
    method: Method::Lobes { most: EXACT, mixtures: true, slow: false, fit },
};

/// Lobes for the footprints of a chunk.
pub(super) fn fit(chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    pulp::Arch::new().dispatch(Closest { chunk, shape, out });
}

/// Closures are not always inlined into the clones; this is.
struct Closest<'a> {
    chunk: &'a Chunk,
    shape: Shape,
    out: &'a mut [Fitted],
}

impl pulp::WithSimd for Closest<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        match self.out {
            [out] => {
                let Self { chunk, shape, .. } = self;
                let estimate = scatter::closest(&chunk.atoms, shape.form, chunk.normal[2]);
                *out = estimate::read_out(&estimate, shape.form, &chunk.normal, Lanes::all(1.0));
            }
            out => mixture::fit(self.chunk, self.shape, out),
        }
    }
}
