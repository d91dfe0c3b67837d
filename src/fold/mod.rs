//! A footprint becomes a lobe: the list of folds, and the one loop over levels ([`chain`]).
//!
//! A fold is a value in [`FOLDS`]. The command line, its help, the law tests, the benches and the README's table
//! all walk that list: a new method is one file here and one line in it.

mod average;
mod bump_to_roughness;
mod chain;
mod clean;
mod lean;
mod level;
mod projected;
mod rows;
mod sggx;
mod shape;
mod toksvig;
mod vmf;

pub use chain::{Chain, Options, chain};
pub use level::Level;
pub use rows::{LobeRow, MomentRow};
pub use shape::{Tail, best_student};

use crate::error::{Error, Result};
use crate::moments::{Moments, Needs};
use crate::ndf::{Form, Lobe};

/// A way to replace a footprint by one lobe.
pub struct Fold {
    /// Name on the command line and in reports.
    pub name: &'static str,
    /// Paper and equation.
    pub cite: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// The moments that it reads.
    pub needs: Needs,
    /// Folds a row of footprints to lobes of one width.
    pub isotropic: fn(&MomentRow, &mut LobeRow),
    /// Folds a row of footprints to lobes of two widths, where the method defines them.
    pub anisotropic: Option<fn(&MomentRow, &mut LobeRow)>,
}

/// Every fold.
pub static FOLDS: &[Fold] = &[
    average::FOLD,
    toksvig::FOLD,
    vmf::FOLD,
    clean::FOLD,
    lean::FOLD,
    bump_to_roughness::FOLD,
    projected::FOLD,
    sggx::FOLD,
];

/// The fold that is used when none is named.
pub static DEFAULT_FOLD: &Fold = &projected::FOLD;

impl Fold {
    /// The fold of this name.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the list of names.
    pub fn by_name(name: &str) -> Result<&'static Fold> {
        FOLDS.iter().find(|fold| fold.name == name).ok_or_else(|| {
            let names: Vec<_> = FOLDS.iter().map(|fold| fold.name).collect();
            Error::invalid_option("--fold", format!("'{name}'"), format!("one of {}", names.join(", ")))
        })
    }

    /// The function for a form; the isotropic one where the method has no other.
    pub fn rows(&self, form: Form) -> fn(&MomentRow, &mut LobeRow) {
        match (form, self.anisotropic) {
            (Form::Anisotropic, Some(anisotropic)) => anisotropic,
            _ => self.isotropic,
        }
    }

    /// The lobe of one footprint, its width not yet clamped to 0..1.
    pub fn lobe(&self, moments: &Moments, form: Form) -> Lobe {
        rows::one(self.rows(form), moments)
    }
}

#[cfg(test)]
mod tests;
