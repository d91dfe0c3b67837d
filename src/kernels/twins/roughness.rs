//! Twins of `kernels/wgsl/roughness.wgsl`.

/// GGX width from perceptual roughness.
pub fn alpha_from_perceptual(perceptual: f64) -> f64 {
    perceptual * perceptual
}
