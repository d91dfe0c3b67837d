//! Which images, textures and materials of a model become what: nothing is written here.

use std::collections::{BTreeMap, BTreeSet};

use super::textures::Slot;
use crate::gltf::text::{at, items, member, members, numbers, whole};
use crate::material::Foldable;

/// Extensions whose indices are known: those of textures and images are looked up where they are, or there are none.
const KNOWN: [&str; 28] = [
    "KHR_texture_transform",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "KHR_animation_pointer",
    "KHR_xmp_json_ld",
    "KHR_node_visibility",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

/// Whether what an extension refers to is known.
pub fn is_known(extension: &str) -> bool {
    KNOWN.contains(&extension)
}

/// An image that is to be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewImage {
    /// Index of the folded material.
    pub group: usize,
    pub slot: Slot,
    /// The image that it stems from; that of the normals where there was none.
    pub from: usize,
    /// Whether it takes the place of that, which nothing else uses.
    pub takes: bool,
}

/// A texture that is to be made: another one with another image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NewTexture {
    pub like: usize,
    /// Index of the new image.
    pub image: usize,
}

/// What a material refers to afterwards.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewUses {
    /// Its textures, by their numbers in the new file.
    pub textures: BTreeMap<Slot, usize>,
    /// That of its occlusion, if it is one of ours.
    pub occlusion: Option<usize>,
}

/// All that changes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Assignment {
    pub images: Vec<NewImage>,
    /// Textures that get another image in their place, by number: index of the new image.
    pub replaced: BTreeMap<usize, usize>,
    /// Other images that only textures showed which now show another: index of that new image.
    pub gone: BTreeMap<usize, usize>,
    /// Textures that are added.
    pub added: Vec<NewTexture>,
    /// By material and index of the folded material.
    pub materials: BTreeMap<usize, (usize, NewUses)>,
}

/// A place of a material that names a texture.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Of(Slot),
    Occlusion,
}

/// The images that a texture names, in every known form.
pub fn images_of(texture: &str) -> Vec<usize> {
    let extensions = member(texture, "extensions").map_or_else(Vec::new, members);
    let known = extensions.into_iter().filter(|(name, _)| is_known(name));
    let others = known.filter_map(|(_, text)| member(text, "source"));
    member(texture, "source").into_iter().chain(others).filter_map(whole).collect()
}

/// Decides, for folded materials and the slots that each has. `text` is the file's JSON; with `keep`, old images stay as
/// what readers without KTX 2 show.
pub fn assign(text: &str, groups: &[(&Foldable, &[Slot])], keep: bool) -> Assignment {
    let list = |key: &str| member(text, key).map_or_else(Vec::new, items);
    let (materials, textures) = (list("materials"), list("textures"));
    let images: Vec<Vec<usize>> = textures.iter().map(|texture| images_of(texture)).collect();
    let strange: BTreeSet<usize> =
        numbers(text, is_known).into_iter().filter(|number| number.strange).map(|number| number.value).collect();

    let mut out = Assignment::default();
    // What the places of folded materials show afterwards.
    let mut shown: BTreeMap<(usize, Place), (usize, usize)> = BTreeMap::new();
    for (group, (foldable, slots)) in groups.iter().enumerate() {
        let turned = foldable.anisotropy.as_ref().and_then(|a| a.texture.as_ref());
        for slot in slots.iter().copied() {
            let own = match slot {
                Slot::Normal => Some(&foldable.normal),
                Slot::Roughness => foldable.roughness.as_ref(),
                Slot::Anisotropy => turned,
            };
            let like = own.unwrap_or(&foldable.normal);
            let image = out.images.len();
            out.images.push(NewImage { group, slot, from: like.image, takes: false });
            for material in foldable.materials.iter().copied() {
                let old = texture_at(materials[material], slot).filter(|_| own.is_some()).unwrap_or(like.texture);
                shown.insert((material, Place::Of(slot)), (old, image));
                let occlusion = index(member(materials[material], "occlusionTexture"));
                if let (Slot::Roughness, Some(own), Some(occlusion)) = (slot, own, occlusion)
                    && images.get(occlusion).is_some_and(|images| images.contains(&own.image))
                {
                    shown.insert((material, Place::Occlusion), (occlusion, image));
                }
            }
        }
        foldable.materials.iter().for_each(|material| out.materials.entry(*material).or_default().0 = group);
    }

    // A texture changes in its place if all who use it want another; where they differ, the first is served there.
    let mut wanted: BTreeMap<usize, BTreeSet<Option<usize>>> = BTreeMap::new();
    for (index, material) in materials.iter().enumerate() {
        for (place, texture) in uses(material) {
            let new = place.and_then(|place| shown.get(&(index, place))).map(|(_, image)| *image);
            wanted.entry(texture).or_default().insert(new);
        }
    }
    for (texture, wanted) in &wanted {
        if let (Some(Some(image)), false) = (wanted.first().copied(), strange.contains(texture)) {
            out.replaced.insert(*texture, image);
        }
    }
    for ((material, place), (old, image)) in &shown {
        let existed = match place {
            Place::Of(slot) => texture_at(materials[*material], *slot) == Some(*old),
            Place::Occlusion => true,
        };
        let number = if existed && out.replaced.get(old) == Some(image) {
            *old
        } else {
            let new = NewTexture { like: *old, image: *image };
            let at = out.added.iter().position(|added| *added == new).unwrap_or_else(|| {
                out.added.push(new);
                out.added.len() - 1
            });
            textures.len() + at
        };
        let uses = &mut out.materials.entry(*material).or_default().1;
        match place {
            Place::Of(slot) => drop(uses.textures.insert(*slot, number)),
            Place::Occlusion => uses.occlusion = Some(number),
        }
    }
    if !keep {
        // An image goes if no texture that stays shows it.
        let replaced = &out.replaced;
        let stays = |image: usize| {
            let shows = |(i, images): (usize, &Vec<usize>)| !replaced.contains_key(&i) && images.contains(&image);
            strange.contains(&image) || images.iter().enumerate().any(shows)
        };
        let mut taken = BTreeSet::new();
        let free: Vec<bool> = out.images.iter().map(|new| !stays(new.from)).collect();
        for (new, free) in out.images.iter_mut().zip(free) {
            let stems = match new.slot {
                Slot::Normal => true,
                Slot::Roughness => groups[new.group].0.roughness.is_some(),
                Slot::Anisotropy => groups[new.group].0.anisotropy.as_ref().is_some_and(|a| a.texture.is_some()),
            };
            new.takes = free && stems && taken.insert(new.from);
        }
        let shown = replaced.iter().flat_map(|(texture, new)| images[*texture].iter().map(|image| (*image, *new)));
        out.gone = shown.filter(|(image, _)| !stays(*image) && !taken.contains(image)).collect();
    }
    out
}

fn index(info: Option<&str>) -> Option<usize> {
    whole(member(info?, "index")?)
}

/// The texture of a slot of a material.
fn texture_at(material: &str, slot: Slot) -> Option<usize> {
    index(at(material, path(slot)))
}

/// Where a slot is in a material.
pub fn path(slot: Slot) -> &'static [&'static str] {
    match slot {
        Slot::Normal => &["normalTexture"],
        Slot::Roughness => &["pbrMetallicRoughness", "metallicRoughnessTexture"],
        Slot::Anisotropy => &["extensions", "KHR_materials_anisotropy", "anisotropyTexture"],
    }
}

/// Every texture that a material uses, and where if it is a place that may change.
fn uses(material: &str) -> Vec<(Option<Place>, usize)> {
    let mut out = Vec::new();
    let mut add = |owner: &[&str], text: &str| {
        for (key, info) in members(text) {
            let Some(texture) = index(Some(info)) else { continue };
            let full: Vec<&str> = owner.iter().copied().chain([key.as_str()]).collect();
            let slots = [Slot::Normal, Slot::Roughness, Slot::Anisotropy];
            let slot = slots.into_iter().find(|slot| path(*slot) == full).map(Place::Of);
            out.push((slot.or((full == ["occlusionTexture"]).then_some(Place::Occlusion)), texture));
        }
    };
    add(&[], material);
    if let Some(pbr) = member(material, "pbrMetallicRoughness") {
        add(&["pbrMetallicRoughness"], pbr);
    }
    for (name, text) in member(material, "extensions").map_or_else(Vec::new, members) {
        add(&["extensions", &name], text);
    }
    out
}
