//! Channels of packed maps that seem to hold something else.

use super::stats::Stats;
use super::{Check, Finding, Severity, Subject, percent};
use crate::material::colour;

/// Swapped channels.
pub const CHECK: Check = Check {
    name: "packing",
    about: "the channel read as roughness looks like metal or occlusion, another does not",
    run,
};

/// Share of the texels at 0 or 1, within five 8-bit steps, that makes a mask: metal is or is not.
const MASK: f64 = 0.95;

/// Deviation from which a channel says something.
const VARIED: f64 = 0.01;

/// How a channel looks.
struct Look {
    channel: usize,
    stats: Stats,
    /// Share of texels near 0 or 1.
    extreme: f64,
    /// Share of texels near 1.
    white: f64,
}

fn run(subject: &Subject) -> Vec<Finding> {
    let Some(width) = subject.width() else { return vec![] };
    let raster = &width.picture.raster;
    let look = |channel| {
        let stats = Stats::of(raster, channel);
        let (black, white) = (stats.share(0.0, 0.02), stats.share(0.98, 1.0));
        Look { channel, extreme: black + white, white, stats }
    };
    let read = look(width.channel);
    let finding = |severity, evidence, confidence, fix| {
        vec![Finding {
            check: CHECK.name,
            severity,
            map: width.picture.file.clone(),
            channel: width.channel_name(),
            evidence,
            confidence,
            fix,
        }]
    };
    let flag = if width.smooth { "--gloss" } else { "--roughness" };
    let letter = |channel: usize| ["r", "g", "b", "a"].get(channel).copied().unwrap_or("a");
    let name = colour(width.channel);
    // Gray stored as colour has no other channel.
    let others: Vec<Look> = (0..raster.channels.len().min(3))
        .filter(|c| matches!(width.picture.roles[*c], crate::material::Role::Other(_)))
        .map(look)
        .filter(|other| other.stats.deviation > VARIED && other.extreme < MASK)
        .collect();
    // The one that is least like occlusion, which is white where nothing is near.
    let better = others.iter().min_by(|a, b| a.white.total_cmp(&b.white));
    if read.extreme >= MASK {
        let two_valued = read.stats.deviation > VARIED;
        let what = if two_valued { "two-valued, as metal is" } else { "black or white everywhere" };
        let evidence = format!("{name} is {what}: {} of the texels are 0 or 1", percent(read.extreme));
        return match better {
            Some(better) => finding(
                Severity::Warning,
                format!("{evidence}; {} is not (mean {:.2})", colour(better.channel), better.stats.mean),
                0.85,
                format!(
                    "read it with {flag} FILE:{}, or pack occlusion, roughness, metal in that order",
                    letter(better.channel)
                ),
            ),
            None if two_valued => {
                finding(Severity::Note, evidence, 0.4, "check that the map is roughness and not a mask".to_owned())
            }
            // One value is a constant map, which has its own check.
            None => vec![],
        };
    }
    match better {
        Some(better) if read.white > OPEN && better.white < CLOSED => finding(
            Severity::Note,
            format!(
                "{name} is white in {} of the texels, as occlusion is; {} in {}",
                percent(read.white),
                colour(better.channel),
                percent(better.white)
            ),
            0.35,
            format!("if {} is the roughness: {flag} FILE:{}", colour(better.channel), letter(better.channel)),
        ),
        _ => vec![],
    }
}

/// Share of white that looks like occlusion: most of a surface is open, and hardly any material is fully rough.
const OPEN: f64 = 0.4;

/// And that does not.
const CLOSED: f64 = 0.05;
