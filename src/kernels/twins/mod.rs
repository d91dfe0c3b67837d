//! The shader helpers of `kernels/wgsl` once more, in f64: function by function, with the same names (without `mf_`) and
//! arguments. They are written from the formulas, not from the shaders' text, and judge it.

pub mod footprint;
pub mod geometric_aa;
pub mod glint;
pub mod glint_binomial;
pub mod glint_chance;
pub mod glint_field;
pub mod moments;
pub mod ndf;
pub mod roughness;
pub mod shading;

/// The next number of a stream, -1 to 1, by a linear congruential generator.
#[cfg(test)]
fn draw(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
