//! Meshes of Wavefront OBJ files. Material libraries are not opened: parts go by the names that `usemtl` gives. Objects,
//! groups and smoothing groups are ignored, as are lines, points and curves.

use std::collections::HashMap;
use std::path::Path;
use std::str::FromStr;

use glam::{Vec2, Vec3};

use super::mesh::{Piece, Pieces};
use crate::error::{Error, Result};

/// The corner of a face: position, texture coordinates and normal by number.
type Corner = (usize, Option<usize>, Option<usize>);

/// The faces of one material, with or without texture coordinates.
#[derive(Default)]
struct Faces {
    piece: Piece,
    vertices: HashMap<Corner, u32>,
}

/// What the lines so far have listed.
#[derive(Default)]
struct Lists {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
}

/// The pieces of a file, one for each material, with and without texture coordinates. Polygons are cut into fans, which
/// is right for convex ones.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Pieces> {
    let mut lists = Lists::default();
    let mut faces: Vec<Faces> = Vec::new();
    // Names are looked up where they are given and faces go by number: there are far more faces than names.
    let mut numbers_of: HashMap<String, usize> = HashMap::new();
    let mut materials: Vec<String> = Vec::new();
    let mut material = None;
    // Where the faces of a material are, without and with texture coordinates, once it has some.
    let mut places: HashMap<(Option<usize>, bool), usize> = HashMap::new();
    let mut corners: Vec<Corner> = Vec::new();
    for (i, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_ascii_whitespace();
        let wrong = |expected: &str| {
            let shown: String = text.trim().chars().take(60).collect();
            Error::invalid(path, format!("{shown:?} in line {}", i + 1), expected)
        };
        match words.next() {
            Some("v") => {
                lists.positions.push(numbers(words, 3).map(Vec3::from).ok_or_else(|| wrong("three coordinates"))?);
            }
            Some("vn") => {
                lists.normals.push(numbers(words, 3).map(Vec3::from).ok_or_else(|| wrong("three coordinates"))?);
            }
            Some("vt") => lists.uvs.push(numbers(words, 1).map(Vec2::from).ok_or_else(|| wrong("coordinates"))?),
            Some("usemtl") => {
                let name = text.trim().split_once([' ', '\t']).map(|(_, name)| name.trim().to_owned());
                material = name.map(|name| {
                    *numbers_of.entry(name).or_insert_with_key(|name| {
                        materials.push(name.clone());
                        materials.len() - 1
                    })
                });
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    corners.push(corner(word, &lists).ok_or_else(|| wrong("corners at vertices listed before"))?);
                }
                if corners.len() < 3 {
                    return Err(wrong("three corners or more"));
                }
                let has_uvs = corners.iter().all(|corner| corner.1.is_some());
                let place = *places.entry((material, has_uvs)).or_insert_with(|| {
                    let uvs = has_uvs.then(Vec::new);
                    let piece = Piece { material, uvs, ..Piece::default() };
                    faces.push(Faces { piece, ..Faces::default() });
                    faces.len() - 1
                });
                faces[place].add(&corners, &lists);
            }
            _ => {}
        }
    }
    Ok(Pieces { pieces: faces.into_iter().map(|faces| faces.piece).collect(), materials })
}

/// N numbers, of which `least` must be there and the others are 0; what follows is ignored.
fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>, least: usize) -> Option<[f32; N]> {
    let mut out = [0.0; N];
    for (i, out) in out.iter_mut().enumerate() {
        match words.next() {
            Some(word) => *out = f32::from_str(word).ok()?,
            None if i >= least => break,
            None => return None,
        }
    }
    Some(out)
}

/// `position`, `position/uv`, `position//normal` or `position/uv/normal`, counted from 1, or backwards from -1.
fn corner(word: &str, lists: &Lists) -> Option<Corner> {
    let mut parts = word.split('/');
    let mut index = |count: usize| -> Option<Option<usize>> {
        let Some(part) = parts.next().filter(|part| !part.is_empty()) else { return Some(None) };
        let index = i64::from_str(part).ok()?;
        let place = if index < 0 { (count as i64).checked_add(index)? } else { index - 1 };
        usize::try_from(place).ok().filter(|&place| place < count).map(Some)
    };
    let (position, uv, normal) = (index(lists.positions.len())??, index(lists.uvs.len())?, index(lists.normals.len())?);
    Some((position, uv, normal))
}

impl Faces {
    fn add(&mut self, corners: &[Corner], lists: &Lists) {
        let Piece { positions, normals, uvs, triangles, .. } = &mut self.piece;
        let mut vertex = |corner: &Corner| {
            *self.vertices.entry(*corner).or_insert_with(|| {
                positions.push(lists.positions[corner.0]);
                normals.push(corner.2.map_or(Vec3::ZERO, |i| lists.normals[i]));
                if let (Some(uvs), Some(i)) = (uvs.as_mut(), corner.1) {
                    uvs.push(lists.uvs[i]);
                }
                (positions.len() - 1) as u32
            })
        };
        let first = vertex(&corners[0]);
        let mut last = vertex(&corners[1]);
        for corner in &corners[2..] {
            let next = vertex(corner);
            triangles.push([first, last, next]);
            last = next;
        }
    }
}
