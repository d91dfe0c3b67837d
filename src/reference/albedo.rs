//! How much a GGX lobe reflects.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;

use super::lobe::{PreparedLobe, quadratic};
use crate::ndf::Lobe;
use crate::roughness::Alpha;

/// Entries for cosines and for alpha; both are spaced evenly in the square root, where the albedo is smooth.
const SIDE: usize = 64;

/// Rings and spokes of the quadrature for each entry.
const RINGS: usize = 32;

/// Directional albedo of an isotropic GGX lobe, F = 1, height-correlated Smith masking, single scattering:
/// `E(v) = integral of D G2 / (4 n.v) over l`, for `cos = n . v` and `alpha`, both 0 to 1. What is missing to 1 is what
/// scatters between facets (Kulla & Conty 2017; Turquin 2019 multiplies by 1/E). Bilinear in a table that is made at
/// first use; within 0.005 of the integral, or 0.05 within a degree of the horizon.
pub fn directional_albedo(cos: f64, alpha: Alpha) -> f64 {
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let at = |i: usize| (i as f64 / (SIDE - 1) as f64).powi(2);
        (0..SIDE * SIDE).map(|i| integrate(at(i % SIDE).max(1e-4), at(i / SIDE), RINGS)).collect()
    });
    let place = |v: f64| v.clamp(0.0, 1.0).sqrt() * (SIDE - 1) as f64;
    let (x, y) = (place(cos), place(f64::from(alpha.0)));
    let corner = |v: f64| (v as usize).min(SIDE - 2);
    let (i, j) = (corner(x), corner(y));
    let (s, t) = (x - i as f64, y - j as f64);
    let at = |i: usize, j: usize| table[j * SIDE + i];
    let row = |j: usize| at(i, j) + (at(i + 1, j) - at(i, j)) * s;
    row(j) + (row(j + 1) - row(j)) * t
}

/// Mean of [`directional_albedo`] over views, weighted by their cosine: `2 integral E cos dcos`, the share that the lobe
/// reflects of light from everywhere. Linear between the same entries, within 0.003.
pub fn average_albedo(alpha: Alpha) -> f64 {
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        const VIEWS: usize = 400;
        let cos = |i: usize| (i as f64 + 0.5) / VIEWS as f64;
        let alpha = |j: usize| Alpha((j as f64 / (SIDE - 1) as f64).powi(2) as f32);
        let mean = |j: usize| (0..VIEWS).map(|i| 2.0 * cos(i) * directional_albedo(cos(i), alpha(j))).sum::<f64>();
        (0..SIDE).map(|j| mean(j) / VIEWS as f64).collect()
    });
    let place = f64::from(alpha.0).clamp(0.0, 1.0).sqrt() * (SIDE - 1) as f64;
    let j = (place as usize).min(SIDE - 2);
    table[j] + (table[j + 1] - table[j]) * (place - j as f64)
}

/// Midpoint rule over the visible normals: with `m` drawn by `G1 (v.m) D / (n.v)`, E is the mean of G2 / G1(v)
/// (Heitz 2014, sec. 5). Visible normals by Heitz 2018: a disk of the stretched view, squeezed in its lower half. What
/// is lost is lost at the disk's rim, where facets are steep: `1 - y^4` puts more rings there.
fn integrate(cos: f64, alpha: f64, n: usize) -> f64 {
    let lobe = PreparedLobe::new(&Lobe::isotropic(glam::Vec3::Z, Alpha(alpha as f32)), 1.0);
    let alpha = alpha.max(f64::from(Alpha::SMOOTHEST.0));
    let v = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let stretched = DVec3::new(alpha * v.x, 0.0, v.z).normalize();
    let (right, up) = (DVec3::Y, stretched.cross(DVec3::Y));
    let lambda2 = |w: DVec3| quadratic(&lobe.ellipsoid, w).sqrt() / w.z;
    let mut sum = 0.0;
    for i in 0..n * n {
        let (y, turn) = (((i % n) as f64 + 0.5) / n as f64, ((i / n) as f64 + 0.5) / n as f64);
        let (r, phi) = ((1.0 - y.powi(4)).sqrt(), 2.0 * PI * turn);
        let a = r * phi.cos();
        let s = 0.5 * (1.0 + stretched.z);
        let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * r * phi.sin();
        let facet = a * right + b * up + (1.0 - a * a - b * b).max(0.0).sqrt() * stretched;
        let m = DVec3::new(alpha * facet.x, alpha * facet.y, facet.z.max(0.0)).normalize();
        let l = 2.0 * v.dot(m) * m - v;
        if l.z > 0.0 {
            // 1 + Lambda(v) + Lambda(l) over 1 + Lambda(v).
            sum += 4.0 * y.powi(3) * (1.0 + lambda2(v)) / (lambda2(v) + lambda2(l));
        }
    }
    sum / (n * n) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean albedo `2 integral E cos dcos`, against values computed apart from this code (three digits).
    #[test]
    fn average_albedo_is_the_known_one() {
        let known = [(0.05, 0.991), (0.1, 0.972), (0.2, 0.915), (0.4, 0.774), (0.6, 0.631), (0.8, 0.508), (1.0, 0.409)];
        for (alpha, expected) in known {
            let mean = average_albedo(Alpha(alpha));
            assert!((mean - expected).abs() < 3e-3, "alpha {alpha}: {mean} {expected}");
        }
    }

    #[test]
    fn table_is_close_to_the_integral_between_its_entries() {
        for i in 0..300 {
            let (cos, alpha) = (((i * 37 % 300) as f64 + 0.5) / 300.0, ((i * 71 % 300) as f64 + 0.5) / 300.0);
            let (table, integral) = (directional_albedo(cos, Alpha(alpha as f32)), integrate(cos, alpha, 6 * RINGS));
            let bound = if cos < 0.0175 { 0.05 } else { 5e-3 };
            assert!((table - integral).abs() < bound, "cos {cos}, alpha {alpha}: {table} {integral}");
        }
    }

    /// Seen from above at alpha 1, `E = 1 - ln 2 = 0.307`: D = 1/pi and G2 = 2c / (1 + c) for a light at cosine c.
    #[test]
    fn widest_lobe_in_closed_form() {
        assert!((directional_albedo(1.0, Alpha(1.0)) - (1.0 - 2f64.ln())).abs() < 2e-3);
        assert!((directional_albedo(0.7, Alpha(0.0)) - 1.0).abs() < 1e-3);
    }
}
