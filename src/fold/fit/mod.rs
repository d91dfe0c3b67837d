//! Folds that search: the closest lobe, or few lobes, for the lobes of a footprint.
//!
//! Footprints are fitted side by side, one in each lane of a [`Chunk`]: every step is arithmetic without branches, so that
//! the compiler fills vector registers with it; `pulp` picks a clone for AVX2 where there is one. Rust never contracts
//! products and sums, so every clone gives the same bits.

mod chunk;
pub(super) mod estimate;
mod lanes;
pub(super) mod lobe_error;
pub(super) mod mixture;
pub(super) mod scatter;
mod seed;
pub(super) mod simplex;

pub use chunk::{Atom, Chunk, Fit, Fitted, Shape};
pub(super) use chunk::{one, row};
pub use lanes::{LANES, Lanes};
