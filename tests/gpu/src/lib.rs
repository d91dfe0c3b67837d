//! Runs the shader helpers of `kernels/` on a Vulkan device and compares every function, in each language, with its twin
//! in f64.
//!
//! `kernels/wgsl` is the hand-written text; [`translate`] makes GLSL and HLSL from it, [`harness`] runs all three, and
//! [`cases`] says with which arguments.

pub mod case;
pub mod cases;
pub mod gpu;
pub mod harness;
pub mod source;
pub mod token;
pub mod translate;
/// The twins, by path, so that the shader tests need not build the whole library.
#[path = "../../../src/kernels/twins/mod.rs"]
pub mod twins;
pub mod words;
pub mod wrapper;
