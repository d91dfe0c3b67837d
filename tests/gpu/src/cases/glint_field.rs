//! Cases of `glint_field`. What is a whole number agrees in every bit. The statistics of many queries, from uv to g, are in
//! `tests/glint.rs`.

use glam::{DVec2, DVec3};

use super::glint::{draw_kernel, kernel, light, of_kernel, of_light, of_pixel, pixel};
use super::glint_chance::{EXACT, draws, log, words};
use crate::case::{Bound, Case, SplitMix, Sweep};
use crate::glint::{BIWEIGHT_AREA, Ellipse};
use crate::twins::glint::{GlintKernel, GlintLight, GlintPixel};
use crate::twins::glint_field as twin;

/// A whole number of 32 bits, of any size and sign.
pub fn whole(r: &mut SplitMix) -> f64 {
    let v = (r.bits() >> 32) as u32 as i32;
    f64::from(v >> (r.bits() % 32))
}

fn cell(a: &[f64]) -> [i32; 2] {
    [a[0] as i32, a[1] as i32]
}

fn digits(r: &mut SplitMix, k: u32) -> [f64; 2] {
    [(); 2].map(|()| ((r.bits() >> 40) as u32 & ((1 << k) - 1)).into())
}

/// A pixel with this many effective flakes for a light of this area, as long as `anisotropy` times its width.
pub fn draw_query(r: &mut SplitMix, n_eff: f64, area: f64, anisotropy: f64) -> (GlintPixel, GlintLight) {
    let root = n_eff / (BIWEIGHT_AREA * area);
    let (long, short) = ((root * anisotropy).sqrt(), (root / anisotropy).sqrt());
    let (x, y) = (DVec2::from_angle(7.0 * r.unit()) * long, short);
    let across = x.perp().normalize() * y;
    let e = Ellipse {
        xx: x.x * x.x + across.x * across.x,
        xy: x.x * x.y + across.x * across.y,
        yy: x.y * x.y + across.y * across.y,
    };
    let kernel = GlintKernel { tensor: DVec3::new(e.xx, e.xy, e.yy), root };
    let cell = [whole(r) as i32, whole(r) as i32];
    let mut unit = || f64::from(r.unit() as f32);
    let pixel = GlintPixel { cell, within: DVec2::new(unit(), unit()), kernel };
    let light = GlintLight { y: DVec2::new(unit(), unit()), area, widths: DVec2::new(unit(), unit()) * 50.0 - 25.0 };
    (pixel, light)
}

/// Scalars of an evaluator's arguments.
pub fn query(r: &mut SplitMix, n_eff: f64, area: f64, anisotropy: f64, variation: f64) -> Vec<f64> {
    let (pixel, light) = draw_query(r, n_eff, area, anisotropy);
    let seed = (r.bits() % 64) as f64;
    [of_pixel(&pixel), of_light(&light), vec![1.0, seed, variation, 1.0, 1.0, 1.0, 0.0]].concat()
}

/// All of them.
pub fn cases() -> Vec<Case> {
    let mut all = net();
    all.extend(boxes());
    all.extend(sums());
    all
}

fn net() -> Vec<Case> {
    let word = |r: &mut SplitMix| f64::from((r.bits() >> 32) as u32);
    vec![
        Case {
            name: "mf_glint_net",
            inputs: Sweep::new(500).integer(0, u32::MAX).integer(0, 15).inputs(),
            twin: |a| twin::glint_net(a[0] as u32, a[1] as u32).map(f64::from).to_vec(),
            bound: EXACT,
        },
        Case {
            name: "mf_glint_mix",
            inputs: draws(20_000, 31, |r| vec![whole(r), whole(r), word(r), word(r)]),
            twin: |a| vec![twin::glint_mix(cell(a), a[2] as u32, a[3] as u32).into()],
            bound: EXACT,
        },
        Case {
            name: "mf_glint_permutation",
            inputs: draws(5000, 32, |r| {
                let level = (r.bits() % 12) as u32;
                let [a, b] = digits(r, 11 - level);
                vec![word(r), level.into(), whole(r), whole(r), a, b]
            }),
            twin: |a| {
                twin::glint_permutation(a[0] as u32, a[1] as i32, cell(&a[2..]), words(&a[4..])).map(f64::from).to_vec()
            },
            bound: EXACT,
        },
        Case {
            name: "mf_glint_digits",
            inputs: draws(20_000, 33, |r| {
                let k = (r.bits() % 13) as u32;
                let [a, b] = digits(r, k);
                let to = k + (r.bits() % (13 - u64::from(k))) as u32;
                vec![word(r), whole(r), whole(r), k.into(), to.into(), a, b]
            }),
            twin: |a| {
                twin::glint_digits(a[0] as u32, cell(&a[1..]), a[3] as i32, a[4] as i32, words(&a[5..]))
                    .map(f64::from)
                    .to_vec()
            },
            bound: EXACT,
        },
        Case {
            name: "mf_glint_cell",
            inputs: draws(20_000, 34, |r| {
                let k = (r.bits() % 13) as u32;
                let [a, b] = digits(r, k);
                // Blocks of this level.
                let mut block = || f64::from((whole(r) as i32) >> k);
                let (x, y) = (block(), block());
                vec![word(r), k.into(), x, y, a, b]
            }),
            twin: |a| twin::glint_cell(a[0] as u32, a[1] as i32, cell(&a[2..]), words(&a[4..])).map(f64::from).to_vec(),
            bound: EXACT,
        },
        Case {
            name: "mf_glint_flake",
            inputs: draws(20_000, 35, |r| vec![word(r), (r.bits() % 8) as f64, whole(r), whole(r)]),
            twin: |a| {
                let flake = twin::glint_flake(a[0] as u32, a[1] as u32, cell(&a[2..]));
                vec![flake.place.x, flake.place.y, flake.y.x, flake.y.y, flake.mark]
            },
            // Directions are rounded to 24 bits; the rest is exact.
            bound: Bound { absolute: 6.1e-8, relative: 0.0 },
        },
    ]
}

fn boxes() -> Vec<Case> {
    let rows = |r: &mut SplitMix| {
        let side = f64::from(1u32 << (r.bits() % 6));
        let (x, y) = (r.unit() * side, r.unit() * side);
        (draw_kernel(r), DVec2::new(x, y), side)
    };
    let mut row = draws(4000, 36, |r| {
        let (kernel, centre, side) = rows(r);
        let rows = twin::glint_rows(kernel, centre, side).map(|v| f64::from(v as f32));
        let (low, high) = ((rows[1] - rows[3]).floor(), (rows[1] + rows[3]).floor());
        [&rows[..], &[(low + r.unit() * (high - low + 1.0)).floor()]].concat()
    });
    // Where a row ends within rounding of a box's side, what is missed weighs nothing, but the numbers differ.
    row.retain(|a| {
        let ends = |step: f64| {
            let mut rows: [f64; 7] = std::array::from_fn(|i| a[i]);
            rows[0] += step;
            rows[1] += 0.3 * step;
            twin::glint_row(rows, a[7] as i64)
        };
        let steps = [-2e-3, 2e-3, 0.0];
        steps.iter().all(|s| ends(*s).is_some() && ends(*s) == ends(0.0))
    });
    let mut boxes = draws(2000, 37, |r| vec![r.unit(), log(r, 2.4e-5, 0.5), f64::from(1u32 << (r.bits() % 13))]);
    boxes.retain(|a| {
        let at = |step: f64| twin::glint_boxes(a[0] + step, a[1], a[2] as i64);
        at(-3e-7) == at(3e-7)
    });
    let mut levels = draws(2000, 38, |r| vec![log(r, 1e-4, 1e13), log(r, 2.4e-5, 0.5)]);
    levels.retain(|a| (twin::glint_level(a[0], a[1]).fract() - 0.5).abs() > 1e-4);
    vec![
        Case {
            name: "mf_glint_rows",
            inputs: draws(2000, 39, |r| {
                let (kernel, centre, side) = rows(r);
                [&of_kernel(kernel)[..], &[centre.x, centre.y, side]].concat()
            }),
            twin: |a| twin::glint_rows(kernel(a), DVec2::new(a[4], a[5]), a[6]).to_vec(),
            // The twin's tensor of a long ellipse has the root's area.
            bound: Bound { absolute: 1e-4, relative: 2e-5 },
        },
        Case {
            name: "mf_glint_row",
            inputs: row,
            twin: |a| {
                let ends = twin::glint_row(std::array::from_fn(|i| a[i]), a[7] as i64).expect("a row");
                ends.map(|v| v as f64).to_vec()
            },
            bound: EXACT,
        },
        Case {
            name: "mf_glint_boxes",
            inputs: boxes,
            twin: |a| twin::glint_boxes(a[0], a[1], a[2] as i64).map(|v| v as f64).to_vec(),
            bound: EXACT,
        },
        Case {
            name: "mf_glint_apart",
            inputs: Sweep::new(500).linear(-8190.0, 8190.0).edges(&[0.0]).inputs(),
            twin: |a| vec![twin::glint_apart(a[0])],
            bound: Bound { absolute: 1e-3, relative: 0.0 },
        },
        Case {
            name: "mf_glint_level",
            inputs: levels,
            twin: |a| vec![twin::glint_level(a[0], a[1]).round()],
            bound: EXACT,
        },
    ]
}

fn sums() -> Vec<Case> {
    vec![
        Case {
            name: "mf_glint_even_variance",
            inputs: Sweep::new(500).log(1e-6, 10.0).log(1.0, 64.0).inputs(),
            twin: |a| vec![twin::glint_even_variance(a[0], a[1])],
            bound: Bound { absolute: 0.0, relative: 1e-6 },
        },
        Case {
            name: "mf_glint_exponent",
            inputs: Sweep::new(500).log(1e-6, 20.0).edges(&[0.0, -1.0]).inputs(),
            twin: |a| vec![twin::glint_exponent(a[0])],
            bound: Bound { absolute: 0.0, relative: 1e-6 },
        },
        Case {
            name: "mf_glint_layer",
            inputs: draws(1500, 40, |r| {
                let (n_eff, area) = (log(r, 0.1, 6.0), log(r, 1e-3, 0.43));
                let (layer, long) = ((r.bits() % 4) as f64, log(r, 1.0, 20.0));
                let (pixel, light) = draw_query(r, n_eff * (2.0 * layer).exp2(), area, long);
                [of_pixel(&pixel), of_light(&light), vec![(r.bits() % 9) as f64, layer, 2.0 * r.unit()]].concat()
            }),
            twin: |a| vec![twin::glint_layer(&pixel(a), &light(&a[8..]), a[13] as u32, a[14] as u32, a[15])],
            // g is up to some tens here; its deviation is 0.4 to 3.
            bound: Bound { absolute: 1e-3, relative: 1e-3 },
        },
        Case {
            name: "mf_glint_field",
            inputs: draws(4000, 41, |r| {
                let (n_eff, area) = (log(r, 0.1, 3e4), log(r, 1e-4, 0.43));
                let (long, varied) = (log(r, 1.0, 64.0), if r.unit() < 0.7 { 0.0 } else { 2.0 * r.unit() });
                query(r, n_eff, area, long, varied)
            })
            .into_iter()
            // Nothing can be asked.
            .chain([[&[0.0; 8][..], &[0.5, 0.5, 0.1, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0]].concat()])
            .collect(),
            twin: |a| {
                if a[7] * a[10] <= 0.0 {
                    return vec![1.0];
                }
                vec![twin::glint_field(&pixel(a), &light(&a[8..]), a[14] as u32, a[15])]
            },
            bound: Bound { absolute: 1e-3, relative: 1e-3 },
        },
    ]
}
