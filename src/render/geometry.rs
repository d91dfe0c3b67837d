//! Where a ray of the camera meets the object.

use glam::{Vec2, Vec3};

use super::{Scene, Shape};
use crate::ndf::Frame;

/// From the camera to the middle of the object, whose sphere has radius 1.
const DISTANCE: f32 = 3.5;
/// Tangent of half the angle of view: the sphere's rim at `tan(asin(1 / DISTANCE))`, and a margin of 3 percent.
const HALF_VIEW: f32 = 0.2981424 * 1.03;
/// Half the panel's side: it fills the picture when it leans.
const HALF_PANEL: f32 = 0.92;

/// A visible point of the object.
pub(super) struct Hit {
    /// Where it is; the object's middle is the origin.
    pub position: Vec3,
    /// Unit, towards the camera.
    pub view: Vec3,
    /// Of the shape, unit.
    pub normal: Vec3,
    /// +u and +v on the shape.
    pub frame: Frame,
    /// Texture coordinates: u right, v up, unbounded.
    pub uv: Vec2,
    /// Side of the square that has the area of one pixel's footprint in texture coordinates: the geometric mean
    /// of its axes. The longer one, which hardware without anisotropic filtering takes, would blur the rim by
    /// more than the truth does, and so blame the filter for what the chain did not do.
    pub footprint: f32,
    /// How `uv` changes over one pixel to the right, and over one pixel up.
    pub steps: [Vec2; 2],
}

/// Direction of the ray through `place` (-1 to 1, right and up) of a picture.
pub(super) fn ray(place: Vec2) -> Vec3 {
    (place * HALF_VIEW).extend(-1.0).normalize()
}

/// Where the ray through `place` of a picture `pixels` wide meets the object.
pub(super) fn hit(scene: &Scene, place: Vec2, pixels: usize) -> Option<Hit> {
    let origin = Vec3::new(0.0, 0.0, DISTANCE);
    let ray = ray(place);
    // `uv_per_length` is along either axis of the frame.
    let (along, normal, frame, uv, uv_per_length) = match scene.shape {
        Shape::Sphere => {
            let half = origin.dot(ray);
            let root = half * half - (origin.length_squared() - 1.0);
            if root < 0.0 {
                return None;
            }
            let along = -half - root.sqrt();
            let n = (origin + along * ray).normalize();
            // Stereographic coordinates (x, y) / (1 + z) span -1 to 1 over the near half; their axes on the
            // sphere are the transported frame and their scale is 1 / (1 + z).
            let scale = 0.5 * scene.repeats / (1.0 + n.z);
            (along, n, Frame::transported(n), scale * n.truncate(), scale)
        }
        Shape::Plane { tilt } => {
            let (sin, cos) = tilt.sin_cos();
            let n = Vec3::new(0.0, sin, cos);
            let along = -origin.dot(n) / ray.dot(n);
            let frame = Frame { tangent: Vec3::X, bitangent: Vec3::new(0.0, cos, -sin) };
            let p = origin + along * ray;
            let at = Vec2::new(p.dot(frame.tangent), p.dot(frame.bitangent));
            if along <= 0.0 || at.abs().max_element() > HALF_PANEL {
                return None;
            }
            let scale = 0.5 * scene.repeats / HALF_PANEL;
            (along, n, frame, scale * at, scale)
        }
    };
    let view = -ray;
    // Area that a pixel's solid angle (pixel area on the screen at distance 1, times cos^3) covers on the surface.
    let pixel = 2.0 * HALF_VIEW / pixels as f32;
    let slant = ray.z * ray.z / normal.dot(view).max(1e-4) * -ray.z;
    let footprint = uv_per_length * pixel * along * slant.sqrt();
    // A pixel further on the screen (at distance 1), moved along the ray back onto the tangent plane.
    let step = |screen: Vec3| {
        let moved = along * -ray.z * pixel * (screen - ray * (screen.dot(normal) / ray.dot(normal).min(-1e-4)));
        uv_per_length * Vec2::new(moved.dot(frame.tangent), moved.dot(frame.bitangent))
    };
    let steps = [step(Vec3::X), step(Vec3::Y)];
    Some(Hit { position: origin + along * ray, view, normal, frame, uv: uv + 0.5, footprint, steps })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The footprint against the area of the quadrilateral of four neighbouring rays.
    #[test]
    fn footprints_are_the_areas_between_rays() {
        const PIXELS: usize = 1000;
        for scene in [Scene::studio(), Scene::studio_panel()] {
            for place in [Vec2::ZERO, Vec2::new(0.5, -0.3), Vec2::new(-0.6, 0.5)] {
                let uv = |x: f32, y: f32| hit(&scene, place + Vec2::new(x, y) / PIXELS as f32, PIXELS).unwrap().uv;
                let diagonals = (uv(1.0, 1.0) - uv(-1.0, -1.0), uv(-1.0, 1.0) - uv(1.0, -1.0));
                let area = 0.5 * diagonals.0.perp_dot(diagonals.1).abs();
                let footprint = hit(&scene, place, PIXELS).unwrap().footprint;
                assert!((footprint * footprint / area - 1.0).abs() < 0.01, "{place} {footprint} {area}");
            }
        }
    }

    /// The steps against neighbouring rays; their parallelogram has the footprint's area.
    #[test]
    fn steps_are_the_differences_between_rays() {
        const PIXELS: usize = 1000;
        for scene in [Scene::studio(), Scene::studio_panel(), Scene::outdoor_panel()] {
            for place in [Vec2::ZERO, Vec2::new(0.5, -0.3), Vec2::new(-0.4, 0.2)] {
                let at = |x: f32, y: f32| hit(&scene, place + Vec2::new(x, y) / PIXELS as f32, PIXELS).unwrap();
                let Hit { steps, footprint, position, normal, .. } = at(0.0, 0.0);
                let seen = [at(1.0, 0.0).uv - at(-1.0, 0.0).uv, at(0.0, 1.0).uv - at(0.0, -1.0).uv];
                for (step, seen) in steps.iter().zip(seen) {
                    assert!((step - seen).length() < 0.01 * seen.length(), "{place} {step} {seen}");
                }
                let area = steps[0].perp_dot(steps[1]);
                assert!((area / (footprint * footprint) - 1.0).abs() < 1e-3, "{place} {area} {footprint}");
                match scene.shape {
                    Shape::Sphere => assert!((position - normal).length() < 1e-5),
                    Shape::Plane { .. } => assert!(position.dot(normal).abs() < 1e-5),
                }
            }
        }
    }

    #[test]
    fn frames_follow_the_texture() {
        for scene in [Scene::studio(), Scene::studio_panel()] {
            let at = |x: f32, y: f32| hit(&scene, Vec2::new(x, y), 100).unwrap();
            let hit = at(0.3, 0.2);
            assert!((hit.frame.tangent.cross(hit.frame.bitangent) - hit.normal).length() < 1e-5);
            // The middle of the picture is the middle of the texture; u grows to the right and v upwards.
            assert!((at(0.0, 0.0).uv - 0.5).length() < 1e-6);
            assert!(hit.uv.x > 0.5 && hit.uv.y > 0.5);
        }
        assert!(hit(&Scene::studio(), Vec2::new(0.9, 0.9), 100).is_none());
    }
}
