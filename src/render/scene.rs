//! What is drawn and how it is lit.

use glam::Vec3;

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

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit, towards the light. x right, y up, z towards the camera.
    pub direction: Vec3,
    /// Irradiance on a surface that faces it, linear RGB: radiance times solid angle.
    pub irradiance: Vec3,
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
    /// The lights, all of them: there is no other environment.
    pub lights: Vec<Light>,
    /// Radiance beside the object, linear RGB. It lights nothing.
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
            Light { direction: direction.normalize(), irradiance: self.irradiance / count as f32 }
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

impl Scene {
    /// A silvery sphere in a dark studio, the window on its left.
    pub fn studio() -> Self {
        Self {
            shape: Shape::Sphere,
            repeats: 1.5,
            f0: Vec3::new(0.91, 0.92, 0.92),
            lights: studio_lights(-32.0, 22.0),
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn studio_lights_are_unit_and_sum_to_their_boxes() {
        let scene = Scene::studio();
        assert!(scene.lights.iter().all(|light| (light.direction.length() - 1.0).abs() < 1e-6));
        let total: Vec3 = scene.lights.iter().map(|light| light.irradiance).sum();
        assert!((total - Vec3::new(1.77, 1.78, 1.82)).length() < 1e-4, "{total}");
    }
}
