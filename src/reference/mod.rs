//! The exact NDF and the exact shading of a footprint, in f64.
//!
//! A [`Footprint`] is the weighted list of the level-0 lobes under one texel of a level: weights are the shares of its
//! area, exact for every size. Its NDF is their mean, `sum w_i D_i(m) / (n_i . z)`; its shading is the mean of what a
//! renderer computes from each texel's own normal and roughness; its diffuse term the mean of `max(0, n_i . l)`. Nothing
//! is binned or fitted, and nothing of it is kept in memory but one block of lobes for each thread.

mod albedo;
mod footprint;
mod kernel;
mod lobe;
mod rows;
#[cfg(test)]
pub(crate) mod tests;

pub use albedo::{average_albedo, directional_albedo};
pub use footprint::{Footprint, Interpolation, Reading};
pub use kernel::{Diffuse, Means, Queries};
