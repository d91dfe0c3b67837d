//! Channels that hold something and are read for nothing.

use super::stats::Stats;
use super::{Check, Finding, Severity, Subject};
use crate::material::Role;
use crate::material::colour;

/// Alpha and further channels.
pub const CHECK: Check =
    Check { name: "unread", about: "alpha or further channels that vary but are read for nothing", run };

/// Deviation from which a channel says something: more than rounding and compression.
const VARIED: f64 = 0.01;

fn run(subject: &Subject) -> Vec<Finding> {
    let mut findings = Vec::new();
    for picture in &subject.pictures {
        let count = picture.raster.channels.len();
        let holds_normals = picture.roles.contains(&Role::NormalX);
        // The other colours of a packed map are known company; the second channel of a gray map is alpha.
        let first = if count == 2 { 1 } else { 3 };
        for channel in (first..count).filter(|c| matches!(picture.roles[*c], Role::Other(_))) {
            let stats = Stats::of(&picture.raster, channel);
            if stats.deviation <= VARIED {
                continue;
            }
            let name = &picture.raster.channels[channel];
            let what = if count > 4 { format!("channel {name}") } else { colour(first.max(channel.min(3))).to_owned() };
            let hint = if holds_normals { "roughness or height there" } else { "gloss or opacity there" };
            findings.push(Finding {
                check: CHECK.name,
                severity: Severity::Note,
                map: picture.file.clone(),
                channel: Some(if count == 2 { "alpha" } else { colour(channel) }),
                evidence: format!(
                    "{} varies from {:.2} to {:.2} (mean {:.2}, deviation {:.3}) and is read for nothing",
                    if count == 2 { "alpha" } else { &what },
                    stats.min,
                    stats.max,
                    stats.mean,
                    stats.deviation
                ),
                confidence: 0.5,
                fix: format!(
                    "if there is {hint}, name it (--roughness FILE:a, --gloss FILE:a); as it is, mips average it plainly"
                ),
            });
        }
    }
    findings
}
