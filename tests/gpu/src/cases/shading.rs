//! Of `kernels/wgsl/shading.wgsl`.

use glam::DVec3;

use super::geometric_aa::{v2, v3};
use super::ndf::{alpha, built, case, half, tensor};
use crate::case::{Bound, Case, Sweep};
use crate::twins::shading as twins;

/// A few roundings of f32, squared.
const ROUNDING: Bound = Bound { absolute: 1e-9, relative: 1e-6 };

/// D squares what a half vector is off by, near mirror directions.
const PEAKED: Bound = Bound { absolute: 1e-9, relative: 2e-6 };

/// Of lobes up to ten times as wide as thin.
const TEN: Bound = Bound { absolute: 1e-9, relative: 6e-6 };

/// Components of unit vectors.
const UNIT: Bound = Bound { absolute: 6e-7, relative: 0.0 };

/// All functions.
pub fn cases() -> Vec<Case> {
    [specular(), energy(), diffuse(), directions()].into_iter().flatten().collect()
}

fn colour(sweep: Sweep) -> Sweep {
    (0..3).fold(sweep, |sweep, _| sweep.linear(0.0, 1.0).edges(&[0.04]))
}

fn list(v: DVec3) -> Vec<f64> {
    v.to_array().into()
}

/// Calls whose first direction is the second, mirrored by a normal within a few widths of z. The width is at `at`.
fn mirrored(calls: Vec<Vec<f64>>, at: usize, square: bool) -> Vec<Vec<f64>> {
    let mirror = |a: Vec<f64>| {
        let width = if square { a[at].sqrt() } else { a[at] };
        let m = (2.0 * width * v3(&a, 0).truncate()).extend(1.0).normalize();
        let v = v3(&a, 3);
        let l = 2.0 * v.dot(m) * m - v;
        [&list(l), &a[3..]].concat()
    };
    calls.into_iter().map(mirror).collect()
}

fn specular() -> Vec<Case> {
    let pairs = || colour(half(500).hemisphere().edges(&[0.0, 0.6, -0.8]));
    let round = || alpha(pairs()).inputs();
    let of_tensor = || built(tensor(pairs(), 0.001, 10.0), 9);
    vec![
        case("mf_schlick", colour(Sweep::new(300)).linear(0.0, 1.0).edges(&[-0.1, 1.1]).inputs(), ROUNDING, |a| {
            list(twins::schlick(v3(a, 0), a[3]))
        }),
        case(
            "mf_half_vector",
            Sweep::new(500).sphere().sphere().and(&[0.0, 0.6, 0.8, 0.0, -0.6, -0.8]).inputs(),
            UNIT,
            |a| list(twins::half_vector(v3(a, 0), v3(a, 3))),
        ),
        case("mf_specular_ggx", [round(), mirrored(round(), 9, false)].concat(), PEAKED, |a| {
            list(twins::specular_ggx(v3(a, 0), v3(a, 3), v3(a, 6), a[9]))
        }),
        case("mf_specular_ggx_tensor", [of_tensor(), mirrored(of_tensor(), 9, true)].concat(), TEN, |a| {
            list(twins::specular_ggx_tensor(v3(a, 0), v3(a, 3), v3(a, 6), v3(a, 9)))
        }),
    ]
}

fn energy() -> Vec<Case> {
    let cosine = |sweep: Sweep| sweep.log(1e-5, 1.0).edges(&[0.0, -0.1, 1.000_001]);
    vec![
        case("mf_energy_loss_ggx", alpha(cosine(Sweep::new(600))).inputs(), ROUNDING, |a| {
            vec![twins::energy_loss_ggx(a[0], a[1])]
        }),
        case("mf_energy_loss_ggx_mean", alpha(Sweep::new(300)).inputs(), ROUNDING, |a| {
            vec![twins::energy_loss_ggx_mean(a[0])]
        }),
        case("mf_multiscatter_ggx", alpha(colour(cosine(cosine(Sweep::new(600))))).inputs(), ROUNDING, |a| {
            list(twins::multiscatter_ggx(a[0], a[1], v3(a, 2), a[5]))
        }),
        case("mf_turquin_scale", alpha(colour(cosine(Sweep::new(600)))).inputs(), ROUNDING, |a| {
            list(twins::turquin_scale(a[0], v3(a, 1), a[4]))
        }),
    ]
}

fn diffuse() -> Vec<Case> {
    let pairs = colour(half(800).hemisphere().edges(&[0.0, 0.6, -0.8, 0.6, -0.8, 0.0])).linear(0.0, 1.0);
    let slopes = Sweep::new(800).sphere().signed_log(1e-3, 2.0).signed_log(1e-3, 2.0);
    vec![
        case("mf_diffuse_hammon", pairs.inputs(), ROUNDING, |a| {
            list(twins::diffuse_hammon(v3(a, 0), v3(a, 3), v3(a, 6), a[9]))
        }),
        case(
            "mf_diffuse_mean_normal",
            Sweep::new(300).sphere().sphere().inputs(),
            Bound { absolute: 2e-7, relative: 0.0 },
            |a| vec![twins::diffuse_mean_normal(v3(a, 0), v3(a, 3))],
        ),
        // As the text states, for deviations up to 1 (the fit of erfc).
        case(
            "mf_diffuse_gaussian",
            built(tensor(slopes, 0.001, 30.0), 5),
            Bound { absolute: 1e-6, relative: 5e-7 },
            |a| vec![twins::diffuse_gaussian(v3(a, 0), v2(a, 3), v3(a, 5))],
        ),
    ]
}

fn directions() -> Vec<Case> {
    vec![
        case("mf_reflected", Sweep::new(500).sphere().sphere().inputs(), UNIT, |a| {
            list(twins::reflected(v3(a, 0), v3(a, 3)))
        }),
        case(
            "mf_reflection_filament",
            half(600).linear(-1.0, 1.0).edges(&[0.0]).linear(0.0, 1.0).inputs(),
            UNIT,
            |a| list(twins::reflection_filament(v3(a, 0), a[3], a[4])),
        ),
        case("mf_mean_reflection_ggx", built(tensor(half(600), 0.001, 30.0), 3), UNIT, |a| {
            list(twins::mean_reflection_ggx(v3(a, 0), v3(a, 3)))
        }),
        case("mf_bent_reflection_ggx", built(tensor(half(600), 0.001, 30.0), 3), UNIT, |a| {
            list(twins::bent_reflection_ggx(v3(a, 0), v3(a, 3)))
        }),
    ]
}
