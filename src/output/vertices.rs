//! Curvature at the vertices of a mesh as a file.

use std::path::Path;

use serde::Serialize;

use super::{MANIFEST, Stage, may_build, safe_name, stale};
use crate::curvature::{Curvature, Mesh};
use crate::error::Result;
use crate::material::{GENERATOR, SCHEMA};

/// A vertex: position, normal, and the shape operator in object space.
#[derive(Serialize)]
struct Vertex {
    x: f32,
    y: f32,
    z: f32,
    nx: f32,
    ny: f32,
    nz: f32,
    w_xx: f32,
    w_xy: f32,
    w_xz: f32,
    w_yy: f32,
    w_yz: f32,
    w_zz: f32,
}

#[derive(Serialize)]
struct Face {
    /// Three; the crate writes lists only from vectors.
    vertex_indices: Vec<u32>,
}

#[derive(Serialize)]
struct Ply {
    vertex: Vec<Vertex>,
    face: Vec<Face>,
}

/// How a shader makes a roughness tensor of the attributes of a vertex.
const DECODE: &str = "W = [w_xx w_xy w_xz; w_xy w_yy w_yz; w_xz w_yz w_zz], 1 / length in object space; a round footprint of \
                      radius r about the vertex adds K = r^2 / 2 [Wt.Wt Wt.Wb; Wt.Wb Wb.Wb] to R, for unit tangent t and \
                      bitangent b in object space; of one width alpha^2 grows by r^2 / 4 times the sum of the squares of all \
                      nine entries";

/// The file of a material's vertices.
pub fn vertices_name(material: &str) -> String {
    format!("{}_curvature.ply", safe_name(material))
}

/// Writes a mesh with the curvature at each of its vertices as binary PLY, and a manifest; both or none.
///
/// # Errors
/// Whatever the system refuses, and a file there that mipfold did not write, unless `force`.
pub fn write_vertices(folder: &Path, material: &str, mesh: &Mesh, curvature: &[Curvature], force: bool) -> Result<()> {
    let name = vertices_name(material);
    may_build(folder, material, [name.as_str()], force)?;
    let stale = stale(folder, material, &[&name]);
    let vertex = |((p, n), c): ((&glam::Vec3, &glam::Vec3), &Curvature)| {
        let [w_xx, w_xy, w_xz, w_yy, w_yz, w_zz] = c.form.map(|v| v as f32);
        Vertex { x: p.x, y: p.y, z: p.z, nx: n.x, ny: n.y, nz: n.z, w_xx, w_xy, w_xz, w_yy, w_yz, w_zz }
    };
    let ply = Ply {
        vertex: mesh.positions.iter().zip(&mesh.normals).zip(curvature).map(vertex).collect(),
        face: mesh.triangles.iter().map(|t| Face { vertex_indices: t.to_vec() }).collect(),
    };
    let stage = Stage::new(folder)?;
    stage.write(&name, |out| {
        let options = serde_ply::SerializeOptions::binary_le();
        serde_ply::to_writer(&ply, options, out).map_err(std::io::Error::other)
    })?;
    let manifest = serde_json::json!({
        "schema": SCHEMA,
        "generator": GENERATOR,
        "version": env!("CARGO_PKG_VERSION"),
        "material": material,
        "vertices": mesh.positions.len(),
        "triangles": mesh.triangles.len(),
        "normals_computed": mesh.normals_computed,
        "maps": [{ "role": "vertex-curvature", "container": "ply", "files": [name], "decode": DECODE }],
    });
    stage.write(MANIFEST, |out| {
        serde_json::to_writer_pretty(&mut *out, &manifest)?;
        std::io::Write::write_all(out, b"\n")
    })?;
    stage.commit(MANIFEST, &stale)
}
