//! Based on: J. T. Kent, D. E. Tyler, Y. Vardi, "A Curious Likelihood Identity for the Multivariate t-Distribution", 1994.

use super::fit::{Atom, Chunk, Fitted, LANES, Lanes, Shape, estimate, mixture, scatter};
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
        let mut atoms = Vec::with_capacity(chunk.lobes.len());
        for first in (0..LANES).step_by(S::F32_LANES) {
            atoms.clear();
            for lobe in &chunk.lobes {
                atoms.push(Atom::new(simd, lobe, first));
            }
            let [x, y, z] = &chunk.normal;
            let normal = [Lanes::load(simd, x, first), Lanes::load(simd, y, first), Lanes::load(simd, z, first)];
            match &mut *out {
                [out] => {
                    let estimate = scatter::closest(&atoms, shape.form, normal[2]);
                    estimate::read_out(&estimate, shape.form, &normal, Lanes::all(simd, 1.0), first, out);
                }
                out => mixture::fit(&atoms, normal[2], shape, first, out),
            }
        }
    }
}
