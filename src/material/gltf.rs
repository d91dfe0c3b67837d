//! What the materials of a glTF file are made from: its normal and roughness textures as inputs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::{ChannelRef, Inputs, RoughnessInput};
use crate::codec::{self, Decoded, read_file};
use crate::error::{Error, Result};
use crate::gltf::{
    Buffers, Document, Image, Material, Reader, Sampler, TextureInfo, beside, inline, is_gltf, item, open,
};
use crate::image::{Raster, Samples, Wrap};
use crate::roughness::PerceptualRoughness;

/// glTF's channel of the roughness.
const GREEN: usize = 1;

/// The materials of a glTF file.
pub struct Model {
    path: PathBuf,
    bytes: Vec<u8>,
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
    pictures: HashMap<PathBuf, Picture>,
}

/// Where a picture is, and what its roughness is multiplied with.
#[derive(Clone, Debug)]
struct Picture {
    source: Source,
    factor: Option<f32>,
}

#[derive(Clone, Debug)]
enum Source {
    File(PathBuf),
    /// Inside the file.
    Bytes(Vec<u8>),
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

    /// The surfaces that these materials make, each by its number in the file, in order of their first one. One that cannot
    /// be read does not hide the others.
    ///
    /// # Errors
    /// A file that is no glTF. For each surface: textures that are missing, in another form than pictures, or used in a
    /// way that a mip chain cannot follow.
    pub fn surfaces(&self, used: &[usize]) -> Result<Vec<Result<Surface>>> {
        let (document, binary) = open(&self.path, &self.bytes)?;
        let buffers = Buffers::new(&self.path, &document.buffers, binary);
        let reader = Reader { path: &self.path, document: &document, buffers: &buffers };
        let mut surfaces: Vec<Result<Surface>> = Vec::new();
        for &index in used {
            match Self::surface(&reader, index) {
                Ok(surface) => {
                    let same = surfaces.iter_mut().flatten().find(|other| other.shares_maps_with(&surface));
                    match same {
                        Some(other) => {
                            other.materials.push(index);
                            let note = format!("also for material {}, which shares the maps", surface.inputs.name);
                            other.inputs.notes.push(note);
                        }
                        None => surfaces.push(Ok(surface)),
                    }
                }
                Err(error) => surfaces.push(Err(error)),
            }
        }
        Ok(surfaces)
    }

    fn surface(reader: &Reader, index: usize) -> Result<Surface> {
        let path = reader.path;
        let material: &Material = item(path, &reader.document.materials, index, "material")?;
        let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
        let wrong = |found: String, expected: &str| {
            Err(Error::Unsupported {
                subject: format!("{}: material {name:?}", path.display()),
                found,
                expected: expected.to_owned(),
            })
        };
        if material.extensions.contains_key("KHR_materials_pbrSpecularGlossiness") {
            return wrong("KHR_materials_pbrSpecularGlossiness".into(), "roughness; or maps given with --roughness");
        }
        let metallic = &material.pbr_metallic_roughness;
        let textures = [
            ("normalTexture", material.normal_texture.as_ref()),
            ("metallicRoughnessTexture", metallic.metallic_roughness_texture.as_ref()),
        ];
        for (what, texture) in textures {
            if texture.is_some_and(|texture| texture.extensions.contains_key("KHR_texture_transform")) {
                let expected = "texture coordinates as they are: apply the transform to the mesh, or give maps";
                return wrong(format!("KHR_texture_transform on its {what}"), expected);
            }
        }
        let [normal, width] = textures.map(|(_, texture)| texture);
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
        let mut surface = Surface {
            inputs: Inputs { name: name.clone(), ..Inputs::default() },
            materials: vec![index],
            uv_set: normal.or(width).map(|texture| texture.tex_coord),
            pictures: HashMap::new(),
        };
        if let Some(texture) = normal {
            let picture = surface.add(reader, texture, "normal", None)?;
            surface.inputs.normal = Some(picture);
            surface.inputs.normal_scale = Some(texture.scale);
        }
        surface.inputs.roughness = match width {
            None => RoughnessInput::Constant(PerceptualRoughness(factor)),
            Some(texture) => {
                let factor = (factor != 1.0).then_some(factor);
                let path = surface.add(reader, texture, "metallic_roughness", factor)?;
                if let Some(factor) = factor {
                    let note = format!("roughnessFactor {factor} is multiplied into the maps: set it to 1 beside them");
                    surface.inputs.notes.push(note);
                }
                RoughnessInput::Roughness(ChannelRef { path, channel: Some(GREEN) })
            }
        };
        if let Some(texture) = normal.or(width) {
            surface.inputs.wrap = surface.wrap(reader, texture)?;
        }
        if material.extensions.contains_key("KHR_materials_anisotropy") {
            let warning = "KHR_materials_anisotropy is not read from glTF: the lobes are taken as round (--anisotropy)";
            surface.inputs.warnings.push(warning.into());
        }
        Ok(surface)
    }
}

impl Surface {
    /// The picture of a path of [`Surface::inputs`].
    ///
    /// # Errors
    /// Those of [`codec::read`].
    pub fn read(&self, path: &Path) -> Result<Decoded> {
        let Some(picture) = self.pictures.get(path) else { return codec::read(path) };
        let mut decoded = match &picture.source {
            Source::File(path) => codec::read(path)?,
            Source::Bytes(bytes) => codec::decode(path, bytes.clone())?,
        };
        if let Some(factor) = picture.factor {
            decoded.raster = scaled(decoded.raster, factor);
            decoded.plain_png = None;
        }
        Ok(decoded)
    }

    /// Whether one chain can stand for both: all but the names.
    fn shares_maps_with(&self, other: &Surface) -> bool {
        let same = |surface: &Surface| {
            let inputs = &surface.inputs;
            (inputs.normal.clone(), inputs.roughness.clone(), inputs.normal_scale, inputs.wrap, surface.uv_set)
        };
        self.uv_set.is_some() && same(self) == same(other)
    }

    /// Adds the picture of a texture; `role` is its name if it has none. Returns the path that stands for it.
    fn add(&mut self, reader: &Reader, texture: &TextureInfo, role: &str, factor: Option<f32>) -> Result<PathBuf> {
        let (path, document) = (reader.path, reader.document);
        let entry = item(path, &document.textures, texture.index, "texture")?;
        let Some(source) = entry.source else {
            let found = match entry.extensions.keys().next() {
                Some(extension) => format!("texture {} in the form of {extension}", texture.index),
                None => format!("texture {} without an image", texture.index),
            };
            return Err(Error::unsupported(path, found, "PNG, JPEG or WebP images"));
        };
        let image: &Image = item(path, &document.images, source, "image")?;
        let what = format!("image {source}");
        let inside = |bytes: Vec<u8>| {
            // As if the model were a folder: messages and names of outputs come from this path.
            let name = image.name.clone().unwrap_or_else(|| format!("{role}_{source}"));
            let name: String =
                name.chars().map(|c| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' }).collect();
            (path.join(format!("{name}.{}", ending(&bytes))), Source::Bytes(bytes))
        };
        let (mut name, source) = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match inline(path, uri, &what)? {
                Some(bytes) => inside(bytes),
                None => {
                    let file = beside(path, uri, &what)?;
                    (file.clone(), Source::File(file))
                }
            },
            (None, Some(view)) => inside(reader.view(view)?.to_vec()),
            (None, None) => return Err(Error::invalid(path, format!("{what} without data"), "a uri or a buffer view")),
        };
        if let Some(factor) = factor {
            // The same picture with another factor is another map.
            let file = name.file_name().unwrap_or_default().to_owned();
            name = name.with_file_name(format!("roughnessFactor {factor}")).join(file);
        }
        self.pictures.insert(name.clone(), Picture { source, factor });
        Ok(name)
    }

    /// How the sampler of a texture continues it; warns where its two sides differ.
    fn wrap(&mut self, reader: &Reader, texture: &TextureInfo) -> Result<Wrap> {
        let document: &Document = reader.document;
        let Some(sampler) = item(reader.path, &document.textures, texture.index, "texture")?.sampler else {
            return Ok(Wrap::Repeat);
        };
        let Sampler { wrap_s, wrap_t } = item(reader.path, &document.samplers, sampler, "sampler")?;
        if wrap_s != wrap_t {
            self.inputs.warnings.push(format!("sampler {sampler} wraps u and v differently; both are taken as u"));
        }
        Ok(match wrap_s {
            33648 => Wrap::Mirror,
            33071 => Wrap::Clamp,
            _ => Wrap::Repeat,
        })
    }
}

/// The ending of a picture's file name by its content; for names of outputs only.
fn ending(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        _ => "picture",
    }
}

/// A picture with its roughness multiplied by a factor, 0 to 1.
fn scaled(raster: Raster, factor: f32) -> Raster {
    let channel = if raster.channels.len() > GREEN { GREEN } else { 0 };
    let channels = raster.channels.clone();
    let mut samples = raster.samples;
    let axis = ndarray::Axis(2);
    match &mut samples {
        Samples::U8(a) => a.index_axis_mut(axis, channel).mapv_inplace(|v| (f32::from(v) * factor).round() as u8),
        Samples::U16(a) => a.index_axis_mut(axis, channel).mapv_inplace(|v| (f32::from(v) * factor).round() as u16),
        Samples::F32(a) => a.index_axis_mut(axis, channel).mapv_inplace(|v| v * factor),
    }
    Raster { samples, channels }
}

#[cfg(test)]
mod tests;
