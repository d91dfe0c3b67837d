//! What goes in comes out, in every shape that a format offers.

use ::png::{BitDepth, ColorType, Encoder};
use ::tiff::encoder::{TiffEncoder, colortype};

use super::*;

#[test]
fn png_round_trips() {
    for (width, height) in [(1, 1), (1, 7), (13, 4), (300, 170)] {
        for channels in 1..=4 {
            let eight = Samples::U8(bytes_u8(width, height, channels));
            let sixteen = Samples::U16(bytes_u8(width, height, channels).mapv(|v| u16::from(v) * 251 + 3));
            for samples in [eight, sixteen] {
                let raster = read_bytes("a.png", &png_of(samples.clone())).unwrap().raster;
                assert_eq!(raster, Raster::new(samples));
            }
        }
    }
}

#[test]
fn png_refuses_what_it_cannot_hold() {
    let names = |n: usize| (0..n).map(|c| c.to_string()).collect();
    for samples in [Samples::F32(floats(2, 2, 3)), Samples::U8(bytes_u8(2, 2, 5))] {
        let raster = Raster { channels: names(samples.channels()), samples };
        let error = write_png(Vec::new(), &raster).unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::Unsupported);
    }
}

/// A 5x2 PNG of the given kind, from raw rows.
fn raw_png(color: ColorType, depth: BitDepth, rows: &[u8], edit: impl FnOnce(&mut Encoder<&mut Vec<u8>>)) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, 5, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    edit(&mut encoder);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(rows).unwrap();
    writer.finish().unwrap();
    bytes
}

fn u8s(bytes: &[u8]) -> (Vec<u8>, usize) {
    let Samples::U8(samples) = read_bytes("a.png", bytes).unwrap().raster.samples else { panic!("8 bit expected") };
    let channels = samples.dim().2;
    (samples.into_raw_vec_and_offset().0, channels)
}

#[test]
fn png_expands_few_bits_and_palettes() {
    let bits = raw_png(ColorType::Grayscale, BitDepth::One, &[0b1011_0000, 0b0100_1000], |_| {});
    assert_eq!(u8s(&bits), (vec![255, 0, 255, 255, 0, 0, 255, 0, 0, 255], 1));

    let two = raw_png(ColorType::Grayscale, BitDepth::Two, &[0b00_01_10_11, 0, 0b11_11_11_11, 0], |_| {});
    assert_eq!(u8s(&two), (vec![0, 85, 170, 255, 0, 255, 255, 255, 255, 0], 1));

    let palette = |alpha: Option<&'static [u8]>| {
        raw_png(ColorType::Indexed, BitDepth::Four, &[0x01, 0x21, 0x00, 0x00, 0x00, 0x20], |encoder| {
            encoder.set_palette(&[1, 2, 3, 10, 20, 30, 100, 150, 200][..]);
            alpha.into_iter().for_each(|alpha| encoder.set_trns(alpha));
        })
    };
    let (rgb, channels) = u8s(&palette(None));
    assert_eq!((channels, &rgb[..9]), (3, &[1, 2, 3, 10, 20, 30, 100, 150, 200][..]));
    let (rgba, channels) = u8s(&palette(Some(&[9])));
    assert_eq!((channels, &rgba[..8]), (4, &[1, 2, 3, 9, 10, 20, 30, 255][..]));
}

#[test]
fn png_makes_transparent_gray_an_alpha_channel() {
    let rows: Vec<u8> = (0..10).flat_map(|i| [0, i]).collect();
    let bytes = raw_png(ColorType::Grayscale, BitDepth::Sixteen, &rows, |encoder| encoder.set_trns(&[0, 3][..]));
    let Samples::U16(samples) = read_bytes("a.png", &bytes).unwrap().raster.samples else { panic!("16 bit expected") };
    assert_eq!(samples.dim(), (2, 5, 2));
    assert_eq!((samples[[0, 2, 1]], samples[[0, 3, 0]], samples[[0, 3, 1]]), (65535, 3, 0));
}

#[test]
fn png_reports_colour_claims_and_keeps_the_data() {
    let plain = raw_png(ColorType::Grayscale, BitDepth::Eight, &[7; 10], |encoder| {
        encoder.set_source_gamma(::png::ScaledFloat::new(1.0));
    });
    assert!(read_bytes("a.png", &plain).unwrap().notes.is_empty());
    let gamma = raw_png(ColorType::Grayscale, BitDepth::Eight, &[7; 10], |encoder| {
        encoder.set_source_gamma(::png::ScaledFloat::new(0.45455));
    });
    let decoded = read_bytes("a.png", &gamma).unwrap();
    assert_eq!(decoded.notes, ["PNG says its data has a gamma of 0.45455: ignored, data is taken as linear"]);
    assert_eq!(decoded.raster.samples, Samples::U8(Array3::from_elem((2, 5, 1), 7)));
    let srgb = raw_png(ColorType::Grayscale, BitDepth::Eight, &[7; 10], |encoder| {
        encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    });
    assert!(read_bytes("a.png", &srgb).unwrap().notes[0].starts_with("PNG says its data is sRGB"));
}

/// Gray, 4x3, 8 bit (`10 * y + x`) and 16 bit (256 times that, plus 1), in the passes of Adam7.
#[test]
fn png_reads_interlaced_files() {
    for (name, wide) in [("8", false), ("16", true)] {
        let mut raw = Vec::new();
        // Adam7 passes of a 4x3 picture: (first row, row step, first column, column step).
        for (y0, dy, x0, dx) in
            [(0, 8, 0, 8), (0, 8, 4, 8), (4, 8, 0, 4), (0, 4, 2, 4), (2, 4, 0, 2), (0, 2, 1, 2), (1, 2, 0, 1)]
        {
            for y in (y0..3).step_by(dy).filter(|_| x0 < 4) {
                raw.push(0);
                for x in (x0..4).step_by(dx) {
                    raw.push((10 * y + x) as u8);
                    raw.extend(wide.then_some(1));
                }
            }
        }
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, 4, 3);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(if wide { BitDepth::Sixteen } else { BitDepth::Eight });
        let mut writer = encoder.write_header().unwrap();
        writer.write_chunk(::png::chunk::IDAT, &stored_zlib(&raw)).unwrap();
        drop(writer);
        // The encoder makes none itself: set the flag in the header and its checksum.
        bytes[28] = 1;
        let crc = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        let raster = read_bytes("a.png", &bytes).unwrap().raster;
        let expected = |y: usize, x: usize| 10 * y + x;
        match raster.samples {
            Samples::U8(s) => assert_eq!(s, Array3::from_shape_fn((3, 4, 1), |(y, x, _)| expected(y, x) as u8)),
            Samples::U16(s) => {
                assert_eq!(s, Array3::from_shape_fn((3, 4, 1), |(y, x, _)| 256 * expected(y, x) as u16 + 1));
            }
            Samples::F32(_) => panic!("{name} bit"),
        }
    }
}

/// A zlib stream of one stored block.
fn stored_zlib(raw: &[u8]) -> Vec<u8> {
    let length = raw.len() as u16;
    let (a, b) =
        raw.iter().fold((1u32, 0u32), |(a, b), &v| ((a + u32::from(v)) % 65521, (b + a + u32::from(v)) % 65521));
    let mut out = vec![0x78, 0x01, 1];
    out.extend(length.to_le_bytes());
    out.extend((!length).to_le_bytes());
    out.extend(raw);
    out.extend((b << 16 | a).to_be_bytes());
    out
}

/// The checksum of PNG chunks, bit by bit.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

#[test]
fn lossless_pictures_come_back() {
    let expected = Raster::new(Samples::U8(bytes_u8(9, 7, 3)));
    for (name, bytes) in samples_of_all_formats() {
        let raster = read_bytes(name, &bytes).unwrap().raster;
        match name {
            "a.hdr" => {
                assert_eq!((raster.at(5, 0, 0), raster.at(5, 0, 1), raster.at(8, 6, 2)), (5.0, 0.5, 1.0));
            }
            "a.exr" => assert_eq!(raster.at(5, 4, 1), 10.0),
            // Lossy: only the shape is certain.
            "a.jpg" => assert_eq!(raster.channels, expected.channels),
            // These have no three channels: an alpha of 1 makes four.
            "a.ktx2" | "a.dds" => {
                let three = bytes_u8(9, 7, 3);
                let four = Array3::from_shape_fn((7, 9, 4), |(y, x, c)| if c == 3 { 255 } else { three[(y, x, c)] });
                assert_eq!(raster, Raster::new(Samples::U8(four)), "{name}");
            }
            _ => assert_eq!(raster, expected, "{name}"),
        }
    }
}

#[test]
fn tiff_reads_deep_samples() {
    fn tiff<C: colortype::ColorType>(data: &[C::Inner]) -> Samples
    where
        [C::Inner]: ::tiff::encoder::TiffValue,
    {
        let mut out = Cursor::new(Vec::new());
        TiffEncoder::new(&mut out).unwrap().write_image::<C>(3, 2, data).unwrap();
        read_bytes("a.tif", out.get_ref()).unwrap().raster.samples
    }
    let words: Vec<u16> = (0..18).map(|i| i * 3001).collect();
    let gray: Vec<f32> = (0..6).map(|i| i as f32 - 2.5).collect();
    let rgb: Vec<f32> = (0..18).map(|i| i as f32 * 0.37).collect();
    assert_eq!(
        tiff::<colortype::RGB16>(&words),
        Samples::U16(Array3::from_shape_vec((2, 3, 3), words.clone()).unwrap())
    );
    assert_eq!(
        tiff::<colortype::Gray32Float>(&gray),
        Samples::F32(Array3::from_shape_vec((2, 3, 1), gray.clone()).unwrap())
    );
    assert_eq!(
        tiff::<colortype::RGB32Float>(&rgb),
        Samples::F32(Array3::from_shape_vec((2, 3, 3), rgb.clone()).unwrap())
    );
}
