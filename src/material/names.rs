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
    /// Several of these in one picture.
    Packed(Layout),
    /// Unity's mask map if it has an alpha channel; any mask if not.
    Mask,
    /// Normals in RGB, roughness in alpha.
    NormalRoughness,
    Anisotropy,
    Height,
    Occlusion,
    Metal,
    /// Something that is not ours, in a word.
    Ignored(&'static str),
}

/// Which channel of a packed map holds what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Of perceptual roughness, or of smoothness.
    pub width: usize,
    pub smooth: bool,
    pub occlusion: Option<usize>,
    pub metal: Option<usize>,
}

use Kind::*;

const OCCLUSION_ROUGH_METAL: Kind = rough(1, Some(0), 2);
const ROUGH_METAL: Kind = rough(1, None, 2);
const METAL_ROUGH_OCCLUSION: Kind = rough(1, Some(2), 0);
const ROUGH_METAL_OCCLUSION: Kind = rough(0, Some(2), 1);
const METAL_SMOOTH: Kind = smooth(None, Some(0));
const SPECULAR_GLOSS: Kind = smooth(None, None);
/// Unity's mask map: metal, occlusion, detail mask, smoothness.
pub(super) const MASK_MAP: Kind = smooth(Some(1), Some(0));

const fn rough(width: usize, occlusion: Option<usize>, metal: usize) -> Kind {
    Packed(Layout { width, smooth: false, occlusion, metal: Some(metal) })
}

const fn smooth(occlusion: Option<usize>, metal: Option<usize>) -> Kind {
    Packed(Layout { width: 3, smooth: true, occlusion, metal })
}

/// Joined words and what they mean. Single letters count only as the last word. What says which way green points may
/// stand before or after the words of a normal map: see [`MARKS`].
const WORDS: &[(&[&str], Kind)] = &[
    (&["normal", "normals", "normalmap", "nor", "nrm", "nrml", "norm", "n", "nm"], Normal(None)),
    (&["roughness", "roughnessmap", "rough", "rgh", "r"], Roughness),
    (&["gloss", "glossiness", "glossmap", "smoothness", "smoothnessmap", "smooth", "g"], Smoothness),
    (&["orm", "arm", "aorm", "occlusionroughnessmetallic", "occlusionroughmetal"], OCCLUSION_ROUGH_METAL),
    (&["aoroughmetal", "aoroughnessmetallic", "occlusionroughnessmetalness"], OCCLUSION_ROUGH_METAL),
    (&["ambientocclusionroughnessmetallic", "ambientocclusionroughnessmetalness"], OCCLUSION_ROUGH_METAL),
    (&["metallicroughness", "metalnessroughness", "roughnessmetallic", "mr"], ROUGH_METAL),
    (&["mra", "mrao", "mro"], METAL_ROUGH_OCCLUSION),
    (&["rma", "rmao", "rmo"], ROUGH_METAL_OCCLUSION),
    (&["normalroughness", "nrmrgh", "nrmrough", "normrough"], NormalRoughness),
    (&["metallicsmoothness", "metallicgloss", "metalsmoothness"], METAL_SMOOTH),
    (&["specularglossiness", "specularsmoothness", "specgloss"], SPECULAR_GLOSS),
    (&["maskmap", "mads"], MASK_MAP),
    (&["mask"], Mask),
    (&["anisotropy", "aniso", "anisotropic"], Anisotropy),
    (&["height", "heightmap", "displacement", "displacementmap", "disp", "hgt", "h"], Height),
    (&["ao", "ambientocclusion", "occlusion", "occlusionmap", "occ", "mixedao", "aomap"], Occlusion),
    (&["metallic", "metalness", "metal", "mtl", "metallicmap", "m"], Metal),
    (&["basecolor", "basecolour", "basecol", "albedo", "diffuse", "diff", "color", "colour", "col"], Ignored("colour")),
    (&["alb", "bc", "albedotransparency", "basecolormap", "albedomap", "diffusemap"], Ignored("colour")),
    (&["albedoheight", "albht"], Ignored("colour and height")),
    (&["opacity", "alpha", "transparency"], Ignored("opacity")),
    (&["emissive", "emission"], Ignored("emission")),
    (&["specular", "spec"], Ignored("specular colour")),
    (&["bump"], Ignored("bump")),
    (&["depth"], Ignored("depth")),
    (&["transmission"], Ignored("transmission")),
    (&["subsurface", "sss"], Ignored("subsurface scattering")),
    (&["cavity"], Ignored("cavity")),
];

/// Words that stand for [`ROUGH_METAL`] only where nothing but a separator is before them, and none between them:
/// `rusty_metal_roughness` is the roughness of something called metal.
const GLUED: &[&str] = &["metalrough", "metalroughness"];

/// What says which way green points.
const MARKS: [(&[&str], NormalY); 2] =
    [(&["gl", "ogl", "opengl"], NormalY::OpenGl), (&["dx", "d3d", "directx"], NormalY::DirectX)];

fn kind_of(joined: &str) -> Option<Kind> {
    let exact = |joined: &str| WORDS.iter().find(|(names, _)| names.contains(&joined)).map(|(_, kind)| *kind);
    let marked = |(marks, y): &(&[&str], NormalY)| {
        marks.iter().find_map(|mark| {
            let rest = joined.strip_suffix(mark).or_else(|| joined.strip_prefix(mark))?;
            (rest.len() > 1 && exact(rest) == Some(Normal(None))).then_some(Normal(Some(*y)))
        })
    };
    exact(joined).or_else(|| MARKS.iter().find_map(marked))
}

/// A tile of a texture that is cut into several files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// By UDIM's count: 1001 + u + 10 v, from zero.
    pub number: u32,
    /// As the name has it: `1001`, or Mudbox's `u1_v1`.
    pub text: String,
}

/// The name before the tile at its end, after a point or an underscore: `1001` to `1999`, or `u1_v1`, which counts from 1.
pub(super) fn tile(stem: &str) -> Option<(&str, Tile)> {
    let count = |digits: &str| digits.parse::<u32>().ok().filter(|_| digits.bytes().all(|b| b.is_ascii_digit()));
    let after = |text: &str, letter: char| count(text.strip_prefix([letter, letter.to_ascii_uppercase()])?);
    let (rest, last) = stem.rsplit_once(['.', '_'])?;
    let (rest, number) = match count(last) {
        Some(number) => (rest, (last.len() == 4).then_some(number)?),
        None => {
            let v = after(last, 'v').filter(|v| (1..=100).contains(v))?;
            let (rest, u) = rest.rsplit_once(['.', '_'])?;
            let u = after(u, 'u').filter(|u| (1..=10).contains(u))?;
            (rest, 990 + u + 10 * v)
        }
    };
    let real = (1001..=1999).contains(&number) && !rest.is_empty();
    real.then(|| (rest, Tile { number, text: stem[rest.len() + 1..].to_owned() }))
}

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
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Meaning {
    pub kind: Kind,
    /// Channel named by a trailing `in_g` or the like.
    pub channel: Option<usize>,
    /// The rest of the name, which the maps of one material have in common.
    pub material: String,
    /// What decided, as it stands in the name.
    pub word: String,
    pub tile: Option<Tile>,
}

pub(super) fn meaning_of(stem: &str) -> Option<Meaning> {
    let (stem, tile) = tile(stem).map_or((stem, None), |(stem, tile)| (stem, Some(tile)));
    let words = words(stem);
    let mut best = None;
    for start in 0..words.len() {
        for end in start + 1..=(start + 4).min(words.len()) {
            let joined: String = words[start..end].iter().map(|(word, _)| word.as_str()).collect();
            let single = joined.len() == 1;
            // `a_orm` is the packed map of a material called a.
            if end - start > 1 && words[start].0.len() == 1 {
                continue;
            }
            let glued = || GLUED.contains(&joined.as_str()) && stands_alone(&words, start..end);
            let Some(kind) = kind_of(&joined).or_else(|| glued().then_some(ROUGH_METAL)) else { continue };
            // What ends last says what the map is; before it stands the material's own name, which may hold such
            // words too. Of those that end together, the longest. Words that qualify as often as they name count only
            // if there is no other.
            let rank = (!is_weak(&joined, &words[end..]), end, end - start);
            let last = end == words.len() && start > 0 && words[start - 1].0 != "in";
            if (!single || last || words.len() == 1) && best.as_ref().is_none_or(|(old, _, _)| rank >= *old) {
                best = Some((rank, start..end, kind));
            }
        }
    }
    let (_, run, kind) = best?;
    let word = stem[words[run.start].1.start..words[run.end - 1].1.end].to_owned();
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
    Some(Meaning { kind, channel, material: format!("{head}{joint}{tail}"), word, tile })
}

/// Whether nothing separates these words, and something separates them from the one before; a lone one if there is none.
fn stands_alone(words: &[(String, std::ops::Range<usize>)], run: std::ops::Range<usize>) -> bool {
    let meets = |i: usize| words[i - 1].1.end == words[i].1.start;
    (run.start + 1..run.end).all(meets) && if run.start > 0 { !meets(run.start) } else { run.len() == 1 }
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

    const OPENGL: Kind = Normal(Some(NormalY::OpenGl));
    const DIRECTX: Kind = Normal(Some(NormalY::DirectX));

    #[test]
    fn names_seen_in_the_wild() {
        let of = |stem: &str| {
            let meaning = meaning_of(stem)?;
            assert!(stem.contains(&meaning.word), "{stem}: {}", meaning.word);
            Some((meaning.kind, meaning.channel, meaning.material))
        };
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
            ("tea_set_01_arm_1k", OCCLUSION_ROUGH_METAL, "tea_set_01_1k"),
            (
                "FlightHelmet_Materials_RubberWoodMat_OcclusionRoughMetal",
                OCCLUSION_ROUGH_METAL,
                "FlightHelmet_Materials_RubberWoodMat",
            ),
            ("ground037_nrm_rgh", NormalRoughness, "ground037"),
            ("albedo_height", Ignored("colour and height"), ""),
            ("wall_n", Normal(None), "wall"),
            ("n_wall_color", Ignored("colour"), "n_wall"),
            ("rusty_metal_roughness", Roughness, "rusty_metal"),
            ("rock_metallicRoughness", ROUGH_METAL, "rock"),
            ("rust_RMA", ROUGH_METAL_OCCLUSION, "rust"),
            ("normal_dx", DIRECTX, ""),
            ("rough_wood_nor_gl_1k", OPENGL, "rough_wood_1k"),
            ("rough_wood_rough_1k", Roughness, "rough_wood_1k"),
            ("rough_wood_diff_1k", Ignored("colour"), "rough_wood_1k"),
            ("SmoothConcrete_Color", Ignored("colour"), "SmoothConcrete"),
            ("T_Height_Marker_N", Normal(None), "T_Height_Marker"),
            ("wall_MetallicSmoothness", METAL_SMOOTH, "wall"),
            ("wall_normal_metal", Normal(None), "wall_metal"),
            ("rock_normal_alpha", Normal(None), "rock_alpha"),
            ("Normal_Rough_Stone", Normal(None), "Rough_Stone"),
            ("wall_rough_1k", Roughness, "wall_1k"),
            ("Wall_Normal_GL", OPENGL, "Wall"),
            ("wall_NormalOGL", OPENGL, "wall"),
            ("brick-normal-ogl", OPENGL, "brick"),
            ("Wall_DirectX_Normal", DIRECTX, "Wall"),
            ("wall_nm_d3d", DIRECTX, "wall"),
            ("wall_occlusionroughnessmetallic", OCCLUSION_ROUGH_METAL, "wall"),
            ("T_Wall_MRAO", METAL_ROUGH_OCCLUSION, "T_Wall"),
            ("wall_rmo", ROUGH_METAL_OCCLUSION, "wall"),
            ("wall_MADS", MASK_MAP, "wall"),
            ("a_orm", OCCLUSION_ROUGH_METAL, "a"),
            ("Wall_MaskMap", MASK_MAP, "Wall"),
            ("wall_mask", Mask, "wall"),
            ("wall_normal_mask", Normal(None), "wall_mask"),
            ("car_SpecularGlossiness", SPECULAR_GLOSS, "car"),
            ("hull_MetalRough", ROUGH_METAL, "hull"),
            ("metalroughness", ROUGH_METAL, ""),
            ("RustyMetalRoughness", Roughness, "RustyMetal"),
            ("rusty_metal_rough", Roughness, "rusty_metal"),
            ("MetalRoughness", Roughness, "Metal"),
            ("wall_Mixed_AO", Occlusion, "wall"),
            ("wall_ambient_occlusion", Occlusion, "wall"),
            ("rusty_metal_metalness", Metal, "rusty_metal"),
            ("wall_mtl", Metal, "wall"),
            ("Wall_AlbedoTransparency", Ignored("colour"), "Wall"),
        ];
        for (stem, kind, material) in cases {
            assert_eq!(of(stem), Some((kind, None, material.into())), "{stem}");
        }
        assert_eq!(of("veneer_rough_in_g_1k"), Some((Roughness, Some(1), "veneer_1k".into())));
        assert_eq!(meaning_of("readme_2024"), None);
    }

    #[test]
    fn every_name_of_the_lists_users_gave_means_something() {
        let normal = "normal nor nrm nrml norm n nm normalgl normal_gl nor_gl normal_ogl normalopengl normaldx nor_dx \
                      normal_dx normaldirectx";
        let width = "roughness rough rgh r gloss glossiness smoothness smooth g";
        let packed =
            "orm occlusionroughnessmetallic arm rma mra mrao metallicroughness metalrough mr maskmap mask mads rmo";
        let others = "metal metallic metalness mtl m ao ambientocclusion occlusion occ height disp displacement h";
        for name in [normal, width, packed, others].into_iter().flat_map(str::split_whitespace) {
            for stem in [format!("wall_{name}"), format!("Wall_{}", name.to_uppercase())] {
                let meaning = meaning_of(&stem).unwrap_or_else(|| panic!("{stem}"));
                assert!(meaning.material.eq_ignore_ascii_case("wall"), "{stem}: {meaning:?}");
                assert!(!matches!(meaning.kind, Ignored(_)), "{stem}: {meaning:?}");
            }
        }
    }

    #[test]
    fn tiles_stand_at_the_end() {
        let tiled =
            |stem: &str| meaning_of(stem).map(|m| (m.kind, m.material, m.tile.map(|tile| (tile.number, tile.text))));
        let is = |kind, number, text: &str| Some((kind, "wall".to_owned(), Some((number, text.to_owned()))));
        assert_eq!(tiled("wall_normal.1001"), is(Normal(None), 1001, "1001"));
        assert_eq!(tiled("wall_n_1042"), is(Normal(None), 1042, "1042"));
        assert_eq!(tiled("wall_ORM_u2_v3"), is(OCCLUSION_ROUGH_METAL, 1022, "u2_v3"));
        assert_eq!(tiled("wall_ORM.U10_V1"), is(OCCLUSION_ROUGH_METAL, 1010, "U10_V1"));
        for stem in [
            "wall_normal_2048",
            "wall_normal_1000",
            "wall_normal_10010",
            "Metal1001_normal",
            "wall_1001_normal",
            "wall_normal1001",
            "wall_normal-1001",
            "wall_normal_u0_v1",
            "wall_normal_u11_v1",
            "wall_normal_v1",
            "normal_u1v1",
        ] {
            assert_eq!(meaning_of(stem).unwrap().tile, None, "{stem}");
        }
        assert_eq!((tile("1001"), tile(".1001"), tile("_u1_v1")), (None, None, None));
    }
}
