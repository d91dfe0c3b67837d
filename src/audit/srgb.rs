//! sRGB where data should be linear.

use super::subject::bands;
use super::{Check, Finding, Normals, Severity, Subject};
use crate::codec::COLOUR_IGNORED;

/// Normals that went through the sRGB curve.
pub const CHECK: Check =
    Check { name: "srgb-normals", about: "normals encoded as sRGB: flat is 188,188,255 and not 128,128,255", run };

/// Files that call themselves colour.
pub const CLAIM: Check =
    Check { name: "says-colour", about: "files that say that their data is colour (sRGB, gamma, ICC)", run: claim };

/// How much nearer to unit length the curve's inverse must bring the normals. Rough maps that lean by chance do not come
/// nearer at all; the one found in the wild (defense_wall) goes from 0.18 to 0.05 off.
const NEARER: f64 = 0.7;

fn run(subject: &Subject) -> Vec<Finding> {
    let Some(normals) = subject.normals() else { return vec![] };
    let found = &subject.found;
    if !found.looks_srgb() || !normals.stored_z {
        return vec![];
    }
    let [stored, linear] = lengths(&normals);
    let certain = linear < NEARER * stored;
    vec![Finding {
        check: CHECK.name,
        severity: if certain { Severity::Error } else { Severity::Warning },
        map: normals.picture.file.clone(),
        channel: None,
        evidence: format!(
            "mean x {:+.2}, y {:+.2} and length {:.2} as stored; undoing the sRGB curve brings the mean error of the \
             length from {stored:.2} to {linear:.2}",
            found.mean_xy[0], found.mean_xy[1], found.mean_length
        ),
        confidence: if certain { 0.98 } else { 0.6 },
        fix: "export the map again as linear (non-colour, raw) data, so that flat is 128,128,255".into(),
    }]
}

/// The curve is slow to undo: one row in so many is enough. Not a power of two, with which patterns would agree.
const SAMPLED: usize = 7;

/// Mean |length - 1| as stored, and with the sRGB curve (IEC 61966-2-1) undone.
fn lengths(normals: &Normals) -> [f64; 2] {
    let size = normals.size();
    let linear = |v: f32| {
        let s = 0.5 + 0.5 * v;
        2.0 * (if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }) - 1.0
    };
    let sums = bands(size.height.div_ceil(SAMPLED), |rows| {
        let (mut sums, mut row) = ([0.0f64; 2], vec![vec![0.0f32; size.width]; 3]);
        for y in rows {
            let [nx, ny, nz] = &mut row[..] else { unreachable!("three rows") };
            normals.row(SAMPLED * y, [nx, ny, nz]);
            for ((x, y), z) in nx.iter().zip(&*ny).zip(&*nz) {
                let off = |v: [f32; 3]| f64::from((v.iter().map(|v| v * v).sum::<f32>().sqrt() - 1.0).abs());
                let stored = [*x, *y, *z];
                sums = [sums[0] + off(stored), sums[1] + off(stored.map(linear))];
            }
        }
        sums
    });
    let n = (size.height.div_ceil(SAMPLED) * size.width) as f64;
    sums.iter().fold([0.0; 2], |all, sum| [all[0] + sum[0] / n, all[1] + sum[1] / n])
}

fn claim(subject: &Subject) -> Vec<Finding> {
    let pictures = subject.pictures.iter().chain(&subject.height);
    let claims = pictures.filter_map(|picture| {
        let evidence = picture.notes.iter().find_map(|note| note.strip_suffix(COLOUR_IGNORED))?.to_owned();
        let fix = "save it without colour information, or import it as linear (non-colour) data";
        Some(Finding {
            check: CLAIM.name,
            severity: Severity::Note,
            map: picture.file.clone(),
            channel: None,
            evidence,
            confidence: 0.5,
            fix: fix.into(),
        })
    });
    claims.collect()
}
