//! Values that cannot be what they are read as.

use super::{Check, Finding, Severity, Subject, percent};

/// Roughness outside 0..1, and what is not a number.
pub const CHECK: Check = Check { name: "values", about: "roughness outside 0..1, values that are not numbers", run };

/// Share of the texels that makes an error of it.
const MANY: f64 = 0.1;

fn run(subject: &Subject) -> Vec<Finding> {
    let found = &subject.found;
    let width = subject.width();
    let map = |fallback: &str| width.as_ref().map_or(fallback.to_owned(), |width| width.picture.file.clone());
    let cases = [
        (
            found.roughness_outside,
            map(""),
            "roughness values lie outside 0..1",
            "save perceptual roughness as 0..1; the fold clamps these",
        ),
        (
            found.roughness_not_finite,
            map(""),
            "roughness values are not numbers",
            "save the map again; the fold takes these as 1",
        ),
        (
            found.others_not_finite,
            "other channels".to_owned(),
            "texels of other channels are not numbers",
            "save them again; the fold takes these as 0",
        ),
    ];
    let cases = cases.into_iter().filter(|(count, ..)| *count > 0);
    cases
        .map(|(count, map, what, fix)| {
            let share = count as f64 / found.texels as f64;
            Finding {
                check: CHECK.name,
                severity: if share > MANY { Severity::Error } else { Severity::Warning },
                map,
                channel: None,
                evidence: format!("{count} of {} {what} ({})", found.texels, percent(share)),
                confidence: 1.0,
                fix: fix.to_owned(),
            }
        })
        .collect()
}
