//! A chain becomes files: PNG per level, mip-mapped EXR, lobes, moments, manifest; whole or not at all.

mod energy;
mod exr;
mod extra;
mod manifest;
mod plan;
mod stage;
mod texels;
mod vertices;
mod write;

pub use crate::material::{MANIFEST, SCHEMA};
pub use energy::fold_for;
pub use manifest::{Input, Manifest, OutputMap};
pub use plan::{Content, Format, Output, Plan, Request, safe_name};
use stage::stale;
pub use stage::{Stage, may_build, may_write};
pub use texels::{read_texels, write_texels};
pub use vertices::{vertices_name, write_vertices};
pub use write::{write, write_with};
