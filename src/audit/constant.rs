//! Maps that hold one value.

use super::stats::Stats;
use super::{Check, Finding, Severity, Subject};
use crate::material::Role;

/// Constants.
pub const CHECK: Check = Check {
    name: "constant",
    about: "maps of one value: roughness that a number can give, flat normals, channels of other layouts",
    run,
};

/// Range that counts as one value: two 8-bit steps, as JPEG leaves around a flat colour.
const FLAT: f64 = 2.5 / 255.0;

/// Standard deviation of roughness that is as good as none: an eye does not tell 0.30 from 0.31.
const STILL: f64 = 0.005;

fn run(subject: &Subject) -> Vec<Finding> {
    let mut findings = roughness(subject).into_iter().collect::<Vec<_>>();
    findings.extend(normals(subject));
    findings
}

fn roughness(subject: &Subject) -> Option<Finding> {
    let width = subject.width()?;
    let stats = Stats::of(&width.picture.raster, width.channel);
    let constant = stats.is_constant(FLAT);
    if !constant && stats.deviation > STILL {
        return None;
    }
    let perceptual = if width.smooth { 1.0 - stats.mean } else { stats.mean };
    let evidence = if constant {
        format!("{:.3} everywhere (roughness {perceptual:.3})", stats.mean)
    } else {
        format!(
            "nearly constant: {:.3} with a deviation of {:.4} (roughness {perceptual:.3})",
            stats.mean, stats.deviation
        )
    };
    Some(Finding {
        check: CHECK.name,
        severity: Severity::Note,
        map: width.picture.file.clone(),
        channel: width.channel_name(),
        evidence,
        confidence: if constant { 0.9 } else { 0.5 },
        fix: format!(
            "give the number instead (--roughness {perceptual:.3}), unless another channel or file was meant; the mips \
             below level 0 will vary all the same"
        ),
    })
}

fn normals(subject: &Subject) -> Option<Finding> {
    let normals = subject.normals()?;
    let picture = normals.picture;
    let channel = |role| picture.roles.iter().position(|r| *r == role);
    let stats = |role| channel(role).map(|channel| Stats::of(&picture.raster, channel));
    let (x, y) = (stats(Role::NormalX)?, stats(Role::NormalY)?);
    let z = stats(Role::NormalZ).filter(|_| normals.stored_z);
    let scale = if picture.signed { 2.0 } else { 1.0 };
    let flat = |stats: &Stats| stats.is_constant(scale * FLAT);
    let finding = |severity, channel, evidence: String, confidence, fix: &str| {
        Some(Finding {
            check: CHECK.name,
            severity,
            map: picture.file.clone(),
            channel,
            evidence,
            confidence,
            fix: fix.into(),
        })
    };
    let alpha = (picture.raster.channels.len() == 4).then(|| Stats::of(&picture.raster, 3));
    if flat(&x) && flat(&y) {
        let fix = "leave the normal map away: there are no bumps to fold, only roughness to average";
        return finding(Severity::Note, None, "flat: red and green hold one value".into(), 0.9, fix);
    }
    if flat(&x) && x.mean > 0.99 && alpha.is_some_and(|alpha| !flat(&alpha)) {
        let evidence = "red is 1 everywhere and alpha varies: x is in alpha, as DXT5nm stores it".into();
        let fix = "move alpha to red and give it with --normal-z rebuild";
        return finding(Severity::Error, Some("red"), evidence, 0.95, fix);
    }
    if let Some(z) = z.filter(flat) {
        let bent = x.deviation.hypot(y.deviation) * 2.0 / scale;
        // Bumps this small leave z where it is.
        if bent > LEAST_BENT {
            let evidence = format!(
                "blue is {:.2} everywhere while red and green vary by {bent:.2}: a two-channel map in three channels",
                z.mean
            );
            let fix = "read it with --normal-z rebuild";
            return finding(Severity::Warning, Some("blue"), evidence, 0.9, fix);
        }
    }
    for (channel, stats) in [("red", &x), ("green", &y)] {
        if flat(stats) {
            let evidence =
                format!("{channel} is {:.3} everywhere while the other varies: grooves, or a lost channel", stats.mean);
            let fix = "nothing, if the bumps are grooves along one axis; else bake the map again";
            return finding(Severity::Note, Some(channel), evidence, 0.4, fix);
        }
    }
    None
}

/// Deviation of x and y from which a stored z must vary by more than [`FLAT`] (0.0098 of 0..1): z is about
/// 1 - (x^2 + y^2) / 2, stored as half of it; where x and y reach twice their deviation s, z falls by s^2 at least.
const LEAST_BENT: f64 = 0.15;
