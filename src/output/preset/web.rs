//! Engines that load KTX 2 with UASTC: one file for every GPU.

use super::{Compress, Fact, Preset, Slot, nothing};
use crate::image::Sides;
use crate::material::NormalY;
use crate::output::Format;

/// glTF's order: occlusion in red, roughness in green, metal in blue.
pub const ORM: &[Slot] = &[Slot::Occlusion, Slot::Roughness, Slot::Metal];

/// UASTC in KTX 2, normals whole, packed as glTF has it.
const WEB: Preset = Preset {
    name: "",
    engine: "",
    format: Format::Ktx2,
    compress: Compress::Uastc,
    normal_z: true,
    normal_y: NormalY::OpenGl,
    packed: Some(ORM),
    packed_suffix: "orm",
    without_metal: 1.0,
    sides: Sides::MultipleOf4,
    facts: &[],
    load: "",
    aside: nothing,
};

/// three.js.
pub const THREE: Preset = Preset {
    name: "three",
    engine: "three.js r187",
    facts: &[Fact {
        text: "Roughness is read from green, metal from blue, occlusion from red, of whatever texture is in the slot.",
        source: "three 0.187.0, src/renderers/shaders/ShaderChunk/roughnessmap_fragment.glsl.js",
        checked: true,
    }],
    load: "Load each file with KTX2Loader.",
    ..WEB
};

/// glTF.
pub const GLTF: Preset = Preset { name: "gltf", engine: "glTF 2.0, KHR_texture_basisu", ..THREE };
