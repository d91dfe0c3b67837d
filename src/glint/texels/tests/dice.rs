//! Dice: each part has its own, they are fixed to the map, and what they choose is right on average.

use std::collections::HashSet;

use super::*;
use crate::glint::hash::pcg4d;
use crate::glint::texels::Tails;
use crate::glint::texels::chance::{Die, Path};

/// Blocks of all levels, cells, and all their pieces to a depth, and some at the greatest: no two have a die in common.
#[test]
fn no_two_parts_share_a_die() {
    let mut words = HashSet::new();
    let mut count = 0;
    let mut add = |die: Die| {
        for salt in [0, 1] {
            count += 1;
            assert!(words.insert(pcg4d(die.words(salt))), "{die:?}");
        }
    };
    for cell in [[0, 0], [1, 0], [0, 1], [2, 6], [4096, 8192], [16_382, 16_382]] {
        (1..=15).for_each(|level| add(Die::Block(cell, level)));
        let mut paths = vec![Path::CELL];
        for depth in 0..=12 {
            for path in &paths {
                (0..3).for_each(|k| add(Die::Piece(cell, path.die(k))));
            }
            // All to the fifth, then the way down to each corner.
            let quarters = |path: &Path| [0, 1, 2, 3].map(|k| path.quarter(k));
            paths = match depth {
                0..=4 => paths.iter().flat_map(quarters).collect(),
                5 => [0, 500, 600, 1023].iter().flat_map(|k| quarters(&paths[*k])).collect(),
                _ => paths.iter().enumerate().map(|(k, path)| path.quarter(k as u32 & 3)).collect(),
            };
        }
    }
    assert_eq!(words.len(), count);
    assert!(count > 40_000);
}

/// A query with other dice.
fn salted<'a>(glints: &'a TexelGlints, footprint: &'a Footprint, h: DVec3, salt: u32) -> Query<'a> {
    let mut query = Query::new(&glints.slopes, &glints.pyramid, footprint, h, Tails::Kept).unwrap();
    query.chance.salt = salt;
    query
}

fn mean(of: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = of.len() as f64;
    of.sum::<f64>() / count
}

/// At a given tolerance the mean over many dice is the exact sum, in which blocks within blocks, cells within those
/// and pieces within cells have been looked into.
#[test]
fn a_tolerance_has_the_exact_sum_for_its_mean() {
    let (mut worst, mut all) = (0.0f64, Vec::new());
    for (map, alpha, width, reach) in [
        (maps::spikes(64, 0.3), 0.1, 8.0, 0.3),
        (maps::spikes(64, 0.3), 0.02, 12.0, 0.3),
        (maps::bumps(64, 0.2), 0.05, 16.0, 0.2),
        (maps::scratches(64, 0.3), 0.1, 16.0, 0.2),
    ] {
        let glints = glints(&map, alpha);
        let j = jacobian((width, 0.8 * width), 0.4, (64, 64));
        for k in 0..3 {
            let r = |i| maps::noise(51, k, i);
            let h = half_vector(reach * (2.0 * DVec2::new(r(0), r(1)) - 1.0));
            let footprint = glints.footprint(DVec2::new(r(2), r(3)), j).unwrap();
            let exact = salted(&glints, &footprint, h, 0).sum();
            let sums: Vec<f64> = (0..200)
                .map(|salt| {
                    let mut query = salted(&glints, &footprint, h, salt);
                    (query.chance.tau, query.chance.guess) = (0.01 * exact, exact);
                    query.sum() / exact - 1.0
                })
                .collect();
            let off = mean(sums.iter().copied());
            let deviation = mean(sums.iter().map(|d| (d - off).powi(2))).sqrt();
            assert!(deviation > 1e-3, "{deviation}");
            let t = off / (deviation / 200f64.sqrt());
            println!("alpha {alpha} width {width}: mean {off:8.1e}, deviation {deviation:.1e}: {t:5.2}");
            worst = worst.max(t.abs());
            all.push(t);
        }
    }
    let square = mean(all.iter().map(|t| t * t));
    println!("mean square of {} means over their deviations {square:.2}", all.len());
    // Chances of 1e-3 and less, were all well.
    assert!(worst < 4.2 && square < 2.7, "{worst} {square}");
}

/// One step of a pan over the edges of a map is as small as one beside them: the same parts are looked into.
#[test]
fn a_pan_over_the_edge_of_a_map_is_continuous() {
    let glints = glints(&maps::spikes(64, 0.3), 0.05);
    let j = jacobian((16.0, 16.0), 0.3, (64, 64));
    let mut chosen = 0;
    for (k, at) in [(1.0, 0.37), (0.0, 0.61), (0.43, 1.0), (0.72, 0.0), (1.0, 1.0), (-3.0, 7.0)].into_iter().enumerate()
    {
        let at = DVec2::from(at);
        for i in 0..4 {
            let r = |n| maps::noise(61, 4 * k as i64 + i, n);
            let h = half_vector(0.25 * (2.0 * DVec2::new(r(0), r(1)) - 1.0));
            let d = |x: f64| glints.ndf(at + x / 64.0 * DVec2::ONE, j, h);
            let footprint = glints.footprint(at, j).unwrap();
            chosen += usize::from((d(0.0) / ask(&glints, &footprint, h, Ways::BEST).0 - 1.0).abs() > 1e-4);
            // In texels: less than it takes to move a chance across a die.
            let (before, after) = (d(-1e-7), d(1e-7));
            assert!((after / before - 1.0).abs() < 1e-5, "{at} {h}: {before} {after}");
        }
    }
    assert!(chosen > 12, "sums that dice had a part in: {chosen}");
}

/// Frame by frame over the edge, steps are those of the exact sum and a few spreads.
#[test]
fn frames_over_the_edge_of_a_map_follow_each_other() {
    let glints = glints(&maps::spikes(64, 0.3), 0.05);
    let j = jacobian((16.0, 16.0), 0.3, (64, 64));
    let (mut at_edge, mut elsewhere) = (0.0f64, 0.0f64);
    for i in 0..6 {
        let r = |n| maps::noise(71, i, n);
        let h = half_vector(0.25 * (2.0 * DVec2::new(r(0), r(1)) - 1.0));
        let d: Vec<f64> =
            (-20..=20).map(|k| glints.ndf(DVec2::new(1.0 + (f64::from(k) - 0.5) / 4096.0, r(2)), j, h)).collect();
        for (k, pair) in d.windows(2).enumerate() {
            let step = (pair[1] / pair[0] - 1.0).abs();
            if k == 20 { at_edge = at_edge.max(step) } else { elsewhere = elsewhere.max(step) }
        }
    }
    println!("steps of a 256th of a pixel: at the edge {at_edge:.1e}, elsewhere {elsewhere:.1e}");
    assert!(at_edge <= elsewhere && at_edge < 3e-3, "{at_edge} {elsewhere}");
}
