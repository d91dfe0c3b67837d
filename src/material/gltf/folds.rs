//! Which materials of a model a fold can serve, and how these use their textures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec2;
use ndarray::Array3;
use serde::Deserialize;

use super::{GREEN, Model, Pictures, headers, is_roughness, material_name, picture, wrap};
use crate::codec::{Decoded, read_file};
use crate::error::Result;
use crate::gltf::text::{at, items, member};
use crate::gltf::{Buffers, Reader, TextureInfo, item, objects, open, parse, parts};
use crate::image::{Raster, Samples, Size, each_texel, from_rows};
use crate::material::{ChannelRef, Inputs, RoughnessInput};
use crate::roughness::PerceptualRoughness;

/// Stands for a picture of the one anisotropy of a material without a texture of it.
const EVEN_ANISOTROPY: &str = "even anisotropy";

/// A texture as a material uses it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextureUse {
    /// Its number in the file.
    pub texture: usize,
    /// The image that is read.
    pub image: usize,
    /// The use as the file has it, a JSON object: texture, set of coordinates, transform.
    pub info: String,
}

/// What is known of a material's anisotropy (`KHR_materials_anisotropy`).
#[derive(Clone, Debug, PartialEq)]
pub struct AnisotropyUse {
    /// What the renderer multiplies the texture's strength with.
    pub strength: f32,
    /// Radians, by which the renderer turns the texture's directions.
    pub rotation: f32,
    /// The texture; without one, direction and strength are the same everywhere.
    pub texture: Option<TextureUse>,
}

/// Materials of a file that use the same textures in the same way, and can be folded; most often one.
#[derive(Clone, Debug)]
pub struct Foldable {
    /// What their chain is made from; its pictures are those of [`Foldable::picture`] with [`Foldable::apply_factors`].
    pub inputs: Inputs,
    /// Their numbers in the file.
    pub materials: Vec<usize>,
    /// Their normal texture.
    pub normal: TextureUse,
    /// Their roughness texture; without one the roughness is the factor.
    pub roughness: Option<TextureUse>,
    /// What the renderer multiplies the roughness with.
    pub factor: f32,
    /// Their anisotropy.
    pub anisotropy: Option<AnisotropyUse>,
    /// Whether u and v wrap differently, so that maps that are enlarged may be a little wrong at their borders.
    pub wraps_differ: bool,
    embedded: HashMap<PathBuf, Arc<[u8]>>,
}

/// What becomes of a material.
#[derive(Clone, Debug)]
pub enum Fate {
    /// It can be folded.
    Fold(Box<Foldable>),
    /// It stays as it is.
    Leave {
        /// Its number in the file.
        material: usize,
        /// For messages.
        name: String,
        /// Why.
        reason: String,
        /// Whether that is for want of a normal map, and so nothing to wonder about.
        plain: bool,
    },
}

objects!(Anisotropy, Layout);

#[derive(Deserialize)]
#[serde(remote = "Self", rename_all = "camelCase", default)]
struct Anisotropy {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<TextureInfo>,
}

impl Default for Anisotropy {
    fn default() -> Self {
        Self { anisotropy_strength: 0.0, anisotropy_rotation: 0.0, anisotropy_texture: None }
    }
}

/// `KHR_texture_transform`, and the set of coordinates that it transforms.
#[derive(Deserialize, Debug, PartialEq)]
#[serde(remote = "Self", rename_all = "camelCase", default)]
struct Layout {
    offset: [f64; 2],
    rotation: f64,
    scale: [f64; 2],
    tex_coord: Option<usize>,
}

impl Default for Layout {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl Layout {
    /// Of a use of a texture.
    fn of(path: &Path, info: &TextureInfo, text: &str) -> Result<Self> {
        let name = "KHR_texture_transform";
        let transform = at(text, &["extensions", name]);
        let layout: Self = transform.map_or_else(|| Ok(Self::default()), |text| parse(path, name, text))?;
        Ok(Self { tex_coord: Some(layout.tex_coord.unwrap_or(info.tex_coord)), ..layout })
    }
}

impl Model {
    /// What becomes of each material when the model is folded, in order of the first of those that share their textures.
    ///
    /// # Errors
    /// A file that is no glTF, or that contradicts itself. A picture that cannot be had leaves its material alone.
    pub fn fates(&self) -> Result<Vec<Fate>> {
        let (document, binary) = open(&self.path, &self.bytes)?;
        let text = parts(&self.path, &self.bytes)?.text;
        let buffers = Buffers::new(&self.path, &document.buffers, binary);
        let reader = Reader { path: &self.path, document: &document, buffers: &buffers };
        let mut pictures = Pictures { reader: &reader, embedded: HashMap::new() };
        let texts = member(text, "materials").map_or_else(Vec::new, items);
        let animated = animated(text);
        let mut fates: Vec<Fate> = Vec::new();
        for (index, text) in texts.into_iter().enumerate() {
            let foldable = match foldable(&mut pictures, index, text, &animated)? {
                Ok(foldable) => foldable,
                Err((reason, plain)) => {
                    let name = material_name(document.materials[index].name.as_deref(), index);
                    fates.push(Fate::Leave { material: index, name, reason, plain });
                    continue;
                }
            };
            let same = fates.iter_mut().find_map(|fate| match fate {
                Fate::Fold(other) if other.shares_maps_with(&foldable) => Some(other),
                _ => None,
            });
            match same {
                Some(other) => {
                    other.materials.push(index);
                    let note = format!("also for material {}, which uses the same textures", foldable.inputs.name);
                    other.inputs.notes.push(note);
                }
                None => fates.push(Fate::Fold(Box::new(foldable))),
            }
        }
        Ok(fates)
    }
}

impl Foldable {
    /// The picture of a path of [`Foldable::inputs`], as the file has it: a gray roughness map in all three colours.
    ///
    /// # Errors
    /// Those of [`crate::codec::read`].
    pub fn picture(&self, path: &Path) -> Result<Decoded> {
        if path == Path::new(EVEN_ANISOTROPY) {
            return Ok(self.even_anisotropy());
        }
        picture(&self.inputs, &self.embedded, path)
    }

    /// The size that its maps will have, as far as the headers of their pictures tell: the longest sides of any.
    pub fn size(&self) -> Option<Size> {
        let Inputs { normal, roughness, anisotropy, .. } = &self.inputs;
        let paths = [normal.as_deref(), roughness.file(), anisotropy.as_deref()].into_iter().flatten();
        let size = |path: &Path| match self.embedded.get(path) {
            Some(bytes) => headers::size(bytes),
            None => headers::size(&read_file(path, "a picture file", u64::MAX).ok()?),
        };
        let sizes: Vec<Size> =
            paths.filter(|path| *path != Path::new(EVEN_ANISOTROPY)).map(size).collect::<Option<_>>()?;
        let sides = |side: fn(&Size) -> usize| sizes.iter().map(side).max();
        Some(Size::new(sides(|size| size.width)?, sides(|size| size.height)?))
    }

    /// Makes of the picture of a path what the renderer makes of it: the factor times the roughness, directions turned.
    /// Floats, if that changes anything, so that nothing is rounded.
    pub fn apply_factors(&self, path: &Path, decoded: &mut Decoded) {
        if decoded.raster.channels.len() < 3 {
            return;
        }
        match &self.anisotropy {
            _ if is_roughness(&self.inputs, path) && self.factor != 1.0 => {
                edit(decoded, |texel| texel[GREEN] *= self.factor);
            }
            Some(AnisotropyUse { strength, rotation, texture: Some(_) })
                if self.inputs.anisotropy.as_deref() == Some(path) && (*strength, *rotation) != (1.0, 0.0) =>
            {
                edit(decoded, |texel| {
                    turn(texel, *rotation);
                    texel[2] *= strength;
                });
            }
            _ => {}
        }
    }

    /// One texel that all others are like.
    fn even_anisotropy(&self) -> Decoded {
        let (strength, rotation) = self.anisotropy.as_ref().map_or((0.0, 0.0), |a| (a.strength, a.rotation));
        let direction = 0.5 + 0.5 * Vec2::from_angle(rotation);
        let texel = [direction.x, direction.y, strength];
        let raster = Raster::new(Samples::F32(Array3::from_shape_fn((1, 1, 3), |(_, _, c)| texel[c])));
        Decoded { raster, format: "glTF", notes: vec![], sha256: String::new(), bytes_len: 0, plain_png: None }
    }

    /// Whether one chain can stand for both: all but the names.
    fn shares_maps_with(&self, other: &Self) -> bool {
        let of = |foldable: &Self| {
            let Inputs { normal, roughness, anisotropy, normal_scale, wrap, .. } = foldable.inputs.clone();
            let turned = foldable.anisotropy.as_ref().map(|a| (a.strength, a.rotation));
            (normal, roughness, anisotropy, normal_scale, wrap, foldable.factor, turned)
        };
        of(self) == of(other)
    }
}

/// Turns the direction of an anisotropy texel, 0..1 standing for -1..1.
pub(crate) fn turn(texel: &mut [f32], radians: f32) {
    let direction = Vec2::from_angle(radians).rotate(2.0 * Vec2::new(texel[0], texel[1]) - 1.0);
    (texel[0], texel[1]) = (0.5 + 0.5 * direction.x, 0.5 + 0.5 * direction.y);
}

/// Changes every texel, in floats.
fn edit(decoded: &mut Decoded, change: impl Fn(&mut [f32])) {
    let Raster { samples, channels } = &decoded.raster;
    let read = |channel: usize, y: usize, row: &mut [f32]| decoded.raster.read(channel, y, 0, row);
    let mut values = from_rows(decoded.raster.size(), samples.channels(), read);
    each_texel(&mut values, change);
    decoded.raster = Raster { samples: Samples::F32(values), channels: channels.clone() };
    decoded.plain_png = None;
}

/// Why a material stays as it is, and whether there is nothing to wonder about.
type Left = (String, bool);

/// What a material is folded from. `text` is its JSON, `animated` what animations change.
fn foldable(
    pictures: &mut Pictures,
    index: usize,
    text: &str,
    animated: &[String],
) -> Result<std::result::Result<Foldable, Left>> {
    let Reader { path, document, .. } = *pictures.reader;
    let material = item(path, &document.materials, index, "material")?;
    let left = |reason: String| Ok(Err((reason, false)));
    for extension in ["KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness"] {
        if material.extensions.contains_key(extension) {
            return Ok(Err((format!("{extension}: no metallic roughness"), extension == "KHR_materials_unlit")));
        }
    }
    // A normal map of scale 0 is flat.
    let Some(normal) = material.normal_texture.as_ref().filter(|texture| texture.scale != 0.0) else {
        return Ok(Err(("no normal map: nothing to fold".into(), true)));
    };
    if !(1e-3..=1e3).contains(&normal.scale) {
        return left(format!("a normal map of scale {}; supported: 0.001 to 1000", normal.scale));
    }
    let metallic = &material.pbr_metallic_roughness;
    let factor = metallic.roughness_factor;
    if !(0.0..=1.0).contains(&factor) {
        return left(format!("roughnessFactor {factor}; expected a number from 0 to 1"));
    }
    let anisotropy_text = at(text, &["extensions", "KHR_materials_anisotropy"]);
    let parsed = |text| parse::<Anisotropy>(path, "KHR_materials_anisotropy", text);
    let anisotropy = anisotropy_text.map(parsed).transpose()?;
    let anisotropy = anisotropy.filter(|anisotropy| anisotropy.anisotropy_strength != 0.0);
    if let Some(Anisotropy { anisotropy_strength: strength, anisotropy_rotation: rotation, .. }) = anisotropy
        && !((0.0..=1.0).contains(&strength) && rotation.is_finite())
    {
        return left(format!(
            "anisotropyStrength {strength}, anisotropyRotation {rotation}; expected 0 to 1, and an angle"
        ));
    }
    let uses = [
        ("normal", Some(normal), member(text, "normalTexture")),
        (
            "metallic_roughness",
            metallic.metallic_roughness_texture.as_ref(),
            at(text, &["pbrMetallicRoughness", "metallicRoughnessTexture"]),
        ),
        (
            "anisotropy",
            anisotropy.as_ref().and_then(|a| a.anisotropy_texture.as_ref()),
            anisotropy_text.and_then(|text| member(text, "anisotropyTexture")),
        ),
    ];
    let mut layouts: Vec<(&str, Layout)> = Vec::new();
    let mut found: Vec<Option<(TextureUse, PathBuf)>> = Vec::new();
    let mut inputs = Inputs { name: material_name(material.name.as_deref(), index), ..Inputs::default() };
    let mut embedded = HashMap::new();
    for (role, info, text) in uses {
        let (Some(info), Some(text)) = (info, text) else {
            found.push(None);
            continue;
        };
        let layout = Layout::of(path, info, text)?;
        let entry = item(path, &document.textures, info.index, "texture")?;
        let image = match entry.image() {
            Ok(image) => image,
            Err(instead) => {
                return left(format!("its {role} texture is {instead}; supported: PNG, JPEG or WebP images"));
            }
        };
        if let Some((first, same)) = layouts.first()
            && *same != layout
        {
            return left(format!(
                "its {first} and {role} textures are laid out differently (texture coordinates or KHR_texture_transform): \
                 their texels cannot be paired"
            ));
        }
        layouts.push((role, layout));
        item(path, &document.images, image, "image")?;
        let (file, bytes) = match pictures.get(info, role) {
            Ok(picture) => picture,
            Err(error) => return left(error.to_string()),
        };
        embedded.extend(bytes.map(|bytes| (file.clone(), bytes)));
        if let Some(sampler) = entry.sampler
            && matches!(item(path, &document.samplers, sampler, "sampler")?.min_filter, Some(9728 | 9729))
        {
            inputs.warnings.push(format!(
                "sampler {sampler} of its {role} texture asks for no mips (minFilter), so the folded ones are not seen"
            ));
        }
        found.push(Some((TextureUse { texture: info.index, image, info: text.to_owned() }, file)));
    }
    for part in [
        "normalTexture",
        "pbrMetallicRoughness/roughnessFactor",
        "pbrMetallicRoughness/metallicRoughnessTexture",
        "extensions/KHR_materials_anisotropy",
    ] {
        let pointer = format!("/materials/{index}/{part}");
        if animated.iter().any(|animated| animated.starts_with(&pointer)) {
            return left(format!("an animation changes its {part}"));
        }
    }
    let mut sides = Vec::new();
    inputs.wrap = wrap(pictures.reader, normal, &mut sides)?;
    inputs.normal_scale = Some(normal.scale);
    let [normal, roughness, turned] = <[_; 3]>::try_from(found).expect("three uses");
    let (normal, file) = normal.expect("there is a normal map");
    inputs.normal = Some(file);
    inputs.roughness = match &roughness {
        Some((_, path)) => RoughnessInput::Roughness(ChannelRef { path: path.clone(), channel: Some(GREEN) }),
        None => RoughnessInput::Constant(PerceptualRoughness(factor)),
    };
    if anisotropy.is_some() {
        inputs.anisotropy = Some(turned.as_ref().map_or(EVEN_ANISOTROPY.into(), |(_, path)| path.clone()));
    }
    if at(text, &["extensions", "KHR_materials_clearcoat", "clearcoatNormalTexture"]).is_some() {
        inputs.notes.push("the normals of its clear coat are not folded".into());
    }
    Ok(Ok(Foldable {
        inputs,
        materials: vec![index],
        normal,
        roughness: roughness.map(|(texture, _)| texture),
        factor,
        anisotropy: anisotropy.map(|a| AnisotropyUse {
            strength: a.anisotropy_strength,
            rotation: a.anisotropy_rotation,
            texture: turned.map(|(texture, _)| texture),
        }),
        wraps_differ: !sides.is_empty(),
        embedded,
    }))
}

/// What animations change, as JSON pointers (`KHR_animation_pointer`).
fn animated(text: &str) -> Vec<String> {
    if !text.contains("KHR_animation_pointer") {
        return Vec::new();
    }
    let animations = member(text, "animations").map_or_else(Vec::new, items);
    let channels = animations.into_iter().flat_map(|text| member(text, "channels").map_or_else(Vec::new, items));
    channels
        .filter_map(|text| at(text, &["target", "extensions", "KHR_animation_pointer", "pointer"]))
        .filter_map(|text| serde_json::from_str(text).ok())
        .collect()
}
