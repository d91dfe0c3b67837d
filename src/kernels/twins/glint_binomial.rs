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

/// Mean, neighbours, share of the upper, chances of some, share of a normal distribution.
pub fn smooth_poisson(mean: f64) -> [f64; 7] {
    let octave = mean.log2().floor().exp2();
    let step = (4.0 * (mean / octave - 1.0)).floor();
    let (low, high) = (octave * (1.0 + step / 4.0), octave * (1.0 + (step + 1.0) / 4.0));
    let normal = ((mean / 12.0 - 0.75) * 4.0).clamp(0.0, 1.0);
    [mean, low, high, (mean - low) / (high - low), -(-low).exp_m1(), -(-high).exp_m1(), normal]
}

/// The library's count.
pub fn smooth_count(mean: f64, u: f64) -> f64 {
    SmoothPoisson::new(mean).count(u)
}

/// The library's share of the variance that smooth counts keep.
pub fn smooth_variance(mean: f64) -> f64 {
    SmoothPoisson::variance_share(mean)
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

/// Mean of the counts in the four boxes about a half vector in one cell.
pub fn glint_count(grid: &GlintGrid, i: i32, j: i32, widths: DVec2, seed: u32, mean: f64) -> f64 {
    let counts = SmoothPoisson::new(mean);
    let at = [grid.home[0].wrapping_add(i) as u32, grid.home[1].wrapping_add(j) as u32];
    let cell = pcg4d([at[0], at[1], grid.level as u32, seed]);
    let q = widths + DVec2::new(unit(cell[0]), unit(cell[1]));
    let mut sum = 0.0;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let (a, b) = (q.x.floor() as i32 + dx, q.y.floor() as i32 + dy);
        let words = pcg4d([cell[2], cell[3], a.div_euclid(2) as u32, b.div_euclid(2) as u32]);
        let word = words[(a.rem_euclid(2) + 2 * b.rem_euclid(2)) as usize];
        let tent = (1.0 - (q - DVec2::new(f64::from(a), f64::from(b))).abs()).max(DVec2::ZERO);
        sum += tent.x * tent.y * counts.count(unit(word));
    }
    sum
}

/// Sums of weights and squares, or of weighted counts of a mean and 0.
pub fn glint_cells(grid: &GlintGrid, counting: Option<(DVec2, u32, f64)>) -> DVec2 {
    let e = grid.kernel.ellipse();
    let (inverse, c) = (e.inverse(), grid.own - 0.5);
    let mut sums = DVec2::ZERO;
    for j in (c.y - e.yy.sqrt()).floor() as i32..=(c.y + e.yy.sqrt()).ceil() as i32 {
        for i in (c.x - e.xx.sqrt()).floor() as i32..=(c.x + e.xx.sqrt()).ceil() as i32 {
            let w = (1.0 - inverse.of(DVec2::new(f64::from(i), f64::from(j)) - c)).max(0.0).powi(2);
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
    let e = pixel.kernel.ellipse().scaled(1.0 / side);
    let tensor = DVec3::new(e.xx + 0.6, e.xy, e.yy + 0.6);
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
    4.0 / 9.0 * grid.squares / (grid.sum * grid.sum * area)
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
