//! The judge's findings, for people (one self-contained HTML page) and for programs (JSON, CSV).

mod data;
mod disks;
mod figures;
mod histogram;
mod mips;
mod motion;
mod page;
mod pictures;
mod plot;
mod strip;
mod svg;
#[cfg(test)]
mod tests;
mod verdict;

pub use data::{CSV_MARK, SCHEMA, csv, json, passes};
pub use motion::motion;
pub use page::{HTML_MARK, page};
pub use verdict::{LITTLE, Matters, SIGNIFICANT, UNSEEN, Verdict, not_this_surface, verdict};

use serde::Serialize;

use crate::compare::{Candidate, Judgement, Limit, MotionScore, Settings};
use crate::material::Material;

/// Pictures of more chains than this are smaller or fewer, so that the page stays below 5 MB.
const MANY: usize = 4;

/// Everything that a report tells of.
pub struct Subject<'a> {
    /// The surface as it is at level 0.
    pub material: &'a Material,
    /// The chains, level 0 first.
    pub chains: &'a [Candidate],
    /// Where they come from, in the same order; of those at the end that have no entry, nothing is said.
    pub about: &'a [ChainAbout],
    /// What the judge said of them, in the same order.
    pub judgement: &'a Judgement,
    /// Which of the chains is plain mips, made for comparison.
    pub plain: Option<usize>,
    /// What was asked of the other chains.
    pub limits: &'a [Limit],
    /// How closely the judge looked.
    pub settings: &'a Settings,
    /// The command line that repeats it.
    pub command: &'a str,
    /// Pictures in motion, if any were made.
    pub motion: &'a [Motion],
}

/// Where a chain comes from, and what was understood of it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ChainAbout {
    /// Path or keys as they were given, or in words how it was made.
    pub source: String,
    /// Which form of a folder's chain was read: "png", "exr" or "lobes".
    pub container: Option<&'static str>,
    /// What was understood of its files.
    pub notes: Vec<String>,
    /// What looks wrong in them.
    pub warnings: Vec<String>,
}

/// A moving picture and what it says of each chain.
pub struct Motion {
    /// "zoom" or "pan".
    pub name: &'static str,
    /// Chains and the truth side by side, as an animated PNG.
    pub apng: Vec<u8>,
    /// The chains that it shows, from the left; the truth stands last.
    pub shown: Vec<String>,
    /// Width and height of the animation in pixels.
    pub size: (usize, usize),
    /// For each chain in order.
    pub scores: Vec<MotionScore>,
}
