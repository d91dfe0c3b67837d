//! Procedural flakes: what a pixel sees of a surface that is made of countless small mirrors.
//!
//! A smooth lobe D is the mean of its flakes. A pixel that sees few of them glints: [`Evaluator`]s give the ratio g by
//! which the flakes in the pixel's footprint answer a light, to be shaded as `D(h) * g`. The mean of g is 1 for any lobe,
//! footprint and light, so that glints neither brighten nor darken a material, and g tends to 1 where many flakes are
//! seen.
//!
//! The variance of g is that of independent flakes, `1 / N_eff`: the expected number of answering flakes, in effective
//! areas ([`Probe::n_eff`]). A variance times N_eff is called normalised here, V*, and should be 1 (or 1 plus the squared
//! variation of the flakes' sizes).
//!
//! Two lights at once: the correlation of their ratios at one pixel, where no flake answers both, is within 0.006 of 0 for
//! lobes that take 0.4 percent of the chart, with either evaluator, and for lobes of 3 percent -0.021 for the field and 0.002 for
//! the counts (within 0.002; `tests/lights.rs`). What the field has below 0 is the lobe's share of all directions: a flake
//! that answers one light does not answer the other. Lobes right beside each other, two radii apart, correlate by -0.02 to
//! -0.04 in the field, which is evenly filled, and by up to 0.05 in the counts (`tests/glints.rs`). Published counts that take the
//! absolute slope show each glint again for the mirrored half vector.
//!
//! What to expect when things move. Glints of the field fade in and out where they are, make no lines and no lattice on
//! curved surfaces, and keep apart: they look a little more even than independent flakes. Where more than 1.5 flakes answer,
//! sparser nets stand for them, and as a pixel's number of flakes grows by a factor of four, glints dissolve into those of the
//! next. Counts dissolve so at every doubling of the distance, for any number, reach over one pixel, and have no places of
//! their own. Close-ups show flakes as soft round disks (streaks: ellipses), never their edges.
//!
//! | file | what is there |
//! |---|---|
//! | `hash` | integers to integers: the only source of chance |
//! | `gauss`, `count` | normal quantile and error function; counts by inversion |
//! | `chart`, `light`, `footprint` | the areas that count: lobe, solid angles, pixel |
//! | `probe` | a query in units of flakes |
//! | `net` | one flake per cell, such that all levels of place and direction are evenly filled |
//! | `field` | sums over the net's flakes without levels of detail |
//! | `binomial` | counts in cells, after Zirr & Kaplanyan 2016 |
//! | `gather` | the flakes of a pixel one by one, for several lights and for sampling |
//! | `brute` | the truths: enumeration of the net, and independent flakes |
//! | `texels` | no flakes, but the texels of a normal map close up |
//!
//! Everything is f64 here; nothing but the sums needs it. Wherever a float is rounded down to a cell, the weight of what
//! could be missed is 0 (the field), or a mean is mixed across (the counts), so that processors may round differently.

mod binomial;
pub mod brute;
mod chart;
mod count;
mod field;
mod footprint;
mod gather;
mod gauss;
mod hash;
mod light;
mod net;
mod probe;
#[cfg(test)]
#[allow(clippy::print_stdout, clippy::type_complexity, reason = "tables of figures")]
mod tests;
pub mod texels;

pub use chart::{Chart, Macro, Tail};
pub use count::{SmoothPoisson, binomial, ln_one_minus, poisson};
pub use footprint::{BIWEIGHT_AREA, Ellipse, Inverse, MOST_ANISOTROPY, SUPPORT2};
pub use gather::{Gathered, GatheredFlake, gather};
pub use gauss::{erf, erfc, normal_quantile};
pub use hash::{fifth, pcg4d, unit};
pub use light::{Light, SolidAngle};
pub use net::{DEPTH, Flake, Net};
pub use probe::{FlakeDensity, Flakes, Probe, Query, Streak};

/// A way to find the ratio of a pixel.
pub struct Evaluator {
    /// Name on command lines and in reports.
    pub name: &'static str,
    /// Where it is from.
    pub cite: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// The ratio of a query in units of flakes: finite, 0 or more, mean 1.
    pub ratio: fn(&Probe) -> f64,
}

/// All of them; the first is the one to use.
pub static EVALUATORS: &[Evaluator] = &[
    Evaluator {
        name: "field",
        cite: "original; nets after Niederreiter 1987, scrambling after Owen 1995",
        about: "the pixel's own flakes, one per cell: up to 1.5 that answer without levels of detail, sparser ones for more",
        ratio: field::ratio,
    },
    Evaluator {
        name: "binomial",
        cite: "Zirr & Kaplanyan 2016, corrected",
        about: "counts in a grid of cells with levels of detail, calibrated to the variance of independent flakes",
        ratio: binomial::ratio,
    },
    Evaluator {
        name: "reference",
        cite: "enumeration of the field's flakes",
        about: "every flake under the pixel, one by one; slow",
        ratio: brute::ratio,
    },
];

/// The evaluator with this name.
pub fn evaluator(name: &str) -> Option<&'static Evaluator> {
    EVALUATORS.iter().find(|e| e.name == name)
}

/// The ratio g of a pixel, 0 or more, with mean 1: the glinting lobe is `D(h) * g`.
///
/// 1 where flakes cannot be told apart or nothing is known: more than 1e4 effective flakes, a half vector below the
/// surface, numbers that are not finite.
pub fn glint_ratio(evaluator: &Evaluator, query: &Query) -> f64 {
    query.probe().map_or(1.0, |probe| (evaluator.ratio)(&probe))
}
