//! Of `kernels/wgsl/roughness.wgsl`.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use crate::case::{Bound, Case, Sweep};
use crate::twins::roughness::{self as twin, Axes, Burley, Gltf};

/// Three or so roundings.
const EXACT: Bound = Bound { absolute: 1e-12, relative: 4e-7 };
/// Sines and cosines of the driver.
const SINES: Bound = Bound { absolute: 3e-7, relative: 4e-7 };
/// Mesa's arcs are off by 3.4e-6.
const ARCS: Bound = Bound { absolute: 4e-6, relative: 1e-6 };

/// All functions.
pub fn cases() -> Vec<Case> {
    units().into_iter().chain(widened()).chain(tensors()).chain(engines()).collect()
}

fn units() -> Vec<Case> {
    let share = || Sweep::new(300).linear(0.0, 1.0).and(&[-0.0]).inputs();
    let alpha = || Sweep::new(300).log(1e-5, 1.0).edges(&[0.0, 1e-4, 0.999_999]).inputs();
    vec![
        Case {
            name: "mf_alpha_from_perceptual",
            inputs: share(),
            twin: |a| vec![twin::alpha_from_perceptual(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_perceptual_from_alpha",
            inputs: alpha(),
            twin: |a| vec![twin::perceptual_from_alpha(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_alpha_from_smoothness",
            inputs: share(),
            twin: |a| vec![twin::alpha_from_smoothness(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_smoothness_from_alpha",
            inputs: alpha(),
            twin: |a| vec![twin::smoothness_from_alpha(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_variance_from_alpha",
            inputs: alpha(),
            twin: |a| vec![twin::variance_from_alpha(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_alpha_from_variance",
            inputs: Sweep::new(300).log(1e-9, 10.0).edges(&[0.0, -1e-8]).inputs(),
            twin: |a| vec![twin::alpha_from_variance(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_kappa_from_alpha",
            inputs: alpha(),
            twin: |a| vec![twin::kappa_from_alpha(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_alpha_from_kappa",
            inputs: Sweep::new(300).log(1e-3, 1e9).edges(&[0.0, 2.0]).inputs(),
            twin: |a| vec![twin::alpha_from_kappa(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_exponent_from_alpha",
            inputs: alpha(),
            twin: |a| vec![twin::exponent_from_alpha(a[0])],
            bound: EXACT,
        },
        Case {
            name: "mf_alpha_from_exponent",
            inputs: Sweep::new(300).log(1e-3, 1e9).edges(&[0.0, -1.0]).inputs(),
            twin: |a| vec![twin::alpha_from_exponent(a[0])],
            bound: EXACT,
        },
    ]
}

fn widened() -> Vec<Case> {
    let over_variance = || Sweep::new(500).log(1e-4, 1.0).edges(&[0.0]).log(1e-9, 100.0).edges(&[0.0]).inputs();
    let lengths = || Sweep::new(500).log(1e-4, 1.0).edges(&[0.0]).linear(0.0, 1.0).edges(&[1.0001, 0.999_999]);
    vec![
        Case {
            name: "mf_alpha_widened",
            inputs: over_variance(),
            twin: |a| vec![twin::alpha_widened(a[0], a[1])],
            bound: EXACT,
        },
        Case {
            name: "mf_alpha_widened_projected",
            inputs: over_variance(),
            twin: |a| vec![twin::alpha_widened_projected(a[0], a[1])],
            bound: EXACT,
        },
        Case {
            name: "mf_toksvig",
            inputs: lengths().and(&[0.1, -0.1]).inputs(),
            twin: |a| vec![twin::toksvig(a[0], a[1])],
            bound: EXACT,
        },
        Case {
            name: "mf_kappa_from_mean_length",
            // Most near the seams of the three parts, 0.2 and 0.9.
            inputs: Sweep::new(1000)
                .linear(0.0, 1.0)
                .edges(&[0.2, 0.200_001, 0.899_999, 0.9, 0.999_999, 1.1, -0.1])
                .inputs(),
            twin: |a| vec![twin::kappa_from_mean_length(a[0])],
            // Two Newton steps leave 5.7e-6, at kappa 5.
            bound: Bound { absolute: 1e-12, relative: 7e-6 },
        },
        Case {
            name: "mf_alpha_widened_vmf",
            inputs: lengths().inputs(),
            twin: |a| vec![twin::alpha_widened_vmf(a[0], a[1])],
            // As of kappa, halved by the root.
            bound: Bound { absolute: 1e-12, relative: 4e-6 },
        },
    ]
}

/// Tensors of lobes with widths 0.001 to 1, the smaller at least `ratio` of the larger and at most 0.95 of it, at angles that
/// stay clear of the seam at pi/2.
fn tensors_of(ratio: f64) -> Vec<Vec<f64>> {
    let lobes = Sweep::new(600).log(0.001, 1.0).log(ratio, 0.95).linear(-1.57, 1.57).edges(&[0.0]).inputs();
    let tensor = |a: Vec<f64>| {
        let r = twin::tensor_from_axes(Axes { alpha_x: a[0], alpha_y: a[0] * a[1], angle: a[2] });
        vec![r.x, r.y, r.z]
    };
    let exact = [
        [0.25, 0.0, 0.25],
        [0.0, 0.0, 0.0],
        [0.25, 0.0, 0.01],
        [1.0, 0.0, 1.0],
        [0.25, 0.12, 0.25],
        [0.25, -0.12, 0.25],
    ];
    lobes.into_iter().map(tensor).chain(exact.map(Vec::from)).collect()
}

fn axes(a: &[f64]) -> Axes {
    Axes { alpha_x: a[0], alpha_y: a[1], angle: a[2] }
}

fn of_axes(axes: Axes) -> Vec<f64> {
    vec![axes.alpha_x, axes.alpha_y, axes.angle]
}

fn tensors() -> Vec<Case> {
    vec![
        Case {
            name: "mf_tensor_from_axes",
            inputs: axes_inputs(),
            twin: |a| twin::tensor_from_axes(axes(a)).to_array().to_vec(),
            bound: SINES,
        },
        Case {
            name: "mf_widths_from_tensor",
            inputs: tensors_of(0.1),
            twin: |a| twin::widths_from_tensor(DVec3::from_slice(a)).to_array().to_vec(),
            // The determinant is a difference: of a ratio of 0.1 it loses a digit.
            bound: Bound { absolute: 1e-9, relative: 2e-6 },
        },
        Case {
            name: "mf_widths_from_tensor",
            inputs: tensors_of(1e-4),
            twin: |a| twin::widths_from_tensor(DVec3::from_slice(a)).to_array().to_vec(),
            // Needles: of a difference that rounding leaves of 0, the root.
            bound: Bound { absolute: 1e-4, relative: 1e-6 },
        },
        Case {
            name: "mf_direction_from_tensor",
            inputs: tensors_of(1e-4),
            twin: |a| twin::direction_from_tensor(DVec3::from_slice(a)).to_array().to_vec(),
            bound: Bound { absolute: 3e-7, relative: 0.0 },
        },
        Case {
            name: "mf_axes_from_tensor",
            inputs: tensors_of(0.1),
            twin: |a| of_axes(twin::axes_from_tensor(DVec3::from_slice(a))),
            bound: ARCS,
        },
        Case {
            name: "mf_tensor_clamped",
            inputs: tensors_of(1e-4).into_iter().map(|r| [r, vec![0.01, 0.5]].concat()).collect(),
            twin: |a| twin::tensor_clamped(DVec3::from_slice(a), a[3], a[4]).to_array().to_vec(),
            // The mixed term is told in parts of the largest.
            bound: Bound { absolute: 1e-7, relative: 1e-7 },
        },
    ]
}

fn axes_inputs() -> Vec<Vec<f64>> {
    let lobes = Sweep::new(500).log(0.001, 1.0).edges(&[0.0]).linear(0.0, 1.0).linear(-1.57, 1.57).edges(&[0.0]);
    lobes.inputs().into_iter().map(|a| vec![a[0], a[0] * a[1], a[2]]).collect()
}

fn gltf(a: &[f64]) -> Gltf {
    Gltf { alpha: a[0], strength: a[1], direction: DVec2::new(a[2], a[3]) }
}

fn of_gltf(g: Gltf) -> Vec<f64> {
    vec![g.alpha, g.strength, g.direction.x, g.direction.y]
}

/// glTF's parameters: directions of every length, those across the seam of the angle left out.
fn gltf_inputs() -> Vec<Vec<f64>> {
    let all = Sweep::new(500).log(0.001, 1.0).edges(&[0.0]).linear(0.0, 1.0).disk();
    all.inputs().into_iter().filter(|a| a[2].abs() > 1e-3 || a[3].abs() < 1e-9).collect()
}

fn engines() -> Vec<Case> {
    vec![
        Case {
            name: "mf_gltf_strength",
            inputs: axes_inputs()
                .into_iter()
                .map(|a| a[..2].to_vec())
                .chain([vec![1.0, 1.0], vec![0.2, 0.3]])
                .collect(),
            twin: |a| vec![twin::gltf_strength(a[0], a[1])],
            bound: EXACT,
        },
        Case {
            name: "mf_gltf_from_axes",
            inputs: axes_inputs(),
            twin: |a| of_gltf(twin::gltf_from_axes(axes(a))),
            bound: SINES,
        },
        Case {
            name: "mf_gltf_from_tensor",
            inputs: tensors_of(0.1).into_iter().filter(|r| r[0] + r[2] < 1.999).collect(),
            twin: |a| of_gltf(twin::gltf_from_tensor(DVec3::from_slice(a))),
            bound: Bound { absolute: 3e-7, relative: 2e-6 },
        },
        Case {
            name: "mf_gltf_along",
            inputs: gltf_inputs(),
            twin: |a| twin::gltf_along(gltf(a)).to_array().to_vec(),
            bound: EXACT,
        },
        Case {
            name: "mf_axes_from_gltf",
            inputs: gltf_inputs(),
            twin: |a| of_axes(twin::axes_from_gltf(gltf(a))),
            bound: ARCS,
        },
        Case {
            name: "mf_tensor_from_gltf",
            inputs: gltf_inputs(),
            twin: |a| twin::tensor_from_gltf(gltf(a)).to_array().to_vec(),
            bound: Bound { absolute: 1e-9, relative: 1e-6 },
        },
        Case {
            name: "mf_burley_from_axes",
            inputs: axes_inputs(),
            twin: |a| {
                let b = twin::burley_from_axes(axes(a));
                vec![b.alpha, b.anisotropy, b.rotation]
            },
            bound: Bound { absolute: 1e-7, relative: 4e-7 },
        },
        Case {
            name: "mf_axes_from_burley",
            // Clear of the seam at a quarter turn.
            inputs: Sweep::new(500)
                .log(0.001, 0.3)
                .linear(0.0, 1.0)
                .linear(-0.249, 0.249)
                .edges(&[0.0, 0.5, 0.75 + 1e-3, 1.0])
                .inputs(),
            twin: |a| of_axes(twin::axes_from_burley(Burley { alpha: a[0], anisotropy: a[1], rotation: a[2] })),
            // 1 - 0.9 is rounded where the anisotropy is 1.
            bound: Bound { absolute: 2e-7, relative: 1e-6 },
        },
        Case {
            name: "mf_kulla_conty_from_axes",
            inputs: axes_inputs(),
            twin: |a| twin::kulla_conty_from_axes(axes(a)).to_array().to_vec(),
            bound: EXACT,
        },
        Case {
            name: "mf_axes_from_kulla_conty",
            inputs: Sweep::new(500)
                .log(0.001, 0.5)
                .linear(-1.0, 1.0)
                .edges(&[0.0])
                .linear(-1.57, FRAC_PI_2 - 1e-6)
                .edges(&[0.3])
                .inputs(),
            twin: |a| of_axes(twin::axes_from_kulla_conty(a[0], a[1], a[2])),
            bound: Bound { absolute: 3e-7, relative: 4e-7 },
        },
    ]
}
