//! Bevy, and the `.meta` files that keep it from taking linear data for sRGB.

use super::web::ORM;
use super::{Aside, Compress, Fact, Preset, Written};
use crate::image::{Sides, Wrap};
use crate::material::NormalY;
use crate::output::Format;

/// Bevy.
pub const BEVY: Preset = Preset {
    name: "bevy",
    engine: "Bevy 0.15 to 0.20",
    format: Format::Ktx2,
    compress: Compress::Bc,
    normal_z: false,
    normal_y: NormalY::OpenGl,
    packed: Some(ORM),
    packed_suffix: "orm",
    without_metal: 1.0,
    sides: Sides::MultipleOf4,
    facts: &[
        Fact {
            text: "Without its .meta file a BC7 or RGBA8 texture is read as sRGB whatever it says of itself, and roughness \
                   comes out too low: keep the .meta files beside the textures.",
            source: "bevy_image 0.20.1, src/image_loader.rs, ImageLoaderSettings; src/ktx2.rs, \
                     ktx2_format_to_texture_format; loaded both ways",
            checked: true,
        },
        Fact {
            text: "Textures clamp at their border by default; the .meta files say what the maps were folded for.",
            source: "bevy_image 0.20.1, src/image.rs, ImageAddressMode",
            checked: true,
        },
        Fact {
            text: "The settings in the .meta files are those that all versions from 0.15 on have.",
            source: "bevy tags v0.15.0 to v0.19.0, crates/bevy_image/src/image_loader.rs; bevy_image 0.20.1",
            checked: true,
        },
        Fact {
            text: "The factors multiply the map, and perceptual_roughness is 0.5 at first.",
            source: "bevy_pbr 0.20.1, src/pbr_material.rs; src/render/pbr_fragment.wesl",
            checked: true,
        },
        Fact {
            text: "z of BC5 normals is the root of 1 - x*x - y*y, not clamped; mipfold keeps it from being negative.",
            source: "bevy_pbr 0.20.1, src/render/pbr_functions.wesl",
            checked: true,
        },
        Fact {
            text: "BC needs a desktop GPU; for others build with --compress none.",
            source: "bevy_image 0.20.1, src/ktx2.rs, supported_compressed_formats",
            checked: true,
        },
    ],
    load: "Put the files into assets/, each with its .meta file beside it.
Load them; the features ktx2 and zstd_rust must be on.
 let normal = asset_server.load(\"{normal}\");
 let orm = asset_server.load(\"{packed}\");
Make the material. For metals, or with a metal map: metallic: 1.0.
 StandardMaterial {
     normal_map_texture: Some(normal),
     metallic_roughness_texture: Some(orm.clone()),
     occlusion_texture: Some(orm),
     perceptual_roughness: 1.0,
     metallic: 0.0,
     ..default()
 }
Give the mesh tangents if it has none: mesh.with_generated_tangents().",
    aside: metas,
};

/// A `.meta` file for every texture: linear, and repeated as the maps were folded.
fn metas(written: &Written) -> Vec<Aside> {
    let files = written.maps.iter().flat_map(|map| map.files);
    files.map(|file| Aside { name: format!("{file}.meta"), text: meta(written.wrap) }).collect()
}

/// RON, as `bevy_asset::meta::AssetMeta` is read. The settings have no defaults in Bevy, and neither has the sampler.
fn meta(wrap: Wrap) -> String {
    let mode = match wrap {
        Wrap::Repeat => "Repeat",
        Wrap::Mirror => "MirrorRepeat",
        Wrap::Clamp => "ClampToEdge",
    };
    format!(
        "(
    meta_format_version: \"1.0\",
    asset: Load(
        loader: \"bevy_image::image_loader::ImageLoader\",
        settings: (
            format: FromExtension,
            is_srgb: false,
            sampler: Descriptor((
                label: None,
                address_mode_u: {mode},
                address_mode_v: {mode},
                address_mode_w: {mode},
                mag_filter: Linear,
                min_filter: Linear,
                mipmap_filter: Linear,
                lod_min_clamp: 0.0,
                lod_max_clamp: 32.0,
                compare: None,
                anisotropy_clamp: 1,
                border_color: None,
            )),
            asset_usage: (\"MAIN_WORLD | RENDER_WORLD\"),
        ),
    ),
)
"
    )
}
