//! Textures into containers and back, what blocks cost, headers by hand, and files that lie.

use std::path::Path;

use ndarray::Array3;

use super::*;
use crate::codec::{Decoded, decode as read_bytes, decode_levels};
use crate::error::Result;
use crate::image::Samples;

mod accuracy;
mod headers;
mod hostile;
mod round_trips;

/// One texel, less than a block each way, whole blocks, and blocks that end on half a block on some levels.
const SIZES: [(usize, usize); 4] = [(1, 1), (5, 3), (64, 16), (100, 36)];

fn value(x: usize, y: usize, c: usize) -> f64 {
    let (x, y, c) = (x as f64, y as f64, c as f64);
    0.5 + 0.3 * (0.21 * x + 0.13 * y + 1.7 * c).sin() + 0.19 * (0.11 * x - 0.34 * y * (1.0 + 0.2 * c)).cos()
}

/// A picture of as many bits as the format has.
fn picture(size: Size, format: TexelFormat) -> Raster {
    let shape = (size.height, size.width, format.channels());
    let names: &[&str] = if format.channels() == 1 { &["Y"] } else { &["R", "G", "B", "A"][..format.channels()] };
    let samples = match format.facts().kind {
        Kind::Unorm8 | Kind::Bc7 | Kind::Uastc => {
            Samples::U8(Array3::from_shape_fn(shape, |(y, x, c)| (255.0 * value(x, y, c)).round() as u8))
        }
        Kind::Half => {
            Samples::F32(Array3::from_shape_fn(shape, |(y, x, c)| f16::from_f64(20.0 * value(x, y, c) - 10.0).to_f32()))
        }
        _ => Samples::U16(Array3::from_shape_fn(shape, |(y, x, c)| (65535.0 * value(x, y, c)).round() as u16)),
    };
    Raster { samples, channels: names.iter().map(|name| (*name).to_owned()).collect() }
}

/// A full chain, its levels all different.
fn texture(size: Size, format: TexelFormat) -> Texture {
    let levels: Vec<Raster> = (0..size.level_count()).map(|k| picture(size.level(k), format)).collect();
    Texture::encode(&levels, format, Effort::Fast)
}

/// How levels of a KTX 2 file may be packed.
const PACKINGS: [Option<Effort>; 3] = [None, Some(Effort::Fast), Some(Effort::Slow)];

fn ktx2_of(texture: &Texture, zstd: Option<Effort>) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_ktx2(&mut bytes, texture, zstd).unwrap();
    bytes
}

/// Not UASTC, and blocks only if they fill level 0.
fn fits_dds(texture: &Texture) -> bool {
    let Texture { size, format, .. } = texture;
    let side = format.block_side();
    format.dxgi_format().is_some() && size.width.is_multiple_of(side) && size.height.is_multiple_of(side)
}

fn dds_of(texture: &Texture) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_dds(&mut bytes, texture).unwrap();
    bytes
}

fn read_all(bytes: Vec<u8>) -> Result<Vec<Decoded>> {
    decode_levels(Path::new("a.texture"), bytes, usize::MAX)
}

fn message(bytes: Vec<u8>) -> String {
    let result = read_all(bytes).map(|levels| format!("{} levels", levels.len()));
    let message = result.unwrap_err().to_string();
    assert!(message.starts_with("a.texture: "), "{message}");
    message
}

fn put(bytes: &mut [u8], at: usize, value: u32) {
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
}
