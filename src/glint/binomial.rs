//! The ratio from counts in a grid of cells, after Zirr & Kaplanyan 2016, "Real-time rendering of procedural multiscale
//! materials".
//!
//! Two grids of cells, each twice as wide as the other, are mixed; in each cell a grid over half vectors, as wide as the
//! lobe that answers and shifted at random; in each of its boxes a count of flakes. The published form loses more than
//! half of the variance in its weights. Here the weights of all cells are known before anything is counted, so that
//! fewer and brighter flakes make up for it exactly, in every pixel. Counts are Poisson, the limit of binomial ones for
//! flakes whose number in a cell is random too, and smooth ([`SmoothPoisson`]).

use glam::DVec2;

use super::count::SmoothPoisson;
use super::field::SMOOTH;
use super::footprint::Ellipse;
use super::hash::{pcg4d, unit};
use super::probe::Probe;

/// Squared radius, in cells, that is added to the kernel: no place is without a cell.
const REACH2: f64 = 0.6;
/// The finer cells are as wide as the footprint's short radius over this, or up to twice as narrow.
const FINEST: f64 = 0.75;
/// Mean sum of squared weights of the four boxes around a half vector.
const BOXES: f64 = 4.0 / 9.0;

/// A grid of cells as one pixel sees it.
struct Grid {
    level: i32,
    side: f64,
    home: [i64; 2],
    own: DVec2,
    kernel: Ellipse,
    sum: f64,
    squares: f64,
}

impl Grid {
    fn new(p: &Probe, level: i32) -> Self {
        let side = f64::from(level).exp2();
        let at = p.at / side;
        let mut kernel = p.kernel.scaled(1.0 / side);
        kernel.xx += REACH2;
        kernel.yy += REACH2;
        let home = [at.x.floor() as i64, at.y.floor() as i64];
        let mut grid = Self { level, side, home, own: at - at.floor(), kernel, sum: 0.0, squares: 0.0 };
        let (mut sum, mut squares) = (0.0, 0.0);
        grid.cells(|_, w| {
            sum += w;
            squares += w * w;
        });
        (grid.sum, grid.squares) = (sum, squares);
        grid
    }

    /// Calls `f(cell, weight)` for cells with their centres in the kernel.
    #[inline(always)]
    fn cells(&self, mut f: impl FnMut([i64; 2], f64)) {
        let (e, inverse, c) = (self.kernel, self.kernel.inverse(), self.own - 0.5);
        let (height, slope) = (e.yy.sqrt(), e.xy / e.yy);
        let half2 = e.xx - e.xy * slope;
        for j in (c.y - height).ceil() as i64..=(c.y + height).floor() as i64 {
            let d = j as f64 - c.y;
            let (middle, half) = (c.x + d * slope, ((1.0 - d * d / e.yy).max(0.0) * half2).sqrt());
            for i in (middle - half).ceil() as i64..=(middle + half).floor() as i64 {
                let rest = (1.0 - inverse.of(DVec2::new(i as f64 - c.x, d))).max(0.0);
                f([self.home[0] + i, self.home[1] + j], rest * rest);
            }
        }
    }

    /// Variance of the weighted counts for one expected flake per unit area and box.
    fn variance(&self) -> f64 {
        BOXES * self.squares / (self.sum * self.sum * self.side * self.side)
    }

    /// Mean of counts over their mean.
    fn ratio(&self, p: &Probe, flakes_per_area: f64) -> f64 {
        let mean = flakes_per_area * self.side * self.side;
        let counter = SmoothPoisson::new(mean);
        let (whole, part) = (p.widths.floor(), p.widths - p.widths.floor());
        let whole = [whole.x as i32, whole.y as i32];
        let mut sum = 0.0;
        self.cells(|[i, j], weight| {
            let cell = pcg4d([i as u32, j as u32, self.level as u32, p.seed]);
            let f = part + DVec2::new(unit(cell[0]), unit(cell[1]));
            let (a, b) = (whole[0] + i32::from(f.x >= 1.0), whole[1] + i32::from(f.y >= 1.0));
            let f = DVec2::new(if f.x >= 1.0 { f.x - 1.0 } else { f.x }, if f.y >= 1.0 { f.y - 1.0 } else { f.y });
            let mut boxes = 0.0;
            // Boxes share hashes in blocks of 2 x 2.
            for y in b >> 1..=(b + 1) >> 1 {
                for x in a >> 1..=(a + 1) >> 1 {
                    let words = pcg4d([cell[2], cell[3], x as u32, y as u32]);
                    for (n, word) in words.iter().enumerate() {
                        let (dx, dy) = (2 * x + (n & 1) as i32 - a, 2 * y + (n >> 1) as i32 - b);
                        if dx >> 1 == 0 && dy >> 1 == 0 {
                            let wx = if dx == 0 { 1.0 - f.x } else { f.x };
                            let wy = if dy == 0 { 1.0 - f.y } else { f.y };
                            boxes += wx * wy * counter.count(unit(*word));
                        }
                    }
                }
            }
            sum += weight * boxes;
        });
        sum / (self.sum * mean)
    }
}

/// The evaluator: see [`super::EVALUATORS`].
pub(super) fn ratio(p: &Probe) -> f64 {
    let n_eff = p.n_eff();
    if n_eff >= SMOOTH {
        return 1.0;
    }
    let position = (p.kernel.radii()[1] / FINEST).log2();
    let (level, share) = (position.floor() as i32, position - position.floor());
    let grids = [Grid::new(p, level), Grid::new(p, level + 1)];
    let shares = [1.0 - share, share];
    // Flakes per area and chart that leave the variance of independent flakes, (1 + variation^2) / N_eff.
    // Smooth counts keep a share of it that depends on their mean; two rounds find it to a thousandth.
    let [fine, coarse] = [0, 1].map(|n| shares[n] * shares[n] * grids[n].variance());
    let (per_flake, area) = (n_eff / (1.0 + p.variation2), grids[0].side * grids[0].side);
    let mut mean = per_flake * (fine + coarse);
    for _ in 0..2 {
        let kept = |cells: f64| SmoothPoisson::variance_share(mean * area * cells);
        mean = per_flake * (fine * kept(1.0) + coarse * kept(4.0));
    }
    let g: f64 = grids.iter().zip(shares).map(|(grid, share)| share * grid.ratio(p, mean)).sum();
    1.0 + (2.0 - 2.0 * n_eff / SMOOTH).min(1.0) * (g - 1.0)
}
