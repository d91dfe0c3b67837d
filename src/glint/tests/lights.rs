//! Directions are independent of one another: two lights at once, and a light that moves.

use glam::DVec2;
use rayon::prelude::*;

use super::{Case, correlation};
use crate::glint::net::Net;
use crate::glint::{evaluator, pcg4d, unit};

/// Two lights that share no flake, at the same pixel: correlation of the ratios within 0.02, the lights' share of all
/// directions and 4 standard errors. Flakes that answer one do not answer the other, so the field's is below 0 by such a
/// share.
fn two_lights(count: u32) {
    for name in ["field", "binomial"] {
        let ratio = evaluator(name).unwrap().ratio;
        for (n_eff, area) in [(0.1, 0.004), (0.3, 0.004), (1.0, 0.004), (4.0, 0.004), (0.5, 0.03)] {
            let pairs: Vec<_> = (0..count)
                .into_par_iter()
                .map(|n| {
                    let mut p = Case::round(n_eff, area).probe(n, 71);
                    let first = ratio(&p);
                    // From just beyond two radii to half the chart.
                    let h = pcg4d([n, 7, 1, 7]);
                    let far = 2.0 * p.radius() + (0.5 - 2.0 * p.radius()).max(0.0) * unit(h[0]);
                    let step = DVec2::from_angle(7.0 * unit(h[1])) * far;
                    p.y = (p.y + step).fract_gl();
                    p.widths += step / area.sqrt();
                    (first, ratio(&p))
                })
                .collect();
            let found = correlation(&pairs);
            let error = 1.0 / f64::from(count).sqrt();
            eprintln!("{name}, N_eff {n_eff}, area {area}: correlation of two lights {found:.4} +- {error:.4}");
            assert!(found.abs() < 0.02 + area + 4.0 * error, "{name}, N_eff {n_eff}: {found}");
        }
    }
}

#[test]
fn two_lights_are_independent() {
    two_lights(10_000);
}

#[test]
#[ignore = "samples of 200000"]
fn two_lights_are_independent_at_length() {
    two_lights(200_000);
}

/// How often a flake in box A of the chart has a neighbour, `step` cells away, in box B, over what chance makes of it: the
/// standard deviation over all A and B without that of the counts, and the largest. Boxes of side 1/16, cells of a square
/// of 512.
pub(super) fn pairs_of_neighbours(flake: impl Fn([i32; 2]) -> glam::DVec2 + Sync, step: [i32; 2]) -> (f64, f64) {
    let (side, boxes) = (512, 256);
    let number = |cell| {
        let y = flake(cell) * 16.0;
        y.x as usize * 16 + y.y as usize
    };
    let mut counts = vec![0u32; boxes * boxes];
    for i in 0..side {
        for j in 0..side {
            counts[number([i, j]) * boxes + number([i + step[0], j + step[1]])] += 1;
        }
    }
    let mean = f64::from(side * side) / counts.len() as f64;
    let variance = counts.iter().map(|c| (f64::from(*c) / mean - 1.0).powi(2)).sum::<f64>() / counts.len() as f64;
    let largest = f64::from(*counts.iter().max().unwrap()) / mean;
    ((variance - 1.0 / mean).max(0.0).sqrt(), largest)
}

/// What evenly filled nets cannot avoid, and no more: two of the four flakes of a block never share a quarter of the
/// chart, so half of the neighbours have chance 0 in a quarter of all cases and 4/3 else, a deviation of 0.29, and blocks of
/// four cells add a little.
#[test]
fn neighbours_hold_no_fixed_pairs_of_directions() {
    for step in [[1, 0], [0, 1], [1, 1], [2, 0], [-3, 2], [64, 0]] {
        let net = Net::new(5, 0);
        let (deviation, largest) = pairs_of_neighbours(|cell| net.flake(cell).y, step);
        let (of_chance, largest_of_chance) = pairs_of_neighbours(
            |cell| {
                let h = pcg4d([cell[0] as u32, cell[1] as u32, 1, 1]);
                glam::DVec2::new(unit(h[0]), unit(h[1]))
            },
            step,
        );
        eprintln!(
            "step {step:?}: deviation {deviation:.3} (chance {of_chance:.3}), largest {largest} ({largest_of_chance})"
        );
        assert!(deviation < 0.4, "{step:?}: {deviation}");
        // Counts of 4 on average over 65536 pairs: 18 at most for chance, and some more for half the pairs at 4/3.
        assert!(largest < 8.0, "{step:?}: {largest}");
    }
}

/// How often answering flakes stand so far apart, over what independent flakes do, in bins of half of the mean spacing out
/// to six of them. The half vector turns across the surface, once through the chart in `cells` cells, as on a sphere.
fn pairs_over_chance(cells: f64, radius: f64, side: i32) -> Vec<(i32, i32, f64, f64)> {
    const MOST: i32 = 12;
    let net = Net::new(3, 0);
    let answering = |i: i32, j: i32| {
        let flake = net.flake([i, j]);
        let place = DVec2::new(f64::from(i), f64::from(j)) + flake.place;
        let d = flake.y - (DVec2::from_angle(0.4).rotate(place) / cells + DVec2::new(0.37, 0.61));
        ((d - d.round()).length() < radius).then_some(place)
    };
    let places: Vec<DVec2> = (0..side).flat_map(|j| (0..side).filter_map(move |i| answering(i, j))).collect();
    let spacing = (1.0 / std::f64::consts::PI).sqrt() / radius;
    let (bin, end) = (0.5 * spacing, f64::from(side));
    let reach = (f64::from(MOST) + 0.5) * bin;
    let inner: Vec<_> = places.iter().filter(|p| p.min_element() > reach && p.max_element() < end - reach).collect();
    let width = 2 * MOST + 1;
    let mut counts = vec![0.0; (width * width) as usize];
    for from in &inner {
        for d in places.iter().map(|to| (*to - **from) / bin).filter(|d| d.abs().max_element() < f64::from(MOST) + 0.5)
        {
            let (x, y) = (d.x.round() as i32, d.y.round() as i32);
            if d != DVec2::ZERO {
                counts[((y + MOST) * width + x + MOST) as usize] += 1.0;
            }
        }
    }
    let expected = inner.len() as f64 * places.len() as f64 / (end * end) * bin * bin;
    let place = |i: i32| (i % width - MOST, i / width - MOST);
    counts.iter().zip(0..).map(|(c, i)| (place(i).0, place(i).1, c / expected, expected)).collect()
}

/// On flat and curved surfaces glints make no lines and no lattice: two glints stand any distance apart as often as chance
/// has it, within 5 standard errors in each of some 570 bins, but for close ones, which are half as frequent: evenly filled
/// flakes keep apart.
#[test]
fn glints_make_no_patterns() {
    for cells in [1e9, 2500.0, 600.0, 150.0] {
        for bin in pairs_over_chance(cells, 0.05, 512) {
            let (x, y, ratio, expected) = bin;
            if x * x + y * y > 16 {
                assert!((ratio - 1.0).abs() * expected.sqrt() < 5.0, "{cells} cells: {bin:?}");
            } else if (x, y) == (0, 0) {
                assert!((0.3..0.7).contains(&ratio), "{cells} cells: {bin:?}");
            }
        }
    }
}
