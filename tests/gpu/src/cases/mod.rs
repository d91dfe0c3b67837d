//! What the shader helpers are called with, one file per subject.

use crate::case::Case;

mod roughness;

/// The cases of every subject (a file `kernels/wgsl/<subject>.wgsl`), with its name.
pub fn all() -> Vec<(&'static str, Vec<Case>)> {
    vec![("roughness", roughness::cases())]
}
