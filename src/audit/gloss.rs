//! Roughness that is gloss, or the other way round.

use super::stats::correlation;
use super::subject::{STEEPEST_Z, bands};
use super::{Check, Finding, Severity, Subject};
use crate::material::{Inputs, Texels, named_smooth};

/// Complements.
pub const CHECK: Check =
    Check { name: "gloss", about: "roughness that looks like gloss, by name and by where the bumps are", run };

/// Side of the blocks whose bumps and mean roughness are compared.
const BLOCK: usize = 8;

/// Correlation below which bumpy places are suspiciously smooth. Of the real maps, which are roughness, none is below -0.25
/// (a knit, nearly constant), and glazed tiles have 0.94, their complement -0.94.
const AGAINST: f64 = -0.4;

fn run(subject: &Subject) -> Vec<Finding> {
    let Some(width) = subject.width() else { return vec![] };
    let (read, other) = if width.smooth { ("gloss", "roughness") } else { ("roughness", "gloss") };
    let flag = if width.smooth { "--roughness" } else { "--gloss" };
    let bumps = against(subject);
    let measured = format!("bumpy places are smoother than flat ones (correlation {bumps:+.2} over blocks of 8 x 8)");
    let named = path(subject.inputs).and_then(named_smooth).is_some_and(|smooth| smooth != width.smooth);
    let finding = |severity, evidence, confidence| {
        vec![Finding {
            check: CHECK.name,
            severity,
            map: width.picture.file.clone(),
            channel: width.channel_name(),
            evidence,
            confidence,
            fix: format!("if it is {other}, give it with {flag}"),
        }]
    };
    match (named, bumps < AGAINST) {
        (true, true) => finding(Severity::Warning, format!("read as {read}, named as {other}; {measured}"), 0.95),
        (true, false) => finding(Severity::Warning, format!("read as {read}, named as {other}"), 0.8),
        // Polished edges and worn bumps do that too.
        (false, true) => finding(Severity::Note, measured, (0.2 - 0.4 * (bumps - AGAINST)).min(0.45)),
        (false, false) => vec![],
    }
}

/// The file, where its name speaks for the channel that is read.
fn path(inputs: &Inputs) -> Option<&std::path::Path> {
    inputs.roughness.channel().filter(|file| file.channel.is_none()).map(|file| file.path.as_path())
}

/// Correlation of bumps (root of the slope variance within a block) with the mean perceptual roughness there; 0 without
/// normals.
pub fn against(subject: &Subject) -> f64 {
    if subject.normals().is_none() {
        return 0.0;
    }
    let material = subject.material;
    let size = material.size;
    let parts = bands(size.height / BLOCK, |rows| {
        let mut sums = [0.0f64; 6];
        let mut row: [Vec<f32>; 5] = std::array::from_fn(|_| vec![0.0; size.width]);
        for block_row in rows {
            // Count, p, q, p^2 + q^2, roughness.
            let mut blocks = vec![[0.0f32; 5]; size.width / BLOCK];
            for y in block_row * BLOCK..(block_row + 1) * BLOCK {
                let [nx, ny, nz, coverage, roughness] = &mut row;
                material.normals(y, 0, [nx, ny, nz], coverage);
                material.perceptual(y, 0, roughness);
                for (i, block) in blocks.iter_mut().enumerate() {
                    for x in i * BLOCK..(i + 1) * BLOCK {
                        // Clamped to 85 degrees.
                        let scale = coverage[x] / nz[x].max(STEEPEST_Z);
                        let (p, q) = (nx[x] * scale, ny[x] * scale);
                        block[0] += coverage[x];
                        block[1] += p;
                        block[2] += q;
                        block[3] += p * p + q * q;
                        block[4] += coverage[x] * roughness[x];
                    }
                }
            }
            for [n, p, q, squares, roughness] in blocks {
                if n > 0.0 {
                    let variance = squares / n - (p * p + q * q) / (n * n);
                    let (bumps, roughness) = (f64::from(variance.max(0.0).sqrt()), f64::from(roughness / n));
                    let terms = [1.0, bumps, roughness, bumps * bumps, roughness * roughness, bumps * roughness];
                    sums = std::array::from_fn(|i| sums[i] + terms[i]);
                }
            }
        }
        sums
    });
    correlation(parts.iter().fold([0.0; 6], |all: [f64; 6], part| std::array::from_fn(|i| all[i] + part[i])))
}
