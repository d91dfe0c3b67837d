//! The text beside the maps.

use super::{Fact, Preset, Slot, Written, WrittenMap};
use crate::image::Wrap;
use crate::material::NormalY;
use crate::output::Format;

/// Columns of a line.
const COLUMNS: usize = 80;

pub fn readme(preset: &Preset, written: &Written) -> String {
    let mut lines = fill(&format!("{}, for {}", written.material, preset.engine), "", "");
    lines.extend(fill("Mip levels by mipfold: bumps that a level lost are roughness in it.", "", ""));
    lines.extend(["".into(), "Files".into()]);
    for map in written.maps {
        let Some(file) = map.files.first() else { continue };
        let last = map.files.last().filter(|last| *last != file);
        let name = last.map_or(file.clone(), |last| format!("{file} to {last}"));
        lines.extend(fill(&format!("{name}: {}", content(preset, map)), "  ", "    "));
    }
    let asides: Vec<String> = (preset.aside)(written).into_iter().map(|aside| aside.name).collect();
    if !asides.is_empty() {
        lines.extend(fill(&format!("{}: see below", asides.join(", ")), "  ", "    "));
    }
    lines.extend(["".into(), "Load them".into()]);
    let files = |of: &dyn Fn(&WrittenMap) -> bool| written.maps.iter().find(|map| of(map)).and_then(Files::of);
    let steps = steps(preset.load, files(&is_normal).as_ref(), files(&is_packed).as_ref(), written.wrap);
    lines.extend(steps.lines().map(String::from));
    lines.extend(["".into(), format!("Mind (`mipfold presets {}` tells the sources)", preset.name)]);
    lines.extend(preset.facts.iter().flat_map(|fact| fill(&said(fact), "  - ", "    ")));
    lines.join("\n") + "\n"
}

/// A fact, and whether it was checked.
pub fn said(fact: &Fact) -> String {
    format!("{}{}", fact.text, if fact.checked { "" } else { " (Not verified.)" })
}

/// What steps call a map.
pub struct Files {
    /// Its file, or that of level 0.
    pub first: String,
    /// The file of a level, `%d` standing for its number.
    pub level: String,
    /// Number of the last level.
    pub last: String,
}

impl Files {
    fn of(map: &WrittenMap) -> Option<Self> {
        let first = map.files.first()?.clone();
        Some(Self { level: first.replace("_mip0.", "_mip%d."), first, last: map.levels.saturating_sub(1).to_string() })
    }
}

/// Numbered steps, code below them; without the lines that name a file that is not there.
pub fn steps(load: &str, normal: Option<&Files>, packed: Option<&Files>, wrap: Wrap) -> String {
    let mut lines = Vec::new();
    let mut number = 0;
    'lines: for line in load.lines() {
        let mut line = line.replace("{wrap}", wrap.oiio());
        for (word, files) in [("normal", normal), ("packed", packed)] {
            if !line.contains(&format!("{{{word}")) {
                continue;
            }
            let Some(Files { first, level, last }) = files else { continue 'lines };
            for (ending, value) in [("", first), (".level", level), (".last", last)] {
                line = line.replace(&format!("{{{word}{ending}}}"), value);
            }
        }
        if line.starts_with(' ') {
            lines.push(format!("    {line}"));
        } else {
            number += 1;
            lines.extend(fill(&line, &format!("  {number}. "), "     "));
        }
    }
    lines.join("\n")
}

fn is_normal(map: &WrittenMap) -> bool {
    map.role.starts_with("normal")
}

fn is_packed(map: &WrittenMap) -> bool {
    matches!(map.role, "packed" | "roughness" | "smoothness")
}

/// What a map holds, its size and its levels.
fn content(preset: &Preset, map: &WrittenMap) -> String {
    let green = if preset.normal_y == NormalY::OpenGl { "green up (OpenGL)" } else { "green down (DirectX)" };
    let words = match map.role {
        "normal" => {
            let range = if preset.format == Format::Exr { ", from -1 to 1" } else { "" };
            format!("normals, {green}{range}")
        }
        "normal-roughness" => format!("normals, {green}, with the roughness in the channels left over"),
        "anisotropy" => "anisotropy as glTF has it: direction in red and green, strength in blue".into(),
        "packed" | "roughness" | "smoothness" => match preset.packed {
            Some(slots) => packing(slots, preset.without_metal),
            None => format!("{} and what was packed with it", map.role),
        },
        other => format!("{other}, as manifest.json describes"),
    };
    format!("{words}; linear, {}x{}, {} levels", map.width, map.height, map.levels)
}

/// "red occlusion, green roughness, ...".
fn packing(slots: &[Slot], without_metal: f32) -> String {
    let word = |slot: &Slot| match slot {
        Slot::Occlusion => "occlusion (1 if none came)".into(),
        Slot::Roughness => "roughness".into(),
        Slot::Smoothness => "smoothness".into(),
        Slot::Metal => format!("metal ({without_metal} if none came)"),
        Slot::Zero => "0".into(),
        Slot::One => "1".into(),
    };
    let named = ["red", "green", "blue", "alpha"].into_iter().zip(slots);
    let words: Vec<String> = named.map(|(channel, slot)| format!("{channel} {}", word(slot))).collect();
    words.join(", ")
}

/// Lines of up to 80 columns; a longer word has one of its own.
pub fn fill(text: &str, first: &str, rest: &str) -> Vec<String> {
    let mut lines = vec![first.to_owned()];
    let mut empty = true;
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("never empty");
        if empty {
            *last += word;
        } else if last.chars().count() + 1 + word.chars().count() <= COLUMNS {
            *last += " ";
            *last += word;
        } else {
            lines.push(format!("{rest}{word}"));
        }
        empty = false;
    }
    lines
}
