//! Pictures as files, by format and then by what is wrong with them.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use ndarray::Array3;

use super::*;
use crate::image::{Samples, Wrap};

mod formats;
mod hostile;
mod textures;

/// A folder that goes away with its files.
pub(super) struct Files(tempfile::TempDir);

impl Files {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

pub(super) fn bytes_u8(width: usize, height: usize, channels: usize) -> Array3<u8> {
    Array3::from_shape_fn((height, width, channels), |(y, x, c)| (7 * x + 31 * y + 85 * c + x * y) as u8)
}

pub(super) fn floats(width: usize, height: usize, channels: usize) -> Array3<f32> {
    Array3::from_shape_fn((height, width, channels), |(y, x, c)| x as f32 - 0.5 * y as f32 + 100.0 * c as f32)
}

pub(super) fn read_bytes(name: &str, bytes: &[u8]) -> Result<Decoded> {
    let files = Files::new();
    read(&files.write(name, bytes))
}

pub(super) fn png_of(samples: Samples) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_png(&mut bytes, &Raster::new(samples)).unwrap();
    bytes
}

pub(super) fn exr_of(
    size: Size,
    channels: &[(&str, Depth)],
    value: impl Fn(usize, usize, usize, usize) -> f32 + Sync,
) -> Vec<u8> {
    let channels: Vec<_> =
        channels.iter().map(|(name, depth)| Channel { name: (*name).to_owned(), depth: *depth }).collect();
    let mut out = Cursor::new(Vec::new());
    write_exr(&mut out, &channels, size, Wrap::Repeat, &|level, channel, y, x, out| {
        out.iter_mut().enumerate().for_each(|(i, out)| *out = value(level, channel, y, x + i));
    })
    .unwrap();
    out.into_inner()
}

/// One small valid file of each format, its name first.
pub(super) fn samples_of_all_formats() -> Vec<(&'static str, Vec<u8>)> {
    let rgb = bytes_u8(9, 7, 3);
    let with = |format| {
        let mut out = Cursor::new(Vec::new());
        let picture = ::image::RgbImage::from_raw(9, 7, rgb.as_slice().unwrap().to_vec()).unwrap();
        picture.write_to(&mut out, format).unwrap();
        out.into_inner()
    };
    let hdr = {
        let mut out = Vec::new();
        let pixels: Vec<_> = (0..63).map(|i| ::image::Rgb([i as f32, 0.5, 1.0])).collect();
        ::image::codecs::hdr::HdrEncoder::new(&mut out).encode(&pixels, 9, 7).unwrap();
        out
    };
    let tiff = {
        let mut out = Cursor::new(Vec::new());
        let mut encoder = ::tiff::encoder::TiffEncoder::new(&mut out).unwrap();
        encoder.write_image::<::tiff::encoder::colortype::RGB8>(9, 7, rgb.as_slice().unwrap()).unwrap();
        out.into_inner()
    };
    let texture = {
        let raster = Raster::new(Samples::U8(rgb.clone()));
        texture::Texture::encode(&[raster], texture::TexelFormat::Rgba8, texture::Effort::Fast)
    };
    let (mut ktx2, mut dds) = (Vec::new(), Vec::new());
    texture::write_ktx2(&mut ktx2, &texture, Some(texture::Effort::Fast)).unwrap();
    texture::write_dds(&mut dds, &texture).unwrap();
    vec![
        ("a.png", png_of(Samples::U8(rgb.clone()))),
        ("a.jpg", with(::image::ImageFormat::Jpeg)),
        ("a.tga", with(::image::ImageFormat::Tga)),
        ("a.bmp", with(::image::ImageFormat::Bmp)),
        ("a.webp", with(::image::ImageFormat::WebP)),
        ("a.hdr", hdr),
        ("a.tif", tiff),
        ("a.exr", exr_of(Size::new(9, 7), &[("R", Depth::Half), ("G", Depth::Float)], |_, c, y, x| (c + y + x) as f32)),
        ("a.ktx2", ktx2),
        ("a.dds", dds),
    ]
}

#[test]
fn tells_formats_by_content() {
    let names = samples_of_all_formats().into_iter().map(|(name, bytes)| {
        // Only TGA needs its extension.
        let decoded = read_bytes(if name == "a.tga" { "a.TGA" } else { "misnamed.jpeg" }, &bytes).unwrap();
        assert_eq!(decoded.raster.size(), Size::new(9, 7), "{name}");
        assert_eq!(decoded.bytes_len, bytes.len());
        decoded.format
    });
    let expected = ["PNG", "JPEG", "TGA", "BMP", "WebP", "Radiance HDR", "TIFF", "OpenEXR", "KTX 2", "DDS"];
    assert_eq!(names.collect::<Vec<_>>(), expected);
}

#[test]
fn fingerprints_the_file() {
    let decoded = read_bytes("a.png", &png_of(Samples::U8(bytes_u8(2, 2, 1)))).unwrap();
    assert_eq!(decoded.sha256.len(), 64);
    assert!(decoded.sha256.bytes().all(|b| b.is_ascii_hexdigit() && !b.is_ascii_uppercase()));
    assert!(decoded.notes.is_empty());
}

pub(super) fn message(result: Result<Decoded>) -> String {
    result.map(|decoded| format!("{} of {}", decoded.format, decoded.raster.size())).unwrap_err().to_string()
}

pub(super) fn is_about(message: &str, path: &Path) -> bool {
    message.starts_with(&path.display().to_string())
}
