//! Which file is which, by name.
//!
//! Names are cut into words at punctuation, at a lower-case letter before a capital, and at digits; a role word may
//! stand anywhere (`brown_mud_Nor_8k`, `Metal009_2K_NormalDX`), and the last run of words that means something wins
//! (`rough_wood_normal`). Nothing is guessed between two candidates: that is an error that lists them and names the flag.

use std::path::{Path, PathBuf};

use super::NormalY;
use super::built::Earlier;
use super::{ChannelRef, Inputs, RoughnessInput};
use crate::error::{Error, Result};

/// What a file name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Normal(Option<NormalY>),
    Roughness,
    Smoothness,
    /// A packed map with perceptual roughness in this channel.
    Packed(usize),
    /// A packed map with smoothness in this channel.
    PackedSmoothness(usize),
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
    // Not "metal roughness": that is the roughness of something called metal.
    (&["metallicroughness", "roughnessmetallic", "mr"], Packed(1)),
    (&["mra", "mrao"], Packed(1)),
    (&["rma", "rmo"], Packed(0)),
    (&["normalroughness", "nrmrgh", "nrmrough", "normrough"], NormalRoughness),
    (&["metallicsmoothness", "metallicgloss", "maskmap"], PackedSmoothness(3)),
    (&["anisotropy", "aniso", "anisotropic"], Anisotropy),
    (&["height", "heightmap", "displacement", "disp", "h"], Height),
    (&["basecolor", "basecolour", "albedo", "diffuse", "diff", "color", "colour", "col", "alb"], Ignored),
    (&["albedoheight", "albht", "metallic", "metalness", "metal", "mtl", "m"], Ignored),
    (&["ao", "ambientocclusion", "occlusion", "occ", "opacity", "alpha", "mask", "emissive", "emission"], Ignored),
    (&["specular", "spec", "bump", "depth", "transmission", "subsurface", "sss", "cavity"], Ignored),
];

/// Extensions that are read.
const EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "tif", "tiff", "tga", "bmp", "webp", "hdr", "exr"];

/// Lower-case words of a file stem, and where each stands.
fn words(stem: &str) -> Vec<(String, std::ops::Range<usize>)> {
    let mut words: Vec<(String, std::ops::Range<usize>)> = Vec::new();
    let mut before = ' ';
    for (at, c) in stem.char_indices() {
        let cut = !before.is_alphanumeric()
            || (before.is_lowercase() && c.is_uppercase())
            || before.is_ascii_digit() != c.is_ascii_digit();
        if c.is_alphanumeric() {
            if cut {
                words.push((String::new(), at..at));
            }
            let (word, range) = words.last_mut().expect("pushed");
            word.extend(c.to_lowercase());
            range.end = at + c.len_utf8();
        }
        before = c;
    }
    words
}

/// Whether a word may be said of something else: of a material (`rough_wood`, `normal_metal`) or of another map
/// (`normal_alpha`). `rough` and `smooth` name a map where nothing but a resolution or a format follows.
fn is_weak(word: &str, after: &[(String, std::ops::Range<usize>)]) -> bool {
    let formal = |w: &str| {
        w.chars().all(|c| c.is_ascii_digit()) || ["k", "in", "r", "g", "b", "a"].contains(&w) || EXTENSIONS.contains(&w)
    };
    match word {
        "rough" | "smooth" => after.iter().any(|(w, _)| !formal(w)),
        _ => ["metal", "alpha", "mask", "depth", "bump", "spec", "specular"].contains(&word),
    }
}

/// What a name means.
#[derive(Debug, PartialEq)]
struct Meaning {
    kind: Kind,
    /// Channel named by a trailing `in_g` or the like.
    channel: Option<usize>,
    /// The rest of the name, which the maps of one material have in common.
    material: String,
}

fn meaning_of(stem: &str) -> Option<Meaning> {
    let words = words(stem);
    let mut best = None;
    for start in 0..words.len() {
        for end in start + 1..=(start + 4).min(words.len()) {
            let joined: String = words[start..end].iter().map(|(word, _)| word.as_str()).collect();
            let single = joined.len() == 1;
            let Some((_, kind)) = WORDS.iter().find(|(names, _)| names.contains(&joined.as_str())) else { continue };
            // What ends last says what the map is; before it stands the material's own name, which may hold such
            // words too. Of those that end together, the longest. Words that qualify as often as they name count only
            // if there is no other.
            let rank = (!is_weak(&joined, &words[end..]), end, end - start);
            let last = end == words.len() && start > 0 && words[start - 1].0 != "in";
            if (!single || last || words.len() == 1) && best.as_ref().is_none_or(|(old, _, _)| rank >= *old) {
                best = Some((rank, start..end, *kind));
            }
        }
    }
    let (_, run, kind) = best?;
    let (mut end, mut channel) = (run.end, None);
    if let [(word, _), (letter, _), ..] = &words[end..]
        && word == "in"
        && let Some(c) = ["r", "g", "b", "a"].iter().position(|name| name == letter)
    {
        (end, channel) = (end + 2, Some(c));
    }
    let separator = |c: char| !c.is_alphanumeric();
    let (head, tail) = (&stem[..words[run.start].1.start], &stem[words[end - 1].1.end..]);
    let (head, tail) = (head.trim_matches(separator), tail.trim_matches(separator));
    let joint = if head.is_empty() || tail.is_empty() { "" } else { "_" };
    Some(Meaning { kind, channel, material: format!("{head}{joint}{tail}") })
}

/// What the caller knows.
#[derive(Clone, Copy)]
struct Wanted {
    normal_y: NormalY,
    width_given: bool,
}

/// What the name of a normal map says about its convention.
pub fn convention(path: &Path) -> Option<NormalY> {
    match meaning_of(&path.file_stem()?.to_string_lossy())?.kind {
        Normal(y) => y,
        _ => None,
    }
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

/// The words of a material's name without resolutions (`4k`), which its maps need not share.
fn common_name(material: &str) -> Vec<String> {
    let words: Vec<_> = words(material).into_iter().map(|(word, _)| word).collect();
    let number = |word: &String| word.chars().all(|c| c.is_ascii_digit());
    let resolution = |i: usize| {
        let follows = |i: usize| words.get(i + 1).is_some_and(|next| next == "k") && number(&words[i]);
        follows(i) || (i > 0 && follows(i - 1))
    };
    (0..words.len()).filter(|i| !resolution(*i)).map(|i| words[i].clone()).collect()
}

fn is_picture(path: &Path) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_seen_in_the_wild() {
        let cases = [
            ("normal", Normal(None), ""),
            ("brown_mud_leaves_01_Nor_8k", Normal(None), "brown_mud_leaves_01_8k"),
            ("greymarble_3_roughness-1K", Roughness, "greymarble_3_1K"),
            ("BricksFlemishRed001_NRM_3K", Normal(None), "BricksFlemishRed001_3K"),
            ("BricksFlemishRed001_GLOSS_3K", Smoothness, "BricksFlemishRed001_3K"),
            ("Metal009_2K_NormalDX", DIRECTX, "Metal009_2K"),
            ("Metal009_2K_Roughness", Roughness, "Metal009_2K"),
            ("Paper001_1K-JPG_NormalGL", OPENGL, "Paper001_1K-JPG"),
            ("tea_set_01_nor_gl_1k", OPENGL, "tea_set_01_1k"),
            ("tea_set_01_arm_1k", Packed(1), "tea_set_01_1k"),
            (
                "FlightHelmet_Materials_RubberWoodMat_OcclusionRoughMetal",
                Packed(1),
                "FlightHelmet_Materials_RubberWoodMat",
            ),
            ("ground037_nrm_rgh", NormalRoughness, "ground037"),
            ("albedo_height", Ignored, ""),
            ("wall_n", Normal(None), "wall"),
            ("n_wall_color", Ignored, "n_wall"),
            ("rusty_metal_roughness", Roughness, "rusty_metal"),
            ("rock_metallicRoughness", Packed(1), "rock"),
            ("rust_RMA", Packed(0), "rust"),
            ("normal_dx", DIRECTX, ""),
            ("rough_wood_nor_gl_1k", OPENGL, "rough_wood_1k"),
            ("rough_wood_rough_1k", Roughness, "rough_wood_1k"),
            ("rough_wood_diff_1k", Ignored, "rough_wood_1k"),
            ("SmoothConcrete_Color", Ignored, "SmoothConcrete"),
            ("T_Height_Marker_N", Normal(None), "T_Height_Marker"),
            ("wall_MetallicSmoothness", PackedSmoothness(3), "wall"),
            ("wall_normal_metal", Normal(None), "wall_metal"),
            ("rock_normal_alpha", Normal(None), "rock_alpha"),
            ("Normal_Rough_Stone", Normal(None), "Rough_Stone"),
            ("wall_rough_1k", Roughness, "wall_1k"),
        ];
        for (stem, kind, material) in cases {
            let meaning = Meaning { kind, channel: None, material: material.into() };
            assert_eq!(meaning_of(stem), Some(meaning), "{stem}");
        }
        let meaning = Meaning { kind: Roughness, channel: Some(1), material: "veneer_1k".into() };
        assert_eq!(meaning_of("veneer_rough_in_g_1k"), Some(meaning));
        assert_eq!(meaning_of("readme_2024"), None);
    }
}
