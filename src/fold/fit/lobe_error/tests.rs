//! Few half vectors against many.

use super::*;
use crate::ndf::{Lobe, SlopeLobe};
use crate::reference::{Diffuse, Footprint, Queries};
use crate::roughness::Alpha;

/// Half vectors a view.
const HALVES_OF_TRUTH: usize = 20_000;

/// A lobe, by slopes and widths.
fn lobe(x: f32, y: f32, [xx, xy, yy]: [f32; 3]) -> Candidate {
    (Vec3::new(-x, -y, 1.0).normalize(), RoughnessTensor { xx, xy, yy })
}

fn bent((normal, tensor): Candidate) -> Lobe {
    Lobe { normal, roughness: tensor.to_bent(normal) }
}

/// The judge's integrals by many half vectors, in f64.
pub fn exact(truth: &Footprint, other: &Footprint) -> f64 {
    let (mut queries, mut spread) = (Queries::default(), Spread::new(&mut Random::new(7, 0)));
    for view in VIEWS {
        queries.start_view(direction(view).as_dvec3().normalize());
        for i in 0..HALVES_OF_TRUTH {
            queries.push_half(if i % 2 == 0 { truth } else { other }.draw(spread.point()));
        }
    }
    let [a, b] = [truth, other].map(|f| f.means(&queries, &Diffuse::default()).swap_remove(0));
    let (mut apart, mut both) = (0.0, 0.0);
    for (view, range) in queries.views().zip(queries.ranges()) {
        for j in range {
            let share = view.dot(queries.half(j)).max(0.0) / (a.pdf[j] + b.pdf[j]);
            apart += share * (a.specular[j] - b.specular[j]).abs();
            both += share * 0.5 * (a.specular[j] + b.specular[j]);
        }
    }
    apart / both
}

fn of_lobes(lobes: &[(f32, Candidate)]) -> Footprint<'_> {
    Footprint::of_lobes(&lobes.iter().map(|(share, lobe)| (bent(*lobe), f64::from(*share))).collect::<Vec<_>>())
}

#[test]
fn few_half_vectors_tell_what_many_in_f64_do() {
    let footprint =
        [lobe(0.3, -0.1, [0.02, 0.005, 0.01]), lobe(-0.2, 0.2, [0.04, 0.0, 0.04]), lobe(0.1, 0.6, [0.01, 0.0, 0.01])];
    let entries = footprint.map(|lobe| Entry { weight: 1.0, lobe: SlopeLobe::new(&bent(lobe)) });
    let guess = lobe(0.05, 0.2, [0.08, 0.0, 0.12]);
    let error = LobeError::new(entries.into_iter(), &[(1.0, guess)]);
    for other in [guess, lobe(0.1, 0.1, [0.05, 0.02, 0.2]), lobe(0.3, -0.1, [0.02, 0.005, 0.01])] {
        let (found, expected) =
            (error.of(other), exact(&of_lobes(&footprint.map(|lobe| (1.0, lobe))), &of_lobes(&[(1.0, other)])));
        assert!((f64::from(found) / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }
}

#[test]
fn steep_mirrors_have_one() {
    for z in [1e-2f32, 1e-3, 1e-4] {
        let steep = |x: f32, y: f32| {
            let lobe = Lobe::isotropic(Vec3::new(x, y, z).normalize(), Alpha(1e-6));
            Entry { weight: 1.0, lobe: SlopeLobe::new(&lobe) }
        };
        let footprint = [steep(1.0, 1.0), steep(-0.3, 1.0), steep(1.0, -0.9)];
        let guess = lobe(0.1, 0.2, [0.5, 0.0, 0.5]);
        let error = LobeError::new(footprint.into_iter(), &[(1.0, guess)]).of(guess);
        assert!((0.0..=2.0).contains(&error), "{z}: {error}");
    }
}

#[test]
fn a_single_lobe_has_no_error() {
    // Down to widths at which a light is mirrored to a point.
    for alpha in [0.9f32, 0.1, 0.01, 0.001] {
        let own = lobe(0.4, -0.3, [alpha * alpha, 0.0, 0.25 * alpha * alpha]);
        let entry = Entry { weight: 3.0, lobe: SlopeLobe::new(&bent(own)) };
        let error = LobeError::new(std::iter::once(entry), &[(1.0, own)]).of(own);
        assert!(error < 2e-3, "{alpha}: {error}");
    }
}

#[test]
fn a_mixture_of_the_footprints_own_lobes_has_no_error() {
    let own = [(0.25, lobe(0.3, -0.1, [0.02, 0.005, 0.01])), (0.75, lobe(-0.2, 0.2, [0.04, 0.0, 0.04]))];
    let entries = own.map(|(weight, lobe)| Entry { weight, lobe: SlopeLobe::new(&bent(lobe)) });
    let error = LobeError::new(entries.into_iter(), &own);
    for (j, other) in [(0, 1), (1, 0)] {
        let others = error.others(&[own[other]]);
        let (share, lobe) = own[j];
        assert!(error.of_share(share, lobe, &others) < 2e-3);
        let (other_lobe, half) = (own[other].1, 0.5);
        let mixed = exact(&of_lobes(&own), &of_lobes(&[(half, lobe), (1.0 - half, other_lobe)]));
        let found = f64::from(error.of_share(half, lobe, &others));
        assert!((found / mixed - 1.0).abs() < 0.05, "{found} {mixed}");
        // As a share of 1, others do not matter; and less of it is further off.
        assert!((error.of_share(1.0, lobe, &others) - error.of(lobe)).abs() < 1e-6);
        assert!(error.of_share(share - 0.1, lobe, &others) > 0.1);
    }
}
