//! What is wrong with the maps of a material: each finding with its evidence, how sure it is, and what mends it.
//!
//! Nothing here changes a map. A [`Check`] looks at a [`Subject`], the loaded material and its pictures as the files hold
//! them; a new one is a file and a line of [`CHECKS`]. Thresholds are derived where they stand, or measured on the real
//! maps that `tests/audit.rs` names.

use std::path::Path;
use std::sync::Mutex;

use serde::Serialize;

use crate::error::Error;
use crate::image::Size;
use crate::material::{Inputs, ReadPicture, load_with};

mod compression;
mod constant;
mod curl;
mod gloss;
mod green;
mod lean;
mod length;
mod packing;
mod relief;
mod sizes;
mod srgb;
mod stats;
mod steps;
mod subject;
#[cfg(test)]
mod tests;
mod unread;
mod values;

pub use subject::{Normals, Picture, Subject, Width};

/// How bad a finding is, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The material comes out wrong.
    Error,
    /// Probably wrong, or visibly worse than it could be.
    Warning,
    /// Worth knowing.
    Note,
}

impl Severity {
    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// Something that is, or may be, wrong with a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the check.
    pub check: &'static str,
    /// How bad it is if it is so.
    pub severity: Severity,
    /// The file, without its folder; what could not be loaded, for `load`.
    pub map: String,
    /// The channels: `red`, `green`, `red green`, ...; all of them where it is none.
    pub channel: Option<&'static str>,
    /// What was measured.
    pub evidence: String,
    /// How sure it is that this is a fault, 0 to 1.
    pub confidence: f64,
    /// What to do.
    pub fix: String,
}

/// One way to look at a material.
pub struct Check {
    /// Name in reports: lower case, words joined by hyphens.
    pub name: &'static str,
    /// What it looks for, in one line.
    pub about: &'static str,
    /// Looks. The findings name the check again.
    pub run: fn(&Subject) -> Vec<Finding>,
}

/// Name of the findings about a set that cannot be loaded.
pub const LOAD: &str = "load";

/// Every check, in the order of their findings.
pub static CHECKS: &[Check] = &[
    values::CHECK,
    srgb::CHECK,
    srgb::CLAIM,
    length::BEHIND,
    length::CHECK,
    green::CHECK,
    lean::CHECK,
    packing::CHECK,
    gloss::CHECK,
    constant::CHECK,
    compression::CHECK,
    steps::CHECK,
    unread::CHECK,
    sizes::SET,
    sizes::CHECK,
];

/// A material and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// Name of the material.
    pub name: String,
    /// Size of its largest map, if it could be loaded.
    pub size: Option<Size>,
    /// Worst first; of one severity, in the order of [`CHECKS`].
    pub findings: Vec<Finding>,
}

impl Audit {
    /// Findings of one severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// A set that cannot be loaded.
    pub fn unloadable(name: impl Into<String>, error: &Error) -> Self {
        let (map, evidence, fix) = match error {
            Error::Unsupported { subject, found, expected } => {
                (subject.clone(), format!("{found} is not supported"), format!("use {expected}"))
            }
            Error::Invalid { subject, found, expected } => {
                (subject.clone(), format!("found {found}"), format!("expected {expected}"))
            }
            Error::Io { path, source } => {
                (path.display().to_string(), source.to_string(), "make the file readable".to_owned())
            }
        };
        let finding =
            Finding { check: LOAD, severity: Severity::Error, map, channel: None, evidence, confidence: 1.0, fix };
        Self { name: name.into(), size: None, findings: vec![finding] }
    }
}

/// Runs every check on a material. A set that cannot be loaded is an error among the findings.
pub fn audit(inputs: &Inputs, read: ReadPicture) -> Audit {
    match try_audit(inputs, read) {
        Ok(audit) => audit,
        Err(error) => Audit::unloadable(inputs.name.clone(), &error),
    }
}

fn try_audit(inputs: &Inputs, read: ReadPicture) -> crate::error::Result<Audit> {
    // What files say about themselves goes into the notes of the material; here it must be known by file.
    let seen = Mutex::new(Vec::new());
    let watched = |path: &Path| {
        let decoded = read(path)?;
        let about = subject::Seen { path: path.to_owned(), notes: decoded.notes.clone() };
        seen.lock().expect("no panic while it is held").push(about);
        Ok(decoded)
    };
    let material = load_with(inputs, &watched)?;
    let seen = seen.into_inner().expect("no panic while it was held");
    let subject = Subject::new(inputs, &material, read, &seen)?;
    let mut findings: Vec<Finding> = CHECKS.iter().flat_map(|check| (check.run)(&subject)).collect();
    findings.sort_by_key(|finding| finding.severity);
    // More digits would say more than is known.
    findings.iter_mut().for_each(|finding| finding.confidence = (100.0 * finding.confidence).round() / 100.0);
    Ok(Audit { name: material.name.clone(), size: Some(material.size), findings })
}

/// A share of 1 in per cent, with as many digits as it needs.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || percent >= 10.0 {
        format!("{percent:.0} %")
    } else if percent >= 0.1 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.1e} %")
    }
}
