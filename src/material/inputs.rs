//! What a material is made from.

use std::path::{Path, PathBuf};

use super::{NormalRange, NormalY, NormalZ};
use crate::image::{Sides, Size, Wrap};
use crate::roughness::PerceptualRoughness;

/// A file, and a channel of it if one was named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelRef {
    /// The picture.
    pub path: PathBuf,
    /// Index of the channel; by default the green one of colour pictures (glTF's place for roughness; the same as
    /// the others where gray is stored as colour), else the first.
    pub channel: Option<usize>,
}

/// Channels as options and files name them.
pub(super) const LETTERS: [&str; 4] = ["r", "g", "b", "a"];

/// A channel in the words of artists.
pub(crate) fn colour(channel: usize) -> &'static str {
    ["red", "green", "blue", "alpha"].get(channel).unwrap_or(&"further")
}

impl ChannelRef {
    /// Index of the channel in a picture of so many, which may lack it.
    pub(super) fn index(&self, count: usize) -> usize {
        self.channel.unwrap_or(if count >= 3 { 1 } else { 0 })
    }

    /// `file.png` or `file.png:g`; channels are r g b a, or 0 to 3.
    pub fn parse(text: &str) -> Self {
        if let Some((path, name)) = text.rsplit_once(':') {
            let channel = LETTERS.iter().position(|c| c.eq_ignore_ascii_case(name));
            let channel = channel.or_else(|| name.parse().ok().filter(|c| *c < 4 && name.len() == 1));
            if channel.is_some() && !path.is_empty() {
                return Self { path: path.into(), channel };
            }
        }
        Self { path: text.into(), channel: None }
    }
}

/// Where the base width comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RoughnessInput {
    /// Nowhere: [`DEFAULT_ROUGHNESS`] everywhere.
    #[default]
    Missing,
    /// The same everywhere.
    Constant(PerceptualRoughness),
    /// A channel of perceptual roughness.
    Roughness(ChannelRef),
    /// A channel of gloss or smoothness.
    Smoothness(ChannelRef),
}

impl RoughnessInput {
    /// The channel of a file, if it comes from one.
    pub fn channel(&self) -> Option<&ChannelRef> {
        match self {
            RoughnessInput::Roughness(channel) | RoughnessInput::Smoothness(channel) => Some(channel),
            RoughnessInput::Missing | RoughnessInput::Constant(_) => None,
        }
    }

    /// Its file, if it comes from one.
    pub fn file(&self) -> Option<&Path> {
        self.channel().map(|channel| channel.path.as_path())
    }
}

/// Perceptual roughness of a material that gives none.
pub const DEFAULT_ROUGHNESS: PerceptualRoughness = PerceptualRoughness(0.5);

/// Height range of a height map in widths of the texture, where none is given.
pub const DEFAULT_HEIGHT_SCALE: f32 = 0.03;

/// What a material is made from. At least one of normal, height, a roughness map and the size of a flat one must be there.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// For messages and output names.
    pub name: String,
    /// Tangent-space normal map.
    pub normal: Option<PathBuf>,
    /// Base width.
    pub roughness: RoughnessInput,
    /// glTF's anisotropy texture: direction in red and green, strength in blue.
    pub anisotropy: Option<PathBuf>,
    /// Height map, from which normals are derived if there is no normal map.
    pub height: Option<PathBuf>,
    /// Ambient occlusion: nothing is folded into it, but engines pack it with the roughness. Read only if it is to be packed.
    pub occlusion: Option<ChannelRef>,
    /// Metalness, likewise.
    pub metal: Option<ChannelRef>,
    /// Convention of the normal map.
    pub normal_y: NormalY,
    /// Where z comes from.
    pub normal_z: NormalZ,
    /// How a float file stores them; integer files always store 0..1.
    pub normal_range: NormalRange,
    /// Strength that the renderer multiplies x and y of the normal with; `None` for 1.
    pub normal_scale: Option<f32>,
    /// What the renderer multiplies a roughness map with, 0 to 1 (glTF's `roughnessFactor`); `None` for 1. It is multiplied
    /// into the maps that come back.
    pub roughness_factor: Option<f32>,
    /// Height of white over black in widths of the texture.
    pub height_scale: Option<f32>,
    /// Size of a material that no map gives one: flat, of the roughness that is given.
    pub flat: Option<Size>,
    /// What the sides must be: maps are enlarged until they are.
    pub sides: Sides,
    /// What lies beyond the border.
    pub wrap: Wrap,
    /// What looks wrong on the way to these inputs, said again in the material's warnings.
    pub warnings: Vec<String>,
    /// What was decided on the way to these inputs, said again in the material's notes.
    pub notes: Vec<String>,
}

impl Inputs {
    /// All files that are named, some perhaps more than once.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let maps = [&self.normal, &self.anisotropy, &self.height].into_iter().flatten().map(PathBuf::as_path);
        let plain = [&self.occlusion, &self.metal].into_iter().flatten().map(|channel| channel.path.as_path());
        maps.chain(self.roughness.file()).chain(plain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_named_after_a_colon() {
        let parse = |text| {
            let ChannelRef { path, channel } = ChannelRef::parse(text);
            (path.display().to_string(), channel)
        };
        assert_eq!(parse("orm.png"), ("orm.png".into(), None));
        assert_eq!(parse("orm.png:g"), ("orm.png".into(), Some(1)));
        assert_eq!(parse("mask.tga:A"), ("mask.tga".into(), Some(3)));
        assert_eq!(parse("x.exr:2"), ("x.exr".into(), Some(2)));
        assert_eq!(parse("C:\\maps\\orm.png"), ("C:\\maps\\orm.png".into(), None));
        assert_eq!(parse("odd:name.png"), ("odd:name.png".into(), None));
    }
}
