//! A footprint in a bounded number of lobes.
//!
//! Folds that need more than moments read a footprint's lobes. Where it has more than a few, a **summary** stands for
//! them: at most so many lobes of the slope plane ([`SlopeLobe`](crate::ndf::SlopeLobe)), each with the weight of those
//! that it replaces. Summaries of neighbours join to that of the coarser texel: their lobes side by side, near ones merged
//! if they become too many ([`merge`]). Weight and mean slope are kept exactly; what is lost is the difference between
//! lobes that lie close together beside the width of the whole.

mod merge;
mod rows;

pub use merge::{Entry, Scratch, merge, merge_to};
pub(crate) use rows::{Buffers, Gather, QUANTITIES, Summaries};

/// Level-0 texels joined without loss: a summary may hold so many lobes, or more.
pub const EXACT: usize = 16;

#[cfg(test)]
mod tests;
