//! What a normal distribution is: the [`Ndf`] trait, the GGX [`Lobe`], its [`RoughnessTensor`] and Smith terms.

mod frame;
mod lobe;
mod lobes;
mod readout;
mod tensor;

pub use frame::{Frame, bent_from_transported};
pub use lobe::Lobe;
pub use lobes::{Form, Lobes, MOST_LOBES};
pub use readout::{BURLEY_LEAST_RATIO, Burley, Gltf, TensorRoot};
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
