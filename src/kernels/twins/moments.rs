//! Twins of `kernels/wgsl/moments.wgsl`.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use glam::{DMat2, DVec2, DVec3, DVec4};

use super::geometric_aa::{matrix, tensor, with_eigenvalues};
use super::roughness::{alpha_widened_vmf, toksvig};

/// A lobe to shade with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit, in the surface's tangent frame.
    pub normal: DVec3,
    /// xx, xy, yy in the bent frame of the normal.
    pub tensor: DVec3,
}

/// A lobe of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedLobe {
    /// Unit, in the surface's tangent frame.
    pub normal: DVec3,
    /// xx, xy, yy in the bent frame of the normal.
    pub tensor: DVec3,
    /// Share of the texel's area.
    pub weight: f64,
}

/// Mean and covariance of slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Along +u and +v.
    pub mean: DVec2,
    /// xx, xy, yy.
    pub covariance: DVec3,
}

/// Least z of a normal whose slope is told.
pub const STEEPEST_Z: f64 = 0.2;

/// Least cosine to the mean plane that slopes are looked at from.
pub const LEAST_SLOPE_COSINE: f64 = 1e-4;

/// What `energy` textures are over.
pub const LARGEST_ENERGY: f64 = 2.5;

/// Tangent and bitangent of the bent frame: the +u axis made orthogonal to n (`X - n n.x`, for a unit n written so that
/// nothing cancels); -z where n is that axis.
pub fn bent(n: DVec3) -> (DVec3, DVec3) {
    let along = DVec3::new(n.y * n.y + n.z * n.z, -n.x * n.y, -n.x * n.z);
    let tangent = if along.x < 1e-12 { DVec3::NEG_Z } else { along.normalize() };
    (tangent, n.cross(tangent))
}

/// Of components -1 to 1; up where they are no longer than 0.1.
pub fn decode_normal_signed(n: DVec3, y_sign: f64, scale: f64) -> DVec3 {
    let scaled = n * DVec3::new(scale, scale * y_sign, 1.0);
    if n.length_squared() <= 0.01 || scaled.length_squared() < 1e-12 { DVec3::Z } else { scaled.normalize() }
}

/// Of components 0 to 1.
pub fn decode_normal(texel: DVec3, y_sign: f64, scale: f64) -> DVec3 {
    decode_normal_signed(2.0 * texel - DVec3::ONE, y_sign, scale)
}

/// Of two components -1 to 1.
pub fn decode_normal_xy_signed(n: DVec2, y_sign: f64, scale: f64) -> DVec3 {
    decode_normal_signed(n.extend((1.0 - n.length_squared()).max(0.0).sqrt()), y_sign, scale)
}

/// Of two components 0 to 1.
pub fn decode_normal_xy(texel: DVec2, y_sign: f64, scale: f64) -> DVec3 {
    decode_normal_xy_signed(2.0 * texel - DVec2::ONE, y_sign, scale)
}

/// alpha^2 = roughness^4 twice.
pub fn decode_roughness(roughness: f64) -> DVec3 {
    let alpha2 = roughness.powi(4);
    DVec3::new(alpha2, 0.0, alpha2)
}

/// The same of `1 - roughness`.
pub fn decode_gloss(gloss: f64) -> DVec3 {
    decode_roughness(1.0 - gloss)
}

/// glTF's `KHR_materials_anisotropy`; a direction no longer than 0.1 counts as the tangent.
pub fn decode_anisotropy(texel: DVec3, roughness: f64) -> DVec3 {
    let d = 2.0 * texel.truncate() - DVec2::ONE;
    let d = if d.length_squared() <= 0.01 { DVec2::X } else { d.normalize() };
    let across = roughness * roughness;
    let along = across + (1.0 - across) * texel.z * texel.z;
    let turn = DMat2::from_cols(d, d.perp());
    tensor(turn * DMat2::from_diagonal(DVec2::new(along * along, across * across)) * turn.transpose())
}

/// `S^2`, S given as xx, yy, xy.
pub fn decode_tensor_root_signed(root: DVec3) -> DVec3 {
    let s = matrix(DVec3::new(root.x, root.z, root.y));
    tensor(s * s)
}

/// The same with xy as `(128 + 254 xy) / 255`.
pub fn decode_tensor_root(texel: DVec3) -> DVec3 {
    decode_tensor_root_signed(DVec3::new(texel.x, texel.y, (255.0 * texel.z - 128.0) / 254.0))
}

/// Two widths and the angle of the first.
pub fn decode_axes_signed(alpha_x: f64, alpha_y: f64, angle: f64) -> DVec3 {
    let turn = DMat2::from_angle(angle);
    tensor(turn * DMat2::from_diagonal(DVec2::new(alpha_x * alpha_x, alpha_y * alpha_y)) * turn.transpose())
}

/// Two perceptual roughnesses and a turn.
pub fn decode_axes(texel: DVec3) -> DVec3 {
    decode_axes_signed(texel.x * texel.x, texel.y * texel.y, TAU * texel.z)
}

/// Burley 2012, sec. 5.4.
pub fn decode_burley(texel: DVec3) -> DVec3 {
    let (alpha, aspect) = (texel.x * texel.x, (1.0 - 0.9 * texel.y).sqrt());
    decode_axes_signed(alpha / aspect, alpha * aspect, TAU * texel.z)
}

/// Times [`LARGEST_ENERGY`].
pub fn decode_energy(texel: f64) -> f64 {
    LARGEST_ENERGY * texel
}

/// n.x, n.y (-1 to 1), weight, perceptual roughness.
pub fn decode_lobe_signed(texel: DVec4, y_sign: f64, scale: f64) -> WeightedLobe {
    let normal = decode_normal_xy_signed(texel.truncate().truncate(), y_sign, scale);
    WeightedLobe { normal, tensor: decode_roughness(texel.w), weight: texel.z }
}

/// The same with n.x and n.y 0 to 1.
pub fn decode_lobe(texel: DVec4, y_sign: f64, scale: f64) -> WeightedLobe {
    decode_lobe_signed(DVec4::new(2.0 * texel.x - 1.0, 2.0 * texel.y - 1.0, texel.z, texel.w), y_sign, scale)
}

/// Perceptual roughness and weight.
pub fn decode_haze(texel: DVec2, normal: DVec3) -> WeightedLobe {
    WeightedLobe { normal, tensor: decode_roughness(texel.x), weight: texel.y }
}

/// What the further lobes leave.
pub fn first_weight(further: DVec3) -> f64 {
    (1.0 - further.element_sum()).max(0.0)
}

/// Toksvig's gloss factor over a mean normal.
pub fn lobe_toksvig(n: DVec3, alpha: f64) -> Lobe {
    round(n, toksvig(alpha, n.length()))
}

/// The von Mises-Fisher lobe of a mean normal.
pub fn lobe_vmf(n: DVec3, alpha: f64) -> Lobe {
    round(n, alpha_widened_vmf(alpha, n.length()))
}

fn round(n: DVec3, alpha: f64) -> Lobe {
    Lobe { normal: decode_normal_signed(n / n.length().max(1e-6), 1.0, 1.0), tensor: decode_roughness(alpha.sqrt()) }
}

/// Without negative eigenvalues.
pub fn tensor_positive(x: DVec3) -> DVec3 {
    with_eigenvalues(x, |e| e.max(0.0))
}

/// Means, and raw moments xx, yy, xy.
pub fn decode_moments(mean: DVec2, raw: DVec3, y_sign: f64) -> Moments {
    let covariance = DVec3::new(raw.x - mean.x * mean.x, y_sign * (raw.z - mean.x * mean.y), raw.y - mean.y * mean.y);
    Moments { mean: DVec2::new(mean.x, y_sign * mean.y), covariance: tensor_positive(covariance) }
}

/// The slope of a normal.
pub fn moments_of_normal(n: DVec3) -> Moments {
    Moments { mean: -n.truncate() / n.z.max(STEEPEST_Z), covariance: DVec3::ZERO }
}

/// `T m` and `T C T^T`, T by its rows.
pub fn moments_transform(m: Moments, row_x: DVec2, row_y: DVec2) -> Moments {
    let t = DMat2::from_cols(row_x, row_y).transpose();
    Moments { mean: t * m.mean, covariance: tensor(t * matrix(m.covariance) * t.transpose()) }
}

/// Slopes that add up, uncorrelated.
pub fn moments_add(a: Moments, b: Moments) -> Moments {
    Moments { mean: a.mean + b.mean, covariance: a.covariance + b.covariance }
}

/// Raw moments mixed.
pub fn moments_blend(a: Moments, b: Moments, t: f64) -> Moments {
    let product = |m: DVec2| DVec3::new(m.x * m.x, m.x * m.y, m.y * m.y);
    let raw = |m: Moments| m.covariance + product(m.mean);
    let mean = a.mean.lerp(b.mean, t);
    Moments { mean, covariance: raw(a).lerp(raw(b), t) - product(mean) }
}

/// `J`: slopes to the bent frame of n. The derivative of the normal `c (-s, 1)` is `-c ds` and a part along n.
fn to_lobe(n: DVec3) -> DMat2 {
    let (t, b) = bent(n);
    n.z * DMat2::from_cols(t.truncate(), b.truncate()).transpose()
}

/// The mean slope's normal, and `base + 2 J C J^T`.
pub fn lobe_from_moments(m: Moments, base: DVec3) -> Lobe {
    let normal = (-m.mean).extend(1.0).normalize();
    let j = to_lobe(normal);
    Lobe { normal, tensor: base + 2.0 * tensor(j * matrix(m.covariance) * j.transpose()) }
}

/// `J^-1 R J^-T / 2`.
pub fn moments_from_lobe(lobe: Lobe) -> Moments {
    let mean = moments_of_normal(lobe.normal).mean;
    let j = to_lobe((-mean).extend(1.0).normalize()).inverse();
    Moments { mean, covariance: 0.5 * tensor(j * matrix(lobe.tensor) * j.transpose()) }
}

/// Density of the standard normal distribution.
pub fn gaussian_pdf(x: f64) -> f64 {
    (-0.5 * x * x).exp() / TAU.sqrt()
}

/// Its share below x.
pub fn gaussian_cdf(x: f64) -> f64 {
    0.5 * erfc(-x * FRAC_1_SQRT_2)
}

/// The complementary error function: the series of erf below 2.5, [`super::ndf::erfc_scaled`] above.
pub fn erfc(x: f64) -> f64 {
    if x < 0.0 {
        return 2.0 - erfc(-x);
    }
    if x < 2.5 {
        // erf = 2 / sqrt(pi) e^(-x^2) sum 2^n x^(2n+1) / (2n+1)!!: no term is negative.
        let (mut term, mut sum, mut n) = (x, x, 0.0);
        while term > 1e-18 * sum {
            n += 1.0;
            term *= 2.0 * x * x / (2.0 * n + 1.0);
            sum += term;
        }
        return 1.0 - 2.0 / PI.sqrt() * (-x * x).exp() * sum;
    }
    (-x * x).exp() * super::ndf::erfc_scaled(x)
}

/// `c Phi(c / tau) + tau phi(c / tau)`.
pub fn slope_cosine(m: Moments, v: DVec3) -> f64 {
    let (c, tau) = (cosine(m, v), deviation(m, v));
    if tau > 0.0 { c * gaussian_cdf(c / tau) + tau * gaussian_pdf(c / tau) } else { c }
}

fn cosine(m: Moments, v: DVec3) -> f64 {
    (v.z - m.mean.dot(v.truncate())).max(LEAST_SLOPE_COSINE)
}

fn deviation(m: Moments, v: DVec3) -> f64 {
    v.truncate().dot(matrix(m.covariance) * v.truncate()).max(0.0).sqrt()
}

/// `max(0, v.z - s . v.xy)` over its mean.
pub fn visible_weight(m: Moments, v: DVec3, s: DVec2) -> f64 {
    (v.z - s.dot(v.truncate())).max(0.0) / slope_cosine(m, v)
}

/// Moments of the slopes, each with its [`visible_weight`]. Of `x = v.z - s . v.xy`, which is Gaussian, and its weight
/// max(0, x), Stein's lemma gives both.
pub fn visible_moments(m: Moments, v: DVec3) -> Moments {
    let (c, tau, e) = (cosine(m, v), deviation(m, v), slope_cosine(m, v));
    let w = matrix(m.covariance) * v.truncate();
    let (share, density) = if tau > 0.0 { (gaussian_cdf(c / tau), gaussian_pdf(c / tau) / tau) } else { (1.0, 0.0) };
    let factor = (density * e - share * share) / (e * e);
    Moments {
        mean: m.mean - w * share / e,
        covariance: m.covariance + factor * DVec3::new(w.x * w.x, w.x * w.y, w.y * w.y),
    }
}

#[cfg(test)]
mod tests;
