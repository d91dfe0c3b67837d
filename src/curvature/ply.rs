//! Meshes of PLY files, text and binary. Texture coordinates may stand at vertices (`s t`, `u v`, `texture_u texture_v`)
//! or at the corners of faces (`texcoord`).

use std::collections::HashMap;
use std::io::{BufReader, Read};
use std::path::Path;

use glam::{Vec2, Vec3};
use serde::Deserialize;
use serde_ply::PlyReader;

use super::mesh::{Piece, Pieces};
use super::weld::bits;
use crate::error::{Error, Result};

#[derive(Deserialize)]
struct Vertex {
    x: f32,
    y: f32,
    z: f32,
    #[serde(default)]
    nx: Option<f32>,
    #[serde(default)]
    ny: Option<f32>,
    #[serde(default)]
    nz: Option<f32>,
    #[serde(default, alias = "u", alias = "texture_u")]
    s: Option<f32>,
    #[serde(default, alias = "v", alias = "texture_v")]
    t: Option<f32>,
}

#[derive(Deserialize)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<i64>,
    #[serde(default)]
    texcoord: Vec<f32>,
}

/// An element that nothing is read from.
#[derive(Deserialize)]
struct Skipped {}

/// The one piece of a file. Polygons are cut into fans, which is right for convex ones.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Pieces> {
    let broken = |error: serde_ply::DeserializeError| Error::invalid(path, error.0.to_string(), "a PLY file");
    // Text may end without a line break, which the reader asks for.
    let mut reader = PlyReader::from_reader(BufReader::new(bytes.chain(&b"\n"[..]))).map_err(broken)?;
    for element in &reader.header().elem_defs {
        // Each row takes a byte at least, so that a count beyond the file's length is a lie.
        if element.count > bytes.len() || element.count > 0 && element.properties.is_empty() {
            let found = format!("{} rows of '{}' in {} bytes", element.count, element.name, bytes.len());
            return Err(Error::invalid(path, found, "as many rows as the file holds"));
        }
    }
    let (mut vertices, mut faces): (Vec<Vertex>, Option<Vec<Face>>) = (Vec::new(), None);
    while let Some(name) = reader.current_element().map(|element| element.name.clone()) {
        match name.as_str() {
            "vertex" => vertices = reader.next_element().map_err(broken)?,
            "face" => faces = Some(reader.next_element().map_err(broken)?),
            _ => drop(reader.next_element::<Vec<Skipped>>().map_err(broken)?),
        }
    }
    let faces = faces.ok_or_else(|| Error::unsupported(path, "a PLY file without faces", "a mesh with faces"))?;
    Ok(Pieces { pieces: vec![piece(path, &vertices, &faces)?], materials: Vec::new() })
}

fn piece(path: &Path, vertices: &[Vertex], faces: &[Face]) -> Result<Piece> {
    let mut positions: Vec<Vec3> = vertices.iter().map(|v| Vec3::new(v.x, v.y, v.z)).collect();
    let mut normals: Vec<Vec3> = match vertices.first() {
        Some(Vertex { nx: Some(_), ny: Some(_), nz: Some(_), .. }) => {
            vertices.iter().map(|v| Vec3::new(v.nx.unwrap_or(0.0), v.ny.unwrap_or(0.0), v.nz.unwrap_or(0.0))).collect()
        }
        _ => Vec::new(),
    };
    let at_corners = faces.iter().any(|face| !face.texcoord.is_empty());
    let at_vertices = vertices.iter().any(|v| v.s.is_some() && v.t.is_some());
    let mut uvs: Vec<Vec2> = vertices.iter().map(|v| Vec2::new(v.s.unwrap_or(0.0), v.t.unwrap_or(0.0))).collect();
    let mut triangles = Vec::with_capacity(faces.len());
    let mut corners: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    let mut fresh = vec![true; vertices.len()];
    for (i, face) in faces.iter().enumerate() {
        let count = face.vertex_indices.len();
        if at_corners && face.texcoord.len() != 2 * count {
            let found = format!("{} texture coordinates at the {count} corners of face {i}", face.texcoord.len());
            return Err(Error::invalid(path, found, "two a corner, or none"));
        }
        let mut indices = Vec::with_capacity(count);
        for (k, &index) in face.vertex_indices.iter().enumerate() {
            let Some(v) = usize::try_from(index).ok().filter(|&v| v < vertices.len()) else {
                let (found, last) = (format!("vertex {index} in face {i}"), vertices.len() as i64 - 1);
                return Err(Error::invalid(path, found, format!("vertices 0 to {last}")));
            };
            let mut vertex = v as u32;
            if at_corners {
                // A vertex takes the coordinates of the first corner there; each further pair gets a copy of it.
                let uv = Vec2::new(face.texcoord[2 * k], face.texcoord[2 * k + 1]);
                vertex = *corners.entry((vertex, uv.to_array().map(bits))).or_insert_with(|| {
                    if std::mem::take(&mut fresh[v]) {
                        uvs[v] = uv;
                        return v as u32;
                    }
                    positions.push(positions[v]);
                    uvs.push(uv);
                    if !normals.is_empty() {
                        normals.push(normals[v]);
                    }
                    (positions.len() - 1) as u32
                });
            }
            indices.push(vertex);
        }
        triangles.extend((2..count).map(|k| [indices[0], indices[k - 1], indices[k]]));
    }
    let uvs = (at_corners || at_vertices).then_some(uvs);
    Ok(Piece { material: None, positions, normals, uvs, triangles })
}
