//! Triangles on the screen, in the homogeneous form that needs no clipping.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use crate::curvature::Mesh;

/// A pinhole camera with a square picture. What lies behind the eye is not drawn, nor is a triangle that reaches there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshView {
    /// Where it is, in the mesh's space.
    pub eye: Vec3,
    /// What it looks at: the middle of the picture.
    pub target: Vec3,
    /// Any direction that points up in the picture, not along the line of sight.
    pub up: Vec3,
    /// Tangent of half the angle of view.
    pub half_view: f32,
}

/// Axes of the camera: right, up and ahead, unit.
#[derive(Clone, Copy)]
pub(super) struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    ahead: DVec3,
    half_view: f64,
}

impl Camera {
    pub fn new(view: &MeshView) -> Self {
        let ahead = (view.target - view.eye).as_dvec3().try_normalize().unwrap_or(DVec3::NEG_Z);
        let right = ahead.cross(view.up.as_dvec3()).try_normalize().unwrap_or_else(|| ahead.any_orthonormal_vector());
        let half_view = f64::from(view.half_view);
        Self { eye: view.eye.as_dvec3(), right, up: right.cross(ahead), ahead, half_view }
    }

    /// Components along the axes.
    fn local(&self, p: DVec3) -> DVec3 {
        let p = p - self.eye;
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.ahead))
    }

    /// Towards the eye.
    pub fn to_eye(self, p: DVec3) -> DVec3 {
        (self.eye - p).normalize_or(-self.ahead)
    }

    /// Right, up, and towards the eye.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.right, self.up, -self.ahead]
    }

    /// Width of a pixel at a distance ahead.
    pub fn pixel(&self, pixels: usize, ahead: f64) -> f64 {
        2.0 * self.half_view * ahead / pixels as f64
    }
}

/// Square samples of a picture: which place on the screen each stands for.
#[derive(Clone, Copy)]
pub(super) struct Screen {
    /// Samples along one side.
    pub samples: usize,
    half_view: f64,
    /// By how much the picture is moved, in samples, right and up.
    offset: DVec2,
}

impl Screen {
    pub fn new(camera: &Camera, samples: usize, offset: DVec2) -> Self {
        Self { samples, half_view: camera.half_view, offset }
    }

    /// The ray through the middle of a sample, of length 1 ahead.
    #[inline]
    pub fn ray(&self, column: f64, row: f64) -> DVec3 {
        let scale = 2.0 * self.half_view / self.samples as f64;
        let middle = 0.5 * self.samples as f64;
        DVec3::new(scale * (column + 0.5 - self.offset.x - middle), scale * (middle - row - 0.5 - self.offset.y), 1.0)
    }

    /// Column and row, with parts, of a point in the camera's axes.
    fn place(&self, p: DVec3) -> DVec2 {
        let scale = self.samples as f64 / (2.0 * self.half_view * p.z);
        let middle = 0.5 * self.samples as f64 - 0.5;
        DVec2::new(middle + scale * p.x + self.offset.x, middle - scale * p.y - self.offset.y)
    }

    /// Samples whose middles lie between two places, or on them but for rounding.
    fn between(&self, low: f64, high: f64) -> Range<u32> {
        let last = self.samples as f64;
        let (low, high) = (low - 1e-6, high + 1e-6);
        let (low, high) = (low.ceil().clamp(0.0, last), (high.floor() + 1.0).clamp(0.0, last));
        low as u32..high as u32
    }
}

/// A triangle before the camera. On a ray d the weights of the corners over depth are dot products of d, so linear on the
/// screen, and their sum is 1 / depth (Olano and Greer 1997).
pub(super) struct Projected {
    pub index: u32,
    /// Planes through the eye and an edge, of any length, positive on the triangle's side.
    edges: [DVec3; 3],
    /// What makes them weights over depth.
    scale: f64,
    pub columns: Range<u32>,
    pub rows: Range<u32>,
}

impl Projected {
    /// Nothing for a triangle seen edge-on, or behind the eye, or between samples, or beside the picture.
    pub fn new(mesh: &Mesh, index: usize, camera: &Camera, screen: &Screen) -> Option<Self> {
        let [a, b, c] = mesh.triangles[index].map(|i| camera.local(mesh.positions[i as usize].as_dvec3()));
        if a.z.min(b.z).min(c.z) <= 0.0 {
            return None;
        }
        let determinant = a.dot(b.cross(c));
        if determinant == 0.0 {
            return None;
        }
        let [p, q, r] = [a, b, c].map(|corner| screen.place(corner));
        let (low, high) = (p.min(q).min(r), p.max(q).max(r));
        let (columns, rows) = (screen.between(low.x, high.x), screen.between(low.y, high.y));
        if columns.is_empty() || rows.is_empty() {
            return None;
        }
        // Not divided yet: a shared edge is the same to the bit, but for its sign, from both sides, and no sample falls
        // between two triangles.
        let edges = [b.cross(c), c.cross(a), a.cross(b)].map(|edge| edge * determinant.signum());
        Some(Self { index: index as u32, edges, scale: 1.0 / determinant.abs(), columns, rows })
    }

    /// Weights of the corners over depth on a ray, inside or beside the triangle.
    pub fn weights(&self, ray: DVec3) -> DVec3 {
        self.scale * DVec3::from_array(self.edges.map(|edge| edge.dot(ray)))
    }

    /// 1 / depth on a ray that meets the triangle.
    #[inline]
    pub fn near(&self, ray: DVec3) -> Option<f64> {
        let edges = self.edges.map(|edge| edge.dot(ray));
        let sum = edges[0] + edges[1] + edges[2];
        (edges.iter().all(|edge| *edge >= 0.0) && sum > 0.0).then_some(self.scale * sum)
    }
}
