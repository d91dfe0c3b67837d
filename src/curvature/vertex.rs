//! Curvature at the vertices, for meshes without a texture.

use glam::{DMat3, DQuat, DVec3, Vec3};
use rayon::prelude::*;

use super::Mesh;
use super::moments::form;
use super::weld::{bits, weld};
use crate::ndf::{Frame, RoughnessTensor};
use crate::roughness::Alpha;

/// How the normal turns at a vertex: a step `d` along the surface changes it by `W d`. W, the shape operator, is
/// symmetric, kills the normal, and has the two principal curvatures and their directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// W in object space, xx xy xz yy yz zz; 1 / length.
    pub form: [f64; 6],
}

impl Curvature {
    /// Mean of the squares of the principal curvatures, 1 / length^2.
    pub fn mean_square(&self) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.form;
        0.5 * (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz))
    }

    /// What a round footprint of this radius (in the mesh's unit of length, on the surface) adds to the roughness tensor in
    /// a tangent frame of the vertex: positions on a disk have the variance `radius^2 / 4` along each axis, and `K` is
    /// twice the covariance of the normals, `radius^2 / 2 W W`. A square pixel of side s is as wide as a disk of
    /// radius `s / sqrt(3)`. First order: good while radius times curvature is small; not capped.
    pub fn added(&self, frame: Frame, radius: f64) -> RoughnessTensor {
        let [xx, xy, xz, yy, yz, zz] = self.form;
        let w = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let (t, b) = (w * frame.tangent.as_dvec3(), w * frame.bitangent.as_dvec3());
        let half = 0.5 * radius * radius;
        RoughnessTensor { xx: (half * t.dot(t)) as f32, xy: (half * t.dot(b)) as f32, yy: (half * b.dot(b)) as f32 }
    }

    /// The one width whose square a round footprint of this radius adds to alpha^2: the mean over both axes.
    pub fn isotropic(&self, radius: f64) -> Alpha {
        Alpha((0.5 * radius * radius * self.mean_square()).sqrt() as f32)
    }

    /// Curvature along a unit direction of the tangent plane, positive where the surface bends away from its normal.
    pub fn along(&self, direction: Vec3) -> f64 {
        form(&self.form, direction.as_dvec3(), direction.as_dvec3())
    }
}

/// The curvature at every vertex of a mesh: on each face the shape operator that fits the differences of its normals along
/// its edges best, then the mean over the faces around, by the area that belongs to the vertex (Rusinkiewicz 2004,
/// section 3; areas by Meyer et al. 2003, section 3.3). Vertices at the same place with the same normal count as one, so
/// that cuts of a texture do not show; where normals differ, an edge, each side has its own.
pub fn vertex_curvature(mesh: &Mesh) -> Vec<Curvature> {
    let keys = mesh.positions.iter().zip(&mesh.normals).map(|(p, n)| {
        let [x, y, z] = p.to_array().map(bits);
        // Normals of two sides of a cut may differ by their rounding.
        let [a, b, c] = n.to_array().map(|v| (v * 4096.0).round() as i32 as u32);
        [x, y, z, a, b, c]
    });
    let (points, count) = weld(keys);
    let faces: Vec<_> = mesh.triangles.par_iter().map(|t| face(mesh, t)).collect();
    let mut sums = vec![([0.0; 6], 0.0); count];
    for (triangle, face) in mesh.triangles.iter().zip(&faces) {
        let Some((w, normal, areas)) = face else { continue };
        for (&vertex, area) in triangle.iter().zip(areas) {
            let own = mesh.normals[vertex as usize].as_dvec3();
            let turn = DMat3::from_quat(DQuat::from_rotation_arc(*normal, own));
            let turned = turn * *w * turn.transpose();
            let (sum, total) = &mut sums[points[vertex as usize] as usize];
            let [x, y, z] = [turned.x_axis, turned.y_axis, turned.z_axis];
            for (sum, value) in sum.iter_mut().zip([x.x, x.y, x.z, y.y, y.z, z.z]) {
                *sum += area * value;
            }
            *total += area;
        }
    }
    let mean = |&point: &u32| {
        let (sum, area) = sums[point as usize];
        Curvature { form: sum.map(|v| if area > 0.0 { v / area } else { 0.0 }) }
    };
    points.iter().map(mean).collect()
}

/// The shape operator of a face, its unit normal, and the areas that belong to its corners; nothing without area.
fn face(mesh: &Mesh, triangle: &[u32; 3]) -> Option<(DMat3, DVec3, [f64; 3])> {
    let p = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
    let n = triangle.map(|i| mesh.normals[i as usize].as_dvec3());
    let edges = [p[2] - p[1], p[0] - p[2], p[1] - p[0]];
    let turns = [n[2] - n[1], n[0] - n[2], n[1] - n[0]];
    let cross = edges[2].cross(-edges[1]);
    let normal = cross.try_normalize()?;
    let normal = if normal.dot(n[0] + n[1] + n[2]) < 0.0 { -normal } else { normal };
    let t = edges[0].try_normalize()?;
    let b = normal.cross(t);
    // Least squares for (e, f, g): (e f; f g) (x, y) is the turn along an edge (x, y).
    let (mut xx, mut xy, mut yy, mut right) = (0.0, 0.0, 0.0, DVec3::ZERO);
    for (edge, turn) in edges.iter().zip(&turns) {
        let (x, y, u, v) = (edge.dot(t), edge.dot(b), turn.dot(t), turn.dot(b));
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        right += DVec3::new(x * u, y * u + x * v, y * v);
    }
    let system = DMat3::from_cols_array(&[xx, xy, 0.0, xy, xx + yy, xy, 0.0, xy, yy]);
    // Scale-free: the determinant of a needle is tiny beside the cube of its size.
    if system.determinant() <= 1e-12 * (xx + yy).powi(3) {
        return None;
    }
    let efg = system.inverse() * right;
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let w = outer(t, t) * efg.x + (outer(t, b) + outer(b, t)) * efg.y + outer(b, b) * efg.z;
    Some((w, normal, corner_areas(&edges, 0.5 * cross.length())))
}

/// The part of a triangle that is nearer to each corner than to the others; by halves and quarters if it is obtuse (Meyer et
/// al. 2003, figure 4). Edge `i` is opposite to corner `i`.
fn corner_areas(edges: &[DVec3; 3], area: f64) -> [f64; 3] {
    let length2 = edges.map(|e| e.length_squared());
    // The dot of the two edges at a corner; negative if the angle is obtuse.
    let dots = [0, 1, 2].map(|i| -edges[(i + 1) % 3].dot(edges[(i + 2) % 3]));
    if let Some(obtuse) = dots.iter().position(|&d| d < 0.0) {
        return [0, 1, 2].map(|i| area * if i == obtuse { 0.5 } else { 0.25 });
    }
    [0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        // cot of the angle at a corner is its dot over twice the area.
        (length2[j] * dots[j] + length2[k] * dots[k]) / (16.0 * area)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corner_areas_add_up() {
        for p in [[0.3, 0.8], [0.5, 0.1], [2.0, 0.5], [0.0, 1.0]] {
            let p = [DVec3::ZERO, DVec3::X, DVec3::new(p[0], p[1], 0.3)];
            let edges = [p[2] - p[1], p[0] - p[2], p[1] - p[0]];
            let area = 0.5 * edges[2].cross(-edges[1]).length();
            let sum: f64 = corner_areas(&edges, area).iter().sum();
            assert!((sum - area).abs() < 1e-12 * area, "{p:?}");
        }
    }
}
