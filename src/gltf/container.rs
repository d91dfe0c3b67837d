//! The JSON and the buffers of a file: chunks of a .glb, files beside it, data in the JSON itself.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::document::{Buffer, Document};
use super::item;
use super::words::parse;
use crate::codec::read_file;
use crate::error::{Error, Result};

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// The most bytes that the buffers of a file may hold: 8 GiB, as a mesh of the most vertices needs at 100 bytes each,
/// and twice what a .glb can hold. A small file may name large ones.
const MOST_BUFFER_BYTES: u64 = 1 << 33;

/// The document, and the binary chunk if there is one.
pub(crate) fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Document, Option<&'a [u8]>)> {
    let parts = parts(path, bytes)?;
    let document: Document = parse(path, "JSON", parts.text)?;
    if !document.asset.version.starts_with("2.") {
        let found = format!("glTF version {:?}", document.asset.version);
        return Err(Error::unsupported(path, found, "glTF 2.0"));
    }
    Ok((document, parts.chunk))
}

/// What a file is made of.
pub(crate) struct Parts<'a> {
    /// The JSON as it is written.
    pub text: &'a str,
    /// Whether it is a .glb.
    pub binary: bool,
    /// The binary chunk of a .glb.
    pub chunk: Option<&'a [u8]>,
    /// Further chunks, by their kind.
    pub others: Vec<(u32, &'a [u8])>,
    /// How many bytes follow the end that a .glb tells.
    pub beyond: usize,
}

/// The parts of a file (glTF 2.0, 4.4). What follows the end that a .glb tells is none of them.
pub(crate) fn parts<'a>(path: &Path, bytes: &'a [u8]) -> Result<Parts<'a>> {
    let binary = bytes.starts_with(b"glTF");
    let (mut json, mut chunk, mut others, mut beyond) = (Some(bytes).filter(|_| !binary), None, Vec::new(), 0);
    if binary {
        let whole = whole(path, bytes)?;
        beyond = bytes.len() - whole.len();
        let mut at = 12;
        while at < whole.len() {
            let (length, kind, content) = chunk_at(path, whole, at)?;
            match kind {
                JSON if json.is_none() => json = Some(content),
                BIN if chunk.is_none() => chunk = Some(content),
                _ => others.push((kind, content)),
            }
            at += 8 + length;
        }
    }
    let json = json.ok_or_else(|| Error::invalid(path, "no JSON chunk", "a GLB file with one"))?;
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let text = std::str::from_utf8(json).map_err(|error| Error::invalid(path, format!("JSON: {error}"), "UTF-8"))?;
    Ok(Parts { text, binary, chunk, others, beyond })
}

/// A .glb of a text, a binary chunk, and further ones.
///
/// # Errors
/// More than the format's 4 GiB.
pub(crate) fn binary(path: &Path, text: &str, binary: Option<&[u8]>, others: &[(u32, &[u8])]) -> Result<Vec<u8>> {
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    let chunks = [(JSON, text.as_bytes())].into_iter().chain(binary.map(|binary| (BIN, binary)));
    for (kind, chunk) in chunks.chain(others.iter().copied()) {
        let padded = chunk.len().next_multiple_of(4);
        out.extend((padded as u32).to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(chunk);
        out.resize(out.len() + padded - chunk.len(), if kind == JSON { b' ' } else { 0 });
    }
    let length = u32::try_from(out.len())
        .map_err(|_| Error::unsupported(path, format!("a .glb of {} bytes", out.len()), "4 GiB; or a .gltf"))?;
    out[8..12].copy_from_slice(&length.to_le_bytes());
    Ok(out)
}

/// The buffers of a document, each loaded when it is first asked for: many files hold buffers that no triangle needs.
pub(crate) struct Buffers<'a> {
    path: &'a Path,
    buffers: &'a [Buffer],
    binary: Option<&'a [u8]>,
    /// For each buffer the first one with the same uri, whose bytes it shares.
    first: Vec<usize>,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
    /// Bytes that may still be loaded.
    room: Cell<u64>,
}

impl<'a> Buffers<'a> {
    pub fn new(path: &'a Path, buffers: &'a [Buffer], binary: Option<&'a [u8]>) -> Self {
        let mut places: HashMap<&str, usize> = HashMap::new();
        let first = (buffers.iter().enumerate())
            .map(|(i, buffer)| buffer.uri.as_deref().map_or(i, |uri| *places.entry(uri).or_insert(i)))
            .collect();
        let loaded = buffers.iter().map(|_| OnceCell::new()).collect();
        Self { path, buffers, binary, first, loaded, room: Cell::new(MOST_BUFFER_BYTES) }
    }

    /// The bytes of a buffer, at least as many as it says.
    pub fn get(&self, index: usize) -> Result<&[u8]> {
        let buffer = item(self.path, self.buffers, index, "buffer")?;
        let cell = &self.loaded[self.first[index]];
        let data = match cell.get() {
            Some(data) => data,
            None => {
                let data = self.load(index, buffer)?;
                cell.get_or_init(|| data)
            }
        };
        if (data.len() as u64) < buffer.byte_length {
            let expected = format!("the {} that the file claims", buffer.byte_length);
            return Err(Error::invalid(self.path, format!("{} bytes in buffer {index}", data.len()), expected));
        }
        Ok(data)
    }

    fn load(&self, index: usize, buffer: &Buffer) -> Result<Cow<'a, [u8]>> {
        let path = self.path;
        let Some(uri) = &buffer.uri else {
            return match self.binary {
                Some(binary) if index == 0 => Ok(Cow::Borrowed(binary)),
                _ => Err(Error::invalid(path, format!("buffer {index} without data"), "a uri or a binary chunk")),
            };
        };
        let what = format!("buffer {index}");
        // In memory already and bounded by the file itself, so it takes no room.
        if let Some(data) = inline(path, uri, &what)? {
            return Ok(Cow::Owned(data));
        }
        let data = read_file(&beside(path, uri, &what)?, "a mesh file", self.room.get())?;
        self.room.set(self.room.get().saturating_sub(data.len() as u64));
        Ok(Cow::Owned(data))
    }
}

/// The bytes of a data URI; nothing if it is another one. `what` is for messages.
pub(crate) fn inline(path: &Path, uri: &str, what: &str) -> Result<Option<Vec<u8>>> {
    let Some(rest) = uri.strip_prefix("data:") else { return Ok(None) };
    let Some((_, text)) = rest.split_once(";base64,") else {
        return Err(Error::unsupported(path, format!("a data URI in {what}"), "base64 data"));
    };
    let broken = |error| Error::invalid(path, format!("base64 in {what}: {error}"), "base64 data");
    STANDARD.decode(text).map(Some).map_err(broken)
}

/// The file that a URI names. A model from elsewhere has no business outside its own folder.
pub(crate) fn beside(path: &Path, uri: &str, what: &str) -> Result<PathBuf> {
    let below = |name: &String| {
        let mut parts = Path::new(name).components();
        !name.is_empty()
            && !name.contains("://")
            && parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    };
    let Some(name) = unescaped(uri).filter(below) else {
        let expected = "a file relative to this one, in its folder or below";
        return Err(Error::unsupported(path, format!("{uri:?} in {what}"), expected));
    };
    Ok(path.parent().unwrap_or(Path::new("")).join(name))
}

/// A .glb from its header to the end that this tells.
fn whole<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8]> {
    let (version, length) = word(bytes, 4).zip(word(bytes, 8)).ok_or_else(|| cut(path, bytes, 0))?;
    if version != 2 {
        return Err(Error::unsupported(path, format!("GLB version {version}"), "version 2"));
    }
    bytes.get(..length as usize).filter(|whole| whole.len() >= 12).ok_or_else(|| {
        let found = format!("a GLB header that tells of {length} bytes, in a file of {}", bytes.len());
        Error::invalid(path, found, "the length of the whole file")
    })
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

fn cut(path: &Path, bytes: &[u8], at: usize) -> Error {
    let found = format!("the end of the file at byte {}", bytes.len());
    let expected = if at == 0 { "a GLB header of 12 bytes".to_owned() } else { format!("a chunk at byte {at}") };
    Error::invalid(path, found, expected)
}

/// Length, kind and content of the chunk at a byte.
fn chunk_at<'a>(path: &Path, bytes: &'a [u8], at: usize) -> Result<(usize, u32, &'a [u8])> {
    let (length, kind) = word(bytes, at).zip(word(bytes, at + 4)).ok_or_else(|| cut(path, bytes, at))?;
    let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize)).ok_or_else(|| {
        let found = format!("a chunk of {length} bytes at byte {at} of {}", bytes.len());
        Error::invalid(path, found, "chunks inside the file")
    })?;
    Ok((length as usize, kind, chunk))
}

/// A uri with its `%20`s as characters (RFC 3986, 2.1); nothing if that is no text.
fn unescaped(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = (first == b'%')
            .then(|| after.get(..2).and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok()))
            .flatten();
        out.push(code.unwrap_or(first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_undone() {
        assert_eq!(unescaped("a%20b%c3%a9.bin").as_deref(), Some("a b\u{e9}.bin"));
        assert_eq!(unescaped("100%").as_deref(), Some("100%"));
        assert_eq!(unescaped("%ff"), None);
    }

    #[test]
    fn a_file_is_read_once_and_all_files_have_one_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        for name in ["a.bin", "b.bin"] {
            std::fs::write(folder.path().join(name), [7; 100]).unwrap();
        }
        let of = |uri: &str, byte_length| Buffer { uri: Some(uri.to_owned()), byte_length };
        let list = [of("a.bin", 100), of("a.bin", 60), of("b.bin", 100), of("a.bin", 101)];
        let mut buffers = Buffers::new(&path, &list, None);
        buffers.room = Cell::new(150);
        let first = buffers.get(0).unwrap();
        assert!(std::ptr::eq(first, buffers.get(1).unwrap()) && first.len() == 100);
        let error = buffers.get(2).unwrap_err().to_string();
        assert!(error.contains("b.bin: a file of 100 bytes") && error.contains("up to 50 bytes"), "{error}");
        assert!(buffers.get(3).unwrap_err().to_string().contains("100 bytes in buffer 3"));
        buffers.room = Cell::new(200);
        assert!(buffers.get(2).is_ok());
    }
}
