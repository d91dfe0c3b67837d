//! How far a mip chain is from the truth: distances between NDFs and between lobes as seen, energy, diffuse light; and
//! of pictures and sequences of them. Nothing here knows how a chain was made.

mod flicker;
mod flip;
mod judge;
mod limit;
mod measure;
mod score;
#[cfg(test)]
mod tests;

pub use flicker::{flicker, score_motion};
pub use flip::flip;
pub use judge::{Candidate, LOBES_A_LEVEL, Settings, judge};
pub use limit::{Breach, Limit, Metric};
pub use measure::{LIGHT_RADIUS, VIEWS};
pub use score::{ChainScore, Energy, Judgement, LevelScore, MotionScore, Place, Summary, WorstTexel};
