//! The laws of every lobe.

use std::f64::consts::{PI, TAU};
use std::fmt::Debug;

use glam::{DVec3, Vec3};
use proptest::prelude::*;

use super::*;
use crate::random::Random;
use crate::roughness::Alpha;

trait Law: ShapeInvariant + Debug {}
impl<L: ShapeInvariant + Debug> Law for L {}

fn axes(alpha_x: f32, alpha_y: f32, angle: f32) -> RoughnessTensor {
    RoughnessTensor::from_axes(Axes { alpha_x: Alpha(alpha_x), alpha_y: Alpha(alpha_y), angle })
}

/// Normals and widths.
fn placed() -> Vec<(Vec3, RoughnessTensor)> {
    let tilted = Vec3::new(0.3, -0.4, 0.8).normalize();
    let round = |alpha| RoughnessTensor::isotropic(Alpha(alpha));
    vec![(Vec3::Z, round(0.5)), (tilted, round(0.2)), (Vec3::Z, axes(0.6, 0.2, 0.5)), (tilted, axes(0.5, 0.3, -1.2))]
}

const TAILS: [f32; 4] = [1.7, 2.0, 3.5, 40.0];

fn lobes() -> Vec<Box<dyn Law>> {
    let mut lobes: Vec<Box<dyn Law>> = Vec::new();
    for (normal, roughness) in placed() {
        lobes.push(Box::new(Lobe { normal, roughness }));
        lobes.push(Box::new(Beckmann { normal, roughness }));
        lobes.extend(
            TAILS.map(|tail| -> Box<dyn Law> { Box::new(Student { normal, roughness, tail: TailExponent(tail) }) }),
        );
    }
    lobes
}

/// Midpoint rule over the hemisphere about the lobe's own normal: `f` gets each direction and its solid angle. Cosines
/// are `(1 - w^2)^power` for even w, dense at the peak; powers above 1 resolve what heavy tails do at the horizon.
fn hemisphere<L: ShapeInvariant + ?Sized>(lobe: &L, n: usize, power: i32, mut f: impl FnMut(DVec3, f64)) {
    let normal = lobe.normal();
    let frame = Frame::bent(normal);
    for i in 0..n {
        let w = (i as f64 + 0.5) / n as f64;
        let z = (1.0 - w * w).powi(power);
        let cell = TAU / (n * n) as f64 * 2.0 * w * f64::from(power) * (1.0 - w * w).powi(power - 1);
        let r = (1.0 - z * z).sqrt();
        for j in 0..n {
            let (s, c) = (TAU * (j as f64 + 0.5) / n as f64).sin_cos();
            f(r * c * frame.tangent.as_dvec3() + r * s * frame.bitangent.as_dvec3() + z * normal.as_dvec3(), cell);
        }
    }
}

#[test]
fn projected_area_of_the_facets_is_one() {
    for lobe in lobes() {
        let mut sum = 0.0;
        hemisphere(&*lobe, 500, 2, |m, cell| sum += lobe.pdf(m) * cell);
        assert!((sum - 1.0).abs() < 2e-3, "{lobe:?}: {sum}");
    }
}

/// Projected area towards v, divided by G1, is n.v.
#[test]
fn smith_conserves_projected_area() {
    for lobe in lobes() {
        for v in [DVec3::Z, DVec3::new(0.6, 0.1, 0.5).normalize(), DVec3::new(-0.3, 0.9, 0.2).normalize()] {
            let nv = v.dot(lobe.normal().as_dvec3());
            if nv <= 0.05 {
                continue;
            }
            let mut area = 0.0;
            hemisphere(&*lobe, 500, 3, |m, cell| area += lobe.d(m) * m.dot(v).max(0.0) * cell);
            let expected = nv * (1.0 + lobe.lambda(v));
            assert!((area / expected - 1.0).abs() < 4e-3, "{lobe:?} {v}: {area} {expected}");
        }
    }
}

/// Weak white furnace: with masking alone, all that a view sees leaves again, `integral D G1 / (4 n.v) dl = 1`
/// (Heitz 2014, section 4); with shadowing too, none is gained.
#[test]
fn furnaces_gain_no_energy() {
    for lobe in lobes() {
        let n = lobe.normal().as_dvec3();
        let v = (n + 0.9 * Frame::bent(lobe.normal()).tangent.as_dvec3()).normalize();
        let (mut weak, mut strong) = (0.0, 0.0);
        hemisphere(&*lobe, 500, 3, |m, cell| {
            // dl = 4 (v.m) dm.
            let spread = 4.0 * v.dot(m).max(0.0) * cell;
            weak += lobe.d(m) / (4.0 * n.dot(v) * (1.0 + lobe.lambda(v))) * spread;
            strong += lobe.specular(v, 2.0 * v.dot(m) * m - v) * spread;
        });
        assert!((weak - 1.0).abs() < 4e-3, "{lobe:?}: {weak}");
        assert!(strong < 1.0 && strong > 0.3, "{lobe:?}: {strong}");
    }
}

/// Pearson's chi-square of `sample` against `pdf` on 12 x 12 cells of cosine and azimuth, at the 0.1 percent point.
/// Cells where fewer than 5 are expected are taken together.
pub(super) fn samples_follow<L: ShapeInvariant + ?Sized>(lobe: &L, random: &mut Random, what: &str) {
    const N: usize = 12;
    const DRAWS: usize = 40_000;
    let cell_of = |m: DVec3| {
        let m = lobe.local(m);
        let z = ((m.z.clamp(0.0, 1.0) * N as f64) as usize).min(N - 1);
        let phi = (m.y.atan2(m.x) / TAU + 0.5) * N as f64;
        z * N + (phi as usize).min(N - 1)
    };
    let mut expected = vec![0.0; N * N];
    hemisphere(lobe, 1200, 1, |m, cell| expected[cell_of(m)] += lobe.pdf(m) * cell * DRAWS as f64);
    let mut observed = vec![0.0; N * N];
    for _ in 0..DRAWS {
        observed[cell_of(lobe.sample([random.uniform(), random.uniform()]))] += 1.0;
    }
    let (mut chi2, mut cells, mut rest) = (0.0, 0.0, (0.0, 0.0));
    let mut add = |expected: f64, observed: f64| {
        if expected < 5.0 {
            return false;
        }
        chi2 += (observed - expected).powi(2) / expected;
        cells += 1.0;
        true
    };
    for (&e, &o) in expected.iter().zip(&observed) {
        if !add(e, o) {
            rest = (rest.0 + e, rest.1 + o);
        }
    }
    add(rest.0, rest.1);
    // Wilson-Hilferty: 0.1 percent point of chi-square with k degrees of freedom (z = 3.09).
    let k: f64 = cells - 1.0;
    let limit = k * (1.0 - 2.0 / (9.0 * k) + 3.09 * (2.0 / (9.0 * k)).sqrt()).powi(3);
    assert!(chi2 < limit, "{what}: chi-square {chi2} over {limit} with {k} degrees of freedom");
}

#[test]
fn samples_follow_the_pdf() {
    for (i, lobe) in lobes().iter().enumerate() {
        samples_follow(&**lobe, &mut Random::new(1, i as u64), &format!("{lobe:?}"));
    }
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs()) || a == b
}

/// A unit vector above the horizon of `n`.
fn above(n: Vec3, x: f64, y: f64) -> DVec3 {
    let frame = Frame::bent(n);
    (n.as_dvec3() + x * frame.tangent.as_dvec3() + y * frame.bitangent.as_dvec3()).normalize()
}

proptest! {
    #[test]
    fn tail_exponent_2_is_ggx(
        alpha_x in 0.02f32..1.0, alpha_y in 0.02f32..1.0, angle in -1.5f32..1.5, tilt in -0.8f32..0.8,
        v in (-9.0f64..9.0, -9.0f64..9.0), l in (-9.0f64..9.0, -9.0f64..9.0), u in (0.0f64..0.9999, 0.0f64..1.0),
    ) {
        let normal = Vec3::new(tilt, 0.2, 1.0).normalize();
        let lobe = Lobe { normal, roughness: axes(alpha_x, alpha_y, angle) };
        let student = Student::from(lobe);
        let (v, l) = (above(normal, v.0, v.1), above(normal, l.0, l.1));
        prop_assert!(close(lobe.d(v), student.d(v), 1e-12), "{} {}", lobe.d(v), student.d(v));
        prop_assert!((lobe.lambda(v) - student.lambda(v)).abs() < 1e-10 * (1.0 + lobe.lambda(v)));
        prop_assert!(close(lobe.specular(v, l), student.specular(v, l), 1e-10));
        prop_assert!((lobe.sample([u.0, u.1]) - student.sample([u.0, u.1])).length() < 1e-10);
    }

    /// To first order in `c = 1 / (gamma - 1)`.
    #[test]
    fn large_exponents_tend_to_beckmann(
        alpha_x in 0.1f32..1.0, alpha_y in 0.1f32..1.0, angle in -1.5f32..1.5, v in (-1.5f64..1.5, -1.5f64..1.5),
        u in (0.0f64..0.99, 0.0f64..1.0),
    ) {
        let (normal, roughness) = (Vec3::new(0.3, 0.2, 1.0).normalize(), axes(alpha_x, alpha_y, angle));
        let beckmann = Beckmann { normal, roughness };
        let v = above(normal, v.0, v.1);
        let peak = beckmann.d(normal.as_dvec3());
        let apart = |gamma| {
            let student = Student { normal, roughness, tail: TailExponent(gamma) };
            let moved = (student.sample([u.0, u.1]) - beckmann.sample([u.0, u.1])).length();
            ((student.d(v) - beckmann.d(v)).abs() / peak).max((student.lambda(v) - beckmann.lambda(v)).abs()).max(moved)
        };
        prop_assert!(apart(1e3) < 6e-3, "{}", apart(1e3));
        prop_assert!(apart(1e6) < 6e-6, "{}", apart(1e6));
        prop_assert!(apart(f32::INFINITY) < 1e-14);
    }

    /// Smith's Lambda by its definition: slopes drawn evenly from the lobe's own quantiles, no marginal involved.
    #[test]
    fn lambda_is_the_mean_excess_of_the_slopes(
        c in 0.0f64..1.3, alpha_x in 0.1f32..1.0, alpha_y in 0.1f32..1.0, angle in -1.5f32..1.5,
        tan in 0.2f64..30.0, turn in 0.0f64..TAU,
    ) {
        let student =
            Student { normal: Vec3::Z, roughness: axes(alpha_x, alpha_y, angle), tail: TailExponent::from_weight(c) };
        let v = DVec3::new(tan * turn.cos(), tan * turn.sin(), 1.0);
        const N: usize = 500;
        let mut mean = 0.0;
        for i in 0..N {
            // Graded, so that the steep end of the tail is resolved: 1 - u = w^8.
            let w = (i as f64 + 0.5) / N as f64;
            let share = 8.0 * w.powi(7) / (N * N) as f64;
            for j in 0..N {
                let m = student.sample([1.0 - w.powi(8), (j as f64 + 0.5) / N as f64]);
                // A facet is seen from behind where the slope along v exceeds 1 / tan.
                mean += share * (-m.dot(v) / m.z).max(0.0);
            }
        }
        let lambda = student.lambda(v);
        prop_assert!((lambda - mean).abs() < 2e-3 * (1.0 + mean), "gamma {:?}: {lambda} {mean}", student.tail);
    }
}

/// What is known in closed form.
#[test]
fn lambda_worked_by_hand() {
    let lambda = |gamma: f32, a: f64| TailExponent(gamma).unit_lambda(1.0 / (a * a));
    // erf(1) and erf(3) from tables (Abramowitz & Stegun 1964, table 7.1).
    let beckmann = |a: f64, erf: f64| 0.5 * (erf - 1.0) + (-a * a).exp() / (2.0 * a * PI.sqrt());
    assert!((lambda(f32::INFINITY, 1.0) - beckmann(1.0, 0.842_700_792_949_715)).abs() < 1e-14);
    assert!((lambda(f32::INFINITY, 3.0) - beckmann(3.0, 0.999_977_909_503_001)).abs() < 1e-14);
    // gamma = 5/2, nu = 3: P = (1 + 2/3 x^2)^-2 sqrt(8/3) / pi, and its tail is elementary.
    for a in [0.01f64, 0.3, 1.0, 2.5, 40.0] {
        let (x, k) = (a * (2.0f64 / 3.0).sqrt(), (2.0f64 / 3.0).sqrt());
        let tail = 0.5 - (x / (1.0 + x * x) + x.atan()) / PI;
        let mean = 1.0 / (PI * k * (1.0 + x * x));
        assert!((lambda(2.5, a) - (mean / a - tail)).abs() < 1e-11 / a, "{a}: {} {}", lambda(2.5, a), mean / a - tail);
    }
    // Straight down nothing is masked; along the surface everything is, and at 3/2 always.
    assert_eq!(lambda(2.5, f64::INFINITY), 0.0);
    assert_eq!(lambda(2.5, 0.0), f64::INFINITY);
    assert_eq!(lambda(1.5, 1.0), f64::INFINITY);
    // The mean slope, to which Lambda is proportional at grazing angles, at the heaviest tail that is fitted.
    let grazing = |tail: TailExponent| tail.unit_lambda(1e12) * 1e-6;
    let ratio = grazing(TailExponent::HEAVIEST) / grazing(TailExponent::GGX);
    assert!((2.7..3.0).contains(&ratio), "{ratio}");
}

#[test]
fn exponents_and_weights() {
    assert_eq!(TailExponent::GGX.weight(), 1.0);
    assert_eq!(TailExponent::BECKMANN.weight(), 0.0);
    assert_eq!(TailExponent::from_weight(0.0), TailExponent::BECKMANN);
    assert_eq!(TailExponent::from_weight(0.5), TailExponent(3.0));
    assert_eq!(TailExponent(3.0).degrees_of_freedom(), 4.0);
}
