//! Laws of the twins, and how good the fits are.

use std::f64::consts::TAU;

use super::ndf::{lambda_ggx_aniso, sample_ggx_visible};
use super::*;

/// Reflected light, F = 1: its amount, which is the directional albedo, and its sum of directions. By midpoints of the
/// normals that v sees, of which G2 / G1 are not shadowed.
fn reflection(v: DVec3, ax: f64, ay: f64, [rows, columns]: [usize; 2]) -> (f64, DVec3) {
    let before = 1.0 + lambda_ggx_aniso(v, ax, ay);
    let mut sums = (0.0, DVec3::ZERO);
    for i in 0..rows * columns {
        // Denser towards both ends of the caps' heights.
        let w = ((i / columns) as f64 + 0.5) / rows as f64;
        let (u, weight) = (w * w * (3.0 - 2.0 * w), 6.0 * w * (1.0 - w) / (rows * columns) as f64);
        let m = sample_ggx_visible(DVec2::new(u, ((i % columns) as f64 + 0.5) / columns as f64), v, ax, ay);
        let l = reflected(v, m);
        if l.z > 0.0 {
            let part = weight * before / (before + lambda_ggx_aniso(l, ax, ay));
            sums = (sums.0 + part, sums.1 + part * l);
        }
    }
    sums
}

fn albedo(n_v: f64, alpha: f64) -> f64 {
    reflection(DVec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v), alpha, alpha, [64, 64]).0
}

fn direction(z: f64, angle: f64) -> DVec3 {
    let p = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(p * angle.cos(), p * angle.sin(), z)
}

/// The mean over the hemisphere weighted by 2 cos, denser towards the horizon.
fn over_cosines(n: usize, f: impl Fn(f64) -> f64) -> f64 {
    let at = |i: usize| {
        let x = (i as f64 + 0.5) / n as f64;
        6.0 * x.powi(5) * f(x.powi(3)) / n as f64
    };
    (0..n).map(at).sum()
}

#[test]
fn the_albedo_is_the_integral_of_the_brdf() {
    for (n_v, alpha) in [(0.9, 0.5), (0.3, 0.6), (0.5, 1.0)] {
        let v = direction(n_v, 0.0);
        let turn =
            |z: f64, k: usize| specular_ggx(direction(z, TAU * (k as f64 + 0.5) / 200.0), v, DVec3::ONE, alpha).x;
        let sum = over_cosines(200, |z| PI * (0..200).map(|k| turn(z, k)).sum::<f64>() / 200.0);
        assert!((sum - albedo(n_v, alpha)).abs() < 1e-3, "{sum} {}", albedo(n_v, alpha));
    }
}

#[test]
fn lost_light_is_fitted_as_stated() {
    let (mut worst, mut worst_mean, mut worst_furnace, mut worst_scale) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for alpha in [0.001, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.77, 0.9, 1.0] {
        let returned =
            over_cosines(60, |z| multiscatter_ggx(z, 1.0, DVec3::ONE, alpha).x * PI) / energy_loss_ggx(1.0, alpha);
        for n_v in
            [0.0126, 0.03, 0.3, 0.6, 1.0].into_iter().chain([0.5, 1.0, 2.0, 4.0].map(|t| f64::min(t * alpha, 1.0)))
        {
            let e = albedo(n_v, alpha);
            worst = worst.max((1.0 - energy_loss_ggx(n_v, alpha) - e).abs());
            worst_furnace = worst_furnace.max((e + returned * energy_loss_ggx(n_v, alpha) - 1.0).abs());
            worst_scale = worst_scale.max((e * turquin_scale(n_v, DVec3::ONE, alpha).x - 1.0).abs());
        }
        let mean = over_cosines(24, |z| albedo(z, alpha));
        worst_mean = worst_mean.max((1.0 - energy_loss_ggx_mean(alpha) - mean).abs());
    }
    let all = [worst, worst_mean, worst_furnace, worst_scale];
    assert!(all.iter().zip([0.008, 0.004, 0.013, 0.03]).all(|(error, stated)| *error < stated), "{all:?}");
}

#[test]
fn reciprocal() {
    let (f0, r) = (DVec3::new(0.04, 0.5, 1.0), DVec3::new(0.3, 0.1, 0.08));
    let close = |a: DVec3, b: DVec3| assert!((a - b).length() <= 1e-12 * a.length(), "{a} {b}");
    for i in 1..60 {
        let (l, v) = (direction(f64::from(i) / 60.0, f64::from(i)), direction(1.0 - f64::from(i * i) / 3600.0, 0.3));
        close(specular_ggx(l, v, f0, 0.4), specular_ggx(v, l, f0, 0.4));
        close(specular_ggx_tensor(l, v, f0, r), specular_ggx_tensor(v, l, f0, r));
        close(multiscatter_ggx(l.z, v.z, f0, 0.4), multiscatter_ggx(v.z, l.z, f0, 0.4));
        close(diffuse_hammon(l, v, f0, 0.4), diffuse_hammon(v, l, f0, 0.4));
        let a2 = 0.4 * 0.4;
        close(specular_ggx(l, v, f0, 0.4), specular_ggx_tensor(l, v, f0, DVec3::new(a2, 0.0, a2)));
    }
}

#[test]
fn hammons_albedo() {
    let white = |n_v: f64, alpha: f64| {
        let v = direction(n_v, 0.0);
        let turn =
            |z: f64, k: usize| diffuse_hammon(direction(z, TAU * (k as f64 + 0.5) / 100.0), v, DVec3::ONE, alpha).x;
        over_cosines(120, |z| PI * (0..100).map(|k| turn(z, k)).sum::<f64>() / 100.0)
    };
    let most = |alpha| [0.01, 0.05, 0.2, 0.5, 0.9, 1.0].map(|n_v| white(n_v, alpha)).into_iter().fold(0.0, f64::max);
    // 1.05 is 21 / 20: with it, the smooth term returns what Fresnel's term at v lets in.
    for n_v in [0.1, 0.4, 1.0] {
        assert!((white(n_v, 0.0) - (1.0 - (1.0 - n_v).powi(5))).abs() < 1e-3);
    }
    assert!(most(0.25) < 1.03 && most(0.25) > 1.01 && most(1.0) < 1.17 && most(1.0) > 1.15);
}

#[test]
fn diffuse_of_gaussian_slopes() {
    let (mean, covariance) = (DVec2::new(0.3, -0.2), DVec3::new(0.2, 0.05, 0.1));
    for (z, angle) in [(0.9, 0.4), (0.1, 2.0), (0.0, 4.0), (-0.3, 1.0)] {
        let l = direction(z, angle);
        let tau = ndf::tensor_quadratic(covariance, l.truncate()).sqrt();
        let lit = |x: f64| (l.z - mean.dot(l.truncate()) - tau * x).max(0.0) * gaussian_pdf(x);
        let sum: f64 = (0..40_000).map(|i| lit((f64::from(i) + 0.5) / 2000.0 - 10.0) / 2000.0).sum();
        assert!((sum - diffuse_gaussian(l, mean, covariance)).abs() < 1e-6);
    }
    // Where every facet is lit, its mean normal is enough.
    let normals = [DVec3::new(0.3, 0.1, 1.0), DVec3::new(-0.4, 0.2, 1.0)].map(DVec3::normalize);
    let l = direction(0.8, 1.0);
    let sum = 0.5 * (normals[0].dot(l) + normals[1].dot(l));
    assert!((diffuse_mean_normal(0.5 * (normals[0] + normals[1]), l) - sum).abs() < 1e-12);
}

/// Errors in degrees against the mean direction of the lobe, mean and worst: of the mirror direction, Filament's, the mean
/// reflection and the bent one.
#[test]
fn directions_to_look_up() {
    let (mut sums, mut worst, mut count) = ([[0.0f64; 4]; 2], [[0.0f64; 4]; 2], [0.0f64; 2]);
    for perceptual in [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8] {
        for anisotropy in [0.0, 0.5, 0.9] {
            for (elevation, angle) in (0..9).map(|i| ([20.0f64, 50.0, 75.0][i / 3], [0.0f64, 45.0, 90.0][i % 3])) {
                let alpha: f64 = perceptual * perceptual;
                let (ax, ay) = (alpha * (1.0 + anisotropy), alpha * (1.0 - anisotropy));
                let v = direction(elevation.to_radians().cos(), angle.to_radians());
                let r = DVec3::new(ax * ax, 0.0, ay * ay);
                let target = reflection(v, ax, ay, [24, 32]).1;
                let found = [
                    reflected(v, DVec3::Z),
                    reflection_filament(v, anisotropy, perceptual),
                    mean_reflection_ggx(v, r),
                    bent_reflection_ggx(v, r),
                ];
                let which = usize::from(anisotropy > 0.0);
                count[which] += 1.0;
                for (k, found) in found.into_iter().enumerate() {
                    let degrees = found.cross(target).length().atan2(found.dot(target)).to_degrees();
                    sums[which][k] += degrees;
                    worst[which][k] = worst[which][k].max(degrees);
                }
            }
        }
    }
    let mean = [0, 1].map(|i| sums[i].map(|sum| sum / count[i]));
    let below = |found: f64, stated: f64| assert!(found < stated && found > 0.9 * stated, "{mean:?} {worst:?}");
    // Round lobes: the mirror direction, and the mean reflection.
    for (k, average, most) in [(0, 13.0, 57.0), (2, 1.3, 5.7)] {
        below(mean[0][k], average);
        below(worst[0][k], most);
    }
    // Lobes of two widths.
    for (k, average, most) in [(0, 16.0, 98.0), (1, 22.0, 133.0), (2, 3.0, 11.0), (3, 3.5, 23.0)] {
        below(mean[1][k], average);
        below(worst[1][k], most);
    }
}

#[test]
fn bends_vanish() {
    let v = direction(0.4, 0.7);
    let mirror = DVec3::new(-v.x, -v.y, v.z);
    for alpha in [0.001, 0.3, 1.0] {
        let round = DVec3::new(alpha * alpha, 0.0, alpha * alpha);
        assert!((bent_reflection_ggx(v, round) - mirror).length() < 1e-12);
    }
    let smooth = DVec3::new(1e-6, 0.0, 1e-8);
    assert!((bent_reflection_ggx(v, smooth) - mirror).length() < 1e-5);
    assert!((mean_reflection_ggx(v, smooth) - mirror).length() < 1e-5);
    // alpha is 0.04 here: the lobe is 5 degrees wide, and bent by more than that.
    assert!((reflection_filament(v, 0.5, 0.2) - mirror).length() > 0.3);
}

/// The albedo of a lobe of two widths by that of a round one: of the mean of alpha^2, of the geometric mean, of the width
/// along v.
#[test]
fn two_widths_as_one() {
    let (mut sums, mut worst) = ([0.0f64; 3], 0.0f64);
    for alpha in [0.05, 0.1, 0.2, 0.4] {
        for (elevation, angle) in
            (0..16).map(|i| ([5.0f64, 40.0, 65.0, 80.0][i / 4], [0.0f64, 30.0, 60.0, 90.0][i % 4]))
        {
            let (ax, ay) = (alpha * f64::sqrt(2.0), alpha / f64::sqrt(2.0));
            let (n_v, angle) = (elevation.to_radians().cos(), angle.to_radians());
            let e = reflection(direction(n_v, angle), ax, ay, [48, 48]).0;
            let means = [(0.5 * (ax * ax + ay * ay)).sqrt(), alpha, (ax * angle.cos()).hypot(ay * angle.sin())];
            for (sum, mean) in sums.iter_mut().zip(means) {
                *sum += (1.0 - energy_loss_ggx(n_v, mean) - e).abs() / 64.0;
            }
            worst = worst.max((1.0 - energy_loss_ggx(n_v, means[0]) - e).abs());
        }
    }
    assert!(sums[0] < 0.8 * sums[1] && sums[1] < sums[2] && sums[0] < 0.015 && worst < 0.1, "{sums:?} {worst}");
}
