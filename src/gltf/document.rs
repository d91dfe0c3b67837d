//! The parts of a glTF document that say where triangles are and what their roughness and normals come from; everything
//! else in the file is skipped.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::words::objects;

objects!(
    Document,
    Asset,
    Buffer,
    BufferView,
    Accessor,
    Material,
    MetallicRoughness,
    TextureInfo,
    Texture,
    TextureExtensions,
    Source,
    Image,
    Sampler,
    Mesh,
    Primitive,
    Node,
    Scene,
);

/// The JSON of a file.
#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct Document {
    pub asset: Asset,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub textures: Vec<Texture>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    pub scene: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Asset {
    pub version: String,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase", default)]
pub(crate) struct Material {
    pub name: Option<String>,
    pub pbr_metallic_roughness: MetallicRoughness,
    pub normal_texture: Option<TextureInfo>,
    pub occlusion_texture: Option<TextureInfo>,
    pub extensions: BTreeMap<String, serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase", default)]
pub(crate) struct MetallicRoughness {
    pub roughness_factor: f32,
    pub metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self { roughness_factor: 1.0, metallic_roughness_texture: None }
    }
}

/// A texture as a material uses it.
#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: usize,
    /// Of normals.
    #[serde(default = "one")]
    pub scale: f32,
    #[serde(default)]
    pub extensions: BTreeMap<String, serde::de::IgnoredAny>,
}

fn one() -> f32 {
    1.0
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Texture {
    pub source: Option<usize>,
    pub sampler: Option<usize>,
    #[serde(default)]
    pub extensions: TextureExtensions,
}

impl Texture {
    /// The image that is read: WebP's if there is one.
    ///
    /// # Errors
    /// What the texture is instead, in words that follow its name.
    pub fn image(&self) -> Result<usize, String> {
        let webp = self.extensions.webp.as_ref().map(|webp| webp.source);
        webp.or(self.source).ok_or_else(|| match self.extensions.others.keys().next() {
            Some(extension) => format!("in the form of {extension:?}"),
            None => "without an image".to_owned(),
        })
    }
}

/// Other forms of a texture; we read WebP.
#[derive(Debug, Default, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub webp: Option<Source>,
    #[serde(flatten)]
    pub others: BTreeMap<String, serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Source {
    pub source: usize,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct Image {
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
    pub name: Option<String>,
    pub mime_type: Option<String>,
}

/// How a texture continues beyond its border; 10497 repeats, 33648 mirrors, 33071 clamps.
#[derive(Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase")]
pub(crate) struct Sampler {
    #[serde(default = "repeat")]
    pub wrap_s: u32,
    #[serde(default = "repeat")]
    pub wrap_t: u32,
    /// How it is minified; 9728 and 9729 use no mips.
    pub min_filter: Option<u32>,
}

fn repeat() -> u32 {
    10497
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    /// 0 points, 1 to 3 lines, 4 triangles, 5 a strip, 6 a fan.
    #[serde(default = "triangles")]
    pub mode: u32,
    #[serde(default)]
    pub extensions: BTreeMap<String, serde::de::IgnoredAny>,
}

fn triangles() -> u32 {
    4
}

/// Numbers are in lists, whose length is checked where they are used.
#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Node {
    pub mesh: Option<usize>,
    #[serde(default)]
    pub children: Vec<usize>,
    pub matrix: Option<Vec<f64>>,
    pub translation: Option<Vec<f64>>,
    pub rotation: Option<Vec<f64>>,
    pub scale: Option<Vec<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(remote = "Self")]
pub(crate) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}
