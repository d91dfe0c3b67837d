//! Bytes to images and back. Knows formats, not meaning: samples come out as the file holds them, never converted
//! between colour spaces, never rotated.
//!
//! | format | told by | samples |
//! |---|---|---|
//! | PNG | content | 8, 16 bit; palettes, 1, 2 and 4 bit and transparent colours are expanded |
//! | JPEG | content | 8 bit gray or RGB |
//! | TIFF | content | 8, 16 bit, half, float, double; gray, RGB, with or without alpha |
//! | TGA | the extension, for it has no magic number | 8 bit |
//! | BMP, WebP | content | 8 bit |
//! | Radiance HDR | content | float |
//! | OpenEXR | content | half, float, unsigned integer; any channels, any data window |
//! | KTX 2 | content | 8, 16 bit, half, float, BC1, BC3, BC4, BC5, BC7, UASTC; with Zstandard or zlib |
//! | DDS | content | the same but UASTC, with the DX10 header or the older one; masks of whole bytes |

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::error::{Error, Result};
use crate::image::{Raster, Size};

mod apng;
pub mod exr;
mod pictures;
pub mod png;
pub mod texture;
mod tiff;

#[cfg(test)]
mod tests;

pub use apng::write_apng;
pub use exr::{Channel, Depth, read_exr_levels, write_exr, write_exr_covering};
pub use png::write_png;

/// How the note ends that a file's claims about colour were not obeyed.
pub(crate) const COLOUR_IGNORED: &str = ": ignored, data is taken as linear";

/// The most texels that a picture may have: 32768 x 32768.
pub const MAX_TEXELS: u64 = 1 << 30;

/// A picture as its file holds it.
#[derive(Clone, Debug)]
pub struct Decoded {
    /// The samples.
    pub raster: Raster,
    /// The format found, by its usual name: `PNG`, `JPEG`, `OpenEXR`.
    pub format: &'static str,
    /// What the file says about itself and was not obeyed, in plain words: colour spaces, orientation, further layers.
    pub notes: Vec<String>,
    /// SHA-256 of the file, 64 lower-case hexadecimal digits.
    pub sha256: String,
    /// Length of the file in bytes.
    pub bytes_len: usize,
    /// The file itself, if it is a PNG with the header that [`write_png`] would give it and without claims about
    /// colour: it can be passed on byte for byte.
    pub plain_png: Option<Arc<[u8]>>,
}

/// Reads a picture. The format is told by the content, whatever the file is called; TGA, which has no magic number,
/// by its extension.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Invalid`] if it is not a picture, is cut short or damaged, or
/// claims more texels than its length can hold; [`Error::Unsupported`] if it has more than [`MAX_TEXELS`] or uses a part
/// of its format that is not read here.
pub fn read(path: &Path) -> Result<Decoded> {
    decode(path, file(path)?)
}

/// Decodes the bytes of a picture; `path` is for messages, and its extension tells TGA.
///
/// # Errors
/// As [`read`].
pub fn decode(path: &Path, bytes: Vec<u8>) -> Result<Decoded> {
    Ok(decode_levels(path, bytes, 1)?.swap_remove(0))
}

/// Reads every level of a mip-mapped OpenEXR, KTX 2 or DDS file, largest first; the one picture of any other file.
/// Channels are in the same order as [`read`] gives them.
///
/// # Errors
/// As [`read`].
pub fn read_levels(path: &Path) -> Result<Vec<Decoded>> {
    decode_levels(path, file(path)?, usize::MAX)
}

fn decode_levels(path: &Path, bytes: Vec<u8>, count: usize) -> Result<Vec<Decoded>> {
    let format = Format::of(path, &bytes)?;
    let source = Source { path, bytes: &bytes, format };
    let one = |(raster, notes)| (vec![raster], notes);
    let (rasters, notes) = source.guard(|| match format {
        Format::Png => png::decode(&source).map(one),
        Format::Exr => exr::decode(&source, count),
        Format::Ktx2 => texture::decode_ktx2(&source, count),
        Format::Dds => texture::decode_dds(&source, count),
        Format::Tiff => tiff::decode(&source).map(one),
        _ => pictures::decode(&source).map(one),
    })?;
    let sha256 = sha256(&bytes);
    let (bytes_len, plain) = (bytes.len(), format == Format::Png && png::is_plain(&bytes));
    let plain_png: Option<Arc<[u8]>> = plain.then(|| bytes.into());
    let decoded = |raster| Decoded {
        raster,
        format: format.name(),
        notes: notes.clone(),
        sha256: sha256.clone(),
        bytes_len,
        plain_png: plain_png.clone(),
    };
    Ok(rasters.into_iter().map(decoded).collect())
}

/// SHA-256 of bytes, 64 lower-case hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    format!("{:x}", Sha256::digest(bytes))
}

fn file(path: &Path) -> Result<Vec<u8>> {
    read_file(path, "a picture file", u64::MAX)
}

/// A whole file, unless it is longer than `most` bytes; not a folder, and nothing that never ends.
pub(crate) fn read_file(path: &Path, expected: &str, most: u64) -> Result<Vec<u8>> {
    let there = path.metadata().map_err(|error| Error::io(path, error))?;
    if !there.is_file() {
        let found = if there.is_dir() { "a folder" } else { "something that is not a file" };
        return Err(Error::invalid(path, found, expected));
    }
    if there.len() > most {
        let found = format!("a file of {} bytes", there.len());
        return Err(Error::unsupported(path, found, format!("up to {most} bytes here")));
    }
    std::fs::read(path).map_err(|error| Error::io(path, error))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Jpeg,
    Tiff,
    Tga,
    Bmp,
    WebP,
    Hdr,
    Exr,
    Ktx2,
    Dds,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Format::Png => "PNG",
            Format::Jpeg => "JPEG",
            Format::Tiff => "TIFF",
            Format::Tga => "TGA",
            Format::Bmp => "BMP",
            Format::WebP => "WebP",
            Format::Hdr => "Radiance HDR",
            Format::Exr => "OpenEXR",
            Format::Ktx2 => "KTX 2",
            Format::Dds => "DDS",
        }
    }

    fn of(path: &Path, bytes: &[u8]) -> Result<Self> {
        Ok(match bytes {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Format::Png,
            [0xff, 0xd8, 0xff, ..] => Format::Jpeg,
            // 42 is TIFF, 43 its 64-bit variety.
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Format::Tiff,
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Format::WebP,
            [0x76, 0x2f, 0x31, 0x01, ..] => Format::Exr,
            _ if bytes.starts_with(b"\xabKTX 20\xbb\r\n\x1a\n") => Format::Ktx2,
            [b'D', b'D', b'S', b' ', ..] => Format::Dds,
            _ if bytes.starts_with(b"#?RADIANCE") || bytes.starts_with(b"#?RGBE") => Format::Hdr,
            _ if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tga")) && !bytes.is_empty() => Format::Tga,
            [b'B', b'M', ..] => Format::Bmp,
            _ => {
                let known = "PNG, JPEG, TIFF, TGA, BMP, WebP, HDR, EXR, KTX 2 or DDS data";
                return Err(Error::invalid(path, unknown(bytes), known));
            }
        })
    }
}

/// What a file that is no picture of ours seems to be.
fn unknown(bytes: &[u8]) -> String {
    let known: [(&[u8], &str); 5] = [
        (b"GIF8", "a GIF picture"),
        (b"\xabKTX 1", "a texture of KTX 1"),
        (b"8BPS", "a Photoshop document"),
        (b"glTF", "a GLB scene"),
        (b"PK\x03\x04", "a ZIP archive"),
    ];
    if let Some((_, name)) = known.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return (*name).to_owned();
    }
    let start = &bytes[..bytes.len().min(64)];
    match start {
        [] => "an empty file".to_owned(),
        _ if start.is_ascii() && !start.contains(&0) => "a text file".to_owned(),
        _ => format!("data of an unknown kind, starting with bytes {:02x?}", &start[..start.len().min(4)]),
    }
}

/// A file's bytes, and its errors: each names the file and its format.
struct Source<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    format: Format,
}

impl Source<'_> {
    /// The decoder gave up: the file is damaged or cut short.
    fn broken(&self, why: impl std::fmt::Display) -> Error {
        let name = self.format.name();
        Error::invalid(
            self.path,
            format!("{name} data that cannot be decoded ({why})"),
            format!("a whole and undamaged {name} file"),
        )
    }

    /// The file is fine but beyond us.
    fn unsupported(&self, found: impl std::fmt::Display, supported: &str) -> Error {
        Error::unsupported(self.path, format!("{} with {found}", self.format.name()), supported)
    }

    /// Checks the sides that a header claims.
    fn size(&self, width: u64, height: u64) -> Result<Size> {
        if width == 0 || height == 0 {
            return Err(Error::invalid(self.path, format!("a size of {width}x{height}"), "sides of at least 1 texel"));
        }
        if width.checked_mul(height).is_none_or(|texels| texels > MAX_TEXELS) {
            return Err(self.unsupported(
                format!("{width}x{height} texels"),
                &format!("up to {MAX_TEXELS} texels (2^30, as 32768x32768)"),
            ));
        }
        Ok(Size::new(width as usize, height as usize))
    }

    /// Checks that a file this long can hold `needed` bytes if each of its bytes stands for up to `ratio` of them, and
    /// so protects against small files that claim to be huge.
    fn holds(&self, needed: u64, ratio: u64) -> Result<()> {
        let length = self.bytes.len() as u64;
        if needed > length.saturating_mul(ratio) {
            return Err(Error::invalid(
                self.path,
                format!(
                    "a truncated or hostile {} file: {length} bytes for {needed} bytes of texels",
                    self.format.name()
                ),
                format!("at least {} bytes", needed.div_ceil(ratio)),
            ));
        }
        Ok(())
    }

    /// Checks that there is memory for the samples: a failed allocation would end the process.
    fn memory(&self, size: Size, bytes_per_texel: usize) -> Result<()> {
        let bytes = size.texels().saturating_mul(bytes_per_texel);
        // Reserved and given back untouched: costs nothing.
        Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| {
            self.unsupported(format!("{size} texels of {bytes_per_texel} bytes"), "what fits in this machine's memory")
        })
    }

    /// Runs a decoder: a panic inside the crates that decode is an error about the file.
    fn guard<T>(&self, decode: impl FnOnce() -> Result<T>) -> Result<T> {
        catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err(self.broken("the decoder failed on it")))
    }
}
