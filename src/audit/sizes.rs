//! Sizes of the maps.

use super::{Check, Finding, Severity, Subject};
use crate::image::Size;

/// Maps against each other.
pub const SET: Check = Check { name: "set-sizes", about: "maps of one material that differ in size", run: set };

/// Sides that formats and engines dislike.
pub const CHECK: Check =
    Check { name: "size", about: "sides that are no multiple of 4 (BC formats) or no power of two", run };

fn set(subject: &Subject) -> Vec<Finding> {
    // Heights beside a normal map are not folded with it.
    let heights = subject.height.as_ref().filter(|_| subject.inputs.normal.is_none());
    let sizes: Vec<(&str, Size)> =
        subject.pictures.iter().chain(heights).map(|p| (p.file.as_str(), p.raster.size())).collect();
    let Some((first, largest)) = sizes.iter().max_by_key(|(_, size)| size.texels()).copied() else { return vec![] };
    let others = sizes.iter().filter(|(_, size)| *size != largest);
    others
        .map(|&(file, size)| {
            let same_shape = size.width * largest.height == size.height * largest.width;
            let one = size.texels() == 1;
            Finding {
                check: SET.name,
                severity: if same_shape || one { Severity::Note } else { Severity::Warning },
                map: file.to_owned(),
                channel: None,
                evidence: if same_shape || one {
                    format!("{size}, but {first} is {largest}")
                } else {
                    format!("{size}, but {first} is {largest}: another shape, so one of them is stretched or cut")
                },
                confidence: if same_shape || one { 0.3 } else { 0.8 },
                fix: "export both at one size; mipfold enlarges the smaller one bilinearly".into(),
            }
        })
        .collect()
}

fn run(subject: &Subject) -> Vec<Finding> {
    let size = subject.material.size;
    let sides = [size.width, size.height];
    if sides.iter().all(|side| side.is_power_of_two()) {
        return vec![];
    }
    let Some(picture) = subject.pictures.iter().chain(&subject.height).find(|p| p.raster.size() == size) else {
        return vec![];
    };
    let blocks = sides.iter().all(|side| side % 4 == 0);
    let (evidence, fix) = if blocks {
        (
            format!("{size}: not powers of two; mip levels round down, so their texels do not line up in fours"),
            "nothing, if the engine takes any size: mipfold weights its footprints exactly. Else resize to powers of two",
        )
    } else {
        (
            format!("{size}: not multiples of 4, which block-compressed (BC) formats need of level 0"),
            "resize to multiples of 4, best to powers of two, before block compression",
        )
    };
    vec![Finding {
        check: CHECK.name,
        severity: Severity::Note,
        map: picture.file.clone(),
        channel: None,
        evidence,
        confidence: if blocks { 0.3 } else { 0.6 },
        fix: fix.into(),
    }]
}
