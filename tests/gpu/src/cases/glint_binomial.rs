//! Cases of `glint_binomial`; its statistics are in `tests/glint.rs`.

use glam::DVec2;

use super::glint::{light, of_kernel, of_pixel, pixel};
use super::glint_chance::{draws, log, uniform};
use super::glint_field::{draw_query, query};
use crate::case::{Bound, Case, SplitMix, Sweep};
use crate::twins::glint_binomial::{self as twin, GlintGrid};

/// Six scalars of an `MfSmoothPoisson`, the mean first.
fn counts(mean: f64) -> [f64; 6] {
    twin::smooth_poisson(mean)
}

/// Thirteen scalars of an `MfGlintGrid`.
fn grid(a: &[f64]) -> GlintGrid {
    GlintGrid {
        home: [a[0] as i32, a[1] as i32],
        own: DVec2::new(a[2], a[3]),
        kernel: super::glint::kernel(&a[4..]),
        level: a[8] as i32,
        sum: a[10],
        squares: a[11],
    }
}

fn of_grid(g: &GlintGrid) -> Vec<f64> {
    let place = [f64::from(g.home[0]), f64::from(g.home[1]), g.own.x, g.own.y];
    let rest = [f64::from(g.level), f64::from(g.level).exp2(), g.sum, g.squares];
    [&place[..], &of_kernel(g.kernel), &rest].concat()
}

/// Pixels with radii of about one to some cells at the level.
fn draw_grid(r: &mut SplitMix) -> (Vec<f64>, f64) {
    let level = (r.bits() % 12) as f64 - 3.0;
    let (size, long) = (log(r, 0.4, 1.5), log(r, 1.0, 8.0));
    let root = long * (size * level.exp2()).powi(2);
    let (pixel, _) = draw_query(r, root * crate::glint::BIWEIGHT_AREA * 0.1, 0.1, long);
    (of_pixel(&pixel), level)
}

pub fn cases() -> Vec<Case> {
    let mut all = counting();
    all.extend(grids());
    all
}

fn counting() -> Vec<Case> {
    let smooth = draws(6000, 51, |r| {
        let mean = f64::from(log(r, 1e-4, 60.0) as f32);
        // The chance of more than k is known to 1e-7, over v.
        let v = if r.bits() % 2 == 0 { uniform(r).max(1e-3) } else { log(r, 1e-3, 1.0) };
        [&counts(mean)[..], &[v]].concat()
    });
    vec![
        Case {
            name: "mf_smooth_poisson",
            // Below a mean of 0.45 the root of many is not used, and 0 within rounding.
            inputs: [Sweep::new(1000).log(1e-6, 0.44).inputs(), Sweep::new(1000).log(0.45, 1e4).inputs()].concat(),
            twin: |a| twin::smooth_poisson(a[0]).to_vec(),
            bound: Bound { absolute: 1e-30, relative: 1e-5 },
        },
        Case {
            name: "mf_nearly_normal",
            inputs: Sweep::new(1000).linear(-1.0, 1.0).inputs(),
            twin: |a| vec![twin::nearly_normal(a[0])],
            // The denominator is 0.11 at the ends.
            bound: Bound { absolute: 0.0, relative: 3e-6 },
        },
        Case {
            name: "mf_smooth_count",
            inputs: smooth,
            twin: |a| vec![twin::smooth_count(a[0], a[6])],
            bound: Bound { absolute: 2e-4, relative: 1e-5 },
        },
        Case {
            name: "mf_glint_words",
            inputs: draws(500, 60, |r| {
                let place = [(r.bits() % 4000) as f64 - 2000.0, (r.bits() % 4000) as f64 - 2000.0];
                [&place[..], &[(r.bits() % 16_777_216) as f64, (r.bits() % 16_777_216) as f64]].concat()
            }),
            twin: |a| twin::glint_words(a[0] as i32, a[1] as i32, a[2] as u32, a[3] as u32).map(f64::from).to_vec(),
            bound: Bound { absolute: 0.0, relative: 0.0 },
        },
        Case {
            name: "mf_glint_chance",
            inputs: draws(500, 61, |r| vec![(r.bits() % 16_777_216) as f64 * 256.0]),
            twin: |a| vec![twin::glint_chance(a[0] as u32)],
            bound: Bound { absolute: 0.0, relative: 2e-7 },
        },
        Case {
            name: "mf_glint_pair",
            inputs: draws(1000, 52, |r| vec![(r.unit() - 0.5) * log(r, 1.0, 1e3), uniform(r)]),
            twin: |a| twin::glint_pair(a[0], a[1]).to_vec(),
            bound: Bound { absolute: 2e-7, relative: 0.0 },
        },
        Case {
            name: "mf_glint_count",
            inputs: draws(2000, 53, |r| {
                let (pixel, level) = draw_grid(r);
                let grid = twin::glint_grid(&super::glint::pixel(&pixel), level as i32);
                let (i, j) = ((r.bits() % 5) as f64 - 2.0, (r.bits() % 5) as f64 - 2.0);
                let widths = [r.unit() * 40.0 - 20.0, r.unit() * 40.0 - 20.0, (r.bits() % 64) as f64];
                let mean = f64::from(log(r, 0.01, 40.0) as f32);
                [&of_grid(&grid)[..], &[i, j], &widths, &counts(mean)].concat()
            }),
            twin: |a| {
                let widths = DVec2::new(a[14], a[15]);
                vec![twin::glint_count(&grid(a), a[12] as i32, a[13] as i32, widths, a[16] as u32, a[17])]
            },
            // Widths of 20 know their box to 2e-6.
            bound: Bound { absolute: 1e-4, relative: 3e-5 },
        },
    ]
}

fn grids() -> Vec<Case> {
    let grid_of = |r: &mut SplitMix| {
        let (pixel, level) = draw_grid(r);
        twin::glint_grid(&super::glint::pixel(&pixel), level as i32)
    };
    let mut centres = draws(3000, 54, |r| {
        let grid = grid_of(r);
        let height = grid.kernel.tensor.z.sqrt();
        [of_grid(&grid), vec![((r.unit() * 2.0 - 1.0) * height).round()]].concat()
    });
    centres.retain(|a| {
        let rounded: Vec<f64> = a.iter().map(|v| f64::from(*v as f32)).collect();
        twin::glint_centres(&grid(&rounded), a[12] as i32).1 > 1e-3
    });
    let mut pixels = draws(2000, 55, |r| {
        let (pixel, level) = draw_grid(r);
        [pixel, vec![level]].concat()
    });
    pixels.retain(|a| a[0].abs() < 1e6 && a[1].abs() < 1e6);
    vec![
        Case {
            name: "mf_glint_centres",
            inputs: centres,
            twin: |a| twin::glint_centres(&grid(a), a[12] as i32).0.to_vec(),
            bound: Bound { absolute: 0.0, relative: 0.0 },
        },
        Case {
            name: "mf_glint_cells",
            inputs: draws(1500, 56, |r| {
                let counting = (r.bits() % 2) as f64;
                let mean = f64::from(log(r, 0.01, 40.0) as f32);
                let more = [counting, r.unit() * 40.0 - 20.0, r.unit() * 40.0 - 20.0, (r.bits() % 64) as f64];
                [&of_grid(&grid_of(r))[..], &more, &counts(mean)].concat()
            }),
            twin: |a| {
                let counting = (a[12] != 0.0).then_some((DVec2::new(a[13], a[14]), a[15] as u32, a[16]));
                twin::glint_cells(&grid(a), counting).to_array().to_vec()
            },
            bound: Bound { absolute: 1e-4, relative: 1e-4 },
        },
        Case {
            name: "mf_glint_grid",
            inputs: pixels,
            twin: |a| of_grid(&twin::glint_grid(&pixel(a), a[8] as i32)),
            // Absolute, so that cells agree.
            bound: Bound { absolute: 2e-3, relative: 0.0 },
        },
        Case {
            name: "mf_glint_grid_variance",
            inputs: draws(500, 57, |r| of_grid(&grid_of(r))),
            twin: |a| vec![twin::glint_grid_variance(&grid(a))],
            bound: Bound { absolute: 0.0, relative: 2e-6 },
        },
        Case {
            name: "mf_glint_grid_ratio",
            inputs: draws(1000, 58, |r| {
                let grid = grid_of(r);
                let density = log(r, 0.01, 40.0) * f64::from(-2 * grid.level).exp2();
                let more = [r.unit() * 40.0 - 20.0, r.unit() * 40.0 - 20.0, (r.bits() % 64) as f64, density];
                [of_grid(&grid), more.to_vec()].concat()
            }),
            twin: |a| vec![twin::glint_grid_ratio(&grid(a), DVec2::new(a[12], a[13]), a[14] as u32, a[15])],
            bound: Bound { absolute: 1e-3, relative: 1e-3 },
        },
        Case {
            name: "mf_glint_binomial",
            inputs: draws(3000, 59, |r| {
                let (n_eff, area, long) = (log(r, 0.1, 3e4), log(r, 1e-4, 0.43), log(r, 1.0, 64.0));
                query(r, n_eff, area, long, r.clone().unit())
            }),
            twin: |a| vec![twin::glint_binomial(&pixel(a), &light(&a[8..]), a[14] as u32, a[15])],
            bound: Bound { absolute: 1e-3, relative: 1e-3 },
        },
    ]
}
