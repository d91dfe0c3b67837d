//! Textures for GPUs: texels as graphics hardware samples them, and the containers that carry whole mip chains, KTX 2 and
//! DDS.
//!
//! Everything here is linear: written as `UNORM` or half float, never sRGB, because no map of this crate holds colours for
//! the eye. Levels are those that the caller made; nothing here filters.
//!
//! | format | samples | bytes a texel |
//! |---|---|---|
//! | `R8` `Rg8` `Rgba8` | 8 bit | 1, 2, 4 |
//! | `R16` `Rg16` `Rgba16` | 16 bit | 2, 4, 8 |
//! | `R16f` `Rg16f` `Rgba16f` | half float | 2, 4, 8 |
//! | `Bc4` | 1 channel in blocks of 4x4 | 1/2 |
//! | `Bc5` | 2 channels, each a BC4 block | 1 |
//! | `Bc7` | 3 or 4 channels in blocks of 4x4 | 1 |
//! | `Uastc` | likewise; only in KTX 2, and turned into another of these when loaded | 1 |
//!
//! What that costs normals, on made-up bumps of 256x256 texels (24 waves, the shortest 11 texels long, slopes of 0.25 root
//! mean square, and three dents), against normals that are not rounded at all; the tests hold these figures:
//!
//! | format | PSNR | mean angle | worst angle |
//! |---|---|---|---|
//! | `Rg8`, third coordinate from the other two | 58.9 dB | 0.17 degrees | 0.4 degrees |
//! | `Bc5`, likewise | 49.6 dB | 0.47 degrees | 2.4 degrees |
//! | `Bc7`, fast | 39.8 dB | 1.50 degrees | 14.7 degrees |
//! | `Bc7`, slow | 44.5 dB | 0.94 degrees | 6.0 degrees |
//! | `Uastc`, fast | 44.3 dB | 0.98 degrees | 6.0 degrees |
//! | `Uastc`, slow | 44.7 dB | 0.94 degrees | 5.3 degrees |
//!
//! A map of occlusion, roughness and patches of metal made from them: 42.4 dB in `Bc7`, fast, and 46.9 dB, slow; 45.4 dB
//! and 45.9 dB in `Uastc`; its first channel alone 55.5 dB in `Bc4`. Normals belong in `Bc5`.
//!
//! Channels go in as they come: a raster with fewer channels than the format is filled up as hardware does, with 0 and an
//! alpha of 1, and what the format has no place for is dropped. Integers that the format has fewer bits for are rounded;
//! floats outside 0 to 1 are clamped where the format is `UNORM`.

use std::io;
use std::ops::Range;

use ddsfile::DxgiFormat;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use crate::image::{Raster, Size};

mod bc4;
mod bc7;
mod dds;
mod ktx2;
mod layout;
mod uastc;

#[cfg(test)]
mod tests;

pub use dds::{write_dds, write_dds9};
pub use ktx2::write_ktx2;

pub(super) use dds::decode as decode_dds;
pub(super) use ktx2::decode as decode_ktx2;

use layout::{Kind, Layout};

/// How texels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelFormat {
    /// One channel of 8 bit.
    R8,
    /// Two channels of 8 bit.
    Rg8,
    /// Four channels of 8 bit.
    Rgba8,
    /// One channel of 16 bit.
    R16,
    /// Two channels of 16 bit.
    Rg16,
    /// Four channels of 16 bit.
    Rgba16,
    /// One half-float channel.
    R16f,
    /// Two half-float channels.
    Rg16f,
    /// Four half-float channels.
    Rgba16f,
    /// One channel, block-compressed.
    Bc4,
    /// Two channels, block-compressed, each by itself.
    Bc5,
    /// Four channels, block-compressed, of 8 bit or less.
    Bc7,
    /// Four channels, block-compressed, of 8 bit or less: UASTC LDR 4x4, which no GPU samples but which is quickly turned
    /// into what it does. Only KTX 2 holds it.
    Uastc,
}

/// What is to be known about a format: its name, what it is in `VkFormat` (0: nothing) and `DXGI_FORMAT`, and its samples.
struct Facts {
    format: TexelFormat,
    name: &'static str,
    vulkan: u32,
    dxgi: Option<DxgiFormat>,
    channels: usize,
    kind: Kind,
}

/// All formats. Vulkan 1.3, `VkFormat`; Windows SDK, `dxgiformat.h`.
#[rustfmt::skip]
static FORMATS: [Facts; 13] = {
    const fn facts(
        format: TexelFormat, name: &'static str, vulkan: u32, dxgi: DxgiFormat, channels: usize, kind: Kind,
    ) -> Facts {
        Facts { format, name, vulkan, dxgi: Some(dxgi), channels, kind }
    }
    [
        facts(TexelFormat::R8,      "r8",        9, DxgiFormat::R8_UNorm,           1, Kind::Unorm8),
        facts(TexelFormat::Rg8,     "rg8",      16, DxgiFormat::R8G8_UNorm,         2, Kind::Unorm8),
        facts(TexelFormat::Rgba8,   "rgba8",    37, DxgiFormat::R8G8B8A8_UNorm,     4, Kind::Unorm8),
        facts(TexelFormat::R16,     "r16",      70, DxgiFormat::R16_UNorm,          1, Kind::Unorm16),
        facts(TexelFormat::Rg16,    "rg16",     77, DxgiFormat::R16G16_UNorm,       2, Kind::Unorm16),
        facts(TexelFormat::Rgba16,  "rgba16",   91, DxgiFormat::R16G16B16A16_UNorm, 4, Kind::Unorm16),
        facts(TexelFormat::R16f,    "r16f",     76, DxgiFormat::R16_Float,          1, Kind::Half),
        facts(TexelFormat::Rg16f,   "rg16f",    83, DxgiFormat::R16G16_Float,       2, Kind::Half),
        facts(TexelFormat::Rgba16f, "rgba16f",  97, DxgiFormat::R16G16B16A16_Float, 4, Kind::Half),
        facts(TexelFormat::Bc4,     "bc4",     139, DxgiFormat::BC4_UNorm,          1, Kind::Bc4),
        facts(TexelFormat::Bc5,     "bc5",     141, DxgiFormat::BC5_UNorm,          2, Kind::Bc5),
        facts(TexelFormat::Bc7,     "bc7",     145, DxgiFormat::BC7_UNorm,          4, Kind::Bc7),
        Facts { format: TexelFormat::Uastc, name: "uastc", vulkan: 0, dxgi: None, channels: 4, kind: Kind::Uastc },
    ]
};

impl TexelFormat {
    /// Every format, in the order of the table above.
    pub fn all() -> impl ExactSizeIterator<Item = Self> {
        FORMATS.iter().map(|facts| facts.format)
    }

    /// The format of a name; upper and lower case are the same.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::all().find(|format| format.name().eq_ignore_ascii_case(name))
    }

    fn facts(self) -> &'static Facts {
        &FORMATS[self as usize]
    }

    /// Its name, lower case: `rg16f`, `bc5`.
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// Number of channels: 1, 2 or 4.
    pub fn channels(self) -> usize {
        self.facts().channels
    }

    /// Its number in Vulkan's `VkFormat`, as KTX 2 has it; none for UASTC, which a data format descriptor tells.
    pub fn vk_format(self) -> Option<u32> {
        Some(self.facts().vulkan).filter(|number| *number > 0)
    }

    /// Its number in Direct3D's `DXGI_FORMAT`, as DDS has it; none for UASTC, which DDS cannot hold.
    pub fn dxgi_format(self) -> Option<u32> {
        self.facts().dxgi.map(|format| format as u32)
    }

    /// Texels along each side of a block: 4, or 1 where texels stand alone.
    pub fn block_side(self) -> usize {
        self.layout().block_side()
    }

    /// Bytes of a block, or of a texel where there are no blocks.
    pub fn block_bytes(self) -> usize {
        self.layout().block_bytes()
    }

    /// Bytes of a picture of this size.
    pub fn bytes(self, size: Size) -> usize {
        self.layout().bytes(size)
    }

    fn layout(self) -> Layout {
        Layout::plain(self.facts().kind, self.channels())
    }
}

/// How much time BC7, UASTC and Zstandard may take; other formats have one way only.
///
/// Measured on real maps of 512x512 texels, one core of an EPYC 7003, in megatexels a second: BC7 with three channels 7 to
/// 10 fast and 0.28 slow, with four 1.6 and 0.17; BC4 19 to 33, BC5 half of that. Slow gains 3 to 7 dB with three
/// channels, and 0.1 to 3 dB with four. UASTC 2.2 fast and 0.2 to 0.3 slow, which gains about 1 dB. Zstandard packs 40 to 50
/// megabytes of BC7 or UASTC a second fast, and 1.3 to 5 slow, to up to a fifth less.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// Some seconds of one core for a chain from 4096x4096.
    #[default]
    Fast,
    /// Minutes of one core for it: for what ships.
    Slow,
}

/// A mip chain as texels of one format, ready for a container.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Size of level 0.
    pub size: Size,
    /// How its texels are stored.
    pub format: TexelFormat,
    /// The levels, largest first; the sizes are those of [`Size::level`]. A chain may stop before 1x1.
    pub levels: Vec<Vec<u8>>,
}

impl Texture {
    /// Encodes the levels of a chain, largest first.
    ///
    /// # Panics
    /// If there is no level, or one does not have the size that [`Size::level`] says.
    pub fn encode(levels: &[Raster], format: TexelFormat, effort: Effort) -> Self {
        let size = levels.first().expect("a chain has levels").size();
        for (k, level) in levels.iter().enumerate() {
            assert!(k < size.level_count() && level.size() == size.level(k), "level {k} of {size} is {}", level.size());
        }
        Self { size, format, levels: levels.iter().map(|level| encode(level, format, effort)).collect() }
    }

    /// That there are levels, as many as the size may have or fewer, each as long as it must be.
    fn check(&self) -> io::Result<()> {
        let Self { size, format, levels } = self;
        let wrong = |what: String| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        if size.width == 0 || size.height == 0 {
            return wrong(format!("a texture of {size} texels"));
        }
        if levels.is_empty() || levels.len() > size.level_count() {
            return wrong(format!("{} levels, where {size} texels have 1 to {}", levels.len(), size.level_count()));
        }
        for (k, level) in levels.iter().enumerate() {
            let (length, needed) = (level.len(), format.bytes(size.level(k)));
            if length != needed {
                let (size, name) = (size.level(k), format.name());
                return wrong(format!("level {k} of {size} texels in {name} has {length} bytes, not {needed}"));
            }
        }
        Ok(())
    }
}

/// Encodes one picture. Rows of blocks are shared between threads; the bytes do not depend on their number.
///
/// Blocks that stick out of the picture repeat its last row and column, so that no texel is spoilt by one that nobody
/// sees.
pub fn encode(raster: &Raster, format: TexelFormat, effort: Effort) -> Vec<u8> {
    let facts = format.facts();
    let size = raster.size();
    let mut bytes = vec![0; format.bytes(size)];
    let row_bytes = size.width.div_ceil(format.block_side()) * format.block_bytes();
    let opaque = raster.samples.channels() < 4;
    bytes.par_chunks_exact_mut(row_bytes).enumerate().for_each(|(row, bytes)| {
        let y = row * format.block_side();
        match facts.kind {
            Kind::Bc4 | Kind::Bc5 => channel_blocks(raster, facts.channels, y, bytes),
            Kind::Bc7 => bc7::encode(&strip(raster, y), opaque, effort, bytes),
            Kind::Uastc => uastc::encode(&strip(raster, y), effort, bytes),
            kind => plain_row(raster, facts.channels, kind, y, bytes),
        }
    });
    bytes
}

/// Decodes one picture: 8 bit to 8 bit, 16 bit, BC4 and BC5 (which are finer than 8 bit) to 16 bit, half to float. The
/// channels are called `Y`, `R G` or `R G B A`.
///
/// # Panics
/// If there are not [`TexelFormat::bytes`] bytes.
pub fn decode(bytes: &[u8], size: Size, format: TexelFormat) -> Raster {
    format.layout().decode(bytes, size)
}

/// Part of a row of one channel as the format's hardware would fill it up: 0 where the raster has no such channel, but
/// an alpha of 1.
fn channel_row(raster: &Raster, channel: usize, y: usize, out: &mut [f32]) {
    if channel < raster.samples.channels() {
        raster.read(channel, y, 0, out);
    } else {
        out.fill(if channel == 3 { 1.0 } else { 0.0 });
    }
}

/// A row of texels that stand alone.
fn plain_row(raster: &Raster, channels: usize, kind: Kind, y: usize, bytes: &mut [u8]) {
    let width = raster.size().width;
    let mut row = vec![0.0; width];
    let mut halves = vec![f16::ZERO; if kind == Kind::Half { width } else { 0 }];
    for channel in 0..channels {
        channel_row(raster, channel, y, &mut row);
        if kind == Kind::Unorm8 {
            let to = bytes[channel..].iter_mut().step_by(channels);
            to.zip(&row).for_each(|(to, v)| *to = unorm(*v, 255.0) as u8);
            continue;
        }
        let to = bytes.as_chunks_mut::<2>().0[channel..].iter_mut().step_by(channels);
        if kind == Kind::Half {
            halves.convert_from_f32_slice(&row);
            to.zip(&halves).for_each(|(to, v)| *to = v.to_le_bytes());
        } else {
            to.zip(&row).for_each(|(to, v)| *to = (unorm(*v, 65535.0) as u16).to_le_bytes());
        }
    }
}

/// To be cut to an integer: 0..1 as 0..`most`, rounded. No number becomes 0.
fn unorm(value: f32, most: f32) -> f32 {
    value.clamp(0.0, 1.0) * most + 0.5
}

/// The four rows that a row of blocks covers, `0..height` of them real.
fn rows(raster: &Raster, y: usize) -> impl Iterator<Item = (usize, usize)> {
    let last = raster.size().height - 1;
    (0..4).map(move |i| (i, (y + i).min(last)))
}

/// A row of BC4 or BC5 blocks.
fn channel_blocks(raster: &Raster, channels: usize, y: usize, bytes: &mut [u8]) {
    let width = raster.size().width;
    let padded = width.next_multiple_of(4);
    let mut strip = vec![0.0; 4 * padded];
    for channel in 0..channels {
        for (i, y) in rows(raster, y) {
            let row = &mut strip[i * padded..][..padded];
            channel_row(raster, channel, y, &mut row[..width]);
            row[..width].iter_mut().for_each(|v| *v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) * 255.0 });
            let last = row[width - 1];
            row[width..].fill(last);
        }
        let blocks = bytes.as_chunks_mut::<8>().0[channel..].iter_mut().step_by(channels);
        for (x, block) in (0..).step_by(4).zip(blocks) {
            let mut values = [0.0; 16];
            for i in 0..4 {
                values[4 * i..][..4].copy_from_slice(&strip[i * padded + x..][..4]);
            }
            *block = bc4::encode(&values);
        }
    }
}

/// Four rows as RGBA of 8 bit, as wide as their blocks.
fn strip(raster: &Raster, y: usize) -> Vec<u8> {
    let width = raster.size().width;
    let row_bytes: Range<usize> = 0..4 * width.next_multiple_of(4);
    let mut strip = vec![0; 4 * row_bytes.end];
    for (i, y) in rows(raster, y) {
        let row = &mut strip[i * row_bytes.end..][row_bytes.clone()];
        plain_row(raster, 4, Kind::Unorm8, y, &mut row[..4 * width]);
        let (texels, padding) = row.as_chunks_mut::<4>().0.split_at_mut(width);
        padding.fill(texels[width - 1]);
    }
    strip
}
