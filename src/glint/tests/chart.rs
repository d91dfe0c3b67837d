//! The chart is uniform, and its inverse is one.

use glam::{DVec2, DVec3};

use crate::glint::{Macro, Tail, pcg4d, unit};
use crate::ndf::RoughnessTensor;
use crate::roughness::Alpha;

/// Round, stretched, sheared, off the middle, with both tails.
fn lobes() -> Vec<Macro> {
    let mut lobes = Vec::new();
    for tail in [Tail::Ggx, Tail::Beckmann] {
        lobes.push(Macro { tail, ..Macro::isotropic(Alpha(0.4)) });
        lobes.push(Macro {
            mean: DVec2::new(0.2, -0.35),
            roughness: RoughnessTensor { xx: 0.25, xy: 0.06, yy: 0.03 },
            tail,
        });
        lobes.push(Macro { mean: DVec2::new(-0.5, 0.0), tail, ..Macro::isotropic(Alpha(0.05)) });
    }
    lobes
}

#[test]
fn chart_and_inverse_agree() {
    for lobe in lobes() {
        let chart = lobe.chart().unwrap();
        for n in 0..20_000 {
            let h = pcg4d([n, 1, 2, 3]);
            let y = DVec2::new(unit(h[0]), unit(h[1]));
            let m = chart.normal(y);
            assert!((m.length() - 1.0).abs() < 1e-12 && m.z > 0.0);
            // Close to grazing, digits of the fraction are lost.
            let edge = (y - 0.5).abs().max_element();
            assert!(edge > 0.4999 || chart.square(m).distance(y) < 1e-7, "{lobe:?} at {y}: {}", chart.square(m));
        }
    }
}

/// The Jacobian of the chart, by differences, is the density; and the density alone is that of the textbooks.
#[test]
fn chart_is_uniform() {
    for lobe in lobes() {
        let chart = lobe.chart().unwrap();
        for n in 0..4000 {
            let h = pcg4d([n, 5, 2, 3]);
            let y = DVec2::new(unit(h[0]), unit(h[1])) * 0.96 + 0.02;
            // Diagonals are creases of the concentric map.
            let c = (y - 0.5).abs();
            if (c.x - c.y).abs() < 1e-3 || c.max_element() < 1e-3 {
                continue;
            }
            let e = 1e-5;
            let d = |s: DVec2| (chart.normal(y + s) - chart.normal(y - s)) / (2.0 * e);
            let solid_angle = d(DVec2::X * e).cross(d(DVec2::Y * e)).length();
            let density = chart.density(chart.normal(y));
            assert!((solid_angle * density - 1.0).abs() < 1e-4, "{lobe:?} at {y}: {}", solid_angle * density);
        }
    }
    let chart = Macro::isotropic(Alpha(0.3)).chart().unwrap();
    let (cos, a2) = (0.8f64, f64::from(0.3f32 * 0.3));
    let h = DVec3::new(0.6 * 0.28, -0.6 * 0.96, 0.8);
    // Walter et al. 2007, eq. 33, times the cosine.
    let expected = a2 / (std::f64::consts::PI * (cos * cos * (a2 - 1.0) + 1.0).powi(2)) * cos;
    assert!((chart.density(h) / expected - 1.0).abs() < 1e-6);
}

/// Flakes by the textbook's sampling of GGX (polar angles), not by this chart: counts of the square's 16 x 16 boxes
/// within 5 standard deviations of chi-squared.
#[test]
fn sampled_normals_fill_the_chart() {
    let chart = Macro::isotropic(Alpha(0.3)).chart().unwrap();
    let mut boxes = [0u32; 256];
    for n in 0..200_000 {
        let h = pcg4d([n, 9, 2, 3]);
        let (u, phi) = (unit(h[0]), std::f64::consts::TAU * unit(h[1]));
        let tan = f64::from(0.3f32) * (u / (1.0 - u)).sqrt();
        let m = DVec3::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalize();
        let y = chart.square(m) * 16.0;
        boxes[y.x.min(15.0) as usize * 16 + y.y.min(15.0) as usize] += 1;
    }
    let mean = 200_000.0 / 256.0;
    let chi2: f64 = boxes.iter().map(|b| (f64::from(*b) - mean).powi(2) / mean).sum();
    assert!((chi2 - 255.0).abs() < 5.0 * 510f64.sqrt(), "{chi2}");
}

#[test]
fn lobes_that_are_not_finite_have_no_chart() {
    let mut lobe = Macro::isotropic(Alpha(f32::NAN));
    lobe.roughness.xx = f32::INFINITY;
    assert!(lobe.chart().is_none());
    let mirror = Macro::isotropic(Alpha(0.0)).chart().unwrap();
    assert!(mirror.density(DVec3::Z).is_finite() && mirror.square(DVec3::Z) == DVec2::splat(0.5));
    let wrong = Macro { roughness: RoughnessTensor { xx: 0.01, xy: 1.0, yy: 0.01 }, ..Macro::isotropic(Alpha(0.1)) };
    assert!(wrong.chart().unwrap().density(DVec3::new(0.6, 0.0, 0.8)).is_finite());
}
