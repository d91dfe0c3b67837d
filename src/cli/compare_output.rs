//! The judge's findings as texts and files.

use super::report::Report;
use crate::error::Result;
use crate::report::{Motion, Subject};

pub use crate::report::{csv, json, page, verdict};

/// The chains in motion.
pub fn motion(_subject: &Subject, _report: &Report) -> Result<Vec<Motion>> {
    Ok(Vec::new())
}
