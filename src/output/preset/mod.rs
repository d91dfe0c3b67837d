//! What engines want.

use serde::Serialize;

use crate::image::Sides;
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    Occlusion,
    Roughness,
    Smoothness,
    Metal,
    Zero,
    One,
}

pub struct Preset {
    pub name: &'static str,
    pub normal_z: bool,
    pub normal_y: NormalY,
    pub packed: Option<&'static [Slot]>,
    pub packed_suffix: &'static str,
    pub without_metal: f32,
    pub sides: Sides,
}

#[derive(Clone, Debug)]
pub struct Aside {
    pub name: String,
    pub text: String,
}
