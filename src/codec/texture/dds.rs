//! DDS: written with the DX10 header, read with it and with the older one. Headers by the `ddsfile` crate; the data after
//! them is cut up here, for the crate's sizes are of 32 bit and overflow.

use std::io::{self, Cursor, Write};

use ddsfile::{AlphaMode, Caps2, D3D10ResourceDimension, Dds, FourCC, Header, Header10, MiscFlag};
use ddsfile::{DxgiFormat, PixelFormat, PixelFormatFlags};

use super::layout::{Kind, Layout};
use super::{TexelFormat, Texture};
use crate::codec::Source;
use crate::error::{Error, Result};
use crate::image::{Raster, Size};

/// Bytes before the header.
const MAGIC: usize = 4;

/// Bytes of the header.
const HEADER: usize = 124;

/// Writes a DDS file with a DX10 header: one 2D texture with its levels, largest first, without gaps.
///
/// # Errors
/// Whatever `out` returns; [`io::ErrorKind::InvalidInput`] if the levels are not those of the size and the format;
/// [`io::ErrorKind::Unsupported`] for UASTC, for blocks if a side of level 0 is no multiple of 4 (Direct3D makes no such
/// texture), and if a row has 2^32 bits or more, or level 0 in blocks 2^32 bytes.
pub fn write_dds(mut out: impl Write, texture: &Texture) -> io::Result<()> {
    texture.check()?;
    let Texture { size, format, levels } = texture;
    let unsupported = |what: String| io::Error::new(io::ErrorKind::Unsupported, what);
    let too_large = |_| unsupported(format!("DDS cannot hold {size} texels"));
    let dxgi = format.facts().dxgi.ok_or_else(|| {
        unsupported(format!(
            "DDS cannot hold {}: it is for KTX 2, which says how it is turned into others",
            format.name()
        ))
    })?;
    let blocks = format.block_side() > 1;
    if blocks && !(size.width.is_multiple_of(4) && size.height.is_multiple_of(4)) {
        let name = format.name();
        return Err(unsupported(format!("DDS with {name} has sides that are multiples of 4 texels, not {size}")));
    }
    let row = size.width.div_ceil(format.block_side()) * format.block_bytes();
    // Rows in bits: the crate multiplies them in 32.
    u32::try_from(if blocks { format.bytes(*size) } else { 8 * row }).map_err(too_large)?;
    let mut header = Header::new_dxgi(
        size.height.try_into().map_err(too_large)?,
        size.width.try_into().map_err(too_large)?,
        None,
        dxgi,
        Some(levels.len() as u32),
        None,
        None,
    )
    .map_err(io::Error::other)?;
    // The crate adds what some readers take for a format without DX10 header: that texels are RGB, and their bits.
    header.spf =
        PixelFormat { flags: PixelFormatFlags::FOURCC, fourcc: Some(FourCC(FourCC::DX10)), ..PixelFormat::default() };
    let header10 = Header10::new(dxgi, false, D3D10ResourceDimension::Texture2D, 1, AlphaMode::Unknown);
    let head = Dds { header, header10: Some(header10), data: Vec::new() };
    head.write(&mut out).map_err(io::Error::other)?;
    for level in levels {
        out.write_all(level)?;
    }
    out.flush()
}

const SUPPORTED: &str = "one 2D texture of 8 or 16 bit, half or float, BC1, BC3, BC4, BC5 or BC7";

/// The largest `count` levels.
pub(in crate::codec) fn decode(source: &Source, count: usize) -> Result<(Vec<Raster>, Vec<String>)> {
    let mut rest = Cursor::new(&source.bytes[MAGIC..]);
    let header = Header::read(&mut rest).map_err(|error| failure(source, error))?;
    let modern = header.spf.fourcc == Some(FourCC(FourCC::DX10));
    let header10 = modern.then(|| read_header10(source, &mut rest)).transpose()?;
    let size = size(source, &header, header10.as_ref())?;
    let (layout, srgb) = match &header10 {
        Some(header) => modern_layout(header.dxgi_format)
            .ok_or_else(|| source.unsupported(format!("texels of format {:?}", header.dxgi_format), SUPPORTED))?,
        None => (legacy_layout(&header.spf).ok_or_else(|| unsupported_pixels(source, &header.spf))?, false),
    };

    let levels = header.mip_map_count.unwrap_or(1).max(1) as usize;
    if levels > size.level_count() {
        return Err(source.broken(format!("{levels} levels, where {size} texels have {}", size.level_count())));
    }
    let needed: u64 = (0..levels).map(|k| layout.bytes(size.level(k)) as u64).sum();
    let mut data = &source.bytes[MAGIC + rest.position() as usize..];
    if needed > data.len() as u64 {
        return Err(source.broken(format!("{} bytes of texels, where its {levels} levels need {needed}", data.len())));
    }
    source.memory(size, layout.sample_bytes() * if count > 1 { 2 } else { 1 })?;

    let mut rasters = Vec::new();
    for k in 0..levels.min(count) {
        let size = size.level(k);
        let (level, rest) = data.split_at(layout.bytes(size));
        rasters.push(layout.decode(level, size));
        data = rest;
    }
    let note = "DDS says its data is sRGB: ignored, data is taken as linear";
    Ok((rasters, if srgb { vec![note.to_owned()] } else { Vec::new() }))
}

/// The DX10 header. Its format and dimension have numbers that the crate does not know: these are unsupported, not
/// damaged.
fn read_header10(source: &Source, rest: &mut Cursor<&[u8]>) -> Result<Header10> {
    let at = MAGIC + HEADER;
    let Some(fields) = source.bytes.get(at..at + 20) else { return Err(source.broken("it ends within its header")) };
    let word = |i: usize| u32::from_le_bytes([fields[4 * i], fields[4 * i + 1], fields[4 * i + 2], fields[4 * i + 3]]);
    Header10::read(rest).map_err(|_| {
        source.unsupported(
            format!("format {}, resource dimension {} and alpha mode {}", word(0), word(1), word(4) & 7),
            SUPPORTED,
        )
    })
}

/// The size of level 0, of a file that is one 2D texture.
fn size(source: &Source, header: &Header, header10: Option<&Header10>) -> Result<Size> {
    let is_volume = header.caps2.contains(Caps2::VOLUME) || header.depth.is_some_and(|depth| depth > 1);
    let found = match header10 {
        Some(Header10 { misc_flag, .. }) if misc_flag.contains(MiscFlag::TEXTURECUBE) => "a cube map".to_owned(),
        _ if header.caps2.contains(Caps2::CUBEMAP) => "a cube map".to_owned(),
        Some(Header10 { resource_dimension: D3D10ResourceDimension::Texture2D, array_size: 0 | 1, .. }) | None
            if !is_volume =>
        {
            return source.size(header.width.into(), header.height.into());
        }
        Some(Header10 { array_size: 2.., .. }) => "an array of textures".to_owned(),
        _ => "a texture that is not 2D".to_owned(),
    };
    Err(source.unsupported(found, SUPPORTED))
}

/// How texels of a `DXGI_FORMAT` lie, and whether they are sRGB.
fn modern_layout(format: DxgiFormat) -> Option<(Layout, bool)> {
    let plain = |kind, channels| (Layout::plain(kind, channels), false);
    if let Some(format) = TexelFormat::all().find(|known| known.dxgi_format() == Some(format as u32)) {
        return Some((format.layout(), false));
    }
    Some(match format {
        DxgiFormat::R8G8B8A8_UNorm_sRGB => (Layout::plain(Kind::Unorm8, 4), true),
        DxgiFormat::B8G8R8A8_UNorm => (Layout::bgr(4, 4), false),
        DxgiFormat::B8G8R8A8_UNorm_sRGB => (Layout::bgr(4, 4), true),
        DxgiFormat::B8G8R8X8_UNorm => (Layout::bgr(4, 3), false),
        DxgiFormat::B8G8R8X8_UNorm_sRGB => (Layout::bgr(4, 3), true),
        DxgiFormat::A8_UNorm => plain(Kind::Unorm8, 1),
        DxgiFormat::R8_SNorm => plain(Kind::Snorm8, 1),
        DxgiFormat::R8G8_SNorm => plain(Kind::Snorm8, 2),
        DxgiFormat::R8G8B8A8_SNorm => plain(Kind::Snorm8, 4),
        DxgiFormat::R16_SNorm => plain(Kind::Snorm16, 1),
        DxgiFormat::R16G16_SNorm => plain(Kind::Snorm16, 2),
        DxgiFormat::R16G16B16A16_SNorm => plain(Kind::Snorm16, 4),
        DxgiFormat::R32_Float => plain(Kind::Float, 1),
        DxgiFormat::R32G32_Float => plain(Kind::Float, 2),
        DxgiFormat::R32G32B32_Float => plain(Kind::Float, 3),
        DxgiFormat::R32G32B32A32_Float => plain(Kind::Float, 4),
        DxgiFormat::BC1_UNorm => plain(Kind::Bc1, 4),
        DxgiFormat::BC1_UNorm_sRGB => (Layout::plain(Kind::Bc1, 4), true),
        DxgiFormat::BC3_UNorm => plain(Kind::Bc3, 4),
        DxgiFormat::BC3_UNorm_sRGB => (Layout::plain(Kind::Bc3, 4), true),
        DxgiFormat::BC4_SNorm => plain(Kind::Bc4Signed, 1),
        DxgiFormat::BC5_SNorm => plain(Kind::Bc5Signed, 2),
        DxgiFormat::BC7_UNorm_sRGB => (Layout::plain(Kind::Bc7, 4), true),
        _ => return None,
    })
}

/// How texels of the older header lie: by its four letters or number, or by its masks.
fn legacy_layout(pixels: &PixelFormat) -> Option<Layout> {
    /// The other two spellings, which the crate has no names for.
    const BC4U: u32 = u32::from_le_bytes(*b"BC4U");
    const BC5U: u32 = u32::from_le_bytes(*b"BC5U");
    if let Some(FourCC(code)) = pixels.fourcc {
        return Some(match code {
            FourCC::DXT1 => Layout::plain(Kind::Bc1, 4),
            FourCC::DXT5 => Layout::plain(Kind::Bc3, 4),
            FourCC::ATI1 | BC4U => Layout::plain(Kind::Bc4, 1),
            FourCC::BC4_SNORM => Layout::plain(Kind::Bc4Signed, 1),
            FourCC::ATI2 | BC5U => Layout::plain(Kind::Bc5, 2),
            FourCC::BC5_SNORM => Layout::plain(Kind::Bc5Signed, 2),
            FourCC::A16B16G16R16 => Layout::plain(Kind::Unorm16, 4),
            FourCC::R16F => Layout::plain(Kind::Half, 1),
            FourCC::G16R16F => Layout::plain(Kind::Half, 2),
            FourCC::A16B16G16R16F => Layout::plain(Kind::Half, 4),
            FourCC::R32F => Layout::plain(Kind::Float, 1),
            FourCC::G32R32F => Layout::plain(Kind::Float, 2),
            FourCC::A32B32G32R32F => Layout::plain(Kind::Float, 4),
            _ => return None,
        });
    }
    let alpha = pixels.flags.contains(PixelFormatFlags::ALPHA_PIXELS);
    if pixels.flags.contains(PixelFormatFlags::LUMINANCE) {
        return Some(match (pixels.rgb_bit_count?, alpha) {
            (8, false) => Layout::plain(Kind::Unorm8, 1),
            (16, false) => Layout::plain(Kind::Unorm16, 1),
            (16, true) => Layout::plain(Kind::Unorm8, 2),
            _ => return None,
        });
    }
    if !pixels.flags.contains(PixelFormatFlags::RGB) {
        // (The crate keeps no number of bits for alpha alone, which has 8.)
        let alone = pixels.flags.contains(PixelFormatFlags::ALPHA) && pixels.a_bit_mask == Some(0xff);
        return alone.then(|| Layout::plain(Kind::Unorm8, 1));
    }
    let bits = pixels.rgb_bit_count.filter(|bits| matches!(bits, 8 | 16 | 24 | 32))?;
    let masks = [pixels.r_bit_mask, pixels.g_bit_mask, pixels.b_bit_mask, pixels.a_bit_mask.filter(|_| alpha)];
    let mut masks: Vec<u32> = masks.map(Option::unwrap_or_default).to_vec();
    while masks.pop_if(|mask| *mask == 0).is_some() {}
    if masks == [0xffff, 0xffff_0000] && bits == 32 {
        return Some(Layout::plain(Kind::Unorm16, 2));
    }
    if masks == [0xffff] && bits == 16 {
        return Some(Layout::plain(Kind::Unorm16, 1));
    }
    // (A mask of 0 before another is no byte: red and blue are no red and green.)
    let byte = |mask: &u32| (0..bits as u8 / 8).find(|i| *mask == 0xff << (8 * i));
    let order: Vec<u8> = masks.iter().map(byte).collect::<Option<_>>()?;
    (!order.is_empty()).then(|| Layout::ordered(Kind::Unorm8, bits as usize / 8, &order))
}

fn unsupported_pixels(source: &Source, pixels: &PixelFormat) -> Error {
    let found = match &pixels.fourcc {
        Some(FourCC(code)) if code.to_le_bytes().iter().all(u8::is_ascii_graphic) => {
            format!("texels of format {}", String::from_utf8_lossy(&code.to_le_bytes()))
        }
        Some(FourCC(code)) => format!("texels of format number {code}"),
        None => {
            let mask = |mask: Option<u32>| mask.map_or("none".to_owned(), |mask| format!("{mask:#x}"));
            let [r, g, b, a] = [pixels.r_bit_mask, pixels.g_bit_mask, pixels.b_bit_mask, pixels.a_bit_mask].map(mask);
            format!("texels of {} bit with masks {r}, {g}, {b} and {a}", pixels.rgb_bit_count.unwrap_or(0))
        }
    };
    source.unsupported(found, SUPPORTED)
}

fn failure(source: &Source, error: ddsfile::Error) -> Error {
    match error {
        ddsfile::Error::Io(_) => source.broken("it ends within its header"),
        other => source.broken(other),
    }
}
