//! What engines want, as data: container, packing, conventions, the facts behind them, and the files that go along.

mod bevy;
mod film;
mod games;
mod readme;
#[cfg(test)]
mod tests;
mod unity;
mod web;

pub use readme::{fill, said};
use serde::Serialize;

use super::Format;
use crate::error::{Error, Result};
use crate::image::{Sides, Wrap};
use crate::material::NormalY;

/// How texels of a texture are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Compress {
    /// Not at all
    None,
    /// BC5 for normals, BC4 for one channel, BC7 for more: desktop hardware
    #[default]
    Bc,
    /// UASTC, which every GPU's own format is made of at load time
    Uastc,
}

/// What a channel of a packed map holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Slot {
    /// Ambient occlusion; 1 where the material has none.
    Occlusion,
    /// Perceptual roughness.
    Roughness,
    /// 1 - perceptual roughness.
    Smoothness,
    /// Metalness; [`Preset::without_metal`] where the material has none.
    Metal,
    /// 0 everywhere.
    Zero,
    /// 1 everywhere.
    One,
}

/// Something that an engine does, or wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Fact {
    /// One sentence.
    pub text: &'static str,
    /// File and version, or page of the manual.
    pub source: &'static str,
    /// Whether it was read in the engine's source or manual, or was seen there; else it is told as "not verified".
    pub checked: bool,
}

/// What an engine wants.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// In options.
    pub name: &'static str,
    /// The engine, and the version that the facts are about.
    pub engine: &'static str,
    /// Container.
    pub format: Format,
    /// Compression of its texels, where the container has a choice.
    pub compress: Compress,
    /// Whether normals keep their z; else the engine makes it from x and y, where compression has a format for two.
    pub normal_z: bool,
    /// Which way green points.
    pub normal_y: NormalY,
    /// Channels of the map that holds the roughness; `None` where it keeps its own packing.
    pub packed: Option<&'static [Slot]>,
    /// Last word of that map's name.
    pub packed_suffix: &'static str,
    /// What stands for metal where the material has no map of it: 1 where a factor multiplies it, 0 elsewhere.
    pub without_metal: f32,
    /// What container or engine need of level 0.
    pub sides: Sides,
    /// Why all of that is so, and what to mind.
    pub facts: &'static [Fact],
    /// How to load the files, a step a line; lines that begin with a space are code of the step before. `{normal}` stands
    /// for the file of the normals, `{packed}` for that of the roughness: level 0, where levels have files of their own;
    /// `{normal.level}` for that of any level, with `%d`, and `{normal.last}` for the number of the last one. A line whose
    /// file was not written is left out.
    pub load: &'static str,
    /// Further files, beside the README.
    pub aside: fn(&Written) -> Vec<Aside>,
}

/// A material as it was written.
#[derive(Clone, Copy, Debug)]
pub struct Written<'a> {
    /// Its name.
    pub material: &'a str,
    /// Its maps.
    pub maps: &'a [WrittenMap<'a>],
    /// What lies beyond the border.
    pub wrap: Wrap,
}

/// A map as it was written.
#[derive(Clone, Copy, Debug)]
pub struct WrittenMap<'a> {
    /// "normal", "roughness", "packed", "anisotropy" and what else a manifest calls them.
    pub role: &'a str,
    /// Its files: one, or one a level, the finest first.
    pub files: &'a [String],
    /// Number of levels.
    pub levels: usize,
    /// Texels of level 0, across.
    pub width: usize,
    /// Texels of level 0, down.
    pub height: usize,
}

/// A text file beside the maps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Aside {
    /// Its name.
    pub name: String,
    /// What is in it.
    pub text: String,
}

/// All of them.
pub const PRESETS: &[Preset] = &[
    web::THREE,
    web::GLTF,
    bevy::BEVY,
    games::GODOT,
    unity::UNITY,
    unity::UNITY_HDRP,
    games::UNREAL,
    web::BABYLON,
    web::PLAYCANVAS,
    web::FILAMENT,
    film::OIIO,
    film::RENDERMAN,
];

impl Preset {
    /// The preset of a name.
    ///
    /// # Errors
    /// [`Error::Invalid`] that lists the names.
    pub fn by_name(name: &str) -> Result<&'static Preset> {
        PRESETS.iter().find(|preset| preset.name == name).ok_or_else(|| {
            let names: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
            Error::invalid_option("preset", format!("'{name}'"), format!("one of {}", names.join(", ")))
        })
    }

    /// Text of `README.txt`: what the files are, how to load them, what to mind. Lines of up to 80 columns.
    pub fn readme(&self, written: &Written) -> String {
        readme::readme(self, written)
    }

    /// The steps of [`Preset::load`] for a material that is called `NAME`.
    pub fn steps(&self) -> String {
        let ending = self.format.extension();
        let files = |stem: &str| {
            let level = |k: &str| if self.format == Format::Png { format!("_mip{k}") } else { String::new() };
            let name = |k| format!("NAME_{stem}{}.{ending}", level(k));
            readme::Files { first: name("0"), level: name("%d"), last: "LAST".into() }
        };
        let packed = if self.packed.is_some() { self.packed_suffix } else { "roughness" };
        readme::steps(self.load, Some(&files("normal")), Some(&files(packed)), Wrap::Repeat)
    }

    /// The channels of the packed map, in a letter each: occlusion, roughness, smoothness, metal, 0, 1; none for the
    /// material's own packing.
    pub fn letters(&self) -> String {
        let letter = |slot: &Slot| match slot {
            Slot::Occlusion => 'O',
            Slot::Roughness => 'R',
            Slot::Smoothness => 'S',
            Slot::Metal => 'M',
            Slot::Zero => '0',
            Slot::One => '1',
        };
        self.packed.unwrap_or_default().iter().map(letter).collect()
    }

    /// All files that go along, the README first.
    pub fn asides(&self, written: &Written) -> Vec<Aside> {
        let readme = Aside { name: README.into(), text: self.readme(written) };
        std::iter::once(readme).chain((self.aside)(written)).collect()
    }
}

/// Name of the file that says what the others are.
pub const README: &str = "README.txt";

/// No further files.
fn nothing(_: &Written) -> Vec<Aside> {
    Vec::new()
}
