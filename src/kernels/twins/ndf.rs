//! Twins of `kernels/wgsl/ndf.wgsl`.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3};

use super::moments::bent;
use super::roughness::SMOOTHEST;

/// A GGX lobe as a density of slopes about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeLobe {
    /// The most frequent slope.
    pub centre: DVec2,
    /// xx, xy, yy: squared widths.
    pub scatter: DVec3,
}

/// A lobe of one width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundLobe {
    /// Unit.
    pub normal: DVec3,
    /// Its width.
    pub alpha: f64,
}

/// Cosines count from this where something is divided by them.
pub const GRAZING: f64 = 1e-6;

/// Determinants count from this share of xx yy.
pub const LEAST_DETERMINANT: f64 = 2e-7;

/// As the round lobe stretched.
pub fn d_ggx(n_h: f64, alpha: f64) -> f64 {
    let z = n_h.min(1.0);
    d_ggx_aniso(DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z), alpha, alpha)
}

/// As the round lobe stretched.
pub fn d_ggx_tangent(m: DVec3, alpha: f64) -> f64 {
    d_ggx_aniso(m, alpha, alpha)
}

/// In the frame in which n is z.
pub fn d_ggx_cross(n: DVec3, h: DVec3, alpha: f64) -> f64 {
    d_ggx_aniso(DVec3::new(n.cross(h).length(), 0.0, n.dot(h)), alpha, alpha)
}

/// `1 / (pi ax ay ((m.x / ax)^2 + (m.y / ay)^2 + m.z^2)^2)`.
pub fn d_ggx_aniso(m: DVec3, alpha_x: f64, alpha_y: f64) -> f64 {
    if m.z <= 0.0 {
        return 0.0;
    }
    let (ax, ay) = (alpha_x.max(SMOOTHEST), alpha_y.max(SMOOTHEST));
    1.0 / (PI * ax * ay * DVec3::new(m.x / ax, m.y / ay, m.z).length_squared().powi(2))
}

/// With the floors of the shader.
pub fn tensor_determinant(r: DVec3) -> f64 {
    let product = r.x.max(SMOOTHEST.powi(2)) * r.z.max(SMOOTHEST.powi(2));
    (product - r.y * r.y).max(LEAST_DETERMINANT * product)
}

/// `p^T R p`.
pub fn tensor_quadratic(r: DVec3, p: DVec2) -> f64 {
    (r.x * p.x * p.x + 2.0 * r.y * p.x * p.y + r.z * p.y * p.y).max(0.0)
}

/// `p^T R^-1 p` by the factors `R = L D L^T`, so that a determinant at its floor keeps it positive.
pub fn tensor_inverse_quadratic(r: DVec3, p: DVec2) -> f64 {
    let (xx, yy) = (r.x.max(SMOOTHEST.powi(2)), r.z.max(SMOOTHEST.powi(2)));
    let (first, second, large) = if xx >= yy { (p.x, p.y, xx) } else { (p.y, p.x, yy) };
    first * first / large + (second - r.y / large * first).powi(2) * large / tensor_determinant(r)
}

/// `P22 / m.z^4`.
pub fn d_ggx_tensor(m: DVec3, r: DVec3) -> f64 {
    if m.z <= 0.0 { 0.0 } else { p22_ggx(-m.truncate() / m.z, r) / m.z.powi(4) }
}

/// `1 / (pi sqrt(det R) (1 + s^T R^-1 s)^2)`.
pub fn p22_ggx(s: DVec2, r: DVec3) -> f64 {
    1.0 / (PI * tensor_determinant(r).sqrt() * (1.0 + tensor_inverse_quadratic(r, s)).powi(2))
}

/// `exp(-s^T R^-1 s) / (pi sqrt(det R))`.
pub fn p22_beckmann(s: DVec2, r: DVec3) -> f64 {
    (-tensor_inverse_quadratic(r, s)).exp() / (PI * tensor_determinant(r).sqrt())
}

/// `log(1 + x)`.
pub fn log_one_plus(x: f64) -> f64 {
    x.ln_1p()
}

/// `(1 + s^T R^-1 s / (gamma - 1))^-gamma / (pi sqrt(det R))`.
pub fn p22_student(s: DVec2, r: DVec3, gamma: f64) -> f64 {
    let fall = gamma * (tensor_inverse_quadratic(r, s) / (gamma - 1.0)).ln_1p();
    (-fall).exp() / (PI * tensor_determinant(r).sqrt())
}

/// `P22 / m.z^4`.
pub fn d_beckmann(m: DVec3, r: DVec3) -> f64 {
    let z = m.z.max(GRAZING);
    if m.z <= 0.0 { 0.0 } else { p22_beckmann(-m.truncate() / z, r) / z.powi(4) }
}

/// `P22 / m.z^4`.
pub fn d_student(m: DVec3, r: DVec3, gamma: f64) -> f64 {
    let z = m.z.max(GRAZING);
    if m.z <= 0.0 { 0.0 } else { p22_student(-m.truncate() / z, r, gamma) / z.powi(4) }
}

/// The ellipsoid `S = n n^T + (t b) R (t b)^T` of a lobe.
pub fn ellipsoid(n: DVec3, r: DVec3) -> DMat3 {
    let (t, b) = bent(n);
    let outer = |a: DVec3, c: DVec3| DMat3::from_cols(a * c.x, a * c.y, a * c.z);
    outer(n, n) + outer(t, t) * r.x + (outer(t, b) + outer(b, t)) * r.y + outer(b, b) * r.z
}

/// `u = -S_pz / S_zz` and `P = S_pp / S_zz - u u^T`.
pub fn slope_lobe(n: DVec3, r: DVec3) -> SlopeLobe {
    let s = ellipsoid(n, r);
    let s = s * (1.0 / s.z_axis.z.max(SMOOTHEST.powi(2)));
    let u = -s.z_axis.truncate();
    let scatter = DVec3::new(s.x_axis.x - u.x * u.x, s.x_axis.y - u.x * u.y, s.y_axis.y - u.y * u.y);
    SlopeLobe { centre: u, scatter }
}

/// Of the tensor alpha^2 I.
pub fn slope_lobe_round(n: DVec3, alpha: f64) -> SlopeLobe {
    let a2 = alpha.max(SMOOTHEST).powi(2);
    slope_lobe(n, DVec3::new(a2, 0.0, a2))
}

/// The eigenvector of S with the largest eigenvalue, in the plane of z and the tilt, by its angle.
pub fn round_lobe(lobe: SlopeLobe) -> RoundLobe {
    let tilt = lobe.centre.length();
    let along = if tilt > 0.0 { lobe.centre / tilt } else { DVec2::X };
    let aa = tensor_quadratic(lobe.scatter, along).max(SMOOTHEST.powi(2));
    let cc = tensor_quadratic(lobe.scatter, along.perp()).max(SMOOTHEST.powi(2));
    let (side, cross) = (1.0 - aa - tilt * tilt, 2.0 * tilt);
    let (sin, cos) = (0.5 * cross.atan2(side)).sin_cos();
    let largest = 0.5 * (1.0 + aa + tilt * tilt + side.hypot(cross));
    RoundLobe { normal: (-along * sin).extend(cos), alpha: (aa * cc / largest.powi(3)).sqrt().sqrt() }
}

/// Of the slope from the centre.
pub fn p22_slope_lobe(s: DVec2, lobe: SlopeLobe) -> f64 {
    p22_ggx(s - lobe.centre, lobe.scatter)
}

/// `P22 / m.z^4`.
pub fn d_slope_lobe(m: DVec3, lobe: SlopeLobe) -> f64 {
    if m.z <= 0.0 { 0.0 } else { p22_slope_lobe(-m.truncate() / m.z, lobe) / m.z.powi(4) }
}

/// `(sqrt(1 + t) - 1) / 2`.
pub fn lambda_ggx(v: DVec3, r: DVec3) -> f64 {
    let t = tensor_quadratic(r, v.truncate()) / v.z.max(GRAZING).powi(2);
    0.5 * (0.5 * t.ln_1p()).exp_m1()
}

/// The same from two widths.
pub fn lambda_ggx_aniso(v: DVec3, alpha_x: f64, alpha_y: f64) -> f64 {
    lambda_ggx(v, DVec3::new(alpha_x * alpha_x, 0.0, alpha_y * alpha_y))
}

/// `exp(x^2) erfc(x)`: the series of erf below 2.5, a continued fraction above.
pub fn erfc_scaled(x: f64) -> f64 {
    if x < 2.5 {
        return (x * x).exp() * super::moments::erfc(x);
    }
    let tail = (1..=60).rev().fold(x, |tail, n| x + 0.5 * f64::from(n) / tail);
    1.0 / (PI.sqrt() * tail)
}

/// `(erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi))`.
pub fn lambda_beckmann(v: DVec3, r: DVec3) -> f64 {
    let a = v.z.max(GRAZING) / tensor_quadratic(r, v.truncate()).sqrt();
    if a.is_infinite() { 0.0 } else { 0.5 * (-a * a).exp() * (1.0 / (a * PI.sqrt()) - erfc_scaled(a)) }
}

/// `1 / (1 + Lambda)`.
pub fn g1(lambda: f64) -> f64 {
    1.0 / (1.0 + lambda)
}

/// `1 / (1 + Lambda(v) + Lambda(l))`.
pub fn g2(lambda_v: f64, lambda_l: f64) -> f64 {
    1.0 / (1.0 + lambda_v + lambda_l)
}

/// `G2 / (4 n.l n.v)`.
pub fn v_smith_ggx(n_l: f64, n_v: f64, alpha: f64) -> f64 {
    let direction = |z: f64| DVec3::new((1.0 - z * z).max(0.0).sqrt(), 0.0, z);
    v_smith_ggx_aniso(direction(n_l.max(GRAZING)), direction(n_v.max(GRAZING)), alpha, alpha)
}

/// `G2 / (4 n.l n.v)`.
pub fn v_smith_ggx_aniso(l: DVec3, v: DVec3, alpha_x: f64, alpha_y: f64) -> f64 {
    let (ax, ay) = (alpha_x.max(SMOOTHEST), alpha_y.max(SMOOTHEST));
    v_smith_ggx_tensor(l, v, DVec3::new(ax * ax, 0.0, ay * ay))
}

/// `G2 / (4 n.l n.v)`.
pub fn v_smith_ggx_tensor(l: DVec3, v: DVec3, r: DVec3) -> f64 {
    g2(lambda_ggx(v, r), lambda_ggx(l, r)) / (4.0 * l.z.max(GRAZING) * v.z.max(GRAZING))
}

/// What stands in the place of a cosine: `v.z - u . v.xy`.
pub fn mean_cosine(v: DVec3, lobe: SlopeLobe) -> f64 {
    v.z - lobe.centre.dot(v.truncate())
}

/// `(c + sqrt(c^2 + f)) / 2`.
pub fn sigma_slope_lobe(v: DVec3, lobe: SlopeLobe) -> f64 {
    let (c, f) = (mean_cosine(v, lobe), tensor_quadratic(lobe.scatter, v.truncate()));
    let root = (c * c + f).sqrt();
    if c < 0.0 { 0.5 * f / (root - c) } else { 0.5 * (c + root) }
}

/// `1 / (1 + Lambda)` about the mean plane.
pub fn g1_slope_lobe(v: DVec3, lobe: SlopeLobe) -> f64 {
    let c = mean_cosine(v, lobe);
    if c <= 0.0 { 0.0 } else { g1(lambda_ggx(v.truncate().extend(c), lobe.scatter)) }
}

/// `G2 / (4 c_l c_v)`.
pub fn v_smith_slope_lobe(l: DVec3, v: DVec3, lobe: SlopeLobe) -> f64 {
    let (cl, cv) = (mean_cosine(l, lobe), mean_cosine(v, lobe));
    if cl <= 0.0 || cv <= 0.0 {
        return 0.0;
    }
    v_smith_ggx_tensor(l.truncate().extend(cl), v.truncate().extend(cv), lobe.scatter)
}

/// Slopes of the round lobe of unit width within a radius of `sqrt(u / (1 - u))` are a share u, stretched.
pub fn sample_ggx(u: DVec2, alpha_x: f64, alpha_y: f64) -> DVec3 {
    let (sin, cos) = (TAU * u.y).sin_cos();
    let (ax, ay) = (alpha_x.max(SMOOTHEST), alpha_y.max(SMOOTHEST));
    DVec3::new(ax * u.x.sqrt() * cos, ay * u.x.sqrt() * sin, (1.0 - u.x).sqrt()).normalize()
}

/// `D m.z`.
pub fn pdf_ggx(m: DVec3, alpha_x: f64, alpha_y: f64) -> f64 {
    d_ggx_aniso(m, alpha_x, alpha_y) * m.z.max(0.0)
}

/// A point of the cap z above -s.z, plus s, stretched back.
pub fn sample_ggx_visible(u: DVec2, v: DVec3, alpha_x: f64, alpha_y: f64) -> DVec3 {
    let (ax, ay) = (alpha_x.max(SMOOTHEST), alpha_y.max(SMOOTHEST));
    let s = DVec3::new(ax * v.x, ay * v.y, v.z.max(0.0)).normalize_or_zero();
    let z = (1.0 - u.x) * (1.0 + s.z) - s.z;
    let (sin, cos) = (TAU * u.y).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let h = DVec3::new(radius * cos, radius * sin, z) + s;
    DVec3::new(ax * h.x, ay * h.y, h.z.max(0.0)).normalize_or_zero()
}

/// `D max(0, v . m) / sigma(v)`.
pub fn pdf_ggx_visible(m: DVec3, v: DVec3, alpha_x: f64, alpha_y: f64) -> f64 {
    let (ax, ay) = (alpha_x.max(SMOOTHEST), alpha_y.max(SMOOTHEST));
    let z = v.z.max(0.0);
    let sigma = 0.5 * (z + DVec3::new(ax * v.x, ay * v.y, z).length());
    d_ggx_aniso(m, ax, ay) * v.dot(m).max(0.0) / sigma.max(1e-8)
}

#[cfg(test)]
mod tests;
