//! A lobe of two widths in the forms that engines store, each with its way back.
//!
//! All of them speak of the larger width first, along a direction that turns counter-clockwise from the lobe's tangent in
//! a frame with v up. Where an engine's bitangent runs down, the direction is mirrored: the angle, `c` of the tensor and
//! the sine change sign.

use std::f32::consts::{PI, TAU};

use glam::Vec2;

use super::{Axes, RoughnessTensor};
use crate::roughness::Alpha;

/// Smallest ratio of the widths, smaller over larger, that Burley's parameters reach: `1 - 0.9 A` at `A = 1`.
pub const BURLEY_LEAST_RATIO: f32 = 0.1;

impl Axes {
    /// The same axis, told by the one of its two directions that lies on the side of `main`. Neighbours on one side can
    /// be filtered as vectors; a round lobe, which has no direction, takes `main` itself.
    pub fn sided(self, main: f32) -> Self {
        let angle = if self.alpha_x > self.alpha_y { self.angle } else { main };
        Self { angle: if (angle - main).cos() < 0.0 { angle + PI } else { angle }, ..self }
    }

    /// The direction as a share of a whole turn, 0 to 1. Of the two directions of the axis, the one in the half turn
    /// about `main` that does not run over 1: so neighbours near the main axis can be filtered, and only those across it
    /// are cut apart.
    pub fn turns(self, main: f32) -> f32 {
        let middle = 0.25 + (main / TAU - 0.25).rem_euclid(0.5);
        let away = (self.sided(main).angle / TAU - middle + 0.25).rem_euclid(0.5) - 0.25;
        (middle + away).clamp(0.0, 1.0)
    }
}

/// glTF's `KHR_materials_anisotropy`: the smaller width as the roughness, and strength and direction of the larger by
/// `alpha_t = mix(alpha, 1, strength^2)`. Every lobe with widths up to 1 has this form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gltf {
    /// The smaller width.
    pub alpha: Alpha,
    /// 0 to 1.
    pub strength: f32,
    /// Unit vector along the larger width.
    pub direction: Vec2,
}

impl Gltf {
    /// From widths and direction.
    pub fn from_axes(axes: Axes) -> Self {
        let Axes { alpha_x: Alpha(along), alpha_y: Alpha(across), angle } = axes;
        let strength = if across < 1.0 { ((along - across) / (1.0 - across)).clamp(0.0, 1.0).sqrt() } else { 0.0 };
        let (sin, cos) = angle.sin_cos();
        Self { alpha: Alpha(across), strength, direction: Vec2::new(cos, sin) }
    }

    /// As glTF's sample renderer builds it.
    pub fn tensor(self) -> RoughnessTensor {
        let Self { alpha: Alpha(alpha), strength, direction } = self;
        let along = alpha + (1.0 - alpha) * strength * strength;
        RoughnessTensor { xx: along * along, xy: 0.0, yy: alpha * alpha }.rotated(direction.x, direction.y)
    }
}

/// Disney's parameters (Burley 2012, sec. 5.4): `aspect = sqrt(1 - 0.9 A)`, `alpha_x = alpha / aspect`,
/// `alpha_y = alpha aspect`. Widths further apart than 1 to [`BURLEY_LEAST_RATIO`] become the nearest there are: the same
/// product of widths, `A = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burley {
    /// Geometric mean of the widths; textures hold its root.
    pub alpha: Alpha,
    /// 0 to 1.
    pub anisotropy: f32,
    /// Direction of the larger width as a share of a whole turn, 0 to 1.
    pub rotation: f32,
}

impl Burley {
    /// From widths and direction, told near the direction `main` ([`Axes::turns`]).
    pub fn from_axes(axes: Axes, main: f32) -> Self {
        let (along, across) = (axes.alpha_x.0, axes.alpha_y.0);
        let ratio = if along > 0.0 { across / along } else { 1.0 };
        Self {
            alpha: Alpha((along * across).sqrt()),
            anisotropy: ((1.0 - ratio) / (1.0 - BURLEY_LEAST_RATIO)).clamp(0.0, 1.0),
            rotation: axes.turns(main),
        }
    }

    /// As a Disney material builds it.
    pub fn tensor(self) -> RoughnessTensor {
        let aspect = (1.0 - (1.0 - BURLEY_LEAST_RATIO) * self.anisotropy).sqrt();
        let (alpha_x, alpha_y) = (Alpha(self.alpha.0 / aspect), Alpha(self.alpha.0 * aspect));
        RoughnessTensor::from_axes(Axes { alpha_x, alpha_y, angle: TAU * self.rotation })
    }
}

/// The root of a roughness tensor, `S = R^(1/2)`, whose eigenvalues are the widths themselves: the form to filter. A mix
/// of roots has no width outside those that were mixed, along any direction, and `R = S^2` is a lobe whatever rounding
/// and filtering did to S. (MIPNet, Gauthier et al. 2022, stores the same.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensorRoot {
    /// Along the tangent.
    pub xx: f32,
    /// Mixed term, at most half of the difference of the widths.
    pub xy: f32,
    /// Along the bitangent.
    pub yy: f32,
}

impl TensorRoot {
    /// The root with no eigenvalue below 0: `(R + d I) / sqrt(tr R + 2 d)` with `d = sqrt(det R)`.
    pub fn from_tensor(r: RoughnessTensor) -> Self {
        let d = r.determinant().max(0.0).sqrt();
        let inverse = 1.0 / (r.xx + r.yy + 2.0 * d).max(f32::MIN_POSITIVE).sqrt();
        Self { xx: (r.xx + d) * inverse, xy: r.xy * inverse, yy: (r.yy + d) * inverse }
    }

    /// `S^2`.
    pub fn tensor(self) -> RoughnessTensor {
        let Self { xx, xy, yy } = self;
        RoughnessTensor { xx: xx * xx + xy * xy, xy: (xx + yy) * xy, yy: yy * yy + xy * xy }
    }

    /// As unsigned textures hold it: xx, yy, and xy moved so that 0 is the byte 128: `(128 + 254 xy) / 255`.
    pub fn encoded(self) -> [f32; 3] {
        [self.xx, self.yy, (128.0 + 254.0 * self.xy) / 255.0]
    }

    /// From [`TensorRoot::encoded`], rounded and filtered as it may be.
    pub fn decoded([xx, yy, xy]: [f32; 3]) -> Self {
        Self { xx, xy: (255.0 * xy - 128.0) / 254.0, yy }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f32::consts::FRAC_PI_2;

    fn lobe(along: f32, ratio: f32, angle: f32) -> Axes {
        Axes { alpha_x: Alpha(along), alpha_y: Alpha(along * ratio), angle }
    }

    /// Largest difference of two tensors' entries.
    fn apart(a: RoughnessTensor, b: RoughnessTensor) -> f32 {
        (a.xx - b.xx).abs().max((a.xy - b.xy).abs()).max((a.yy - b.yy).abs())
    }

    fn quantised(values: [f32; 3], max: f32) -> [f32; 3] {
        values.map(|v| (v.clamp(0.0, 1.0) * max).round() / max)
    }

    /// Widths 0.5 and 0.1: strength `sqrt(0.4 / 0.9)`; `alpha = sqrt(0.05)`, `A = (1 - 0.2) / 0.9`; roots 0.5 and 0.1.
    #[test]
    fn worked_by_hand() {
        let axes = lobe(0.5, 0.2, FRAC_PI_2);
        let gltf = Gltf::from_axes(axes);
        assert!((gltf.strength - (4f32 / 9.0).sqrt()).abs() < 1e-6 && gltf.direction.distance(Vec2::Y) < 1e-6);
        let burley = Burley::from_axes(axes, FRAC_PI_2);
        assert!((burley.alpha.0 - 0.05f32.sqrt()).abs() < 1e-6 && (burley.anisotropy - 8.0 / 9.0).abs() < 1e-6);
        assert!((burley.rotation - 0.25).abs() < 1e-6);
        let root = TensorRoot::from_tensor(RoughnessTensor::from_axes(axes));
        assert!((root.xx - 0.1).abs() < 1e-6 && (root.yy - 0.5).abs() < 1e-6 && root.xy.abs() < 1e-6);
        // A round lobe stays round in 8 bits: 0 is a whole byte.
        let round = TensorRoot { xx: 0.2, xy: 0.0, yy: 0.2 };
        assert_eq!(round.encoded()[2] * 255.0, 128.0);
    }

    #[test]
    fn mirrors_have_every_form() {
        let axes = lobe(0.0, 1.0, 0.0);
        assert_eq!(Gltf::from_axes(axes).tensor(), RoughnessTensor::default());
        assert_eq!(Burley::from_axes(axes, 1.0).tensor(), RoughnessTensor::default());
        assert_eq!(TensorRoot::from_tensor(RoughnessTensor::default()).tensor(), RoughnessTensor::default());
    }

    /// Widths of 1 to 50 are out of Burley's reach: the nearest keeps their product and is 1 to 10.
    #[test]
    fn burley_stops_at_one_to_ten() {
        let back = Burley::from_axes(lobe(0.5, 0.02, 0.3), 0.3).tensor().axes();
        assert!((back.alpha_x.0 * back.alpha_y.0 - 0.005).abs() < 1e-6);
        assert!((back.alpha_y.0 / back.alpha_x.0 - BURLEY_LEAST_RATIO).abs() < 1e-4 && (back.angle - 0.3).abs() < 1e-4);
    }

    proptest! {
        #[test]
        fn every_form_gives_the_lobe_back(a in 0.001f32..1.0, ratio in 0.0f32..1.0, angle in -1.57f32..1.57, main in -3.0f32..6.0) {
            let axes = lobe(a, ratio, angle);
            let tensor = RoughnessTensor::from_axes(axes);
            prop_assert!(apart(Gltf::from_axes(axes).tensor(), tensor) < 1e-6);
            prop_assert!(apart(Gltf::from_axes(axes.sided(main)).tensor(), tensor) < 1e-6);
            prop_assert!(apart(TensorRoot::from_tensor(tensor).tensor(), tensor) < 1e-6);
            let root = TensorRoot::decoded(TensorRoot::from_tensor(tensor).encoded());
            prop_assert!(apart(root.tensor(), tensor) < 2e-6);
            let reached = lobe(a, ratio.max(BURLEY_LEAST_RATIO), angle);
            prop_assert!(apart(Burley::from_axes(reached, main).tensor(), RoughnessTensor::from_axes(reached)) < 4e-6);
        }

        #[test]
        fn turns_do_not_run_over_near_the_main_axis(main in -4.0f32..4.0, near in -1.5f32..1.5) {
            let turns = |angle: f32| lobe(0.5, 0.2, angle).turns(main);
            prop_assert!((0.0..=1.0).contains(&turns(main + near)));
            // As far from the main axis as the angle is.
            prop_assert!((TAU * (turns(main + near) - turns(main)) - near).abs() < 1e-4);
        }

        /// What a bilinear sampler makes of four texels: along any direction a width between the least and the largest.
        #[test]
        fn mixes_of_roots_lie_between(
            lobes in prop::array::uniform4((0.001f32..1.0, 0.0f32..1.0, -1.57f32..1.57)),
            u in 0.0f32..1.0, v in 0.0f32..1.0, direction in 0.0f32..TAU,
        ) {
            let roots = lobes.map(|(a, ratio, angle)| {
                TensorRoot::from_tensor(RoughnessTensor::from_axes(lobe(a, ratio, angle))).encoded()
            });
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            let mix = std::array::from_fn(|i| (0..4).map(|j| weights[j] * roots[j][i]).sum());
            let mixed = TensorRoot::decoded(mix);
            let along = |s: TensorRoot| {
                let (y, x) = direction.sin_cos();
                s.xx * x * x + 2.0 * s.xy * x * y + s.yy * y * y
            };
            let each = roots.map(|root| along(TensorRoot::decoded(root)));
            let (low, high) = (each.into_iter().fold(1.0, f32::min), each.into_iter().fold(0.0, f32::max));
            prop_assert!((low - 1e-6..=high + 1e-6).contains(&along(mixed)));
            let widths = mixed.tensor().axes();
            let most = lobes.iter().fold(0.0, |most: f32, lobe| most.max(lobe.0));
            let least = lobes.iter().fold(1.0, |least: f32, lobe| least.min(lobe.0 * lobe.1));
            prop_assert!(widths.alpha_x.0 <= most + 1e-4 && widths.alpha_y.0 >= least - 1e-3);
        }

        /// Half a step in each of three entries moves no eigenvalue by more than `0.5 / 255 + 0.5 / 254` = 0.004 (Weyl);
        /// in 16 bits by 257 times less.
        #[test]
        fn rounding_moves_widths_little(a in 0.0f32..1.0, ratio in 0.0f32..1.0, angle in -1.57f32..1.57) {
            let axes = lobe(a, ratio, angle);
            let root = TensorRoot::from_tensor(RoughnessTensor::from_axes(axes));
            for (max, bound) in [(255.0, 0.00394), (65535.0, 2e-5)] {
                let back = TensorRoot::decoded(quantised(root.encoded(), max));
                let half = 0.5 * (back.xx - back.yy);
                let (mean, spread) = (0.5 * (back.xx + back.yy), (half * half + back.xy * back.xy).sqrt());
                prop_assert!((mean + spread - axes.alpha_x.0).abs() <= bound);
                prop_assert!((mean - spread - axes.alpha_y.0).abs() <= bound);
            }
        }
    }
}
