//! What CHAIN may be on the command line.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::args::ReadingArgs;
use super::inputs;
use crate::error::{Error, Result};
use crate::material::{
    ChannelRef, Container, Inputs, LevelChain, NormalRange, NormalZ, RoughnessInput, read_folder, read_lobes, read_maps,
};

/// Where a chain is.
pub enum Source {
    /// A folder that a build wrote.
    Folder(PathBuf, Option<Container>),
    /// A lobes file.
    Lobes(PathBuf),
    /// Maps by patterns, or mip-mapped.
    Maps(Box<Inputs>),
}

/// A chain and what to call it.
pub struct Chain {
    pub name: String,
    /// As it was given.
    pub text: String,
    pub source: Source,
}

/// The forms of a CHAIN.
const EXPECTED: &str = "a folder that `mipfold build` wrote, a NAME_lobes.exr, or \
                        normal=FILE_%d.png,roughness=FILE_%d.png (see mipfold compare --help)";

/// What may stand before `=`.
pub const KEYS: &str = "normal, roughness, smoothness, orm, anisotropy, normal-y, normal-z, normal-range, normal-scale, name, \
                    container";

impl Chain {
    /// From its text. Where that says nothing of a convention, the options of the command hold.
    pub fn parse(text: &str, reading: &ReadingArgs) -> Result<Self> {
        // A path may hold any character.
        if Path::new(text).exists() {
            return Self::at(text, Path::new(text), None, None);
        }
        let there = text.rmatch_indices(',').map(|(at, _)| at).find(|at| Path::new(&text[..*at]).exists());
        let (path, rest) = match (there, text.split_once(',')) {
            (Some(at), _) => (Some(&text[..at]), &text[at + 1..]),
            (None, Some((path, rest))) if !path.contains('=') => (Some(path), rest),
            (None, None) if !text.contains('=') => (Some(text), ""),
            _ => (None, text),
        };
        let mut pairs: Vec<(&str, &str)> = Vec::new();
        for part in parts(rest).into_iter().filter(|part| !part.is_empty()) {
            let wrong = |found: String| Error::invalid_option(text, found, format!("KEY=VALUE with KEY one of {KEYS}"));
            let (key, value) = part.split_once('=').ok_or_else(|| wrong(format!("'{part}'")))?;
            if !KEYS.split(", ").any(|known| known == key) || value.is_empty() {
                return Err(wrong(format!("'{part}'")));
            }
            if pairs.iter().any(|(other, _)| *other == key) {
                return Err(wrong(format!("{key} twice")));
            }
            pairs.push((key, value));
        }
        let name = pairs.iter().find(|(key, _)| *key == "name").map(|(_, name)| (*name).to_owned());
        let container = pairs.iter().find(|(key, _)| *key == "container").map(|(_, name)| *name);
        let container = container.map(|name| {
            let wrong = || Error::invalid_option(text, format!("container={name}"), "png, ktx2, dds, exr or lobes");
            Container::by_name(name).ok_or_else(wrong)
        });
        let container = container.transpose()?;
        match path {
            Some(path) => {
                if let Some((key, _)) = pairs.iter().find(|(key, _)| !["name", "container"].contains(key)) {
                    let expected = "name and container only, for the folder's manifest says the rest";
                    return Err(Error::invalid_option(text, format!("{key} beside a folder or file"), expected));
                }
                Self::at(text, Path::new(path), container, name)
            }
            None if container.is_some() => Err(Error::invalid_option(
                text,
                "a container without a folder",
                "FOLDER,container=png|ktx2|dds|exr|lobes",
            )),
            None => {
                let inputs = maps(text, &pairs, reading)?;
                let name = name.unwrap_or_else(|| inputs.name.clone());
                let source = Source::Maps(Box::new(Inputs { name: name.clone(), ..inputs }));
                Ok(Self { name, text: text.into(), source })
            }
        }
    }

    /// A folder or a lobes file.
    fn at(text: &str, path: &Path, container: Option<Container>, name: Option<String>) -> Result<Self> {
        let whole = path.canonicalize().map_err(|_| Error::invalid(path, "no such folder or file", EXPECTED))?;
        let own = |name: Option<&std::ffi::OsStr>| name.unwrap_or_default().to_string_lossy().into_owned();
        if whole.is_dir() {
            let asked = container.map(|container| format!(" ({})", container.name())).unwrap_or_default();
            let name = name.unwrap_or_else(|| own(whole.file_name()) + &asked);
            return Ok(Self { name, text: text.into(), source: Source::Folder(path.to_owned(), container) });
        }
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
            return Err(Error::invalid(path, "a single file", EXPECTED));
        }
        if container.is_some() {
            return Err(Error::invalid(
                path,
                "a container of a single file",
                "FOLDER,container=png|ktx2|dds|exr|lobes",
            ));
        }
        let name = name.unwrap_or_else(|| own(path.file_stem()));
        Ok(Self { name, text: text.into(), source: Source::Lobes(path.to_owned()) })
    }

    /// Reads all levels.
    pub fn read(&self) -> Result<LevelChain> {
        match &self.source {
            Source::Folder(folder, container) => read_folder(folder, *container),
            Source::Lobes(file) => read_lobes(file),
            Source::Maps(inputs) => read_maps(inputs),
        }
    }
}

/// Parts between commas; one without `=` belongs to the path before it, which then has a comma in it.
fn parts(text: &str) -> Vec<&str> {
    let mut cuts = vec![0];
    for (at, _) in text.match_indices(',') {
        if text[at + 1..].split(',').next().is_some_and(|part| part.is_empty() || part.contains('=')) {
            cuts.push(at + 1);
        }
    }
    let ends = cuts.iter().skip(1).map(|cut| cut - 1).chain([text.len()]);
    cuts.iter().zip(ends).map(|(&from, to)| &text[from..to]).collect()
}

/// Maps by keys.
fn maps(text: &str, pairs: &[(&str, &str)], reading: &ReadingArgs) -> Result<Inputs> {
    let mut set = Inputs {
        normal_y: reading.normal_y,
        normal_z: reading.normal_z,
        normal_range: reading.normal_range,
        normal_scale: Some(reading.normal_scale),
        wrap: reading.wrap(),
        ..Inputs::default()
    };
    let mut widths = 0;
    for &(key, value) in pairs {
        let wrong = |expected: &str| Error::invalid_option(text, format!("{key}={value}"), expected);
        let subject = || format!("{key}={value} in {text}");
        match key {
            "normal" => set.normal = Some(value.into()),
            "anisotropy" => set.anisotropy = Some(value.into()),
            "roughness" => set.roughness = inputs::roughness(&subject(), value)?,
            "smoothness" => set.roughness = inputs::smoothness(&subject(), value)?,
            "orm" => {
                set.roughness = RoughnessInput::Roughness(ChannelRef { path: value.into(), channel: Some(1) });
            }
            "normal-y" => {
                set.normal_y = ValueEnum::from_str(value, true).map_err(|_| wrong("opengl or directx"))?;
            }
            "normal-z" => {
                set.normal_z = NormalZ::from_str(value, true).map_err(|_| wrong("auto, stored or rebuild"))?;
            }
            "normal-range" => {
                set.normal_range = NormalRange::from_str(value, true).map_err(|_| wrong("auto, signed or unsigned"))?;
            }
            "normal-scale" => set.normal_scale = Some(value.parse().map_err(|_| wrong("a number"))?),
            _ => {}
        }
        widths += usize::from(["roughness", "smoothness", "orm"].contains(&key));
    }
    if widths > 1 {
        return Err(Error::invalid_option(text, "several of roughness, smoothness and orm", "one of them"));
    }
    set.name = default_name(&set);
    Ok(set)
}

/// The first file's name, without the level.
fn default_name(set: &Inputs) -> String {
    let first = set.normal.as_deref().or(set.roughness.file());
    let stem = first.and_then(|path| path.file_stem()).unwrap_or_default().to_string_lossy();
    let stem = stem.rsplit_once('%').map_or(&*stem, |(stem, _)| stem).replace("%%", "%");
    let stem = stem.trim_end_matches(|c: char| !c.is_alphanumeric());
    if stem.is_empty() { "chain".into() } else { stem.into() }
}
