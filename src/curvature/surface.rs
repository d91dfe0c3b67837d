//! A mesh made ready for its texture: triangles sorted by island, each as a patch of texels.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::mesh::Mesh;
use super::weld::{Sets, bits, weld};
use crate::error::{Error, Result};
use crate::image::Size;

/// The longest side of a baked texture.
pub const LONGEST_SIDE: usize = 16384;

/// How often the surface may cover the texture. Tiled coordinates cover it without end, and a texture that
/// tiles has no texel that belongs to one place of the surface.
pub const MOST_COVERS: f64 = 256.0;

/// The triangles to bake.
pub(super) struct Surface<'a> {
    mesh: &'a Mesh,
    uvs: &'a [glam::Vec2],
    /// Triangles that have an area in space and in the texture, with their islands, sorted by island.
    pub order: Vec<(u32, u32)>,
    /// Number of islands.
    pub islands: usize,
    /// Triangles without texture coordinates, without area in the texture, and without area in space.
    pub skipped: [usize; 3],
    /// Share of the surface's area that was skipped.
    pub skipped_area: f64,
    /// Area in texture space, overlaps counted as often as they are there; in textures.
    pub cover: f64,
}

/// A triangle over the texels of a level, in one repeat of the texture: corners in texels from its upper left, y down; it
/// may reach beyond.
pub(super) struct Patch {
    pub corners: [DVec2; 3],
    /// Unit normals at the corners.
    pub normals: [DVec3; 3],
    /// The triangle's own normal, unit, on the side of the corners' normals.
    pub face: DVec3,
    /// Surface area of a texel.
    pub density: f64,
    /// Unit direction in which u grows.
    pub tangent: DVec3,
    /// +1, or -1 where the texture is mirrored.
    pub side: f64,
    /// Texels in a row of the level.
    pub columns: usize,
}

/// One repeat of the texture: coordinates from (x, y) to (x + 1, y + 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Tile {
    pub x: i32,
    pub y: i32,
}

impl<'a> Surface<'a> {
    /// Sorts the triangles of a mesh.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a mesh without texture coordinates, or one that covers the texture more than
    /// [`MOST_COVERS`] times, and above [`LONGEST_SIDE`].
    pub fn new(mesh: &'a Mesh, size: Size) -> Result<Self> {
        let unsupported =
            |found: String, expected: String| Error::Unsupported { subject: "bake".to_owned(), found, expected };
        if size.width.max(size.height) > LONGEST_SIDE {
            return Err(unsupported(format!("a texture of {size}"), format!("sides up to {LONGEST_SIDE}")));
        }
        let Some(uvs) = mesh.uvs.as_deref() else {
            return Err(unsupported("a mesh without texture coordinates".into(), "unwrapped meshes".into()));
        };
        let keys = mesh.positions.iter().zip(uvs).map(|(p, t)| [p.x, p.y, p.z, t.x, t.y].map(bits));
        let (points, count) = weld(keys);
        let mut surface =
            Self { mesh, uvs, order: Vec::new(), islands: 0, skipped: [0; 3], skipped_area: 0.0, cover: 0.0 };
        // Each point twice, for triangles that show the texture as it is and for mirrored ones: halves that lie on each
        // other in the texture and meet on the surface are two islands.
        let (mut sets, mut kept, mut area, mut work) = (Sets::new(2 * count), Vec::new(), 0.0, 0.0);
        let mut tiles = 0.0;
        for part in &mesh.parts {
            for t in part.triangles.clone() {
                let here = surface.space_area(t).length();
                area += here;
                let kind = if !part.has_uvs {
                    Some(0)
                } else if surface.texture_area(t) == 0.0 {
                    Some(1)
                } else if here == 0.0 {
                    Some(2)
                } else {
                    None
                };
                if let Some(kind) = kind {
                    surface.skipped[kind] += 1;
                    surface.skipped_area += here;
                    continue;
                }
                let mirrored = u32::from(surface.side(t) < 0.0);
                let [a, b, c] = mesh.triangles[t].map(|i| 2 * points[i as usize] + mirrored);
                sets.join(a, b);
                sets.join(b, c);
                kept.push((t as u32, a));
                let cover = surface.texture_area(t).abs();
                surface.cover += cover;
                let (low, high) = surface.bounds(t);
                let sides = (high - low) * DVec2::new(size.width as f64, size.height as f64);
                work += cover * size.texels() as f64 + sides.x + sides.y;
                let reach = high.ceil() - low.floor();
                tiles += reach.x * reach.y;
            }
        }
        // Long slivers have no area, but are walked from end to end.
        let texels = (size.texels() + kept.len()) as f64;
        if surface.cover > MOST_COVERS
            || work > 2.0 * MOST_COVERS * texels
            || tiles > 4.0 * (MOST_COVERS + kept.len() as f64)
        {
            let times = surface.cover.ceil();
            let found = format!("texture coordinates that cover the texture {times} times, over {tiles} repeats");
            return Err(unsupported(found, format!("unwrapped meshes, or up to {MOST_COVERS} layers")));
        }
        surface.skipped_area /= if area > 0.0 { area } else { 1.0 };
        surface.order = kept.into_iter().map(|(t, point)| (sets.root(point), t)).collect();
        surface.order.sort_unstable();
        surface.islands = surface.order.chunk_by(|a, b| a.0 == b.0).count();
        Ok(surface)
    }

    fn uv(&self, t: usize) -> [DVec2; 3] {
        self.mesh.triangles[t].map(|i| self.uvs[i as usize].as_dvec2())
    }

    /// Half the cross product of two edges: the area, along the normal.
    fn space_area(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.mesh.triangles[t].map(|i| self.mesh.positions[i as usize].as_dvec3());
        0.5 * (b - a).cross(c - a)
    }

    /// +1 if the winding is counter-clockwise seen from the side of the normals, or -1.
    fn out(&self, t: usize) -> f64 {
        let normals = self.mesh.triangles[t].map(|i| self.mesh.normals[i as usize].as_dvec3());
        if self.space_area(t).dot(normals.iter().sum()) < 0.0 { -1.0 } else { 1.0 }
    }

    /// +1, or -1 where the texture is mirrored.
    fn side(&self, t: usize) -> f64 {
        self.out(t) * self.texture_area(t).signum()
    }

    /// Area in textures, negative if the corners run clockwise there.
    fn texture_area(&self, t: usize) -> f64 {
        let [a, b, c] = self.uv(t);
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Lowest and highest texture coordinates.
    fn bounds(&self, t: usize) -> (DVec2, DVec2) {
        let [a, b, c] = self.uv(t);
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// The repeats of the texture that a triangle may reach.
    pub fn tiles(&self, t: u32) -> impl Iterator<Item = Tile> + use<> {
        let (low, high) = self.bounds(t as usize);
        let (low, high) = (low.floor(), high.ceil());
        (low.x as i32..high.x as i32).flat_map(move |x| (low.y as i32..high.y as i32).map(move |y| Tile { x, y }))
    }

    /// The rows of a level's texels that a triangle reaches in a repeat of the texture.
    pub fn rows(&self, t: u32, tile: Tile, size: Size) -> Range<usize> {
        let [a, b, c] = self.corners(t as usize, tile, size).map(|c| c.y);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Conversion stops at 0.
        (low.floor() as usize)..(high.ceil() as usize).min(size.height)
    }

    fn corners(&self, t: usize, tile: Tile, size: Size) -> [DVec2; 3] {
        let (left, top) = (f64::from(tile.x), f64::from(tile.y) + 1.0);
        self.uv(t).map(|uv| DVec2::new((uv.x - left) * size.width as f64, (top - uv.y) * size.height as f64))
    }

    /// A kept triangle over the texels of a level.
    pub fn patch(&self, t: u32, tile: Tile, size: Size) -> Patch {
        let t = t as usize;
        let vertices = self.mesh.triangles[t];
        let normals = vertices.map(|i| self.mesh.normals[i as usize].as_dvec3());
        let [p, q, r] = vertices.map(|i| self.mesh.positions[i as usize].as_dvec3());
        let [a, b, c] = self.uv(t);
        let (e, f, area) = (b - a, c - a, self.texture_area(t));
        let space = self.space_area(t);
        // dP/du: the edges are P_u du + P_v dv.
        let along_u = ((q - p) * f.y - (r - p) * e.y) * area.signum();
        Patch {
            corners: self.corners(t, tile, size),
            normals,
            face: self.out(t) * space.normalize_or_zero(),
            density: space.length() / (area.abs() * size.texels() as f64),
            columns: size.width,
            tangent: along_u.normalize_or_zero(),
            side: self.side(t),
        }
    }
}
