//! mipfold builds mip chains that keep a material looking the same at every distance.

pub mod codec;
pub mod error;
pub mod image;
pub mod ndf;
pub mod roughness;

pub use error::{Error, Result};
