//! KTX 2 (Khronos KTX File Format Specification 2.0.4): written for the formats of this crate, read for more.
//!
//! The `ktx2` crate knows the header, the index and the data format descriptors; its reader is not used, for it panics on
//! some damaged files. The bounds of everything are checked here first.

use std::io::{self, Write};

use ::ktx2::{ColorModel, Format, Header, Index, KeyValueDataIterator, LevelIndex, SupercompressionScheme};
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use rayon::prelude::*;

use super::layout::{Kind, Layout};
use super::{Effort, TexelFormat, Texture};
use crate::codec::Source;
use crate::error::Result;
use crate::image::{Raster, Size};

mod descriptor;
mod zstd;

const WRITER: &str = concat!("mipfold ", env!("CARGO_PKG_VERSION"));

/// A byte of Zstandard data stands for fewer than this many: a block of a repeated byte has 4 bytes for up to 128 KiB.
const ZSTD_BOUND: u64 = 1 << 15;

/// As for PNG.
const ZLIB_BOUND: u64 = 1032;

/// Writes a KTX 2 file: one 2D picture with its levels, linear, primaries unspecified, rows from the top (`KTXorientation`
/// `rd`). With `zstd`, each level is compressed by itself with Zstandard, at level 6 or, slow, at level 18.
///
/// UASTC is as `KHR_texture_basisu` of glTF has it, which asks for sides of level 0 that are multiples of 4, too; it is
/// said to have no alpha if no block has.
///
/// # Errors
/// Whatever `out` returns; [`io::ErrorKind::InvalidInput`] if the levels are not those of the size and the format;
/// [`io::ErrorKind::Unsupported`] for sides beyond 2^32; [`io::ErrorKind::Other`] if compressed bytes do not unpack to what
/// they were made of.
pub fn write_ktx2(mut out: impl Write, texture: &Texture, zstd: Option<Effort>) -> io::Result<()> {
    texture.check()?;
    let pack = |effort| {
        let levels = texture.levels.par_iter().enumerate();
        let wrong = |k, why| io::Error::other(format!("Zstandard data of level {k}: {why}"));
        levels.map(|(k, level)| zstd::pack(level, effort).map_err(|why| wrong(k, why))).collect::<io::Result<Vec<_>>>()
    };
    let packed = zstd.map(pack).transpose()?;
    let levels = packed.as_ref().unwrap_or(&texture.levels);

    let descriptor = descriptor::write(texture);
    let values = [entry("KTXorientation", "rd"), entry("KTXwriter", WRITER)].concat();
    let descriptor_at = Header::LENGTH + levels.len() * LevelIndex::LENGTH;
    let values_at = descriptor_at + descriptor.len();
    let too_large = |_| io::Error::new(io::ErrorKind::Unsupported, format!("KTX cannot hold {} texels", texture.size));
    let header = Header {
        format: texture.format.vk_format().and_then(Format::new),
        type_size: type_size(texture.format),
        pixel_width: texture.size.width.try_into().map_err(too_large)?,
        pixel_height: texture.size.height.try_into().map_err(too_large)?,
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: levels.len() as u32,
        supercompression_scheme: zstd.map(|_| SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: descriptor_at as u32,
            dfd_byte_length: descriptor.len() as u32,
            kvd_byte_offset: values_at as u32,
            kvd_byte_length: values.len() as u32,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };

    // The smallest level comes first, so that a file that is still arriving can be shown.
    let alignment = if zstd.is_some() { 1 } else { alignment(texture.format) };
    let mut end = values_at + values.len();
    let mut index: Vec<LevelIndex> = Vec::with_capacity(levels.len());
    for (level, full) in levels.iter().zip(&texture.levels).rev() {
        let start = end.next_multiple_of(alignment);
        end = start + level.len();
        let [byte_offset, byte_length, uncompressed_byte_length] = [start, level.len(), full.len()].map(|n| n as u64);
        index.push(LevelIndex { byte_offset, byte_length, uncompressed_byte_length });
    }

    out.write_all(&header.as_bytes())?;
    for level in index.iter().rev() {
        out.write_all(&level.as_bytes())?;
    }
    out.write_all(&descriptor)?;
    out.write_all(&values)?;
    let mut at = (values_at + values.len()) as u64;
    for (place, level) in index.iter().zip(levels.iter().rev()) {
        out.write_all(&vec![0; (place.byte_offset - at) as usize])?;
        out.write_all(level)?;
        at = place.byte_offset + place.byte_length;
    }
    out.flush()
}

/// The least common multiple of 4 and the bytes of a block; all of these are powers of two.
fn alignment(format: TexelFormat) -> usize {
    format.block_bytes().max(4)
}

/// Bytes of what a machine with the other byte order would have to turn round.
fn type_size(format: TexelFormat) -> u32 {
    if format.block_side() > 1 { 1 } else { (format.block_bytes() / format.channels()) as u32 }
}

/// A key and a text, with their length, filled up to a multiple of 4.
fn entry(key: &str, value: &str) -> Vec<u8> {
    let length = key.len() + value.len() + 2;
    let mut bytes = [&(length as u32).to_le_bytes(), key.as_bytes(), &[0], value.as_bytes(), &[0]].concat();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

const SUPPORTED: &str = "one 2D picture of 8 or 16 bit, half or float, BC1, BC3, BC4, BC5, BC7 or UASTC, plain or with \
     Zstandard or zlib";

/// How texels of a `VkFormat` lie, and whether they are sRGB.
fn layout(number: u32) -> Option<(Layout, bool)> {
    let plain = |kind, channels| (Layout::plain(kind, channels), false);
    let srgb = |layout| (layout, true);
    if let Some(format) = TexelFormat::all().find(|format| format.vk_format() == Some(number)) {
        return Some((format.layout(), false));
    }
    // The same numbers as Vulkan's enumeration; UINT of 8 bit stands for linear data where UNORM is refused (Godot).
    Some(match number {
        10 => plain(Kind::Snorm8, 1),
        13 => plain(Kind::Unorm8, 1),
        15 => srgb(Layout::plain(Kind::Unorm8, 1)),
        17 => plain(Kind::Snorm8, 2),
        20 => plain(Kind::Unorm8, 2),
        22 => srgb(Layout::plain(Kind::Unorm8, 2)),
        23 | 27 => plain(Kind::Unorm8, 3),
        29 => srgb(Layout::plain(Kind::Unorm8, 3)),
        30 => (Layout::bgr(3, 3), false),
        36 => srgb(Layout::bgr(3, 3)),
        38 => plain(Kind::Snorm8, 4),
        41 => plain(Kind::Unorm8, 4),
        43 => srgb(Layout::plain(Kind::Unorm8, 4)),
        44 => (Layout::bgr(4, 4), false),
        50 => srgb(Layout::bgr(4, 4)),
        71 => plain(Kind::Snorm16, 1),
        78 => plain(Kind::Snorm16, 2),
        84 => plain(Kind::Unorm16, 3),
        90 => plain(Kind::Half, 3),
        92 => plain(Kind::Snorm16, 4),
        100 => plain(Kind::Float, 1),
        103 => plain(Kind::Float, 2),
        106 => plain(Kind::Float, 3),
        109 => plain(Kind::Float, 4),
        131 => (Layout::ordered(Kind::Bc1, 4, &[0, 1, 2]), false),
        132 => srgb(Layout::ordered(Kind::Bc1, 4, &[0, 1, 2])),
        133 => plain(Kind::Bc1, 4),
        134 => srgb(Layout::plain(Kind::Bc1, 4)),
        137 => plain(Kind::Bc3, 4),
        138 => srgb(Layout::plain(Kind::Bc3, 4)),
        140 => plain(Kind::Bc4Signed, 1),
        142 => plain(Kind::Bc5Signed, 2),
        146 => srgb(Layout::plain(Kind::Bc7, 4)),
        _ => return None,
    })
}

/// How the levels of a file are packed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Packing {
    Plain,
    Zstd,
    Zlib,
}

/// The largest `count` levels.
pub(in crate::codec) fn decode(source: &Source, count: usize) -> Result<(Vec<Raster>, Vec<String>)> {
    let Some(header) = source.bytes.first_chunk::<{ Header::LENGTH }>() else {
        return Err(source.broken("it ends within its header"));
    };
    let header = Header::from_bytes(header).map_err(|error| source.broken(error))?;
    let size = size(source, &header)?;
    let packing = match header.supercompression_scheme {
        None => Packing::Plain,
        Some(SupercompressionScheme::Zstandard) => Packing::Zstd,
        Some(SupercompressionScheme::ZLIB) => Packing::Zlib,
        Some(SupercompressionScheme::BasisLZ) => return Err(source.unsupported(ETC1S, SUPPORTED)),
        Some(other) => return Err(source.unsupported(format!("supercompression {other:?}"), SUPPORTED)),
    };
    let (layout, srgb) = match header.format {
        Some(format) => layout(format.value()).ok_or_else(|| {
            source.unsupported(format!("texels of VkFormat {}, {format:?}", format.value()), SUPPORTED)
        })?,
        None => (described_layout(source, &header)?, false),
    };
    let levels = levels(source, &header, size, layout, packing)?;
    let unpacked = if packing == Packing::Plain { 0 } else { layout.bytes(size).div_ceil(size.texels()) };
    source.memory(size, layout.sample_bytes() * if count > 1 { 2 } else { 1 } + unpacked)?;

    let mut rasters = Vec::new();
    for (k, data) in levels.into_iter().take(count).enumerate() {
        let size = size.level(k);
        let unpacked = match packing {
            Packing::Plain => None,
            Packing::Zstd => {
                let unpacked = zstd::unpack(data, layout.bytes(size));
                Some(unpacked.map_err(|why| source.broken(format!("Zstandard data of level {k}: {why}")))?)
            }
            Packing::Zlib => Some(unpack_zlib(source, k, data, layout.bytes(size))?),
        };
        let data = unpacked.as_deref().unwrap_or(data);
        if let Some(block) = layout.no_block(data) {
            return Err(source.broken(format!("block {block} of level {k} is none of UASTC")));
        }
        rasters.push(layout.decode(data, size));
    }
    Ok((rasters, notes(source, &header, srgb)))
}

const ETC1S: &str = "texels of Basis Universal's ETC1S";

/// How texels without a `VkFormat` lie: by the colour model of the descriptor.
fn described_layout(source: &Source, header: &Header) -> Result<Layout> {
    match descriptor::model(section(source, header.index.dfd_byte_offset, header.index.dfd_byte_length)) {
        Some(ColorModel::UASTC) => Ok(Layout::plain(Kind::Uastc, 4)),
        Some(ColorModel::ETC1S) => Err(source.unsupported(ETC1S, SUPPORTED)),
        Some(other) => Err(source.unsupported(format!("texels of no VkFormat and colour model {other:?}"), SUPPORTED)),
        None => Err(source.unsupported("texels of no VkFormat and no colour model", SUPPORTED)),
    }
}

/// As much of a section as there is.
fn section<'a>(source: &Source<'a>, from: u32, length: u32) -> &'a [u8] {
    source.bytes.get(from as usize..).map_or(&[][..], |rest| &rest[..rest.len().min(length as usize)])
}

/// The size of level 0, of a file that is one 2D picture.
fn size(source: &Source, header: &Header) -> Result<Size> {
    let found = match header {
        Header { pixel_depth: 1.., .. } => "a 3D texture".to_owned(),
        Header { face_count: 2.., .. } => format!("{} faces (a cube map)", header.face_count),
        Header { layer_count: 2.., .. } => format!("{} layers", header.layer_count),
        Header { pixel_height: 0, .. } => "a 1D texture".to_owned(),
        _ => return source.size(header.pixel_width.into(), header.pixel_height.into()),
    };
    Err(source.unsupported(found, SUPPORTED))
}

/// The packed levels, largest first, each where the index says and as long as its size demands.
fn levels<'a>(
    source: &Source<'a>,
    header: &Header,
    size: Size,
    layout: Layout,
    packing: Packing,
) -> Result<Vec<&'a [u8]>> {
    // A file may leave all levels but the first to be made by whoever reads it.
    let count = header.level_count.max(1) as usize;
    if count > size.level_count() {
        return Err(source.broken(format!("{count} levels, where {size} texels have {}", size.level_count())));
    }
    let mut levels = Vec::with_capacity(count);
    let index = source.bytes[Header::LENGTH..].as_chunks::<{ LevelIndex::LENGTH }>().0;
    let index = index.get(..count).ok_or_else(|| source.broken("it ends within its index of levels"))?;
    let start = (Header::LENGTH + count * LevelIndex::LENGTH) as u64;
    for (k, entry) in index.iter().map(LevelIndex::from_bytes).enumerate() {
        let LevelIndex { byte_offset: from, byte_length: length, uncompressed_byte_length: unpacked } = entry;
        let needed = layout.bytes(size.level(k)) as u64;
        let wrong = unpacked != needed || (packing == Packing::Plain && length != needed);
        if wrong {
            let claimed = if unpacked == needed { length } else { unpacked };
            let size = size.level(k);
            return Err(source.broken(format!("level {k} of {size} texels has {claimed} bytes, not {needed}")));
        }
        let data = from
            .checked_add(length)
            .filter(|_| from >= start)
            .and_then(|to| source.bytes.get(usize::try_from(from).ok()?..usize::try_from(to).ok()?));
        let data = data.ok_or_else(|| {
            source.broken(format!(
                "level {k}, {length} bytes from byte {from}, is not within its {} bytes",
                source.bytes.len()
            ))
        })?;
        let bound = match packing {
            Packing::Plain => 1,
            Packing::Zstd => ZSTD_BOUND,
            Packing::Zlib => ZLIB_BOUND,
        };
        if needed > length.saturating_mul(bound) {
            return Err(source.broken(format!("level {k} has {length} bytes, too few for {needed} of texels")));
        }
        levels.push(data);
    }
    Ok(levels)
}

fn unpack_zlib(source: &Source, level: usize, data: &[u8], length: usize) -> Result<Vec<u8>> {
    let fail = |why: &dyn std::fmt::Display| source.broken(format!("zlib data of level {level}: {why}"));
    let unpacked = decompress_to_vec_zlib_with_limit(data, length).map_err(|error| fail(&error))?;
    if unpacked.len() == length { Ok(unpacked) } else { Err(fail(&format!("it does not unpack to {length} bytes"))) }
}

/// What the file says about itself and is not obeyed; each once, as a key has one value.
fn notes(source: &Source, header: &Header, srgb: bool) -> Vec<String> {
    let Index { dfd_byte_offset, dfd_byte_length, kvd_byte_offset, kvd_byte_length, .. } = header.index;
    let descriptor = section(source, dfd_byte_offset, dfd_byte_length);
    let mut notes = Vec::new();
    if srgb || descriptor::is_srgb(descriptor) {
        notes.push("KTX 2 says its data is sRGB: ignored, data is taken as linear".to_owned());
    }
    if header.format.is_none() && descriptor::has_second_in_alpha(descriptor) {
        notes.push("KTX 2 has its second channel in alpha: left there".to_owned());
    }
    let mut seen = Vec::new();
    for (key, value) in KeyValueDataIterator::new(section(source, kvd_byte_offset, kvd_byte_length)) {
        if seen.contains(&key) {
            continue;
        }
        // (Longer ones than `rdo` and `rgba` are wrong.)
        let text = String::from_utf8_lossy(&value[..value.len().min(16)]);
        let text = text.trim_end_matches('\0');
        match key {
            "KTXorientation" | "KTXswizzle" => seen.push(key),
            _ => continue,
        }
        match key {
            "KTXorientation" if text != "rd" => {
                notes.push(format!("KTX 2 asks to be turned or mirrored (orientation {text:?}): ignored"));
            }
            "KTXswizzle" if text != "rgba" => {
                notes.push(format!("KTX 2 asks for its channels in another order ({text:?}): ignored"));
            }
            _ => {}
        }
    }
    notes
}
