//! What the shader helpers are called with, one file per subject.

use crate::case::Case;

mod footprint;
mod geometric_aa;
pub mod glint;
mod glint_binomial;
pub mod glint_chance;
pub mod glint_field;
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
        ("glint", glint::cases()),
        ("glint_binomial", glint_binomial::cases()),
        ("glint_chance", glint_chance::cases()),
        ("glint_field", glint_field::cases()),
        ("moments", moments::cases()),
        ("ndf", ndf::cases()),
        ("roughness", roughness::cases()),
        ("shading", shading::cases()),
    ]
}
