//! PNG, by the `png` crate, straight into and out of the raster's own buffer.

use std::io::{self, Cursor, Write};

use ::png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, Reader, Transformations};
use ndarray::Array3;

use super::{COLOUR_IGNORED, Source};
use crate::error::Result;
use crate::image::{Raster, Samples};

/// A byte of deflate data stands for at most this many.
const DEFLATE_BOUND: u64 = 1032;

/// Bytes of an IDAT chunk.
const CHUNK: usize = 1 << 18;

pub(super) fn decode(source: &Source) -> Result<(Raster, Vec<String>)> {
    // The limits concern the decoder's own row buffers; the checks below bound those.
    let mut decoder = Decoder::new_with_limits(Cursor::new(source.bytes), Limits { bytes: usize::MAX });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);

    let info = decoder.read_header_info().map_err(|error| source.broken(error))?;
    let size = source.size(info.width.into(), info.height.into())?;
    let row_bytes = info.raw_row_length() - 1;
    source.holds(row_bytes as u64 * u64::from(info.height), DEFLATE_BOUND)?;

    let mut reader = decoder.read_info().map_err(|error| source.broken(error))?;
    let (color, depth) = reader.output_color_type();
    let channels = color.samples();
    source.memory(size, channels * depth as usize / 8)?;
    if let Some(frame) = reader.info().frame_control
        && (frame.width as usize, frame.height as usize) != (size.width, size.height)
    {
        return Err(source.broken("the first frame of the animation does not fill the picture"));
    }

    let shape = (size.height, size.width, channels);
    let count = size.texels() * channels;
    let samples = match depth {
        BitDepth::Sixteen => wide(&mut reader, count).map(|words| Samples::U16(array(shape, words))),
        _ => frame(&mut reader, count).map(|bytes| Samples::U8(array(shape, bytes))),
    };
    let samples = samples.map_err(|error| source.broken(error))?;
    Ok((Raster::new(samples), color_notes(source.bytes).into_iter().collect()))
}

type DecodeResult<T> = std::result::Result<T, ::png::DecodingError>;

fn frame(reader: &mut Reader<Cursor<&[u8]>>, bytes: usize) -> DecodeResult<Vec<u8>> {
    let mut frame = vec![0; bytes];
    reader.next_frame(&mut frame)?;
    Ok(frame)
}

/// 16-bit samples from the file's big-endian bytes, row by row where the rows come in order.
fn wide(reader: &mut Reader<Cursor<&[u8]>>, count: usize) -> DecodeResult<Vec<u16>> {
    let word = |pair: &[u8]| u16::from_be_bytes([pair[0], pair[1]]);
    if reader.info().interlaced {
        return Ok(frame(reader, 2 * count)?.chunks_exact(2).map(word).collect());
    }
    let mut words = Vec::with_capacity(count);
    let mut row = vec![0; 2 * count / reader.info().height as usize];
    while reader.read_row(&mut row)?.is_some() {
        words.extend(row.chunks_exact(2).map(word));
    }
    Ok(words)
}

fn array<T>(shape: (usize, usize, usize), samples: Vec<T>) -> Array3<T> {
    Array3::from_shape_vec(shape, samples).expect("as many samples as the header says")
}

/// The chunks before the first image data: kind and content. Read from the bytes, so that damage does no harm.
fn chunks(bytes: &[u8]) -> impl Iterator<Item = ([u8; 4], &[u8])> {
    let mut rest = &bytes[8..];
    std::iter::from_fn(move || {
        let (head, tail) = rest.split_first_chunk::<8>()?;
        let [a, b, c, d, kind @ ..] = *head;
        let (data, tail) = tail.split_at_checked(u32::from_be_bytes([a, b, c, d]) as usize)?;
        // Past the checksum.
        rest = tail.get(4..).unwrap_or_default();
        (kind != *b"IDAT").then_some((kind, data))
    })
}

/// What the file says about its colours, which is not obeyed.
fn color_notes(bytes: &[u8]) -> Option<String> {
    let claim = |(kind, data): ([u8; 4], &[u8])| match (&kind, data) {
        (b"sRGB", _) => Some("is sRGB".to_owned()),
        (b"iCCP", _) => Some("has an ICC profile".to_owned()),
        (b"cICP", _) => Some("has a video colour space".to_owned()),
        (b"cHRM", _) => Some("has primaries of its own".to_owned()),
        (b"gAMA", &[a, b, c, d]) => {
            let gamma = u32::from_be_bytes([a, b, c, d]);
            (gamma != 100_000).then(|| format!("has a gamma of {}", f64::from(gamma) / 1e5))
        }
        _ => None,
    };
    let claims: Vec<_> = chunks(bytes).filter_map(claim).collect();
    (!claims.is_empty()).then(|| format!("PNG says its data {}{COLOUR_IGNORED}", claims.join(" and ")))
}

/// Whether [`write_png`] would give the picture the same header: 8 or 16 bit, no palette, not interlaced, one frame,
/// no transparent colour, and no claims about colour.
pub(super) fn is_plain(bytes: &[u8]) -> bool {
    let header = matches!(bytes.get(24..29), Some([8 | 16, 0 | 2 | 4 | 6, _, _, 0]));
    let extra = |kind: &[u8; 4]| matches!(kind, b"tRNS" | b"acTL" | b"gAMA");
    header && color_notes(bytes).is_none() && !chunks(bytes).any(|(kind, _)| extra(&kind))
}

/// Writes an 8- or 16-bit raster of 1 to 4 channels as PNG, compressed fast, without any statement about colour.
/// Rows are compressed as they go: besides the raster, memory holds a few of them.
///
/// # Errors
/// Whatever `out` returns; [`io::ErrorKind::Unsupported`] for float samples or more than 4 channels, which PNG cannot
/// hold.
pub fn write_png(out: impl Write, raster: &Raster) -> io::Result<()> {
    let color = match raster.samples.channels() {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        4 => ColorType::Rgba,
        n => return Err(io::Error::new(io::ErrorKind::Unsupported, format!("PNG cannot hold {n} channels"))),
    };
    match &raster.samples {
        Samples::U8(samples) => rows(out, raster, color, BitDepth::Eight, samples, |row, bytes| bytes.extend(row)),
        Samples::U16(samples) => rows(out, raster, color, BitDepth::Sixteen, samples, |row, bytes| {
            bytes.extend(row.iter().flat_map(|word| word.to_be_bytes()));
        }),
        Samples::F32(_) => Err(io::Error::new(io::ErrorKind::Unsupported, "PNG cannot hold float samples")),
    }
}

fn rows<T>(
    out: impl Write,
    raster: &Raster,
    color: ColorType,
    depth: BitDepth,
    samples: &Array3<T>,
    to_bytes: impl Fn(&[T], &mut Vec<u8>),
) -> io::Result<()> {
    let size = raster.size();
    let too_large = |_| io::Error::new(io::ErrorKind::Unsupported, format!("PNG cannot hold {size} texels"));
    let width = u32::try_from(size.width).map_err(too_large)?;
    let height = u32::try_from(size.height).map_err(too_large)?;
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    // The crate's default is forty times slower for a few per cent of size.
    encoder.set_compression(Compression::Fast);
    let mut header = encoder.write_header()?;
    let mut writer = header.stream_writer_with_size(CHUNK)?;
    let samples = samples.as_slice().expect("rasters are in standard layout");
    let mut bytes = Vec::new();
    for row in samples.chunks_exact(size.width * color.samples()) {
        bytes.clear();
        to_bytes(row, &mut bytes);
        writer.write_all(&bytes)?;
    }
    writer.finish()?;
    Ok(header.finish()?)
}
