//! Models: glTF in, glTF out, with folded textures in it.
//!
//! What is not folded stays as it is written: the JSON is edited as text, buffers keep their bytes. Taken out are images
//! that nothing uses any more, and their bytes, with the offsets of what follows mended (but with fallbacks none); extensions that are then no
//! longer used, from their lists, and lists that this empties; and, with a warning, bytes after the end that a .glb tells
//! and the unknown chunks of one that becomes a .gltf. Buffer views, textures, images and materials keep their numbers, so
//! that what unknown extensions say of them holds: other forms of a texture that changes (a PNG beside WebP) show its new
//! image, unless that is a data URI, and then they stay. What an unknown extension may refer to is not taken out.

mod assign;
mod digests;
mod extensions;
mod package;
mod proofs;
mod textures;
mod views;
mod write;

use std::collections::BTreeMap;

pub use digests::{ImageDigest, digests};
pub use proofs::Proof;
pub use textures::{Folded, FoldedMaterial, Left, Slot, check_early, fold_material};
pub use write::{ModelFiles, sidecar_name};

use serde_json::Value;

use assign::{Assignment, NewImage, assign, path};
use extensions::extensions;
use package::{Package, Place, Whole, data_uri, image_bytes, relative};

use crate::codec::texture::Effort;
use crate::error::{Error, Result};
use crate::fold::Options;
use crate::gltf::text::{Edits, at, items, member, quoted, with};
use crate::image::Sides;
use crate::material::{Foldable, Model};
use crate::ndf::Form;
use crate::output::preset::Compress;

const BASISU: &str = "KHR_texture_basisu";
const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// Other forms of a texture, which would still show the old image.
const OTHER_FORMS: [&str; 3] = ["EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds"];

/// How a model is folded and written.
#[derive(Clone, Copy)]
pub struct ModelOptions {
    /// How footprints are folded; the form is that of `form`.
    pub fold: Options,
    /// One width or two; without, two for materials with anisotropy.
    pub form: Option<Form>,
    /// UASTC is what glTF allows (`KHR_texture_basisu`); of others only Bevy is known to read them.
    pub compress: Compress,
    /// How much time that may take.
    pub effort: Effort,
    /// What the sides of textures are brought to.
    pub sides: Sides,
    /// A material stays as it is where folding changes the roughness by less than this.
    pub skip_if_below: Option<f32>,
    /// Whether old images stay, for readers without KTX 2.
    pub fallback: bool,
}

/// A group of materials with what was folded of it.
pub struct Group<'a> {
    /// The materials.
    pub foldable: &'a Foldable,
    /// Their textures.
    pub folded: &'a FoldedMaterial,
}

/// What is known of a new image.
#[derive(Clone, Debug)]
pub struct ImageAbout {
    /// Index of the group.
    pub group: usize,
    /// What it is for.
    pub slot: Slot,
    /// The image that it stems from.
    pub from: usize,
    /// Its number in the new file.
    pub image: usize,
    /// The number of the picture that readers without KTX 2 show, if that is new.
    pub picture: Option<usize>,
    /// Whether it took the place of that.
    pub replaces: bool,
    /// Where it is a file of its own.
    pub file: Option<String>,
}

/// A model that was changed.
pub struct Rewritten {
    /// What is to be written.
    pub files: ModelFiles,
    /// The new images.
    pub images: Vec<ImageAbout>,
    /// Old images that show a new one, for nothing else would use them: the numbers of both.
    pub gone: BTreeMap<usize, usize>,
    /// What could not be kept.
    pub warnings: Vec<String>,
}

/// Makes the new file; `stem` is its name without ending, and new files beside it begin with that. Without textures (in a
/// dry run, or before the work) contents are missing, and names are right, but that fallbacks are among them that may not
/// be needed.
///
/// # Errors
/// Buffers that cannot be read or contradict themselves, files outside the model's folder. Images that cannot be read stay
/// as they are, with a warning.
pub fn rewrite(
    model: &Model,
    groups: &[Group],
    options: &ModelOptions,
    to_binary: bool,
    stem: &str,
) -> Result<Rewritten> {
    let mut package = Package::new(model, to_binary)?;
    let text = package.text;
    let given: Vec<(&Foldable, &[Slot])> =
        groups.iter().map(|group| (group.foldable, &group.folded.slots[..])).collect();
    let mut plan = assign(text, &given, options.fallback);
    let list = |key: &str| member(text, key).map_or_else(Vec::new, items);
    let (images, textures, materials) = (list("images"), list("textures"), list("materials"));
    let mut edits = Edits::new(text);

    plan.gone.retain(|old, new| match package.place(plan.images[*new].from) {
        Place::View(_) => true,
        Place::File => package.document.images[*old].buffer_view.is_none(),
        // The data would be there twice.
        Place::Inline => false,
    });
    let taken = plan.images.iter().filter(|new| new.takes).map(|new| new.from);
    package.drop_images(&taken.chain(plan.gone.keys().copied()).collect());
    let mut about: Vec<ImageAbout> = Vec::new();
    let mut new_images = Vec::new();
    for (index, new) in plan.images.iter().enumerate() {
        let group = &groups[new.group];
        let folded = group.folded.textures.iter().find(|folded| folded.slot == new.slot);
        let bytes = folded.map_or_else(Vec::new, |folded| folded.bytes.clone());
        let old = &package.document.images[new.from];
        let (name, place) = (image_name(old.name.as_deref(), new, group), package.place(new.from));
        let gone: Vec<usize> = plan.gone.iter().filter(|(_, new)| **new == index).map(|(old, _)| *old).collect();
        let own = [new.from].into_iter().filter(|_| new.takes).chain(gone.iter().copied());
        let views: Vec<usize> = own.filter_map(|image| package.document.images[image].buffer_view).collect();
        let base = format!("{stem}_{}", plain(&name));
        let (changes, file) = put(&mut package, place, bytes, "ktx2", &base, &views);
        gone.iter().for_each(|old| edits.replace(images[*old], with(images[*old], &changes)));
        let image = if new.takes {
            edits.replace(images[new.from], with(images[new.from], &changes));
            new.from
        } else {
            new_images.push(named(&name, &changes));
            images.len() + new_images.len() - 1
        };
        let picture = group.folded.pictures.contains(&new.slot).then(|| {
            let bytes = folded.and_then(|folded| folded.picture.clone()).unwrap_or_default();
            let (changes, _) = put(&mut package, place, bytes, "png", &base, &[]);
            new_images.push(named(&format!("{name}_fallback"), &changes));
            images.len() + new_images.len() - 1
        });
        let NewImage { group, slot, from, takes, .. } = *new;
        about.push(ImageAbout { group, slot, from, image, picture, replaces: takes, file });
    }
    let gone: BTreeMap<usize, usize> = plan.gone.iter().map(|(old, new)| (*old, about[*new].image)).collect();
    let stays = |i: &usize| !gone.contains_key(i) && !about.iter().any(|about| about.replaces && about.image == *i);
    for i in (0..images.len()).filter(stays) {
        if let Err(error) = carry(&mut package, &mut edits, images[i], i) {
            package.warnings.push(format!("image {i} stays as it is written: {error}"));
        }
    }

    let pointed = |texture: &str, image: usize| texture_with(texture, &about[image], options);
    for (number, image) in &plan.replaced {
        edits.replace(textures[*number], pointed(textures[*number], *image));
    }
    let added: Vec<String> = plan.added.iter().map(|new| pointed(textures[new.like], new.image)).collect();
    for (array, new) in [("images", &new_images), ("textures", &added)] {
        if let Some(array) = member(text, array) {
            edits.append(array, new);
        }
    }
    for (number, (group, _)) in &plan.materials {
        let (old, new) = (materials[*number], material_with(materials[*number], *number, &groups[*group], &plan));
        // Not even its blanks, where only what it refers to has changed.
        let parsed = |text: &str| serde_json::from_str::<Value>(text).ok();
        if parsed(old).is_none_or(|old| Some(old) != parsed(&new)) {
            edits.replace(old, new);
        }
    }
    extensions(text, &mut edits, &plan, groups, options);
    if options.compress != Compress::Uastc && !groups.is_empty() {
        let warning = "textures that are not UASTC are no part of glTF: Bevy reads them, other loaders and validators do not \
                       know image/ktx2";
        package.warnings.push(warning.into());
    }
    let inputs = package.inputs()?;
    let Whole { main, beside, warnings } = package.finish(edits, stem)?;
    Ok(Rewritten { files: ModelFiles { main, beside, inputs }, images: about, gone, warnings })
}

/// Puts the bytes of a new image in its place: the members that say so, and the name of its file if it is one. `ending` is
/// `ktx2` or `png`, `base` begins the names of files, and `views` are those that it may take.
fn put(
    package: &mut Package,
    place: Place,
    bytes: Vec<u8>,
    ending: &str,
    base: &str,
    views: &[usize],
) -> (Vec<(&'static str, Option<String>)>, Option<String>) {
    let mime_type = format!("image/{ending}");
    let mut file = None;
    let [first, second] = match place {
        Place::View(buffer) => {
            let view = package.add(buffer, bytes, views);
            [("uri", None), ("bufferView", Some(view.to_string()))]
        }
        Place::Inline => [("bufferView", None), ("uri", Some(quoted(&data_uri(&mime_type, &bytes))))],
        Place::File => {
            let name = package.free_name(base, ending, |_| true);
            package.files.push((name.clone(), package::Beside::Bytes(bytes)));
            file = Some(name.clone());
            [("bufferView", None), ("uri", Some(quoted(&name)))]
        }
    };
    (vec![first, second, ("mimeType", Some(quoted(&mime_type)))], file)
}

/// A new image.
fn named(name: &str, members: &[(&str, Option<String>)]) -> String {
    with(&format!("{{\"name\":{}}}", quoted(name)), members)
}

/// Takes an image along that stays what it is: into the .glb that is made of a .gltf, or as a file.
fn carry<'a>(package: &mut Package<'a>, edits: &mut Edits<'a>, text: &'a str, image: usize) -> Result<()> {
    let Some(uri) = package.document.images[image].uri.clone() else { return Ok(()) };
    if package.to_binary && !package.from_binary {
        let bytes = image_bytes(package, &package.buffers(), image)?.into_owned();
        let mime_type = package.document.images[image].mime_type.clone().or(mime_type(&bytes).map(str::to_owned));
        let view = package.add(0, bytes, &[]);
        let mut changes = vec![("uri", None), ("bufferView", Some(view.to_string()))];
        changes.extend(mime_type.map(|mime_type| ("mimeType", Some(quoted(&mime_type)))));
        edits.replace(text, with(text, &changes));
    } else if !uri.starts_with("data:") {
        let file = crate::gltf::beside(package.path, &uri, &format!("image {image}"))?;
        std::fs::File::open(&file).map_err(|error| Error::io(&file, error))?;
        package.files.push((relative(package.path, &file), package::Beside::Copy(file)));
    }
    Ok(())
}

/// A name for an image.
fn image_name(old: Option<&str>, new: &NewImage, group: &Group) -> String {
    match old.filter(|name| !name.is_empty() && new.takes) {
        Some(name) => name.to_owned(),
        None => format!("{}_{}", group.foldable.inputs.name, new.slot.name()),
    }
}

/// Letters that a URI and every file system take.
fn plain(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' };
    name.chars().map(plain).take(80).collect()
}

fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, ..] => Some("image/jpeg"),
        [0xab, b'K', b'T', b'X', ..] => Some("image/ktx2"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

/// A texture that shows a new image.
fn texture_with(texture: &str, about: &ImageAbout, options: &ModelOptions) -> String {
    let (image, old) = (about.image, member(texture, "extensions").unwrap_or("{}"));
    let mut changes: Vec<(&str, Option<String>)> = Vec::new();
    if !options.fallback || about.picture.is_some() {
        changes.extend(OTHER_FORMS.map(|form| (form, None)));
        changes.push((BASISU, None));
    }
    let basisu = options.compress == Compress::Uastc;
    if basisu {
        changes.push((BASISU, Some(format!("{{\"source\":{image}}}"))));
    }
    let extensions = with(old, &changes);
    let extensions = Some(extensions).filter(|text| text != "{}");
    let source = match (basisu, options.fallback, about.picture) {
        (true, true, None) => return with(texture, &[("extensions", extensions)]),
        (true, _, picture) => picture,
        (false, ..) => Some(image),
    };
    with(texture, &[("source", source.map(|image| image.to_string())), ("extensions", extensions)])
}

/// A material that uses its new textures.
fn material_with(material: &str, number: usize, group: &Group, plan: &Assignment) -> String {
    let (_, uses) = &plan.materials[&number];
    let index = |texture: usize| [("index", Some(texture.to_string()))];
    // Laid out as the normals are.
    let like_normal = |texture: usize| {
        let normal = member(material, "normalTexture").unwrap_or("{}");
        let info = with(normal, &[("scale", None), ("extras", None)]);
        with(&info, &index(texture))
    };
    let mut changes: Vec<(&str, Option<String>)> = Vec::new();
    for (slot, texture) in &uses.textures {
        let old = at(material, path(*slot));
        // One that was not there is made for the layout of the normals, whatever the material says of it.
        let made = match slot {
            Slot::Normal => false,
            Slot::Roughness => group.foldable.roughness.is_none(),
            Slot::Anisotropy => group.foldable.anisotropy.as_ref().is_none_or(|a| a.texture.is_none()),
        };
        let old = old.filter(|_| !made);
        let info = old.map_or_else(|| like_normal(*texture), |info| with(info, &index(*texture)));
        match slot {
            Slot::Normal => changes.push(("normalTexture", Some(info))),
            Slot::Roughness => {
                let metallic = member(material, "pbrMetallicRoughness").unwrap_or("{}");
                let mut inner = vec![("metallicRoughnessTexture", Some(info))];
                if !group.folded.keeps_factor && member(metallic, "roughnessFactor").is_some() {
                    inner.push(("roughnessFactor", Some("1".into())));
                }
                changes.push(("pbrMetallicRoughness", Some(with(metallic, &inner))));
            }
            Slot::Anisotropy => {
                let extensions = member(material, "extensions").unwrap_or("{}");
                let own = member(extensions, ANISOTROPY).unwrap_or("{}");
                let mut inner = vec![("anisotropyTexture", Some(info))];
                if !group.folded.keeps_strength {
                    inner.push(("anisotropyStrength", Some("1".into())));
                }
                if group.foldable.anisotropy.is_none() {
                    inner.push(("anisotropyRotation", None));
                }
                let new = with(extensions, &[(ANISOTROPY, Some(with(own, &inner)))]);
                changes.push(("extensions", Some(new)));
            }
        }
    }
    if let (Some(texture), Some(info)) = (uses.occlusion, member(material, "occlusionTexture")) {
        changes.push(("occlusionTexture", Some(with(info, &index(texture)))));
    }
    with(material, &changes)
}
