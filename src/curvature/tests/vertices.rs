//! Curvature at vertices of known shapes.

use glam::{DVec2, Vec3};

use super::super::vertex_curvature;
use super::shapes::{cylinder, sphere, torus, whole};
use crate::ndf::Frame;

#[test]
fn a_sphere_has_one_over_its_radius_everywhere() {
    let mesh = whole(sphere, [64, 32]);
    let curvature = vertex_curvature(&mesh);
    for (i, (c, n)) in curvature.iter().zip(&mesh.normals).enumerate() {
        // At the poles some vertices of the grid have no face with area.
        if n.z.abs() > 0.999 {
            continue;
        }
        assert!((c.mean_square() * 2.25 - 1.0).abs() < 0.02, "{i}: {}", c.mean_square());
        let k = c.added(frame(*n), 0.03);
        // Radius times curvature is 0.02; half its square along both axes.
        assert!((k.xx / 2e-4 - 1.0).abs() < 0.03 && (k.yy / 2e-4 - 1.0).abs() < 0.03 && k.xy.abs() < 4e-6, "{k:?}");
        assert!((c.isotropic(0.03).squared() / k.mean() - 1.0).abs() < 1e-3);
    }
}

/// Any tangent frame.
fn frame(n: Vec3) -> Frame {
    let (tangent, bitangent) = n.any_orthonormal_pair();
    Frame { tangent, bitangent }
}

#[test]
fn a_cylinder_is_straight_along_its_axis() {
    let mesh = whole(cylinder, [64, 8]);
    for (c, n) in vertex_curvature(&mesh).iter().zip(&mesh.normals) {
        let around = Vec3::Z.cross(*n);
        assert!((c.along(around) / 2.0 - 1.0).abs() < 0.01, "{}", c.along(around));
        assert!(c.along(Vec3::Z).abs() < 1e-3 && c.along(*n).abs() < 1e-3);
    }
}

#[test]
fn a_torus_has_its_two_curvatures() {
    let counts = [96, 48];
    let mesh = whole(torus, counts);
    for (i, c) in vertex_curvature(&mesh).iter().enumerate() {
        let uv = DVec2::new((i % 97) as f64 / 96.0, (i / 97) as f64 / 48.0);
        let tube = std::f64::consts::TAU * uv.y;
        let around = Vec3::Z.cross(mesh.positions[i]).normalize();
        let across = mesh.normals[i].cross(around);
        // 1/r across, cos / (R + r cos) around: negative inside.
        let want = tube.cos() / (2.0 + 0.7 * tube.cos());
        assert!((c.along(around) - want).abs() < 0.02, "{uv}: {} {want}", c.along(around));
        assert!((c.along(across) * 0.7 - 1.0).abs() < 0.02, "{uv}: {}", c.along(across));
    }
}

#[test]
fn a_plane_and_a_box_have_none() {
    let mesh = whole(super::shapes::plane, [4, 4]);
    assert!(vertex_curvature(&mesh).iter().all(|c| c.mean_square() < 1e-12));
}
