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

/// Of three in a row, of which one lies at the mean: a third of the weight is there, so that `E|d| E[d d^T / |d|]` is 4/9 of
/// the squared distance.
#[test]
fn a_lobe_at_the_mean_is_as_any_other() {
    for weight in [1e-3, 1.0, 1e3, 1e7] {
        let mut entries: Vec<Entry> = [-0.3, 0.0, 0.3].map(|x| entry(x, 0.0, 0.2, weight)).into();
        // Equal but for their place.
        entries.iter_mut().for_each(|e| e.lobe.scatter = entry(0.0, 0.0, 0.2, 1.0).lobe.scatter);
        let (apart, own) = (entries[0].lobe.centre.x.powi(2), entries[0].lobe.scatter);
        merge_to(&mut entries, 1, &mut Scratch::default());
        let [merged] = entries[..] else { panic!("{entries:?}") };
        let scatter = merged.lobe.scatter;
        assert!(merged.lobe.centre.length() < 1e-6, "{merged:?}");
        assert!(
            (scatter.xx - own.xx - 4.0 / 9.0 * apart).abs() < 1e-6 && (scatter.yy - own.yy).abs() < 1e-6,
            "{merged:?}"
        );
    }
}

/// What is close together beside the distance to others is told apart all the same.
#[test]
fn tight_groups_far_apart_are_cut_as_they_would_be_alone() {
    // Of 0 and -0 alike.
    let places = |entries: &[Entry]| {
        let bits = |e: &Entry| e.lobe.centre.to_array().map(|v| (v + 0.0).to_bits());
        let mut places: Vec<_> = entries.iter().map(bits).collect();
        places.sort_unstable();
        places.dedup();
        places
    };
    for offset in 0..50 {
        let group = |x: f32| {
            let x = x + 0.003 * offset as f32;
            (0..20).map(move |i| entry(x + 1e-5 * (i % 4) as f32, 1e-5 * (i % 2) as f32, 1e-5, 1.0))
        };
        let mut entries: Vec<Entry> = group(-0.5).chain(group(0.5)).collect();
        let expected = places(&entries);
        merge_to(&mut entries, 8, &mut Scratch::default());
        assert_eq!(places(&entries), expected, "{offset}");
    }
}
