//! Which file is which in a folder, by name. Nothing is guessed between two candidates: that is an error
//! that lists them and names the flag.

use std::path::{Path, PathBuf};

use super::NormalY;
use super::built::Earlier;
use super::names::{EXTENSIONS, Kind, Kind::*, Meaning, common_name, meaning_of};
use super::{ChannelRef, Inputs, RoughnessInput};
use crate::error::{Error, Result};

/// What the caller knows.
#[derive(Clone, Copy)]
struct Wanted {
    normal_y: NormalY,
    width_given: bool,
}

/// The materials in a folder: its own maps by their common names, or else those of its sub-folders, however deep.
/// Files that an earlier build wrote are passed over. A set whose roles cannot be told is an error of its own;
/// roughness is not looked for where it is given.
///
/// # Errors
/// A folder that cannot be read, or holds no texture set at all.
pub fn folder(folder: &Path, want: NormalY, width_given: bool) -> Result<Vec<Result<Inputs>>> {
    let found = sets_below(folder, Wanted { normal_y: want, width_given }, &mut Vec::new())?;
    if found.is_empty() {
        let expected = "files named like NAME_normal.png, NAME_roughness.png or NAME_orm.png; or give them with \
                        --normal and --roughness";
        return Err(Error::invalid(folder, "no texture set", expected));
    }
    Ok(found)
}

fn sets_below(folder: &Path, want: Wanted, seen: &mut Vec<PathBuf>) -> Result<Vec<Result<Inputs>>> {
    // Links may lead back.
    let place = folder.canonicalize().map_err(|e| Error::io(folder, e))?;
    if seen.contains(&place) {
        return Ok(Vec::new());
    }
    seen.push(place);
    let read = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
    let paths: std::io::Result<Vec<_>> = read.map(|entry| Ok(entry?.path())).collect();
    let mut paths = paths.map_err(|e| Error::io(folder, e))?;
    paths.sort();
    let built = Earlier::read(folder).unwrap_or_default();
    let mut sets: Vec<(String, Vec<Candidate>)> = Vec::new();
    for path in paths.iter().filter(|path| is_picture(path)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        if built.wrote(&name) {
            continue;
        }
        let Some(Meaning { kind, channel, material }) = meaning_of(&stem) else { continue };
        let file = Candidate { kind, file: ChannelRef { path: path.clone(), channel } };
        match sets.iter_mut().find(|(name, _)| name.eq_ignore_ascii_case(&material)) {
            Some((_, files)) => files.push(file),
            None => sets.push((material, vec![file])),
        }
    }
    let sets = join_resolutions(sets);
    let folder_name = || Some(folder.canonicalize().ok()?.file_name()?.to_string_lossy().into_owned());
    let named = sets.into_iter().map(|(name, files)| {
        let name = if name.is_empty() { folder_name().unwrap_or_else(|| "material".into()) } else { name };
        set(folder, name, &files, want).transpose()
    });
    let mut found: Vec<_> = named.flatten().collect();
    pass_over_widths_alone(&mut found);
    if found.is_empty() {
        for sub in paths.iter().filter(|path| path.is_dir()) {
            found.extend(sets_below(sub, want, seen)?);
        }
    }
    Ok(found)
}

/// A roughness map whose name no normal map shares is not a material, where others are: it would only be averaged.
fn pass_over_widths_alone(found: &mut Vec<Result<Inputs>>) {
    let bumpy = |set: &Result<Inputs>| set.as_ref().map_or(true, |set| set.normal.is_some() || set.height.is_some());
    if !found.iter().any(|set| set.is_ok() && bumpy(set)) {
        return;
    }
    let alone: Vec<String> =
        found.iter().filter(|set| !bumpy(set)).filter_map(|set| Some(set.as_ref().ok()?.name.clone())).collect();
    found.retain(bumpy);
    if let (Some(first), false) = (found.iter_mut().find_map(|set| set.as_mut().ok()), alone.is_empty()) {
        let names = alone.join(", ");
        let warning = format!(
            "passed over, roughness without a normal map of its name: {names}. If they belong together, name them with \
             --normal and --roughness"
        );
        first.warnings.push(warning);
    }
}

/// Joins sets whose names differ in resolution only, unless both hold the same kind of map: those are two sizes of one
/// material.
fn join_resolutions(sets: Vec<(String, Vec<Candidate>)>) -> Vec<(String, Vec<Candidate>)> {
    let mut joined: Vec<(String, Vec<Candidate>)> = Vec::new();
    for (name, files) in sets {
        let apart =
            |other: &[Candidate]| other.iter().all(|a| files.iter().all(|b| a.kind != b.kind || a.kind == Ignored));
        match joined.iter_mut().find(|(n, other)| common_name(n) == common_name(&name) && apart(other)) {
            Some((_, other)) => other.extend(files),
            None => joined.push((name, files)),
        }
    }
    joined
}

pub(super) fn is_picture(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    path.is_file() && EXTENSIONS.contains(&extension.as_str())
}

/// A file that may play a role.
struct Candidate {
    kind: Kind,
    file: ChannelRef,
}

/// The files of one common name.
struct Candidates<'a> {
    folder: &'a Path,
    files: &'a [Candidate],
}

impl Candidates<'_> {
    /// The only file that `wanted` accepts, if there is one; two are an error.
    fn one(&self, what: &str, flag: &str, wanted: impl Fn(Kind) -> bool) -> Result<Option<ChannelRef>> {
        let found: Vec<_> = self.files.iter().filter(|c| wanted(c.kind)).map(|c| &c.file).collect();
        match found[..] {
            [] => Ok(None),
            [only] => Ok(Some(only.clone())),
            _ => {
                let names: Vec<_> =
                    found.iter().map(|c| c.path.file_name().unwrap_or_default().to_string_lossy()).collect();
                let alone = if flag.starts_with("--normal") || flag.starts_with("--height") {
                    " without the folder"
                } else {
                    ""
                };
                let found = format!("{} candidates for the {what} map: {}", names.len(), names.join(", "));
                Err(Error::invalid(self.folder, found, format!("one; choose with {flag} FILE{alone}")))
            }
        }
    }

    fn any(&self, wanted: impl Fn(Kind) -> bool) -> bool {
        self.files.iter().any(|c| wanted(c.kind))
    }

    /// A roughness map before a packed one, a packed one before smoothness.
    fn roughness(&self) -> Result<RoughnessInput> {
        let kinds: [(&str, &[Kind]); 5] = [
            ("roughness", &[Roughness]),
            ("roughness", &[NormalRoughness]),
            ("packed", &[Packed(0), Packed(1)]),
            ("smoothness", &[Smoothness]),
            ("packed smoothness", &[PackedSmoothness(3)]),
        ];
        for (what, kinds) in kinds {
            let flag = if what.ends_with("smoothness") { "--smoothness" } else { "--roughness" };
            let Some(mut file) = self.one(what, flag, |k| kinds.contains(&k))? else { continue };
            let kind = self.files.iter().find(|c| c.file.path == file.path).map(|c| c.kind);
            file.channel = file.channel.or(match kind {
                Some(NormalRoughness) => Some(3),
                Some(Packed(channel) | PackedSmoothness(channel)) => Some(channel),
                _ => None,
            });
            let smooth = matches!(kind, Some(Smoothness | PackedSmoothness(_)));
            return Ok(if smooth { RoughnessInput::Smoothness(file) } else { RoughnessInput::Roughness(file) });
        }
        Ok(RoughnessInput::Missing)
    }
}

/// One material from the files of one common name; `None` if there is nothing to fold.
fn set(folder: &Path, name: String, files: &[Candidate], wanted: Wanted) -> Result<Option<Inputs>> {
    let want = wanted.normal_y;
    let candidates = Candidates { folder, files };
    let path = |file: Option<ChannelRef>| file.map(|f| f.path);
    let mut inputs = Inputs { name, normal_y: want, ..Inputs::default() };
    // Of maps in both conventions the one that is wanted; an unmarked map stands for the wanted one.
    let other = if want == NormalY::OpenGl { NormalY::DirectX } else { NormalY::OpenGl };
    let marked = |k| k == Normal(Some(want));
    let unmarked = |k| k == Normal(None) || k == NormalRoughness;
    let opposite = |k| k == Normal(Some(other));
    inputs.normal = if candidates.any(marked) {
        path(candidates.one("normal", "--normal", marked)?)
    } else if candidates.any(unmarked) {
        path(candidates.one("normal", "--normal", unmarked)?)
    } else if candidates.any(opposite) {
        inputs.normal_y = other;
        inputs.notes.push(format!("the normal map's name says {}", other.describe()));
        path(candidates.one("normal", "--normal", opposite)?)
    } else {
        None
    };
    let kinds = [candidates.any(marked), candidates.any(unmarked), candidates.any(opposite)];
    if let (true, Some(path)) = (kinds.iter().filter(|k| **k).count() > 1, &inputs.normal) {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        inputs.notes.push(format!("several normal maps: {file} taken as {}", want.describe()));
    }
    if !wanted.width_given {
        inputs.roughness = candidates.roughness()?;
    }
    inputs.anisotropy = path(candidates.one("anisotropy", "--anisotropy", |k| k == Anisotropy)?);
    if inputs.normal.is_none() {
        inputs.height = path(candidates.one("height", "--height", |k| k == Height)?);
    }
    let foldable = inputs.normal.is_some() || inputs.height.is_some() || inputs.roughness != RoughnessInput::Missing;
    Ok(foldable.then_some(inputs))
}
