//! A query, and the same in units of flakes.

use glam::{DMat2, DVec2, DVec3};

use super::chart::Macro;
use super::footprint::{BIWEIGHT_AREA, Ellipse};
use super::light::{Light, SolidAngle};

/// Flakes per unit of area of the coordinates that queries use (uv), more than 0.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct FlakeDensity(pub f64);

/// Scratches: flakes in cells that are compressed across a direction, as Zirr & Kaplanyan 2016 do it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Streak {
    /// Length over width, 1 or more: the ratio of the widths of the lobe that is scratched so.
    pub ratio: f64,
    /// Direction of the long side, radians from u towards v.
    pub angle: f64,
}

/// A material's flakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flakes {
    /// How many.
    pub density: FlakeDensity,
    /// Of half vectors that a flake answers by its own roughness ([`SolidAngle::of_flake`]).
    pub lobe: SolidAngle,
    /// Another seed, another surface.
    pub seed: u32,
    /// Standard deviation of the flakes' areas over their mean, 0 to 3.
    pub size_variation: f64,
    /// Share of the density that is there, 0 to 1, where a map thins the flakes out. The fewer that are left answer the more
    /// strongly, so that the mean stays; below [`Flakes::LEAST_SHARE`] they get no sparser.
    pub share: f64,
    /// Share of the surface that flakes cover, more than 0, at most 1: the size at which close-ups show them.
    pub coverage: f64,
    /// Set for scratches.
    pub streak: Option<Streak>,
}

impl Flakes {
    /// See [`Flakes::share`].
    pub const LEAST_SHARE: f64 = 1e-3;

    /// Round flakes of equal size that cover the surface.
    pub fn new(density: FlakeDensity, lobe: SolidAngle, seed: u32) -> Self {
        Self { density, lobe, seed, size_variation: 0.0, share: 1.0, coverage: 1.0, streak: None }
    }

    /// Squared variation of what the flakes of cells answer: their sizes, and whether they are there. Flakes that are
    /// there by chance `share`, and so count `1 / share`, have variation `1 / share - 1`; both chances multiply.
    pub fn variation2(&self) -> f64 {
        let variation = self.size_variation.clamp(0.0, 3.0);
        (1.0 + variation * variation) / self.share.clamp(Self::LEAST_SHARE, 1.0) - 1.0
    }

    /// Surface coordinates to cells: one flake each. Areas keep their ratio.
    pub fn to_cells(&self) -> DMat2 {
        let scale = self.density.0.sqrt();
        let Some(Streak { ratio, angle }) = self.streak else { return DMat2::from_diagonal(DVec2::splat(scale)) };
        let root = ratio.max(1.0).sqrt();
        DMat2::from_diagonal(DVec2::new(scale / root, scale * root)) * DMat2::from_angle(-angle)
    }
}

/// What a pixel asks: who, where, and which light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Coordinates on the surface.
    pub uv: DVec2,
    /// Columns: their change along the screen's x and y, per pixel. Taken as it is given, so that compute shaders and
    /// ray tracers can ask too.
    pub jacobian: DMat2,
    /// Half vector, of any length, tangent frame, z out of the surface.
    pub h: DVec3,
    /// The smooth lobe.
    pub lobe: Macro,
    /// Its flakes.
    pub flakes: Flakes,
    /// The light.
    pub light: Light,
}

/// A query in units of flakes: cells of one flake each, and the square in which their normals are uniform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Place in cells; the net repeats after [`Probe::PERIOD`], counts in wider cells do not.
    pub at: DVec2,
    /// The pixel's kernel, cells squared.
    pub kernel: Ellipse,
    /// Direction in the chart, 0 to 1.
    pub y: DVec2,
    /// Effective area of the flakes that answer, share of all: [`Probe::LEAST_AREA`] to [`Probe::MOST_AREA`].
    pub area: f64,
    /// The half vector on an equal-area map of the hemisphere, in widths of the lobe that answers: the scale at which
    /// glints come and go.
    pub widths: DVec2,
    /// Of the flakes.
    pub seed: u32,
    /// Squared variation of the flakes' sizes.
    pub variation2: f64,
}

impl Probe {
    /// Cells after which everything repeats, along both axes.
    pub const PERIOD: f64 = 4_294_967_296.0;

    /// The smallest share: rarer answers are told apart no finer.
    pub const LEAST_AREA: f64 = 1e-9;

    /// The largest share: the kernel over directions then just does not overlap itself.
    pub const MOST_AREA: f64 = 0.25 * BIWEIGHT_AREA;

    /// Effective number of answering flakes: effective area of the footprint times that of the directions.
    pub fn n_eff(&self) -> f64 {
        self.kernel.area() * self.area
    }

    /// Radius of the kernel over directions.
    pub fn radius(&self) -> f64 {
        (self.area / BIWEIGHT_AREA).sqrt()
    }
}

impl Query {
    /// The query in units of flakes. None where g is 1: nothing finite to ask, or no flakes.
    pub fn probe(&self) -> Option<Probe> {
        let (flakes, h) = (&self.flakes, self.h.try_normalize()?);
        let of_flakes = [flakes.density.0, flakes.lobe.0, flakes.size_variation, flakes.share, flakes.coverage];
        let of_light = [self.light.solid_angle.0, self.light.l_dot_h];
        if !(h.z > 0.0 && self.uv.is_finite() && of_flakes.iter().chain(&of_light).all(|v| v.is_finite())) {
            return None;
        }
        let to_cells = flakes.to_cells();
        if !(flakes.density.0 > 0.0 && to_cells.is_finite()) {
            return None;
        }
        let size = (flakes.coverage.clamp(1e-6, 1.0) / BIWEIGHT_AREA).sqrt();
        let kernel = Ellipse::of_pixel(to_cells * self.jacobian, size)?;
        let (y, density) = self.lobe.chart()?.square_and_density(h);
        let omega = self.light.half_vectors(flakes.lobe).0;
        let area = (density * omega).clamp(Probe::LEAST_AREA, Probe::MOST_AREA);
        let at = to_cells * self.uv;
        let at = at - Probe::PERIOD * (at / Probe::PERIOD).round();
        let widths = DVec2::new(h.x, h.y) * (2.0 / (1.0 + h.z) / omega.max(Probe::LEAST_AREA)).sqrt();
        if !(y.is_finite() && area.is_finite() && at.is_finite() && widths.is_finite()) {
            return None;
        }
        Some(Probe { at, kernel, y, area, widths, seed: flakes.seed, variation2: flakes.variation2() })
    }
}
