//! OpenEXR, by the `exr` crate's block interface: tiles are made, compressed and written as they come, so that memory
//! holds a few of them and never the picture. Nothing here is generic over samples or channels, whose instantiations
//! are what makes that crate slow to compile.

use std::collections::HashSet;
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::Path;

use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedTileBlock, TileCoordinates};
use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::attribute::{ChannelDescription, LevelMode, LineOrder, SampleType, Text, TileDescription};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData, mip_map_levels};
use half::f16;
use half::slice::HalfFloatSliceExt;
use miniz_oxide::deflate::compress_to_vec_zlib;
use ndarray::Array3;
use rayon::prelude::*;

use super::{Format, Source};
use crate::error::{Error, Result};
use crate::image::{Raster, Samples, Size, Wrap};

/// Sides of a tile, in texels.
const TILE: usize = 64;

/// Half the time of PIZ or less, and smaller, for lobes in tiles this small: each PIZ tile carries a code book.
const COMPRESSION: Compression = Compression::ZIP16;

/// The fastest.
const DEFLATE_LEVEL: u8 = 1;

/// Tiles in flight for each thread: enough that threads seldom wait for each other.
const TILES_PER_THREAD: usize = 16;

/// How a channel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 16-bit float: 11 significant bits, up to 65504.
    Half,
    /// 32-bit float.
    Float,
}

/// A channel to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name, unlike any other in the file; dots separate layers: `normal.X`.
    pub name: String,
    /// How it is stored.
    pub depth: Depth,
}

/// The source of samples to write: `fill(level, channel, y, x, out)` is asked for part of a row of one channel,
/// `out.len()` texels of row `y` from column `x`, as they shall be stored.
pub type Fill<'a> = &'a (dyn Fn(usize, usize, usize, usize, &mut [f32]) + Sync);

/// Writes an OpenEXR file with all mip levels down to 1x1 (sizes as [`Size::level`]: rounded down), in tiles of 64x64.
/// Renderers that read textures by OpenImageIO find there what lies beyond the border (the attribute `wrapmodes`).
///
/// `fill` counts channels in the order of `channels`, whatever order the file has (EXR sorts names). It is called from
/// several threads, in any order, once for each texel of each level.
///
/// The bytes depend on nothing else, not on the number of threads. Memory holds a bounded number of tiles. `out` needs
/// no buffer of its own and shall be at its start.
///
/// # Errors
/// Whatever `out` returns; [`io::ErrorKind::InvalidInput`] for no channels, names that are empty, equal, longer than 255
/// or not Latin-1, or sides beyond 2^31.
pub fn write_exr(out: impl Write + Seek, channels: &[Channel], size: Size, wrap: Wrap, fill: Fill) -> io::Result<()> {
    write_rounded(out, channels, (size, RoundingMode::Down), Some(wrap), fill)
}

/// The same with the sizes of levels rounded up (EXR's ROUND_UP): a texel of a level covers all of two by two texels below
/// it, and none is left out. For ranges.
///
/// # Errors
/// As [`write_exr`].
pub fn write_exr_covering(out: impl Write + Seek, channels: &[Channel], size: Size, fill: Fill) -> io::Result<()> {
    write_rounded(out, channels, (size, RoundingMode::Up), None, fill)
}

fn write_rounded(
    out: impl Write + Seek,
    channels: &[Channel],
    size: (Size, RoundingMode),
    wrap: Option<Wrap>,
    fill: Fill,
) -> io::Result<()> {
    write_tiles(&mut BufWriter::with_capacity(1 << 18, out), channels, size, wrap, fill).map_err(|error| match error {
        ::exr::error::Error::Io(error) => error,
        other => io::Error::new(io::ErrorKind::InvalidInput, other.to_string()),
    })
}

trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

fn write_tiles(
    out: &mut dyn Sink,
    channels: &[Channel],
    (size, rounding_mode): (Size, RoundingMode),
    wrap: Option<Wrap>,
    fill: Fill,
) -> ::exr::error::UnitResult {
    // EXR wants channels by name: `order` leads from the file's channel to the caller's.
    let mut order: Vec<usize> = (0..channels.len()).collect();
    order.sort_by_key(|&c| &channels[c].name);
    let list = order.iter().map(|&c| description(&channels[c])).collect::<::exr::error::Result<_>>()?;

    let mip_mapped = TileDescription { tile_size: Vec2(TILE, TILE), level_mode: LevelMode::MipMap, rounding_mode };
    let sizes: Vec<Vec2<usize>> =
        mip_map_levels(rounding_mode, Vec2(size.width, size.height)).map(|(_, level)| level).collect();
    let mut header = Header::new(Text::default(), Vec2(size.width, size.height), list)
        .with_encoding(COMPRESSION, BlockDescription::Tiles(mip_mapped), LineOrder::Increasing)
        .with_attributes(LayerAttributes::default());
    // A file of one part needs no name.
    header.own_attributes.layer_name = None;
    header.own_attributes.wrap_mode_name = wrap.map(Wrap::oiio).map(|mode| format!("{mode},{mode}").as_str().into());

    let tile = |location: TileCoordinates| {
        let Vec2(x, top) = location.tile_index * Vec2(TILE, TILE);
        let Vec2(columns, rows) = sizes[location.level_index.x()];
        let (width, height) = (TILE.min(columns - x), TILE.min(rows - top));
        let mut data = Vec::with_capacity(width * height * 4 * channels.len());
        let mut row = vec![0.0; width];
        let mut halves = vec![f16::ZERO; width];
        for y in top..top + height {
            for &channel in &order {
                fill(location.level_index.x(), channel, y, x, &mut row);
                match channels[channel].depth {
                    Depth::Float => data.extend(row.iter().flat_map(|value| value.to_le_bytes())),
                    Depth::Half => {
                        halves.convert_from_f32_slice(&row);
                        data.extend(halves.iter().flat_map(|value| value.to_le_bytes()));
                    }
                }
            }
        }
        let block = CompressedTileBlock { coordinates: location, compressed_pixels_le: zip(data) };
        Chunk { layer_index: 0, compressed_block: CompressedBlock::Tile(block) }
    };

    // (The sizes that come with the tiles' places are wrong at the border.)
    let tiles: Vec<TileCoordinates> = header.blocks_increasing_y_order().map(|tile| tile.location).collect();
    ::exr::block::write(out, vec![header].into(), true, |_, writer| {
        let batch = TILES_PER_THREAD * rayon::current_num_threads();
        for (batch, tiles) in (0..).step_by(batch).zip(tiles.chunks(batch)) {
            let chunks: Vec<Chunk> = tiles.par_iter().map(|&location| tile(location)).collect();
            for (number, chunk) in (batch..).zip(chunks) {
                writer.write_chunk(number, chunk)?;
            }
        }
        Ok(())
    })
}

/// EXR's ZIP compression: low bytes before high bytes, differences of neighbours, deflate; or as it is if that is no
/// shorter. Done here because exr's own takes three times as long to save a tenth more.
fn zip(data: Vec<u8>) -> Vec<u8> {
    let mut bytes: Vec<u8> = data.iter().step_by(2).chain(data.iter().skip(1).step_by(2)).copied().collect();
    for i in (1..bytes.len()).rev() {
        bytes[i] = bytes[i].wrapping_sub(bytes[i - 1]).wrapping_add(128);
    }
    let packed = compress_to_vec_zlib(&bytes, DEFLATE_LEVEL);
    if packed.len() < data.len() { packed } else { data }
}

fn description(channel: &Channel) -> ::exr::error::Result<ChannelDescription> {
    let name = Text::new_or_none(&channel.name)
        .ok_or_else(|| ::exr::error::Error::Invalid(format!("channel name {:?}", channel.name).into()))?;
    let sample_type = match channel.depth {
        Depth::Half => SampleType::F16,
        Depth::Float => SampleType::F32,
    };
    Ok(ChannelDescription { name, sample_type, quantize_linearly: false, sampling: Vec2(1, 1) })
}

/// All levels of an OpenEXR file, largest first, with channels in the file's order (by name); one level if the file is
/// flat or rip-mapped. The first part of the file that has texels is read.
///
/// # Errors
/// As [`super::read`].
pub fn read_exr_levels(path: &Path) -> Result<Vec<Raster>> {
    let bytes = super::file(path)?;
    let format = Format::of(path, &bytes)?;
    if format != Format::Exr {
        return Err(Error::invalid(path, format!("{} data", format.name()), "an OpenEXR file"));
    }
    let source = Source { path, bytes: &bytes, format };
    source.guard(|| Layer::open(&source)?.levels(usize::MAX, |names| (0..names.len()).collect()))
}

/// The largest `count` levels, with channels in the order that people expect.
pub(super) fn decode(source: &Source, count: usize) -> Result<(Vec<Raster>, Vec<String>)> {
    let layer = Layer::open(source)?;
    let notes = layer.notes();
    Ok((layer.levels(count, customary_order)?, notes))
}

/// File channels in customary order: `R G B A` or `X Y Z A`, then others, within each layer that has such; else as they
/// are.
fn customary_order(names: &[String]) -> Vec<usize> {
    let split = |name: &'_ str| -> (String, Option<usize>) {
        let (layer, channel) = name.rsplit_once('.').unwrap_or(("", name));
        (layer.to_owned(), ["R", "G", "B", "X", "Y", "Z", "A"].iter().position(|c| c.eq_ignore_ascii_case(channel)))
    };
    let split: Vec<_> = names.iter().map(|name| split(name)).collect();
    // A layer of usual names alone, or one that has all three of a colour or a vector.
    let customary = |layer: &str| {
        let ranks: Vec<_> = split.iter().filter(|(l, _)| l == layer).map(|(_, rank)| *rank).collect();
        let has = |triple: [usize; 3]| triple.iter().all(|rank| ranks.contains(&Some(*rank)));
        ranks.iter().all(Option::is_some) || has([0, 1, 2]) || has([3, 4, 5])
    };
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|&c| {
        let (layer, rank) = &split[c];
        let first = split.iter().position(|(l, _)| l == layer);
        let rank = if customary(layer) { *rank } else { None };
        (first, rank.is_none(), rank)
    });
    order
}

/// The part of a file that is read.
struct Layer<'a> {
    source: &'a Source<'a>,
    reader: Reader<Cursor<&'a [u8]>>,
    number: usize,
}

impl<'a> Layer<'a> {
    fn open(source: &'a Source<'a>) -> Result<Self> {
        let reader = ::exr::block::read(Cursor::new(source.bytes), false).map_err(|error| failure(source, error))?;
        let number = reader
            .headers()
            .iter()
            .position(|header| header.layer_size.area() > 0 && !header.channels.list.is_empty())
            .ok_or_else(|| source.broken("no part has texels"))?;
        let layer = Self { source, reader, number };
        let header = layer.header();
        let size = source.size(header.layer_size.x() as u64, header.layer_size.y() as u64)?;
        // Each block has its place in a table: a cheap measure of what the file must hold.
        let chunks =
            layer.reader.headers().iter().fold(0u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
        source.holds(chunks.saturating_mul(8), 1)?;
        // The smaller levels and the block at hand fit in as much again.
        source.memory(size, header.channels.list.len().saturating_mul(8))?;
        if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(source.unsupported("subsampled channels (luminance and chroma)", "one sample a texel"));
        }
        Ok(layer)
    }

    fn header(&self) -> &Header {
        &self.reader.headers()[self.number]
    }

    fn notes(&self) -> Vec<String> {
        let header = self.header();
        let mut notes = Vec::new();
        let count = self.reader.headers().len();
        if count > 1 {
            let name = header.own_attributes.layer_name.as_ref().map(Text::to_string).unwrap_or_default();
            notes.push(format!("OpenEXR has {count} parts: part {} \"{name}\" is read", self.number + 1));
        }
        if header.data_window() != header.shared_attributes.display_window {
            notes.push("OpenEXR has a data window that is not its display window: the data window is read".to_owned());
        }
        notes
    }

    /// The largest `count` levels (fewer where there are fewer), channels arranged by `order`.
    fn levels(self, count: usize, order: fn(&[String]) -> Vec<usize>) -> Result<Vec<Raster>> {
        let Layer { source, number, .. } = self;
        let header = self.header();
        let sizes: Vec<Size> = match header.blocks {
            BlockDescription::Tiles(tiles) if tiles.level_mode == LevelMode::MipMap => {
                let levels = mip_map_levels(tiles.rounding_mode, header.layer_size).take(count);
                levels.map(|(_, Vec2(width, height))| Size::new(width, height)).collect()
            }
            _ => vec![Size::new(header.layer_size.x(), header.layer_size.y())],
        };
        let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
        let order = order(&names);
        // From the file's channel to its place in the raster.
        let mut place = vec![0; names.len()];
        for (to, &from) in order.iter().enumerate() {
            place[from] = to;
        }
        let channels: Vec<String> = order.iter().map(|&from| names[from].clone()).collect();
        let mut levels: Vec<Vec<f32>> = sizes.iter().map(|size| vec![0.0; size.texels() * names.len()]).collect();

        let wanted = |block: &BlockIndex| {
            let Vec2(x, y) = block.level;
            block.layer == number && x == y && x < sizes.len()
        };
        let fail = |error| failure(source, error);
        let mut chunks = self.reader.filter_chunks(false, |_, _, block| wanted(&block)).map_err(fail)?;
        let meta = chunks.meta_data().clone();
        let mut missing = chunks.expected_chunk_count();
        let mut seen = HashSet::new();
        loop {
            let batch = chunks.by_ref().take(TILES_PER_THREAD * rayon::current_num_threads());
            let batch = batch.collect::<::exr::error::Result<Vec<Chunk>>>().map_err(fail)?;
            if batch.is_empty() {
                break;
            }
            let blocks = batch.into_par_iter().map(|chunk| samples(chunk, &meta));
            for (index, samples) in blocks.collect::<::exr::error::Result<Vec<_>>>().map_err(fail)? {
                if !wanted(&index) || !seen.insert(index) {
                    return Err(source.broken("its table of blocks points at the wrong one"));
                }
                missing -= 1;
                scatter(&mut levels[index.level.x()], sizes[index.level.x()], &place, index, &samples);
            }
        }
        debug_assert_eq!(missing, 0);
        let raster = |(level, size): (Vec<f32>, &Size)| {
            let samples = Array3::from_shape_vec((size.height, size.width, channels.len()), level);
            Raster { samples: Samples::F32(samples.expect("made for this size")), channels: channels.clone() }
        };
        Ok(levels.into_iter().zip(&sizes).map(raster).collect())
    }
}

/// A block's samples as floats: rows of channels of texels.
fn samples(chunk: Chunk, meta: &MetaData) -> ::exr::error::Result<(BlockIndex, Vec<f32>)> {
    let block = UncompressedBlock::decompress_chunk(chunk, meta, false)?;
    let Vec2(width, height) = block.index.pixel_size;
    let list = &meta.headers[block.index.layer].channels.list;
    let mut samples = vec![0.0; width * height * list.len()];
    let mut bytes = block.data.as_slice();
    let mut rows = samples.chunks_exact_mut(width);
    let mut halves = vec![f16::ZERO; width];
    for _ in 0..height {
        for (channel, row) in list.iter().zip(rows.by_ref()) {
            let length = width * channel.sample_type.bytes_per_sample();
            let (line, rest) =
                bytes.split_at_checked(length).ok_or(::exr::error::Error::Invalid("a block is too short".into()))?;
            bytes = rest;
            let words = line.as_chunks::<4>().0.iter();
            match channel.sample_type {
                SampleType::F32 => row.iter_mut().zip(words).for_each(|(to, &from)| *to = f32::from_ne_bytes(from)),
                SampleType::U32 => {
                    row.iter_mut().zip(words).for_each(|(to, &from)| *to = u32::from_ne_bytes(from) as f32)
                }
                SampleType::F16 => {
                    let pairs = line.as_chunks::<2>().0.iter();
                    halves.iter_mut().zip(pairs).for_each(|(to, &from)| *to = f16::from_ne_bytes(from));
                    halves.convert_to_f32_slice(row);
                }
            }
        }
    }
    Ok((block.index, samples))
}

/// Copies a block's samples to their places in a level.
fn scatter(level: &mut [f32], size: Size, place: &[usize], index: BlockIndex, samples: &[f32]) {
    let Vec2(width, height) = index.pixel_size;
    let Vec2(x, top) = index.pixel_position;
    let channels = place.len();
    let mut rows = samples.chunks_exact(width);
    for y in top..top + height {
        let texels = &mut level[(y * size.width + x) * channels..][..width * channels];
        for (&channel, row) in place.iter().zip(rows.by_ref()) {
            texels[channel..].iter_mut().step_by(channels).zip(row).for_each(|(to, &from)| *to = from);
        }
    }
}

fn failure(source: &Source, error: ::exr::error::Error) -> Error {
    match error {
        ::exr::error::Error::NotSupported(what) => source.unsupported(what, "flat OpenEXR pictures"),
        other => source.broken(other),
    }
}

#[cfg(test)]
mod tests;
