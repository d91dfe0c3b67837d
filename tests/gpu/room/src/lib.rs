//! The glints of the library, and what they need of it, by path: the shader tests need not build the whole library. A package
//! of its own, so that it is optimised, and built without its own tests, which belong to the library.

#[path = "../../../../src/glint/mod.rs"]
pub mod glint;
/// Tensors of lobes.
pub mod ndf {
    pub use crate::tensor::{Axes, RoughnessTensor};
}
#[path = "../../../../src/roughness.rs"]
pub mod roughness;
#[path = "../../../../src/ndf/tensor.rs"]
mod tensor;
