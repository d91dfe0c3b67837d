//! The exact NDF and the exact shading of a footprint, in f64.

mod footprint;

pub use footprint::{Footprint, Interpolation, Reading};
