//! Numbers out of buffers (glTF 2.0, 3.6.2). Nothing is allocated before its bytes are known to be there.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::container::{Buffers, beside, inline};
use super::document::{Accessor, Document};
use super::item;
use crate::error::{Error, Result};

/// A file's accessors.
pub(crate) struct Reader<'a, 'f> {
    pub path: &'a Path,
    pub document: &'a Document,
    pub buffers: &'a Buffers<'f>,
}

/// Where the bytes of an image are.
pub(crate) enum Stored<'a> {
    /// In a buffer or in the JSON.
    Inside(Cow<'a, [u8]>),
    /// In a file beside the model.
    File(PathBuf),
}

/// The elements of an accessor, N numbers each, `stride` bytes apart: known to be there, and not yet copied.
pub(crate) struct Elements<'a, const N: usize> {
    bytes: &'a [u8],
    stride: usize,
    pub count: usize,
    component: Component,
    normalized: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }
}

impl<const N: usize> Elements<'_, N> {
    /// The numbers. Integers that stand for 0..1 or -1..1 are scaled (`KHR_mesh_quantization` allows others).
    pub fn floats(&self) -> Vec<[f32; N]> {
        let e = self;
        let size = e.component.size();
        let scale = |most: f32| if e.normalized { 1.0 / most } else { 1.0 };
        let number = |b: &[u8]| match e.component {
            Component::I8 => (f32::from(b[0] as i8) * scale(127.0)).max(if e.normalized { -1.0 } else { f32::MIN }),
            Component::U8 => f32::from(b[0]) * scale(255.0),
            Component::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])) * scale(32767.0)).max(if e.normalized {
                -1.0
            } else {
                f32::MIN
            }),
            Component::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])) * scale(65535.0),
            Component::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            Component::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        let element = |i: usize| {
            let bytes = &e.bytes[i * e.stride..];
            std::array::from_fn(|k| number(&bytes[k * size..]))
        };
        (0..e.count).map(element).collect()
    }
}

impl Elements<'_, 1> {
    /// The numbers as vertex indices; nothing if they are of another kind.
    pub fn indices(&self) -> Option<Vec<u32>> {
        let e = self;
        let number = |b: &[u8]| match e.component {
            Component::U8 => Some(u32::from(b[0])),
            Component::U16 => Some(u32::from(u16::from_le_bytes([b[0], b[1]]))),
            Component::U32 => Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            _ => None,
        };
        (0..e.count).map(|i| number(&e.bytes[i * e.stride..])).collect()
    }
}

impl<'a> Reader<'a, '_> {
    /// The elements of an accessor, checked against the bytes that hold them; this loads the buffer.
    pub fn elements<const N: usize>(&self, index: usize) -> Result<Elements<'a, N>> {
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let a: &Accessor = item(self.path, &self.document.accessors, index, "accessor")?;
        let wrong = |found: String, expected: String| Error::invalid(self.path, found, expected);
        if a.shape != shape {
            return Err(wrong(format!("accessor {index} of type {}", a.shape), format!("{shape} there")));
        }
        if a.sparse.is_some() {
            return Err(Error::unsupported(self.path, format!("sparse accessor {index}"), "accessors of plain values"));
        }
        let Some(view) = a.buffer_view else {
            return Err(Error::unsupported(self.path, format!("accessor {index} without data"), "buffer views"));
        };
        let component = match a.component_type {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            other => return Err(wrong(format!("component type {other} in accessor {index}"), "5120 to 5126".into())),
        };
        let bytes = self.view(view)?;
        let size = (component.size() * N) as u64;
        let stride = self.document.buffer_views[view].byte_stride.unwrap_or(size);
        let end = a.count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(size));
        let length = if a.count == 0 { Some(0) } else { end };
        let inside = length.and_then(|length| range(bytes, a.byte_offset, length)).filter(|_| stride >= size);
        let bytes = inside.ok_or_else(|| {
            let found = format!("accessor {index}: {} elements of {size} bytes, {stride} apart", a.count);
            wrong(found, format!("a place inside the {} bytes of buffer view {view}", bytes.len()))
        })?;
        let (stride, count) = (stride as usize, a.count as usize);
        Ok(Elements { bytes, stride, count, component, normalized: a.normalized })
    }

    /// The bytes of an image, or the file that has them.
    pub fn image(&self, index: usize) -> Result<Stored<'a>> {
        let image = item(self.path, &self.document.images, index, "image")?;
        let what = format!("image {index}");
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match inline(self.path, uri, &what)? {
                Some(bytes) => Ok(Stored::Inside(bytes.into())),
                None => Ok(Stored::File(beside(self.path, uri, &what)?)),
            },
            (None, Some(view)) => Ok(Stored::Inside(self.view(view)?.into())),
            (None, None) => Err(Error::invalid(self.path, format!("{what} without data"), "a uri or a buffer view")),
        }
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: usize) -> Result<&'a [u8]> {
        let view = item(self.path, &self.document.buffer_views, index, "buffer view")?;
        let buffer = self.buffers.get(view.buffer)?;
        range(buffer, view.byte_offset, view.byte_length).ok_or_else(|| {
            let found = format!("buffer view {index}: {} bytes from byte {}", view.byte_length, view.byte_offset);
            let expected = format!("a place inside the {} bytes of buffer {}", buffer.len(), view.buffer);
            Error::invalid(self.path, found, expected)
        })
    }
}

fn range(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let (offset, length) = (usize::try_from(offset).ok()?, usize::try_from(length).ok()?);
    bytes.get(offset..)?.get(..length)
}
