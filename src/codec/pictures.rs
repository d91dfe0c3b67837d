//! JPEG, TGA, BMP, WebP and Radiance HDR, by the `image` crate.

use std::io::Cursor;

use ::image::codecs::{bmp::BmpDecoder, hdr::HdrDecoder, jpeg::JpegDecoder, tga::TgaDecoder, webp::WebPDecoder};
use ::image::error::UnsupportedErrorKind;
use ::image::metadata::Orientation;
use ::image::{DynamicImage, ImageDecoder, ImageError, ImageResult, Limits};
use ndarray::Array3;

use super::{COLOUR_IGNORED, Format, Source};
use crate::error::{Error, Result};
use crate::image::{Raster, Samples, Size};

/// JPEG codes each 8x8 block of a component in at least a bit, and samples some component at least every 4x4 texels.
const JPEG_TEXELS_PER_BYTE: u64 = 8 * 64 * 16;

pub(super) fn decode(source: &Source) -> Result<(Raster, Vec<String>)> {
    let cursor = Cursor::new(source.bytes);
    match source.format {
        Format::Jpeg => {
            check_jpeg(source)?;
            finish(source, JpegDecoder::new(cursor))
        }
        Format::Tga => finish(source, TgaDecoder::new(cursor)),
        Format::Bmp => {
            check_bmp(source)?;
            finish(source, BmpDecoder::new(cursor))
        }
        Format::WebP => {
            let decoder = WebPDecoder::new(cursor).map_err(|error| failure(source, error))?;
            if decoder.has_animation() {
                return Err(source.unsupported("an animation", "WebP with one picture"));
            }
            finish(source, Ok(decoder))
        }
        // Lenient, for many files start with #?RGBE.
        _ => {
            let decoder = HdrDecoder::new_nonstrict(cursor).map_err(|error| failure(source, error))?;
            if decoder.metadata().orientation != ((1, 0), (0, 1)) {
                return Err(source.unsupported("rows that do not run right and down", "the usual -Y +X order"));
            }
            finish(source, Ok(decoder))
        }
    }
}

fn finish(source: &Source, decoder: ImageResult<impl ImageDecoder>) -> Result<(Raster, Vec<String>)> {
    let fail = |error| failure(source, error);
    let mut decoder = decoder.map_err(fail)?;
    let (width, height) = decoder.dimensions();
    let size = source.size(width.into(), height.into())?;
    check_length(source, size)?;
    source.memory(size, decoder.color_type().bytes_per_pixel().into())?;
    decoder.set_limits(Limits::no_limits()).map_err(fail)?;

    let mut notes = Vec::new();
    let name = source.format.name();
    if decoder.orientation().is_ok_and(|o| o != Orientation::NoTransforms) {
        notes.push(format!("{name} asks to be turned or mirrored: ignored"));
    }
    if matches!(decoder.icc_profile(), Ok(Some(_))) {
        notes.push(format!("{name} says its data has an ICC profile{COLOUR_IGNORED}"));
    }

    let samples = match DynamicImage::from_decoder(decoder).map_err(fail)? {
        DynamicImage::ImageLuma8(p) => Samples::U8(array(size, p.into_raw())),
        DynamicImage::ImageLumaA8(p) => Samples::U8(array(size, p.into_raw())),
        DynamicImage::ImageRgb8(p) => Samples::U8(array(size, p.into_raw())),
        DynamicImage::ImageRgba8(p) => Samples::U8(array(size, p.into_raw())),
        DynamicImage::ImageRgb32F(p) => Samples::F32(array(size, p.into_raw())),
        other => return Err(source.unsupported(format!("{:?} samples", other.color()), "8 bit or float")),
    };
    Ok((Raster::new(samples), notes))
}

fn array<T>(size: Size, samples: Vec<T>) -> Array3<T> {
    let channels = samples.len() / size.texels();
    Array3::from_shape_vec((size.height, size.width, channels), samples).expect("as many samples as the header says")
}

fn failure(source: &Source, error: ImageError) -> Error {
    match error {
        ImageError::Unsupported(what) => {
            let found = match what.kind() {
                UnsupportedErrorKind::Color(color) => format!("{color:?} colours"),
                UnsupportedErrorKind::GenericFeature(feature) => feature,
                _ => what.to_string(),
            };
            source.unsupported(found, "the common kinds of this format")
        }
        other => source.broken(other),
    }
}

/// Checks that the file is long enough for its size, where its format sets a lower bound.
fn check_length(source: &Source, size: Size) -> Result<()> {
    let byte = |at: usize| source.bytes.get(at).copied().unwrap_or(0);
    let texels = size.texels() as u64;
    match source.format {
        Format::Jpeg => source.holds(texels, JPEG_TEXELS_PER_BYTE),
        Format::Tga => {
            let texel_bytes = u64::from(byte(16)).div_ceil(8);
            match byte(2) {
                // Run lengths: a packet of one byte and one texel stands for up to 128.
                9.. => source.holds(texels.div_ceil(128) * (1 + texel_bytes), 1),
                _ => source.holds(texels * texel_bytes, 1),
            }
        }
        _ => Ok(()),
    }
}

/// Checks a BMP file's size against its length, where it has the usual header of at least 40 bytes.
fn check_bmp(source: &Source) -> Result<()> {
    let word = |at: usize| source.bytes.get(at..at + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if word(14) < 40 {
        return Ok(());
    }
    // Rows that run down have a negative height.
    let size = source.size(word(18).into(), word(22).cast_signed().unsigned_abs().into())?;
    let bits = u64::from(word(28) & 0xffff);
    match word(30) {
        // Run lengths have no bound.
        1 | 2 => Ok(()),
        _ => source.holds((size.width as u64 * bits).div_ceil(32) * 4 * size.height as u64, 1),
    }
}

/// Walks the segments of a JPEG file to its end, for the decoder fills a truncated one with gray and turns CMYK into RGB
/// without a word.
fn check_jpeg(source: &Source) -> Result<()> {
    let mut rest = &source.bytes[2..];
    loop {
        // Entropy-coded data follows a scan's header: its 0xff bytes are stuffed with 0 or are restart markers.
        let marker = rest.windows(2).position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7 | 0xff));
        let Some(at) = marker else { return Err(source.broken("it ends before its end marker")) };
        let kind = rest[at + 1];
        let body = &rest[at + 2..];
        if kind == 0xd9 {
            return Ok(());
        }
        let length = match body {
            [high, low, ..] => usize::from(u16::from_be_bytes([*high, *low])),
            _ => 0,
        };
        let Some(segment) = body.get(..length) else { return Err(source.broken("it ends before its end marker")) };
        let is_frame = matches!(kind, 0xc0..=0xcf) && !matches!(kind, 0xc4 | 0xc8 | 0xcc);
        if is_frame && let Some(components) = segment.get(7).filter(|n| !matches!(n, 1 | 3)) {
            let found = if *components == 4 { "CMYK colours".to_owned() } else { format!("{components} components") };
            return Err(source.unsupported(found, "gray or RGB"));
        }
        rest = &body[length..];
    }
}
