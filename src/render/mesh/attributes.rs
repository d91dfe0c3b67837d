//! What a shader knows of a point of the mesh, and how it changes over a pixel.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::projected::{Camera, Projected, Screen};
use crate::curvature::Mesh;
use crate::ndf::Frame;

/// A visible point of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// In [`Mesh::triangles`].
    pub triangle: usize,
    /// Of the triangle's corners, in perspective; sum 1.
    pub weights: [f32; 3],
    /// In the mesh's space.
    pub position: Vec3,
    /// Unit, towards the camera.
    pub view: Vec3,
    /// Interpolated, unit.
    pub normal: Vec3,
    /// The triangle's +u direction made orthogonal to the normal, and the one across it on the side where v grows; without
    /// texture coordinates, the camera's axes carried to the normal by the smallest rotation.
    pub frame: Frame,
    /// Texture coordinates, v up; zero without any.
    pub uv: Vec2,
}

/// What changes over one pixel: a finite difference between the two pixels of a quad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Of the position; length.
    pub position: Vec3,
    /// Of the unit direction to the camera.
    pub view: Vec3,
    /// Of the unit normal.
    pub normal: Vec3,
    /// Of the texture coordinates.
    pub uv: Vec2,
}

/// What the middle of a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// In the middle of the pixel.
    pub point: SurfacePoint,
    /// Over one pixel to the right.
    pub right: Step,
    /// Over one pixel up.
    pub up: Step,
}

/// Reads a mesh's attributes.
#[derive(Clone, Copy)]
pub(super) struct Attributes<'a> {
    pub mesh: &'a Mesh,
    pub camera: Camera,
}

/// What is interpolated.
struct Interpolated {
    weights: DVec3,
    position: DVec3,
    view: DVec3,
    normal: DVec3,
    uv: DVec2,
}

impl Attributes<'_> {
    fn has_uvs(&self, triangle: usize) -> bool {
        self.mesh.uvs.is_some() && self.mesh.parts.iter().any(|p| p.has_uvs && p.triangles.contains(&triangle))
    }

    /// At a ray; nothing where the triangle's plane is behind the camera there.
    fn interpolated(&self, triangle: &Projected, ray: DVec3) -> Option<Interpolated> {
        let weights = triangle.weights(ray);
        let sum = weights.element_sum();
        if sum <= 0.0 {
            return None;
        }
        let weights = weights / sum;
        let corners = self.mesh.triangles[triangle.index as usize].map(|i| i as usize);
        let mean = |of: &[Vec3]| -> DVec3 { (0..3).map(|k| weights[k] * of[corners[k]].as_dvec3()).sum() };
        let position = mean(&self.mesh.positions);
        let normal = mean(&self.mesh.normals).try_normalize().unwrap_or(self.mesh.normals[corners[0]].as_dvec3());
        let uv = self
            .mesh
            .uvs
            .as_ref()
            .map_or(DVec2::ZERO, |uvs| (0..3).map(|k| weights[k] * uvs[corners[k]].as_dvec2()).sum());
        Some(Interpolated { weights, position, view: self.camera.to_eye(position), normal, uv })
    }

    fn frame(&self, triangle: usize, n: DVec3) -> Frame {
        let frame = |t: DVec3, b: DVec3| Frame { tangent: t.as_vec3(), bitangent: b.as_vec3() };
        if let Some((t, side)) = self.along_u(triangle, n) {
            return frame(t, side * n.cross(t));
        }
        let [right, up, back] = self.camera.axes();
        let local = DVec3::new(n.dot(right), n.dot(up), n.dot(back));
        // Where the smallest rotation is not defined, the normal faces away.
        let a = 1.0 / (1.0 + local.z).max(1e-9);
        let t = DVec3::new(1.0 - local.x * local.x * a, -local.x * local.y * a, -local.x);
        let t = (t.x * right + t.y * up + t.z * back).try_normalize().unwrap_or(right);
        frame(t, n.cross(t))
    }

    /// Where u grows on the surface, and on which side of it v does.
    fn along_u(&self, triangle: usize, n: DVec3) -> Option<(DVec3, f64)> {
        if !self.has_uvs(triangle) {
            return None;
        }
        let corners = self.mesh.triangles[triangle].map(|i| i as usize);
        let uvs = self.mesh.uvs.as_ref()?;
        let [p, q, r] = corners.map(|i| self.mesh.positions[i].as_dvec3());
        let [a, b, c] = corners.map(|i| uvs[i].as_dvec2());
        let (e, f, g, h) = (q - p, r - p, b - a, c - a);
        let area = g.perp_dot(h);
        // The edges are P_u du + P_v dv.
        let (u, v) = ((e * h.y - f * g.y) * area.signum(), (f * g.x - e * h.x) * area.signum());
        let t = (u - n * n.dot(u)).try_normalize().filter(|_| area != 0.0)?;
        Some((t, if n.cross(t).dot(v) < 0.0 { -1.0 } else { 1.0 }))
    }

    fn point(&self, triangle: &Projected, at: &Interpolated) -> SurfacePoint {
        let index = triangle.index as usize;
        SurfacePoint {
            triangle: index,
            weights: at.weights.as_vec3().to_array(),
            position: at.position.as_vec3(),
            view: at.view.as_vec3(),
            normal: at.normal.as_vec3(),
            frame: self.frame(index, at.normal),
            uv: at.uv.as_vec2(),
        }
    }

    /// The point of a triangle on a ray that meets it.
    pub fn at(&self, triangle: &Projected, ray: DVec3) -> Option<SurfacePoint> {
        self.interpolated(triangle, ray).map(|at| self.point(triangle, &at))
    }

    /// A pixel. Differences are those of its row and its column of the quad; where pixels of the quad lie beside the triangle,
    /// attributes go on in its plane, as those of helper invocations do.
    pub fn fragment(&self, triangle: &Projected, screen: &Screen, column: usize, row: usize) -> Option<Fragment> {
        let at = |column: usize, row: usize| self.interpolated(triangle, screen.ray(column as f64, row as f64));
        let step = |from: Option<Interpolated>, to: Option<Interpolated>| match (from, to) {
            (Some(from), Some(to)) => Step {
                position: (to.position - from.position).as_vec3(),
                view: (to.view - from.view).as_vec3(),
                normal: (to.normal - from.normal).as_vec3(),
                uv: (to.uv - from.uv).as_vec2(),
            },
            _ => Step::default(),
        };
        let (left, top) = (column & !1, row & !1);
        Some(Fragment {
            point: self.point(triangle, &at(column, row)?),
            right: step(at(left, row), at(left + 1, row)),
            up: step(at(column, top + 1), at(column, top)),
        })
    }
}
