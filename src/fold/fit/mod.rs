//! Folds that search: the closest lobe, or few lobes, for the lobes of a footprint.
//!
//! Footprints are fitted side by side, one in each lane of a register, those of a [`Chunk`] in turn: steps are arithmetic
//! without branches on [`Lanes`], for which `pulp` picks the widest registers of the processor. What only few footprints
//! need is done for those alone, again side by side. Products and sums are never contracted: all processors give the same
//! bits, and so do a footprint alone and one in a chunk.

mod chunk;
pub(super) mod estimate;
mod lanes;
pub(super) mod lobe_error;
pub(super) mod mixture;
mod nodes;
pub(super) mod read_out;
pub(super) mod scatter;
mod seed;
pub(super) mod simplex;

pub use chunk::{Chunk, Fit, Fitted, Shape};
pub(super) use chunk::{one, row};
#[cfg(test)]
pub use lanes::Rows;
pub use lanes::{Lanes, Which};
