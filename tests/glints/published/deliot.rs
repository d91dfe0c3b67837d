//! Deliot & Belcour 2023, "Real-Time Rendering of Glinty Appearances using Distributed Binomial Laws on Anisotropic Grids".
//!
//! The pixel's ellipse lies between grids of four angles, ratios and levels of detail, the corners of a tetrahedron. Its
//! flakes are shared out among the four by barycentric weights, and their counts are added, which keeps the variance. Each
//! grid is a lattice of triangles, with counts at three corners blended, and the half vector's plane a grid of boxes, with
//! four blended. A count is a gated normal distribution: none, or one and a rounded normal number.
//!
//! Kept: the mean of the gated count (its second part is that of N - 1 flakes, but not given that one was hit); the ramp
//! that stands for the gate; half vectors as absolute values, so that each light has three mirror images. Two readings, both
//! for the better, are those of Kneiphof & Klein 2024 and 2025: levels are rounded down (the released shader truncates, and
//! halves the footprint: the same for pixels shorter than a unit of uv), and the chance is the physical one, with boxes as
//! large as the flake's lobe. Published is a chance of `R D(h) / D(0)` for boxes of width R, which an artist chooses: for the
//! chances asked here boxes would be a tenth to a third as wide, and glints gone as much sooner when lights move. The noise
//! is hashed, without the period of a texture.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat2, DVec2};
use mipfold::glint::{normal_quantile, pcg4d, unit};

use super::Published;

/// Effective area of the filter, pixels: a cell of the continuous level, at a screen space scale of 1.
pub const AREA: f64 = 1.0;

/// A grid of cells: level of detail, log2 of the ratio, angle as a number of [`angle_step`]s (0 for none).
type Grid = [i32; 3];

/// Estimate over smooth lobe.
pub fn ratio(q: &Published) -> f64 {
    let share = q.share().min(1.0);
    // Boxes of the half vector's plane, in which solid angles are projected.
    let boxes = DVec2::new(q.h.x, q.h.y).abs() / (q.flake * q.h.z).sqrt();
    grids(q.jacobian_of(AREA))
        .into_iter()
        .filter(|(_, weight)| *weight > 0.0)
        .map(|([level, ratio, angle], weight)| {
            let (width, long) = (f64::from(level).exp2(), f64::from(ratio).exp2());
            let (sin, cos) = (f64::from(angle) * angle_step(ratio)).sin_cos();
            let turned = DVec2::new(cos * q.at.x + sin * q.at.y, cos * q.at.y - sin * q.at.x);
            let seed = pcg4d([level as u32, ratio as u32, angle as u32, q.seed]);
            let flakes = q.density * width * width * long;
            simplex(turned / DVec2::new(width, width * long), seed, boxes, flakes * weight, share) / (flakes * share)
        })
        .sum()
}

/// Between angles of grids of this ratio.
fn angle_step(ratio: i32) -> f64 {
    0.5 * FRAC_PI_2 / f64::from(ratio.max(1)).exp2()
}

/// The grids about a pixel's ellipse, with weights that add up to 1; four or fewer are above 0.
///
/// Angle and ratio are the corner of a triangle, level and triangle a prism, and the prism is cut into three tetrahedra
/// along diagonals that rise towards the first corners. In a prism cut so, the weight of the upper level goes to the
/// triangle's corners in their order, each filled before the next.
pub fn grids(jacobian: DMat2) -> [(Grid, f64); 6] {
    let (major, [long, short]) = ellipse(jacobian);
    let (lod, ratio) = (short.log2(), (long / short).max(1.0));
    let first = ratio.log2().floor();
    let y = (ratio / first.exp2() - 1.0).clamp(0.0, 1.0);
    let first = first as i32;
    // From the v axis, 0 to pi.
    let major = if major.x > 0.0 { -major } else { major };
    let turns = (-major.x).atan2(major.y) / angle_step(first);
    let (bin, x) = (turns.floor() as i32, turns - turns.floor());
    let near = |ratio: i32, angle: i32| {
        // Half a turn brings the lattice upon itself; as published, no turn is half a turn.
        let whole = (PI / angle_step(ratio)).round() as i32;
        [ratio, (angle - 1).rem_euclid(whole) + 1]
    };
    let corners = if first == 0 {
        // About the round ellipse, which has no angle.
        [([0, 0], 1.0 - y), (near(1, bin + 1), x * y), (near(1, bin), y * (1.0 - x))]
    } else {
        let (left, right) = (near(first, bin), near(first, bin + 1));
        let [a, c, e] = [0, 1, 2].map(|half| near(first + 1, 2 * bin + half));
        if 2.0 * x < y {
            [(left, 1.0 - y), (c, 2.0 * x), (a, y - 2.0 * x)]
        } else if 2.0 * (1.0 - x) > y {
            [(right, x - 0.5 * y), (left, 1.0 - x - 0.5 * y), (c, y)]
        } else {
            [(right, 1.0 - y), (e, y - 2.0 * (1.0 - x)), (c, 2.0 * (1.0 - x))]
        }
    };
    let (level, mut above) = (lod.floor() as i32, lod - lod.floor());
    let mut grids = [([0; 3], 0.0); 6];
    for (n, ([ratio, angle], weight)) in corners.into_iter().enumerate() {
        let upper = above.min(weight);
        above -= upper;
        grids[2 * n] = ([level, ratio, angle], weight - upper);
        grids[2 * n + 1] = ([level + 1, ratio, angle], upper);
    }
    grids
}

/// Direction of the major axis of the unit circle's image, and both half axes.
fn ellipse(jacobian: DMat2) -> (DVec2, [f64; 2]) {
    let m = jacobian * jacobian.transpose();
    let (mean, half) = (0.5 * (m.x_axis.x + m.y_axis.y), 0.5 * (m.x_axis.x - m.y_axis.y));
    let spread = half.hypot(m.x_axis.y);
    let long = (mean + spread).sqrt();
    (DVec2::from_angle(0.5 * m.x_axis.y.atan2(half)), [long, jacobian.determinant().abs() / long])
}

/// Blended count about a place in a lattice of triangles of unit width, for a mean of `flakes` in a cell.
fn simplex(at: DVec2, seed: [u32; 4], boxes: DVec2, flakes: f64, share: f64) -> f64 {
    let skewed = DVec2::new(at.x - at.y / 3f64.sqrt(), at.y * 2.0 / 3f64.sqrt());
    let (base, f) = (skewed.floor(), skewed - skewed.floor());
    let rest = 1.0 - f.x - f.y;
    let corners = if rest > 0.0 {
        [([0, 0], rest), ([0, 1], f.y), ([1, 0], f.x)]
    } else {
        [([1, 1], -rest), ([1, 0], 1.0 - f.y), ([0, 1], 1.0 - f.x)]
    };
    let count = Count::new(flakes, share);
    corners
        .into_iter()
        .map(|([i, j], weight)| {
            let cell = [base.x as i64 + i, base.y as i64 + j].map(|i| i as u32);
            let own = pcg4d([cell[0], cell[1], seed[0], seed[1]]);
            let at = boxes + DVec2::new(unit(own[0]), unit(own[1]));
            let (corner, f) = (at.floor(), at - at.floor());
            let of = |dx: i32, dy: i32| {
                let random = pcg4d([own[2], own[3], (corner.x as i32 + dx) as u32, (corner.y as i32 + dy) as u32]);
                count.of(unit(random[0]), normal_quantile(unit(random[1])))
            };
            let row = |dy| of(0, dy) * (1.0 - f.x) + of(1, dy) * f.x;
            weight * (row(0) * (1.0 - f.y) + row(1) * f.y)
        })
        .sum()
}

/// A gated normal distribution.
pub struct Count {
    flakes: f64,
    hit: f64,
    ramp: f64,
    mean: f64,
    deviation: f64,
}

impl Count {
    /// Of so many flakes with a chance of `share` each.
    pub fn new(flakes: f64, share: f64) -> Self {
        let hit = 1.0 - (1.0 - share).powf(flakes);
        let ramp = 0.1 * (10.0 * hit).min(1.0) * (10.0 * (1.0 - hit)).min(1.0);
        let mean = (flakes - 1.0) * share;
        // Not a number for less than one flake; the clamp below then gives 0, as shaders do.
        Self { flakes, hit, ramp, mean, deviation: (mean * (1.0 - share)).sqrt() }
    }

    /// For a uniform and a normal number.
    pub fn of(&self, u: f64, z: f64) -> f64 {
        let gate = if self.ramp > 1e-7 {
            ((self.hit + self.ramp - u) / (2.0 * self.ramp)).clamp(0.0, 1.0)
        } else {
            f64::from(u < self.hit)
        };
        gate * (1.0 + (self.mean + z * self.deviation).floor().max(0.0).min(self.flakes))
    }
}
