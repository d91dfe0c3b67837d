//! A triangle mesh, whatever file it came from.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::normals::{self, Vertices};
use super::{gltf, obj, ply};
use crate::codec::read_file;
use crate::error::{Error, Result};
use crate::gltf::is_gltf;

/// The most vertices and the most triangles that a mesh may have: 2^26, 67 million.
pub const MOST_VERTICES: usize = 1 << 26;

/// Triangles in object space, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// One a vertex, finite, in the file's own unit of length.
    pub positions: Vec<Vec3>,
    /// One a vertex, unit: interpolated over a triangle and made unit again, as renderers do.
    pub normals: Vec<Vec3>,
    /// One a vertex, finite, v up (glTF's points down and is turned over); zero for a vertex of a part without any. None
    /// if no part has texture coordinates.
    pub uvs: Option<Vec<Vec2>>,
    /// Vertices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The triangles by material.
    pub parts: Vec<Part>,
    /// Whether normals were missing and were computed with the crease angle.
    pub normals_computed: bool,
}

/// The triangles of one material; a texture usually belongs to one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The material's name in the file, if it has one.
    pub material: Option<String>,
    /// Its number among the file's materials: glTF's own, or in order of first use.
    pub index: Option<usize>,
    /// The triangles in [`Mesh::triangles`].
    pub triangles: Range<usize>,
    /// Whether the part has texture coordinates.
    pub has_uvs: bool,
}

/// How a mesh file is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOptions {
    /// Where normals are missing, faces that meet at more than this angle (degrees, 0 to 180) get an edge between them;
    /// 0 shades every face flat, which is what glTF viewers do with such a mesh.
    pub crease_degrees: f64,
    /// Which set of texture coordinates a glTF file is read with, `TEXCOORD_n`. Other formats have one.
    pub uv_set: usize,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { crease_degrees: 60.0, uv_set: 0 }
    }
}

/// What a loader hands over: the triangles of one material in one object.
#[derive(Debug, Default)]
pub(super) struct Piece {
    /// By number.
    pub material: Option<usize>,
    pub positions: Vec<Vec3>,
    /// As many as positions; zero, or none at all, where they are missing.
    pub normals: Vec<Vec3>,
    /// As many as positions, or none; v up.
    pub uvs: Option<Vec<Vec2>>,
    pub triangles: Vec<[u32; 3]>,
}

/// All pieces of a file, and the names of its materials.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    pub pieces: Vec<Piece>,
    pub materials: Vec<String>,
}

/// Reads a mesh: `.glb`, `.gltf`, `.ply` or `.obj`, told by content where it tells.
///
/// # Errors
/// [`Error::Io`] if a file cannot be read; [`Error::Invalid`] if it is broken, has no triangles, or contradicts
/// itself; [`Error::Unsupported`] for parts of the formats that are not read, and above [`MOST_VERTICES`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Mesh> {
    parse(path, &read_file(path, "a mesh file", u64::MAX)?, options)
}

/// The mesh of a file's bytes; `path` is for messages and for the files beside it.
pub(super) fn parse(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Mesh> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    // Some editors begin text files with a byte order mark, which belongs to no format here.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let read = if is_gltf(bytes) {
        gltf::read(path, bytes, options.uv_set)?
    } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        ply::read(path, bytes)?
    } else if extension == "obj" {
        obj::read(path, bytes)?
    } else {
        let first = String::from_utf8_lossy(&bytes[..bytes.len().min(8)]).into_owned();
        return Err(Error::unsupported(
            path,
            format!("a file that starts with {first:?}"),
            "meshes in .glb, .gltf, .obj and .ply",
        ));
    };
    Mesh::assemble(&path.display().to_string(), read, options.crease_degrees)
}

impl Mesh {
    /// A mesh of one part from its arrays. `normals` and `uvs` hold one a vertex, v up, or are absent; missing normals, and
    /// those of length zero, are computed with `crease_degrees` ([`LoadOptions`]).
    ///
    /// # Errors
    /// [`Error::Invalid`] for lengths that differ, numbers that are not finite, indices beyond the vertices, and a mesh
    /// without triangles.
    pub fn new(
        positions: Vec<Vec3>,
        normals: Option<Vec<Vec3>>,
        uvs: Option<Vec<Vec2>>,
        triangles: Vec<[u32; 3]>,
        crease_degrees: f64,
    ) -> Result<Self> {
        let normals = normals.unwrap_or_default();
        let pieces = vec![Piece { material: None, positions, normals, uvs, triangles }];
        Self::assemble("mesh", Pieces { pieces, materials: Vec::new() }, crease_degrees)
    }

    /// One mesh of all pieces, sorted by material and by whether there are texture coordinates; `subject` is for messages.
    pub(super) fn assemble(subject: &str, read: Pieces, crease_degrees: f64) -> Result<Self> {
        if !(0.0..=180.0).contains(&crease_degrees) {
            return Err(Error::invalid_option("crease angle", crease_degrees.to_string(), "0 to 180 degrees"));
        }
        let Pieces { pieces, materials } = read;
        let mut kinds: Vec<Vec<&Piece>> = Vec::new();
        let mut places = HashMap::new();
        for piece in &pieces {
            check(subject, piece)?;
            let place = *places.entry((piece.material, piece.uvs.is_some())).or_insert(kinds.len());
            kinds.resize(kinds.len().max(place + 1), Vec::new());
            kinds[place].push(piece);
        }
        let (vertices, faces) =
            pieces.iter().fold((0, 0), |(v, t), piece| (v + piece.positions.len(), t + piece.triangles.len()));
        if faces == 0 {
            return Err(Error::invalid_option(subject, "no triangles", "a mesh of triangles"));
        }
        too_many(subject, vertices, faces)?;
        let any_uvs = pieces.iter().any(|piece| piece.uvs.is_some());
        let (mut positions, mut normals, mut uvs) = (Vec::with_capacity(vertices), Vec::new(), Vec::new());
        let (mut triangles, mut parts): (Vec<[u32; 3]>, _) = (Vec::with_capacity(faces), Vec::new());
        for pieces in kinds {
            let first = triangles.len();
            let (index, has_uvs) = (pieces[0].material, pieces[0].uvs.is_some());
            for piece in pieces {
                let base = positions.len() as u32;
                positions.extend_from_slice(&piece.positions);
                normals.extend(piece.normals.iter().map(|n| n.as_dvec3().normalize_or_zero().as_vec3()));
                normals.resize(positions.len(), Vec3::ZERO);
                if any_uvs {
                    uvs.extend_from_slice(piece.uvs.as_deref().unwrap_or_default());
                    uvs.resize(positions.len(), Vec2::ZERO);
                }
                triangles.extend(piece.triangles.iter().map(|t| t.map(|i| base + i)));
            }
            let material = index.map(|i| materials[i].clone());
            parts.push(Part { material, index, triangles: first..triangles.len(), has_uvs });
        }
        let mut vertices = Vertices { positions, normals, uvs, triangles };
        let normals_computed = normals::complete(&mut vertices, crease_degrees.to_radians());
        let Vertices { positions, normals, uvs, triangles } = vertices;
        Ok(Self { positions, normals, uvs: any_uvs.then_some(uvs), triangles, parts, normals_computed })
    }

    /// The mesh of some parts alone, by their indices in [`Mesh::parts`], with the vertices that they use.
    pub fn select(&self, parts: &[usize]) -> Self {
        let mut new_index = vec![u32::MAX; self.positions.len()];
        let (mut used, mut triangles, mut selected) = (Vec::new(), Vec::new(), Vec::new());
        for &part in parts {
            let (part, first) = (&self.parts[part], triangles.len());
            triangles.extend(self.triangles[part.triangles.clone()].iter().map(|t| {
                t.map(|i| {
                    let index = &mut new_index[i as usize];
                    if *index == u32::MAX {
                        *index = used.len() as u32;
                        used.push(i as usize);
                    }
                    *index
                })
            }));
            selected.push(Part { triangles: first..triangles.len(), ..part.clone() });
        }
        let uvs = self.uvs.as_ref().filter(|_| selected.iter().any(|part| part.has_uvs));
        Self {
            positions: used.iter().map(|&i| self.positions[i]).collect(),
            normals: used.iter().map(|&i| self.normals[i]).collect(),
            uvs: uvs.map(|uvs| used.iter().map(|&i| uvs[i]).collect()),
            parts: selected,
            triangles,
            normals_computed: self.normals_computed,
        }
    }
}

/// Refuses a mesh above [`MOST_VERTICES`].
pub(super) fn too_many(subject: &str, vertices: usize, triangles: usize) -> Result<()> {
    if vertices.max(triangles) <= MOST_VERTICES {
        return Ok(());
    }
    Err(Error::Unsupported {
        subject: subject.to_owned(),
        found: format!("{vertices} vertices and {triangles} triangles"),
        expected: format!("up to {MOST_VERTICES} of each"),
    })
}

fn check(subject: &str, piece: &Piece) -> Result<()> {
    let vertices = piece.positions.len();
    let wrong = |found: String, expected: String| Err(Error::invalid_option(subject, found, expected));
    for (what, count) in
        [("normals", piece.normals.len()), ("texture coordinates", piece.uvs.as_ref().map_or(0, Vec::len))]
    {
        let absent = what == "normals" && count == 0 || what != "normals" && piece.uvs.is_none();
        if count != vertices && !absent {
            return wrong(format!("{count} {what} for {vertices} vertices"), "one a vertex".into());
        }
    }
    // A length beyond this has a square beyond f32.
    let near = |p: &Vec3| p.abs().cmple(Vec3::splat(1e18)).all();
    if let Some(i) = piece.positions.iter().position(|p| !near(p)) {
        return wrong(format!("vertex {i} at {}", piece.positions[i]), "finite numbers up to 1e18".into());
    }
    if let Some(i) = piece.normals.iter().position(|n| !n.is_finite()) {
        return wrong(format!("normal {i} of {}", piece.normals[i]), "finite numbers".into());
    }
    let near = |uv: &Vec2| uv.abs().cmple(Vec2::splat(1e6)).all();
    if let Some((i, uv)) = piece.uvs.iter().flatten().enumerate().find(|(_, uv)| !near(uv)) {
        return wrong(format!("texture coordinates {i} of {uv}"), "finite numbers up to 1e6".into());
    }
    match piece.triangles.iter().flatten().find(|&&i| i as usize >= vertices) {
        Some(i) => wrong(format!("a triangle at vertex {i}"), format!("vertices 0 to {}", vertices as i64 - 1)),
        None => Ok(()),
    }
}
