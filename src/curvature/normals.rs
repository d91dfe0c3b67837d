//! Normals of a mesh that has none.
//!
//! Each corner's normal is the mean of the faces around it, weighted by their angles there (Thuermer & Wuethrich 1998), as
//! far as one can walk around the vertex without crossing a crease: an edge whose faces meet at more than the crease
//! angle, or an edge of one face, of more than two, or of two that disagree about which side is out.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::weld::{Sets, by_position};

/// A mesh in the making: what [`complete`] reads and extends.
pub(super) struct Vertices {
    /// One a vertex.
    pub positions: Vec<Vec3>,
    /// One a vertex, zero where it is missing.
    pub normals: Vec<Vec3>,
    /// One a vertex, or none at all.
    pub uvs: Vec<Vec2>,
    /// Vertices, three a face.
    pub triangles: Vec<[u32; 3]>,
}

/// Gives every vertex that lacks a normal one, and splits it where a crease (radians) runs through it. Whether any was
/// missing.
pub(super) fn complete(mesh: &mut Vertices, crease: f64) -> bool {
    let given: Vec<bool> = mesh.normals.iter().map(|n| *n != Vec3::ZERO).collect();
    if given.iter().all(|&given| given) {
        return false;
    }
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize].as_dvec3());
    let faces: Vec<Face> = mesh.triangles.par_iter().map(|t| Face::new(corners(t))).collect();
    let mut groups = smooth_groups(&mesh.positions, &mesh.triangles, &faces, crease);
    let roots: Vec<u32> = (0..3 * faces.len() as u32).map(|corner| groups.root(corner)).collect();
    let mut sums = vec![DVec3::ZERO; roots.len()];
    for (corner, &root) in roots.iter().enumerate() {
        let face = &faces[corner / 3];
        sums[root as usize] += face.angles[corner % 3] * face.normal;
    }
    // A vertex keeps the first group of corners that comes by; each further one gets a copy of it.
    let mut filled = given.clone();
    let mut vertex_of: HashMap<(u32, u32), u32> = HashMap::new();
    for (corner, &root) in roots.iter().enumerate() {
        let vertex = &mut mesh.triangles[corner / 3][corner % 3];
        let old = *vertex as usize;
        if given[old] {
            continue;
        }
        *vertex = *vertex_of.entry((*vertex, root)).or_insert_with(|| {
            let sum = sums[root as usize].try_normalize().unwrap_or(faces[corner / 3].normal);
            let normal = if sum == DVec3::ZERO { Vec3::Z } else { sum.as_vec3() };
            if !filled[old] {
                filled[old] = true;
                mesh.normals[old] = normal;
                return old as u32;
            }
            mesh.positions.push(mesh.positions[old]);
            mesh.normals.push(normal);
            if !mesh.uvs.is_empty() {
                mesh.uvs.push(mesh.uvs[old]);
            }
            (mesh.positions.len() - 1) as u32
        });
    }
    // Vertices of no face: any normal will do.
    mesh.normals.iter_mut().filter(|n| **n == Vec3::ZERO).for_each(|n| *n = Vec3::Z);
    true
}

/// Shape of a triangle.
struct Face {
    /// Unit, on the side from which the corners run counter-clockwise; zero without area.
    normal: DVec3,
    /// Angle at each corner, radians.
    angles: [f64; 3],
}

impl Face {
    fn new(p: [DVec3; 3]) -> Self {
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
        let angle = |i: usize| {
            let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            a.cross(b).length().atan2(a.dot(b))
        };
        Self { normal, angles: [0, 1, 2].map(angle) }
    }
}

/// Corners (3 a triangle) that share a normal: joined across every edge that is no crease.
fn smooth_groups(positions: &[Vec3], triangles: &[[u32; 3]], faces: &[Face], crease: f64) -> Sets {
    let (points, _) = by_position(positions);
    // Each edge with the corner that it starts from, sorted so that the two sides of an edge meet.
    let mut edges: Vec<([u32; 2], u32)> = (0..3 * triangles.len())
        .into_par_iter()
        .map(|corner| {
            let t = triangles[corner / 3].map(|i| points[i as usize]);
            let (a, b) = (t[corner % 3], t[(corner + 1) % 3]);
            ([a.min(b), a.max(b)], corner as u32)
        })
        .collect();
    edges.par_sort_unstable();
    let start = |corner: u32| points[triangles[corner as usize / 3][corner as usize % 3] as usize];
    let next = |corner: u32| corner - corner % 3 + (corner + 1) % 3;
    let least_cos = crease.cos();
    let mut sets = Sets::new(3 * triangles.len());
    for side in edges.chunk_by(|a, b| a.0 == b.0) {
        let &[([p, q], a), (_, b)] = side else { continue };
        let (m, n) = (faces[a as usize / 3].normal, faces[b as usize / 3].normal);
        let smooth = m == DVec3::ZERO || n == DVec3::ZERO || m.dot(n) >= least_cos - 1e-9;
        if smooth && p != q && start(a) != start(b) {
            sets.join(a, next(b));
            sets.join(next(a), b);
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    fn completed(positions: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]], crease: f64) -> Vertices {
        let (positions, normals, triangles) = (positions.to_vec(), normals.to_vec(), triangles.to_vec());
        let mut mesh = Vertices { positions, normals, uvs: Vec::new(), triangles };
        assert!(complete(&mut mesh, crease));
        assert!(mesh.normals.iter().all(|n| n.is_normalized()) && mesh.normals.len() == mesh.positions.len());
        mesh
    }

    /// A roof: two faces over the edge from 0 to 1, which fall by `angle` on each side.
    fn roof(angle: f32, crease: f64) -> Vertices {
        let (s, c) = angle.sin_cos();
        let positions = [Vec3::ZERO, Vec3::X, Vec3::new(0.5, c, -s), Vec3::new(0.5, -c, -s)];
        completed(&positions, &[Vec3::ZERO; 4], &[[0, 1, 2], [1, 0, 3]], crease)
    }

    #[test]
    fn a_smooth_edge_shares_its_vertices_and_a_crease_splits_them() {
        let smooth = roof(0.3, 0.7);
        assert_eq!(smooth.triangles, [[0, 1, 2], [1, 0, 3]]);
        assert!(smooth.normals.len() == 4 && smooth.normals[..2].iter().all(|n| n.distance(Vec3::Z) < 1e-6));
        let sharp = roof(0.3, 0.5);
        assert_eq!((sharp.normals.len(), sharp.triangles[1]), (6, [4, 5, 3]));
        assert!((sharp.normals[0].angle_between(sharp.normals[5]) - 0.6).abs() < 1e-5);
    }

    #[test]
    fn given_normals_stay() {
        let mesh = completed(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[Vec3::Z, Vec3::ZERO, Vec3::X], &[[0, 1, 2]], 1.0);
        assert_eq!(mesh.normals, [Vec3::Z, Vec3::Z, Vec3::X]);
    }

    #[test]
    fn faces_without_area_still_leave_unit_normals() {
        completed(&[Vec3::ZERO; 4], &[Vec3::ZERO; 4], &[[0, 1, 2], [0, 0, 0]], 1.0);
    }
}
