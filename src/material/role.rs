//! The meaning of a channel, and the conventions that files differ in.

use serde::{Deserialize, Serialize};

/// What a channel of a map holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Tangent-space normal, along +u.
    NormalX,
    /// Tangent-space normal, along v: up (OpenGL) or down (DirectX).
    NormalY,
    /// Tangent-space normal, out of the surface.
    NormalZ,
    /// Perceptual roughness.
    Roughness,
    /// Gloss or smoothness, `1 - perceptual roughness`.
    Smoothness,
    /// Direction of anisotropy, cosine, 0..1 standing for -1..1 (glTF's `anisotropyTexture`, red).
    AnisotropyX,
    /// Direction of anisotropy, sine, +v up (glTF, green).
    AnisotropyY,
    /// Strength of anisotropy: `alpha_t = mix(alpha, 1, strength^2)` (glTF, blue).
    AnisotropyStrength,
    /// Anything else: averaged plainly. Numbered over all maps of a material.
    Other(usize),
}

/// Which way the green channel of a normal map points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum NormalY {
    /// Green is up (+Y): OpenGL, glTF, Blender, Unity, Godot.
    #[default]
    #[value(name = "opengl", alias = "gl")]
    OpenGl,
    /// Green is down (-Y): DirectX, Unreal.
    #[value(name = "directx", alias = "dx")]
    DirectX,
}

impl NormalY {
    /// The sign that turns the stored Y up.
    pub fn sign(self) -> f32 {
        match self {
            NormalY::OpenGl => 1.0,
            NormalY::DirectX => -1.0,
        }
    }

    /// In the words that artists use.
    pub fn describe(self) -> &'static str {
        match self {
            NormalY::OpenGl => "OpenGL (green up, +Y)",
            NormalY::DirectX => "DirectX (green down, -Y)",
        }
    }
}

/// How a float file stores normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum NormalRange {
    /// Whichever reading makes the normals more nearly unit.
    #[default]
    Auto,
    /// -1..1.
    Signed,
    /// 0..1, as integer files do.
    Unsigned,
}

/// Where the z of a normal comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum NormalZ {
    /// Stored if the map has a third channel, else rebuilt.
    #[default]
    Auto,
    /// The third channel.
    Stored,
    /// `sqrt(1 - x^2 - y^2)`, as two-channel formats are read.
    Rebuild,
}
