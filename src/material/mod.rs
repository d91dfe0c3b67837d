//! What channels mean, both ways.

mod texels;

pub use texels::Texels;
