//! The published methods show the figures that are known of them: from closed forms of their weights, or measured apart from
//! this code, by prototypes in another language. So what is compared here is what was published.

use std::f64::consts::PI;

use glam::{DMat2, DVec2};
use mipfold::glint::{BIWEIGHT_AREA, SUPPORT2, Tail, normal_quantile, pcg4d, unit};
use rayon::prelude::*;

use crate::measure::moments;
use crate::published::cases::{Case, Free};
use crate::published::{Published, deliot, kemppinen, zirr};

/// Filters of one pixel are so much wider than pixels, for the same area as the library's kernel.
fn widened() -> f64 {
    (BIWEIGHT_AREA * SUPPORT2).sqrt()
}

/// Mean and V* of `ratio`, with errors, for pixels of `2^(phase - 8)` in the method's own terms, turned by `angle`.
fn fixed(ratio: fn(&Published) -> f64, tail: Tail, case: Case, phase: f64, angle: f64, count: u32) -> [[f64; 2]; 2] {
    let values: Vec<_> = (0..count)
        .into_par_iter()
        .map(|n| {
            let width = (phase - 8.0).exp2() / widened();
            ratio(&case.fixed(tail, n, 2, Free { width, angle, share: 0.004, ..Free::new(n, 2) }))
        })
        .collect();
    let (mean, variance) = moments(&values);
    [mean, variance.map(|v| v * case.n_eff)]
}

fn within([found, error]: [f64; 2], expected: f64, slack: f64, what: &str) {
    println!("{what}: {found:.3} +- {error:.3}, expected {expected:.3}");
    assert!((found - expected).abs() < slack + 4.0 * error, "{what}: {found} +- {error}, not {expected}");
}

/// `b = 2^phase`: a tent across, a trapezoid along of plateau `b - 1`, two levels with own flakes.
fn zirr_closed(phase: f64) -> f64 {
    let b = phase.exp2();
    let fine = (1.0 - 1.0 / (3.0 * b)) * (2.0 * b / 3.0);
    (1.0 - phase).powi(2) * fine + phase.powi(2) * (b / 3.0).powi(2)
}

/// Cells without the published twins: levels apart.
fn zirr_without_twins(q: &Published) -> f64 {
    zirr::with_ids(q, |[i, j], level| [(i + (level << 26)) as u32, j as u32])
}

#[test]
fn zirr_and_kaplanyan_lose_variance_to_their_weights() {
    for phase in [0.0, 0.25, 0.5, 0.75] {
        let few = Case { n_eff: 0.3, anisotropy: 1.0 };
        // Above five flakes in every cell, half of the variance, for want of a factor of sqrt 2.
        for (case, share, what) in [(few, 1.0, "few"), (Case { n_eff: 40.0, ..few }, 0.5, "many")] {
            let closed = share * zirr_closed(phase);
            let [mean, variance] = fixed(zirr_without_twins, Tail::Beckmann, case, phase, 0.0, 20_000);
            within(mean, 1.0, 0.002, &format!("Zirr, {what}, phase {phase}, mean"));
            // Counts between two powers of 0.9 lose up to 5 percent.
            within(variance, closed, 0.004 + 0.025 * share, &format!("Zirr, {what}, phase {phase}, V* without twins"));
            let [mean, [found, error]] = fixed(zirr::ratio, Tail::Beckmann, case, phase, 0.0, 20_000);
            within(mean, 1.0, 0.002, &format!("Zirr, {what}, phase {phase}, mean"));
            println!("Zirr, {what}, phase {phase}, V*: {found:.3} +- {error:.3}");
            assert!(found > 0.94 * closed - 4.0 * error && found < 1.35 * closed + 4.0 * error, "{found}, {closed}");
        }
    }
    // Across the axes the bounding box is too large or too small.
    for (anisotropy, expected) in [(1.0, 0.139), (4.0, 0.298), (16.0, 0.340)] {
        let case = Case { n_eff: 0.3, anisotropy };
        let [_, variance] = fixed(zirr_without_twins, Tail::Beckmann, case, 0.0, 0.25 * PI, 20_000);
        within(variance, expected, 0.02, &format!("Zirr, anisotropy {anisotropy} at 45 degrees, V*"));
    }
}

#[test]
fn counts_have_the_errors_that_are_known_of_them() {
    let of = |count: &dyn Fn(f64, f64) -> f64| {
        let side = 400;
        let values: Vec<_> = (0..side * side)
            .map(|i| {
                let h = pcg4d([i, 5, 5, 5]);
                let [u, v] = [i % side, i / side].map(f64::from);
                count((u + unit(h[0])) / f64::from(side), (v + unit(h[1])) / f64::from(side))
            })
            .collect();
        let (mean, variance) = moments(&values);
        (mean[0], variance[0])
    };
    let p = 0.004;
    for (mean, bias, ratio) in [(0.1, -0.05, 0.55), (1.0, 0.06, 0.94), (2.0, 0.12, 1.0), (10.0, 0.05, 1.0)] {
        let count = deliot::Count::new(mean / p, p);
        let (m, v) = of(&|u, w| count.of(u, normal_quantile(w)));
        println!("Deliot & Belcour, {mean} flakes: mean {:.3}, variance {:.3}", m / mean, v / (mean * (1.0 - p)));
        assert!((m / mean - 1.0 - bias).abs() < 0.02, "{mean}: {m}");
        assert!((v / (mean * (1.0 - p)) - ratio).abs() < 0.1, "{mean}: {v}");
    }
    for (mean, ratio) in [(0.1, 0.975), (1.0, 0.975), (4.0, 0.975), (6.0, 0.5), (50.0, 0.5)] {
        let (m, v) = of(&|u, _| zirr::count(mean / p, p, u));
        println!("Zirr & Kaplanyan, {mean} flakes: mean {:.4}, variance {:.3}", m / mean, v / (mean * (1.0 - p)));
        assert!((m / mean - 1.0).abs() < 0.003, "{mean}: {m}");
        assert!((v / (mean * (1.0 - p)) - ratio).abs() < 0.03, "{mean}: {v}");
    }
}

#[test]
fn deliot_and_belcour_keep_the_variance_of_levels_and_lose_that_of_corners() {
    for phase in [0.0, 0.25, 0.5, 0.75] {
        let case = Case { n_eff: 5.0, anisotropy: 1.0 };
        let [mean, variance] = fixed(deliot::ratio, Tail::Ggx, case, phase, 0.0, 20_000);
        let b = phase.exp2();
        // Half of it for corners, 4/9 for boxes, and what levels share out; counts of a few flakes are nearly right.
        let closed = 0.5 * 4.0 / 9.0 * ((1.0 - phase) * b * b + phase * b * b / 4.0);
        within(variance, closed, 0.03, &format!("Deliot, phase {phase}, V*"));
        assert!(mean[0] > 1.02 && mean[0] < 1.14, "{mean:?}");
    }
}

/// By a step of 1/4096 of the chart, all else equal: boxes are interpolated. What pops when lights move is the chance, which
/// follows the lobe, through counts that are rounded.
#[test]
fn deliot_and_belcour_turn_smoothly_at_a_fixed_chance() {
    let case = Case { n_eff: 1.0, anisotropy: 1.0 };
    let mut pops = [Vec::new(), Vec::new()];
    for n in 0..20_000 {
        let free = Free::new(n, 4);
        let step = DVec2::from_angle(f64::from(n)) / 4096.0;
        let q = case.fixed(Tail::Ggx, n, 4, free);
        let fixed = case.fixed(Tail::Ggx, n, 4, Free { y: free.y + step, ..free });
        let moved = Published { flake: q.flake, ..fixed };
        for (pops, to) in pops.iter_mut().zip([fixed, moved]) {
            pops.push((deliot::ratio(&to) - deliot::ratio(&q)).abs());
        }
    }
    let deviation = (0.2 / case.n_eff).sqrt();
    let [fixed, moved] = pops.map(|mut pops| {
        pops.sort_by(f64::total_cmp);
        pops[19_998] / deviation
    });
    println!("Deliot & Belcour, turn: {fixed:.3} at a fixed chance, {moved:.3} at that of the lobe");
    assert!(fixed < 0.15 && moved > 3.0 * fixed, "{fixed}, {moved}");
}

/// Weights add up to 1, and the grids' own angles, ratios and levels to those of the pixel.
#[test]
fn grids_surround_the_pixel() {
    for n in 0..2000 {
        let h = pcg4d([n, 8, 8, 8]);
        let (width, ratio, angle) = ((4.0 * unit(h[0]) - 6.0).exp2(), 1.0 + 15.0 * unit(h[1]), 3.1 * unit(h[2]));
        let turn = DMat2::from_angle(std::f64::consts::FRAC_PI_2 + angle);
        let jacobian = DMat2::from_cols(turn.x_axis * width * ratio, turn.y_axis * width);
        let grids = deliot::grids(jacobian);
        assert!(grids.iter().all(|(_, w)| *w > -1e-12) && grids.iter().filter(|(_, w)| *w > 1e-12).count() <= 4);
        let sum = |of: &dyn Fn([i32; 3]) -> f64| grids.iter().map(|(g, w)| w * of(*g)).sum::<f64>();
        assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-9);
        assert!((sum(&|g| f64::from(g[0])) - width.log2()).abs() < 1e-9);
        assert!((sum(&|g| f64::from(g[1]).exp2()) - ratio).abs() < 1e-6 * ratio);
        let step = |ratio: i32| 0.25 * PI / f64::from(ratio.max(1)).exp2();
        let angles = sum(&|g| f64::from(g[2]) * step(g[1]));
        // Next to no angle, that is half a turn; about the round one there is none.
        if ratio > 2.0 && angle > 0.4 {
            assert!((angles - angle).abs() < 1e-6, "{ratio}, {angle}: {angles}");
        }
    }
}

#[test]
fn kemppinen_et_al_lose_what_lies_beyond_their_cells() {
    let mut pops = Vec::new();
    for (filter, expected) in [(0.5, 0.90), (0.7, 0.95), (1.0, 0.97), (1.2, 0.98)] {
        let case = Case { n_eff: 1.0, anisotropy: 1.0 };
        let pairs: Vec<_> = (0..40_000)
            .into_par_iter()
            .map(|n| {
                let q = case.query(Tail::Ggx, n, 3);
                // 1/256 of the method's own pixel.
                let step = q.jacobian_of(4.0 * PI * filter * filter) * DVec2::from_angle(f64::from(n)) / 256.0;
                let panned = Published { at: q.at + step, ..q };
                (kemppinen::with_filter(&q, filter), kemppinen::with_filter(&panned, filter))
            })
            .collect();
        let (mean, variance) = moments(&pairs.iter().map(|p| p.0).collect::<Vec<_>>());
        let mut changes: Vec<_> = pairs.iter().map(|p| (p.1 - p.0).abs() / variance[0].sqrt()).collect();
        changes.sort_by(f64::total_cmp);
        let pop = changes[changes.len() * 9999 / 10_000];
        println!("Kemppinen, filter {filter}: V* {:.3}, pan {pop:.2}", variance[0]);
        within(mean, expected, 0.015, &format!("Kemppinen, filter {filter}, mean"));
        assert!(variance[0] > 0.6 && variance[0] < 0.9, "{variance:?}");
        pops.push(pop);
    }
    assert!(pops[0] > 0.6 && pops[1] > 0.4 && pops[2] < 0.5 && pops.is_sorted_by(|a, b| a >= b), "{pops:?}");
}
