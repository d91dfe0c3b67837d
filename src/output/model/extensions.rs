//! The lists of extensions that a model uses and requires.

use std::collections::BTreeSet;

use super::assign::{Assignment, NewImage};
use super::{ANISOTROPY, BASISU, Group, ModelOptions, OTHER_FORMS, Slot};
use crate::gltf::text::{Edits, items, member, members, quoted};
use crate::output::preset::Compress;

/// Names the extensions that are used now.
pub fn extensions(text: &str, edits: &mut Edits, plan: &Assignment, groups: &[Group], options: &ModelOptions) {
    let strings = |key: &str| -> Vec<String> {
        let items = member(text, key).map_or_else(Vec::new, items);
        items.into_iter().filter_map(|text| serde_json::from_str(text).ok()).collect()
    };
    let (old_used, old_required) = (strings("extensionsUsed"), strings("extensionsRequired"));
    let (mut used, mut required) = (old_used.clone(), old_required.clone());
    if !plan.images.is_empty() {
        // Textures that still have another form, those with their old image as a fallback among them.
        let textures = member(text, "textures").map_or_else(Vec::new, items);
        let keeps = |image: usize| {
            let NewImage { group, slot, .. } = plan.images[image];
            options.fallback && !groups[group].folded.pictures.contains(&slot)
        };
        let kept = textures.iter().enumerate().filter(|(i, _)| plan.replaced.get(i).is_none_or(|image| keeps(*image)));
        let copied = plan.added.iter().filter(|new| keeps(new.image)).map(|new| (new.like, &textures[new.like]));
        let forms = kept.chain(copied).flat_map(|(_, text)| member(text, "extensions").map_or_else(Vec::new, members));
        let forms: BTreeSet<String> = forms.map(|(name, _)| name).collect();
        let gone = |name: &String| (OTHER_FORMS.contains(&name.as_str()) || name == BASISU) && !forms.contains(name);
        used.retain(|name| !gone(name));
        required.retain(|name| !gone(name));
    }
    let add = |list: &mut Vec<String>, name: &str| {
        if !list.iter().any(|other| other == name) {
            list.push(name.to_owned());
        }
    };
    if !plan.images.is_empty() && options.compress == Compress::Uastc {
        add(&mut used, BASISU);
        if !options.fallback {
            add(&mut required, BASISU);
        }
    }
    if groups.iter().any(|group| group.folded.slots.contains(&Slot::Anisotropy)) {
        add(&mut used, ANISOTROPY);
    }
    let (mut at_root, mut empty) = (Vec::new(), Vec::new());
    for (key, old, new) in [("extensionsUsed", old_used, used), ("extensionsRequired", old_required, required)] {
        if old == new {
            continue;
        }
        let array = |new: &[String]| new.iter().map(|name| quoted(name)).collect::<Vec<_>>();
        match member(text, key) {
            // The schema wants one item at least.
            Some(_) if new.is_empty() => empty.push(key),
            Some(place) if new.starts_with(&old) => edits.append(place, &array(&new[old.len()..])),
            Some(place) => edits.replace(place, format!("[{}]", array(&new).join(","))),
            None => at_root.push((key, format!("[{}]", array(&new).join(",")))),
        }
    }
    edits.remove(text, &empty);
    edits.add(text, &at_root);
}
