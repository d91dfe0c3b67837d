//! What is drawn and how it is lit.

use glam::{Quat, Vec3};

use super::Environment;

/// The object; both carry tangent frames of right angles and equal lengths, so textures are scaled, not sheared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere that fills the picture, textured by stereographic projection from its far pole: no seam or pole in
    /// sight, and texels half as wide at the rim, seen flat, as in the middle.
    Sphere,
    /// A square panel that leans back.
    Plane {
        /// Radians from upright; 0 faces the camera.
        tilt: f32,
    },
}

/// A light. x right, y up, z towards the camera; the object's middle is the origin, and the sphere's radius is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Endlessly far.
    Directional {
        /// Unit, towards the light.
        direction: Vec3,
        /// Irradiance on a surface that faces it, linear RGB: radiance times solid angle.
        irradiance: Vec3,
    },
    /// A point that shines the same in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiant intensity, linear RGB: irradiance on a surface that faces it, at distance 1.
        intensity: Vec3,
    },
    /// A rectangle that shines evenly to one side, as Lambert's law has it. It stands for `columns` times `rows` points,
    /// each in the middle of its share: a finite sum, so reflections narrower than the space between the points show
    /// them apart.
    Rectangle {
        /// Of the rectangle.
        middle: Vec3,
        /// From the middle to the right and to the upper side; at right angles. It shines towards `right x up`.
        right: Vec3,
        /// See `right`.
        up: Vec3,
        /// Linear RGB.
        radiance: Vec3,
        /// Points along `right`.
        columns: usize,
        /// Points along `up`.
        rows: usize,
    },
}

/// An object, its metal, and its lights, before a fixed camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What is drawn.
    pub shape: Shape,
    /// Repeats of the texture across the sphere's disc or the panel's side.
    pub repeats: f32,
    /// Reflectance at normal incidence, linear RGB, 0 to 1.
    pub f0: Vec3,
    /// The lights.
    pub lights: Vec<Light>,
    /// What surrounds the object, lights it from all sides, and is seen beside it.
    pub environment: Option<Environment>,
    /// Radiance beside the object where there is no environment, linear RGB. It lights nothing.
    pub background: Vec3,
    /// Radiances are multiplied by this before they are tone mapped.
    pub exposure: f32,
}

/// A rectangle of lights on the sky.
struct Softbox {
    /// Of its middle: right of the camera's back, and up; degrees.
    azimuth: f32,
    elevation: f32,
    /// Degrees.
    width: f32,
    height: f32,
    /// Lights across and up.
    columns: usize,
    rows: usize,
    /// Of the whole box.
    irradiance: Vec3,
}

impl Softbox {
    fn lights(&self) -> impl Iterator<Item = Light> + '_ {
        let count = self.columns * self.rows;
        (0..count).map(move |i| {
            let step = |k: usize, n: usize, size: f32| ((k as f32 + 0.5) / n as f32 - 0.5) * size;
            let elevation = (self.elevation + step(i / self.columns, self.rows, self.height)).to_radians();
            // A box keeps its width as it rises: meridians close in.
            let across = step(i % self.columns, self.columns, self.width) / self.elevation.to_radians().cos();
            let azimuth = (self.azimuth + across).to_radians();
            let flat = elevation.cos();
            let direction = Vec3::new(flat * azimuth.sin(), elevation.sin(), flat * azimuth.cos());
            Light::Directional { direction: direction.normalize(), irradiance: self.irradiance / count as f32 }
        })
    }
}

/// A window high up, a tall strip on the right, and a low fill. Lights stand close enough for their reflections to
/// run together from perceptual roughness 0.2 up. Degrees.
fn studio_lights(window_azimuth: f32, window_side: f32) -> Vec<Light> {
    let window = Softbox {
        azimuth: window_azimuth,
        elevation: 46.0,
        width: window_side,
        height: window_side,
        columns: 6,
        rows: 6,
        irradiance: Vec3::new(1.05, 1.0, 0.92),
    };
    let strip = Softbox {
        azimuth: 75.0,
        elevation: 12.0,
        width: 10.0,
        height: 64.0,
        columns: 3,
        rows: 14,
        irradiance: Vec3::new(0.5, 0.58, 0.72),
    };
    let fill = Softbox {
        azimuth: -70.0,
        elevation: -28.0,
        width: 24.0,
        height: 12.0,
        columns: 6,
        rows: 3,
        irradiance: Vec3::new(0.22, 0.20, 0.18),
    };
    [window, strip, fill].iter().flat_map(Softbox::lights).collect()
}

/// A disc of haze that the sky's quadrature would be too coarse for, in the middle of the clear sky's glow.
fn hazy_sun() -> impl Iterator<Item = Light> {
    let sun = Softbox {
        azimuth: -44.5,
        elevation: 38.3,
        width: 8.0,
        height: 8.0,
        columns: 4,
        rows: 4,
        irradiance: Vec3::new(1.1, 1.0, 0.8),
    };
    sun.lights().collect::<Vec<_>>().into_iter()
}

impl Scene {
    /// A silvery sphere in a dark studio, the window on its left.
    pub fn studio() -> Self {
        Self {
            shape: Shape::Sphere,
            repeats: 1.5,
            f0: Vec3::new(0.91, 0.92, 0.92),
            lights: studio_lights(-32.0, 22.0),
            environment: None,
            background: Vec3::splat(0.012),
            exposure: 1.0,
        }
    }

    /// A silvery panel that leans back until a smaller window, which stands before it, shows in its middle; exposed
    /// for the window.
    pub fn studio_panel() -> Self {
        Self {
            shape: Shape::Plane { tilt: 0.42 },
            lights: studio_lights(-2.0, 12.0),
            background: Vec3::splat(0.04),
            exposure: 0.3,
            ..Self::studio()
        }
    }

    /// A silvery sphere under a clear sky with a hazy sun on the upper left, and a warm lamp near its lower right.
    pub fn outdoor() -> Self {
        let lamp = Light::Point { position: Vec3::new(1.5, -0.9, 1.9), intensity: Vec3::new(1.3, 0.9, 0.5) };
        Self {
            lights: hazy_sun().chain([lamp]).collect(),
            environment: Some(Environment::clear_sky()),
            exposure: 0.9,
            ..Self::studio()
        }
    }

    /// A silvery floor under the same sky, leaning far back, with a lamp over its far end and a light panel over
    /// its middle: pixels see long, thin footprints.
    pub fn outdoor_panel() -> Self {
        let lamp = Light::Point { position: Vec3::new(0.4, 1.0, -0.9), intensity: Vec3::new(0.5, 0.4, 0.25) };
        let panel = Light::Rectangle {
            middle: Vec3::new(-0.25, 1.1, -1.2),
            right: Vec3::new(0.3, 0.0, 0.0),
            // It shines down and towards the floor's middle.
            up: Vec3::new(0.0, 0.3, 0.2),
            radiance: Vec3::new(2.0, 2.1, 2.4),
            columns: 6,
            rows: 6,
        };
        let lights = hazy_sun().chain([lamp, panel]).collect();
        Self { shape: Shape::Plane { tilt: 1.25 }, lights, repeats: 2.0, ..Self::outdoor() }
    }

    /// A sphere in a dim room with a lamp far away on the upper left and one near by on the right: few lights, so that
    /// each glint is seen to belong to one.
    pub fn lamps() -> Self {
        let far = Vec3::new(-0.45, 0.55, 0.7).normalize();
        Self {
            lights: vec![
                Light::Directional { direction: far, irradiance: Vec3::new(2.2, 2.1, 1.9) },
                Light::Point { position: Vec3::new(1.9, 0.5, 2.2), intensity: Vec3::new(4.0, 4.6, 6.0) },
            ],
            environment: Some(Environment {
                ground: Vec3::splat(0.02),
                horizon: Vec3::splat(0.05),
                zenith: Vec3::new(0.07, 0.08, 0.1),
                softness: 0.6,
                sun: far,
                glow: Vec3::splat(0.1),
            }),
            exposure: 0.9,
            ..Self::studio()
        }
    }

    /// A panel in the same room that leans back until both lamps show in it.
    pub fn lamps_panel() -> Self {
        Self {
            shape: Shape::Plane { tilt: 0.9 },
            lights: vec![
                Light::Directional {
                    direction: Vec3::new(-0.22, 0.95, -0.12).normalize(),
                    irradiance: Vec3::new(1.6, 1.5, 1.35),
                },
                Light::Point { position: Vec3::new(0.55, 1.5, -0.9), intensity: Vec3::new(2.0, 2.3, 3.0) },
            ],
            ..Self::lamps()
        }
    }

    /// With all lights turned about the upright axis through the object's middle; the environment stays.
    pub fn with_lights_turned(&self, radians: f32) -> Self {
        let turn = |v: Vec3| Quat::from_rotation_y(radians) * v;
        let light = |light: &Light| match *light {
            Light::Directional { direction, irradiance } => {
                Light::Directional { direction: turn(direction), irradiance }
            }
            Light::Point { position, intensity } => Light::Point { position: turn(position), intensity },
            Light::Rectangle { middle, right, up, radiance, columns, rows } => {
                let (middle, right, up) = (turn(middle), turn(right), turn(up));
                Light::Rectangle { middle, right, up, radiance, columns, rows }
            }
        };
        Self { lights: self.lights.iter().map(light).collect(), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn studio_lights_are_unit_and_sum_to_their_boxes() {
        let mut total = Vec3::ZERO;
        for light in Scene::studio().lights {
            let Light::Directional { direction, irradiance } = light else { panic!("{light:?}") };
            assert!((direction.length() - 1.0).abs() < 1e-6);
            total += irradiance;
        }
        assert!((total - Vec3::new(1.77, 1.78, 1.82)).length() < 1e-4, "{total}");
    }
}
