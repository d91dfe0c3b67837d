//! A chain becomes files: PNG per level, mip-mapped EXR, KTX 2 and DDS, lobes, moments, manifest; whole or not at all.

mod exr;
mod extra;
mod fold_for;
mod fresh;
mod gain;
mod layer;
mod manifest;
pub mod model;
mod plan;
pub mod preset;
mod sheet;
mod stage;
mod texels;
mod texture;
mod vertices;
mod write;

pub use crate::material::{MANIFEST, SCHEMA};
pub use fold_for::fold_for;
pub use fresh::{file_digest, fresh, key};
pub use gain::{Gain, gain};
pub use layer::{Layer, Rows};
pub use manifest::{Input, Manifest, OutputMap};
pub use plan::{Content, Format, Output, Plan, Request, safe_name};
pub use sheet::{Sheet, Source};
use stage::stale;
pub use stage::{FolderLock, Stage, may_build, may_write};
pub use texels::{read_texels, write_texels};
pub use texture::{ChangeTexel, texel_format, texture_of};
pub use vertices::{vertices_name, write_vertices};
pub use write::{write, write_with};
