//! Twins of `kernels/wgsl/roughness.wgsl`.
