//! Shapes with texture coordinates, and the exact answer for their texels.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2};

use super::super::Mesh;

/// A surface over the unit square, u to the right, v up: position and unit normal.
pub type Shape = fn(DVec2) -> (DVec3, DVec3);

/// Radius 1.5, pole up; u goes around, v from the south pole to the north pole.
pub fn sphere(uv: DVec2) -> (DVec3, DVec3) {
    let (sin, cos) = (TAU * uv.x).sin_cos();
    let (z, r) = (TAU * (0.5 * uv.y - 0.25)).sin_cos();
    let n = DVec3::new(r * cos, r * sin, z);
    (1.5 * n, n)
}

/// Radius 0.5, height 3 along z; u goes around.
pub fn cylinder(uv: DVec2) -> (DVec3, DVec3) {
    let (sin, cos) = (TAU * uv.x).sin_cos();
    (DVec3::new(0.5 * cos, 0.5 * sin, 3.0 * uv.y), DVec3::new(cos, sin, 0.0))
}

/// Radii 2 and 0.7; u goes the long way around.
pub fn torus(uv: DVec2) -> (DVec3, DVec3) {
    let (around, tube) = ((TAU * uv.x).sin_cos(), (TAU * uv.y).sin_cos());
    let n = DVec3::new(tube.1 * around.1, tube.1 * around.0, tube.0);
    (DVec3::new(2.0 * around.1, 2.0 * around.0, 0.0) + 0.7 * n, n)
}

/// Tilted, 2 by 1.
pub fn plane(uv: DVec2) -> (DVec3, DVec3) {
    (DVec3::new(2.0 * uv.x, 0.8 * uv.y, 0.6 * uv.y), DVec3::new(0.0, -0.6, 0.8))
}

/// A grid of `wide` by `high` quads over the part of the shape from `low` to `high`, each as two triangles; texture
/// coordinates as `place` puts them.
pub fn grid(shape: Shape, counts: [usize; 2], low: DVec2, high: DVec2, place: impl Fn(DVec2) -> DVec2) -> Mesh {
    let (mut positions, mut normals, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for j in 0..=counts[1] {
        for i in 0..=counts[0] {
            let share = DVec2::new(i as f64 / counts[0] as f64, j as f64 / counts[1] as f64);
            let uv = low + share * (high - low);
            let (p, n) = shape(uv);
            positions.push(p.as_vec3());
            normals.push(n.as_vec3());
            uvs.push(place(uv).as_vec2());
        }
    }
    let at = |i: usize, j: usize| (j * (counts[0] + 1) + i) as u32;
    for j in 0..counts[1] {
        for i in 0..counts[0] {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Mesh::new(positions, Some(normals), Some(uvs), triangles, 60.0).unwrap()
}

/// The whole shape, its texture coordinates those of the shape.
pub fn whole(shape: Shape, counts: [usize; 2]) -> Mesh {
    grid(shape, counts, DVec2::ZERO, DVec2::ONE, |uv| uv)
}

/// Meshes side by side in one.
pub fn joined(meshes: &[Mesh]) -> Mesh {
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let mut uvs: Vec<Vec2> = Vec::new();
    for mesh in meshes {
        let base = positions.len() as u32;
        positions.extend_from_slice(&mesh.positions);
        normals.extend_from_slice(&mesh.normals);
        uvs.extend_from_slice(mesh.uvs.as_ref().unwrap());
        triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| base + i)));
    }
    Mesh::new(positions, Some(normals), Some(uvs), triangles, 60.0).unwrap()
}

/// Twice the covariance of the exact normals of the shape over a rectangle of texture space, weighted by surface area, in
/// the frame of the mean normal and the u direction; by four Gauss points in each of `steps` by `steps` cells. It shares
/// nothing with the bake.
pub fn exact(shape: Shape, low: DVec2, high: DVec2, steps: usize) -> [f64; 3] {
    let mut points = Vec::new();
    let middle = |i: usize| (i / 2) as f64 + 0.5 + (i % 2) as f64 * 3f64.sqrt().recip() - 0.5 / 3f64.sqrt();
    for j in 0..2 * steps {
        for i in 0..2 * steps {
            let uv = low + (high - low) * DVec2::new(middle(i), middle(j)) / steps as f64;
            let h = 1e-5;
            let along = |d: DVec2| (shape(uv + h * d).0 - shape(uv - h * d).0) / (2.0 * h);
            let (along_u, along_v) = (along(DVec2::X), along(DVec2::Y));
            points.push((along_u.cross(along_v).length(), shape(uv).1, along_u.normalize()));
        }
    }
    let total: f64 = points.iter().map(|p| p.0).sum();
    let mean: DVec3 = points.iter().map(|p| p.0 / total * p.1).sum();
    let tangent: DVec3 = points.iter().map(|p| p.0 / total * p.2).sum();
    let n = mean.normalize();
    let t = (tangent - n * n.dot(tangent)).normalize();
    let b = n.cross(t);
    let about = |a: DVec3, b: DVec3| -> f64 {
        points.iter().map(|p| p.0 / total * a.dot(p.1 - mean) * b.dot(p.1 - mean)).sum()
    };
    [2.0 * about(t, t), 2.0 * about(t, b), 2.0 * about(b, b)]
}
