//! What a normal distribution is: the [`Ndf`] trait, the GGX [`Lobe`], its [`RoughnessTensor`] and Smith terms; and the
//! lobes of other tails, [`Beckmann`] and [`Student`].
//!
//! | lobe | slopes | falls like | mean slope | slope variance |
//! |---|---|---|---|---|
//! | [`Lobe`], GGX | bivariate Student-t of 2 degrees of freedom | `s^-4` | finite | infinite |
//! | [`Beckmann`] | Gaussian | `exp(-s^2 / alpha^2)` | finite | `alpha^2 / 2` |
//! | [`Student`] | bivariate Student-t, [`TailExponent`] gamma | `s^(-2 gamma)` | for gamma over 3/2 | for gamma over 2 |
//!
//! They differ in three functions of a round lobe of unit width; widths, directions, sampling and Smith's masking are
//! shared ([`ShapeInvariant`]). Textures hold GGX lobes, since that is what engines shade; the others say what that
//! costs ([`crate::fold::best_student`]).

mod beckmann;
#[cfg(test)]
pub(crate) mod disk;
mod frame;
mod lobe;
mod lobes;
mod readout;
mod shape;
pub(crate) mod slopes;
mod student;
mod tensor;
#[cfg(test)]
mod tests;

pub use beckmann::Beckmann;
pub use frame::{Frame, bent_from_transported};
pub use lobe::Lobe;
pub use lobes::{Form, Lobes, MOST_LOBES, are_shares, lobes_in_words};
pub use readout::{BURLEY_LEAST_RATIO, Burley, Gltf, TensorRoot};
pub use shape::ShapeInvariant;
pub use slopes::SlopeLobe;
pub use student::{Student, TailExponent};
pub use tensor::{Axes, RoughnessTensor};

use glam::DVec3;

/// A distribution of microfacet normals over the hemisphere about z.
///
/// Evaluated in f64, so that references can be built on it.
pub trait Ndf {
    /// Density D(m) in the sense of microfacet theory: normalised to `integral D(m) (m . n) dm = 1` about the
    /// distribution's own macroscopic normal n. `m` is unit; 1/sr.
    fn d(&self, m: DVec3) -> f64;

    /// A unit normal drawn with density [`Ndf::pdf`], from two uniform numbers in 0..1.
    fn sample(&self, u: [f64; 2]) -> DVec3;

    /// Solid-angle density of [`Ndf::sample`], `D(m) (m . n)`; integrates to 1.
    fn pdf(&self, m: DVec3) -> f64;
}
