//! Based on: J. T. Kent, D. E. Tyler, Y. Vardi, "A Curious Likelihood Identity for the Multivariate t-Distribution", 1994.

use super::fit::estimate::Estimate;
use super::fit::read_out::read_out;
use super::fit::{Chunk, Fitted, Lanes, Shape, Which, mixture, scatter};
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
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { chunk, shape, out } = self;
        let [out] = out else { return mixture::fit(simd, chunk, shape, out) };
        let closest = scatter::closest_of_each(simd, chunk, shape.form);
        for first in (0..chunk.count).step_by(S::F32_LANES) {
            let which = Which::From(first);
            let (estimate, normal) = (Estimate::new(closest.load(simd, which)), chunk.normal.load(simd, which));
            read_out(&estimate, shape.form, &normal, Lanes::all(simd, 1.0), first, out);
        }
    }
}
