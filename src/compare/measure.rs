//! One texel: the questions to put to its footprint and to the chains' lobes, and what the answers say.
//!
//! Every integral is a mean over drawn half vectors, so that lobes of any width are met where they are. For each chain
//! two kinds count, weighted together by how densely both fall (Veach & Guibas 1995, balance heuristic): those drawn
//! from the footprint, which all chains share, and those drawn from the chain's own lobe. The figures of a chain so
//! depend on no other chain. Both sides are evaluated exactly at each.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DQuat, DVec3};

use crate::random::{Random, Spread};
use crate::reference::{Diffuse, Footprint, Means, Queries};

/// From which the lobe error is seen: degrees from the normal and around it. Two for each slant, so that what leans
/// along u and along v counts alike.
pub const VIEWS: [(f64, f64); 5] = [(0.0, 0.0), (30.0, 0.0), (30.0, 90.0), (60.0, 180.0), (60.0, 270.0)];

/// Radius of the round light, degrees.
pub const LIGHT_RADIUS: f64 = 5.0;

/// Places on the round light at which it is evaluated. They resolve lobes of alpha 0.03 and wider; narrower ones seem
/// further from the truth than they are.
const LIGHT_PLACES: usize = 12;

/// Lights of the diffuse term, spread evenly over the hemisphere.
const DIFFUSE_LIGHTS: usize = 256;

/// Directions drawn for each view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    /// Half vectors from the footprint.
    shared: usize,
    /// Half vectors from each chain's lobe.
    own: usize,
    /// Middles of the round light, from each of them.
    lights: usize,
}

impl Counts {
    /// About `directions` half vectors from the footprint over all views. A chain's lobe, which is simpler, gets half as
    /// many; the round light, whose every place costs as much as a half vector, a sixteenth.
    pub fn new(directions: usize) -> Self {
        let shared = directions.div_ceil(VIEWS.len()).max(2);
        Self { shared, own: shared.div_ceil(2), lights: (shared / 16).max(1) }
    }

    /// Half vectors for a footprint judged with `chains` chains.
    pub fn queries(self, chains: usize) -> usize {
        VIEWS.len() * (self.shared + chains * self.own + (1 + chains) * self.lights * LIGHT_PLACES)
    }
}

/// The unit vectors of [`VIEWS`].
pub(super) fn views() -> [DVec3; 5] {
    VIEWS.map(|(slant, around)| {
        let ((sin, cos), (y, x)) = (slant.to_radians().sin_cos(), around.to_radians().sin_cos());
        DVec3::new(sin * x, sin * y, cos)
    })
}

/// Lights for the diffuse term: a spiral with equal steps of z (equal areas) and of the golden angle.
pub(super) fn diffuse_lights() -> Diffuse {
    let golden = TAU * (1.0 - 1.0 / ((1.0 + 5f64.sqrt()) / 2.0));
    let light = |i: usize| {
        let z = (i as f64 + 0.5) / DIFFUSE_LIGHTS as f64;
        let (sin, cos) = (i as f64 * golden).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    };
    Diffuse::new(&(0..DIFFUSE_LIGHTS).map(light).collect::<Vec<_>>())
}

/// The questions for one texel.
pub(super) struct Questions {
    pub queries: Queries,
    counts: Counts,
    chains: usize,
}

impl Questions {
    /// All chains are drawn from by the same random numbers, `random[1]`, and the footprint by `random[0]`, so that a
    /// chain is asked the same whatever stands beside it.
    pub fn new(truth: &Footprint, chains: &[Footprint], counts: Counts, random: [Random; 2]) -> Self {
        let mut queries = Queries::default();
        let [first, others] = random;
        let streams = std::iter::once(first).chain(std::iter::repeat(others));
        let mut sources: Vec<_> = std::iter::once(truth)
            .chain(chains)
            .zip(streams)
            .map(|(source, mut random)| (source, Spread::new(&mut random), random))
            .collect();
        for view in views() {
            queries.start_view(view);
            for (i, (source, spread, _)) in sources.iter_mut().enumerate() {
                for _ in 0..if i == 0 { counts.shared } else { counts.own } {
                    queries.push_half(source.draw(spread.point()));
                }
            }
            for (source, spread, random) in &mut sources {
                for _ in 0..counts.lights {
                    let m = source.draw(spread.point());
                    let mirrored = 2.0 * view.dot(m) * m - view;
                    // A place on the light shall lie there: its middle is anywhere around. What faces away from the
                    // view mirrors no light to it, and counts as one from below the surface.
                    let around = on_light(mirrored, random.uniform(), random.uniform());
                    let middle = if view.dot(m) > 0.0 { around } else { DVec3::NEG_Z };
                    let turn = random.uniform();
                    for k in 0..LIGHT_PLACES {
                        let golden = 0.618_033_988_749_894_8 * k as f64;
                        queries.push_light(on_light(middle, (k as f64 + 0.5) / LIGHT_PLACES as f64, turn + golden));
                    }
                }
            }
        }
        Self { queries, counts, chains: chains.len() }
    }

    /// Part of the half vectors of view `view` that chain `chain` is judged by: from the footprint, and its own.
    fn halves(&self, view: usize, chain: usize) -> impl Iterator<Item = usize> + use<> {
        let Counts { shared, own, .. } = self.counts;
        let start = view * self.counts.queries(self.chains) / VIEWS.len();
        let first = start + shared + chain * own;
        (start..start + shared).chain(first..first + own)
    }

    /// The round lights of view `view` that chain `chain` is judged by.
    fn lights(&self, view: usize, chain: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let Counts { shared, own, lights } = self.counts;
        let start = view * self.counts.queries(self.chains) / VIEWS.len() + shared + self.chains * own;
        let first = (1 + chain) * lights;
        let range = move |i: usize| start + i * LIGHT_PLACES..start + (i + 1) * LIGHT_PLACES;
        (0..lights).chain(first..first + lights).map(range)
    }

    /// What the answers `truth` and `own` say of chain `chain`. Distances are taken over half of what both sides hold
    /// together, so that they end at 1 or 2 even where one side reflects next to nothing.
    pub fn figures(&self, truth: &Means, own: &Means, chain: usize) -> Figures {
        let Counts { shared, own: drawn, .. } = self.counts;
        let share = shared as f64 / (shared + drawn) as f64;
        let density = |j: usize| share * truth.pdf[j] + (1.0 - share) * own.pdf[j];
        // Lights come from as many of the truth's as of the chain's.
        let light_density = |j: usize| 0.5 * (truth.pdf[j] + own.pdf[j]);
        // What no lobe can draw says nothing.
        let over = |v: f64, density: f64| if density > 0.0 { v / density } else { 0.0 };
        let [mut tv, mut hellinger, mut kl] = [const { Vec::new() }; 3];
        let [mut lobe, mut energy, mut compensated, mut light] = [const { Vec::new() }; 4];
        let mut view_energy = [[0.0; 2]; VIEWS.len()];
        for (i, view) in views().into_iter().enumerate() {
            let [mut seen, mut reflected, mut reflected_all, mut lit] = [const { Vec::new() }; 4];
            for j in self.halves(i, chain) {
                let (m, density) = (self.queries.half(j), density(j));
                let projected = over(m.z.max(0.0), density);
                let (p, q) = (truth.d[j].max(0.0), own.d[j].max(0.0));
                let both = 0.5 * (p + q) * projected;
                tv.push([0.5 * (p - q).abs() * projected, both]);
                hellinger.push([0.5 * (p.sqrt() - q.sqrt()).powi(2) * projected, both]);
                // Below its own horizon a lobe has no facets at all; of that sliver no finite divergence can be told.
                let shared = p > 0.0 && q > 0.0;
                kl.push([if shared { (p * (p / q).ln() - p + q) * projected } else { 0.0 }, p * projected]);
                // dl = 4 (v.h) dh.
                let spread = over(4.0 * view.dot(m).max(0.0), density);
                let (f_ref, f) = (truth.specular[j] * spread, own.specular[j] * spread);
                seen.push([(f - f_ref).abs(), 0.5 * (f + f_ref)]);
                reflected.push([f, f_ref]);
                reflected_all.push([own.compensated[j] * spread, truth.compensated[j] * spread]);
            }
            let count = reflected.len() as f64;
            view_energy[i] = [0, 1].map(|k| reflected.iter().map(|draw| draw[k]).sum::<f64>() / count);
            for places in self.lights(i, chain) {
                let mean = |f: &dyn Fn(usize) -> f64| places.clone().map(f).sum::<f64>();
                // Density of lights, at which their middles are spread too.
                let density = mean(&|j| light_density(j) / (4.0 * view.dot(self.queries.half(j))));
                lit.push([over(mean(&|j| own.specular[j] - truth.specular[j]).abs(), density), 0.0]);
            }
            lobe.push(seen);
            energy.push(reflected);
            compensated.push(reflected_all);
            light.push(lit);
        }
        let hellinger2 = ratio(&[hellinger], 0.0);
        let sum = |f: &dyn Fn(f64, f64) -> f64| {
            truth.diffuse.iter().zip(&own.diffuse).map(|(truth, own)| f(*truth, *own)).sum::<f64>()
        };
        Figures {
            light: over_total(&light, &lobe),
            lobe: ratio(&lobe, 0.0),
            tv: ratio(&[tv], 0.0),
            // The variance of a root: that of the square over four times the square.
            hellinger: (hellinger2.0.sqrt(), over(hellinger2.1, 4.0 * hellinger2.0)),
            kl: ratio(&[kl], 0.0),
            // Of what neither shows, all is kept.
            energy: ratio(&energy, 1.0),
            compensated: ratio(&compensated, 1.0),
            diffuse: (sum(&|truth, own| (own - truth).abs()) / sum(&|truth, _| truth), 0.0),
            view_energy,
            biases: [0.0; 8],
        }
    }
}

/// A place on the round light about `middle`: its share of the light's area within, and its turn.
fn on_light(middle: DVec3, area: f64, turn: f64) -> DVec3 {
    let cos = 1.0 - area * (1.0 - LIGHT_RADIUS.to_radians().cos());
    let (sin, (y, x)) = ((1.0 - cos * cos).max(0.0).sqrt(), (TAU * turn).sin_cos());
    DQuat::from_rotation_arc(DVec3::Z, middle.normalize()) * DVec3::new(sin * x, sin * y, cos)
}

/// A figure and the variance of its estimate.
pub(super) type Estimate = (f64, f64);

/// Figures of one chain at one texel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Figures {
    pub lobe: Estimate,
    pub light: Estimate,
    pub tv: Estimate,
    pub hellinger: Estimate,
    pub kl: Estimate,
    pub energy: Estimate,
    pub compensated: Estimate,
    pub diffuse: Estimate,
    /// Light that the chain and the truth reflect to each view.
    pub view_energy: [[f64; 2]; VIEWS.len()],
    /// What was taken off each estimate for the choice of a footprint's texels.
    pub biases: [f64; 8],
}

impl Figures {
    /// All estimates, in a fixed order.
    pub fn estimates(&mut self) -> [&mut Estimate; 8] {
        let Self { lobe, light, tv, hellinger, kl, energy, compensated, diffuse, .. } = self;
        [lobe, light, tv, hellinger, kl, energy, compensated, diffuse]
    }
}

/// Draws of two quantities.
type Draws = Vec<[f64; 2]>;

/// Mean of one quantity over strata.
fn total(strata: &[Draws], k: usize) -> f64 {
    let mean = |draws: &Draws| draws.iter().map(|draw| draw[k]).sum::<f64>() / draws.len() as f64;
    strata.iter().map(mean).sum::<f64>() / strata.len() as f64
}

/// Variance of the mean over strata of `first - value * second`, from the spread inside each, as if draws were
/// independent; they are spread more evenly, so it is less.
fn variance(strata: &[Draws], value: f64) -> f64 {
    let of_mean = |draws: &Draws| {
        let n = draws.len() as f64;
        let residual = |draw: &[f64; 2]| draw[0] - value * draw[1];
        let mean = draws.iter().map(residual).sum::<f64>() / n;
        draws.iter().map(|draw| (residual(draw) - mean).powi(2)).sum::<f64>() / (n * (n - 1.0).max(1.0))
    };
    strata.iter().map(of_mean).sum::<f64>() / (strata.len() * strata.len()) as f64
}

/// The mean of the first quantity over that of the second, with the variance to first order; `of_nothing` where the
/// second is 0 and the first too.
fn ratio(strata: &[Draws], of_nothing: f64) -> Estimate {
    let (above, below) = (total(strata, 0), total(strata, 1));
    if above == 0.0 && below == 0.0 {
        return (of_nothing, 0.0);
    }
    let value = above / below;
    (value, variance(strata, value) / (below * below))
}

/// The same, where the second quantity comes from other draws.
fn over_total(strata: &[Draws], others: &[Draws]) -> Estimate {
    let (above, below) = (total(strata, 0), total(others, 1));
    if above == 0.0 || below == 0.0 {
        return (0.0, 0.0);
    }
    let value = above / below;
    let swapped: Vec<Draws> = others.iter().map(|draws| draws.iter().map(|draw| [draw[1], 0.0]).collect()).collect();
    (value, (variance(strata, 0.0) + value * value * variance(&swapped, 0.0)) / (below * below))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_worked_by_hand() {
        // Means 1 and 2 without residuals.
        assert_eq!(ratio(&[vec![[1.0, 2.0], [2.0, 4.0], [0.0, 0.0]]], 0.0), (0.5, 0.0));
        // Means 2 and 2; residuals 2 and -2, so 8 / (2 * 1), over the square of 2.
        assert_eq!(ratio(&[vec![[3.0, 1.0], [1.0, 3.0]]], 0.0), (1.0, 1.0));
        // Two such strata: half the variance, for each has its own mean.
        let two = [vec![[3.0, 1.0], [1.0, 3.0]], vec![[5.0, 3.0], [3.0, 5.0]]];
        assert_eq!(ratio(&two, 0.0), (1.0, 0.5 * 4.0 / 9.0));
        assert_eq!(ratio(&[vec![[0.0, 0.0]]], 0.5), (0.5, 0.0));
        // 2 over 4, the second without spread: variance 2 / (2 * 1) of the first, over 16.
        let others = [vec![[9.0, 4.0], [7.0, 4.0]]];
        assert_eq!(over_total(&[vec![[1.0, 0.0], [3.0, 0.0]]], &others), (0.5, 1.0 / 16.0));
    }

    #[test]
    fn places_on_the_light_fill_it_evenly() {
        let middle = DVec3::new(0.3, -0.5, 0.8).normalize();
        let rim = LIGHT_RADIUS.to_radians();
        for turn in [0.0, 0.2, 0.9] {
            assert!(on_light(middle, 0.0, turn).distance(middle) < 1e-12);
            assert!((on_light(middle, 1.0, turn).angle_between(middle) - rim).abs() < 1e-9);
            // A quarter of the area lies within half the radius, but for the curvature of 5 degrees.
            assert!((on_light(middle, 0.25, turn).angle_between(middle) / rim - 0.5).abs() < 1e-3);
        }
    }

    #[test]
    fn diffuse_lights_are_spread_evenly() {
        let light = Diffuse::new(&[DVec3::Z]);
        assert_eq!((diffuse_lights().len(), light.len()), (256, 1));
        // The mean of n.l over the hemisphere is 1/2, for the flat lobe through the whole machinery.
        let lobe = crate::ndf::Lobe::isotropic(glam::Vec3::Z, crate::roughness::Alpha(0.3));
        let means = Footprint::of_lobes(&[(lobe, 1.0)]).means(&Queries::default(), &diffuse_lights());
        let mean = means[0].diffuse.iter().sum::<f64>() / 256.0;
        assert!((mean - 0.5).abs() < 1e-12, "{mean}");
    }
}
