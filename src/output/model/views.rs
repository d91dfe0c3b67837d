//! Buffer views: whether they are inside their buffers, what goes with those that are given up, and where others come to lie.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use crate::error::{Error, Result};
use crate::gltf::text::{at, items, member, members, with};
use crate::gltf::{Buffers, Document, item};

/// Extensions of buffer views that place data, with members like a view's own; and of the buffers that it is unpacked to.
const PLACING: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Whether a buffer has no bytes, for readers that know the extension unpack others to it.
pub fn is_fallback(buffer: &str) -> bool {
    let says = |name: &str| at(buffer, &["extensions", name, "fallback"]) == Some("true");
    member(buffer, "uri").is_none() && PLACING.into_iter().any(says)
}

/// Refuses a binary chunk that is shorter than its buffer, views that reach beyond theirs, and views of images that are
/// none.
pub fn check_views(path: &Path, text: &str, document: &Document, binary: Option<&[u8]>) -> Result<()> {
    if binary.is_some() && document.buffers.first().is_some_and(|buffer| buffer.uri.is_none()) {
        Buffers::new(path, &document.buffers, binary).get(0)?;
    }
    let check = |what: String, buffer: usize, offset: u64, length: u64| {
        let whole = item(path, &document.buffers, buffer, "buffer")?.byte_length;
        match offset.checked_add(length).filter(|end| *end <= whole) {
            Some(_) => Ok(()),
            None => {
                let found = format!("{what}: {length} bytes from byte {offset}");
                Err(Error::invalid(path, found, format!("a place inside the {whole} bytes of buffer {buffer}")))
            }
        }
    };
    let texts = member(text, "bufferViews").map_or_else(Vec::new, items);
    for (i, (view, text)) in document.buffer_views.iter().zip(texts).enumerate() {
        check(format!("buffer view {i}"), view.buffer, view.byte_offset, view.byte_length)?;
        for (name, place) in placed(text) {
            let number = |key: &str| member(place, key).map_or(Some(0), |text| text.parse::<u64>().ok());
            let (Some(buffer), Some(offset), Some(length)) =
                (number("buffer"), number("byteOffset"), number("byteLength"))
            else {
                let expected = "whole numbers as buffer, byteOffset and byteLength";
                return Err(Error::invalid(path, format!("{name} of buffer view {i} without a place"), expected));
            };
            check(format!("{name} of buffer view {i}"), usize::try_from(buffer).unwrap_or(usize::MAX), offset, length)?;
        }
    }
    for view in document.images.iter().filter_map(|image| image.buffer_view) {
        item(path, &document.buffer_views, view, "buffer view")?;
    }
    Ok(())
}

/// The extensions of a view that place data.
fn placed(view: &str) -> Vec<(String, &str)> {
    let extensions = member(view, "extensions").map_or_else(Vec::new, members);
    extensions.into_iter().filter(|(name, _)| PLACING.contains(&name.as_str())).collect()
}

fn number(text: &str, key: &str) -> Option<usize> {
    member(text, key).and_then(|text| text.parse().ok())
}

/// Ranges of each buffer that only views that are given up lie in, in order. Lengths are multiples of 4, so that what
/// follows stays aligned.
pub fn removed(document: &Document, views: &[&str], dropped: &BTreeSet<usize>) -> Vec<Vec<Range<usize>>> {
    let mut removed = vec![Vec::new(); document.buffers.len()];
    let extensions = |view: &str| member(view, "extensions").map_or(0, |text| members(text).len());
    // What other extensions of views mean is not known: nothing moves.
    if views.iter().any(|view| extensions(view) > placed(view).len()) {
        return removed;
    }
    let mut kept: Vec<(usize, Range<usize>)> = Vec::new();
    let mut gone = Vec::new();
    for (i, view) in document.buffer_views.iter().enumerate() {
        let start = view.byte_offset as usize;
        let to = if dropped.contains(&i) { &mut gone } else { &mut kept };
        to.push((view.buffer, start..start + view.byte_length as usize));
    }
    for (_, place) in views.iter().flat_map(|view| placed(view)) {
        let [buffer, start, length] = ["buffer", "byteOffset", "byteLength"].map(|key| number(place, key).unwrap_or(0));
        kept.push((buffer, start..start + length));
    }
    kept.sort_by_key(|(_, range)| range.start);
    gone.sort_by_key(|(_, range)| range.start);
    for (buffer, range) in gone {
        let list = &mut removed[buffer];
        let mut start = list.last().map_or(range.start, |last: &Range<usize>| range.start.max(last.end));
        let mut push = |part: Range<usize>| {
            let length = part.len() / 4 * 4;
            if length > 0 {
                list.push(part.start..part.start + length);
            }
        };
        for (_, keep) in kept.iter().filter(|(of, _)| *of == buffer) {
            if keep.end > start && keep.start < range.end {
                push(start..keep.start.max(start));
                start = keep.end;
            }
        }
        push(start..range.end.max(start));
    }
    removed
}

/// A view at its new place; `moved` gives that of a buffer and an offset.
pub fn view_moved(view: &str, moved: &dyn Fn(usize, usize) -> (usize, usize)) -> String {
    let place = |text: &str| {
        let (buffer, offset) = (number(text, "buffer").unwrap_or(0), number(text, "byteOffset"));
        let (to, at) = moved(buffer, offset.unwrap_or(0));
        if (to, at) == (buffer, offset.unwrap_or(0)) {
            return text.to_owned();
        }
        with(text, &[("buffer", Some(to.to_string())), ("byteOffset", Some(at.to_string()))])
    };
    let places: Vec<(String, String)> = placed(view).into_iter().map(|(name, text)| (name, place(text))).collect();
    let places: Vec<(&str, Option<String>)> =
        places.iter().map(|(name, text)| (name.as_str(), Some(text.clone()))).collect();
    let (old, moved) = (member(view, "extensions").unwrap_or("{}"), place(view));
    match with(old, &places) {
        new if new == with(old, &[]) => moved,
        new => with(&moved, &[("extensions", Some(new))]),
    }
}
