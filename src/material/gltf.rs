//! What the materials of a glTF file are made from: its normal and roughness textures as inputs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{ChannelRef, Inputs, RoughnessInput};
use crate::codec::{self, Decoded, read_file};
use crate::error::{Error, Result};
use crate::gltf::{Buffers, Material, Reader, Sampler, Stored, TextureInfo, is_gltf, item, open};
use crate::image::Wrap;
use crate::roughness::PerceptualRoughness;

pub(crate) use folds::turn;
pub use folds::{AnisotropyUse, Fate, Foldable, TextureUse};

/// glTF's channels of occlusion, roughness and metal.
const RED: usize = 0;
const GREEN: usize = 1;
const BLUE: usize = 2;

/// Letters of a material's name that are shown and used for files.
const LONGEST_NAME: usize = 80;

/// The materials of a glTF file.
pub struct Model {
    pub(crate) path: PathBuf,
    pub(crate) bytes: Vec<u8>,
}

/// Materials of a file that use the same maps in the same way; most often one.
#[derive(Clone, Debug)]
pub struct Surface {
    /// What they are made from. Its pictures are read by [`Surface::read`].
    pub inputs: Inputs,
    /// Their numbers in the file.
    pub materials: Vec<usize>,
    /// The set of texture coordinates that the maps are laid out with, `TEXCOORD_n`; none without maps.
    pub uv_set: Option<usize>,
    /// Pictures inside the file, by the path that stands for them.
    embedded: HashMap<PathBuf, Arc<[u8]>>,
}

impl Model {
    /// Reads the file, without its pictures; nothing if its content is not glTF's.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read.
    pub fn read(path: &Path) -> Result<Option<Self>> {
        let bytes = read_file(path, "a mesh file", u64::MAX)?;
        Ok(is_gltf(&bytes).then(|| Self { path: path.to_owned(), bytes }))
    }

    /// How many materials the file has.
    ///
    /// # Errors
    /// A file that is no glTF.
    pub fn materials(&self) -> Result<usize> {
        Ok(open(&self.path, &self.bytes)?.0.materials.len())
    }

    /// The surfaces that these materials make, each by its number in the file, in order of their first one. One that cannot
    /// be read does not hide the others.
    ///
    /// # Errors
    /// A file that is no glTF. For each surface: textures that are missing, in another form than pictures, or used in a
    /// way that a mip chain cannot follow.
    pub fn surfaces(&self, used: impl IntoIterator<Item = usize>) -> Result<Vec<Result<Surface>>> {
        let (document, binary) = open(&self.path, &self.bytes)?;
        let buffers = Buffers::new(&self.path, &document.buffers, binary);
        let reader = Reader { path: &self.path, document: &document, buffers: &buffers };
        let mut pictures = Pictures { reader: &reader, embedded: HashMap::new() };
        let mut surfaces: Vec<Result<Surface>> = Vec::new();
        for index in used {
            let surface = match surface(&mut pictures, index) {
                Ok(surface) => surface,
                Err(error) => {
                    surfaces.push(Err(error));
                    continue;
                }
            };
            match surfaces.iter_mut().flatten().find(|other| other.shares_maps_with(&surface)) {
                Some(other) => {
                    other.materials.push(index);
                    let note = format!("also for material {}, which shares the maps", surface.inputs.name);
                    other.inputs.notes.push(note);
                }
                None => surfaces.push(Ok(surface)),
            }
        }
        Ok(surfaces)
    }
}

impl Surface {
    /// The picture of a path of [`Surface::inputs`]. A gray roughness map is all three colours, as glTF has it.
    ///
    /// # Errors
    /// Those of [`codec::read`].
    pub fn read(&self, path: &Path) -> Result<Decoded> {
        picture(&self.inputs, &self.embedded, path)
    }

    /// Whether one chain can stand for both: all but the names.
    fn shares_maps_with(&self, other: &Surface) -> bool {
        let of = |surface: &Surface| {
            let inputs = surface.inputs.clone();
            let (read, packed) = ((inputs.normal_scale, inputs.roughness_factor, inputs.wrap), inputs.occlusion);
            (inputs.normal, inputs.roughness, read, packed, surface.uv_set)
        };
        self.uv_set.is_some() && of(self) == of(other)
    }
}

/// The picture of a path of some inputs: of those inside the file, or a file itself. A gray roughness map is all three
/// colours, as glTF has it.
fn picture(inputs: &Inputs, embedded: &HashMap<PathBuf, Arc<[u8]>>, path: &Path) -> Result<Decoded> {
    let mut decoded = match embedded.get(path) {
        Some(bytes) => codec::decode(path, bytes.to_vec())?,
        None => codec::read(path)?,
    };
    if is_roughness(inputs, path) && decoded.raster.channels.len() < 3 {
        decoded.raster = decoded.raster.gray_as_rgb();
        decoded.plain_png = None;
    }
    Ok(decoded)
}

/// Whether a path is that of the roughness texture.
fn is_roughness(inputs: &Inputs, path: &Path) -> bool {
    matches!(&inputs.roughness, RoughnessInput::Roughness(channel) if channel.path == path)
}

/// A material's name as it is shown and used for files.
fn material_name(name: Option<&str>, index: usize) -> String {
    let name: String = name.into_iter().flat_map(str::chars).filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
    if name.trim().is_empty() { format!("material {index}") } else { name }
}

fn surface(pictures: &mut Pictures, index: usize) -> Result<Surface> {
    let Reader { path, document, .. } = *pictures.reader;
    let material: &Material = item(path, &document.materials, index, "material")?;
    let name = material_name(material.name.as_deref(), index);
    let wrong = |found: String, expected: &str| {
        let subject = format!("{}: material {name:?}", path.display());
        Err(Error::Unsupported { subject, found, expected: expected.to_owned() })
    };
    if material.extensions.contains_key("KHR_materials_pbrSpecularGlossiness") {
        return wrong("KHR_materials_pbrSpecularGlossiness".into(), "metallic roughness; or maps given by options");
    }
    let metallic = &material.pbr_metallic_roughness;
    let (normal, width) = (material.normal_texture.as_ref(), metallic.metallic_roughness_texture.as_ref());
    for (what, texture) in [("normalTexture", normal), ("metallicRoughnessTexture", width)] {
        if texture.is_some_and(|texture| texture.extensions.contains_key("KHR_texture_transform")) {
            let expected = "texture coordinates as they are: apply the transform to the mesh, or give maps by options";
            return wrong(format!("KHR_texture_transform on its {what}"), expected);
        }
    }
    if let (Some(n), Some(r)) = (normal, width)
        && n.tex_coord != r.tex_coord
    {
        let found = format!("normals by TEXCOORD_{} and roughness by TEXCOORD_{}", n.tex_coord, r.tex_coord);
        return wrong(found, "both by one set: texels of two layouts cannot be paired");
    }
    let factor = metallic.roughness_factor;
    if !(0.0..=1.0).contains(&factor) {
        return wrong(format!("roughnessFactor {factor}"), "a number from 0 to 1");
    }
    // A normal map of scale 0 is flat.
    let normal = normal.filter(|texture| texture.scale != 0.0);
    if let Some(texture) = normal
        && !(1e-3..=1e3).contains(&texture.scale)
    {
        return wrong(format!("a normal map of scale {}", texture.scale), "a scale of 0, or from 0.001 to 1000");
    }
    let mut inputs = Inputs { name: name.clone(), ..Inputs::default() };
    let mut embedded = HashMap::new();
    let mut picture = |texture: &TextureInfo, role: &str| -> Result<PathBuf> {
        let (path, bytes) = pictures.get(texture, role)?;
        embedded.extend(bytes.map(|bytes| (path.clone(), bytes)));
        Ok(path)
    };
    if let Some(texture) = normal {
        inputs.normal = Some(picture(texture, "normal")?);
        inputs.normal_scale = Some(texture.scale);
    }
    inputs.roughness = match width {
        None => RoughnessInput::Constant(PerceptualRoughness(factor)),
        Some(texture) => {
            inputs.roughness_factor = Some(factor);
            let path = picture(texture, "metallic_roughness")?;
            inputs.metal = Some(ChannelRef { path: path.clone(), channel: Some(BLUE) });
            RoughnessInput::Roughness(ChannelRef { path, channel: Some(GREEN) })
        }
    };
    // It is packed where its layout is that of the other maps.
    let uv_set = normal.or(width).map(|texture| texture.tex_coord);
    let moved = |texture: &TextureInfo| texture.extensions.contains_key("KHR_texture_transform");
    let occlusion = material.occlusion_texture.as_ref();
    if let Some(texture) = occlusion.filter(|texture| uv_set == Some(texture.tex_coord) && !moved(texture)) {
        let path = picture(texture, "occlusion")?;
        inputs.occlusion = Some(ChannelRef { path, channel: Some(RED) });
    }
    if let Some(texture) = normal.or(width) {
        inputs.wrap = wrap(pictures.reader, texture, &mut inputs.warnings)?;
    }
    if material.extensions.contains_key("KHR_materials_anisotropy") {
        let warning = "KHR_materials_anisotropy is not read from glTF: the lobes are taken as round (--anisotropy)";
        inputs.warnings.push(warning.into());
    }
    Ok(Surface { inputs, materials: vec![index], uv_set, embedded })
}

/// How the sampler of a texture continues it; warns where its two sides differ.
fn wrap(reader: &Reader, texture: &TextureInfo, warnings: &mut Vec<String>) -> Result<Wrap> {
    let document = reader.document;
    let Some(sampler) = item(reader.path, &document.textures, texture.index, "texture")?.sampler else {
        return Ok(Wrap::Repeat);
    };
    let Sampler { wrap_s, wrap_t, .. } = item(reader.path, &document.samplers, sampler, "sampler")?;
    if wrap_s != wrap_t {
        warnings.push(format!("sampler {sampler} wraps u and v differently; both are taken as u"));
    }
    Ok(match wrap_s {
        33648 => Wrap::Mirror,
        33071 => Wrap::Clamp,
        _ => Wrap::Repeat,
    })
}

/// The pictures of a file; those inside it are held once.
struct Pictures<'a, 'f> {
    reader: &'a Reader<'a, 'f>,
    /// By image.
    embedded: HashMap<usize, Arc<[u8]>>,
}

impl Pictures<'_, '_> {
    /// The path that stands for a texture's picture, and its bytes if it is inside the file; `role` is its name if it has
    /// none.
    fn get(&mut self, texture: &TextureInfo, role: &str) -> Result<(PathBuf, Option<Arc<[u8]>>)> {
        let Reader { path, document, .. } = *self.reader;
        let entry = item(path, &document.textures, texture.index, "texture")?;
        let source = entry.image().map_err(|instead| {
            let found = format!("texture {} {instead}", texture.index);
            Error::unsupported(path, found, "PNG, JPEG or WebP images")
        })?;
        let image = item(path, &document.images, source, "image")?;
        let bytes = match self.embedded.get(&source) {
            Some(bytes) => bytes.clone(),
            None => match self.reader.image(source)? {
                Stored::File(file) => return Ok((file, None)),
                Stored::Inside(bytes) => self.embedded.entry(source).or_insert(bytes.into()).clone(),
            },
        };
        // As if the model were a folder, with one for each image, since names may be equal: messages and names of outputs
        // come from this path.
        let name = image.name.as_deref().filter(|name| !name.is_empty()).unwrap_or(role);
        let plain = |c: char| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' };
        let name: String = name.chars().map(plain).take(LONGEST_NAME).collect();
        let file = path.join(format!("image {source}")).join(format!("{name}.{}", ending(&bytes)));
        Ok((file, Some(bytes)))
    }
}

/// The ending of a picture's file name by its content; for messages only.
fn ending(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        _ => "picture",
    }
}

mod folds;
mod headers;

#[cfg(test)]
mod tests;
