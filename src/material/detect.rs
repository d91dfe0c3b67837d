//! Which file is which, by name.
//!
//! Names are cut into words at punctuation, at a lower-case letter before a capital, and at digits; a role word may
//! stand anywhere (`brown_mud_Nor_8k`, `Metal009_2K_NormalDX`), and the longest run of words that means something
//! wins. Nothing is guessed between two candidates: that is an error that lists them and names the flag.

use std::path::{Path, PathBuf};

use super::NormalY;
use super::load::{ChannelRef, Inputs, RoughnessInput};
use crate::error::{Error, Result};

/// What a file name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Normal(Option<NormalY>),
    Roughness,
    Smoothness,
    /// A packed map with perceptual roughness in this channel.
    Packed(usize),
    /// Normals in RGB, roughness in alpha.
    NormalRoughness,
    Anisotropy,
    Height,
    /// Something that is not ours: colour, occlusion, metal alone, ...
    Ignored,
}

use Kind::*;

const OPENGL: Kind = Normal(Some(NormalY::OpenGl));
const DIRECTX: Kind = Normal(Some(NormalY::DirectX));

/// Joined words and what they mean. Single letters count only as the last word.
const WORDS: &[(&[&str], Kind)] = &[
    (&["normal", "normals", "normalmap", "nor", "nrm", "nrml", "norm", "n", "nm"], Normal(None)),
    (&["normalgl", "normalogl", "normalopengl", "norgl", "nrmgl", "normgl"], OPENGL),
    (&["normaldx", "normaldirectx", "nordx", "nrmdx", "normdx"], DIRECTX),
    (&["roughness", "roughnessmap", "rough", "rgh", "r"], Roughness),
    (&["gloss", "glossiness", "smoothness", "smooth", "g"], Smoothness),
    (&["orm", "arm", "aorm", "occlusionroughnessmetallic", "occlusionroughmetal", "aoroughmetal"], Packed(1)),
    (&["metallicroughness", "metalroughness", "metalrough", "metalrgh", "mr"], Packed(1)),
    (&["mra", "mrao"], Packed(1)),
    (&["rma", "rmo"], Packed(0)),
    (&["normalroughness", "nrmrgh", "nrmrough", "normrough"], NormalRoughness),
    (&["anisotropy", "aniso", "anisotropic"], Anisotropy),
    (&["height", "heightmap", "displacement", "disp", "h"], Height),
    (&["basecolor", "basecolour", "albedo", "diffuse", "diff", "color", "colour", "col", "alb"], Ignored),
    (&["albedoheight", "albht", "metallic", "metalness", "metal", "mtl", "m"], Ignored),
    (&["ao", "ambientocclusion", "occlusion", "occ", "opacity", "alpha", "mask", "emissive", "emission"], Ignored),
    (&["specular", "spec", "bump", "depth", "transmission", "subsurface", "sss", "cavity"], Ignored),
];

/// Extensions that are read.
const EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "tif", "tiff", "tga", "bmp", "webp", "hdr", "exr"];

/// Lower-case words of a file stem.
fn words(stem: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in stem.chars() {
        let cut = !c.is_alphanumeric()
            || (before.is_lowercase() && c.is_uppercase())
            || (before.is_ascii_digit() != c.is_ascii_digit() && before.is_alphanumeric());
        if cut && !words.last().is_some_and(String::is_empty) {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().expect("never empty").extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|w| !w.is_empty());
    words
}

/// The kind that a name means, and the words that are left: what is common to the maps of one material.
fn kind_of(stem: &str) -> Option<(Kind, String)> {
    let words = words(stem);
    let mut best: Option<(usize, usize, Kind)> = None;
    for start in 0..words.len() {
        for end in start + 1..=(start + 4).min(words.len()) {
            let joined = words[start..end].concat();
            if joined.len() == 1 && end != words.len() {
                continue;
            }
            let kind = WORDS.iter().find(|(names, _)| names.contains(&joined.as_str())).map(|(_, kind)| *kind);
            if let Some(kind) = kind {
                // The longest run; of equals a role that is ours before one that is not, then the last.
                let rank = |length: usize, single: bool, kind: Kind| (!single, kind != Ignored, length);
                let new = rank(end - start, joined.len() == 1, kind);
                let old = best.map(|(s, e, k)| rank(e - s, words[s..e].concat().len() == 1, k));
                if old.is_none_or(|old| new >= old) {
                    best = Some((start, end, kind));
                }
            }
        }
    }
    let (start, end, kind) = best?;
    let rest: Vec<&str> = words[..start].iter().chain(&words[end..]).map(String::as_str).collect();
    Some((kind, rest.join("_")))
}

/// The materials in a folder: its own maps by their common names, or else those of its sub-folders.
///
/// # Errors
/// Two candidates for one role; a folder without any map.
pub fn folder(folder: &Path, want: NormalY) -> Result<Vec<Inputs>> {
    let mut found = maps_in(folder, want)?;
    if found.is_empty() {
        for sub in entries(folder)?.into_iter().filter(|path| path.is_dir()) {
            found.extend(maps_in(&sub, want)?);
        }
    }
    if found.is_empty() {
        return Err(Error::invalid(
            folder,
            "no texture set",
            "files named like NAME_normal.png, NAME_roughness.png or NAME_orm.png; or give them with --normal and --roughness",
        ));
    }
    Ok(found)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let read = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
    let paths: std::io::Result<Vec<_>> = read.map(|entry| Ok(entry?.path())).collect();
    let mut paths = paths.map_err(|e| Error::io(folder, e))?;
    paths.sort();
    Ok(paths)
}

fn maps_in(folder: &Path, want: NormalY) -> Result<Vec<Inputs>> {
    let is_picture = |path: &PathBuf| {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        path.is_file() && EXTENSIONS.contains(&extension.as_str())
    };
    let mut sets: Vec<(String, Vec<(Kind, PathBuf)>)> = Vec::new();
    for path in entries(folder)?.into_iter().filter(is_picture) {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let Some((kind, key)) = kind_of(&stem) else { continue };
        match sets.iter_mut().find(|(k, _)| *k == key) {
            Some((_, files)) => files.push((kind, path)),
            None => sets.push((key, vec![(kind, path)])),
        }
    }
    let folder_name = folder.canonicalize().ok().and_then(|p| Some(p.file_name()?.to_string_lossy().into_owned()));
    let mut found = Vec::new();
    for (key, files) in sets {
        let name = if key.is_empty() { folder_name.clone().unwrap_or_else(|| "material".into()) } else { key };
        found.extend(set(folder, name, &files, want)?);
    }
    Ok(found)
}

/// One material from the files of one common name; `None` if there is nothing to fold.
fn set(folder: &Path, name: String, files: &[(Kind, PathBuf)], want: NormalY) -> Result<Option<Inputs>> {
    let of = |wanted: &dyn Fn(Kind) -> bool| -> Vec<&PathBuf> {
        files.iter().filter(|(kind, _)| wanted(*kind)).map(|(_, path)| path).collect()
    };
    let one = |what: &str, flag: &str, candidates: Vec<&PathBuf>| match candidates[..] {
        [] => Ok(None),
        [only] => Ok(Some(only.clone())),
        _ => {
            let names: Vec<_> =
                candidates.iter().map(|p| p.file_name().unwrap_or_default().to_string_lossy()).collect();
            Err(Error::invalid(
                folder,
                format!("{} candidates for the {what} map: {}", names.len(), names.join(", ")),
                format!("one; choose with {flag} FILE"),
            ))
        }
    };
    let mut inputs = Inputs { name, normal_y: want, ..Inputs::default() };
    // Of a pair in both conventions, the one that is wanted; an unmarked map stands for the wanted one.
    let other = if want == NormalY::OpenGl { DIRECTX } else { OPENGL };
    let marked = of(&|k| k == Normal(Some(want)));
    let unmarked = of(&|k| k == Normal(None) || k == NormalRoughness);
    let opposite = of(&|k| k == other);
    let several = [&marked, &unmarked, &opposite].iter().filter(|c| !c.is_empty()).count() > 1;
    let chosen = [marked, unmarked].into_iter().find(|c| !c.is_empty());
    inputs.normal = match chosen {
        Some(candidates) => one("normal", "--normal", candidates)?,
        None => {
            let only = one("normal", "--normal", opposite)?;
            if let (Some(_), Normal(Some(y))) = (&only, other) {
                inputs.normal_y = y;
                inputs.notes.push(format!("the normal map's name says {}", y.describe()));
            }
            only
        }
    };
    if let (true, Some(path)) = (several, &inputs.normal) {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        inputs.notes.push(format!("several normal maps: {file} taken as {}", want.describe()));
    }
    inputs.roughness = roughness(&one, &of)?;
    inputs.anisotropy = one("anisotropy", "--anisotropy", of(&|k| k == Anisotropy))?;
    if inputs.normal.is_none() {
        inputs.height = one("height", "--height", of(&|k| k == Height))?;
    }
    let foldable = inputs.normal.is_some() || inputs.height.is_some() || inputs.roughness != RoughnessInput::Missing;
    Ok(foldable.then_some(inputs))
}

/// The roughness of a set: a map of its own before a packed one, a packed one before smoothness.
fn roughness<'a>(
    one: &dyn Fn(&str, &str, Vec<&'a PathBuf>) -> Result<Option<PathBuf>>,
    of: &dyn Fn(&dyn Fn(Kind) -> bool) -> Vec<&'a PathBuf>,
) -> Result<RoughnessInput> {
    if let Some(path) = one("roughness", "--roughness", of(&|k| k == Roughness))? {
        return Ok(RoughnessInput::Roughness(ChannelRef { path, channel: None }));
    }
    if let Some(path) = one("roughness", "--roughness", of(&|k| k == NormalRoughness))? {
        return Ok(RoughnessInput::Roughness(ChannelRef { path, channel: Some(3) }));
    }
    if let Some(path) = one("packed", "--roughness FILE:CHANNEL, not", of(&|k| matches!(k, Packed(_))))? {
        let channel = if of(&|k| k == Packed(0)).iter().any(|p| **p == path) { 0 } else { 1 };
        return Ok(RoughnessInput::Roughness(ChannelRef { path, channel: Some(channel) }));
    }
    if let Some(path) = one("smoothness", "--smoothness", of(&|k| k == Smoothness))? {
        return Ok(RoughnessInput::Smoothness(ChannelRef { path, channel: None }));
    }
    Ok(RoughnessInput::Missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_seen_in_the_wild() {
        let cases = [
            ("normal", Normal(None), ""),
            ("brown_mud_leaves_01_Nor_8k", Normal(None), "brown_mud_leaves_01_8_k"),
            ("greymarble_3_roughness-1K", Roughness, "greymarble_3_1_k"),
            ("BricksFlemishRed001_NRM_3K", Normal(None), "bricks_flemish_red_001_3_k"),
            ("BricksFlemishRed001_GLOSS_3K", Smoothness, "bricks_flemish_red_001_3_k"),
            ("Metal009_2K_NormalDX", DIRECTX, "metal_009_2_k"),
            ("Metal009_2K_Roughness", Roughness, "metal_009_2_k"),
            ("Paper001_1K-JPG_NormalGL", OPENGL, "paper_001_1_k_jpg"),
            ("tea_set_01_nor_gl_1k", OPENGL, "tea_set_01_1_k"),
            ("tea_set_01_arm_1k", Packed(1), "tea_set_01_1_k"),
            (
                "FlightHelmet_Materials_RubberWoodMat_OcclusionRoughMetal",
                Packed(1),
                "flight_helmet_materials_rubber_wood_mat",
            ),
            ("ground037_nrm_rgh", NormalRoughness, "ground_037"),
            ("albedo_height", Ignored, ""),
            ("roughness_in_g", Roughness, "in_g"),
            ("wall_n", Normal(None), "wall"),
            ("n_wall_color", Ignored, "n_wall"),
            ("rock_metallicRoughness", Packed(1), "rock"),
            ("rust_RMA", Packed(0), "rust"),
            ("normal_dx", DIRECTX, ""),
        ];
        for (stem, kind, rest) in cases {
            assert_eq!(kind_of(stem), Some((kind, rest.to_string())), "{stem}");
        }
        assert_eq!(kind_of("readme_2024"), None);
    }
}
