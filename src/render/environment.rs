//! What surrounds the object: radiance in closed form, and how a lobe reflects it.

use std::array::from_fn;
use std::f32::consts::TAU;

use glam::Vec3;

use super::shade::{LANES, Lanes};

/// Radiance as a smooth function of direction, linear RGB; y is up.
///
/// With t the sine of the elevation, `up(t) = (1 + t / sqrt(t^2 + s^2)) / 2` a smooth step about the horizon, s its
/// softness, and c the cosine of the angle to the sun,
/// `L = ground + up(t) (zenith + (horizon - zenith) (1 - |t|)^4 - ground) + glow / (1 + sharpness (1 - c))^2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Radiance from below.
    pub ground: Vec3,
    /// Radiance just above the horizon.
    pub horizon: Vec3,
    /// Radiance from straight above.
    pub zenith: Vec3,
    /// Half the width of the horizon's step, sine of elevation; above 0.
    pub softness: f32,
    /// Unit, towards the sun.
    pub sun: Vec3,
    /// Radiance that the sun's glow adds in its middle.
    pub glow: Vec3,
    /// Of the glow, which falls to a quarter at an angle whose cosine is `1 - 1 / sharpness`; at least 0.
    pub sharpness: f32,
}

impl Environment {
    /// The same radiance from everywhere: the white furnace.
    pub fn constant(radiance: Vec3) -> Self {
        Self {
            ground: radiance,
            horizon: radiance,
            zenith: radiance,
            softness: 1.0,
            sun: Vec3::Y,
            glow: Vec3::ZERO,
            sharpness: 0.0,
        }
    }

    /// A blue sky over brown ground, hazy about a sun on the upper left before the camera. The sun itself is not in it.
    pub fn clear_sky() -> Self {
        Self {
            ground: Vec3::new(0.10, 0.085, 0.065),
            horizon: Vec3::new(0.62, 0.66, 0.70),
            zenith: Vec3::new(0.12, 0.22, 0.46),
            softness: 0.1,
            sun: Vec3::new(-0.55, 0.62, 0.56).normalize(),
            glow: Vec3::new(0.9, 0.8, 0.6),
            // A quarter at 34 degrees: wide enough for the quadrature. What is narrower belongs to the lights.
            sharpness: 6.0,
        }
    }

    /// Radiance from a unit direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let lanes = self.lanes([direction.x, direction.y, direction.z].map(|v| [v; LANES]));
        Vec3::from_array(lanes.map(|lanes| lanes[0]))
    }

    /// [`Environment::radiance`] of several directions, by colour.
    #[inline(always)]
    pub(super) fn lanes(&self, [x, y, z]: [Lanes; 3]) -> [Lanes; 3] {
        let up: Lanes = from_fn(|i| 0.5 + 0.5 * y[i] / (y[i] * y[i] + self.softness * self.softness).sqrt());
        let low: Lanes = from_fn(|i| {
            let rest = 1.0 - y[i].abs();
            rest * rest * (rest * rest)
        });
        let glow: Lanes = from_fn(|i| {
            let cos = x[i] * self.sun.x + y[i] * self.sun.y + z[i] * self.sun.z;
            let below = 1.0 + self.sharpness * (1.0 - cos);
            1.0 / (below * below)
        });
        from_fn(|c| {
            let (ground, horizon, zenith) = (self.ground[c], self.horizon[c], self.zenith[c]);
            from_fn(|i| ground + up[i] * (zenith + (horizon - zenith) * low[i] - ground) + self.glow[c] * glow[i])
        })
    }
}

/// Points of the quadrature; a multiple of `LANES`. The test below measures what so few leave open.
const POINTS: usize = 32;

/// Evenly spread points for the spherical caps of Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with
/// Spherical Caps": height down the cap, cosine and sine of the angle about z, `LANES` at a time.
///
/// A Fibonacci spiral, which is even on a cap of any height. Every lobe gets the same points, and a reflection depends
/// on the lobe smoothly, so a difference between two pictures is a difference between their lobes.
pub(super) struct Points(pub Vec<[Lanes; 3]>);

impl Points {
    pub fn new() -> Self {
        Self::of(POINTS)
    }

    fn of(points: usize) -> Self {
        // The golden angle's share of a turn.
        const TURN: f64 = 0.381_966_011_250_105_1;
        let group = |g: usize| {
            let height = from_fn(|i| ((LANES * g + i) as f32 + 0.5) / points as f32);
            let angle: Lanes = from_fn(|i| (((LANES * g + i) as f64 * TURN).fract()) as f32 * TAU);
            [height, angle.map(f32::cos), angle.map(f32::sin)]
        };
        Self((0..points / LANES).map(group).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::{Axes, Frame, Lobe, RoughnessTensor};
    use crate::render::shade::Lighting;
    use crate::roughness::Alpha;
    use std::f64::consts::PI;

    #[test]
    fn radiance_worked_by_hand() {
        let sky = Environment { sun: Vec3::X, sharpness: 2.0, glow: Vec3::splat(4.0), ..Environment::clear_sky() };
        // Across the horizon the step is a half; the glow a quarter at 60 degrees, and a ninth at 90.
        let level = sky.radiance(Vec3::Z) - 4.0 / 9.0;
        assert!((level - 0.5 * (sky.ground + sky.horizon)).length() < 1e-6, "{level}");
        let tilted = Vec3::new(0.5, 0.0, 0.75f32.sqrt());
        assert!((sky.radiance(tilted) - sky.radiance(Vec3::Z) - (1.0 - 4.0 / 9.0)).length() < 1e-6);
        let up = (1.0 + 1.0 / (1.0 + 0.1f32 * 0.1).sqrt()) / 2.0;
        let zenith = sky.ground + up * (sky.zenith - sky.ground) + 4.0 / 9.0;
        assert!((sky.radiance(Vec3::Y) - zenith).length() < 1e-6);
        assert_eq!(Environment::constant(Vec3::ONE).radiance(Vec3::new(0.6, -0.8, 0.0)), Vec3::ONE);
    }

    /// The reflection by a lobe on a surface that faces z.
    fn reflected(environment: Environment, points: usize, lobe: &Lobe, view: Vec3, f0: f32) -> Vec3 {
        let mut lighting = Lighting::new(&[], Some(environment), Vec3::splat(f0));
        lighting.points = Points::of(points);
        lighting.radiance(lobe, Vec3::ZERO, Vec3::Z, Frame { tangent: Vec3::X, bitangent: Vec3::Y }, view)
    }

    fn lobe(alpha_x: f32, alpha_y: f32) -> Lobe {
        let roughness =
            RoughnessTensor::from_axes(Axes { alpha_x: Alpha(alpha_x), alpha_y: Alpha(alpha_y), angle: 0.7 });
        Lobe { normal: Vec3::new(0.15, -0.2, 1.0).normalize(), roughness }
    }

    fn views() -> impl Iterator<Item = Vec3> {
        [0.0f32, 0.5, 0.9].map(|x| Vec3::new(x, -0.1, (0.99 - x * x).sqrt())).into_iter()
    }

    /// White furnace: radiance 1 from everywhere comes back as the lobe's directional albedo, integrated in f64 from
    /// the definition of the lobe.
    #[test]
    fn a_constant_environment_gives_the_directional_albedo() {
        let white = Environment::constant(Vec3::ONE);
        let mut worst: f64 = 0.0;
        for (alpha_x, alpha_y) in [(0.3, 0.3), (0.7, 0.25), (1.0, 1.0)] {
            let lobe = lobe(alpha_x, alpha_y);
            for view in views() {
                const STEPS: usize = 600;
                let albedo: f64 = (0..STEPS * STEPS)
                    .map(|i| {
                        let z = ((i / STEPS) as f64 + 0.5) / STEPS as f64 * 2.0 - 1.0;
                        let (sin, cos) = (((i % STEPS) as f64 + 0.5) / STEPS as f64 * 2.0 * PI).sin_cos();
                        let r = (1.0 - z * z).sqrt();
                        lobe.specular(view.as_dvec3(), glam::DVec3::new(r * cos, r * sin, z))
                    })
                    .sum::<f64>()
                    * (4.0 * PI / (STEPS * STEPS) as f64);
                // Many points find the integral, the usual few come close.
                let many = f64::from(reflected(white, 4096, &lobe, view, 1.0).x);
                assert!((many - albedo).abs() < 2e-3, "alpha {alpha_x} {alpha_y}, {view}: {many} {albedo}");
                worst = worst.max((f64::from(reflected(white, POINTS, &lobe, view, 1.0).x) - albedo).abs());
            }
        }
        assert!(worst < 0.02, "{worst}");
        // Seen from above at alpha 1: 1 - ln 2.
        let flat = Lobe::isotropic(Vec3::Z, Alpha(1.0));
        let found = reflected(white, 4096, &flat, Vec3::Z, 1.0).x;
        assert!((found - (1.0 - std::f32::consts::LN_2)).abs() < 1e-3, "{found}");
    }

    /// A mirror shows the environment itself, and Schlick's term at normal incidence is f0.
    #[test]
    fn a_smooth_lobe_is_a_mirror() {
        let sky = Environment::clear_sky();
        let mirror = Lobe::isotropic(Vec3::new(-0.3, 0.35, 1.0).normalize(), Alpha(0.002));
        let view = Vec3::new(0.1, 0.2, 0.97).normalize();
        let seen = 2.0 * view.dot(mirror.normal) * mirror.normal - view;
        let (found, expected) = (reflected(sky, POINTS, &mirror, view, 1.0), sky.radiance(seen));
        assert!((found - expected).length() < 0.02 * expected.length(), "{found} {expected}");
        let white = Environment::constant(Vec3::ONE);
        let facing = reflected(white, POINTS, &Lobe::isotropic(Vec3::Z, Alpha(0.01)), Vec3::Z, 0.3).x;
        assert!((facing - 0.3).abs() < 1e-3, "{facing}");
    }

    /// The usual points against many, under the sky.
    #[test]
    fn few_points_are_enough_for_a_smooth_sky() {
        let sky = Environment::clear_sky();
        for (alpha_x, alpha_y) in [(0.05, 0.05), (0.2, 0.2), (0.5, 0.1), (0.6, 0.6)] {
            for view in views() {
                let lobe = lobe(alpha_x, alpha_y);
                let [few, many] = [POINTS, 8192].map(|points| reflected(sky, points, &lobe, view, 0.9));
                let error = (few - many).length() / many.length();

                assert!(error < 0.08, "alpha {alpha_x} {alpha_y}, {view}: {few} {many}");
            }
        }
    }
}
