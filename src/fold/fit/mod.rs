//! Folds that search: the closest lobe, or few lobes, for the lobes of a footprint.
//!
//! Footprints are fitted side by side, one in each lane of a register, those of a [`Chunk`] in turn: every step is arithmetic without branches, on
//! [`Lanes`] that fill the registers of the processor (AVX2, NEON; one by one elsewhere), which `pulp` picks. Products and sums
//! are never contracted, so all give the same bits.

mod chunk;
pub(super) mod estimate;
mod lanes;
pub(super) mod lobe_error;
pub(super) mod mixture;
pub(super) mod read_out;
pub(super) mod scatter;
mod seed;
pub(super) mod simplex;

pub use chunk::{Atom, Chunk, Fit, Fitted, Shape};
pub(super) use chunk::{one, row};
pub use lanes::{Lanes, Which};
