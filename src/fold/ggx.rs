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

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pulp::WithSimd;

    use super::*;
    use crate::fold::fit::Rows;
    use crate::ndf::{Form, Lobe, SlopeLobe};
    use crate::random::Random;
    use crate::roughness::Alpha;
    use crate::summary::Entry;

    /// Footprints of nine lobes: waves, some of them with mirrors that lie apart, some with a single lobe.
    fn footprints(count: usize) -> Vec<(Vec<Entry>, Vec3)> {
        let mut random = Random::new(11, 0);
        let mut uniform = |low: f32, high: f32| low + (high - low) * random.uniform() as f32;
        let mut footprint = |i: usize| {
            let entries: Vec<Entry> = (0..9)
                .map(|k| {
                    let reach = if i.is_multiple_of(3) { 0.6 } else { 0.1 };
                    let alpha = if i.is_multiple_of(5) && k < 4 { 0.002 } else { uniform(0.05, 0.4) };
                    let normal = Vec3::new(uniform(-reach, reach), uniform(-reach, reach), 1.0).normalize();
                    let weight = if i.is_multiple_of(7) && k > 0 { 0.0 } else { uniform(0.5, 1.0) };
                    Entry { weight, lobe: SlopeLobe::new(&Lobe::isotropic(normal, Alpha(alpha))) }
                })
                .collect();
            (entries, Vec3::new(uniform(-0.1, 0.1), uniform(-0.1, 0.1), 1.0).normalize())
        };
        (0..count).map(&mut footprint).collect()
    }

    fn bits(fitted: &[Fitted], i: usize) -> Vec<u32> {
        let values = |f: &Fitted| f.normal.at(i).into_iter().chain(f.tensor.at(i)).chain([f.weight[i]]);
        fitted.iter().flat_map(values).map(f32::to_bits).collect()
    }

    #[test]
    fn alone_or_in_a_chunk_on_any_registers_the_bits_are_the_same() {
        for count in [13, 64] {
            let footprints = footprints(count);
            let alone: Vec<Chunk> = footprints.iter().map(|(entries, normal)| Chunk::of(entries, *normal)).collect();
            let mut chunk = Chunk { count, lobes: vec![Rows::default(); 9], normal: Rows::default() };
            for (i, one) in alone.iter().enumerate() {
                chunk.normal.set(i, one.normal.at(0));
                chunk.lobes.iter_mut().zip(&one.lobes).for_each(|(rows, own)| rows.set(i, own.at(0)));
            }
            let forms = [Form::Isotropic, Form::Anisotropic].into_iter();
            for (form, shared_normal) in forms.flat_map(|form| [(form, false), (form, true)]) {
                let shape = Shape { form, shared_normal };
                for lobes in 1..=4 {
                    let [mut on_registers, mut one_by_one] =
                        [vec![Fitted::default(); lobes], vec![Fitted::default(); lobes]];
                    fit(&chunk, shape, &mut on_registers);
                    Closest { chunk: &chunk, shape, out: &mut one_by_one }.with_simd(pulp::Scalar);
                    for i in 0..count {
                        let mut own = vec![Fitted::default(); lobes];
                        fit(&alone[i], shape, &mut own);
                        let found = bits(&on_registers, i);
                        assert!(found.iter().all(|v| f32::from_bits(*v).is_finite()));
                        assert_eq!(found, bits(&one_by_one, i), "{shape:?}, {lobes} lobes, footprint {i}: registers");
                        assert_eq!(found, bits(&own, 0), "{shape:?}, {lobes} lobes, footprint {i}: alone");
                    }
                }
            }
        }
    }
}
