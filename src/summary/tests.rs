//! What a summary keeps, and how far it is from what it stands for.

use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::ndf::{Lobe, SlopeLobe, disk};
use crate::roughness::Alpha;

fn entry(x: f32, y: f32, alpha: f32, weight: f32) -> Entry {
    let normal = Vec3::new(-x, -y, 1.0).normalize();
    Entry { weight, lobe: SlopeLobe::new(&Lobe::isotropic(normal, Alpha(alpha))) }
}

prop_compose! {
    fn entries()(
        entries in prop::collection::vec((-0.7f32..0.7, -0.7f32..0.7, 0.05f32..0.6, 0.1f32..2.0), 17..80)
    ) -> Vec<Entry> {
        entries.into_iter().map(|(x, y, alpha, weight)| entry(x, y, alpha, weight)).collect()
    }
}

/// Total variation of the NDFs of two sets.
fn distance(a: &[Entry], b: &[Entry]) -> f64 {
    let ndf = |entries: &[Entry]| disk::ndf(entries.iter().map(|e| (e.lobe.lobe(), e.weight)));
    disk::apart(&ndf(a), &ndf(b))
}

proptest! {
    #[test]
    fn weight_and_mean_slope_are_kept(entries in entries(), most in 1usize..16) {
        let mut merged = entries.clone();
        merge_to(&mut merged, most, &mut Scratch::default());
        prop_assert!(merged.len() <= most);
        let sums = |entries: &[Entry]| {
            let weight: f32 = entries.iter().map(|e| e.weight).sum();
            let slope: glam::Vec2 = entries.iter().map(|e| e.lobe.centre * e.weight).sum();
            (weight, slope / weight)
        };
        let ((w, s), (v, t)) = (sums(&entries), sums(&merged));
        prop_assert!((w / v - 1.0).abs() < 1e-5 && s.distance(t) < 1e-5, "{w} {v} {s} {t}");
    }

    #[test]
    fn few_are_left_alone(entries in entries()) {
        let mut merged = entries.clone();
        merge_to(&mut merged, 80, &mut Scratch::default());
        prop_assert_eq!(merged, entries);
    }
}

/// Bounds: of 64 lobes as unlike as they may be, 16 are less than a twentieth away, and 4 less than twice as far.
#[test]
fn a_summary_is_close_to_what_it_stands_for() {
    let mut random = crate::random::Random::new(1, 2);
    let mut uniform = |low: f32, high: f32| low + (high - low) * random.uniform() as f32;
    let mut means = [0.0; 2];
    for _ in 0..20 {
        let entries: Vec<Entry> =
            (0..64).map(|_| entry(uniform(-0.5, 0.5), uniform(-0.5, 0.5), uniform(0.1, 0.5), 1.0)).collect();
        for (mean, most) in means.iter_mut().zip([4, 16]) {
            let mut merged = entries.clone();
            merge_to(&mut merged, most, &mut Scratch::default());
            let apart = distance(&entries, &merged);
            assert!(apart < 0.15, "{most}: {apart}");
            *mean += apart / 20.0;
        }
    }
    assert!(means[1] < 0.05 && means[1] < 0.6 * means[0] && means[0] < 0.1, "{means:?}");
}

#[test]
fn equal_lobes_merge_to_themselves() {
    let one = entry(0.3, -0.2, 0.2, 0.25);
    let mut entries = vec![one; 30];
    merge_to(&mut entries, 4, &mut Scratch::default());
    let [merged] = entries[..] else { panic!("{entries:?}") };
    assert_eq!(merged.lobe, one.lobe);
    assert!((merged.weight - 7.5).abs() < 1e-5);
}
