//! The maps of a sample and how texels become bytes.

use glam::Vec3;
use ndarray::Array3;

use crate::image::{Raster, Samples};
use crate::roughness::PerceptualRoughness;

/// The maps of one material, all of one square size, tileable (repeat on both axes).
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// RGB, 8 bit: unit normal in tangent space, +y up (OpenGL), `-1..1` stored as `0..255`.
    pub normal: Raster,
    /// RGB, 8 bit, glTF's packing: occlusion in R, perceptual roughness in G, metallic in B.
    pub orm: Raster,
}

/// What a material says about one texel.
pub(super) struct Texel {
    pub normal: Vec3,
    /// 1 is open.
    pub occlusion: f32,
    pub roughness: PerceptualRoughness,
    pub metallic: f32,
}

impl Maps {
    /// Asks `texel` for column and row.
    pub(super) fn from_fn(size: usize, mut texel: impl FnMut(usize, usize) -> Texel) -> Self {
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let mut normals = Array3::zeros((size, size, 3));
        let mut orms = Array3::zeros((size, size, 3));
        for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
            let Texel { normal, occlusion, roughness, metallic } = texel(x, y);
            let orm = [occlusion, roughness.0, metallic];
            for c in 0..3 {
                normals[(y, x, c)] = byte(0.5 * normal[c] + 0.5);
                orms[(y, x, c)] = byte(orm[c]);
            }
        }
        Self { normal: Raster::new(Samples::U8(normals)), orm: Raster::new(Samples::U8(orms)) }
    }
}

/// Texture coordinates of a texel's centre: u right, v up, 0 to 1.
pub(super) fn uv(size: usize, x: usize, y: usize) -> [f32; 2] {
    let side = size as f32;
    [(x as f32 + 0.5) / side, 1.0 - (y as f32 + 0.5) / side]
}

/// 0 up to `low`, 1 from `high`, a smooth cubic between.
pub(super) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
