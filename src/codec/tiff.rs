//! TIFF, by the `tiff` crate: baseline and BigTIFF, strips and tiles, interleaved and planar.

use std::io::Cursor;

use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::tags::Tag;
use ::tiff::{ColorType, TiffError};
use ndarray::Array3;

use super::{COLOUR_IGNORED, Source};
use crate::error::{Error, Result};
use crate::image::{Raster, Samples};

const SUPPORTED: &str = "gray, gray and alpha, RGB or RGBA of 8 or 16 bit, half, float or double";

/// A byte of LZW data, the densest of TIFF's compressions for whole bytes, stands for fewer than this many.
const DENSEST: u64 = 4096;

pub(super) fn decode(source: &Source) -> Result<(Raster, Vec<String>)> {
    let fail = |error| failure(source, error);
    let mut decoder = Decoder::new(Cursor::new(source.bytes)).map_err(fail)?.with_limits(Limits::unlimited());
    let (width, height) = decoder.dimensions().map_err(fail)?;
    let size = source.size(width.into(), height.into())?;

    let color = decoder.colortype().map_err(fail)?;
    let channels = match color {
        ColorType::Gray(8..) => 1,
        // Gray and one extra sample.
        ColorType::GrayA(8..) | ColorType::Multiband { bit_depth: 8.., num_samples: 2 } => 2,
        ColorType::RGB(8..) => 3,
        ColorType::RGBA(8..) => 4,
        other => return Err(source.unsupported(format!("{other:?} samples"), SUPPORTED)),
    };
    let layout = decoder.image_buffer_layout().map_err(fail)?;
    let compression = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(fail)?;
    source.holds(layout.complete_len as u64, if matches!(compression, None | Some(1)) { 1 } else { DENSEST })?;
    source.memory(size, layout.complete_len / size.texels())?;

    let mut data = DecodingResult::U8(Vec::new());
    decoder.read_image_to_buffer(&mut data).map_err(fail)?;
    let shape = Shape { dim: (size.height, size.width, channels), planar: layout.planes > 1 };
    let samples = match data {
        DecodingResult::U8(v) => shape.array(v).map(Samples::U8),
        DecodingResult::U16(v) => shape.array(v).map(Samples::U16),
        DecodingResult::F16(v) => shape.array(v.into_iter().map(f32::from).collect()).map(Samples::F32),
        DecodingResult::F32(v) => shape.array(v).map(Samples::F32),
        DecodingResult::F64(v) => shape.array(v.into_iter().map(|x| x as f32).collect()).map(Samples::F32),
        _ => return Err(source.unsupported("integers that are signed or longer than 16 bit", SUPPORTED)),
    };
    // Gray pictures may carry further samples that the colour type does not tell.
    let samples =
        samples.ok_or_else(|| source.unsupported("a number of samples that its colours do not explain", SUPPORTED))?;

    let mut notes = Vec::new();
    if let Ok(Some(orientation @ 2..)) = decoder.find_tag_unsigned::<u16>(Tag::Orientation) {
        notes.push(format!("TIFF asks to be turned or mirrored (orientation {orientation}): ignored"));
    }
    if matches!(decoder.find_tag(Tag::IccProfile), Ok(Some(_))) {
        notes.push(format!("TIFF says its data has an ICC profile{COLOUR_IGNORED}"));
    }
    if decoder.more_images() {
        notes.push("TIFF has several pictures: the first is read".to_owned());
    }
    Ok((Raster::new(samples), notes))
}

struct Shape {
    dim: (usize, usize, usize),
    planar: bool,
}

impl Shape {
    fn array<T: Clone>(&self, samples: Vec<T>) -> Option<Array3<T>> {
        let (height, width, channels) = self.dim;
        if !self.planar {
            return Array3::from_shape_vec(self.dim, samples).ok();
        }
        let planes = Array3::from_shape_vec((channels, height, width), samples).ok()?;
        Some(planes.permuted_axes([1, 2, 0]).as_standard_layout().into_owned())
    }
}

fn failure(source: &Source, error: TiffError) -> Error {
    match error {
        TiffError::UnsupportedError(what) => source.unsupported(what, SUPPORTED),
        other => source.broken(other),
    }
}
