//! The JSON and the buffers of a file: chunks of a .glb, files beside it, data in the JSON itself.

use std::borrow::Cow;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::super::mesh::read_file;
use super::document::{Buffer, Document};
use crate::error::{Error, Result};

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// The document and the bytes of its buffers, each at least as long as it says.
pub(super) fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Document, Vec<Cow<'a, [u8]>>)> {
    let (json, binary) = if bytes.starts_with(b"glTF") { chunks(path, bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let document: Document =
        serde_json::from_slice(json).map_err(|error| Error::invalid(path, format!("JSON: {error}"), "glTF 2.0"))?;
    if !document.asset.version.starts_with("2.") {
        let found = format!("glTF version {:?}", document.asset.version);
        return Err(Error::unsupported(path, found, "glTF 2.0"));
    }
    let buffers = (document.buffers.iter().enumerate())
        .map(|(i, buffer)| {
            let data = data(path, i, buffer, binary)?;
            if (data.len() as u64) < buffer.byte_length {
                let expected = format!("the {} that the file claims", buffer.byte_length);
                return Err(Error::invalid(path, format!("{} bytes in buffer {i}", data.len()), expected));
            }
            Ok(data)
        })
        .collect::<Result<_>>()?;
    Ok((document, buffers))
}

/// The JSON chunk and the binary chunk, if there is one (glTF 2.0, 4.4).
fn chunks<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let word = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let cut = |at: usize| {
        Error::invalid(
            path,
            format!("the end of the file at byte {}", bytes.len()),
            match at {
                0 => "a GLB header of 12 bytes".to_owned(),
                at => format!("a chunk at byte {at}"),
            },
        )
    };
    let (version, _) = word(4).zip(word(8)).ok_or_else(|| cut(0))?;
    if version != 2 {
        return Err(Error::unsupported(path, format!("GLB version {version}"), "version 2"));
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while at < bytes.len() && (json.is_none() || binary.is_none()) {
        let (length, kind) = word(at).zip(word(at + 4)).ok_or_else(|| cut(at))?;
        let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize)).ok_or_else(|| {
            let found = format!("a chunk of {length} bytes at byte {at} of {}", bytes.len());
            Error::invalid(path, found, "chunks inside the file")
        })?;
        match kind {
            JSON => json = json.or(Some(chunk)),
            BIN => binary = binary.or(Some(chunk)),
            _ => {}
        }
        at += 8 + length as usize;
    }
    let json = json.ok_or_else(|| Error::invalid(path, "no JSON chunk", "a GLB file with one"))?;
    Ok((json, binary))
}

fn data<'a>(path: &Path, index: usize, buffer: &Buffer, binary: Option<&'a [u8]>) -> Result<Cow<'a, [u8]>> {
    let Some(uri) = &buffer.uri else {
        return match binary {
            Some(binary) if index == 0 => Ok(Cow::Borrowed(binary)),
            _ => Err(Error::invalid(path, format!("buffer {index} without data"), "a uri or a binary chunk")),
        };
    };
    if let Some(rest) = uri.strip_prefix("data:") {
        let Some((_, text)) = rest.split_once(";base64,") else {
            return Err(Error::unsupported(path, format!("a data URI in buffer {index}"), "base64 data"));
        };
        return STANDARD
            .decode(text)
            .map(Cow::Owned)
            .map_err(|error| Error::invalid(path, format!("base64 in buffer {index}: {error}"), "base64 data"));
    }
    let name = unescaped(uri);
    let inside = name.as_ref().is_some_and(|name| !name.contains("://") && !Path::new(name).is_absolute());
    let Some(name) = name.filter(|_| inside) else {
        return Err(Error::unsupported(path, format!("{uri:?} in buffer {index}"), "a file relative to this one"));
    };
    Ok(Cow::Owned(read_file(&path.parent().unwrap_or(Path::new("")).join(name))?))
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
}
