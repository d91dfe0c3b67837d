//! A chain becomes files: PNG per level, mip-mapped EXR, lobes, moments, manifest; whole or not at all.

mod exr;
mod manifest;
mod plan;
mod stage;
mod write;

pub use crate::material::{MANIFEST, SCHEMA};
pub use manifest::{Input, Manifest, OutputMap};
pub use plan::{Content, Format, Output, Plan, Request, safe_name};
pub use stage::{Stage, may_write};
pub use write::write;
