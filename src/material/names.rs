//! What a file name says.
//!
//! Names are cut into words at punctuation, at a lower-case letter before a capital, and at digits; a role word may
//! stand anywhere (`brown_mud_Nor_8k`, `Metal009_2K_NormalDX`), and the last run of words that means something wins
//! (`rough_wood_normal`).

use std::path::Path;

use super::NormalY;

/// What a file name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
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
pub(super) const EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "tif", "tiff", "tga", "bmp", "webp", "hdr", "exr"];

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
pub(super) struct Meaning {
    pub kind: Kind,
    /// Channel named by a trailing `in_g` or the like.
    pub channel: Option<usize>,
    /// The rest of the name, which the maps of one material have in common.
    pub material: String,
}

pub(super) fn meaning_of(stem: &str) -> Option<Meaning> {
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

/// What the name of a normal map says about its convention.
pub(super) fn convention(path: &Path) -> Option<NormalY> {
    match meaning_of(&path.file_stem()?.to_string_lossy())?.kind {
        Normal(y) => y,
        _ => None,
    }
}

/// The words of a material's name without resolutions (`4k`), which its maps need not share.
pub(super) fn common_name(material: &str) -> Vec<String> {
    let words: Vec<_> = words(material).into_iter().map(|(word, _)| word).collect();
    let number = |word: &String| word.chars().all(|c| c.is_ascii_digit());
    let resolution = |i: usize| {
        let follows = |i: usize| words.get(i + 1).is_some_and(|next| next == "k") && number(&words[i]);
        follows(i) || (i > 0 && follows(i - 1))
    };
    (0..words.len()).filter(|i| !resolution(*i)).map(|i| words[i].clone()).collect()
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
