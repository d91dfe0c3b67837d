//! Slopes and widths of the texels.

use glam::{DVec2, Vec2};
use ndarray::{Array2, Array3, ArrayView3};

use super::InvalidTexels;
use crate::roughness::Alpha;

/// Longest slope, 86 degrees: beyond it a slope says more about rounding than about the surface. Longer ones are cut.
pub const STEEPEST: f32 = 16.0;

/// Channels of [`SlopeMap::planes`].
pub const SLOPE_CHANNELS: [&str; 3] = ["slope.x", "slope.y", "alpha"];

/// The material's own lobe: GGX widths.
#[derive(Clone, Debug)]
pub enum AlphaSource {
    /// One for all texels.
    Constant(Alpha),
    /// One a texel, axes (row, column): plain [`Alpha`] values, squared perceptual roughness.
    Texels(Array2<f32>),
}

/// Slopes, and widths where they differ, by row and column; the map repeats.
#[derive(Clone, Debug)]
pub struct SlopeMap {
    slope: Array2<Vec2>,
    alpha: Widths,
}

#[derive(Clone, Debug)]
enum Widths {
    Same(f32),
    Each(Array2<f32>),
}

/// A width in the range that lobes are evaluated at; what is no number counts as the roughest.
fn width(alpha: f32) -> f32 {
    if alpha.is_nan() { 1.0 } else { alpha.clamp(Alpha::SMOOTHEST.0, 1.0) }
}

fn slope(x: f32, y: f32, z: f32) -> Vec2 {
    let s = Vec2::new(-x / z, -y / z);
    if x.is_finite() && y.is_finite() && z > 0.0 && z.is_finite() && s.is_finite() {
        s.clamp_length_max(STEEPEST)
    } else {
        Vec2::ZERO
    }
}

impl SlopeMap {
    pub(super) fn new(normals: &Array3<f32>, alpha: AlphaSource) -> Result<Self, InvalidTexels> {
        let (rows, columns, channels) = normals.dim();
        if rows == 0 || columns == 0 || channels != 3 {
            return Err(InvalidTexels::Shape(rows, columns, channels));
        }
        let alpha = match alpha {
            AlphaSource::Constant(Alpha(a)) => Widths::Same(width(a)),
            AlphaSource::Texels(each) if each.dim() == (rows, columns) => {
                Widths::Each(each.as_standard_layout().mapv(width))
            }
            AlphaSource::Texels(each) => return Err(InvalidTexels::AlphaSize(each.dim(), (rows, columns))),
        };
        let at = |(y, x)| slope(normals[[y, x, 0]], normals[[y, x, 1]], normals[[y, x, 2]]);
        Ok(Self { slope: Array2::from_shape_fn((rows, columns), at), alpha })
    }

    /// From [`SlopeMap::planes`].
    pub(super) fn from_planes(planes: ArrayView3<f32>) -> Self {
        let (_, rows, columns) = planes.dim();
        let alpha = Array2::from_shape_fn((rows, columns), |(y, x)| width(planes[[2, y, x]]));
        let first = alpha[[0, 0]];
        let alpha = if alpha.iter().all(|a| *a == first) { Widths::Same(first) } else { Widths::Each(alpha) };
        let at = |(y, x)| {
            let s = Vec2::new(planes[[0, y, x]], planes[[1, y, x]]);
            // Those that were cut are a rounding longer.
            if s.length() > 1.001 * STEEPEST { s.clamp_length_max(STEEPEST) } else { s }
        };
        Self { slope: Array2::from_shape_fn((rows, columns), at), alpha }
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        let (rows, columns) = self.slope.dim();
        (columns, rows)
    }

    /// Rows and columns of the corners of the cell that has the texel (x, y) at its upper left: x first.
    #[inline]
    fn corners(&self, x: usize, y: usize) -> [[usize; 2]; 4] {
        let (columns, rows) = self.size();
        let (right, below) = (if x + 1 == columns { 0 } else { x + 1 }, if y + 1 == rows { 0 } else { y + 1 });
        [[y, x], [y, right], [below, x], [below, right]]
    }

    /// Slopes at the corners of a cell.
    #[inline]
    pub(super) fn cell(&self, x: usize, y: usize) -> [Vec2; 4] {
        let (columns, rows) = self.size();
        let texels = self.slope.as_slice().expect("standard layout");
        let (above, below) = (&texels[y * columns..], &texels[if y + 1 == rows { 0 } else { (y + 1) * columns }..]);
        let right = if x + 1 == columns { 0 } else { x + 1 };
        [above[x], above[right], below[x], below[right]]
    }

    /// Widths at the corners of a cell.
    #[inline]
    pub(super) fn widths(&self, x: usize, y: usize) -> [f32; 4] {
        match &self.alpha {
            Widths::Same(alpha) => [*alpha; 4],
            Widths::Each(each) => self.corners(x, y).map(|at| each[at]),
        }
    }

    /// Slope and width at a point in texel coordinates, both interpolated between four texels.
    pub fn at(&self, x: DVec2) -> (DVec2, f64) {
        let (columns, rows) = self.size();
        let (floor, t) = (x.floor(), x - x.floor());
        let cell = (floor.x.rem_euclid(columns as f64) as usize, floor.y.rem_euclid(rows as f64) as usize);
        let cell = (cell.0.min(columns - 1), cell.1.min(rows - 1));
        let weights = [(1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y];
        let slopes = self.cell(cell.0, cell.1).map(|s| s.as_dvec2());
        let alphas = self.widths(cell.0, cell.1).map(f64::from);
        let slope = weights.iter().zip(slopes).map(|(w, s)| *w * s).sum();
        (slope, weights.iter().zip(alphas).map(|(w, a)| w * a).sum())
    }

    /// For files: axes (channel, row, column), channels [`SLOPE_CHANNELS`]. Slopes are rise over run along +u and +v, `(-x/z, -y/z)` of the normal;
    /// alpha is the GGX width.
    pub fn planes(&self) -> Array3<f32> {
        let (columns, rows) = self.size();
        Array3::from_shape_fn((3, rows, columns), |(c, y, x)| match c {
            0 => self.slope[[y, x]].x,
            1 => self.slope[[y, x]].y,
            _ => self.widths(x, y)[0],
        })
    }
}
