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
    facts: &[
        Fact {
            text: "Levels of a KTX 2 file are used as they are, with trilinear filters; nothing is generated.",
            source: "three 0.187.0, examples/jsm/loaders/KTX2Loader.js, _createTextureFrom",
            checked: true,
        },
        Fact {
            text: "Uncompressed KTX 2 files (--compress none) get nearest filters: set minFilter to \
                   LinearMipmapLinearFilter and magFilter to LinearFilter yourself.",
            source: "three 0.187.0, examples/jsm/loaders/KTX2Loader.js, createRawTexture",
            checked: true,
        },
        Fact {
            text: "BC7 and BC5 (--compress bc) are uploaded as they are, where the GPU has them: on desktops.",
            source: "three 0.187.0, examples/jsm/loaders/KTX2Loader.js, FORMAT_MAP",
            checked: true,
        },
        Fact {
            text: "The material's roughness and metalness multiply the map: roughness must be 1.",
            source: "three 0.187.0, src/renderers/shaders/ShaderChunk: roughnessmap_fragment.glsl.js, \
                     metalnessmap_fragment.glsl.js",
            checked: true,
        },
        Fact {
            text: "Textures clamp at their border until wrapS and wrapT say otherwise.",
            source: "three 0.187.0, src/textures/Texture.js",
            checked: true,
        },
    ],
    load: "Load the files. The transcoder is in three's examples/jsm/libs/basis.
 const loader = new KTX2Loader().setTranscoderPath('basis/');
 loader.detectSupport(renderer);
 const normalMap = await loader.loadAsync('{normal}');
 const orm = await loader.loadAsync('{packed}');
Where the texture tiles, for each: wrapS = wrapT = THREE.RepeatWrapping.
Make the material. For metals, or with a metal map: metalness: 1.
 new THREE.MeshStandardMaterial({ normalMap, aoMap: orm,
   roughnessMap: orm, roughness: 1, metalnessMap: orm, metalness: 0 });",
    ..WEB
};

/// glTF, whatever reads it.
pub const GLTF: Preset = Preset {
    name: "gltf",
    engine: "glTF 2.0, KHR_texture_basisu",
    facts: &[
        Fact {
            text: "Of KTX 2 only ETC1S with BasisLZ, and UASTC with or without Zstandard, are allowed: BC7 is not.",
            source: "KHR_texture_basisu, KTX v2 Images with Basis Universal Supercompression",
            checked: true,
        },
        Fact {
            text: "Width and height must be multiples of 4; powers of two are the most compatible.",
            source: "KHR_texture_basisu, KTX v2 Images with Basis Universal Supercompression",
            checked: true,
        },
        Fact {
            text: "Such maps must be marked linear, with unspecified primaries, and so they are.",
            source: "KHR_texture_basisu, KTX v2 Images with Basis Universal Supercompression",
            checked: true,
        },
        Fact {
            text: "For readers without the extension give the texture a PNG as its source too, and name the extension under \
                   extensionsUsed only.",
            source: "KHR_texture_basisu, glTF Schema Updates",
            checked: true,
        },
        Fact {
            text: "metallicFactor is 1 where a file does not give it: give it.",
            source: "glTF 2.0, schema/material.pbrMetallicRoughness.schema.json",
            checked: true,
        },
        Fact {
            text: "The roughness is right for the normalTexture.scale that it was built with (--normal-scale).",
            source: "mipfold's own: slopes scale with it, and their variance with its square",
            checked: true,
        },
    ],
    load: "Name the files under \"images\", one entry each.
 { \"uri\": \"{normal}\", \"mimeType\": \"image/ktx2\" }
 { \"uri\": \"{packed}\", \"mimeType\": \"image/ktx2\" }
Under \"textures\", say for image 0, and likewise for image 1:
 { \"extensions\": { \"KHR_texture_basisu\": { \"source\": 0 } } }
Add KHR_texture_basisu to \"extensionsUsed\" and \"extensionsRequired\".
In the material. For metals, or with a metal map: \"metallicFactor\": 1.
 \"normalTexture\": { \"index\": 0 }, \"occlusionTexture\": { \"index\": 1 },
 \"pbrMetallicRoughness\": { \"metallicFactor\": 0,
   \"metallicRoughnessTexture\": { \"index\": 1 } }",
    ..WEB
};

/// Babylon.js.
pub const BABYLON: Preset = Preset {
    name: "babylon",
    engine: "Babylon.js 9",
    facts: &[
        Fact {
            text: "The KTX 2 decoder transcodes each stored level, of UASTC with or without Zstandard.",
            source: "BabylonJS/Babylon.js, packages/tools/ktx2Decoder/src/ktx2Decoder.ts, commit 076e49a1",
            checked: true,
        },
        Fact {
            text: "It has no transcoder for files that are BC7 or BC5 already (--compress bc).",
            source: "BabylonJS/Babylon.js, packages/tools/ktx2Decoder/src/ktx2Decoder.ts, commit 076e49a1",
            checked: true,
        },
        Fact {
            text: "Of DDS files it reads --dds9 alone, and makes the levels anew: what was folded is lost.",
            source: "npm babylonjs 9.35.0, ddsTextureLoader; tried",
            checked: true,
        },
        Fact {
            text: "PBRMaterial takes roughness from alpha until told to take it from green.",
            source: "Babylon.js documentation, Mastering PBR Materials",
            checked: true,
        },
        Fact {
            text: "Which normals are inverted depends on the handedness of the scene; the steps do what Babylon's glTF \
                   loader does.",
            source: "BabylonJS/Babylon.js, packages/dev/loaders/src/glTF/2.0/glTFLoader.ts",
            checked: true,
        },
        Fact {
            text: "KTX 2 textures are not flipped on loading: on meshes that do not come from glTF set vScale = -1.",
            source: "from the behaviour of compressed textures in WebGL",
            checked: false,
        },
    ],
    load: "Load the files.
 const normal = new BABYLON.Texture('{normal}', scene);
 const orm = new BABYLON.Texture('{packed}', scene);
Make the material. For metals, or with a metal map: metallic = 1.
 const pbr = new BABYLON.PBRMaterial('material', scene);
 pbr.metallicTexture = orm; pbr.roughness = 1; pbr.metallic = 0;
 pbr.useRoughnessFromMetallicTextureAlpha = false;
 pbr.useRoughnessFromMetallicTextureGreen = true;
 pbr.useMetallnessFromMetallicTextureBlue = true;
 pbr.useAmbientOcclusionFromMetallicTextureRed = true;
 pbr.bumpTexture = normal;
 pbr.invertNormalMapX = !scene.useRightHandedSystem;
 pbr.invertNormalMapY = scene.useRightHandedSystem;",
    ..WEB
};

/// PlayCanvas.
pub const PLAYCANVAS: Preset = Preset {
    name: "playcanvas",
    engine: "PlayCanvas 2",
    facts: &[
        Fact {
            text: "Of KTX 2 only ETC1S and UASTC are read: --compress bc and none are refused.",
            source: "playcanvas/engine, src/framework/parsers/texture/ktx2.js, commit 07c61ad9",
            checked: true,
        },
        Fact {
            text: "All levels of both maps are those of the files, in PlayCanvas 2.23.3.",
            source: "mipfold's tests, tests/consumers.rs",
            checked: true,
        },
        Fact {
            text: "The Basis module must be there before the files are loaded.",
            source: "playcanvas/engine, src/framework/parsers/texture/ktx2.js, commit 07c61ad9",
            checked: true,
        },
        Fact {
            text: "Maps are multiplied by numbers, and gloss is 0.25 at first: set it to 1.",
            source: "PlayCanvas API reference, StandardMaterial; src/scene/materials/standard-material.js",
            checked: true,
        },
        Fact {
            text: "With glossInvert the gloss map is read as roughness, as the engine does for glTF.",
            source: "PlayCanvas API reference, StandardMaterialOptions; src/framework/parsers/glb-parser.js",
            checked: true,
        },
    ],
    load: "Have the Basis module loaded (URLs are those of your copy of it).
 pc.basisInitialize({ glueUrl, wasmUrl, fallbackUrl });
Load the files as assets of type texture.
 new pc.Asset('normal', 'texture', { url: '{normal}' })
 new pc.Asset('orm', 'texture', { url: '{packed}' })
Set the material up. For metals, or with a metal map: metalness = 1.
 material.useMetalness = true; material.metalness = 0;
 material.metalnessMap = orm; material.metalnessMapChannel = 'b';
 material.glossMap = orm; material.glossMapChannel = 'g';
 material.glossInvert = true; material.gloss = 1;
 material.aoMap = orm; material.aoMapChannel = 'r';
 material.normalMap = normal; material.update();",
    ..WEB
};

/// Filament.
pub const FILAMENT: Preset = Preset {
    name: "filament",
    engine: "Filament",
    // Its materials are the user's own: the channel is likely to be read as it is.
    without_metal: 0.0,
    facts: &[
        Fact {
            text: "Ktx2Reader transcodes every stored level; it reads Basis formats only, with Zstandard.",
            source: "google/filament, libs/ktxreader/src/Ktx2Reader.cpp, commit 10dcfb99; \
                     third_party/basisu/tnt/CMakeLists.txt, commit 00ecba67",
            checked: true,
        },
        Fact {
            text: "The first requested format that the GPU has is taken; BC7 and BC5 are not among them, and BC3 (DXT5) \
                   damages normals: request ASTC and RGBA8.",
            source: "google/filament, libs/ktxreader/src/Ktx2Reader.cpp, commit 10dcfb99",
            checked: true,
        },
        Fact {
            text: "A file that is marked linear is refused where sRGB is asked for.",
            source: "google/filament, libs/ktxreader/src/Ktx2Reader.cpp, commit 10dcfb99",
            checked: true,
        },
        Fact {
            text: "The steps take metal from blue as it is: so it is 0 where no map of metal came.",
            source: "mipfold's own",
            checked: true,
        },
    ],
    load: "Load the bytes of each file with a Ktx2Reader.
 ktxreader::Ktx2Reader reader(engine);
 reader.requestFormat(Texture::InternalFormat::RGBA_ASTC_4x4);
 reader.requestFormat(Texture::InternalFormat::RGBA8);
 // {normal}
 Texture* normal = reader.load(data, size,
   ktxreader::Ktx2Reader::TransferFunction::LINEAR);
 // {packed}: likewise
Sample them with LINEAR_MIPMAP_LINEAR, and REPEAT where they tile.
In the material, before and after prepareMaterial(material):
 material.normal = texture(materialParams_normal, uv).xyz * 2.0 - 1.0;
 vec3 orm = texture(materialParams_orm, uv).rgb;
 material.ambientOcclusion = orm.r;
 material.roughness = orm.g; material.metallic = orm.b;",
    ..WEB
};
