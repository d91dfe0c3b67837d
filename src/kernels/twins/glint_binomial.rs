//! Twins of `kernels/wgsl/glint_binomial.wgsl`: counts and the evaluator are the library's; its grids are written once more,
//! over all cells of a rectangle about the kernel.

use glam::{DVec2, DVec3};

use super::glint::{GlintKernel, GlintLight, GlintPixel};
use super::glint_chance::{pcg4d, unit};
use crate::glint::{SmoothPoisson, evaluator};

/// A grid of cells as one pixel sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlintGrid {
    /// The pixel's cell.
    pub home: [i32; 2],
    /// Place in it.
    pub own: DVec2,
    /// In cells.
    pub kernel: GlintKernel,
    /// Logarithm of the cells' width.
    pub level: i32,
    /// Of weights.
    pub sum: f64,
    /// Of weights squared.
    pub squares: f64,
}

/// Mean, chances of none and of some, mean and deviation of the root of many, share of many.
pub fn smooth_poisson(mean: f64) -> [f64; 6] {
    // a^2 + b^2 is the mean, and 4 a^2 b^2 + 2 b^4 the variance: a^4 = mean^2 - variance / 2.
    let a4 = mean * mean - 0.5 * SmoothPoisson::VARIANCE * mean;
    let a2 = a4.max(0.0).sqrt();
    let b2 = if a4 > 0.0 { mean - a2 } else { 0.5 * SmoothPoisson::VARIANCE };
    [mean, (-mean).exp(), -(-mean).exp_m1(), a2.sqrt(), b2.sqrt(), (2.0 * mean - 1.0).clamp(0.0, 1.0)]
}

/// Nearly the normal quantile of `(1 + t) / 2`.
pub fn nearly_normal(t: f64) -> f64 {
    (1.294_576_2 * t - 0.965_239_5 * t.powi(3)) / (1.0 - 0.887_154_17 * t * t)
}

/// The library's count.
pub fn smooth_count(mean: f64, v: f64) -> f64 {
    SmoothPoisson::new(mean).counts_above([v])[0]
}

/// First and last centre in row j, from the middle of that row; with how far both are from a whole number at least.
pub fn glint_centres(grid: &GlintGrid, j: i32) -> ([f64; 2], f64) {
    let e = grid.kernel.ellipse();
    let c = grid.own - 0.5;
    let d = f64::from(j) - c.y;
    // Roots of the quadratic in x.
    let (middle, rest) = (c.x + d * e.xy / e.yy, (1.0 - d * d / e.yy).max(0.0) * e.determinant() / e.yy);
    let ends = [middle - rest.sqrt(), middle + rest.sqrt()];
    let slack = ends.map(|v| (v - v.round()).abs());
    ([ends[0].ceil(), ends[1].floor()], slack[0].min(slack[1]))
}

/// Whole part and rest of a sum.
pub fn glint_pair(w: f64, u: f64) -> [f64; 2] {
    [(w + u).floor(), w + u - (w + u).floor()]
}

/// Words for four boxes.
pub fn glint_words(x: i32, y: i32, prefix: u32, key: u32) -> [u32; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| {
        let place = [x.wrapping_add(dx) as u32, y.wrapping_add(dy) as u32];
        let sum = place[0].wrapping_mul(0x9E37_79B1).wrapping_add(place[1].wrapping_mul(0x85EB_CA77)).wrapping_add(key);
        let once = ((sum ^ sum >> 15) ^ prefix.wrapping_mul(0xC2B2_AE3D)).wrapping_mul(0x2C1B_3C6D);
        (once ^ once >> 14).wrapping_mul(0x297A_2D39)
    })
}

/// A chance from a word.
pub fn glint_chance(word: u32) -> f64 {
    (f64::from(word) + 0.5) / 4_294_967_296.0
}

/// Mean of the counts in the four boxes about a half vector in one cell.
pub fn glint_count(grid: &GlintGrid, i: i32, j: i32, widths: DVec2, seed: u32, mean: f64) -> f64 {
    let counts = SmoothPoisson::new(mean);
    let at = [grid.home[0].wrapping_add(i) as u32, grid.home[1].wrapping_add(j) as u32];
    let cell = pcg4d([at[0], at[1], grid.level as u32, seed]);
    let q = widths + DVec2::new(unit(cell[0]), unit(cell[1]));
    let words = glint_words(q.x.floor() as i32, q.y.floor() as i32, cell[2], cell[3]);
    let step = |t: f64| 3.0 * t * t - 2.0 * t.powi(3);
    let (f, g) = (step(q.x - q.x.floor()), step(q.y - q.y.floor()));
    let weights = [(1.0 - f) * (1.0 - g), f * (1.0 - g), (1.0 - f) * g, f * g];
    weights.iter().zip(words).map(|(weight, word)| weight * counts.counts_above([glint_chance(word)])[0]).sum()
}

/// Sums of weights and squares, or of weighted counts of a mean and 0.
pub fn glint_cells(grid: &GlintGrid, counting: Option<(DVec2, u32, f64)>) -> DVec2 {
    let e = grid.kernel.ellipse();
    let (inverse, c) = (e.inverse(), grid.own - 0.5);
    let mut sums = DVec2::ZERO;
    for j in (c.y - e.yy.sqrt()).floor() as i32..=(c.y + e.yy.sqrt()).ceil() as i32 {
        for i in (c.x - e.xx.sqrt()).floor() as i32..=(c.x + e.xx.sqrt()).ceil() as i32 {
            let t = (1.0 - inverse.of(DVec2::new(f64::from(i), f64::from(j)) - c)).max(0.0);
            let w = 3.0 * t * t - 2.0 * t.powi(3);
            if w > 0.0 {
                sums += match counting {
                    None => DVec2::new(w, w * w),
                    Some((widths, seed, mean)) => DVec2::new(w * glint_count(grid, i, j, widths, seed, mean), 0.0),
                };
            }
        }
    }
    sums
}

/// The grid of a level.
pub fn glint_grid(pixel: &GlintPixel, level: i32) -> GlintGrid {
    let side = f64::from(level).exp2();
    let at = (DVec2::new(f64::from(pixel.cell[0]), f64::from(pixel.cell[1])) + pixel.within) / side;
    let e = pixel.kernel.ellipse().scaled((5.0f64 / 6.0).sqrt() / side);
    let tensor = DVec3::new(e.xx + 0.58, e.xy, e.yy + 0.58);
    let kernel = GlintKernel { tensor, root: (tensor.x * tensor.z - tensor.y * tensor.y).sqrt() };
    let home = [at.x.floor() as i64 as i32, at.y.floor() as i64 as i32];
    let mut grid = GlintGrid { home, own: at - at.floor(), kernel, level, sum: 0.0, squares: 0.0 };
    let sums = glint_cells(&grid, None);
    (grid.sum, grid.squares) = (sums.x, sums.y);
    grid
}

/// Variance for one flake per unit area and box.
pub fn glint_grid_variance(grid: &GlintGrid) -> f64 {
    let area = f64::from(2 * grid.level).exp2();
    (26.0f64 / 35.0).powi(2) * grid.squares / (grid.sum * grid.sum * area)
}

/// Mean of counts over their mean.
pub fn glint_grid_ratio(grid: &GlintGrid, widths: DVec2, seed: u32, density: f64) -> f64 {
    let mean = density * f64::from(2 * grid.level).exp2();
    glint_cells(grid, Some((widths, seed, mean))).x / (grid.sum * mean)
}

/// The library's evaluator.
pub fn glint_binomial(pixel: &GlintPixel, light: &GlintLight, seed: u32, variation: f64) -> f64 {
    (evaluator("binomial").expect("of the library").ratio)(&pixel.probe(light, seed, variation))
}
