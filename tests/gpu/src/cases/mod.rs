//! What the shader helpers are called with, one file per subject.

use crate::case::Case;

mod footprint;
mod geometric_aa;
mod moments;
mod ndf;
mod roughness;
mod shading;

/// The cases of every subject (a file `kernels/wgsl/<subject>.wgsl`), with its name.
pub fn all() -> Vec<(&'static str, Vec<Case>)> {
    vec![
        ("footprint", footprint::cases()),
        ("geometric_aa", geometric_aa::cases()),
        ("geometric_aa_screen", geometric_aa::screen_cases()),
        ("moments", moments::cases()),
        ("ndf", ndf::cases()),
        ("roughness", roughness::cases()),
        ("shading", shading::cases()),
    ]
}
