//! Steps of stored integers that read as roughness.

use super::stats::Stats;
use super::subject::bands;
use super::{Check, Finding, Normals, Severity, Subject, percent};
use crate::image::Samples;
use crate::material::{Role, Texels};

/// Steps.
pub const CHECK: Check =
    Check { name: "steps", about: "8-bit steps that read as roughness; 16-bit files of 8-bit content", run };

/// A step of a component that is stored in 8 bits as 0..1.
const STEP: f64 = 2.0 / 255.0;

/// Rise of the perceptual roughness that counts: 5 %.
const RISE: f64 = 1.05;

/// Share of the texels that is worth a note.
const SOME: f64 = 0.01;

/// Share of the slope variance that rounding may have.
const ROUNDED: f64 = 0.1;

/// So few values of roughness make visible terraces.
const FEW: usize = 12;

fn run(subject: &Subject) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(normals) = subject.normals() {
        let stats: Vec<Stats> = (0..2).map(|c| Stats::of(&normals.picture.raster, c)).collect();
        let widened = widened(&stats);
        findings.extend(holds_8_bits(&normals, &stats));
        if matches!(normals.picture.raster.samples, Samples::U8(_)) || widened {
            findings.extend(in_smooth_places(subject, &normals));
            findings.extend(in_bumps(&normals, &stats));
        }
    }
    findings.extend(terraces(subject));
    findings
}

/// Encoders widen bytes as v * 257; other tools scale them by 256 or through floats, which leaves as few values.
fn widened(stats: &[Stats]) -> bool {
    stats.iter().all(|stats| stats.widened || stats.distinct.is_some_and(|n| n <= 256))
}

fn holds_8_bits(normals: &Normals, stats: &[Stats]) -> Option<Finding> {
    let is16 = matches!(normals.picture.raster.samples, Samples::U16(_));
    let most = stats.iter().filter_map(|stats| stats.distinct).max()?;
    (is16 && widened(stats) && normals.size().texels() > 4096 && most > 1).then(|| Finding {
        check: CHECK.name,
        severity: Severity::Note,
        map: normals.picture.file.clone(),
        channel: Some("red green"),
        evidence: format!("16 bits a sample, but only {most} different values: 8-bit content"),
        confidence: 0.9,
        fix: "export it from the source at 16 bits, or save the space of the second byte".into(),
    })
}

/// Where the base is so smooth that rounding alone widens its lobe.
///
/// Rounding to steps q has the variance q^2 / 12 along each axis; slopes have it too where z is near 1. A fold adds twice a
/// slope variance to alpha^2, so that r becomes (r^4 + q^2 / 6)^(1/4).
fn in_smooth_places(subject: &Subject, normals: &Normals) -> Option<Finding> {
    let step = STEP * f64::from(subject.material.normal_scale);
    let added = step * step / 6.0;
    let smooth = (added / (RISE.powi(4) - 1.0)).powf(0.25);
    // Maps of other sizes have no texels in common.
    let (material, size) = (subject.material, normals.size());
    if material.size != size {
        return None;
    }
    let parts = bands(size.height, |rows| {
        // Smooth texels, those of them that differ from the left neighbour by one step and no more, sum of r^4.
        let mut sums = [0.0f64; 3];
        let mut row: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; size.width]);
        for y in rows {
            let [x, green, roughness] = &mut row;
            material.perceptual(y, 0, roughness);
            if roughness.iter().all(|r| f64::from(*r) > smooth) {
                continue;
            }
            normals.picture.raster.read(0, y, 0, x);
            normals.picture.raster.read(1, y, 0, green);
            for i in 1..size.width {
                if f64::from(roughness[i]) < smooth {
                    let jump = (x[i] - x[i - 1]).abs().max((green[i] - green[i - 1]).abs()) * 255.0;
                    let rounding = (0.5..1.5).contains(&jump);
                    sums[0] += 1.0;
                    sums[1] += f64::from(u8::from(rounding));
                    sums[2] += f64::from(roughness[i]).powi(4);
                }
            }
        }
        sums
    });
    let [count, rounding, alpha2] =
        parts.iter().fold([0.0; 3], |all: [f64; 3], part| std::array::from_fn(|i| all[i] + part[i]));
    let share = rounding / size.texels() as f64;
    if share < SOME {
        return None;
    }
    let base = (alpha2 / count).powf(0.25);
    let folded = (alpha2 / count + added).powf(0.25);
    Some(Finding {
        check: CHECK.name,
        severity: Severity::Note,
        map: normals.picture.file.clone(),
        channel: Some("red green"),
        evidence: format!(
            "{} of the texels are smoother than {smooth:.3}, and {} of those change by single 8-bit steps: rounding adds up to \
             {added:.1e} to alpha^2, so that roughness {base:.3} reads as up to {folded:.3} in the mips",
            percent(count / size.texels() as f64),
            percent(rounding / count)
        ),
        confidence: 0.6,
        fix: "export the normal map at 16 bits, where the surface shall stay that smooth".into(),
    })
}

/// Bumps so low that a good part of them is rounding.
fn in_bumps(normals: &Normals, stats: &[Stats]) -> Option<Finding> {
    let rounding = STEP * STEP / 12.0;
    let variance: f64 = stats.iter().map(|stats| (2.0 * stats.deviation).powi(2)).sum();
    let share = 2.0 * rounding / variance;
    let values = stats.iter().map(|stats| stats.distinct.unwrap_or(0)).max()?;
    // Flat maps have a check of their own.
    (variance > 2.0 * rounding * 0.25 && values > 3 && share > ROUNDED).then(|| Finding {
        check: CHECK.name,
        severity: Severity::Note,
        map: normals.picture.file.clone(),
        channel: Some("red green"),
        evidence: format!(
            "the bumps use {values} values: {} of their slope variance of {variance:.1e} is rounding",
            percent(share.min(1.0))
        ),
        confidence: 0.7,
        fix: "export the normal map at 16 bits, or make the bumps higher and set --normal-scale below 1".into(),
    })
}

/// Roughness in a few values.
fn terraces(subject: &Subject) -> Option<Finding> {
    let width = subject.width()?;
    let stats = Stats::of(&width.picture.raster, width.channel);
    let distinct = stats.distinct?;
    let mask = stats.share(0.0, 0.02) + stats.share(0.98, 1.0);
    let holds = (3..=FEW).contains(&distinct) && stats.deviation > 0.01 && mask < 0.95;
    holds.then(|| Finding {
        check: CHECK.name,
        severity: Severity::Note,
        map: width.picture.file.clone(),
        channel: width.channel_name(),
        evidence: format!("only {distinct} different values from {:.2} to {:.2}", stats.min, stats.max),
        confidence: if width.picture.roles.contains(&Role::NormalX) { 0.3 } else { 0.5 },
        fix: "export it at 8 bits or more without a palette, unless the terraces are meant".into(),
    })
}
