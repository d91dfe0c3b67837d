//! The best lobe with a tail of its own: a maximum-likelihood fit of a footprint.
//!
//! Seen about an axis p, the slopes of a GGX lobe about any other normal are again a bivariate Student-t of two
//! degrees of freedom, only shifted and stretched: with `S = R.xx t t' + R.xy (t b' + b t') + R.yy b b' + n n'` in a
//! frame of p, the homogeneous form `D = 1 / (pi sqrt(det S) (m' S^-1 m)^2)` gives the mean slope `-S_pz / S_zz` and the
//! tensor `S_pp / S_zz` less the mean's square. A footprint is so a mixture of such distributions in one plane, and its
//! lobe of least Kullback-Leibler divergence is the maximum-likelihood Student-t of that mixture. For a given exponent
//! the classic iteration finds it (Kent, Tyler & Vardi 1994; Liu & Rubin 1995); the exponent is searched along the likelihood.
//!
//! The slopes of GGX have no variance, so the divergence of every Beckmann lobe from GGX texels is infinite, and none is
//! best in this sense.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3};

use crate::ndf::{Frame, Lobe, RoughnessTensor, ShapeInvariant, Student, TailExponent};
use crate::roughness::Alpha;

/// What is asked of the exponent of the tail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tail {
    /// The one that fits best, at least [`TailExponent::HEAVIEST`].
    Free,
    /// This one, finite: no Beckmann lobe is nearest to GGX texels.
    Fixed(TailExponent),
}

/// Rings of nodes that stand for a lobe's slopes.
const RINGS: usize = 8;
/// Directions on a ring.
const TURNS: usize = 6;
/// Planes in which the fit is done, one after the other, each about the normal that the one before found.
const PLANES: usize = 8;
/// Steps of the iteration for one exponent.
const STEPS: usize = 200;
/// Relative change of the tensor at which it ends.
const STILL: f64 = 1e-6;
/// Exponents that are tried in one plane: golden section narrows the range of weights by 0.618 each time, to 0.0003.
const TRIES: usize = 18;

/// A distribution of slopes: tensor and mean.
#[derive(Clone, Copy, Debug)]
struct Slopes {
    mean: DVec2,
    /// xx xy yy.
    tensor: [f64; 3],
}

impl Slopes {
    fn determinant(&self) -> f64 {
        self.tensor[0] * self.tensor[2] - self.tensor[1] * self.tensor[1]
    }

    /// `(s - mean)' R^-1 (s - mean)`.
    fn squared_radius(&self) -> impl Fn(DVec2) -> f64 + use<> {
        let ([xx, xy, yy], det, mean) = (self.tensor, self.determinant(), self.mean);
        let [a, b, c] = [yy / det, -2.0 * xy / det, xx / det];
        move |s| {
            let d = s - mean;
            a * d.x * d.x + b * d.x * d.y + c * d.y * d.y
        }
    }
}

/// A slope and its share of the footprint.
#[derive(Clone, Copy, Debug)]
struct Node {
    slope: DVec2,
    share: f64,
}

/// The lobe of least Kullback-Leibler divergence from a footprint of GGX lobes with shares of its area.
///
/// With [`TailExponent::GGX`] fixed it is the best GGX lobe; with the tail free the best of all Student-t lobes. A
/// footprint of one lobe is returned as it is, within the quadrature (2 percent of its squared width).
///
/// Where a free tail pays is a matter of the surface. Over weaves, paper, rock and flakes under a smooth base the
/// tail gets lighter than GGX's, and the lobe comes up to two fifths closer in total variation. Where most is flat
/// and little is steep (tiles, chainmail) the tail gets heavier, and little is gained. The README has the figures. No
/// engine has a texture slot for the exponent, so this is no fold.
///
/// # Panics
/// If there is no weight above 0, or if Beckmann's tail is asked for.
pub fn best_student(lobes: &[(Lobe, f64)], tail: Tail) -> Student {
    let by_projection = |(lobe, weight): &(Lobe, f64)| {
        let n = lobe.normal.as_dvec3();
        *weight / n.z.max(1e-6) * n
    };
    let up = lobes.iter().map(by_projection).sum::<DVec3>();
    let mut normal = up.try_normalize().unwrap_or(DVec3::Z).as_vec3().normalize();
    let mut found: Option<(Slopes, f64)> = None;
    let fixed = match tail {
        Tail::Fixed(tail) => {
            assert!(tail < TailExponent::BECKMANN, "no Beckmann lobe is nearest to GGX texels");
            Some(tail.weight())
        }
        Tail::Free => None,
    };
    for _ in 0..PLANES {
        let nodes = nodes(lobes, normal);
        let start = Slopes { mean: DVec2::ZERO, tensor: found.map_or_else(|| first_guess(&nodes), |f| f.0.tensor) };
        let (slopes, weight) = match fixed {
            Some(weight) => (settle(&nodes, start, weight), weight),
            None => search(&nodes, start),
        };
        found = Some((slopes, weight));
        let frame = Frame::bent(normal);
        let tilt = slopes.mean.x * frame.tangent.as_dvec3() + slopes.mean.y * frame.bitangent.as_dvec3();
        normal = (normal.as_dvec3() - tilt).normalize().as_vec3().normalize();
        // Far less than the lobe is wide.
        if slopes.mean.length_squared() < 1e-8 * slopes.determinant().sqrt() {
            break;
        }
    }
    let (slopes, weight) = found.expect("there is a plane");
    let [xx, xy, yy] = slopes.tensor.map(|v| v as f32);
    let roughness = RoughnessTensor { xx, xy, yy }.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
    let tail = match tail {
        Tail::Fixed(tail) => tail,
        Tail::Free => TailExponent::from_weight(weight),
    };
    Student { normal, roughness, tail }
}

/// The footprint's slopes about an axis, by quadrature in the radial distribution of each lobe.
fn nodes(lobes: &[(Lobe, f64)], axis: Vec3) -> Vec<Node> {
    let unit = unit_nodes();
    let about = Lobe { normal: axis, roughness: RoughnessTensor::default() };
    let mut nodes = Vec::with_capacity(lobes.len() * unit.len());
    for (lobe, weight) in lobes.iter().filter(|(_, weight)| *weight > 0.0) {
        let frame = Frame::bent(lobe.normal);
        let [t, b, n] = [frame.tangent, frame.bitangent, lobe.normal].map(|v| about.local(v.as_dvec3()));
        let r = lobe.roughness.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
        let [xx, xy, yy] = [r.xx, r.xy, r.yy].map(f64::from);
        let s =
            |i: usize, j: usize| xx * t[i] * t[j] + xy * (t[i] * b[j] + b[i] * t[j]) + yy * b[i] * b[j] + n[i] * n[j];
        // Projected area of the lobe's upper side towards the axis: the share of the plane that is its own.
        let share = 0.5 * (n.z + s(2, 2).sqrt()) * weight / f64::from(lobe.normal.z).max(1e-6);
        let mean = -DVec2::new(s(0, 2), s(1, 2)) / s(2, 2);
        let l11 = (s(0, 0) / s(2, 2) - mean.x * mean.x).max(1e-12).sqrt();
        let l21 = (s(0, 1) / s(2, 2) - mean.x * mean.y) / l11;
        let l22 = (s(1, 1) / s(2, 2) - mean.y * mean.y - l21 * l21).max(0.0).sqrt();
        nodes.extend(unit.iter().map(|node| {
            let DVec2 { x, y } = node.slope;
            Node { slope: mean + DVec2::new(l11 * x, l21 * x + l22 * y), share: node.share * share }
        }));
    }
    let total: f64 = nodes.iter().map(|node| node.share).sum();
    nodes.iter_mut().for_each(|node| node.share /= total);
    nodes
}

/// Slopes and shares that stand for a GGX lobe of unit width.
fn unit_nodes() -> Vec<Node> {
    let mut nodes = Vec::with_capacity(RINGS * TURNS);
    for (i, (t, w)) in gauss_legendre(RINGS).into_iter().enumerate() {
        // 1 - u = (1 - t)^2 puts more nodes into the tail. Polynomials in u stay polynomials in t, so that the mean of
        // u is exact, which makes one lobe the best fit of itself.
        let (beyond, share) = ((1.0 - t) * (1.0 - t), 2.0 * (1.0 - t) * w / TURNS as f64);
        let radius = ((1.0 - beyond) / beyond).sqrt();
        // Every other ring is turned by half a step.
        let turned = |j: usize| DVec2::from_angle((j as f64 + 0.5 * (i % 2) as f64) / TURNS as f64 * TAU);
        nodes.extend((0..TURNS).map(|j| Node { slope: radius * turned(j), share }));
    }
    nodes
}

/// Nodes and weights on 0..1, exact for polynomials up to degree `2 n - 1`; Newton's iteration from the usual guess
/// (Press et al. 2007, section 4.6).
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..50 {
            let (mut p, mut before) = (1.0, 0.0);
            for k in 0..n {
                let k = k as f64;
                (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
            }
            slope = n as f64 * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// Round, as wide as the median of the slopes: GGX's own is its width.
fn first_guess(nodes: &[Node]) -> [f64; 3] {
    let mut squares: Vec<f64> = nodes.iter().map(|node| node.slope.length_squared()).collect();
    let middle = squares.len() / 2;
    let median = *squares.select_nth_unstable_by(middle, f64::total_cmp).1;
    [median.max(1e-8), 0.0, median.max(1e-8)]
}

/// The best mean and tensor for one tail, by its weight `c`: means with the weights `1 / (1 + c q)`, until nothing
/// moves. Divided by the sum of these weights, not by that of the shares (parameter expansion).
fn settle(nodes: &[Node], start: Slopes, c: f64) -> Slopes {
    let mut slopes = start;
    for _ in 0..STEPS {
        let q = slopes.squared_radius();
        let (mut total, mut first, mut second) = (0.0, DVec2::ZERO, [0.0; 3]);
        for node in nodes {
            let d = node.slope - slopes.mean;
            let w = node.share / (1.0 + c * q(node.slope));
            total += w;
            first += w * d;
            second[0] += w * d.x * d.x;
            second[1] += w * d.x * d.y;
            second[2] += w * d.y * d.y;
        }
        let shift = first / total;
        let products = [shift.x * shift.x, shift.x * shift.y, shift.y * shift.y];
        let tensor = std::array::from_fn(|i| 2.0 * (second[i] / total - products[i]));
        let moved = (0..3).map(|i| (tensor[i] - slopes.tensor[i]).abs()).fold(0.0, f64::max);
        let done = moved <= STILL * (slopes.tensor[0] + slopes.tensor[2]);
        slopes = Slopes { mean: slopes.mean + shift, tensor };
        if done {
            break;
        }
    }
    slopes
}

/// The best slopes and weight of the tail: golden section on the likelihood, each time with the best slopes.
fn search(nodes: &[Node], start: Slopes) -> (Slopes, f64) {
    let loss = |slopes: &Slopes, c: f64| {
        let (q, tail) = (slopes.squared_radius(), TailExponent::from_weight(c));
        0.5 * slopes.determinant().ln() + nodes.iter().map(|node| node.share * tail.fall(q(node.slope))).sum::<f64>()
    };
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, TailExponent::HEAVIEST.weight());
    let tried = |c: f64, from: Slopes| {
        let slopes = settle(nodes, from, c);
        (loss(&slopes, c), c, slopes)
    };
    let mut left = tried(high - golden * (high - low), start);
    let mut right = tried(low + golden * (high - low), left.2);
    for _ in 0..TRIES {
        if left.0 < right.0 {
            high = right.1;
            right = left;
            left = tried(high - golden * (high - low), left.2);
        } else {
            low = left.1;
            left = right;
            right = tried(low + golden * (high - low), right.2);
        }
    }
    let best = if left.0 < right.0 { left } else { right };
    (best.2, best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::{Axes, Ndf};
    use crate::random::Random;
    use proptest::prelude::*;

    fn lobe(x: f32, y: f32, alpha_x: f32, alpha_y: f32, angle: f32) -> Lobe {
        let axes = Axes { alpha_x: Alpha(alpha_x), alpha_y: Alpha(alpha_y), angle };
        Lobe { normal: Vec3::new(x, y, 1.0).normalize(), roughness: RoughnessTensor::from_axes(axes) }
    }

    /// Bumps of Gaussian slopes under a lobe of one width.
    fn bumps(n: usize, deviation: f64, alpha: f32, random: &mut Random) -> Vec<(Lobe, f64)> {
        let mut slope = || {
            let (u, v) = (random.uniform(), random.uniform());
            deviation * (-2.0 * (1.0 - u).ln()).sqrt() * DVec2::from_angle(TAU * v)
        };
        (0..n)
            .map(|_| {
                let s = slope();
                (lobe(-s.x as f32, -s.y as f32, alpha, alpha, 0.0), 1.0 / n as f64)
            })
            .collect()
    }

    /// Divergence from the footprint up to a constant, by drawing from it: an estimate that knows no quadrature and no
    /// slopes. Shares are areas projected along `axis`; the horizon, below which one lobe or another ends, is left out.
    fn loss(lobes: &[(Lobe, f64)], axis: Vec3, fit: &Student) -> f64 {
        let mut random = Random::new(3, 4);
        let (mut sum, mut total) = (0.0, 0.0);
        for (lobe, weight) in lobes {
            for _ in 0..(100_000 / lobes.len()).max(1) {
                let m = lobe.sample([random.uniform(), random.uniform()]);
                let cos = m.dot(axis.as_dvec3());
                if cos > 0.15 {
                    let share = weight / f64::from(lobe.normal.z) * cos / m.dot(lobe.normal.as_dvec3());
                    sum -= share * fit.pdf(m).ln();
                    total += share;
                }
            }
        }
        sum / total
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn one_lobe_is_its_own_fit(
            x in -0.8f32..0.8, y in -0.8f32..0.8, alpha in 0.02f32..0.6, ratio in 0.3f32..1.0, angle in -1.5f32..1.5,
        ) {
            let own = lobe(x, y, alpha, alpha * ratio, angle);
            for tail in [Tail::Free, Tail::Fixed(TailExponent::GGX)] {
                let fit = best_student(&[(own, 0.7)], tail);
                prop_assert!(fit.normal.distance(own.normal) < 1e-4 * alpha, "{fit:?} {own:?}");
                prop_assert!((fit.tail.weight() - 1.0).abs() < 0.02, "{fit:?}");
                let off = fit.roughness - own.roughness;
                let bound = 0.02 * alpha * alpha;
                prop_assert!(off.xx.abs() < bound && off.xy.abs() < bound && off.yy.abs() < bound, "{fit:?} {own:?}");
            }
        }
    }

    /// For a GGX lobe under Gaussian bumps much wider than itself, the best GGX has `alpha^2 = 0.61 * 2 sigma^2`, where
    /// 0.61 solves `2 x exp(x) E1(x) = 1`: the GGX that is likeliest for Gaussian slopes. The best tail is light.
    #[test]
    fn gaussian_bumps_get_a_light_tail() {
        let bumps = bumps(4000, 0.1, 0.005, &mut Random::new(5, 6));
        let ggx = best_student(&bumps, Tail::Fixed(TailExponent::GGX));
        assert!((ggx.roughness.mean() / 0.02 - 0.61).abs() < 0.03, "{}", ggx.roughness.mean() / 0.02);
        let free = best_student(&bumps, Tail::Free);
        assert!(free.tail > TailExponent(5.0), "{free:?}");
        assert!(loss(&bumps, free.normal, &free) < loss(&bumps, free.normal, &ggx) - 0.05);
    }

    /// Flat ground with a few steep places.
    #[test]
    fn sparse_footprints_get_a_heavy_tail() {
        let mut ground = vec![(lobe(0.0, 0.0, 0.1, 0.1, 0.0), 0.9)];
        ground.extend((0..8).map(|i| {
            let at = DVec2::from_angle(f64::from(i) / 8.0 * TAU);
            (lobe(0.7 * at.x as f32, 0.7 * at.y as f32, 0.1, 0.1, 0.0), 0.1 / 8.0)
        }));
        let free = best_student(&ground, Tail::Free);
        assert!(free.tail < TailExponent(1.9), "{free:?}");
    }

    /// No neighbour of the fit is better, by an estimate that shares nothing with it.
    #[test]
    fn the_fit_is_the_least_divergence() {
        let mut random = Random::new(7, 8);
        let mut lobes = bumps(40, 0.25, 0.15, &mut random);
        lobes.extend(bumps(20, 0.05, 0.3, &mut random).into_iter().map(|(l, w)| (l, 0.5 * w)));
        lobes.push((lobe(0.3, 0.1, 0.4, 0.1, 0.4), 0.3));
        let fit = best_student(&lobes, Tail::Free);
        let least = loss(&lobes, fit.normal, &fit);
        let wider = |k: f32| Student { roughness: fit.roughness * k, ..fit };
        let tail = |k: f64| Student { tail: TailExponent::from_weight(fit.tail.weight() * k), ..fit };
        let turned = |k: f32| {
            let (sin, cos) = k.sin_cos();
            Student { roughness: fit.roughness.rotated(cos, sin), ..fit }
        };
        let tilted = |x: f32, y: f32| Student { normal: (fit.normal + Vec3::new(x, y, 0.0)).normalize(), ..fit };
        let neighbours = [
            wider(0.9),
            wider(1.1),
            tail(0.7),
            tail(1.3),
            turned(0.3),
            turned(-0.3),
            tilted(0.05, 0.0),
            tilted(-0.05, 0.0),
            tilted(0.0, 0.05),
            tilted(0.0, -0.05),
        ];
        for other in neighbours {
            assert!(
                loss(&lobes, fit.normal, &other) > least,
                "{} {least}: {other:?} {fit:?}",
                loss(&lobes, fit.normal, &other)
            );
        }
        // Freeing the tail never costs likelihood.
        let ggx = best_student(&lobes, Tail::Fixed(TailExponent::GGX));
        assert!(least < loss(&lobes, fit.normal, &ggx) + 1e-4);
    }
}
