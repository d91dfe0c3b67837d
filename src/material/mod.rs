//! What channels mean, both ways: roles, packing, Y and roughness conventions, file names, repair.

mod built;
pub mod detect;
mod generate;
mod guess;
mod height;
mod inputs;
mod inspect;
mod load;
mod pack;
mod resample;
mod role;
mod source;
mod texels;

pub use built::{Earlier, GENERATOR, MANIFEST};
pub use inputs::{ChannelRef, DEFAULT_HEIGHT_SCALE, DEFAULT_ROUGHNESS, Inputs, RoughnessInput};
pub use inspect::Findings;
pub use load::{ReadPicture, load, load_with};
pub use pack::{Encoding, LevelView};
pub use role::{NormalRange, NormalY, NormalZ, Role};
pub use source::{MapFile, Material, Origin};
pub use texels::Texels;
