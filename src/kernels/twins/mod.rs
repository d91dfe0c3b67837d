//! The shader helpers of `kernels/wgsl` once more, in f64: function by function, with the same names (without `mf_`) and
//! arguments. They are written from the formulas, not from the shaders' text, and judge it.

pub mod footprint;
pub mod geometric_aa;
pub mod moments;
pub mod ndf;
pub mod roughness;
pub mod shading;
