//! What surrounds the object: radiance in closed form, and how a lobe reflects it.

use std::array::from_fn;
use std::f32::consts::TAU;

use glam::Vec3;

use super::shade::{LANES, Lanes};

/// Radiance as a smooth function of direction, linear RGB; y is up.
///
/// With t the sine of the elevation, `up = u^2 (3 - 2 u)` a smooth step about the horizon, u = (t / softness + 1) / 2
/// clamped to 0..1, and c the cosine of the angle to the sun,
/// `L = ground + up (zenith + (horizon - zenith) (1 - |t|)^4 - ground) + glow ((1 + c) / 2)^16`.
/// There is no root and no quotient in it: it is evaluated very often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Radiance from below.
    pub ground: Vec3,
    /// Radiance just above the horizon.
    pub horizon: Vec3,
    /// Radiance from straight above.
    pub zenith: Vec3,
    /// Half the width of the horizon's step, sine of elevation; above 0 and at most 1.
    pub softness: f32,
    /// Unit, towards the sun.
    pub sun: Vec3,
    /// Radiance that the sun's glow adds in its middle; a quarter of it 34 degrees beside: wide enough for the
    /// quadrature. What is narrower belongs to the lights.
    pub glow: Vec3,
}

impl Environment {
    /// The same radiance from everywhere: the white furnace.
    pub fn constant(radiance: Vec3) -> Self {
        Self { ground: radiance, horizon: radiance, zenith: radiance, softness: 1.0, sun: Vec3::Y, glow: Vec3::ZERO }
    }

    /// A blue sky over brown ground, hazy about a sun on the upper left before the camera. The sun itself is not in it.
    pub fn clear_sky() -> Self {
        Self {
            ground: Vec3::new(0.10, 0.085, 0.065),
            horizon: Vec3::new(0.62, 0.66, 0.70),
            zenith: Vec3::new(0.12, 0.22, 0.46),
            softness: 0.2,
            sun: Vec3::new(-0.55, 0.62, 0.56).normalize(),
            glow: Vec3::new(0.9, 0.8, 0.6),
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
        let steep = 0.5 / self.softness;
        let range = self.horizon - self.zenith;
        let mut out = [[0.0; LANES]; 3];
        // Plain loops: closures inside from_fn are not always inlined, and then not vectorised.
        for i in 0..LANES {
            let u = (0.5 + steep * y[i]).clamp(0.0, 1.0);
            let up = u * u * (3.0 - 2.0 * u);
            let rest = 1.0 - y[i].abs();
            let low = rest * rest * (rest * rest);
            let near = 0.5 + 0.5 * (x[i] * self.sun.x + y[i] * self.sun.y + z[i] * self.sun.z);
            let near = near * near * (near * near);
            let near = near * near * (near * near);
            for c in 0..3 {
                let above = self.zenith[c] + range[c] * low - self.ground[c];
                out[c][i] = self.ground[c] + up * above + self.glow[c] * near;
            }
        }
        out
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
    use crate::ndf::{Axes, Frame, Lobe, RoughnessTensor, ShapeInvariant};
    use crate::render::shade::Lighting;
    use crate::roughness::Alpha;
    use std::f64::consts::PI;

    #[test]
    fn radiance_worked_by_hand() {
        let sky = Environment { sun: Vec3::X, glow: Vec3::splat(4.0), ..Environment::clear_sky() };
        // Across the horizon the step is a half; the glow is 1/65536 of itself at 90 degrees, and (3/4)^16 at 60.
        let level = sky.radiance(Vec3::Z);
        assert!((level - 0.5 * (sky.ground + sky.horizon) - 4.0 / 65536.0).length() < 1e-6, "{level}");
        let tilted = sky.radiance(Vec3::new(0.5, 0.0, 0.75f32.sqrt()));
        assert!((tilted - level - 4.0 * (0.75f32.powi(16) - 1.0 / 65536.0)).length() < 1e-6);
        assert!((sky.radiance(Vec3::Y) - sky.zenith - 4.0 / 65536.0).length() < 1e-6);
        assert!((sky.radiance(-Vec3::Y) - sky.ground - 4.0 / 65536.0).length() < 1e-6);
        // An eighth of the step's width up: u = 5/8.
        let t = 0.05f32;
        let above = sky.zenith + (sky.horizon - sky.zenith) * (1.0 - t).powi(4);
        let expected = sky.ground + 0.625f32.powi(2) * 1.75 * (above - sky.ground) + 4.0 / 65536.0;
        assert!((sky.radiance(Vec3::new(0.0, t, (1.0 - t * t).sqrt())) - expected).length() < 1e-6);
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

    /// The usual points against many, under the sky: within 12 percent for a narrow lobe that shows the dark ground,
    /// whose wide tails toward the sky few points miss, and within 8 percent else.
    #[test]
    fn few_points_are_enough_for_a_smooth_sky() {
        let sky = Environment::clear_sky();
        for (alpha_x, alpha_y) in [(0.05, 0.05), (0.2, 0.2), (0.5, 0.1), (0.6, 0.6)] {
            for view in views() {
                let lobe = lobe(alpha_x, alpha_y);
                let [few, many] = [POINTS, 8192].map(|points| reflected(sky, points, &lobe, view, 0.9));
                let error = (few - many).length() / many.length();

                assert!(
                    error < if alpha_x < 0.1 { 0.12 } else { 0.08 },
                    "alpha {alpha_x} {alpha_y}, {view}: {few} {many}"
                );
            }
        }
    }
}
