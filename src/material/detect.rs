//! The texture sets of a folder and of those below it, by name.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::built::Earlier;
use super::names::{EXTENSIONS, Kind, Kind::*, Meaning, Tile, common_name, meaning_of};
use super::set::{Candidate, file_name};
use super::{ChannelRef, Inputs};
use crate::error::{Error, Result};

pub use super::set::{Given, NamedMap, TextureSet, named_maps};

/// Pictures of other formats, which a folder of textures may hold.
const UNREAD: &[&str] = &["avif", "dds", "gif", "heic", "jp2", "ktx", "ktx2", "psd", "psb", "svg", "tx", "xcf"];

/// What a folder and those below it hold.
#[derive(Debug, Default)]
pub struct Found {
    /// Files by common names, whether or not there is something to fold: a folder's own before those of its sub-folders.
    pub sets: Vec<TextureSet>,
    /// What belongs to no set.
    pub passed_over: Vec<PassedOver>,
    /// Sub-folders that cannot be read.
    pub errors: Vec<Error>,
}

/// A file or folder that plays no part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassedOver {
    /// The file or folder.
    pub path: PathBuf,
    /// In words.
    pub why: String,
}

/// The texture sets of a folder and of all below it. Files that an earlier build wrote are passed over, and so is the folder
/// of the `outputs` if it lies below.
///
/// # Errors
/// A folder that cannot be read.
pub fn folder(folder: &Path, outputs: Option<&Path>) -> Result<Found> {
    let mut walk = Walk { outputs: outputs.and_then(|path| path.canonicalize().ok()), ..Walk::default() };
    walk.look(folder, Path::new(""))?;
    Ok(walk.found)
}

/// What a material is called after one of its files: the name without what says which map it is, `wall` of
/// `wall_normal.png`, and all of it where nothing else is left.
pub fn named_after(file: &Path) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    match meaning_of(&stem) {
        Some(Meaning { material, tile, .. }) if !material.is_empty() => {
            tile.map_or_else(|| material.clone(), |tile| format!("{material}.{}", tile.text))
        }
        _ => stem.into_owned(),
    }
}

/// That nothing in a folder can be folded.
pub fn nothing(folder: &Path) -> Error {
    let expected = "files named like NAME_normal.png, NAME_roughness.png or NAME_orm.png; or give them with --normal and \
                    --roughness";
    Error::invalid(folder, "no texture set", expected)
}

/// Which of these materials are only roughness, in a folder where others have bumps: such a map is not a material, for it
/// would only be averaged.
pub fn widths_alone(materials: &[(&TextureSet, &Result<Inputs>)]) -> Vec<bool> {
    let bumpy = |inputs: &Inputs| inputs.normal.is_some() || inputs.height.is_some();
    let alone = |(set, inputs): &(&TextureSet, &Result<Inputs>)| {
        let others = materials.iter().filter(|(other, _)| other.folder == set.folder);
        inputs.as_ref().is_ok_and(|inputs| !bumpy(inputs))
            && others.into_iter().any(|(_, inputs)| inputs.as_ref().is_ok_and(bumpy))
    };
    materials.iter().map(alone).collect()
}

#[derive(Default)]
struct Walk {
    found: Found,
    /// Folders that were looked at: links may lead back.
    seen: HashSet<PathBuf>,
    outputs: Option<PathBuf>,
}

impl Walk {
    fn pass_over(&mut self, path: &Path, why: impl Into<String>) {
        self.found.passed_over.push(PassedOver { path: path.to_owned(), why: why.into() });
    }

    fn look(&mut self, folder: &Path, below: &Path) -> Result<()> {
        let place = folder.canonicalize().map_err(|e| Error::io(folder, e))?;
        if self.outputs.as_ref() == Some(&place) && !below.as_os_str().is_empty() {
            self.pass_over(folder, "the outputs go there");
            return Ok(());
        }
        if !self.seen.insert(place.clone()) {
            return Ok(());
        }
        let read = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
        let paths: std::io::Result<Vec<_>> = read.map(|entry| Ok(entry?.path())).collect();
        let mut paths = paths.map_err(|e| Error::io(folder, e))?;
        // Hidden ones are nobody's textures: of version control, of previews, of another system's attributes.
        paths.retain(|path| !file_name(path).starts_with('.') && file_name(path) != "__MACOSX");
        paths.sort();
        let groups = self.group(folder, &paths);
        let name = place.file_name().map_or_else(|| "material".into(), |name| name.to_string_lossy().into_owned());
        for Group { material, tile, files } in groups {
            let base = if material.is_empty() { name.clone() } else { material };
            let name = tile.as_ref().map_or_else(|| base.clone(), |tile| format!("{base}.{}", tile.text));
            let (folder, below) = (folder.to_owned(), below.to_owned());
            self.found.sets.push(TextureSet { name, base, tile, folder, below, files });
        }
        for sub in paths.iter().filter(|path| path.is_dir()) {
            if let Err(error) = self.look(sub, &below.join(sub.file_name().unwrap_or_default())) {
                self.found.errors.push(error);
            }
        }
        Ok(())
    }

    /// The pictures of a folder by their common names.
    fn group(&mut self, folder: &Path, paths: &[PathBuf]) -> Vec<Group> {
        let built = Earlier::read(folder).unwrap_or_default();
        let mut groups: Vec<Group> = Vec::new();
        let mut written = 0;
        for path in paths.iter().filter(|path| path.is_file()) {
            let name = file_name(path);
            if built.wrote(&name) {
                written += 1;
                continue;
            }
            if !is_picture(path) {
                let ending = ending(path);
                if UNREAD.contains(&ending.as_str()) {
                    self.pass_over(path, format!(".{ending} is not looked for in folders"));
                }
                continue;
            }
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let Some(Meaning { kind, channel, material, word, tile }) = meaning_of(&stem) else {
                self.pass_over(path, "no word in its name says what it is");
                continue;
            };
            let file = Candidate { kind, file: ChannelRef { path: path.clone(), channel }, word };
            let same = |group: &&mut Group| group.material.eq_ignore_ascii_case(&material) && group.tile == tile;
            match groups.iter_mut().find(same) {
                Some(group) => group.files.push(file),
                None => groups.push(Group { material, tile, files: vec![file] }),
            }
        }
        if written > 0 {
            self.pass_over(folder, format!("{written} files in it that an earlier build wrote"));
        }
        join_resolutions(without_lone_1024(groups))
    }
}

/// Files of one common name, which may be empty.
struct Group {
    material: String,
    tile: Option<Tile>,
    files: Vec<Candidate>,
}

/// `wall_normal_1024` is more often a resolution than a tile: it is one only beside other tiles.
fn without_lone_1024(mut groups: Vec<Group>) -> Vec<Group> {
    let numbers: Vec<_> =
        groups.iter().map(|g| (common_name(&g.material), g.tile.as_ref().map(|t| t.number))).collect();
    for (i, group) in groups.iter_mut().enumerate() {
        let other =
            |(name, number): &(Vec<String>, Option<u32>)| *name == numbers[i].0 && number.is_some_and(|n| n != 1024);
        if group.tile.as_ref().is_some_and(|tile| tile.text == "1024") && !numbers.iter().any(other) {
            group.tile = None;
            group.material += if group.material.is_empty() { "1024" } else { "_1024" };
        }
    }
    groups
}

/// Joins sets whose names differ in resolution only, unless both hold the same kind of map: those are two sizes of one
/// material.
fn join_resolutions(groups: Vec<Group>) -> Vec<Group> {
    let mut joined: Vec<Group> = Vec::new();
    for group in groups {
        let apart = |other: &Group| other.files.iter().all(|a| group.files.iter().all(|b| !rivals(a.kind, b.kind)));
        let same = |other: &Group| {
            other.tile == group.tile && common_name(&other.material) == common_name(&group.material) && apart(other)
        };
        match joined.iter_mut().find(|other| same(other)) {
            Some(other) => other.files.extend(group.files),
            None => joined.push(group),
        }
    }
    joined
}

/// Whether two kinds of map would play one part of a folded material.
fn rivals(a: Kind, b: Kind) -> bool {
    match (a, b) {
        (Packed(a), Packed(b)) => a.width == b.width && a.smooth == b.smooth,
        (Ignored(_) | Occlusion | Metal | Mask, _) => false,
        _ => a == b,
    }
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

pub(super) fn is_picture(path: &Path) -> bool {
    path.is_file() && EXTENSIONS.contains(&ending(path).as_str())
}
