//! Zirr & Kaplanyan 2016, "Real-time rendering of procedural multiscale materials", with the constants of the shader that
//! the authors released.
//!
//! Two virtual grids of cells, each twice as wide as the other, are blended by the logarithm of the pixel's size. Cells are
//! summed along the long side of the pixel's bounding box, with a trapezoid's weights, and across it with a tent's (section
//! 4.2). In each, half vectors fall into boxes of a grid that is shifted at random, and each box has a binomial count.
//!
//! Kept: boxes of directions are not interpolated and 2.26 times as large as the flake's lobe; the normal branch of the
//! count lacks a factor of sqrt 2; indices shed their zero bits along each axis by itself, so that some cells of a level
//! are twins. Left out: variation of flakes' sizes, the cone of search and the limit of brightness, which all change the
//! mean and are off by choice; the limits of loops of WebGL; the tail of counts beyond 16, which is approximate there.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::DVec2;
use mipfold::glint::{normal_quantile, pcg4d, unit};

use super::Published;

/// Effective area of the filter, pixels: the pixel as a box.
pub const AREA: f64 = 1.0;

/// Longest footprint, in cells of the continuous level.
const MOST_ANISOTROPY: f64 = 16.0;
/// Between the stereographic half vector and its grid, in widths of the flake's lobe.
const BOXES: f64 = 0.75;
/// Expected counts from which a normal distribution stands for them.
const NORMAL: f64 = 5.0;
/// Chances are rounded to powers of this.
const STEP: f64 = 0.9;

/// Estimate over smooth lobe.
pub fn ratio(q: &Published) -> f64 {
    with_ids(q, |index, _| index.map(without_zero_bits))
}

/// The same for other identities of cells, from index and level.
pub fn with_ids(q: &Published, id: fn([i64; 2], i64) -> [u32; 2]) -> f64 {
    let jacobian = q.jacobian_of(AREA);
    let to_pixels = jacobian.inverse();
    // Axis-aligned bounding box, and its longer axis.
    let extent = jacobian.x_axis.abs().max(jacobian.y_axis.abs());
    let (long, short) = if extent.x > extent.y { (0, 1) } else { (1, 0) };
    let (along, across) = (to_pixels.col(long), to_pixels.col(short));
    // The line of the pixel's own long side, as a slope over the long axis.
    let skew = if across.x.abs() > across.y.abs() { -along.x / across.x } else { -along.y / across.y };
    // A step along the short axis that moves one pixel.
    let size = (1.0 / across.abs().max_element()).max(extent[long] / MOST_ANISOTROPY);
    let position = size.log2();
    let share = q.share().min(1.0);
    // The flake's lobe is a box in slopes of area `pi width^2`, so that `share = D pi width^2`.
    let width = (q.flake * q.h.z / PI).sqrt();
    let boxes = DVec2::new(q.h.x, q.h.y) * (BOXES / (1.0 + q.h.z) / width);
    let mut g = 0.0;
    for level in [position.floor(), position.floor() + 1.0] {
        let blend = 1.0 - (position - level).abs();
        let cell = level.exp2();
        let flakes = q.density * cell * cell;
        let (low, high) = (
            (q.at[long] - 0.5 * extent[long] + 0.5 * cell).min(q.at[long]),
            (q.at[long] + 0.5 * extent[long] - 0.5 * cell).max(q.at[long]),
        );
        let (mut sum, mut weights) = (0.0, 0.0);
        let mut i = (low / cell).floor();
        while i * cell < high + cell {
            let trapezoid = (1.0 - ((low - i * cell) / cell).max(0.0)) * (1.0 - ((i * cell - high) / cell).max(0.0));
            let centre = (q.at[short] + skew * (i * cell - q.at[long])) / cell;
            for j in [centre.floor(), centre.floor() + 1.0] {
                let weight = trapezoid.max(0.0) * (1.0 - (j - centre).abs()).max(0.0);
                let index = if long == 0 { [i, j] } else { [j, i] };
                let [a, b] = id(index.map(|i| i as i64), level as i64);
                let own = pcg4d([a, b, q.seed, 0x21BB]);
                let cone = (boxes + DVec2::new(unit(own[0]), unit(own[1]))).floor();
                let u = unit(pcg4d([own[2], own[3], cone.x as i32 as u32, cone.y as i32 as u32])[0]);
                sum += weight * count(flakes, share, u);
                weights += weight;
            }
            i += 1.0;
        }
        g += blend * sum / (weights * flakes * share);
    }
    g
}

/// An index that cells of all levels share: 12, 6 and 3 are one.
fn without_zero_bits(i: i64) -> u32 {
    (if i == 0 { 0 } else { i >> i.trailing_zeros() }) as u32
}

/// Flakes that answer, of `n` with a chance of `p` each, for a uniform u.
pub fn count(n: f64, p: f64, u: f64) -> f64 {
    if n * p > NORMAL {
        // The inverse error function of 2u - 1, which is the normal quantile over sqrt 2, times the deviation.
        let z = normal_quantile(u) * FRAC_1_SQRT_2;
        return (n * p + z * (n * p * (1.0 - p)).sqrt()).clamp(0.0, n);
    }
    if p >= 1.0 {
        return n;
    }
    let whole = n.ceil();
    let position = (p * n / whole).ln() / STEP.ln();
    let above = STEP.powf(position.floor());
    let share = position - position.floor();
    invert(whole, above, u) * (1.0 - share) + invert(whole, above * STEP, u) * share
}

/// The binomial count whose distribution function first passes u.
fn invert(n: f64, p: f64, u: f64) -> f64 {
    let (mut k, mut probability) = (0.0, (1.0 - p).powf(n));
    let mut sum = probability;
    while u >= sum && k < n {
        probability *= p / (1.0 - p) * (n - k) / (k + 1.0);
        sum += probability;
        k += 1.0;
        if probability < 1e-18 {
            break;
        }
    }
    k
}
