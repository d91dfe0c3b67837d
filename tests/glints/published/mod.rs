//! Published evaluators of glints, as a reference that the library's own are compared with.
//!
//! Each is written anew from its formulas, with the traits that its authors published, the unfortunate ones too: they are
//! what is measured. Three things are the same for all, so that only the method is judged:
//!
//! - chance is [`pcg4d`] of integers, not the sines, textures and bits of floats of the released shaders, whose repetitions
//!   would count against them;
//! - all is f64, so powers such as `(1 - p)^N` keep their digits;
//! - a pixel means the same. The filters differ (a box, a simplex's cell, a Gaussian), and each is scaled to the effective
//!   area `1 / integral W^2` that the library's kernel has over the same pixel ([`Published::jacobian_of`]). Likewise, a
//!   flake's lobe has the same effective share of all flakes, `D(h) cos(h)` times its solid angle, for all.
//!
//! So all of them see the same expected number of flakes, N_eff, in the same blur.

pub mod cases;
pub mod deliot;
pub mod kemppinen;
pub mod zirr;

use glam::{DMat2, DVec2, DVec3};
use mipfold::glint::{
    BIWEIGHT_AREA, Evaluator, FlakeDensity, Flakes, Light, Macro, Query, SUPPORT2, SolidAngle, Tail, glint_ratio,
};
use mipfold::roughness::Alpha;

/// What a pixel asks of a method.
#[derive(Clone, Copy, Debug)]
pub struct Published {
    /// Place, uv.
    pub at: DVec2,
    /// Columns: change of uv along the screen's x and y, per pixel.
    pub jacobian: DMat2,
    /// Unit half vector, tangent frame.
    pub h: DVec3,
    /// Width of the smooth lobe.
    pub alpha: Alpha,
    /// Its tail: each method has its own ([`Contender::tail`]).
    pub tail: Tail,
    /// Flakes per unit of area of uv.
    pub density: f64,
    /// Effective solid angle of half vectors that a flake answers, sr.
    pub flake: f64,
    /// Of the surface.
    pub seed: u32,
}

impl Published {
    /// The smooth lobe.
    pub fn lobe(&self) -> Macro {
        Macro { tail: self.tail, ..Macro::isotropic(self.alpha) }
    }

    /// Share of all flakes that answer, `D(h) cos(h)` times their solid angle.
    pub fn share(&self) -> f64 {
        self.lobe().chart().map_or(0.0, |chart| chart.density(self.h)) * self.flake
    }

    /// The Jacobian for a filter that has an effective area of `area` pixels: scaled, so that its area over the surface is
    /// that of the library's kernel, `BIWEIGHT_AREA * SUPPORT2` or 3.49 pixels.
    pub fn jacobian_of(&self, area: f64) -> DMat2 {
        self.jacobian * (BIWEIGHT_AREA * SUPPORT2 / area).sqrt()
    }

    /// The same query for the library. Flakes are points, as elsewhere: the least coverage.
    pub fn query(&self) -> Query {
        let flakes =
            Flakes { coverage: 1e-6, ..Flakes::new(FlakeDensity(self.density), SolidAngle(self.flake), self.seed) };
        let light = Light::new(SolidAngle(0.0), 1.0);
        Query { uv: self.at, jacobian: self.jacobian, h: self.h, lobe: self.lobe(), flakes, light }
    }
}

/// A published method, or one of the library's.
pub enum Method {
    /// The ratio of estimate and smooth lobe, which should have mean 1.
    Published(fn(&Published) -> f64),
    /// By the name of an evaluator.
    Own(&'static Evaluator),
}

/// A row of the comparison.
pub struct Contender {
    /// Name in tables.
    pub name: &'static str,
    /// The smooth lobe that it is made for.
    pub tail: Tail,
    /// How it finds the ratio.
    pub method: Method,
}

impl Contender {
    /// All of them: those published, then the library's.
    pub fn all() -> Vec<Self> {
        let published = |name, tail, ratio| Self { name, tail, method: Method::Published(ratio) };
        let own = |name| {
            let evaluator = mipfold::glint::evaluator(name).expect("the library's evaluators keep their names");
            Self { name, tail: Tail::Ggx, method: Method::Own(evaluator) }
        };
        vec![
            published("Zirr & Kaplanyan 2016", Tail::Beckmann, zirr::ratio),
            published("Deliot & Belcour 2023", Tail::Ggx, deliot::ratio),
            published("Kemppinen et al. 2025", Tail::Ggx, kemppinen::ratio),
            own("field"),
            own("binomial"),
        ]
    }

    /// The ratio of a query.
    pub fn ratio(&self, query: &Published) -> f64 {
        match self.method {
            Method::Published(ratio) => ratio(query),
            Method::Own(evaluator) => glint_ratio(evaluator, &query.query()),
        }
    }
}
