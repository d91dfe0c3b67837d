//! Normals that are not of unit length, and those that do not point out of the surface.

use super::subject::bands;
use super::{Check, Finding, Severity, Subject, percent};

/// Lengths.
pub const CHECK: Check = Check { name: "unit-length", about: "stored normals that are not of unit length", run };

/// Directions.
pub const BEHIND: Check = Check { name: "behind", about: "normals with z <= 0, or without a direction", run: behind };

/// Rounding to 8 bits moves each component by up to 1/255, and so the length by up to sqrt(3)/255; this is the double.
const OFF: f64 = 0.014;

/// Mean |length - 1| from which a map is worth a word: bark, rock and other JPEG maps have 0.01 to 0.05.
const NOTE: f64 = 0.01;

/// And from which diffuse light, which is linear in the normal, is visibly off where a shader does not normalise: by 8 %.
const WARNING: f64 = 0.08;

fn run(subject: &Subject) -> Vec<Finding> {
    let Some(normals) = subject.normals().filter(|normals| normals.stored_z) else { return vec![] };
    // Their own finding says it better.
    if subject.found.looks_srgb() {
        return vec![];
    }
    let size = normals.size();
    let parts = bands(size.height, |rows| {
        let (mut sums, mut row) = ([0.0f64; 4], vec![vec![0.0f32; size.width]; 3]);
        for y in rows {
            let [nx, ny, nz] = &mut row[..] else { unreachable!("three rows") };
            normals.row(y, [nx, ny, nz]);
            for ((x, y), z) in nx.iter().zip(&*ny).zip(&*nz) {
                let length = f64::from((x * x + y * y + z * z).sqrt());
                if length.is_finite() {
                    let off = (length - 1.0).abs();
                    let far = f64::from(u8::from(off > OFF));
                    sums = [sums[0] + 1.0, sums[1] + length, sums[2] + off, sums[3] + far];
                }
            }
        }
        sums
    });
    let sums = parts.iter().fold([0.0; 4], |all: [f64; 4], part| std::array::from_fn(|i| all[i] + part[i]));
    let [mean, off, far] = [1, 2, 3].map(|i| sums[i] / sums[0].max(1.0));
    if off < NOTE {
        return vec![];
    }
    // Filtering and occlusion shorten; only encoding and compression lengthen as well.
    let shortened = (1.0 - mean) > 0.8 * off;
    let why = if shortened {
        "; nearly all are short, as after filtering without normalising, or where the length holds occlusion"
    } else {
        ""
    };
    vec![Finding {
        check: CHECK.name,
        severity: if off < WARNING { Severity::Note } else { Severity::Warning },
        map: normals.picture.file.clone(),
        channel: None,
        evidence: format!(
            "mean length {mean:.3}, mean error {off:.3}; {} are off by more than {OFF} (8-bit rounding gives at most half \
             of it){why}",
            percent(far)
        ),
        confidence: if off < WARNING { 0.7 } else { 0.9 },
        fix:
            "normalise the map after the last filter; mipfold does so for the fold, a shader that samples level 0 must \
              do it itself"
                .into(),
    }]
}

/// Share of unusable normals that is an error: a tenth of the surface has no shape.
const MANY: f64 = 0.1;

/// Share below which they are stray texels: copper_tiles has 0.02 % at the rims of its holes.
const STRAY: f64 = 1e-3;

fn behind(subject: &Subject) -> Vec<Finding> {
    let Some(normals) = subject.normals() else { return vec![] };
    let found = &subject.found;
    let share = |count: usize| count as f64 / found.texels as f64;
    let mut findings = Vec::new();
    for (count, what) in [
        (found.behind, "have z <= 0: they point along the surface or into it"),
        (found.directionless, "have no direction: zero, nearly zero or not a number"),
    ] {
        if count > 0 {
            findings.push(Finding {
                check: BEHIND.name,
                severity: match share(count) {
                    share if share > MANY => Severity::Error,
                    share if share > STRAY => Severity::Warning,
                    _ => Severity::Note,
                },
                map: normals.picture.file.clone(),
                channel: Some("blue"),
                evidence: format!("{count} of {} normals ({}) {what}", found.texels, percent(share(count))),
                confidence: 1.0,
                fix: "bake the map again, or check that it is a tangent-space map and that blue is z; the fold leaves \
                      these texels out"
                    .into(),
            });
        }
    }
    findings
}
