//! A chain becomes files: PNG per level, mip-mapped EXR, lobes, moments, manifest; whole or not at all.

mod exr;
mod manifest;
mod plan;
mod stage;
mod write;

pub use manifest::{Input, Manifest, OutputMap, SCHEMA};
pub use plan::{Content, Format, Output, Plan, Request, safe_name};
pub use stage::Stage;
pub use write::write;

/// Name of the manifest in a material's folder.
pub const MANIFEST: &str = "manifest.json";
