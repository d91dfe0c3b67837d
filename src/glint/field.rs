//! The ratio as the sum over the pixel's own flakes.
//!
//! `g = sum W(x - x_f) K(y - y_f) w_f` over the flakes f of a [`Net`], in units of cells and of the chart: W and K are
//! biweights of integral 1, and the weights w of mean 1. Up to [`MOST_SUMMED`] flakes that answer there are no levels of
//! detail: the flakes are fixed on the surface, and the net finds those that matter. For more, two sparser nets stand for
//! them.
//!
//! Neighbouring pixels are a little less alike than their kernels overlap: at one effective flake and one pixel apart their
//! correlation is 0.35, not 0.43, and twice as far -0.04, not 0.02; at a tenth of a flake it is that of the kernels. That is even
//! filling, not noise: a flake here leaves none of its direction for the cells around, so that of the even part of the
//! variance ([`even_variance`]) the correlation is 0.32; of the weights' part it is the kernels' (`tests/motion.rs`).

use glam::DVec2;

use super::footprint::Ellipse;
use super::net::{Cell, DEPTH, Jitter, Net};
use super::probe::Probe;

/// Effective flakes that are summed one by one. Above, two sparser nets stand for the flakes, with deviations from 1 that
/// are scaled down accordingly.
pub(super) const MOST_SUMMED: f64 = 1.5;

/// Effective flakes from which g is 1, and from half of which it tends there.
pub(super) const SMOOTH: f64 = 1e4;

/// Normalised variance of the net's flakes at equal weights: evenly filled, they vary less than independent ones, the less
/// so the longer the footprint (`anisotropy`, length over width). A fit of our own, within 0.025 of what is measured for
/// N_eff to 6, as layers have them, and anisotropies to 64 (`tests/variance.rs`).
pub(super) fn even_variance(n_eff: f64, anisotropy: f64) -> f64 {
    let even = (n_eff * n_eff.sqrt()).sqrt();
    1.0 / (1.0 + 0.79 * even / (1.0 + anisotropy.sqrt()))
}

/// Weights of mean 1 and variance v from a uniform mark t: `(1 + a) t^a`, `a^2 / (1 + 2a) = v`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights(f64);

impl Weights {
    pub(super) fn new(variance: f64) -> Self {
        let v = variance.max(0.0);
        Self(v + (v + v * v).sqrt())
    }

    #[inline(always)]
    pub(super) fn of(self, mark: f64) -> f64 {
        (1.0 + self.0) * mark.powf(self.0)
    }
}

/// The evaluator: see [`super::EVALUATORS`].
pub(super) fn ratio(p: &Probe) -> f64 {
    let n_eff = p.n_eff();
    if n_eff >= SMOOTH {
        return 1.0;
    }
    let anisotropy = p.kernel.anisotropy();
    if n_eff <= MOST_SUMMED {
        return layer(p, 0, 1.0 + p.variation2 - even_variance(n_eff, anisotropy));
    }
    // Layers j and j + 1 have between MOST_SUMMED and four times that, and a quarter of it.
    let position = 0.5 * (n_eff / MOST_SUMMED).log2();
    let first = position.floor();
    let (sin, cos) = ((position - first) * std::f64::consts::FRAC_PI_2).sin_cos();
    // The sparser layer alone could take g below 0 where both are dark: less of the other then, and more variance in each.
    let cos = if first == 0.0 { cos.min(1.0 - 0.5 * sin) } else { cos };
    let more = 1.0 / (sin * sin + cos * cos);
    let deviation = |layer_index: f64, share: f64| {
        if share == 0.0 {
            return 0.0;
        }
        let sparser = n_eff * (-2.0 * layer_index).exp2();
        let variance = more * (1.0 + p.variation2) - even_variance(sparser, anisotropy);
        share * (-layer_index).exp2() * (layer(p, layer_index as u32, variance) - 1.0)
    };
    let fade = (2.0 - 2.0 * n_eff / SMOOTH).min(1.0);
    (1.0 + fade * (deviation(first, cos) + deviation(first + 1.0, sin))).max(0.0)
}

/// The sum over the flakes of a layer: a quarter as many per area as those of the layer before.
pub(super) fn layer(p: &Probe, index: u32, weight_variance: f64) -> f64 {
    let scale = (-f64::from(index)).exp2();
    let (at, kernel, radius) = (p.at * scale, p.kernel.scaled(scale), p.radius());
    let weights = Weights::new(weight_variance);
    let mut sum = 0.0;
    let k = best_level(kernel, radius);
    visit(&Net::new(p.seed, index), at, kernel, p.y, radius, k, |_, jitter, _, both| {
        sum += both * weights.of(jitter.mark())
    });
    sum * peak(kernel, radius)
}

/// The sum over all of the first layer's flakes by blocks of one level, with the field's weights for few flakes.
pub(super) fn sum_at_level(p: &Probe, k: u32) -> f64 {
    let weights = Weights::new(1.0 + p.variation2 - even_variance(p.n_eff(), p.kernel.anisotropy()));
    let mut sum = 0.0;
    visit(&Net::new(p.seed, 0), p.at, p.kernel, p.y, p.radius(), k, |_, jitter, _, both| {
        sum += both * weights.of(jitter.mark());
    });
    sum * peak(p.kernel, p.radius())
}

/// Product of the heights of both kernels.
pub(super) fn peak(kernel: Ellipse, radius: f64) -> f64 {
    let height = 3.0 / std::f64::consts::PI;
    height * height / (kernel.determinant().sqrt() * radius * radius)
}

/// The level at which blocks are as large beside the footprint as boxes are beside the lobe: the fewest flakes to look at.
pub(super) fn best_level(kernel: Ellipse, radius: f64) -> u32 {
    (0.25 * kernel.determinant().sqrt().log2() - 0.5 * radius.log2()).round().clamp(0.0, f64::from(DEPTH)) as u32
}

/// Calls `f(cell, hash, offset from the pixel's centre in cells, product of both kernels over their peaks)` for each
/// flake with a product above 0, by blocks and boxes of level k.
#[inline(always)]
pub(super) fn visit(
    net: &Net,
    at: DVec2,
    kernel: Ellipse,
    y: DVec2,
    radius: f64,
    k: u32,
    mut f: impl FnMut(Cell, Jitter, DVec2, f64),
) {
    let (blocks, side) = (1i32 << k, f64::from(1u32 << k));
    let inverse = kernel.inverse();
    // All differences are taken from the pixel's own cell and block: small numbers, exact in f32 too.
    let (home, own) = (at.floor(), at - at.floor());
    let home = [home.x as i64 as i32, home.y as i64 as i32];
    let block = [home[0] >> k, home[1] >> k];
    let centre = DVec2::new(f64::from(home[0] & (blocks - 1)), f64::from(home[1] & (blocks - 1))) + own;
    // Boxes of the chart, which closes like a torus.
    let range = |y: f64| {
        let (a, b) = (((y - radius) * side).floor() as i32, ((y + radius) * side).floor() as i32);
        if b - a + 1 >= blocks { (0, blocks - 1) } else { (a, b) }
    };
    let ((a0, a1), (b0, b1)) = (range(y.x), range(y.y));
    let per_radius2 = 1.0 / (radius * radius);
    let closer = (k + 2).min(DEPTH);
    let closer_side = 1.0 / f64::from(1u32 << closer);
    // A cell's middle is at most half a diagonal from its flake.
    let beyond = (1.0 + std::f64::consts::FRAC_1_SQRT_2 / kernel.radii()[1]).powi(2);
    kernel.rows(centre, side, |j, first, last| {
        for i in first..=last {
            // Blocks repeat after 2^32 cells.
            let wrap = |home: i32, step: i64| home.wrapping_add(step as i32) << k >> k;
            let block = [wrap(block[0], i), wrap(block[1], j)];
            for b in b0..=b1 {
                for a in a0..=a1 {
                    let digits = [(a & (blocks - 1)) as u32, (b & (blocks - 1)) as u32];
                    let cell = net.cell(k, block, digits);
                    let from = [cell[0].wrapping_sub(home[0]), cell[1].wrapping_sub(home[1])];
                    let from = DVec2::new(f64::from(from[0]), f64::from(from[1])) - own;
                    // Cells that the ellipse cannot reach, before anything is hashed.
                    if inverse.of(from + 0.5) > beyond {
                        continue;
                    }
                    let jitter = net.jitter(cell);
                    let offset = from + jitter.place();
                    let t = inverse.of(offset);
                    if t >= 1.0 {
                        continue;
                    }
                    // Boxes of two more digits that the lobe cannot reach, before all digits are made.
                    let digits = net.digits(cell, k, closer, digits);
                    let d = DVec2::new(f64::from(digits[0]) + 0.5, f64::from(digits[1]) + 0.5) * closer_side - y;
                    let least = ((d - d.round()).abs() - 0.5 * closer_side).max(DVec2::ZERO);
                    if least.length_squared() * per_radius2 >= 1.0 {
                        continue;
                    }
                    let d = jitter.y(net.digits(cell, closer, DEPTH, digits)) - y;
                    let s = (d - d.round()).length_squared() * per_radius2;
                    if s < 1.0 {
                        let root = (1.0 - t) * (1.0 - s);
                        f(cell, jitter, offset, root * root);
                    }
                }
            }
        }
    });
}
