//! Cases of `glint`.

use glam::{DMat2, DVec2, DVec3};

use super::glint_chance::{draws, log};
use crate::case::{Bound, Case, SplitMix, Sweep};
use crate::glint::{FlakeDensity, Flakes, Light, Macro, SolidAngle, Streak, Tail};
use crate::ndf::RoughnessTensor;
use crate::twins::glint::{self as twin, GlintKernel, GlintLight, GlintPixel};

fn two(a: &[f64]) -> DVec2 {
    DVec2::from_slice(a)
}

fn three(a: &[f64]) -> DVec3 {
    DVec3::from_slice(a)
}

fn tail(v: f64) -> Tail {
    if v == 0.0 { Tail::Ggx } else { Tail::Beckmann }
}

/// Six scalars of an `MfGlintLobe`.
fn lobe(a: &[f64]) -> Macro {
    let roughness = RoughnessTensor { xx: a[2] as f32, xy: a[3] as f32, yy: a[4] as f32 };
    Macro { mean: two(a), roughness, tail: tail(a[5]) }
}

/// Four scalars of an `MfGlintKernel`.
pub fn kernel(a: &[f64]) -> GlintKernel {
    GlintKernel { tensor: three(a), root: a[3] }
}

/// Scalars of a kernel.
pub fn of_kernel(k: GlintKernel) -> [f64; 4] {
    [k.tensor.x, k.tensor.y, k.tensor.z, k.root]
}

/// Eight scalars of an `MfGlintPixel`.
pub fn pixel(a: &[f64]) -> GlintPixel {
    GlintPixel { cell: [a[0] as i32, a[1] as i32], within: two(&a[2..]), kernel: kernel(&a[4..]) }
}

/// Scalars of a pixel.
pub fn of_pixel(p: &GlintPixel) -> Vec<f64> {
    let place = [f64::from(p.cell[0]), f64::from(p.cell[1]), p.within.x, p.within.y];
    [place, of_kernel(p.kernel)].concat()
}

/// Five scalars of an `MfGlintLight`.
pub fn light(a: &[f64]) -> GlintLight {
    GlintLight { y: two(a), area: a[2], widths: two(&a[3..]) }
}

/// Scalars of a light.
pub fn of_light(l: &GlintLight) -> Vec<f64> {
    vec![l.y.x, l.y.y, l.area, l.widths.x, l.widths.y]
}

/// Seven scalars of an `MfFlakes`.
pub fn flakes(a: &[f64]) -> Flakes {
    Flakes {
        density: FlakeDensity(a[0] * a[0]),
        lobe: SolidAngle(0.0),
        seed: a[1] as u32,
        size_variation: a[2],
        share: 1.0,
        coverage: a[3],
        streak: Some(Streak { ratio: a[4], angle: a[6].atan2(a[5]) }),
    }
}

/// A lobe: two widths from 0.01 to 1, ten to one at most.
pub fn draw_lobe(r: &mut SplitMix) -> Vec<f64> {
    let (wide, turn) = (log(r, 0.02, 1.0), r.unit() * 3.2);
    let narrow = wide * log(r, 0.1, 1.0);
    let (sin, cos) = turn.sin_cos();
    let (low, more) = (narrow * narrow, wide * wide - narrow * narrow);
    let mean = if r.unit() < 0.5 { [0.0, 0.0] } else { [r.unit() - 0.5, r.unit() - 0.5] };
    let beckmann = if r.unit() < 0.5 { 1.0 } else { 0.0 };
    vec![mean[0], mean[1], low + more * cos * cos, more * sin * cos, low + more * sin * sin, beckmann]
}

/// A kernel with axes of up to 30 cells, round and long.
pub fn draw_kernel(r: &mut SplitMix) -> GlintKernel {
    let angle = r.unit() * 3.2;
    let along = DVec2::from_angle(angle) * log(r, 0.02, 20.0);
    let across = DVec2::from_angle(angle + 1.0 + r.unit()) * log(r, 0.02, 20.0);
    let size = if r.unit() < 0.7 { 0.757 } else { log(r, 0.01, 0.757) };
    twin::glint_kernel(DMat2::from_cols(along, across), size).expect("finite")
}

/// Inputs with a rest that no rounding takes to a whole number.
fn firm(calls: Vec<Vec<f64>>, rest: impl Fn(&[f64]) -> f64, margin: f64) -> Vec<Vec<f64>> {
    let rounded = |a: &Vec<f64>| a.iter().map(|v| f64::from(*v as f32)).collect::<Vec<f64>>();
    calls.into_iter().filter(|a| (margin..1.0 - margin).contains(&rest(&rounded(a)))).collect()
}

/// All of them.
pub fn cases() -> Vec<Case> {
    let mut all = chart();
    all.extend(places());
    all
}

fn chart() -> Vec<Case> {
    let direction = |r: &mut SplitMix| {
        let (z, turn) = (if r.unit() < 0.2 { log(r, 1e-5, 0.1) } else { 1.0 - 0.999 * r.unit() }, r.unit() * 6.3);
        let p = (1.0 - z * z).sqrt();
        [p * turn.cos(), p * turn.sin(), z]
    };
    let small = |sweep: Sweep| sweep.signed_log(1e-5, 0.05).signed_log(1e-5, 0.05).signed_log(1e-5, 0.05);
    vec![
        Case {
            name: "mf_disk_to_square",
            inputs: Sweep::new(2000).disk().inputs(),
            twin: |a| twin::disk_to_square(two(a)).to_array().to_vec(),
            bound: Bound { absolute: 3e-7, relative: 0.0 },
        },
        Case {
            name: "mf_square_to_disk",
            inputs: Sweep::new(2000).linear(0.0, 1.0).edges(&[0.5]).linear(0.0, 1.0).edges(&[0.5]).inputs(),
            twin: |a| twin::square_to_disk(two(a)).to_array().to_vec(),
            bound: Bound { absolute: 4e-7, relative: 0.0 },
        },
        Case {
            name: "mf_glint_factor",
            inputs: draws(1000, 11, |r| draw_lobe(r)[2..5].to_vec()).into_iter().chain([vec![0.0; 3]]).collect(),
            twin: |a| twin::glint_factor(three(a)).to_array().to_vec(),
            // Of a tensor ten to one, a hundredth is left of a difference.
            bound: Bound { absolute: 1e-7, relative: 3e-5 },
        },
        Case {
            name: "mf_glint_point",
            inputs: draws(4000, 12, |r| [draw_lobe(r), direction(r).to_vec()].concat()),
            twin: |a| {
                let (y, density) = twin::glint_point(&lobe(a), three(&a[6..])).expect("finite");
                vec![y.x, y.y, density]
            },
            // As the factor; and exponentials of far slopes.
            bound: Bound { absolute: 5e-6, relative: 1e-4 },
        },
        Case {
            name: "mf_glint_normal",
            inputs: draws(2000, 13, |r| [draw_lobe(r), vec![0.02 + 0.96 * r.unit(), 0.02 + 0.96 * r.unit()]].concat()),
            twin: |a| twin::glint_normal(&lobe(a), two(&a[6..])).expect("finite").to_array().to_vec(),
            // 1 - u loses digits towards the rim.
            bound: Bound { absolute: 1e-5, relative: 0.0 },
        },
        Case {
            name: "mf_flake_solid_angle",
            inputs: Sweep::new(300).linear(0.0, 1.0).integer(0, 1).inputs(),
            twin: |a| vec![twin::flake_solid_angle(a[0], tail(a[1]))],
            bound: Bound { absolute: 1e-9, relative: 1e-6 },
        },
        Case {
            name: "mf_cone_solid_angle",
            inputs: Sweep::new(500).linear(0.0, 3.1).edges(&[0.004_65, 0.1]).inputs(),
            twin: |a| vec![twin::cone_solid_angle(a[0])],
            bound: Bound { absolute: 1e-8, relative: 5e-6 },
        },
        Case {
            name: "mf_glint_half_vectors",
            inputs: small(small(Sweep::new(2000).log(1e-6, 0.1).log(1e-6, 0.5).linear(-1.0, 1.0))).inputs(),
            twin: |a| {
                let mut light = Light::new(SolidAngle(a[1]), a[2]);
                light.half_vector_per_pixel = [three(&a[3..]), three(&a[6..])];
                vec![twin::glint_half_vectors(a[0], &light)]
            },
            bound: Bound { absolute: 1e-10, relative: 1e-5 },
        },
        Case {
            name: "mf_glint_light",
            inputs: draws(4000, 14, |r| [draw_lobe(r), direction(r).to_vec(), vec![log(r, 1e-6, 0.1)]].concat())
                .into_iter()
                .chain([vec![0.0, 0.0, 0.1, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.01]])
                .collect(),
            twin: |a| of_light(&twin::glint_light(&lobe(a), three(&a[6..]), a[9])),
            bound: Bound { absolute: 5e-6, relative: 1e-4 },
        },
    ]
}

fn places() -> Vec<Case> {
    let signed = |r: &mut SplitMix, low: f64, high: f64| log(r, low, high) * if r.unit() < 0.5 { -1.0 } else { 1.0 };
    let products = draws(4000, 15, |r| vec![signed(r, 1e-3, 2e6), signed(r, 1e-3, 2e3)]);
    let products = firm(products, |a| twin::whole_product(a[0], a[1]).1, 2e-3);
    let dots = draws(4000, 16, |r| {
        vec![signed(r, 1e-3, 2e4), signed(r, 1e-3, 2e4), signed(r, 1e-3, 2e3), signed(r, 1e-3, 2e3)]
    });
    let dots = firm(dots, |a| twin::whole_dot(two(a), two(&a[2..])).1, 1e-3);
    let kernels = || draws(2000, 17, |r| of_kernel(draw_kernel(r)).to_vec());
    let pixels = draws(4000, 18, |r| {
        let cells = log(r, 1.0, 5e4);
        let scratched = r.unit() < 0.3;
        let (reach, turn) = (if scratched { 50.0 / cells } else { 100.0 }, r.unit() * 6.3);
        let mut change = || (r.unit() - 0.5) * 6.0 / cells;
        let change = [change(), change(), change(), change()];
        let uv = [(r.unit() - 0.5) * reach, (r.unit() - 0.5) * reach];
        let (stretch, along) =
            if scratched { (log(r, 1.0, 16.0), [turn.cos(), turn.sin()]) } else { (1.0, [1.0, 0.0]) };
        let more = [cells, 7.0, 0.5, log(r, 0.01, 1.0), stretch, along[0], along[1]];
        [&uv[..], &change[..], &more[..]].concat()
    });
    let ask = |a: &[f64]| {
        twin::glint_pixel(two(a), DMat2::from_cols(two(&a[2..]), two(&a[4..])), &flakes(&a[6..])).expect("finite")
    };
    let pixels = firm(firm(pixels, |a| ask(a).within.x, 1e-3), |a| ask(a).within.y, 1e-3);
    vec![
        Case {
            name: "mf_whole_product",
            inputs: products.into_iter().chain([vec![0.5, 4.0], vec![-3.0, 7.0], vec![0.0, -0.3]]).collect(),
            twin: |a| {
                let (whole, rest) = twin::whole_product(a[0], a[1]);
                vec![whole, rest]
            },
            // (|m| + |x|) 2^-34, and the rounding of the rest.
            bound: Bound { absolute: 1.3e-4, relative: 0.0 },
        },
        Case {
            name: "mf_whole_dot",
            inputs: dots,
            twin: |a| {
                let (whole, rest) = twin::whole_dot(two(a), two(&a[2..]));
                vec![whole, rest]
            },
            bound: Bound { absolute: 5e-6, relative: 0.0 },
        },
        Case {
            name: "mf_glint_kernel",
            inputs: draws(3000, 19, |r| {
                let mut v = || signed(r, 1e-2, 8.0);
                vec![v(), v(), v(), v(), log(r, 1e-2, 0.757)]
            })
            .into_iter()
            .chain([vec![0.0, 0.0, 0.0, 0.0, 0.5], vec![3.0, 4.0, 0.0, 0.0, 0.5], vec![3.0, 4.0, 3.0, 4.0, 0.001]])
            .collect(),
            twin: |a| {
                let jacobian = DMat2::from_cols(two(a), two(&a[2..]));
                of_kernel(twin::glint_kernel(jacobian, a[4]).expect("finite")).to_vec()
            },
            // Sums of squares to 512.
            bound: Bound { absolute: 1e-4, relative: 1e-5 },
        },
        Case {
            name: "mf_glint_inverse_root",
            inputs: kernels(),
            twin: |a| twin::glint_inverse_root(kernel(a)).to_array().to_vec(),
            // Of a rounded tensor 64 to 1: 64 units of the last place.
            bound: Bound { absolute: 1e-5, relative: 2e-5 },
        },
        Case {
            name: "mf_glint_anisotropy",
            inputs: kernels(),
            twin: |a| vec![twin::glint_anisotropy(kernel(a))],
            bound: Bound { absolute: 0.0, relative: 3e-6 },
        },
        Case {
            name: "mf_glint_pixel",
            inputs: pixels,
            twin: |a| {
                let jacobian = DMat2::from_cols(two(&a[2..]), two(&a[4..]));
                of_pixel(&twin::glint_pixel(two(a), jacobian, &flakes(&a[6..])).expect("finite"))
            },
            // Absolute, so that cells agree. Tensors are up to 600.
            bound: Bound { absolute: 4e-4, relative: 0.0 },
        },
        Case {
            name: "mf_flake_variation",
            inputs: Sweep::new(500).linear(0.0, 3.5).edges(&[0.0]).log(1e-4, 1.0).edges(&[0.0, 1.0]).inputs(),
            twin: |a| vec![twin::flake_variation(a[0], a[1])],
            // The root of a difference near 0.
            bound: Bound { absolute: 5e-4, relative: 1e-6 },
        },
        Case {
            name: "mf_glint_effective",
            inputs: draws(300, 20, |r| {
                let light = GlintLight { y: DVec2::splat(0.5), area: log(r, 1e-9, 0.43), widths: DVec2::ZERO };
                let pixel = GlintPixel { cell: [1, 2], within: DVec2::splat(0.5), kernel: draw_kernel(r) };
                [of_pixel(&pixel), of_light(&light)].concat()
            }),
            twin: |a| vec![twin::glint_effective(&pixel(a), &light(&a[8..]))],
            bound: Bound { absolute: 0.0, relative: 1e-6 },
        },
    ]
}
