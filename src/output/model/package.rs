//! The bytes of a model: buffers without what nothing uses any more and with what is new, and the chunks of a .glb.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::assign::{images_of, is_known};
use super::views::{check_views, is_fallback, removed, view_moved};
use crate::codec::read_file;
use crate::error::{Error, Result};
use crate::gltf::text::{Edits, items, member, numbers, quoted, with};
use crate::gltf::{Buffers, Document, Reader, Stored, beside, binary, open, parts};
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

/// A model with the files beside it by their names, and what was lost on the way.
pub struct Whole {
    pub main: Vec<u8>,
    pub beside: Vec<(String, Beside)>,
    pub warnings: Vec<String>,
}

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
    /// The views that get what was added, by index there.
    reused: BTreeMap<usize, usize>,
    /// The same of views that are new, in their order.
    new_views: Vec<usize>,
    pub files: Vec<(String, Beside)>,
    pub warnings: Vec<String>,
}

impl<'a> Package<'a> {
    /// # Errors
    /// A file that is no glTF; parts of it that are outside what they are parts of.
    pub fn new(model: &'a Model, to_binary: bool) -> Result<Self> {
        let (document, binary) = open(&model.path, &model.bytes)?;
        let parts = parts(&model.path, &model.bytes)?;
        check_views(&model.path, parts.text, &document, binary)?;
        let textures = member(parts.text, "textures").map_or_else(Vec::new, items);
        for (i, texture) in textures.into_iter().enumerate() {
            for image in images_of(texture) {
                if image >= document.images.len() {
                    let found = format!("image {image} of {} in texture {i}", document.images.len());
                    return Err(Error::invalid(&model.path, found, "an image that exists"));
                }
            }
        }
        for (what, uris) in [
            ("buffer", document.buffers.iter().map(|b| b.uri.as_deref()).collect::<Vec<_>>()),
            ("image", document.images.iter().map(|i| i.uri.as_deref()).collect()),
        ] {
            for (i, uri) in uris.into_iter().enumerate() {
                let file = uri.filter(|uri| !uri.starts_with("data:"));
                file.map(|uri| beside(&model.path, uri, &format!("{what} {i}"))).transpose()?;
            }
        }
        let mut warnings = Vec::new();
        if parts.beyond > 0 {
            warnings.push(format!("{} bytes after the end that its header tells are left out", parts.beyond));
        }
        if parts.binary && !to_binary {
            warnings.extend(parts.others.iter().map(|(kind, chunk)| {
                let kind = kind.to_le_bytes().escape_ascii().to_string();
                format!("its chunk {kind} of {} bytes is left out: a .gltf has no place for it", chunk.len())
            }));
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
            new_views: Vec::new(),
            files: Vec::new(),
            warnings,
        })
    }

    /// Its buffers, each of which is read once.
    pub fn buffers(&self) -> Buffers<'_> {
        Buffers::new(self.path, &self.document.buffers, self.binary)
    }

    /// Whether a buffer is the binary chunk.
    fn in_chunk(&self, buffer: usize) -> bool {
        buffer == 0 && self.binary.is_some() && self.document.buffers[0].uri.is_none()
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

    /// Adds bytes to a buffer; the number of their view: the first of `instead` that was given up, or a new one. All of
    /// `instead` that were given up show them.
    pub fn add(&mut self, buffer: usize, bytes: Vec<u8>, instead: &[usize]) -> usize {
        let added = self.added.len();
        let free = |view: &&usize| self.dropped.contains(view) && !self.reused.contains_key(view);
        let free: Vec<usize> = instead.iter().filter(free).copied().collect();
        self.reused.extend(free.iter().map(|view| (*view, added)));
        self.added.push((buffer, bytes));
        free.first().copied().unwrap_or_else(|| {
            self.new_views.push(added);
            self.document.buffer_views.len() + self.new_views.len() - 1
        })
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

        // Buffers that come out other than they went in; those without bytes stay.
        let empty = |b: usize| !self.in_chunk(b) && is_fallback(buffers[b]);
        let full = || (0..buffers.len()).filter(|b| !empty(*b));
        let merges = self.merges() && (full().next().is_some() || !self.added.is_empty());
        let moves = |b: usize| merges || (self.in_chunk(b) && !self.to_binary);
        let grows: BTreeSet<usize> = self.added.iter().map(|(buffer, _)| *buffer).collect();
        let shrinks: BTreeSet<usize> =
            self.dropped.iter().map(|view| self.document.buffer_views[*view].buffer).collect();
        let changes = |b: usize| !empty(b) && (moves(b) || grows.contains(&b) || shrinks.contains(&b));
        let changed: Vec<bool> = (0..buffers.len()).map(changes).collect();
        // Their numbers afterwards: where all become one, those without bytes follow it.
        let number = |b: usize| match (merges, empty(b)) {
            (false, _) => b,
            (true, false) => 0,
            (true, true) => 1 + (0..b).filter(|b| empty(*b)).count(),
        };
        let numbers: Vec<usize> = (0..buffers.len()).map(number).collect();
        let removed = removed(&self.document, &views, &self.dropped);
        let mut contents: Vec<Vec<u8>> = vec![Vec::new(); buffers.len().max(usize::from(!grows.is_empty()))];
        let mut base = vec![0; contents.len()];
        for b in (0..buffers.len()).filter(|b| changed[*b]) {
            let length = self.document.buffers[b].byte_length as usize;
            let data = &holder.get(b)?[..length];
            let to = numbers[b];
            pad(&mut contents[to], if merges { ALIGNMENT } else { 1 });
            base[b] = contents[to].len();
            let mut from = 0;
            for range in &removed[b] {
                contents[to].extend(&data[from..range.start]);
                from = range.end;
            }
            contents[to].extend(&data[from..]);
        }
        let moved = |buffer: usize, offset: usize| -> (usize, usize) {
            if !changed[buffer] {
                return (numbers[buffer], offset);
            }
            let gone: usize =
                removed[buffer].iter().take_while(|range| range.end <= offset).map(|range| range.len()).sum();
            (numbers[buffer], base[buffer] + offset - gone)
        };

        let mut places = Vec::new();
        for (buffer, bytes) in &self.added {
            pad(&mut contents[*buffer], ALIGNMENT);
            places.push([
                ("buffer", Some(buffer.to_string())),
                ("byteOffset", Some(contents[*buffer].len().to_string())),
                ("byteLength", Some(bytes.len().to_string())),
            ]);
            contents[*buffer].extend(bytes);
        }
        for (i, view) in views.iter().enumerate() {
            let added = self.reused.get(&i);
            edits.replace(view, added.map_or_else(|| view_moved(view, &moved), |added| with(view, &places[*added])));
        }
        let new_views: Vec<String> = self.new_views.iter().map(|added| with("{}", &places[*added])).collect();
        let mut at_root: Vec<(&str, String)> = Vec::new();
        match member(self.text, "bufferViews") {
            Some(array) => edits.append(array, &new_views),
            None if new_views.is_empty() => {}
            None => at_root.push(("bufferViews", format!("[{}]", new_views.join(",")))),
        }

        let mut chunk = self.binary.filter(|_| self.to_binary && !changed.first().copied().unwrap_or(false));
        if merges {
            let first = full().next().map_or("{}", |b| buffers[b]);
            let one = with(first, &[("uri", None), ("byteLength", Some(contents[0].len().to_string()))]);
            let empty = (0..buffers.len()).filter(|b| empty(*b)).map(|b| buffers[b].to_owned());
            let all = format!("[{}]", [one].into_iter().chain(empty).collect::<Vec<_>>().join(","));
            match member(self.text, "buffers") {
                Some(array) => edits.replace(array, all),
                None => at_root.push(("buffers", all)),
            }
            chunk = Some(&contents[0]);
        } else {
            for b in (0..buffers.len()).filter(|b| changed[*b]) {
                let content = std::mem::take(&mut contents[b]);
                let length = Some(content.len().to_string());
                let uri = self.document.buffers[b].uri.as_deref();
                if self.in_chunk(b) && self.to_binary {
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
        Ok(Whole { main, beside: self.files, warnings: self.warnings })
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

/// The bytes of an image, wherever they are; `buffers` are the package's.
pub fn image_bytes<'b>(package: &'b Package, buffers: &'b Buffers, image: usize) -> Result<Cow<'b, [u8]>> {
    match (Reader { path: package.path, document: &package.document, buffers }).image(image)? {
        Stored::Inside(bytes) => Ok(bytes),
        Stored::File(file) => Ok(read_file(&file, "a picture file", u64::MAX)?.into()),
    }
}
