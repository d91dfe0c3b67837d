//! Unity, and the script that puts levels into the textures that it imports.

use super::{Aside, Compress, Fact, Preset, Slot, Written};
use crate::image::Sides;
use crate::material::NormalY;
use crate::output::Format;

/// The script is one for a whole project, and two copies of it would not compile: so it does not come as a `.cs` file.
const SCRIPT: &str = "MipfoldMips.cs.txt";

const UNITY_LOAD: &str = "Rename MipfoldMips.cs.txt and put it into the project, once: Assets/Editor/MipfoldMips.cs
Copy the folder of the maps, with manifest.json, into Assets. If it was there before the script: right click, Reimport.
Look at {normal} and {packed} in the Inspector: the slider of levels shows those of mipfold. Only these two go into \
                          materials; the other levels are read by the script.
Material with shader Lit of URP, or Standard: {packed} into Metallic Map and Occlusion Map, {normal} into Normal Map.
Source of smoothness: Metallic Alpha; slider of Smoothness: 1.";

const HDRP_LOAD: &str = "Rename MipfoldMips.cs.txt and put it into the project, once: Assets/Editor/MipfoldMips.cs
Copy the folder of the maps, with manifest.json, into Assets. If it was there before the script: right click, Reimport.
Look at {normal} and {packed} in the Inspector: the slider of levels shows those of mipfold. Only these two go into \
                         materials; the other levels are read by the script.
Material with shader HDRP/Lit: {packed} into Mask Map, {normal} into Normal Map.
Leave the remapping of metallic, smoothness and occlusion at 0 to 1.";

const MIPS: Fact = Fact {
    text: "Unity calls the script just before it compresses a texture, so every platform gets mipfold's levels in its own \
           format.",
    source: "Unity 6 scripting API, AssetPostprocessor.OnPostprocessTexture",
    checked: true,
};

const NOT_RUN: Fact = Fact {
    text: "The script was written after the manual; it was not run in the engine.",
    source: "mipfold's own",
    checked: true,
};

const PNG_8: Fact = Fact {
    text: "It reads levels with Texture2D.LoadImage, in 8 bits a channel.",
    source: "Unity 6 scripting API, ImageConversion.LoadImage",
    checked: false,
};

const RAW: Fact = Fact {
    text: "DDS and KTX textures would go past Unity's importer, and not be compressed anew for other platforms.",
    source: "Unity 6.3 scripting API, IHVImageFormatImporter",
    checked: true,
};

/// Unity with the Universal pipeline or its built-in one.
pub const UNITY: Preset = Preset {
    name: "unity",
    engine: "Unity 6, URP or built-in",
    format: Format::Png,
    compress: Compress::None,
    normal_z: true,
    normal_y: NormalY::OpenGl,
    packed: Some(&[Slot::Metal, Slot::Occlusion, Slot::Zero, Slot::Smoothness]),
    packed_suffix: "mask",
    without_metal: 0.0,
    sides: Sides::MultipleOf4,
    facts: &[
        MIPS,
        NOT_RUN,
        Fact {
            text: "With a map, metal is red of it and the slider Metallic is ignored; smoothness is alpha times the slider \
                   Smoothness, which is 0.5 at first.",
            source: "Unity-Technologies/Graphics, com.unity.render-pipelines.universal/Shaders/LitInput.hlsl",
            checked: true,
        },
        Fact {
            text: "Occlusion is green of its map.",
            source: "Unity-Technologies/Graphics, com.unity.render-pipelines.universal/Shaders/LitInput.hlsl",
            checked: true,
        },
        PNG_8,
        RAW,
    ],
    load: UNITY_LOAD,
    aside: script,
};

/// Unity with the High Definition pipeline.
pub const UNITY_HDRP: Preset = Preset {
    name: "unity-hdrp",
    engine: "Unity 6, HDRP",
    packed: Some(&[Slot::Metal, Slot::Occlusion, Slot::One, Slot::Smoothness]),
    facts: &[
        MIPS,
        NOT_RUN,
        Fact {
            text: "The mask map holds metal, occlusion, detail mask and smoothness; sRGB must be off, and the script sees \
                   to it.",
            source: "HDRP 15 manual, Mask and detail maps",
            checked: true,
        },
        Fact {
            text: "The detail mask is 1: so a detail map shows as it does without a mask map.",
            source: "Unity-Technologies/Graphics, com.unity.render-pipelines.high-definition/Runtime/Material/Lit/\
                     LitDataIndividualLayer.hlsl",
            checked: true,
        },
        PNG_8,
        RAW,
    ],
    load: HDRP_LOAD,
    ..UNITY
};

fn script(_: &Written) -> Vec<Aside> {
    vec![Aside { name: SCRIPT.into(), text: include_str!("MipfoldMips.cs").into() }]
}
