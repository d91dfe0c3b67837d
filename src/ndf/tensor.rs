//! The anisotropic width of a lobe.

use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Mul, Sub};

use crate::roughness::Alpha;

/// Symmetric 2x2 matrix with eigenvalues alpha_x^2 and alpha_y^2, in a tangent frame of the lobe: the form to
/// average and store. For a GGX lobe, `D = 1 / (pi sqrt(det R) (p^T R^-1 p + m_z^2)^2)` with p the tangential
/// part of m (Heitz 2014, anisotropic GGX, written as a matrix).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoughnessTensor {
    /// Along the tangent.
    pub xx: f32,
    /// Mixed term, 0 for an isotropic lobe.
    pub xy: f32,
    /// Along the bitangent.
    pub yy: f32,
}

/// The read-out of a tensor: two widths and the direction of the larger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// The larger width.
    pub alpha_x: Alpha,
    /// The smaller width.
    pub alpha_y: Alpha,
    /// Radians from the tangent to the axis of alpha_x, counter-clockwise, in (-pi/2, pi/2]; 0 if isotropic.
    pub angle: f32,
}

impl RoughnessTensor {
    /// The same width along every direction.
    pub fn isotropic(alpha: Alpha) -> Self {
        let a2 = alpha.squared();
        Self { xx: a2, xy: 0.0, yy: a2 }
    }

    /// `alpha_x` along the direction at `angle` radians from the tangent, `alpha_y` across it.
    pub fn from_axes(axes: Axes) -> Self {
        let (s, c) = axes.angle.sin_cos();
        Self { xx: axes.alpha_x.squared(), xy: 0.0, yy: axes.alpha_y.squared() }.rotated(c, s)
    }

    /// Widths and direction; the larger width first.
    pub fn axes(self) -> Axes {
        let (mean, spread) = self.mean_and_spread();
        let mut angle = if spread > 0.0 { 0.5 * (2.0 * self.xy).atan2(self.xx - self.yy) } else { 0.0 };
        if angle <= -FRAC_PI_2 {
            angle += PI;
        }
        Axes { alpha_x: Alpha::from_squared(mean + spread), alpha_y: Alpha::from_squared(mean - spread), angle }
    }

    /// Half the trace: alpha^2 of the isotropic lobe with the same mean squared width.
    #[inline(always)]
    pub fn mean(self) -> f32 {
        0.5 * (self.xx + self.yy)
    }

    /// Half the trace, and half the difference of the eigenvalues.
    #[inline(always)]
    pub fn mean_and_spread(self) -> (f32, f32) {
        let half = 0.5 * (self.xx - self.yy);
        (self.mean(), (half * half + self.xy * self.xy).sqrt())
    }

    /// The tensor turned counter-clockwise by the angle with this cosine and sine.
    #[inline(always)]
    pub fn rotated(self, cos: f32, sin: f32) -> Self {
        let (cc, ss, cs) = (cos * cos, sin * sin, cos * sin);
        Self {
            xx: cc * self.xx - 2.0 * cs * self.xy + ss * self.yy,
            xy: cs * (self.xx - self.yy) + (cc - ss) * self.xy,
            yy: ss * self.xx + 2.0 * cs * self.xy + cc * self.yy,
        }
    }

    /// Eigenvalues clamped to `low..=high` (squared widths), axes kept. Free of branches, so that rows of
    /// tensors are clamped in vector registers.
    #[inline(always)]
    pub fn clamped(self, low: f32, high: f32) -> Self {
        let (mean, spread) = self.mean_and_spread();
        let (a, b) = ((mean + spread).max(low).min(high), (mean - spread).max(low).min(high));
        let scale = if spread > 0.0 { (a - b) / (2.0 * spread) } else { 0.0 };
        let (mid, half) = (0.5 * (a + b), 0.5 * (self.xx - self.yy) * scale);
        Self { xx: mid + half, xy: self.xy * scale, yy: mid - half }
    }

    /// Determinant, `(alpha_x alpha_y)^2`.
    pub fn determinant(self) -> f32 {
        self.xx * self.yy - self.xy * self.xy
    }
}

impl Add for RoughnessTensor {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { xx: self.xx + o.xx, xy: self.xy + o.xy, yy: self.yy + o.yy }
    }
}

impl Sub for RoughnessTensor {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { xx: self.xx - o.xx, xy: self.xy - o.xy, yy: self.yy - o.yy }
    }
}

impl Mul<f32> for RoughnessTensor {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: f32) -> Self {
        Self { xx: self.xx * k, xy: self.xy * k, yy: self.yy * k }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn axes_worked_by_hand() {
        // Widths 0.5 and 0.1 at 45 degrees: mean (0.25 + 0.01) / 2 = 0.13, off-diagonal (0.25 - 0.01) / 2.
        let tensor = RoughnessTensor::from_axes(Axes { alpha_x: Alpha(0.5), alpha_y: Alpha(0.1), angle: PI / 4.0 });
        assert!((tensor.xx - 0.13).abs() < 1e-6 && (tensor.yy - 0.13).abs() < 1e-6);
        assert!((tensor.xy - 0.12).abs() < 1e-6);
        assert_eq!(RoughnessTensor::isotropic(Alpha(0.3)).axes().angle, 0.0);
    }

    proptest! {
        #[test]
        fn axes_round_trip(a in 0.01f32..1.0, ratio in 0.01f32..1.0, angle in -1.57f32..1.57) {
            let axes = Axes { alpha_x: Alpha(a), alpha_y: Alpha(a * ratio), angle };
            let tensor = RoughnessTensor::from_axes(axes);
            let back = RoughnessTensor::from_axes(tensor.axes());
            let close = |x: f32, y: f32| (x - y).abs() <= 2e-6 * a * a;
            prop_assert!(close(tensor.xx, back.xx) && close(tensor.xy, back.xy) && close(tensor.yy, back.yy));
            prop_assert!(tensor.axes().alpha_x >= tensor.axes().alpha_y);
        }

        #[test]
        fn clamping_keeps_axes_and_bounds(a in 0.0f32..3.0, b in 0.0f32..3.0, angle in -1.5f32..1.5) {
            let tensor = RoughnessTensor::from_axes(Axes { alpha_x: Alpha(a), alpha_y: Alpha(b), angle });
            let axes = tensor.clamped(0.01, 1.0).axes();
            prop_assert!(axes.alpha_x.0 <= 1.0 + 1e-5 && axes.alpha_y.0 >= 0.1 - 1e-3);
            let inside = RoughnessTensor::from_axes(Axes { alpha_x: Alpha(0.8), alpha_y: Alpha(0.3), angle });
            let same = inside.clamped(0.01, 1.0);
            prop_assert!((same.xx - inside.xx).abs() < 1e-6 && (same.xy - inside.xy).abs() < 1e-6);
        }
    }
}
