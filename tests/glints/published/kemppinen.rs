//! Kemppinen et al. 2025, "Evaluating and Sampling Glinty NDFs in Constant Time", with the constants of the shader that the
//! authors released.
//!
//! Flakes are points of place and direction, one in each cell of a grid of both, shifted at random within it. Of the levels
//! of detail, each half as fine in place and twice as fine in direction as the one before, two next to the pixel's are
//! summed, 2 x 2 cells of place and of direction in each, with Gaussian weights. A flake's level fades by lot. What the
//! cells of direction do not reach of the Gaussian is added as its mean.
//!
//! Kept: what the cells of place do not reach is lost, and appears at once when the pixel passes the middle of a cell.

use std::f64::consts::{PI, SQRT_2};

use glam::{DMat2, DVec2};
use mipfold::glint::{erf, fifth, pcg4d, unit};

use super::Published;

/// Deviation of the pixel's Gaussian, pixels: the value of the released shader, between 0.5 and 1.2.
pub const FILTER: f64 = 0.7;

/// Estimate over smooth lobe.
pub fn ratio(q: &Published) -> f64 {
    with_filter(q, FILTER)
}

/// The same for a Gaussian of another deviation, pixels, of effective area `4 pi filter^2`: levels depend on it.
pub fn with_filter(q: &Published, filter: f64) -> f64 {
    let jacobian = q.jacobian_of(4.0 * PI * filter * filter) * filter;
    let covariance = jacobian * jacobian.transpose();
    let root = q.density.sqrt();
    let (mean, half) =
        (0.5 * (covariance.x_axis.x + covariance.y_axis.y), 0.5 * (covariance.x_axis.x - covariance.y_axis.y));
    let long = (mean + half.hypot(covariance.x_axis.y)).sqrt();
    let position = (long * root).log2() + filter.exp2();
    let y = chart(q);
    // A Gaussian of variance v in each of two directions has an effective area of 4 pi v.
    let variance = q.share() / (4.0 * PI);
    let deviation = variance.sqrt();
    let (place, direction) = (Gaussian::new(covariance), 1.0 / (2.0 * PI * variance));
    let mut g = 0.0;
    for level in [position.floor(), position.floor() + 1.0] {
        let weight = 1.0 - (position - level).abs();
        // Cells along a unit of place and of direction.
        let (per_place, per_direction) = (root * (-level).exp2(), level.exp2());
        let near = (y * per_direction).round().max(DVec2::ONE).min(DVec2::splat(per_direction - 1.0));
        let home = (q.at * per_place).round();
        for n in 0..16 {
            let [i, j, a, b] = [0, 1, 2, 3].map(|bit| f64::from(n >> bit & 1) - 1.0);
            let (cell, angle) = (home + DVec2::new(i, j), near + DVec2::new(a, b));
            // Levels count from -64, angles fit in 16 bits.
            let bits = (angle.x as i32 as u32) << 16 ^ (angle.y as i32 as u32) & 0xFFFF;
            let random = pcg4d([cell.x as i64 as u32, cell.y as i64 as u32, bits, q.seed << 8 | (level + 64.0) as u32]);
            let at = (cell + DVec2::new(unit(random[0]), unit(random[1]))) / per_place;
            let of = (angle + DVec2::new(unit(random[2]), unit(random[3]))) / per_direction;
            let lot = fifth(random);
            let fade = smoothstep((lot - 0.1).max(0.0), (lot + 0.1).min(1.0), weight);
            let off = (of - y).length_squared() / variance;
            g += fade * direction * (-0.5 * off).exp() * place.of(at - q.at) / q.density;
        }
        let reached = box_mass(y, deviation, (near - 1.0) / per_direction, (near + 1.0) / per_direction);
        g += weight * (box_mass(y, deviation, DVec2::ZERO, DVec2::ONE) - reached);
    }
    g
}

/// The half vector, stretched by the lobe, on Lambert's equal-area map of the hemisphere, as a disk in the unit square.
fn chart(q: &Published) -> DVec2 {
    let alpha = f64::from(q.alpha.0);
    let stretched = glam::DVec3::new(q.h.x / alpha, q.h.y / alpha, q.h.z).normalize();
    DVec2::new(stretched.x, stretched.y) / (1.0 + stretched.z).sqrt() * 0.5 + 0.5
}

/// A Gaussian density of two variables.
struct Gaussian {
    inverse: DMat2,
    height: f64,
}

impl Gaussian {
    fn new(covariance: DMat2) -> Self {
        Self { inverse: covariance.inverse(), height: 1.0 / (2.0 * PI * covariance.determinant().sqrt()) }
    }

    fn of(&self, d: DVec2) -> f64 {
        self.height * (-0.5 * d.dot(self.inverse * d)).exp()
    }
}

/// Part of a round Gaussian that lies in a box.
fn box_mass(mean: DVec2, deviation: f64, low: DVec2, high: DVec2) -> f64 {
    let below = |x: f64| 0.5 + 0.5 * erf(x / (deviation * SQRT_2));
    (below(high.x - mean.x) - below(low.x - mean.x)) * (below(high.y - mean.y) - below(low.y - mean.y))
}

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
