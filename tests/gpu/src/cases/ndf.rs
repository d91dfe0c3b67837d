//! Of `kernels/wgsl/ndf.wgsl`.

use std::f64::consts::FRAC_PI_4;

use glam::DVec3;

use super::geometric_aa::{v2, v3, with_tensor_at};
use crate::case::{Bound, Case, Sweep};
use crate::twins::ndf as twins;
use crate::twins::ndf::SlopeLobe;

/// A few roundings of f32, squared.
const ROUNDING: Bound = Bound { absolute: 1e-9, relative: 1e-6 };

/// Of lobes up to ten times as wide as thin, as the text states.
const TEN: Bound = Bound { absolute: 1e-9, relative: 5e-6 };

/// Of lobes up to a hundred times as wide as thin, as the text states.
const HUNDRED: Bound = Bound { absolute: 1e-9, relative: 5e-4 };

/// Exponentials: an exponent of 20 is known to 1e-5 (of lobes up to ten times as wide as thin).
const EXPONENTIAL: Bound = Bound { absolute: 1e-9, relative: 2e-5 };

/// All functions.
pub fn cases() -> Vec<Case> {
    [densities(), by_tensor(), slope_lobes(), smith(), tilted(), samples()].into_iter().flatten().collect()
}

pub(super) fn case(name: &'static str, inputs: Vec<Vec<f64>>, bound: Bound, twin: fn(&[f64]) -> Vec<f64>) -> Case {
    Case { name, inputs, twin, bound }
}

pub(super) fn alpha(sweep: Sweep) -> Sweep {
    sweep.log(0.001, 1.0).edges(&[0.0, 1e-5])
}

/// A wider width, the share of it that the thinner one is, and an angle: for [`built`].
pub(super) fn tensor(sweep: Sweep, narrowest: f64, ratio: f64) -> Sweep {
    sweep.log(narrowest, 1.0).log(1.0 / ratio, 1.0).linear(-3.2, 3.2).edges(&[0.0, FRAC_PI_4])
}

/// The calls with the entries of a [`tensor`] in its place.
pub(super) fn built(sweep: Sweep, at: usize) -> Vec<Vec<f64>> {
    let mut inputs = sweep.inputs();
    for call in &mut inputs {
        call[at + 1] *= call[at];
    }
    with_tensor_at(inputs, at)
}

fn slope(sweep: Sweep) -> Sweep {
    sweep.signed_log(1e-4, 10.0).signed_log(1e-4, 10.0)
}

/// Half vectors: above, below, and along the horizon.
pub(super) fn half(count: usize) -> Sweep {
    Sweep::new(count).hemisphere().edges(&[0.0, 0.0, -1.0, 1.0, 0.0, 1e-7])
}

/// A lobe's tensor, and its normal 78 degrees from z at most, as z and an angle: for [`with_lobes`].
fn bent_lobe(sweep: Sweep, narrowest: f64, widest: f64) -> Sweep {
    let widths = sweep.log(narrowest, widest).log(0.1, 1.0).linear(-3.2, 3.2).edges(&[0.0, FRAC_PI_4]);
    widths.linear(0.2, 1.0).linear(-3.2, 3.2).edges(&[0.0])
}

/// What comes before `at`, the normal, and the tensor.
fn bent_lobes(sweep: Sweep, at: usize) -> Vec<(Vec<f64>, DVec3, DVec3)> {
    let read = |call: Vec<f64>| {
        let (z, (sin, cos)) = (call[at + 3], call[at + 4].sin_cos());
        let p = (1.0 - z * z).max(0.0).sqrt();
        (call[..at].to_vec(), DVec3::new(p * cos, p * sin, z), v3(&call, at))
    };
    built(sweep, at).into_iter().map(read).collect()
}

/// Calls that end in a slope lobe.
fn with_lobes(sweep: Sweep, at: usize) -> Vec<Vec<f64>> {
    bent_lobes(sweep, at).into_iter().map(|(before, n, r)| [before, flat(twins::slope_lobe(n, r))].concat()).collect()
}

fn read(a: &[f64], at: usize) -> SlopeLobe {
    SlopeLobe { centre: v2(a, at), scatter: v3(a, at + 2) }
}

fn flat(lobe: SlopeLobe) -> Vec<f64> {
    [lobe.centre.to_array().as_slice(), &lobe.scatter.to_array()].concat()
}

fn densities() -> Vec<Case> {
    let pairs = || Sweep::new(500).sphere().sphere().log(0.001, 1.0).inputs();
    // h at most a few widths from n, where all the digits count.
    let near = |call: Vec<f64>| {
        let (n, to, alpha) = (v3(&call, 0), v3(&call, 3), call[6]);
        let h = (n + to.cross(n) * alpha * 3.0).normalize();
        [n.to_array().as_slice(), &h.to_array(), &[alpha]].concat()
    };
    let cosines = Sweep::new(600).linear(0.0, 1.0).edges(&[0.999, 0.999_999, -0.5, 1.000_000_1]);
    vec![
        case("mf_d_ggx", alpha(cosines).inputs(), ROUNDING, |a| vec![twins::d_ggx(a[0], a[1])]),
        case("mf_d_ggx_tangent", alpha(half(600)).inputs(), ROUNDING, |a| vec![twins::d_ggx_tangent(v3(a, 0), a[3])]),
        case("mf_d_ggx_cross", [pairs(), pairs().into_iter().map(near).collect()].concat(), ROUNDING, |a| {
            vec![twins::d_ggx_cross(v3(a, 0), v3(a, 3), a[6])]
        }),
        case("mf_d_ggx_aniso", alpha(alpha(half(600))).inputs(), ROUNDING, |a| {
            vec![twins::d_ggx_aniso(v3(a, 0), a[3], a[4])]
        }),
    ]
}

fn by_tensor() -> Vec<Case> {
    let any = |sweep: Sweep, ratio: f64| tensor(sweep, 0.001, ratio);
    let tail = |sweep: Sweep| sweep.log(1.5, 1e4).edges(&[2.0, 1.1, 4.0]);
    // Flat, zero and impossible ones.
    let floors = [[0.0, 0.0, 0.0], [0.25, 0.25, 0.25], [0.0, 0.5, 0.0], [1.0, -2.0, 1.0], [1e-9, 0.0, 1.0]];
    let mut all = vec![
        case("mf_tensor_determinant", floors.map(Vec::from).to_vec(), ROUNDING, |a| {
            vec![twins::tensor_determinant(v3(a, 0))]
        }),
        case("mf_tensor_determinant", built(any(Sweep::new(400), 10.0), 0), Bound { absolute: 0.0, ..TEN }, |a| {
            vec![twins::tensor_determinant(v3(a, 0))]
        }),
        // Terms of either sign, up to 100.
        case(
            "mf_tensor_quadratic",
            built(slope(any(Sweep::new(500), 10.0)), 0),
            Bound { absolute: 1e-5, relative: 1e-6 },
            |a| vec![twins::tensor_quadratic(v3(a, 0), v2(a, 3))],
        ),
        case("mf_tensor_inverse_quadratic", built(slope(any(Sweep::new(500), 10.0)), 0), TEN, |a| {
            vec![twins::tensor_inverse_quadratic(v3(a, 0), v2(a, 3))]
        }),
        case(
            "mf_log_one_plus",
            Sweep::new(400).log(1e-9, 1e20).edges(&[0.0, 0.5, 0.499_999, 0.500_001]).inputs(),
            Bound { absolute: 1e-12, relative: 5e-7 },
            |a| vec![twins::log_one_plus(a[0])],
        ),
        case("mf_p22_beckmann", built(any(slope(Sweep::new(600)), 10.0), 2), EXPONENTIAL, |a| {
            vec![twins::p22_beckmann(v2(a, 0), v3(a, 2))]
        }),
        case("mf_d_beckmann", built(any(half(600), 10.0), 3), EXPONENTIAL, |a| {
            vec![twins::d_beckmann(v3(a, 0), v3(a, 3))]
        }),
        case("mf_p22_student", built(tail(any(slope(Sweep::new(600)), 10.0)), 2), EXPONENTIAL, |a| {
            vec![twins::p22_student(v2(a, 0), v3(a, 2), a[5])]
        }),
        case("mf_d_student", built(tail(any(half(600), 10.0)), 3), EXPONENTIAL, |a| {
            vec![twins::d_student(v3(a, 0), v3(a, 3), a[6])]
        }),
    ];
    for (ratio, bound) in [(10.0, TEN), (100.0, HUNDRED)] {
        all.push(case("mf_d_ggx_tensor", built(any(half(500), ratio), 3), bound, |a| {
            vec![twins::d_ggx_tensor(v3(a, 0), v3(a, 3))]
        }));
        all.push(case("mf_p22_ggx", built(any(slope(Sweep::new(500)), ratio), 2), bound, |a| {
            vec![twins::p22_ggx(v2(a, 0), v3(a, 2))]
        }));
    }
    all
}

fn slope_lobes() -> Vec<Case> {
    let joined = |(_, n, r): (Vec<f64>, DVec3, DVec3)| [n.to_array(), r.to_array()].concat();
    let lobes = || bent_lobes(bent_lobe(Sweep::new(1500), 0.001, 1.0), 0).into_iter().map(joined);
    // Those in which no entry is small by cancellation.
    let full = |a: &Vec<f64>| {
        let SlopeLobe { centre: u, scatter: p } = twins::slope_lobe(v3(a, 0), v3(a, 3));
        p.y.abs() > 0.3 * (p.x * p.z).sqrt() && u.abs().min_element() > 0.3 * u.length()
    };
    let twin: fn(&[f64]) -> Vec<f64> = |a| flat(twins::slope_lobe(v3(a, 0), v3(a, 3)));
    // At a width of 1 there is no direction.
    let round = || bent_lobes(bent_lobe(Sweep::new(800), 0.001, 0.9), 0).into_iter();
    let near = |a: Vec<f64>| {
        // Slopes within a few widths of the centre.
        let (lobe, x) = (read(&a, 2), v2(&a, 0));
        let s = lobe.centre + x * lobe.scatter.z.min(lobe.scatter.x).sqrt();
        [s.to_array().as_slice(), &a[2..]].concat()
    };
    let slopes = |narrowest| with_lobes(bent_lobe(slope(Sweep::new(600)), narrowest, 1.0), 2).into_iter().map(near);
    let normals = |a: Vec<f64>| [(-v2(&a, 0)).extend(1.0).normalize().to_array().as_slice(), &a[2..]].concat();
    let mut all = vec![
        case("mf_slope_lobe", lobes().filter(full).collect(), Bound { absolute: 0.0, relative: 4e-6 }, twin),
        // Entries up to 25, of terms of either sign.
        case("mf_slope_lobe", lobes().collect(), Bound { absolute: 2e-6, relative: 2e-6 }, twin),
        // Normals along x, where the tangent is -z and the bitangent turns with the sign.
        case(
            "mf_slope_lobe",
            [1.0, -1.0]
                .into_iter()
                .flat_map(|x| [[x, 0.0, 0.0], [x, 0.0, 1e-7]])
                .flat_map(|n| [[0.3, 0.1, 0.2], [0.2, -0.15, 0.5]].map(|r| [n, r].concat()))
                .collect(),
            Bound { absolute: 2e-6, relative: 2e-6 },
            twin,
        ),
        case(
            "mf_round_lobe",
            round()
                .map(|(_, n, r)| flat(twins::slope_lobe_round(n, r.x.sqrt())))
                .chain(round().map(|(_, n, r)| flat(twins::slope_lobe(n, r))))
                .chain([vec![0.0; 5], vec![0.0, 0.0, 1.0, 0.0, 1.0]])
                .collect(),
            Bound { absolute: 1e-6, relative: 2e-6 },
            |a| {
                let o = twins::round_lobe(read(a, 0));
                vec![o.normal.x, o.normal.y, o.normal.z, o.alpha]
            },
        ),
    ];
    // Wide ones know their slopes to a rounding of n, narrow ones to one of the slopes.
    for (narrowest, widest, absolute) in [(0.001, 0.1, 1e-12), (0.1, 0.9, 3e-8)] {
        let lobes = bent_lobes(bent_lobe(Sweep::new(500), narrowest, widest), 0).into_iter();
        let inputs = lobes.map(|(_, n, r)| vec![n.x, n.y, n.z, r.x.max(r.z).sqrt()]).collect();
        all.push(case("mf_slope_lobe_round", inputs, Bound { absolute, relative: 3e-6 }, |a| {
            flat(twins::slope_lobe_round(v3(a, 0), a[3]))
        }));
    }
    // m is known to 6e-8, and a lobe's centre too: a share of its width.
    for (narrowest, relative) in [(0.1, 5e-6), (0.001, 2e-4)] {
        let bound = Bound { absolute: 1e-7, relative };
        all.push(case("mf_p22_slope_lobe", slopes(narrowest).collect(), bound, |a| {
            vec![twins::p22_slope_lobe(v2(a, 0), read(a, 2))]
        }));
        all.push(case("mf_d_slope_lobe", slopes(narrowest).map(normals).collect(), bound, |a| {
            vec![twins::d_slope_lobe(v3(a, 0), read(a, 3))]
        }));
    }
    all.push(case(
        "mf_d_slope_lobe",
        with_lobes(bent_lobe(half(600), 0.1, 1.0), 3),
        Bound { absolute: 1e-7, relative: 5e-6 },
        |a| vec![twins::d_slope_lobe(v3(a, 0), read(a, 3))],
    ));
    all
}

fn smith() -> Vec<Case> {
    let directions = || Sweep::new(600).hemisphere().edges(&[-0.6, 0.0, -0.8, 0.0, 0.0, 0.0]);
    let pairs = || directions().hemisphere().edges(&[-0.6, 0.0, -0.8, 0.0, 0.0, 0.0]);
    // A form of lobes ten times as wide as thin may cancel to a hundredth.
    let form = Bound { absolute: 1e-12, relative: 3e-6 };
    let cosine = |sweep: Sweep| sweep.log(1e-5, 1.0).edges(&[0.0, 1e-7]);
    let lambda = |sweep: Sweep| sweep.log(1e-6, 1e6).edges(&[0.0]);
    vec![
        case("mf_lambda_ggx", built(tensor(directions(), 0.001, 10.0), 3), form, |a| {
            vec![twins::lambda_ggx(v3(a, 0), v3(a, 3))]
        }),
        case("mf_lambda_ggx_aniso", alpha(alpha(directions())).inputs(), Bound { absolute: 1e-12, ..ROUNDING }, |a| {
            vec![twins::lambda_ggx_aniso(v3(a, 0), a[3], a[4])]
        }),
        case(
            "mf_erfc_scaled",
            Sweep::new(600).log(1e-6, 1e6).edges(&[0.0, 2.5]).inputs(),
            Bound { absolute: 0.0, relative: 5.5e-6 },
            |a| vec![twins::erfc_scaled(a[0])],
        ),
        case(
            "mf_lambda_beckmann",
            built(tensor(directions(), 0.001, 10.0), 3),
            Bound { absolute: 3e-6, relative: 1e-5 },
            |a| vec![twins::lambda_beckmann(v3(a, 0), v3(a, 3))],
        ),
        case("mf_g1", lambda(Sweep::new(300)).inputs(), ROUNDING, |a| vec![twins::g1(a[0])]),
        case("mf_g2", lambda(lambda(Sweep::new(300))).inputs(), ROUNDING, |a| vec![twins::g2(a[0], a[1])]),
        case("mf_v_smith_ggx", alpha(cosine(cosine(Sweep::new(600)))).inputs(), ROUNDING, |a| {
            vec![twins::v_smith_ggx(a[0], a[1], a[2])]
        }),
        case("mf_v_smith_ggx_aniso", alpha(alpha(pairs())).inputs(), ROUNDING, |a| {
            vec![twins::v_smith_ggx_aniso(v3(a, 0), v3(a, 3), a[6], a[7])]
        }),
        case("mf_v_smith_ggx_tensor", built(tensor(pairs(), 0.001, 10.0), 6), form, |a| {
            vec![twins::v_smith_ggx_tensor(v3(a, 0), v3(a, 3), v3(a, 6))]
        }),
    ]
}

fn tilted() -> Vec<Case> {
    // c = v.z - u.v.xy is a difference, known to 1e-6 where u is 5.
    let clear = |a: &Vec<f64>, lobe: usize, at: usize| twins::mean_cosine(v3(a, at), read(a, lobe)).abs() > 0.01;
    let one = || with_lobes(bent_lobe(half(800), 0.01, 1.0), 3).into_iter();
    let two = || with_lobes(bent_lobe(half(800).hemisphere(), 0.01, 1.0), 6).into_iter();
    let difference = Bound { absolute: 1e-7, relative: 1e-5 };
    vec![
        case("mf_sigma_slope_lobe", one().collect(), difference, |a| {
            vec![twins::sigma_slope_lobe(v3(a, 0), read(a, 3))]
        }),
        case("mf_g1_slope_lobe", one().filter(|a| clear(a, 3, 0)).collect(), difference, |a| {
            vec![twins::g1_slope_lobe(v3(a, 0), read(a, 3))]
        }),
        case("mf_v_smith_slope_lobe", two().filter(|a| clear(a, 6, 0) && clear(a, 6, 3)).collect(), difference, |a| {
            vec![twins::v_smith_slope_lobe(v3(a, 0), v3(a, 3), read(a, 6))]
        }),
    ]
}

fn samples() -> Vec<Case> {
    let uniform = || Sweep::new(600).linear(0.0, 0.999).linear(0.0, 1.0);
    // The second width is a share of the first, or the first of the second.
    let widths = |sweep: Sweep, ratio: f64| {
        let mut inputs = sweep.log(0.001, 1.0).log(1.0 / ratio, 1.0).inputs();
        for (i, call) in inputs.iter_mut().enumerate() {
            let end = call.len();
            call[end - 1] *= call[end - 2];
            call[end - 2..].rotate_right(i % 2);
        }
        inputs
    };
    let mut all = Vec::new();
    // Stretched by unequal widths, the error of an angle grows.
    for (ratio, absolute) in [(3.0, 2e-6), (30.0, 3e-5)] {
        let bound = Bound { absolute, relative: 0.0 };
        let ends = vec![vec![1.0, 0.3, 0.2, 0.4], vec![0.0, 0.0, 0.0, 0.0]];
        all.push(case("mf_sample_ggx", [widths(uniform(), ratio), ends].concat(), bound, |a| {
            twins::sample_ggx(v2(a, 0), a[2], a[3]).to_array().into()
        }));
        let ends = vec![vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]];
        all.push(case("mf_sample_ggx_visible", [widths(uniform().hemisphere(), ratio), ends].concat(), bound, |a| {
            twins::sample_ggx_visible(v2(a, 0), v3(a, 2), a[5], a[6]).to_array().into()
        }));
    }
    let widths = |sweep: Sweep| sweep.log(0.001, 1.0).log(0.001, 1.0);
    let pairs = half(800).hemisphere().log(0.01, 1.0).log(0.01, 1.0).inputs();
    all.extend([
        case("mf_pdf_ggx", widths(half(500)).inputs(), ROUNDING, |a| vec![twins::pdf_ggx(v3(a, 0), a[3], a[4])]),
        // v.m may be small by cancellation where D is at its peak.
        case("mf_pdf_ggx_visible", pairs, Bound { absolute: 1e-5, relative: 1e-6 }, |a| {
            vec![twins::pdf_ggx_visible(v3(a, 0), v3(a, 3), a[6], a[7])]
        }),
    ]);
    all
}
