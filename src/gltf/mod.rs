//! glTF 2.0 files as they are: the document, its buffers, numbers out of them. What meshes and materials make of that is
//! theirs.

mod accessor;
mod container;
mod document;
pub(crate) mod text;
mod words;

use std::path::Path;

pub(crate) use accessor::{Reader, Stored};
pub(crate) use container::{Buffers, beside, binary, open, parts};
pub(crate) use document::{Document, Material, Node, Primitive, Sampler, TextureInfo};
pub(crate) use words::{objects, parse};

use crate::error::{Error, Result};

/// Whether a file's first bytes are those of glTF, binary or text.
pub(crate) fn is_gltf(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    bytes.starts_with(b"glTF") || text.starts_with(b"{")
}

/// One of a list, by the index that another object gave.
pub(crate) fn item<'a, T>(path: &Path, list: &'a [T], index: usize, what: &str) -> Result<&'a T> {
    list.get(index).ok_or_else(|| {
        Error::invalid(path, format!("{what} {index} of {}", list.len()), format!("a {what} that exists"))
    })
}
