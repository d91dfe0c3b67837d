//! Engines with importers of their own: Godot and Unreal.

use super::web::ORM;
use super::{Compress, Fact, Preset, nothing};
use crate::image::Sides;
use crate::material::NormalY;
use crate::output::Format;

/// Godot.
pub const GODOT: Preset = Preset {
    name: "godot",
    engine: "Godot 4",
    format: Format::Ktx2,
    compress: Compress::Bc,
    normal_z: false,
    normal_y: NormalY::OpenGl,
    packed: Some(ORM),
    packed_suffix: "orm",
    without_metal: 0.0,
    sides: Sides::MultipleOf4,
    facts: &[
        Fact {
            text: "KTX 2 files, Zstandard and all, are loaded as they are: there are no import settings, and PNGs would get \
                   plain mips.",
            source: "godotengine/godot, modules/ktx/texture_loader_ktx.cpp, commit 00d7a0bc; \
                     thirdparty/libktx/lib/texture2.c, commit 173c9d2f",
            checked: true,
        },
        Fact {
            text: "BC7, BC5 and BC4 marked linear are taken; 8-bit RGBA is not, and two 8-bit channels become gray and \
                   alpha: do not use --compress none.",
            source: "godotengine/godot, modules/ktx/texture_loader_ktx.cpp, commit 00d7a0bc",
            checked: true,
        },
        Fact {
            text: "A level whose size is not the one that Godot expects silently drops all levels; those of mipfold have \
                   it, down to 1x1.",
            source: "godotengine/godot, modules/ktx/texture_loader_ktx.cpp, commit 00d7a0bc",
            checked: true,
        },
        Fact {
            text: "The DDS loader is no better choice: it misread block-compressed sizes that are no powers of two until \
                   April 2025.",
            source: "godotengine/godot, pull request 105200",
            checked: true,
        },
        Fact {
            text: "ORMMaterial3D reads roughness from green and metal from blue without any factor, and occlusion from \
                   red if Ambient Occlusion is enabled.",
            source: "godotengine/godot, scene/resources/material.cpp, BaseMaterial3D::_update_shader",
            checked: true,
        },
        Fact {
            text: "z of normals is always made from x and y, clamped.",
            source: "godotengine/godot, scene_forward_clustered.glsl, NORMAL_MAP_USED",
            checked: true,
        },
        Fact {
            text: "BC needs a desktop GPU; Godot does not compress KTX 2 anew for mobile exports.",
            source: "godotengine/godot, modules/ktx/texture_loader_ktx.cpp, which has no import step",
            checked: false,
        },
    ],
    load: "Copy the files into the project folder.
Make an ORMMaterial3D and drag {packed} to its ORM texture.
Enable Normal Map and drag {normal} to its texture.
If there is occlusion in red, enable Ambient Occlusion.
Under Sampling choose Linear Mipmap Anisotropic.",
    aside: nothing,
};

/// Unreal Engine.
pub const UNREAL: Preset = Preset {
    name: "unreal",
    engine: "Unreal Engine 5",
    format: Format::Dds,
    compress: Compress::None,
    normal_z: true,
    normal_y: NormalY::DirectX,
    packed: Some(ORM),
    packed_suffix: "orm",
    without_metal: 0.0,
    sides: Sides::PowerOfTwo,
    facts: &[
        Fact {
            text: "The importer keeps the levels of a DDS file and sets Mip Gen Settings to LeaveExistingMips.",
            source: "Unreal Engine 5, Engine/Plugins/Interchange/Runtime/Source/Import/Private/Texture/\
                     InterchangeDDSTranslator.cpp, SetupPayload",
            checked: true,
        },
        Fact {
            text: "A DX10 header that says UNORM turns sRGB off; the older header has no word for it, and sRGB is assumed.",
            source: "Unreal Engine 5, InterchangeDDSTranslator.cpp, DDSPayloadIsSRGB",
            checked: true,
        },
        Fact {
            text: "Versions before that importer took of 8-bit files only those in the order blue, green, red, alpha, with \
                   the older header or DXGI format 87.",
            source: "Unreal Engine 4.1x to 5.0, Engine/Source/Runtime/Engine/Private/DDSLoader.cpp, ComputeSourceFormat",
            checked: true,
        },
        Fact {
            text: "Of 2D files with mips only uncompressed ones are taken; the engine compresses the levels itself.",
            source: "Unreal Engine forum, How to import custom mip maps? (336593)",
            checked: false,
        },
        Fact { text: "Mips and streaming want sides that are powers of two.", source: "common advice", checked: false },
        Fact {
            text: "Normal maps have their green down.",
            source: "common knowledge; the importer has Flip Normal Map Green Channel for others",
            checked: false,
        },
        Fact {
            text: "16-bit maps give 16-bit files, which older versions refuse.",
            source: "Unreal Engine 4.1x to 5.0, DDSLoader.cpp, ComputeSourceFormat",
            checked: true,
        },
    ],
    load: "Import the files into the Content Browser.
Open {normal}: Compression Settings = Normalmap, sRGB off.
Open {packed}: Compression Settings = Masks, sRGB off.
For both see that Mip Gen Settings is LeaveExistingMips; save.
In the material: normal to Normal; of the other, red to Ambient Occlusion, green to Roughness, blue to Metallic.",
    aside: nothing,
};
