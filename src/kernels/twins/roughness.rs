//! Twins of `kernels/wgsl/roughness.wgsl`.
//!
//! Tensors are (xx, xy, yy) with eigenvalues alpha^2.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat2, DVec2, DVec3};

/// The smoothest width that lobes are evaluated at.
pub const SMOOTHEST: f64 = 1e-4;

/// The shortest mean normal.
pub const SHORTEST_MEAN: f64 = 1e-4;

/// Two widths and the direction of the larger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// The larger.
    pub alpha_x: f64,
    /// The smaller.
    pub alpha_y: f64,
    /// Radians, in (-pi/2, pi/2].
    pub angle: f64,
}

/// glTF's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gltf {
    /// The smaller width.
    pub alpha: f64,
    /// 0 to 1.
    pub strength: f64,
    /// Unit, along the larger width.
    pub direction: DVec2,
}

/// Disney's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burley {
    /// Geometric mean of the widths.
    pub alpha: f64,
    /// 0 to 1.
    pub anisotropy: f64,
    /// Turns.
    pub rotation: f64,
}

/// Burley 2012, sec. 5.4.
pub fn alpha_from_perceptual(perceptual: f64) -> f64 {
    perceptual.powi(2)
}

/// The other way round.
pub fn perceptual_from_alpha(alpha: f64) -> f64 {
    alpha.max(0.0).sqrt()
}

/// From `1 - perceptual`.
pub fn alpha_from_smoothness(smoothness: f64) -> f64 {
    alpha_from_perceptual(1.0 - smoothness)
}

/// To `1 - perceptual`.
pub fn smoothness_from_alpha(alpha: f64) -> f64 {
    1.0 - perceptual_from_alpha(alpha)
}

/// Of a Beckmann lobe's slopes along an axis.
pub fn variance_from_alpha(alpha: f64) -> f64 {
    alpha.powi(2) / 2.0
}

/// The other way round.
pub fn alpha_from_variance(variance: f64) -> f64 {
    (2.0 * variance.max(0.0)).sqrt()
}

/// `2 / alpha^2`.
pub fn kappa_from_alpha(alpha: f64) -> f64 {
    2.0 / alpha.max(SMOOTHEST).powi(2)
}

/// The other way round, at most 1.
pub fn alpha_from_kappa(kappa: f64) -> f64 {
    if kappa > 2.0 { (2.0 / kappa).sqrt() } else { 1.0 }
}

/// Of Blinn-Phong, `2 / alpha^2 - 2`.
pub fn exponent_from_alpha(alpha: f64) -> f64 {
    2.0 / alpha.max(SMOOTHEST).powi(2) - 2.0
}

/// The other way round.
pub fn alpha_from_exponent(exponent: f64) -> f64 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt()
}

/// `alpha^2 + 2 variance`, at most 1.
pub fn alpha_widened(alpha: f64, variance: f64) -> f64 {
    (alpha.powi(2) + 2.0 * variance).sqrt().min(1.0)
}

/// `X' = X + 2 variance` for `X = alpha^2 / (1 - alpha^2)`, and back.
pub fn alpha_widened_projected(alpha: f64, variance: f64) -> f64 {
    if alpha >= 1.0 {
        return 1.0;
    }
    let x = alpha.powi(2) / (1.0 - alpha.powi(2)) + 2.0 * variance;
    (x / (1.0 + x)).sqrt()
}

/// By way of the exponents: `1/s' = 1/s + (1 - r) / r`.
pub fn toksvig(alpha: f64, mean_length: f64) -> f64 {
    let r = mean_length.clamp(SHORTEST_MEAN, 1.0);
    if alpha >= 1.0 {
        return 1.0;
    }
    let inverse = alpha.powi(2) / (2.0 - 2.0 * alpha.powi(2)) + (1.0 - r) / r;
    (2.0 * inverse / (1.0 + 2.0 * inverse)).sqrt()
}

/// `coth kappa - 1/kappa`, the length of the mean of a von Mises-Fisher distribution.
pub fn mean_length(kappa: f64) -> f64 {
    if kappa < 0.05 {
        let k2 = kappa * kappa;
        return kappa / 3.0 * (1.0 - k2 / 15.0 * (1.0 - 2.0 * k2 / 21.0 * (1.0 - k2 / 10.0)));
    }
    1.0 / kappa.tanh() - 1.0 / kappa
}

/// The inverse of [`mean_length`] by bisection; at most `2 / SMOOTHEST^2`.
pub fn kappa_from_mean_length(mean_length: f64) -> f64 {
    let most = kappa_from_alpha(SMOOTHEST);
    let r = mean_length.clamp(0.0, 1.0);
    // Where e^-2 kappa is lost in the rounding of 1.
    if r > 0.95 {
        return (1.0 / (1.0 - r)).min(most);
    }
    let (mut low, mut high) = (0.0, 50.0);
    for _ in 0..70 {
        let middle = 0.5 * (low + high);
        *(if self::mean_length(middle) < r { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// `alpha^2 + 2 / kappa`, at most 1.
pub fn alpha_widened_vmf(alpha: f64, mean_length: f64) -> f64 {
    if mean_length >= 1.0 {
        return alpha;
    }
    (alpha.powi(2) + 2.0 / kappa_from_mean_length(mean_length)).sqrt().min(1.0)
}

fn tensor(m: DMat2) -> DVec3 {
    DVec3::new(m.x_axis.x, m.x_axis.y, m.y_axis.y)
}

/// `U diag(x, y) U^T` for a rotation by the angle.
fn rotated(x: f64, y: f64, angle: f64) -> DVec3 {
    let turn = DMat2::from_angle(angle);
    tensor(turn * DMat2::from_diagonal(DVec2::new(x, y)) * turn.transpose())
}

/// An angle of an axis, in (-pi/2, pi/2].
fn folded(angle: f64) -> f64 {
    FRAC_PI_2 - (FRAC_PI_2 - angle).rem_euclid(PI)
}

/// The matrix with these widths along rotated axes.
pub fn tensor_from_axes(axes: Axes) -> DVec3 {
    rotated(axes.alpha_x.powi(2), axes.alpha_y.powi(2), axes.angle)
}

/// Eigenvalues of a tensor, the larger first, from trace and determinant.
fn eigenvalues(r: DVec3) -> (f64, f64) {
    let (half, spread) = (0.5 * (r.x + r.z), (0.5 * (r.x - r.z)).hypot(r.y));
    (half + spread, half - spread)
}

/// Roots of the eigenvalues.
pub fn widths_from_tensor(r: DVec3) -> DVec2 {
    let (high, low) = eigenvalues(r);
    DVec2::new(high.max(0.0).sqrt(), low.max(0.0).sqrt())
}

/// Of the larger width.
pub fn direction_from_tensor(r: DVec3) -> DVec2 {
    DVec2::from_angle(angle_of(r))
}

fn angle_of(r: DVec3) -> f64 {
    if r.x == r.z && r.y == 0.0 { 0.0 } else { folded(0.5 * (2.0 * r.y).atan2(r.x - r.z)) }
}

/// Eigenvalues and the angle of the first eigenvector.
pub fn axes_from_tensor(r: DVec3) -> Axes {
    let widths = widths_from_tensor(r);
    Axes { alpha_x: widths.x, alpha_y: widths.y, angle: angle_of(r) }
}

/// With clamped eigenvalues.
pub fn tensor_clamped(r: DVec3, low: f64, high: f64) -> DVec3 {
    let (a, b) = eigenvalues(r);
    rotated(a.clamp(low, high), b.clamp(low, high), angle_of(r))
}

/// From `along = mix(across, 1, strength^2)`.
pub fn gltf_strength(along: f64, across: f64) -> f64 {
    if across < 1.0 { ((along - across) / (1.0 - across)).clamp(0.0, 1.0).sqrt() } else { 0.0 }
}

/// KHR_materials_anisotropy.
pub fn gltf_from_axes(axes: Axes) -> Gltf {
    let Axes { alpha_x, alpha_y, angle } = axes;
    Gltf { alpha: alpha_y, strength: gltf_strength(alpha_x, alpha_y), direction: DVec2::from_angle(angle) }
}

/// By way of the axes.
pub fn gltf_from_tensor(r: DVec3) -> Gltf {
    gltf_from_axes(axes_from_tensor(r))
}

/// Direction, the tangent where it is no longer than 0.1, and larger width.
pub fn gltf_along(g: Gltf) -> DVec3 {
    let direction = if g.direction.length_squared() <= 0.01 { DVec2::X } else { g.direction.normalize() };
    direction.extend(g.alpha * (1.0 - g.strength.powi(2)) + g.strength.powi(2))
}

/// KHR_materials_anisotropy.
pub fn axes_from_gltf(g: Gltf) -> Axes {
    let along = gltf_along(g);
    Axes { alpha_x: along.z, alpha_y: g.alpha, angle: folded(along.truncate().to_angle()) }
}

/// By way of the axes.
pub fn tensor_from_gltf(g: Gltf) -> DVec3 {
    tensor_from_axes(axes_from_gltf(g))
}

/// Burley 2012, sec. 5.4.
pub fn burley_from_axes(axes: Axes) -> Burley {
    let Axes { alpha_x, alpha_y, angle } = axes;
    let ratio = if alpha_x > 0.0 { alpha_y / alpha_x } else { 1.0 };
    Burley {
        alpha: (alpha_x * alpha_y).sqrt(),
        anisotropy: ((1.0 - ratio) / 0.9).clamp(0.0, 1.0),
        rotation: angle.rem_euclid(PI) / (2.0 * PI),
    }
}

/// The other way round.
pub fn axes_from_burley(b: Burley) -> Axes {
    let aspect = (1.0 - 0.9 * b.anisotropy).sqrt();
    Axes { alpha_x: b.alpha / aspect, alpha_y: b.alpha * aspect, angle: folded(2.0 * PI * b.rotation) }
}

/// Arithmetic mean, and half the difference as a share of it.
pub fn kulla_conty_from_axes(axes: Axes) -> DVec2 {
    let mean = 0.5 * (axes.alpha_x + axes.alpha_y);
    DVec2::new(mean, if mean > 0.0 { 0.5 * (axes.alpha_x - axes.alpha_y) / mean } else { 0.0 })
}

/// The other way round.
pub fn axes_from_kulla_conty(alpha: f64, anisotropy: f64, angle: f64) -> Axes {
    let (x, y) = (alpha + alpha * anisotropy, alpha - alpha * anisotropy);
    if x < y {
        return Axes { alpha_x: y, alpha_y: x, angle: folded(angle + FRAC_PI_2) };
    }
    Axes { alpha_x: x, alpha_y: y, angle }
}

#[cfg(test)]
mod tests {
    use super::super::geometric_aa::matrix;
    use super::*;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-10 * (1.0 + a.abs()), "{a} {b}");
    }

    fn same(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-12, "{a} {b}");
    }

    /// Widths, ratios and angles.
    fn lobes() -> impl Iterator<Item = Axes> {
        (0..400).map(|i| {
            let share = |n: f64| (0.618_034 * n * f64::from(i)).fract();
            let alpha_x = 1e-3f64.powf(share(1.0));
            Axes { alpha_x, alpha_y: alpha_x * share(2.7), angle: folded(PI * share(5.1)) }
        })
    }

    #[test]
    fn units_come_back() {
        for i in 1..=100 {
            let alpha = 0.01 * f64::from(i);
            near(alpha_from_perceptual(perceptual_from_alpha(alpha)), alpha);
            near(alpha_from_smoothness(smoothness_from_alpha(alpha)), alpha);
            near(alpha_from_variance(variance_from_alpha(alpha)), alpha);
            near(alpha_from_kappa(kappa_from_alpha(alpha)), alpha);
            near(alpha_from_exponent(exponent_from_alpha(alpha)), alpha);
            let kappa = 0.03 * 1.2f64.powi(i);
            near(kappa_from_mean_length(mean_length(kappa)).min(1e6) / kappa.min(1e6), 1.0);
        }
    }

    /// The mean of cos theta with density `e^(kappa cos theta)`, summed.
    #[test]
    fn mean_length_is_the_mean_cosine() {
        for kappa in [1e-3, 0.04, 0.06, 0.7, 5.0, 40.0] {
            let sum = |power: i32| -> f64 {
                let z = |i: i32| -1.0 + (f64::from(i) + 0.5) / 1e4;
                (0..20000).map(|i| z(i).powi(power) * (kappa * (z(i) - 1.0)).exp()).sum()
            };
            assert!((mean_length(kappa) - sum(1) / sum(0)).abs() < 1e-6, "{kappa}");
        }
    }

    /// `alpha^2 = 0.1`: s = 18; `r = 0.8`: V = 1/4, s' = 36/11, `alpha'^2 = 11/29`.
    #[test]
    fn widened_worked_by_hand() {
        near(toksvig(0.1f64.sqrt(), 0.8), (11.0f64 / 29.0).sqrt());
        near(alpha_widened_projected(0.1f64.sqrt(), 0.25), (11.0f64 / 29.0).sqrt());
        near(alpha_widened(0.6, 0.14), 0.8);
        near(alpha_widened_vmf(0.1, 0.98), (0.01f64 + 2.0 / 50.0).sqrt());
    }

    #[test]
    fn widening_in_parts_is_widening_at_once() {
        for widen in [alpha_widened, alpha_widened_projected] {
            near(widen(widen(0.3, 0.02), 0.05), widen(0.3, 0.07));
        }
    }

    #[test]
    fn every_form_gives_the_lobe_back() {
        for axes in lobes() {
            let r = tensor_from_axes(axes);
            same(tensor_from_axes(axes_from_tensor(r)), r);
            same(tensor_from_gltf(gltf_from_axes(axes)), r);
            same(tensor_from_gltf(gltf_from_tensor(r)), r);
            let kulla_conty = kulla_conty_from_axes(axes);
            same(tensor_from_axes(axes_from_kulla_conty(kulla_conty.x, kulla_conty.y, axes.angle)), r);
            let across = axes_from_kulla_conty(kulla_conty.x, -kulla_conty.y, axes.angle - FRAC_PI_2);
            same(tensor_from_axes(across), r);
            if axes.alpha_y > 0.1 * axes.alpha_x {
                same(tensor_from_axes(axes_from_burley(burley_from_axes(axes))), r);
            }
        }
    }

    #[test]
    fn clamping_bounds_the_width_along_every_direction() {
        for axes in lobes() {
            let r = tensor_from_axes(axes);
            let clamped = matrix(tensor_clamped(r, 0.01, 0.25));
            for i in 0..32 {
                let d = DVec2::from_angle(PI * f64::from(i) / 32.0);
                assert!((0.01 - 1e-12..=0.25 + 1e-12).contains(&d.dot(clamped * d)));
            }
            same(tensor_clamped(r, 0.0, 1.0), r);
        }
    }
}
