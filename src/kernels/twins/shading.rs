//! Twins of `kernels/wgsl/shading.wgsl`.

use std::f64::consts::PI;

use glam::{DMat2, DVec2, DVec3};

use super::moments::{gaussian_cdf, gaussian_pdf};
use super::ndf::{self, GRAZING};
use super::roughness::SMOOTHEST;

/// `f0 + (1 - f0) (1 - v.h)^5`.
pub fn schlick(f0: DVec3, v_h: f64) -> DVec3 {
    f0.lerp(DVec3::ONE, (1.0 - v_h).clamp(0.0, 1.0).powi(5))
}

/// Unit.
pub fn half_vector(l: DVec3, v: DVec3) -> DVec3 {
    if (l + v).length_squared() < 1e-12 { DVec3::Z } else { (l + v).normalize() }
}

/// Of the tensor alpha^2 I.
pub fn specular_ggx(l: DVec3, v: DVec3, f0: DVec3, alpha: f64) -> DVec3 {
    let a2 = alpha.max(SMOOTHEST).powi(2);
    specular_ggx_tensor(l, v, f0, DVec3::new(a2, 0.0, a2))
}

/// `F D G2 / (4 n.l n.v)`.
pub fn specular_ggx_tensor(l: DVec3, v: DVec3, f0: DVec3, r: DVec3) -> DVec3 {
    if l.z <= 0.0 || v.z <= 0.0 {
        return DVec3::ZERO;
    }
    let h = half_vector(l, v);
    schlick(f0, v.dot(h)) * ndf::d_ggx_tensor(h, r) * ndf::v_smith_ggx_tensor(l, v, r)
}

/// The fit, as a quotient of two sums of products of powers of n.v and alpha.
pub fn energy_loss_ggx(n_v: f64, alpha: f64) -> f64 {
    let (z, a) = (n_v.clamp(0.0, 1.0), alpha.clamp(SMOOTHEST, 1.0));
    let sum = |terms: &[[f64; 3]]| terms.iter().map(|t| t[0] * z.powf(t[1]) * a.powf(t[2])).sum::<f64>();
    let above = [[0.2683, 1.0, 2.0], [4.1529, 1.0, 4.0], [0.1285, 3.0, 2.0]];
    let below = [
        [1.0, 0.0, 3.0],
        [-0.6346, 1.0, 2.0],
        [0.5886, 2.0, 1.0],
        [0.3574, 3.0, 0.0],
        [1.0023, 0.5, 2.5],
        [5.6488, 1.0, 3.0],
        [-1.4708, 2.0, 2.0],
    ];
    sum(&above) / sum(&below)
}

/// The fit.
pub fn energy_loss_ggx_mean(alpha: f64) -> f64 {
    let a = alpha.clamp(SMOOTHEST, 1.0);
    (14.537 * a.powi(2) + 9.128 * a.powi(3)) / (1.0 + 17.313 * a.sqrt() - 11.192 * a + 32.897 * a * a)
}

/// Kulla & Conty's term with Hill's factor.
pub fn multiscatter_ggx(n_l: f64, n_v: f64, f0: DVec3, alpha: f64) -> DVec3 {
    let average = 1.0 - energy_loss_ggx_mean(alpha);
    let f = f0 * (20.0 / 21.0) + DVec3::splat(1.0 / 21.0);
    let colour = f * f * average / (DVec3::ONE - f * (1.0 - average));
    colour * (energy_loss_ggx(n_l, alpha) * energy_loss_ggx(n_v, alpha) / (PI * (1.0 - average)))
}

/// `1 + f0 (1 - E) / E`.
pub fn turquin_scale(n_v: f64, f0: DVec3, alpha: f64) -> DVec3 {
    let e = 1.0 - energy_loss_ggx(n_v, alpha);
    DVec3::ONE + f0 * ((1.0 - e) / e)
}

/// As Hammon 2017 writes it.
pub fn diffuse_hammon(l: DVec3, v: DVec3, albedo: DVec3, alpha: f64) -> DVec3 {
    if l.z <= 0.0 || v.z <= 0.0 {
        return DVec3::ZERO;
    }
    let facing = 0.25 * (l + v).length_squared();
    let n_h = (l.z + v.z).max(GRAZING) / (l + v).length();
    let rough = if facing > 0.0 { facing * (0.9 - 0.4 * facing) * (0.5 + n_h) / n_h } else { 0.0 };
    let share = |x: f64| -(5.0 * (-x).ln_1p()).exp_m1();
    let smooth = 1.05 * share(l.z) * share(v.z);
    let once = (smooth + alpha * (rough - smooth)) / PI;
    albedo * (DVec3::splat(once) + 0.1159 * alpha * albedo)
}

/// `max(0, mean . l)`.
pub fn diffuse_mean_normal(mean: DVec3, l: DVec3) -> f64 {
    mean.dot(l).max(0.0)
}

/// `c Phi(c / tau) + tau phi(c / tau)`.
pub fn diffuse_gaussian(l: DVec3, mean: DVec2, covariance: DVec3) -> f64 {
    let c = l.z - mean.dot(l.truncate());
    let tau = ndf::tensor_quadratic(covariance, l.truncate()).sqrt();
    if tau == 0.0 { c.max(0.0) } else { (c * gaussian_cdf(c / tau) + tau * gaussian_pdf(c / tau)).max(0.0) }
}

/// `2 (v . n) n - v` for the unit n.
pub fn reflected(v: DVec3, n: DVec3) -> DVec3 {
    let n = n.normalize_or_zero();
    2.0 * v.dot(n) * n - v
}

/// By the cross products of Filament's text.
pub fn reflection_filament(v: DVec3, anisotropy: f64, perceptual: f64) -> DVec3 {
    let thin = if anisotropy >= 0.0 { DVec3::Y } else { DVec3::X };
    let across = thin.cross(v).cross(thin);
    let n = DVec3::Z.lerp(across, anisotropy.abs() * (5.0 * perceptual).clamp(0.0, 1.0));
    reflected(v, n.truncate().extend(n.z.max(GRAZING)))
}

/// The normal `(B v.xy, sigma (1 + tr R / 2))` for what bends, B.
fn bent_by(v: DVec3, r: DVec3, b: DMat2) -> DVec3 {
    let z = v.z.max(0.0);
    let sigma = 0.5 * (z + (z * z + ndf::tensor_quadratic(r, v.truncate())).sqrt());
    reflected(v, (b * v.truncate()).extend((sigma * (1.0 + 0.5 * (r.x + r.z))).max(GRAZING)))
}

/// Bent by R.
pub fn mean_reflection_ggx(v: DVec3, r: DVec3) -> DVec3 {
    bent_by(v, r, super::geometric_aa::matrix(r))
}

/// Bent by R without its smaller eigenvalue.
pub fn bent_reflection_ggx(v: DVec3, r: DVec3) -> DVec3 {
    let m = super::geometric_aa::matrix(r);
    let least = 0.5 * (r.x + r.z) - (0.5 * (r.x - r.z)).hypot(r.y);
    bent_by(v, r, m - DMat2::IDENTITY * least)
}

#[cfg(test)]
mod tests;
