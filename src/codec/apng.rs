//! Animated PNG, for people to look at.

use std::io::{self, Write};

use ::png::{BitDepth, ColorType, Compression, Encoder};

use crate::image::{Raster, Samples};

/// Writes 8-bit RGB rasters of one size as an animated PNG, each shown for so many milliseconds, `plays` times over (0
/// for ever). Programs that do not know animations show the first frame.
///
/// # Errors
/// Whatever `out` returns; [`io::ErrorKind::InvalidInput`] for no frames or for frames of unequal sizes, and
/// [`io::ErrorKind::Unsupported`] for samples that are not 8-bit RGB.
pub fn write_apng(out: impl Write, frames: &[Raster], milliseconds_per_frame: u16, plays: u32) -> io::Result<()> {
    let invalid = |what: String| io::Error::new(io::ErrorKind::InvalidInput, what);
    let unsupported = |what: String| io::Error::new(io::ErrorKind::Unsupported, what);
    // Everything is checked before the first byte is written.
    let first = frames.first().ok_or_else(|| invalid("an animation needs at least one frame".into()))?;
    let size = first.size();
    let mut pixels = Vec::with_capacity(frames.len());
    for (k, frame) in frames.iter().enumerate() {
        if frame.size() != size {
            return Err(invalid(format!("frame {k} is {}, expected {size} as frame 0", frame.size())));
        }
        match &frame.samples {
            Samples::U8(samples) if frame.samples.channels() == 3 => {
                pixels.push(samples.as_slice().expect("rasters are in standard layout"));
            }
            samples => {
                let (bits, channels) = (frame.bits(), samples.channels());
                return Err(unsupported(format!(
                    "frame {k} has {channels} channels of {bits} bit, expected 8-bit RGB"
                )));
            }
        }
    }
    let too_large = |_| unsupported(format!("PNG cannot hold {size} texels"));
    let width = u32::try_from(size.width).map_err(too_large)?;
    let height = u32::try_from(size.height).map_err(too_large)?;
    let count = u32::try_from(frames.len()).map_err(|_| unsupported(format!("{} frames", frames.len())))?;
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_animated(count, plays)?;
    encoder.set_frame_delay(milliseconds_per_frame, 1000)?;
    let mut writer = encoder.write_header()?;
    for frame in pixels {
        writer.write_image_data(frame)?;
    }
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::png::Decoder;
    use ndarray::Array3;
    use std::io::Cursor;

    fn frame(k: usize, width: usize) -> Raster {
        Raster::new(Samples::U8(Array3::from_shape_fn((5, width, 3), |(y, x, c)| (40 * k + 7 * y + 3 * x + c) as u8)))
    }

    #[test]
    fn every_frame_comes_back() {
        let frames: Vec<Raster> = (0..4).map(|k| frame(k, 9)).collect();
        let mut bytes = Vec::new();
        write_apng(&mut bytes, &frames, 80, 3).unwrap();
        let mut reader = Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (4, 3));
        for frame in &frames {
            let mut pixels = vec![0; 5 * 9 * 3];
            reader.next_frame(&mut pixels).unwrap();
            let control = reader.info().frame_control.unwrap();
            assert_eq!((control.delay_num, control.delay_den), (80, 1000));
            let Samples::U8(expected) = &frame.samples else { unreachable!() };
            assert_eq!(pixels, expected.as_slice().unwrap());
        }
        // Our own reader sees the first frame, and does not take the file for one that can be passed on.
        let decoded = crate::codec::decode("a.png".as_ref(), bytes).unwrap();
        assert_eq!(decoded.raster, frames[0]);
        assert!(decoded.plain_png.is_none());
    }

    #[test]
    fn wrong_frames_are_refused_before_anything_is_written() {
        let kind = |frames: &[Raster]| {
            let mut bytes = Vec::new();
            let error = write_apng(&mut bytes, frames, 80, 0).unwrap_err();
            assert!(bytes.is_empty());
            (error.kind(), error.to_string())
        };
        use io::ErrorKind::{InvalidInput, Unsupported};
        assert_eq!(kind(&[]), (InvalidInput, "an animation needs at least one frame".into()));
        assert_eq!(kind(&[frame(0, 9), frame(1, 8)]), (InvalidInput, "frame 1 is 8x5, expected 9x5 as frame 0".into()));
        let gray = Raster::new(Samples::U8(Array3::zeros((5, 9, 1))));
        assert_eq!(kind(&[frame(0, 9), gray]).0, Unsupported);
        let float = Raster::new(Samples::F32(Array3::zeros((5, 9, 3))));
        assert_eq!(kind(&[float]).0, Unsupported);
    }
}
