//! mipfold in Bevy 0.20.1: the material of `curvature.wesl`, which says what goes where and what is unverified.
//!
//! ```ignore
//! app.add_plugins(MaterialPlugin::<Curved>::default());
//! commands.spawn((Mesh3d(mesh), MeshMaterial3d(materials.add(Curved {
//!     base: StandardMaterial {
//!         normal_map_texture: Some(folded(&assets, "wall_normal.ktx2")),
//!         metallic_roughness_texture: Some(folded(&assets, "wall_orm.ktx2")),
//!         perceptual_roughness: 1.0, // a factor of the map
//!         ..default()
//!     },
//!     extension: Curvature {},
//! }))));
//! ```

use bevy::image::{ImageAddressMode, ImageLoaderSettings, ImageSampler, ImageSamplerDescriptor};
use bevy::pbr::{ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::ShaderRef;

/// A standard material that is as rough as the curvature of its mesh within a pixel makes it.
pub type Curved = ExtendedMaterial<StandardMaterial, Curvature>;

/// Widens the base material; has nothing to set.
#[derive(Asset, AsBindGroup, Reflect, Clone, Debug, Default)]
pub struct Curvature {}

impl MaterialExtension for Curvature {
    fn fragment_shader() -> ShaderRef {
        "shaders/curvature.wesl".into()
    }

    fn deferred_fragment_shader() -> ShaderRef {
        "shaders/curvature.wesl".into()
    }
}

/// A KTX2 of mipfold's mips, read as numbers and not as colours, which is Bevy's default, and repeated.
pub fn folded(assets: &AssetServer, path: &'static str) -> Handle<Image> {
    let settings = |settings: &mut ImageLoaderSettings| {
        settings.is_srgb = false;
        settings.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
            address_mode_u: ImageAddressMode::Repeat,
            address_mode_v: ImageAddressMode::Repeat,
            ..ImageSamplerDescriptor::linear()
        });
    };
    assets.load_builder().with_settings(settings).load(path)
}
