//! Maps as textures for GPUs: which texel format, and their levels in it.

use glam::Vec3;
use ndarray::Array3;
use rayon::prelude::*;

use super::layer::{Layer, Rows};
use super::preset::Compress;
use crate::codec::texture::{Effort, TexelFormat, Texture, decode, encode};
use crate::image::{Raster, Samples, Size, each_texel, from_rows};
use crate::material::Encoding;

/// Rows that are encoded at a time, of whole blocks: what is in memory beside the bytes.
const BAND: usize = 32;

/// The texel format of a map. Those of further lobes are never compressed. Normals have two channels where
/// `two_channel_normals`, and shaders rebuild z.
pub fn texel_format(rows: &Rows, compress: Compress, two_channel_normals: bool) -> TexelFormat {
    // Blocks would not keep the sum of the lobes' weights.
    let plain = matches!(rows.layer, Layer::Further(_));
    let compress = if plain { Compress::None } else { compress };
    let channels = stored_channels(rows, compress, two_channel_normals);
    match (compress, channels, rows.bits()) {
        (Compress::Uastc, ..) => TexelFormat::Uastc,
        (Compress::Bc, 1, _) => TexelFormat::Bc4,
        (Compress::Bc, 2, _) => TexelFormat::Bc5,
        (Compress::Bc, ..) => TexelFormat::Bc7,
        (Compress::None, 1, 8) => TexelFormat::R8,
        (Compress::None, 2, 8) => TexelFormat::Rg8,
        (Compress::None, _, 8) => TexelFormat::Rgba8,
        (Compress::None, 1, _) => TexelFormat::R16,
        (Compress::None, 2, _) => TexelFormat::Rg16,
        (Compress::None, ..) => TexelFormat::Rgba16,
    }
}

/// Channels of a map that its texture keeps: z of a normal alone is left out where block compression has a format for two.
pub fn stored_channels(rows: &Rows, compress: Compress, two_channel_normals: bool) -> usize {
    let channels = rows.texture_channels();
    let normal = channels.len() == 3 && rows.normal_xy() == Some((0, 1)) && channels[2].1 == "normal.z";
    if normal && two_channel_normals && compress == Compress::Bc { 2 } else { channels.len() }
}

/// What is done to the channels of a texel.
pub type ChangeTexel<'a> = &'a (dyn Fn(&mut [f32]) + Sync);

/// All levels of a map, each texel changed before if it is to be. Block formats, and what is changed, are encoded from
/// floats, not from what an 8-bit picture would hold; in two-channel ones no decoded normal reaches the unit circle, so that
/// shaders find a z.
pub fn texture_of(rows: &Rows, format: TexelFormat, effort: Effort, change: Option<ChangeTexel>) -> Texture {
    let channels = rows.texture_channels();
    let level = |k: usize| match (format.block_side(), change) {
        // As in the PNGs, weights of lobes and all.
        (1, None) => encode(&rows.raster(k), format, effort),
        _ => bands(rows, k, &channels, format, effort, change),
    };
    Texture { size: rows.size(0), format, levels: (0..rows.levels()).map(level).collect() }
}

/// A level, by names and roles of the map's channels.
fn bands(
    rows: &Rows,
    level: usize,
    all: &[(String, String)],
    format: TexelFormat,
    effort: Effort,
    change: Option<ChangeTexel>,
) -> Vec<u8> {
    let size = rows.size(level);
    let normal = format == TexelFormat::Bc5 && rows.normal_xy() == Some((0, 1));
    let with_z = normal && all.get(2).is_some_and(|(_, role)| role == "normal.z");
    let channels = if with_z { 3 } else { all.len().min(format.channels()) };
    let band = |first: usize| {
        let band = Size::new(size.width, BAND.min(size.height - first));
        let mut values = from_rows(band, channels, |channel, y, row| {
            rows.row(level, channel, Encoding::Unsigned, first + y, 0, row);
        });
        if let Some(change) = change {
            each_texel(&mut values, change);
        }
        if with_z {
            unit(&mut values);
        }
        let raster = Raster::new(Samples::F32(values));
        let mut bytes = encode(&raster, format, effort);
        if normal {
            pull_in(&raster, &mut bytes, effort);
        }
        bytes
    };
    let bands: Vec<usize> = (0..size.height).step_by(BAND).collect();
    bands.into_par_iter().map(band).collect::<Vec<_>>().concat()
}

/// Gives normals unit length, for their z will be made from x and y. Those that do not point up stay as they are.
fn unit(values: &mut Array3<f32>) {
    each_texel(values, |texel| {
        let n = Vec3::from_slice(texel) * 2.0 - 1.0;
        if let (true, Some(n)) = (n.z > 0.0, n.try_normalize()) {
            let stored = n * 0.5 + 0.5;
            (texel[0], texel[1]) = (stored.x, stored.y);
        }
    });
}

/// The longest xy of a decoded normal: hardware may decode a few 16-bit steps apart from us.
const LONGEST: f32 = 0.999;

/// Encodes the blocks again of which a normal decodes to more than [`LONGEST`], with such normals shorter by a fortieth each
/// time, until none does: the middle of the disk at the latest.
fn pull_in(raster: &Raster, bytes: &mut [u8], effort: Effort) {
    let (format, Size { width, height }) = (TexelFormat::Bc5, raster.size());
    let (side, block_bytes) = (format.block_side(), format.block_bytes());
    let decoded = decode(bytes, raster.size(), format);
    for (place, block) in bytes.chunks_exact_mut(block_bytes).enumerate() {
        let (x, y) = (place % width.div_ceil(side) * side, place / width.div_ceil(side) * side);
        let size = Size::new(side.min(width - x), side.min(height - y));
        let texels = || (0..size.height).flat_map(|j| (0..size.width).map(move |i| (i, j)));
        if !texels().any(|(i, j)| too_long(&decoded, x + i, y + j)) {
            continue;
        }
        let mut part = Array3::from_shape_fn((size.height, size.width, 2), |(j, i, c)| raster.at(x + i, y + j, c));
        loop {
            let decoded = decode(block, size, format);
            let mut ended = true;
            for (i, j) in texels().filter(|(i, j)| too_long(&decoded, *i, *j)) {
                ended = false;
                for v in [0, 1].map(|c| (j, i, c)) {
                    // (What is not a number would stay so for ever.)
                    let inside = if part[v].is_nan() { 0.5 } else { part[v].clamp(0.0, 1.0) };
                    part[v] = 0.5 + 0.975 * (inside - 0.5);
                }
            }
            if ended {
                break;
            }
            block.copy_from_slice(&encode(&Raster::new(Samples::F32(part.clone())), format, effort));
        }
    }
}

fn too_long(decoded: &Raster, x: usize, y: usize) -> bool {
    let [nx, ny] = [0, 1].map(|c| 2.0 * decoded.at(x, y, c) - 1.0);
    nx * nx + ny * ny > LONGEST * LONGEST
}
