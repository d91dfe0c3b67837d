//! Runs the shader helpers of `kernels/` on a Vulkan device and compares every function, in each language, with its twin
//! in f64.
//!
//! `kernels/wgsl` is the hand-written text; [`translate`] makes GLSL and HLSL from it, [`harness`] runs all three, and
//! [`cases`] says with which arguments.
//!
//! ```text
//! apt-get install mesa-vulkan-drivers libvulkan1 glslang-tools
//! cargo test --manifest-path tests/gpu/Cargo.toml
//! ```
//!
//! `examples/zooming_sphere` shades a sphere with them, in the textures that `mipfold build` wrote; its tests run with these.
//!
//! Without a Vulkan adapter or `glslangValidator` the tests say SKIPPED and pass; with `MIPFOLD_NO_SKIP` set they fail.
//! `MIPFOLD_ONLY` names one file (`ndf`) or, for the comparison, one function (`mf_d_ggx`). `BLESS=1` writes
//! `kernels/glsl` and `kernels/hlsl` anew.

pub mod case;
pub mod cases;
pub mod cost;
pub mod gpu;
pub mod harness;
pub mod source;
pub mod token;
pub mod translate;
/// What the twins of glints call.
pub use mipfold_glint_room::{glint, ndf, roughness};
/// The twins, by path, so that the shader tests need not build the whole library.
#[path = "../../../src/kernels/twins/mod.rs"]
pub mod twins;
pub mod words;
pub mod wrapper;
