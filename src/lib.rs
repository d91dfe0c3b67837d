//! mipfold builds mip chains that keep a material looking the same at every distance.

pub mod cli;
pub mod codec;
pub mod error;
pub mod fold;
pub mod image;
pub mod material;
pub mod moments;
pub mod ndf;
pub mod output;
pub mod render;
pub mod roughness;
pub mod sample;

pub use error::{Error, Result};
