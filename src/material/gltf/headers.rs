//! The sizes of pictures by their headers: what a model is known by before anything is decoded.

use crate::image::Size;

/// The size that a PNG, JPEG or WebP picture claims; nothing of other data.
pub(super) fn size(bytes: &[u8]) -> Option<Size> {
    let (width, height) = if bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.get(12..16)? == b"IHDR" {
        (number(bytes, 16, 4, true)?, number(bytes, 20, 4, true)?)
    } else if bytes.starts_with(b"\xff\xd8") {
        jpeg(bytes)?
    } else if bytes.starts_with(b"RIFF") && bytes.get(8..12)? == b"WEBP" {
        webp(bytes)?
    } else {
        return None;
    };
    (width > 0 && height > 0).then(|| Size::new(width, height))
}

/// Up to 4 bytes as one number.
fn number(bytes: &[u8], at: usize, length: usize, big_endian: bool) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(length)?)?.iter();
    let add = |sum: usize, byte: &u8| sum << 8 | usize::from(*byte);
    Some(if big_endian { bytes.fold(0, add) } else { bytes.rev().fold(0, add) })
}

/// From the first frame header (ITU T.81, B.2.2).
fn jpeg(bytes: &[u8]) -> Option<(usize, usize)> {
    let mut at = 2;
    loop {
        match (bytes.get(at)?, bytes.get(at + 1)?) {
            (0xff, 0xff) => at += 1,
            (0xff, 0xc4 | 0xc8 | 0xcc) => at += 2 + number(bytes, at + 2, 2, true)?,
            (0xff, 0xc0..=0xcf) => return Some((number(bytes, at + 7, 2, true)?, number(bytes, at + 5, 2, true)?)),
            (0xff, _) => at += 2 + number(bytes, at + 2, 2, true)?,
            _ => return None,
        }
    }
}

/// From the first chunk (RFC 9649, 2.4 to 2.7).
fn webp(bytes: &[u8]) -> Option<(usize, usize)> {
    let little = |at, length| number(bytes, at, length, false);
    match bytes.get(12..16)? {
        b"VP8X" => Some((1 + little(24, 3)?, 1 + little(27, 3)?)),
        b"VP8L" if bytes.get(20)? == &0x2f => {
            little(21, 4).map(|sides| (1 + (sides & 0x3fff), 1 + (sides >> 14 & 0x3fff)))
        }
        b"VP8 " if bytes.get(23..26)? == b"\x9d\x01\x2a" => Some((little(26, 2)? & 0x3fff, little(28, 2)? & 0x3fff)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use image::codecs::{jpeg::JpegEncoder, webp::WebPEncoder};
    use image::{ExtendedColorType, ImageEncoder};
    use ndarray::Array3;

    use super::*;
    use crate::codec::write_png;
    use crate::image::{Raster, Samples};

    #[test]
    fn headers_tell_sizes() {
        let (width, height) = (300, 77);
        let texels = vec![9; width * height * 3];
        let array = Array3::from_shape_vec((height, width, 3), texels.clone()).unwrap();
        let (mut png, mut jpeg, mut webp) = (Vec::new(), Vec::new(), Vec::new());
        write_png(&mut png, &Raster::new(Samples::U8(array))).unwrap();
        let rgb = ExtendedColorType::Rgb8;
        JpegEncoder::new(&mut jpeg).write_image(&texels, width as u32, height as u32, rgb).unwrap();
        WebPEncoder::new_lossless(&mut webp).write_image(&texels, width as u32, height as u32, rgb).unwrap();
        for bytes in [&png, &jpeg, &webp] {
            assert_eq!(size(bytes), Some(Size::new(width, height)));
            // Of what is cut short nothing is said, and nothing panics.
            for length in 0..bytes.len().min(200) {
                assert!(size(&bytes[..length]).is_none_or(|size| size == Size::new(width, height)));
            }
        }
        assert_eq!(size(b"RIFF....WEBPVP8X\x0a\0\0\0\x10\0\0\0\x2b\x01\0\x4c\0\0"), Some(Size::new(300, 77)));
        assert_eq!(size(b"RIFF....WEBPVP8 \x0a\0\0\0...\x9d\x01\x2a\x2c\x41\x4d\x80"), Some(Size::new(300, 77)));
        assert_eq!(size(b"GIF89a, which is none of them"), None);
        // Not all that begins like a picture is one, and no side is 0.
        png[12..16].copy_from_slice(b"CgBI");
        assert_eq!(size(&png), None);
        png[12..16].copy_from_slice(b"IHDR");
        png[16..20].fill(0);
        assert_eq!(size(&png), None);
        assert_eq!(size(b"RIFF....AVI VP8X\x0a\0\0\0\x10\0\0\0\x2b\x01\0\x4c\0\0"), None);
    }
}
