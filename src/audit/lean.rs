//! Normals that lean in the mean.

use super::{Check, Finding, Severity, Subject};

/// Mean direction.
pub const CHECK: Check = Check { name: "lean", about: "normals that lean to one side in the mean", run };

/// Mean x or y that is worth a word. A surface that tiles has the mean slope 0, and a flat texel stored as 127 or 128 leans
/// by 1/255; of the real maps a woven cloth (fabric_pattern) leans most, by 0.035.
const NOTE: f64 = 0.05;

/// The texture looks like a tilted plane: 8.6 degrees.
const WARNING: f64 = 0.15;

fn run(subject: &Subject) -> Vec<Finding> {
    let Some(normals) = subject.normals() else { return vec![] };
    let found = &subject.found;
    let [x, y] = found.mean_xy;
    let lean = x.hypot(y);
    if lean < NOTE || found.looks_srgb() {
        return vec![];
    }
    vec![Finding {
        check: CHECK.name,
        severity: if lean < WARNING { Severity::Note } else { Severity::Warning },
        map: normals.picture.file.clone(),
        channel: Some("red green"),
        evidence: format!(
            "mean x {x:+.3}, y {y:+.3}: the surface is tilted by {:.1} degrees; one that tiles is level",
            lean.min(1.0).asin().to_degrees()
        ),
        confidence: (0.4 + lean).min(0.9),
        fix: "level the height map or the bake, or check what flat is stored as: it should be 128,128,255".into(),
    }]
}
