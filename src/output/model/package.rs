//! The bytes of a model: buffers without what nothing uses any more and with what is new, and the chunks of a .glb.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::assign::is_known;
use crate::error::{Error, Result};
use crate::gltf::text::{Edits, items, member, members, numbers, quoted, with};
use crate::gltf::{Buffers, Document, beside, binary, inline, open, parts};
use crate::material::Model;

/// Where the content of an image lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a buffer view of a buffer.
    View(usize),
    /// In a file of its own.
    File,
    /// In the JSON.
    Inline,
}

/// Parts of buffers begin at multiples of this; the widest component of an accessor has 4, textures like 16.
const ALIGNMENT: usize = 16;

/// Extensions of buffer views that place data, with members like a view's own.
const PLACING: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The bytes of a model, and the files beside it by their names.
pub type Whole = (Vec<u8>, Vec<(String, Beside)>);

/// A file beside the model.
#[derive(Debug)]
pub enum Beside {
    /// New.
    Bytes(Vec<u8>),
    /// One of the model's own.
    Copy(PathBuf),
}

/// A model that is being changed.
pub struct Package<'a> {
    pub path: &'a Path,
    pub document: Document,
    pub text: &'a str,
    /// Whether the input is a .glb.
    pub from_binary: bool,
    /// Whether the output is.
    pub to_binary: bool,
    binary: Option<&'a [u8]>,
    others: Vec<(u32, &'a [u8])>,
    /// The views that are taken out or get something else.
    dropped: BTreeSet<usize>,
    /// What is added to buffers: the buffer, and the bytes.
    added: Vec<(usize, Vec<u8>)>,
    /// The views that get what was added, by index there; others are new.
    reused: BTreeMap<usize, usize>,
    pub files: Vec<(String, Beside)>,
}

impl<'a> Package<'a> {
    pub fn new(model: &'a Model, to_binary: bool) -> Result<Self> {
        let (document, binary) = open(&model.path, &model.bytes)?;
        let parts = parts(&model.path, &model.bytes)?;
        for (what, uris) in [
            ("buffer", document.buffers.iter().map(|b| b.uri.as_deref()).collect::<Vec<_>>()),
            ("image", document.images.iter().map(|i| i.uri.as_deref()).collect()),
        ] {
            for (i, uri) in uris.into_iter().enumerate() {
                let file = uri.filter(|uri| !uri.starts_with("data:"));
                file.map(|uri| beside(&model.path, uri, &format!("{what} {i}"))).transpose()?;
            }
        }
        Ok(Self {
            path: &model.path,
            document,
            text: parts.text,
            from_binary: parts.binary,
            to_binary,
            binary,
            others: parts.others,
            dropped: BTreeSet::new(),
            added: Vec::new(),
            reused: BTreeMap::new(),
            files: Vec::new(),
        })
    }

    /// Whether the buffers become one.
    fn merges(&self) -> bool {
        self.to_binary && !self.from_binary
    }

    /// Where an image that stems from this one is put: as that is, but all inside where a .glb is made of a .gltf.
    pub fn place(&self, image: usize) -> Place {
        let image = &self.document.images[image];
        match (&image.uri, image.buffer_view) {
            _ if self.merges() => Place::View(0),
            (Some(uri), _) if uri.starts_with("data:") => Place::Inline,
            (None, Some(view)) => {
                self.document.buffer_views.get(view).map_or(Place::File, |view| Place::View(view.buffer))
            }
            _ => Place::File,
        }
    }

    /// Adds bytes to a buffer; the number of their view, which is that of `instead` if nothing else needs that.
    pub fn add(&mut self, buffer: usize, bytes: Vec<u8>, instead: Option<usize>) -> usize {
        let added = self.added.len();
        self.added.push((buffer, bytes));
        match instead.filter(|view| self.dropped.contains(view) && !self.reused.contains_key(view)) {
            Some(view) => {
                self.reused.insert(view, added);
                view
            }
            None => {
                let new = added - self.reused.len();
                self.document.buffer_views.len() + new
            }
        }
    }

    /// Gives up the views of images that are taken out, where nothing else uses them.
    pub fn drop_images(&mut self, images: &BTreeSet<usize>) {
        let mut users: BTreeMap<usize, isize> = BTreeMap::new();
        for number in numbers(self.text, is_known) {
            if number.strange || number.key == "bufferView" {
                *users.entry(number.value).or_default() += if number.strange { 2 } else { 1 };
            }
        }
        for image in images {
            if let Some(view) = self.document.images[*image].buffer_view {
                *users.entry(view).or_default() -= 1;
            }
        }
        let given_up = images.iter().filter_map(|image| self.document.images[*image].buffer_view);
        self.dropped = given_up.filter(|view| users.get(view) == Some(&0)).collect();
    }

    /// The files beside the model that it names.
    pub fn inputs(&self) -> Result<Vec<PathBuf>> {
        self.files_of(|_| true)
    }

    /// The files of its images, and of those buffers.
    fn files_of(&self, buffer: impl Fn(usize) -> bool) -> Result<Vec<PathBuf>> {
        let images = self.document.images.iter().filter_map(|image| image.uri.as_deref());
        let buffers = self.document.buffers.iter().enumerate().filter(|(b, _)| buffer(*b));
        let buffers = buffers.filter_map(|(_, buffer)| buffer.uri.as_deref());
        let files = images.chain(buffers).filter(|uri| !uri.starts_with("data:"));
        files.map(|uri| beside(self.path, uri, "a uri")).collect()
    }

    /// A name that no file of the model has, but for buffers that get another; file systems that ignore case exist.
    pub fn free_name(&self, base: &str, ending: &str, stays: impl Fn(usize) -> bool) -> String {
        // A uri that names no file is told of where it is read.
        let inputs = self.files_of(stays).unwrap_or_default();
        let inputs: Vec<String> = inputs.iter().map(|file| relative(self.path, file)).collect();
        let names = self.files.iter().map(|(name, _)| name).chain(&inputs);
        let taken: BTreeSet<String> = names.map(|name| name.to_lowercase()).collect();
        let name = |n: usize| if n == 1 { format!("{base}.{ending}") } else { format!("{base}_{n}.{ending}") };
        (1..).map(name).find(|name| !taken.contains(&name.to_lowercase())).expect("some number is free")
    }

    /// The whole file; `edits` has the changes of everything but views and buffers. `stem` names files of buffers.
    pub fn finish(mut self, mut edits: Edits<'a>, stem: &str) -> Result<Whole> {
        let path = self.path;
        let list = |key: &str| member(self.text, key).map_or_else(Vec::new, items);
        let (views, buffers) = (list("bufferViews"), list("buffers"));
        let holder = Buffers::new(path, &self.document.buffers, self.binary);

        // Buffers that come out other than they went in.
        let in_chunk = |b: usize| b == 0 && self.document.buffers[b].uri.is_none() && self.binary.is_some();
        let moves = |b: usize| self.merges() || (in_chunk(b) && !self.to_binary);
        let grows: BTreeSet<usize> = self.added.iter().map(|(buffer, _)| *buffer).collect();
        let shrinks: BTreeSet<usize> =
            self.dropped.iter().map(|view| self.document.buffer_views[*view].buffer).collect();
        let changed: Vec<bool> =
            (0..buffers.len()).map(|b| moves(b) || grows.contains(&b) || shrinks.contains(&b)).collect();
        let removed = self.removed(&views);
        let mut contents: Vec<Vec<u8>> = vec![Vec::new(); buffers.len().max(usize::from(!grows.is_empty()))];
        let mut base = vec![0; contents.len()];
        for b in (0..buffers.len()).filter(|b| changed[*b]) {
            let length = self.document.buffers[b].byte_length as usize;
            let data = &holder.get(b)?[..length];
            let to = if self.merges() { 0 } else { b };
            pad(&mut contents[to], if self.merges() { ALIGNMENT } else { 1 });
            base[b] = contents[to].len();
            let mut from = 0;
            for range in removed[b].iter().map(|range| range.start.min(length)..range.end.min(length)) {
                contents[to].extend(&data[from..range.start]);
                from = range.end;
            }
            contents[to].extend(&data[from..]);
        }
        let moved = |buffer: usize, offset: usize| -> (usize, usize) {
            if changed.get(buffer) != Some(&true) {
                return (buffer, offset);
            }
            let gone: usize =
                removed[buffer].iter().take_while(|range| range.end <= offset).map(|range| range.len()).sum();
            (if self.merges() { 0 } else { buffer }, base[buffer].saturating_add(offset - gone))
        };

        let mut new_views: Vec<String> = Vec::new();
        let mut renewed: BTreeMap<usize, String> = BTreeMap::new();
        for (i, (buffer, bytes)) in self.added.iter().enumerate() {
            pad(&mut contents[*buffer], ALIGNMENT);
            let place = [
                ("buffer", Some(buffer.to_string())),
                ("byteOffset", Some(contents[*buffer].len().to_string())),
                ("byteLength", Some(bytes.len().to_string())),
            ];
            contents[*buffer].extend(bytes);
            match self.reused.iter().find(|(_, added)| **added == i) {
                Some((view, _)) => drop(renewed.insert(*view, with(views[*view], &place))),
                None => new_views.push(with("{}", &place)),
            }
        }
        for (i, view) in views.iter().enumerate() {
            let new = renewed.remove(&i).unwrap_or_else(|| view_moved(view, &moved, self.dropped.contains(&i)));
            edits.replace(view, new);
        }
        let mut at_root: Vec<(&str, String)> = Vec::new();
        match member(self.text, "bufferViews") {
            Some(array) => edits.append(array, &new_views),
            None if new_views.is_empty() => {}
            None => at_root.push(("bufferViews", format!("[{}]", new_views.join(",")))),
        }

        let mut chunk = self.binary.filter(|_| self.to_binary && !changed.first().copied().unwrap_or(false));
        let merged = contents.first().cloned().filter(|_| self.merges() && !contents[0].is_empty());
        if let Some(bytes) = &merged {
            let one = |text: &str| with(text, &[("uri", None), ("byteLength", Some(bytes.len().to_string()))]);
            match member(self.text, "buffers") {
                Some(array) => edits.replace(array, format!("[{}]", one(buffers.first().unwrap_or(&"{}")))),
                None => at_root.push(("buffers", format!("[{}]", one("{}")))),
            }
            chunk = Some(bytes);
        } else {
            for b in (0..buffers.len()).filter(|b| changed[*b]) {
                let content = std::mem::take(&mut contents[b]);
                let length = Some(content.len().to_string());
                let uri = self.document.buffers[b].uri.as_deref();
                if in_chunk(b) && self.to_binary {
                    edits.replace(buffers[b], with(buffers[b], &[("byteLength", length)]));
                    contents[b] = content;
                } else if uri.is_some_and(|uri| uri.starts_with("data:")) {
                    let uri = quoted(&data_uri("application/octet-stream", &content));
                    edits.replace(buffers[b], with(buffers[b], &[("uri", Some(uri)), ("byteLength", length)]));
                } else {
                    let name = self.free_name(stem, "bin", |b| !changed[b]);
                    let uri = Some(quoted(&name));
                    edits.replace(buffers[b], with(buffers[b], &[("uri", uri), ("byteLength", length)]));
                    self.files.push((name, Beside::Bytes(content)));
                }
            }
            if self.to_binary && changed.first() == Some(&true) && self.document.buffers[0].uri.is_none() {
                chunk = Some(&contents[0]);
            }
            for (b, buffer) in self.document.buffers.iter().enumerate().filter(|(b, _)| !changed[*b]) {
                if let Some(uri) = buffer.uri.as_deref().filter(|uri| !uri.starts_with("data:")) {
                    let file = beside(path, uri, &format!("buffer {b}"))?;
                    self.files.push((relative(path, &file), Beside::Copy(file)));
                }
            }
        }
        edits.add(self.text, &at_root);
        let text = edits.apply();
        // Files say what they should not, and what is added to it is then no JSON.
        serde_json::from_str::<serde::de::IgnoredAny>(&text).map_err(|error| {
            let found = format!("members of other kinds than glTF's, which cannot be changed ({error})");
            Error::invalid(path, found, "lists and objects as glTF 2.0 has them")
        })?;
        let main = if self.to_binary { binary(path, &text, chunk, &self.others)? } else { text.into_bytes() };
        Ok((main, self.files))
    }

    /// Ranges of each buffer that only views that are given up lie in. Lengths are multiples of 4, so that what follows
    /// stays aligned.
    fn removed(&self, views: &[&str]) -> Vec<Vec<Range<usize>>> {
        let mut removed = vec![Vec::new(); self.document.buffers.len()];
        let plain = |text: &&str| {
            let extensions = member(text, "extensions").map_or_else(Vec::new, members);
            extensions.iter().all(|(name, _)| PLACING.contains(&name.as_str()))
        };
        // What other extensions of views mean is not known: nothing moves.
        if !views.iter().all(plain) {
            return removed;
        }
        let mut kept: Vec<(usize, Range<usize>)> = Vec::new();
        let mut gone = Vec::new();
        for (i, view) in self.document.buffer_views.iter().enumerate() {
            let start = view.byte_offset as usize;
            let range = start..start.saturating_add(view.byte_length as usize);
            let to = if self.dropped.contains(&i) { &mut gone } else { &mut kept };
            to.push((view.buffer, range));
        }
        for view in views {
            for (_, text) in member(view, "extensions").map_or_else(Vec::new, members) {
                let number = |key| member(text, key).and_then(|text| text.parse::<usize>().ok()).unwrap_or(0);
                let start = number("byteOffset");
                kept.push((number("buffer"), start..start.saturating_add(number("byteLength"))));
            }
        }
        kept.sort_by_key(|(_, range)| range.start);
        gone.sort_by_key(|(_, range)| range.start);
        for (buffer, range) in gone {
            let Some(list) = removed.get_mut(buffer) else { continue };
            let mut start = list.last().map_or(range.start, |last: &Range<usize>| range.start.max(last.end));
            let mut push = |part: Range<usize>| {
                let length = part.len() / 4 * 4;
                if length > 0 && part.start < part.end {
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
}

/// A view at its new place.
fn view_moved(view: &str, moved: &dyn Fn(usize, usize) -> (usize, usize), dropped: bool) -> String {
    let number = |text: &str, key| member(text, key).and_then(|text| text.parse::<usize>().ok());
    let place = |text: &str| {
        let (buffer, offset) = (number(text, "buffer").unwrap_or(0), number(text, "byteOffset"));
        let (to, at) = moved(buffer, offset.unwrap_or(0));
        if (to, at) == (buffer, offset.unwrap_or(0)) {
            return text.to_owned();
        }
        with(text, &[("buffer", Some(to.to_string())), ("byteOffset", Some(at.to_string()))])
    };
    if dropped {
        return view.to_owned();
    }
    let extensions = member(view, "extensions");
    let placing = |text: &str| members(text).iter().any(|(name, _)| PLACING.contains(&name.as_str()));
    match extensions.filter(|text| placing(text)) {
        None => place(view),
        Some(text) => {
            let changes: Vec<(String, String)> =
                members(text).into_iter().map(|(name, text)| (name, place(text))).collect();
            let changes: Vec<(&str, Option<String>)> =
                changes.iter().map(|(name, text)| (name.as_str(), Some(text.clone()))).collect();
            let new = with(text, &changes);
            let moved = place(view);
            if new == with(text, &[]) { moved } else { with(&moved, &[("extensions", Some(new))]) }
        }
    }
}

fn pad(bytes: &mut Vec<u8>, alignment: usize) {
    bytes.resize(bytes.len().next_multiple_of(alignment), 0);
}

pub fn data_uri(mime_type: &str, bytes: &[u8]) -> String {
    use base64::Engine;
    format!("data:{mime_type};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// A file of the model, from its folder on, with `/` between folders.
pub fn relative(model: &Path, file: &Path) -> String {
    let file = file.strip_prefix(model.parent().unwrap_or(Path::new(""))).unwrap_or(file);
    let parts: Vec<_> = file.components().filter(|c| matches!(c, std::path::Component::Normal(_))).collect();
    parts.iter().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// The bytes of an image, wherever they are.
pub fn image_bytes(package: &Package, image: usize) -> Result<Vec<u8>> {
    let (path, document) = (package.path, &package.document);
    let entry = &document.images[image];
    let what = format!("image {image}");
    match (&entry.uri, entry.buffer_view) {
        (Some(uri), _) => match inline(path, uri, &what)? {
            Some(bytes) => Ok(bytes),
            None => crate::codec::read_file(&beside(path, uri, &what)?, "a picture file", u64::MAX),
        },
        (None, Some(view)) => {
            let buffers = Buffers::new(path, &document.buffers, package.binary);
            let reader = crate::gltf::Reader { path, document, buffers: &buffers };
            Ok(reader.view(view)?.to_vec())
        }
        (None, None) => Err(Error::invalid(path, format!("{what} without data"), "a uri or a buffer view")),
    }
}
