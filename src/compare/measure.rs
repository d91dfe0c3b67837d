//! One texel: the questions to put to its footprint and to the chains' lobes, and what the answers say.
//!
//! Every integral is a mean over drawn half vectors, so that lobes of any width are met where they are. For each chain
//! two kinds count, weighted together by how densely both fall (Veach & Guibas 1995, balance heuristic): those drawn
//! from the footprint, which all chains share, and those drawn from the chain's own lobe. The figures of a chain so
//! depend on no other chain. Both sides are evaluated exactly at each.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DQuat, DVec3};

use crate::reference::{Diffuse, Footprint, Means, Queries, Random, Spread};

/// From which the lobe error is seen: degrees from the normal and around it. Two for each slant, so that what leans
/// along u and along v counts alike.
pub const VIEWS: [(f64, f64); 5] = [(0.0, 0.0), (30.0, 0.0), (30.0, 90.0), (60.0, 180.0), (60.0, 270.0)];

/// Radius of the round light, degrees.
pub const LIGHT_RADIUS: f64 = 5.0;

/// Places on the round light at which it is evaluated.
const LIGHT_PLACES: usize = 12;

/// Lights of the diffuse term, spread evenly over the hemisphere.
const DIFFUSE_LIGHTS: usize = 64;

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

    /// What the answers `truth` and `own` say of chain `chain`.
    pub fn figures(&self, truth: &Means, own: &Means, chain: usize) -> Figures {
        let mut figures = Figures::default();
        let shares = {
            let (shared, own) = (self.counts.shared as f64, self.counts.own as f64);
            (shared / (shared + own), own / (shared + own))
        };
        let density = |j: usize| shares.0 * truth.pdf[j] + shares.1 * own.pdf[j];
        // Lights come from as many of the truth's as of the chain's.
        let light_density = |j: usize| 0.5 * (truth.pdf[j] + own.pdf[j]);
        let (mut tv, mut hellinger, mut kl) = (Mean::default(), Mean::default(), Mean::default());
        let [mut lobe, mut light, mut energy, mut compensated] = [Mean::default(); 4];
        // Relative variance of the light that the truth reflects, of a mean over the views.
        let mut noise = 0.0;
        for (i, view) in views().into_iter().enumerate() {
            let [mut seen, mut reflected, mut reflected_all] = [const { Vec::new() }; 3];
            for j in self.halves(i, chain) {
                let m = self.queries.half(j);
                let density = density(j);
                let (p, q) = (truth.d[j], own.d[j]);
                let projected = m.z.max(0.0) / density;
                tv.add(0.5 * (p - q).abs() * projected);
                hellinger.add(0.5 * (p.sqrt() - q.sqrt()).powi(2) * projected);
                // Below its own horizon a lobe has no facets at all; of that sliver no finite divergence can be told.
                let both = p > 0.0 && q > 0.0;
                kl.add(if both { (p * (p / q).ln() - p + q) * projected } else { 0.0 });
                // dl = 4 (v.h) dh.
                let spread = 4.0 * view.dot(m).max(0.0) / density;
                let (f_ref, f) = (truth.specular[j] * spread, own.specular[j] * spread);
                seen.push([(f - f_ref).abs(), f_ref]);
                reflected.push([f, f_ref]);
                reflected_all.push([own.compensated[j] * spread, truth.compensated[j] * spread]);
            }
            let total = Mean::of(seen.iter().map(|draw| draw[1])).of_draws();
            noise += total.1 / (total.0 * total.0).max(f64::MIN_POSITIVE) / (VIEWS.len() * VIEWS.len()) as f64;
            for places in self.lights(i, chain) {
                let mean = |f: &dyn Fn(usize) -> f64| places.clone().map(f).sum::<f64>();
                // Density of lights, at which their middles are spread too.
                let density = mean(&|j| light_density(j) / (4.0 * view.dot(self.queries.half(j))));
                let distance = mean(&|j| own.specular[j] - truth.specular[j]).abs();
                // A light of any size gives the same sum over all its middles.
                let lit = density > 0.0 && total.0 > 0.0;
                light.add(if lit { distance / (density * total.0) } else { 0.0 });
            }
            // A view that truth and chain show nothing to: no error, all energy.
            lobe.add_estimate(ratio(&seen, 0.0));
            let view_energy = ratio(&reflected, 1.0);
            figures.view_energy[i] = view_energy.0;
            energy.add_estimate(view_energy);
            compensated.add_estimate(ratio(&reflected_all, 1.0));
        }
        let hellinger2 = hellinger.of_draws();
        figures.tv = tv.of_draws();
        // The variance of a root: that of the square over four times the square.
        figures.hellinger = (hellinger2.0.sqrt(), hellinger2.1 / (4.0 * hellinger2.0).max(f64::MIN_POSITIVE));
        figures.kl = kl.of_draws();
        figures.lobe = lobe.of_views();
        let (value, variance) = light.of_draws();
        figures.light = (value, variance + value * value * noise);
        figures.energy = energy.of_views();
        figures.compensated = compensated.of_views();
        let sum = |f: &dyn Fn(f64, f64) -> f64| {
            truth.diffuse.iter().zip(&own.diffuse).map(|(truth, own)| f(*truth, *own)).sum::<f64>()
        };
        figures.diffuse = (sum(&|truth, own| (own - truth).abs()) / sum(&|truth, _| truth), 0.0);
        figures
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
    pub view_energy: [f64; 5],
}

impl Figures {
    /// All estimates, in a fixed order.
    pub fn estimates(&mut self) -> [&mut Estimate; 8] {
        let Self { lobe, light, tv, hellinger, kl, energy, compensated, diffuse, .. } = self;
        [lobe, light, tv, hellinger, kl, energy, compensated, diffuse]
    }
}

/// A sum of draws, or of estimates.
#[derive(Clone, Copy, Default)]
struct Mean {
    count: f64,
    sum: f64,
    squares: f64,
    variance: f64,
}

impl Mean {
    fn of(draws: impl Iterator<Item = f64>) -> Self {
        let mut mean = Self::default();
        draws.for_each(|v| mean.add(v));
        mean
    }

    fn add(&mut self, v: f64) {
        self.count += 1.0;
        self.sum += v;
        self.squares += v * v;
    }

    fn add_estimate(&mut self, (value, variance): Estimate) {
        self.count += 1.0;
        self.sum += value;
        self.variance += variance;
    }

    /// Variance from the spread of the draws, as if they were independent; they are spread more evenly, so it is less.
    fn of_draws(self) -> Estimate {
        let mean = self.sum / self.count;
        (mean, ((self.squares / self.count - mean * mean).max(0.0) / (self.count - 1.0).max(1.0)))
    }

    fn of_views(self) -> Estimate {
        (self.sum / self.count, self.variance / (self.count * self.count))
    }
}

/// Ratio of two sums over the same draws, with the variance to first order. `of_nothing` where both are 0; where the
/// truth reflects nothing and the chain does, 2: disjoint.
fn ratio(draws: &[[f64; 2]], of_nothing: f64) -> Estimate {
    let n = draws.len() as f64;
    let sum = |i: usize| draws.iter().map(|draw| draw[i]).sum::<f64>();
    let (above, below) = (sum(0), sum(1));
    if below <= 0.0 {
        return (if above > 0.0 { 2.0 } else { of_nothing }, 0.0);
    }
    let value = above / below;
    let residuals: f64 = draws.iter().map(|[a, b]| (a - value * b).powi(2)).sum();
    (value, residuals / (below * below) * n / (n - 1.0).max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratio_worked_by_hand() {
        // 3 / 6; residuals 1 - 1, 2 - 2 and 0 - 0.
        assert_eq!(ratio(&[[1.0, 2.0], [2.0, 4.0], [0.0, 0.0]], 0.0), (0.5, 0.0));
        // 4 / 4 with residuals 2 and -2: 8 / 16 * 2 / 1.
        assert_eq!(ratio(&[[3.0, 1.0], [1.0, 3.0]], 0.0), (1.0, 1.0));
        assert_eq!((ratio(&[[0.0, 0.0]], 0.5), ratio(&[[1.0, 0.0]], 0.5)), ((0.5, 0.0), (2.0, 0.0)));
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
        assert_eq!((diffuse_lights().len(), light.len()), (64, 1));
        // The mean of n.l over the hemisphere is 1/2, for the flat lobe through the whole machinery.
        let lobe = crate::ndf::Lobe::isotropic(glam::Vec3::Z, crate::roughness::Alpha(0.3));
        let means = Footprint::of_lobes(&[(lobe, 1.0)]).means(&Queries::default(), &diffuse_lights());
        let mean = means[0].diffuse.iter().sum::<f64>() / 64.0;
        assert!((mean - 0.5).abs() < 1e-12, "{mean}");
    }
}
