//! Real meshes, where they are: in the folder that `MIPFOLD_MESHES` names, or in `../shared/meshes`.

use std::path::PathBuf;

use glam::DVec3;

use super::super::moments::Gather;
use super::super::{BakeOptions, LoadOptions, Mesh, bake, load, vertex_curvature};
use crate::image::Size;

/// A mesh of the folder; nothing, said plainly, if it is not there.
#[expect(clippy::print_stderr, reason = "a test that skips says so")]
fn mesh(name: &str) -> Option<Mesh> {
    let folder = std::env::var_os("MIPFOLD_MESHES").map_or_else(|| PathBuf::from("../shared/meshes"), PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        assert!(std::env::var_os("MIPFOLD_NO_SKIP").is_none(), "no {}, and MIPFOLD_NO_SKIP is set", path.display());
        eprintln!("SKIPPED: no {}; MIPFOLD_MESHES names the folder of meshes", path.display());
        return None;
    }
    Some(load(&path, &LoadOptions::default()).unwrap())
}

#[test]
fn every_mesh_with_texture_coordinates_bakes() {
    let meshes = [
        ("shader_ball/shader_ball.gltf", 67_832, 3),
        ("spot/spot.obj", 5_856, 1),
        ("usd_shader_ball/shaderball.glb", 88_264, 1),
    ];
    for (name, triangles, parts) in meshes {
        let Some(mesh) = mesh(name) else { continue };
        assert_eq!((mesh.triangles.len(), mesh.parts.len()), (triangles, parts), "{name}");
        for index in 0..parts {
            let part = mesh.select(&[index]);
            let baked = bake(&part, Size::new(256, 256), &BakeOptions::default(), &|_| ()).unwrap();
            let summary = baked.summary;
            assert_eq!(summary.triangles + summary.without_area + summary.without_texture_area, part.triangles.len());
            assert!(summary.left_out < 1e-3 && summary.covered > 10_000, "{name}: {summary:?}");
            // Footprints grow, and so does what is in them.
            let mean = |k: usize| {
                let level = &baked.levels[k];
                let covered = level.added.iter().zip(&level.coverage).filter(|(_, coverage)| **coverage > 0.0);
                let (sum, count) = covered.fold((0.0, 0), |(sum, count), (k, _)| (sum + k.mean(), count + 1));
                sum / count as f32
            };
            let means: Vec<f32> = (0..7).map(mean).collect();
            assert!(means.is_sorted() && means[0] > 1e-5 && means[0] < 0.02 && means[6] < 1.0, "{name}: {means:?}");
            let within = |level: &super::super::Level| level.added.iter().all(|k| (0.0..1.001).contains(&k.mean()));
            assert!(baked.levels.iter().all(within), "{name}");
        }
    }
}

#[test]
fn the_cow_spreads_as_points_on_its_surface_do() {
    let Some(mesh) = mesh("spot/spot.obj") else { return };
    let (side, per_edge) = (64, 24);
    let baked = bake(&mesh, Size::new(side, side), &BakeOptions::default(), &|_| ()).unwrap();
    // The middles of the small triangles of each triangle, sorted into texels.
    let mut texels: Vec<Gather> = (0..side * side).map(|_| Gather::default()).collect();
    for t in &mesh.triangles {
        let [p, n] = [&mesh.positions, &mesh.normals].map(|list| t.map(|i| list[i as usize].as_dvec3()));
        let uv = t.map(|i| mesh.uvs.as_ref().unwrap()[i as usize].as_dvec2());
        let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
        for i in 0..per_edge {
            for j in 0..2 * (per_edge - i) - 1 {
                let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                let (b, c) = ((i as f64 + third) / per_edge as f64, ((j / 2) as f64 + third) / per_edge as f64);
                let at = uv[0] + b * (uv[1] - uv[0]) + c * (uv[2] - uv[0]);
                let (x, y) = ((at.x * side as f64) as usize, ((1.0 - at.y) * side as f64) as usize);
                let normal: DVec3 = n[0] + b * (n[1] - n[0]) + c * (n[2] - n[0]);
                texels[y * side + x].add(area, normal.normalize());
            }
        }
    }
    let (mut sampled, mut drawn) = (0.0, 0.0);
    for ((k, coverage), gather) in baked.levels[0].added.iter().zip(&baked.levels[0].coverage).zip(&texels) {
        // Charts border on half-empty texels.
        if (coverage - 1.0).abs() < 1e-3 {
            let (mean, cov) = gather.mean_and_cov();
            let n = mean.normalize();
            sampled += cov[0] + cov[3] + cov[5] - super::super::moments::form(&cov, n, n);
            drawn += f64::from(k.mean());
        }
    }
    assert!(drawn > 1.0 && (sampled / drawn - 1.0).abs() < 0.01, "{sampled} {drawn}");
}

#[test]
fn a_mesh_without_texture_coordinates_has_curvature_at_its_vertices() {
    let Some(mesh) = mesh("cycloidal/cycloidal.ply") else { return };
    assert!(mesh.uvs.is_none() && mesh.normals_computed && mesh.triangles.len() == 43_368);
    // Creases split vertices: 21384 in the file.
    assert!(mesh.positions.len() > 30_000, "{}", mesh.positions.len());
    let curvature = vertex_curvature(&mesh);
    assert_eq!(curvature.len(), mesh.positions.len());
    assert!(curvature.iter().all(|c| c.mean_square().is_finite()));
    // Planes and cylinders: a quarter of the vertices are flat.
    let flat = curvature.iter().filter(|c| c.mean_square() < 1e-3).count();
    assert!(flat > curvature.len() / 4 && flat < curvature.len() * 3 / 4, "{flat} of {}", curvature.len());
}
