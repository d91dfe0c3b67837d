//! A footprint becomes a lobe: the list of folds, and the one loop over levels ([`chain`]).
//!
//! A fold is a value in [`FOLDS`]. The command line, its help, the law tests, the benches and the README's table
//! all walk that list: a new method is one file here and one line in it.

mod average;
mod bump_to_roughness;
mod chain;
mod clean;
mod curvature;
pub mod fit;
mod ggx;
mod ggx_lobe;
mod lean;
mod level;
mod projected;
mod rows;
mod sggx;
mod shape;
mod slots;
mod toksvig;
mod vmf;

pub use chain::{Chain, Options, chain, chain_telling};
pub use level::Level;
pub use rows::{LobeRow, MomentRow};
pub use shape::{Tail, best_student};

use crate::error::{Error, Result};
use crate::moments::{Moments, Needs, plane};
use crate::ndf::{Form, Lobe, SlopeLobe};
use crate::roughness::Alpha;
use crate::summary::{self, Entry};

/// A way to replace a footprint by one lobe.
pub struct Fold {
    /// Name on the command line and in reports.
    pub name: &'static str,
    /// Paper and equation.
    pub cite: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// How it works.
    pub method: Method,
}

/// How a fold works.
pub enum Method {
    /// From moments of the footprint.
    Moments(MomentFold),
    /// From its lobes.
    Lobes {
        /// Most lobes that a footprint is summarised by.
        most: usize,
        /// Whether it can give several lobes a texel.
        mixtures: bool,
        /// Whether it searches texel by texel, and takes minutes where others take seconds.
        slow: bool,
        /// Fits lobes to footprints.
        fit: fit::Fit,
    },
}

/// Folds rows of moments.
pub struct MomentFold {
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
    ggx::FOLD,
    ggx_lobe::FOLD,
];

/// The fold that is used when none is named.
pub static DEFAULT_FOLD: &Fold = &ggx::FOLD;

/// Lobes by which a single footprint is summarised; searches may look at all pairs.
const MOST_ENTRIES: usize = 256;

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

    /// Whether the method defines lobes of two widths.
    pub fn has_two_widths(&self) -> bool {
        !matches!(self.method, Method::Moments(MomentFold { anisotropic: None, .. }))
    }

    /// Whether it takes minutes where others take seconds: for final assets, and not among all folds unless it is named.
    pub fn is_slow(&self) -> bool {
        matches!(self.method, Method::Lobes { slow: true, .. })
    }

    /// Whether it can give several lobes a texel.
    pub fn has_mixtures(&self) -> bool {
        matches!(self.method, Method::Lobes { mixtures: true, .. })
    }

    /// Whether it searches, from the footprint's lobes, and is not a formula of moments.
    pub fn searches(&self) -> bool {
        matches!(self.method, Method::Lobes { .. })
    }

    /// Whether it widens the mean base lobe, by an amount that can be scaled.
    fn widens(&self) -> bool {
        !matches!(&self.method, Method::Moments(fold) if !fold.needs.has(plane::TENSOR))
    }

    /// The lobe of one footprint, given as lobes with their areas, its width not yet clamped to 0..1.
    pub fn lobe(&self, footprint: &[(Lobe, f32)], form: Form) -> Lobe {
        let moments = |(lobe, area): &(Lobe, f32)| {
            let perceptual = Alpha::from_squared(lobe.roughness.mean()).perceptual().0;
            Moments::texel(*area, lobe.normal, perceptual, lobe.roughness)
        };
        let moments: Moments = footprint.iter().map(moments).sum();
        match &self.method {
            Method::Moments(fold) => rows::one(fold.rows(form), &moments),
            Method::Lobes { fit, .. } => {
                let entry = |(lobe, weight): &(Lobe, f32)| Entry { weight: *weight, lobe: SlopeLobe::new(lobe) };
                let mut entries: Vec<Entry> = footprint.iter().map(entry).collect();
                summary::merge_to(&mut entries, MOST_ENTRIES, &mut summary::Scratch::default());
                fit::one(*fit, fit::Shape { form, shared_normal: false }, 1, &entries, rows::unit(moments.normal()))[0]
                    .0
            }
        }
    }
}

impl MomentFold {
    /// The function for a form; the isotropic one where the method has no other.
    fn rows(&self, form: Form) -> fn(&MomentRow, &mut LobeRow) {
        match (form, self.anisotropic) {
            (Form::Anisotropic, Some(anisotropic)) => anisotropic,
            _ => self.isotropic,
        }
    }
}

#[cfg(test)]
mod tests;
