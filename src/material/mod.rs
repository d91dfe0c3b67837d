//! What channels mean, both ways: roles, packing, Y and roughness conventions, file names, repair.

mod beside;
mod built;
pub mod detect;
mod extra;
mod flakes;
mod further;
mod generate;
mod gltf;
mod guess;
mod height;
mod inputs;
mod inspect;
mod levels;
mod load;
mod lobes;
mod names;
mod pack;
mod resample;
mod role;
mod set;
mod source;
mod texels;

pub use beside::{height_beside, named_normal_y, named_smooth};
pub use built::{Earlier, GENERATOR, JOURNAL, MANIFEST, PICTURES, SCHEMA};
pub use extra::{Extra, LARGEST_ENERGY};
pub use flakes::{FlakePlaces, FlakesAbout, FlakesFile, MaterialFlakes};
pub use further::{FurtherMap, FurtherView};
pub(crate) use gltf::turn;
pub use gltf::{AnisotropyUse, Fate, Foldable, Model, Surface, TextureUse};
pub(crate) use inputs::colour;
pub use inputs::{ChannelRef, DEFAULT_HEIGHT_SCALE, DEFAULT_ROUGHNESS, Inputs, RoughnessInput};
pub use inspect::Findings;
pub use levels::{Container, LOBE_CHANNELS, LevelChain, lobe_channels, read_folder, read_lobes, read_maps};
pub use load::{ReadPicture, load, load_with};
pub use lobes::{base_lobes, surface_lobes};
pub use names::Tile;
pub(crate) use pack::quantised;
pub use pack::{Encoding, LevelView};
pub use role::{NormalRange, NormalY, NormalZ, Role};
pub use source::{MapFile, Material, MeshAbout, MeshUnder, Origin};
pub use texels::Texels;

/// Whether two spellings mean one file.
pub(crate) fn same_path(a: &std::path::Path, b: &std::path::Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
