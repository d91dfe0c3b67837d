//! The sphere, its lights, and the camera that it moves away from.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

/// From the camera to the middle of the sphere (radius 1) where it is nearest.
const NEAREST: f32 = 3.5;
/// The sphere's radius in halves of the picture.
const RADIUS: f32 = 0.96;
/// Quads of the mesh around the sphere, and from pole to pole.
const AROUND: u32 = 256;
const DOWN: u32 = 128;
/// The mesh ends this close to the poles, in radians, where Mercator's map does not. Seen from its side, the hole is less
/// than a thousandth of a pixel.
const POLE: f32 = 0.01;

/// A light that is small and far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit, towards the light: x right, y up, z towards the camera.
    pub direction: Vec3,
    /// Irradiance on a surface that faces it, linear RGB.
    pub irradiance: Vec3,
}

/// What is drawn, but for the texture maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// All lights.
    pub lights: Vec<Light>,
    /// Reflectance at normal incidence, linear RGB.
    pub f0: Vec3,
    /// Repeats of the texture around the sphere.
    pub repeats: u32,
}

/// Where the sphere is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Its distance is this many times that at which it fills the largest picture, 1 or more.
    pub shrunk: f32,
    /// Turn about its upright axis, radians.
    pub turn: f32,
}

impl Scene {
    /// Nickel (f0 of 0.66 0.61 0.53), and five small lights.
    pub fn new(repeats: u32) -> Self {
        let light = |x, y, z, red, green, blue| Light {
            direction: Vec3::new(x, y, z).normalize(),
            irradiance: Vec3::new(red, green, blue),
        };
        let lights = vec![
            light(-0.55, 0.65, 0.8, 3.0, 2.8, 2.5),
            light(0.9, 0.3, 0.7, 1.2, 1.5, 2.0),
            light(0.1, -0.75, 0.8, 0.9, 0.8, 0.7),
            light(-0.9, -0.25, 0.25, 1.0, 0.9, 0.8),
            light(0.5, 0.9, -0.1, 0.8, 0.9, 1.2),
        ];
        Self { lights, f0: Vec3::new(0.66, 0.61, 0.53), repeats }
    }

    /// Longitude and latitude of the mesh's vertices, radians. The first and the last column lie on each other, a whole
    /// number of repeats apart.
    pub fn vertices() -> Vec<[f32; 2]> {
        let longitude = |i: u32| (2.0 * i as f32 / AROUND as f32 - 1.0) * PI;
        let latitude = |j: u32| (1.0 - 2.0 * j as f32 / DOWN as f32) * (FRAC_PI_2 - POLE);
        (0..=DOWN).flat_map(|j| (0..=AROUND).map(move |i| [longitude(i), latitude(j)])).collect()
    }

    /// Its triangles, counter-clockwise as seen from outside.
    pub fn triangles() -> Vec<u32> {
        let at = |i: u32, j: u32| j * (AROUND + 1) + i;
        let quad = |i, j| [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)];
        (0..DOWN).flat_map(|j| (0..AROUND).flat_map(move |i| quad(i, j))).collect()
    }

    /// The shader's `Scene`. `place` is the scale and the middle of the part that is drawn.
    pub fn uniform(&self, pose: Pose, place: [f32; 4], decode: [f32; 4], more: [f32; 4]) -> Vec<f32> {
        let rim = |distance: f32| (distance * distance - 1.0).sqrt().recip();
        let seen = rim(NEAREST) / pose.shrunk;
        // The distance at which the rim is seen under this tangent.
        let distance = (1.0 + seen.powi(-2)).sqrt();
        let camera = [distance, RADIUS / seen, pose.turn, self.repeats as f32];
        let mut words = [place, camera, decode, more, self.f0.extend(0.0).to_array()].concat();
        for light in &self.lights {
            words.extend(light.direction.extend(0.0).to_array());
            words.extend(light.irradiance.extend(0.0).to_array());
        }
        words
    }
}
