//! A pixel's flakes one by one: the same flakes for all lights, and places to sample.

use glam::DVec2;

use super::field::{Weights, even_variance, peak};
use super::footprint::BIWEIGHT_AREA;
use super::net::{Cell, Net};
use super::probe::Probe;

/// A flake under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatheredFlake {
    /// Its cell; [`Net::flake`] has the rest of it.
    pub cell: Cell,
    /// From the pixel's centre, in cells.
    pub offset: DVec2,
    /// Direction in the chart; [`super::Chart::normal`] makes a normal of it.
    pub y: DVec2,
    /// Uniform in 0..1, for its size.
    pub mark: f64,
    /// The pixel's kernel at the flake over the kernel's peak, 0 to 1.
    pub weight: f64,
}

/// The flakes of a pixel.
#[derive(Clone, Debug)]
pub struct Gathered {
    /// In rows of cells from below.
    pub flakes: Vec<GatheredFlake>,
    probe: Probe,
}

/// The flakes under a pixel, whatever the light; none if there are more than `most`. For close-ups: a few flakes.
pub fn gather(p: &Probe, most: usize) -> Option<Gathered> {
    // The kernel's area is the number of flakes under it.
    if std::f64::consts::PI * p.kernel.determinant().sqrt() > 2.0 * most as f64 + 64.0 {
        return None;
    }
    let (net, inverse, home) = (Net::new(p.seed, 0), p.kernel.inverse(), p.at.floor());
    let own = p.at - home;
    let mut flakes = Vec::new();
    p.kernel.rows(own, 1.0, |j, first, last| {
        for i in first..=last {
            let cell = [(home.x as i64 + i) as i32, (home.y as i64 + j) as i32];
            let flake = net.flake(cell);
            let offset = DVec2::new(i as f64, j as f64) + flake.place - own;
            let rest = 1.0 - inverse.of(offset);
            if rest > 0.0 {
                flakes.push(GatheredFlake { cell, offset, y: flake.y, mark: flake.mark, weight: rest * rest });
            }
        }
    });
    (flakes.len() <= most).then_some(Gathered { flakes, probe: *p })
}

impl Gathered {
    /// The ratio for any half vector and light at this pixel, from its direction in the chart and its area
    /// ([`Probe::y`], [`Probe::area`]): what the reference evaluator gives.
    pub fn ratio(&self, y: DVec2, area: f64) -> f64 {
        let probe = Probe { y, area, ..self.probe };
        self.shares(&probe).sum()
    }

    /// What each flake adds to the ratio.
    pub fn shares<'a>(&'a self, probe: &Probe) -> impl Iterator<Item = f64> + 'a {
        let probe = Probe { kernel: self.probe.kernel, ..*probe };
        let weights = Weights::new(1.0 + probe.variation2 - even_variance(probe.n_eff(), probe.kernel.anisotropy()));
        let (radius2, peak) = (probe.area / BIWEIGHT_AREA, peak(probe.kernel, probe.radius()));
        self.flakes.iter().map(move |flake| {
            let d = flake.y - probe.y;
            let rest = (1.0 - (d - d.round()).length_squared() / radius2).max(0.0);
            flake.weight * rest * rest * peak * weights.of(flake.mark)
        })
    }

    /// A flake drawn in proportion to its weight under the pixel, from a uniform u in 0..1, and its chance: sample the
    /// flake's own lobe about its normal then. None if the pixel has no flake.
    pub fn sample(&self, u: f64) -> Option<(&GatheredFlake, f64)> {
        let all: f64 = self.flakes.iter().map(|f| f.weight).sum();
        let mut rest = u * all;
        let mut chosen = None;
        for flake in &self.flakes {
            chosen = Some((flake, flake.weight / all));
            rest -= flake.weight;
            if rest < 0.0 {
                break;
            }
        }
        chosen
    }
}
