//! Of `kernels/wgsl/roughness.wgsl`.

use crate::case::{Bound, Case, Sweep};
use crate::twins::roughness as twin;

/// All functions.
pub fn cases() -> Vec<Case> {
    let exact = Bound { absolute: 1e-9, relative: 2e-7 };
    vec![Case {
        name: "mf_alpha_from_perceptual",
        inputs: Sweep::new(300).linear(0.0, 1.0).inputs(),
        twin: |a| vec![twin::alpha_from_perceptual(a[0])],
        bound: exact,
    }]
}
