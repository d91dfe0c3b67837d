//! Of `kernels/wgsl/moments.wgsl`.

use glam::{DVec2, DVec3, DVec4};

use super::geometric_aa::{ROUNDING, TENSOR, v2, v3, with_tensor_at};
use crate::case::{Bound, Case, Sweep};
use crate::twins::moments as twins;
use crate::twins::moments::{Lobe, Moments, WeightedLobe};

/// Components of unit vectors.
const NORMAL: Bound = Bound { absolute: 1e-7, relative: 5e-7 };

/// z rebuilt from two channels: near the rim it is the root of a difference that is known to 1e-7, and so to 3e-4 at worst.
const REBUILT: Bound = Bound { absolute: 3e-5, relative: 5e-7 };

/// Vulkan's sine and cosine are good to 2^-11 by the letter and to 5e-7 here; a tensor has that of its larger entry.
const TURNED: Bound = Bound { absolute: 1e-6, relative: 1e-6 };

/// The mid-gray of 8 bits: no direction.
const GRAY: f64 = 128.0 / 255.0;

fn lobe(l: Lobe) -> Vec<f64> {
    [l.normal.to_array(), l.tensor.to_array()].concat()
}

fn weighted(l: WeightedLobe) -> Vec<f64> {
    [l.normal.to_array().as_slice(), &l.tensor.to_array(), &[l.weight]].concat()
}

fn moments(m: Moments) -> Vec<f64> {
    [m.mean.to_array().as_slice(), &m.covariance.to_array()].concat()
}

/// Moments in the arguments from `at` on.
fn read(a: &[f64], at: usize) -> Moments {
    Moments { mean: v2(a, at), covariance: v3(a, at + 2) }
}

/// A mean of slopes, and a covariance as two deviations and an angle for [`with_tensor_at`].
fn slopes(sweep: Sweep) -> Sweep {
    let mean = sweep.signed_log(1e-3, 2.0).signed_log(1e-3, 2.0);
    mean.log(1e-3, 1.0).edges(&[0.0]).log(1e-3, 1.0).edges(&[0.0]).linear(-3.2, 3.2)
}

/// Green up or down, and a normal scale.
fn convention(sweep: Sweep) -> Sweep {
    sweep.one_of(&[1.0, -1.0]).linear(0.2, 2.0).edges(&[1.0])
}

fn texel(sweep: Sweep, channels: usize) -> Sweep {
    (0..channels).fold(sweep, |sweep, _| sweep.linear(0.0, 1.0))
}

fn raw(m: Moments, y_sign: f64) -> Vec<f64> {
    let (m, c) = (m.mean, m.covariance);
    vec![m.x, y_sign * m.y, c.x + m.x * m.x, c.z + m.y * m.y, y_sign * (c.y + m.x * m.y), y_sign]
}

/// All functions.
pub fn cases() -> Vec<Case> {
    let mut all = decoding();
    all.extend(working());
    all
}

fn decoding() -> Vec<Case> {
    vec![
        Case {
            name: "mf_decode_normal_signed",
            inputs: convention(Sweep::new(1000).sphere().edges(&[0.0, 0.0, 0.0, 0.0, 0.09, 0.0, 0.08, 0.0, 0.08]))
                .inputs(),
            twin: |a| twins::decode_normal_signed(v3(a, 0), a[3], a[4]).to_array().into(),
            bound: NORMAL,
        },
        Case {
            name: "mf_decode_normal",
            inputs: convention(texel(Sweep::new(1000), 3))
                .and(&[GRAY, GRAY, GRAY, 1.0, 1.0])
                .and(&[GRAY, GRAY, GRAY, -1.0, 20.0])
                .inputs(),
            // Short vectors within the cube lose digits in 2 v - 1.
            bound: Bound { absolute: 5e-7, ..NORMAL },
            twin: |a| twins::decode_normal(v3(a, 0), a[3], a[4]).to_array().into(),
        },
        Case {
            name: "mf_decode_normal_xy_signed",
            inputs: convention(Sweep::new(1000).disk()).inputs(),
            twin: |a| twins::decode_normal_xy_signed(v2(a, 0), a[2], a[3]).to_array().into(),
            bound: REBUILT,
        },
        Case {
            name: "mf_decode_normal_xy",
            inputs: convention(texel(Sweep::new(1000), 2)).inputs(),
            twin: |a| twins::decode_normal_xy(v2(a, 0), a[2], a[3]).to_array().into(),
            bound: REBUILT,
        },
        Case {
            name: "mf_decode_roughness",
            inputs: Sweep::new(300).linear(0.0, 1.0).inputs(),
            twin: |a| twins::decode_roughness(a[0]).to_array().into(),
            bound: ROUNDING,
        },
        Case {
            name: "mf_decode_gloss",
            inputs: Sweep::new(300).linear(0.0, 1.0).inputs(),
            twin: |a| twins::decode_gloss(a[0]).to_array().into(),
            bound: ROUNDING,
        },
        Case {
            name: "mf_decode_anisotropy",
            // Directions, shortened by filtering.
            inputs: Sweep::new(1000)
                .circle()
                .linear(0.05, 1.0)
                .linear(0.0, 1.0)
                .linear(0.0, 1.0)
                .inputs()
                .into_iter()
                .map(|a| vec![0.5 + 0.5 * a[0] * a[2], 0.5 + 0.5 * a[1] * a[2], a[3], a[4]])
                .chain([vec![GRAY, GRAY, 0.7, 0.5], vec![GRAY, 1.0 - GRAY, 1.0, 0.3]])
                .collect(),
            // The shortest directions lose digits in 2 v - 1.
            bound: Bound { absolute: 5e-7, ..TENSOR },
            twin: |a| twins::decode_anisotropy(v3(a, 0), a[3]).to_array().into(),
        },
        Case {
            name: "mf_decode_tensor_root_signed",
            inputs: Sweep::new(500).linear(0.0, 1.0).linear(0.0, 1.0).linear(-0.5, 0.5).inputs(),
            twin: |a| twins::decode_tensor_root_signed(v3(a, 0)).to_array().into(),
            bound: ROUNDING,
        },
        Case {
            name: "mf_decode_tensor_root",
            inputs: texel(Sweep::new(500), 3).edges(&[128.0 / 255.0]).inputs(),
            twin: |a| twins::decode_tensor_root(v3(a, 0)).to_array().into(),
            // 255 b - 128 has lost what 128 rounds to: 6e-8 of xy.
            bound: Bound { absolute: 2e-7, relative: 2e-6 },
        },
        Case {
            name: "mf_decode_axes_signed",
            inputs: Sweep::new(1000).log(1e-3, 1.0).log(1e-3, 1.0).linear(-3.2, 6.3).inputs(),
            twin: |a| twins::decode_axes_signed(a[0], a[1], a[2]).to_array().into(),
            bound: TURNED,
        },
        Case {
            name: "mf_decode_axes",
            inputs: texel(Sweep::new(1000), 3).inputs(),
            twin: |a| twins::decode_axes(v3(a, 0)).to_array().into(),
            bound: TURNED,
        },
        Case {
            name: "mf_decode_burley",
            inputs: texel(Sweep::new(1000), 3).inputs(),
            // Widths up to 3.2.
            bound: Bound { absolute: 5e-6, ..TURNED },
            twin: |a| twins::decode_burley(v3(a, 0)).to_array().into(),
        },
        Case {
            name: "mf_decode_energy",
            inputs: Sweep::new(100).linear(0.0, 1.0).inputs(),
            twin: |a| vec![twins::decode_energy(a[0])],
            bound: ROUNDING,
        },
        Case {
            name: "mf_decode_lobe_signed",
            inputs: convention(texel(Sweep::new(500).disk(), 2)).inputs(),
            twin: |a| weighted(twins::decode_lobe_signed(DVec4::new(a[0], a[1], a[2], a[3]), a[4], a[5])),
            bound: REBUILT,
        },
        Case {
            name: "mf_decode_lobe",
            inputs: convention(texel(Sweep::new(500), 4)).inputs(),
            twin: |a| weighted(twins::decode_lobe(DVec4::new(a[0], a[1], a[2], a[3]), a[4], a[5])),
            bound: REBUILT,
        },
        Case {
            name: "mf_decode_haze",
            inputs: texel(Sweep::new(300), 2).hemisphere().inputs(),
            twin: |a| weighted(twins::decode_haze(v2(a, 0), v3(a, 2))),
            bound: ROUNDING,
        },
        Case {
            name: "mf_first_weight",
            inputs: texel(Sweep::new(300), 3).inputs(),
            twin: |a| vec![twins::first_weight(v3(a, 0))],
            bound: Bound { absolute: 2e-7, ..ROUNDING },
        },
        Case {
            name: "mf_decode_moments",
            inputs: with_tensor_at(slopes(Sweep::new(1000)).one_of(&[1.0, -1.0]).inputs(), 2)
                .into_iter()
                .map(|a| raw(read(&a, 0), a[5]))
                .collect(),
            twin: |a| moments(twins::decode_moments(v2(a, 0), v3(a, 2), a[5])),
            // A difference of raw moments up to 5.
            bound: Bound { absolute: 1e-6, relative: 5e-7 },
        },
    ]
}

fn working() -> Vec<Case> {
    // Un-normalised means of normals.
    let short = || {
        let scaled = |a: Vec<f64>| vec![a[0] * a[3], a[1] * a[3], a[2] * a[3], a[4]];
        let inputs = Sweep::new(500).hemisphere().linear(0.0, 1.0).edges(&[0.999]).log(1e-3, 1.0).inputs();
        inputs.into_iter().map(scaled).collect::<Vec<_>>()
    };
    vec![
        Case {
            name: "mf_lobe_toksvig",
            inputs: short(),
            twin: |a| lobe(twins::lobe_toksvig(v3(a, 0), a[3])),
            // 1 - r is known to 1.2e-7.
            bound: Bound { absolute: 5e-7, relative: 1e-6 },
        },
        Case {
            name: "mf_lobe_vmf",
            inputs: short(),
            twin: |a| lobe(twins::lobe_vmf(v3(a, 0), a[3])),
            bound: Bound { absolute: 1e-6, relative: 1e-5 },
        },
        Case {
            name: "mf_tensor_positive",
            inputs: Sweep::new(1000).signed_log(1e-6, 1.0).signed_log(1e-6, 1.0).signed_log(1e-6, 1.0).inputs(),
            twin: |a| twins::tensor_positive(v3(a, 0)).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_moments_of_normal",
            inputs: Sweep::new(500).hemisphere().inputs(),
            twin: |a| moments(twins::moments_of_normal(v3(a, 0))),
            bound: ROUNDING,
        },
        Case {
            name: "mf_moments_transform",
            inputs: with_tensor_at(
                (0..4).fold(slopes(Sweep::new(1000)), |sweep, _| sweep.signed_log(1e-2, 3.0)).inputs(),
                2,
            ),
            twin: |a| moments(twins::moments_transform(read(a, 0), v2(a, 5), v2(a, 7))),
            // Terms up to 9 of either sign.
            bound: Bound { absolute: 1e-6, relative: 1e-6 },
        },
        Case {
            name: "mf_moments_add",
            inputs: with_tensor_at(with_tensor_at(slopes(slopes(Sweep::new(300))).inputs(), 2), 7),
            twin: |a| moments(twins::moments_add(read(a, 0), read(a, 5))),
            bound: Bound { absolute: 1e-7, ..ROUNDING },
        },
        Case {
            name: "mf_moments_blend",
            inputs: with_tensor_at(with_tensor_at(slopes(slopes(Sweep::new(1000))).linear(0.0, 1.0).inputs(), 2), 7),
            twin: |a| moments(twins::moments_blend(read(a, 0), read(a, 5), a[10])),
            bound: Bound { absolute: 4e-7, relative: 5e-7 },
        },
        Case {
            name: "mf_lobe_from_moments",
            inputs: with_tensor_at(
                with_tensor_at(super::geometric_aa::tensor(slopes(Sweep::new(1000))).inputs(), 2),
                5,
            ),
            twin: |a| lobe(twins::lobe_from_moments(read(a, 0), v3(a, 5))),
            bound: Bound { absolute: 5e-7, relative: 1e-6 },
        },
        Case {
            name: "mf_moments_from_lobe",
            inputs: with_tensor_at(super::geometric_aa::tensor(Sweep::new(1000).hemisphere()).inputs(), 3),
            twin: |a| moments(twins::moments_from_lobe(Lobe { normal: v3(a, 0), tensor: v3(a, 3) })),
            // J^-1 grows as the cosine to the power -2: covariances up to 700 at 78.5 degrees, entries cancel.
            bound: Bound { absolute: 3e-5, relative: 2e-6 },
        },
        Case {
            name: "mf_gaussian_pdf",
            inputs: Sweep::new(300).linear(-12.0, 12.0).edges(&[0.0]).inputs(),
            twin: |a| vec![twins::gaussian_pdf(a[0])],
            // The exponential's argument is rounded: 72 times 6e-8.
            bound: Bound { absolute: 1e-9, relative: 5e-6 },
        },
        Case {
            name: "mf_gaussian_cdf",
            inputs: Sweep::new(500)
                .linear(-12.0, 12.0)
                .signed_log(1e-3, 4.0)
                .inputs()
                .into_iter()
                .flatten()
                .map(|x| vec![x])
                .collect(),
            twin: |a| vec![twins::gaussian_cdf(a[0])],
            // The polynomial's own 7.5e-8, and roundings.
            bound: Bound { absolute: 4e-7, relative: 0.0 },
        },
        Case {
            name: "mf_slope_cosine",
            inputs: with_tensor_at(slopes(Sweep::new(1000)).hemisphere().inputs(), 2),
            twin: |a| vec![twins::slope_cosine(read(a, 0), v3(a, 5))],
            bound: Bound { absolute: 3e-7, relative: 1e-6 },
        },
        Case {
            name: "mf_visible_weight",
            inputs: with_tensor_at(
                slopes(Sweep::new(1000)).hemisphere().signed_log(1e-2, 1.0).signed_log(1e-2, 1.0).inputs(),
                2,
            )
            .into_iter()
            .filter(|a| above(a))
            .collect(),
            twin: |a| vec![twins::visible_weight(read(a, 0), v3(a, 5), DVec2::new(a[8], a[9]))],
            // Over cosines down to 0.02, each known to 3e-7.
            bound: Bound { absolute: 2e-6, relative: 5e-6 },
        },
        Case {
            name: "mf_visible_moments",
            inputs: with_tensor_at(slopes(Sweep::new(2000)).hemisphere().inputs(), 2)
                .into_iter()
                .filter(|a| above(a))
                .collect(),
            twin: |a| moments(twins::visible_moments(read(a, 0), v3(a, 5))),
            // The shift is over cosines down to 0.02, each known to 3e-7.
            bound: Bound { absolute: 3e-6, relative: 5e-6 },
        },
    ]
}

/// Whether the view is clear of the horizon of the mean plane: there, all the mean's digits go.
fn above(a: &[f64]) -> bool {
    let v: DVec3 = v3(a, 5);
    v.z - v2(a, 0).dot(v.truncate()) > 0.02
}
