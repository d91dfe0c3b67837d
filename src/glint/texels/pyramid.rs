//! Ranges and moments of slopes, block by block.

use glam::{DVec2, Vec2};
use ndarray::{Array3, ArrayView3};

use super::SlopeMap;

/// Channels of [`Level::planes`].
pub const BLOCK_CHANNELS: [&str; 11] =
    ["min.x", "min.y", "max.x", "max.y", "mean.x", "mean.y", "cov.xx", "cov.xy", "cov.yy", "alpha.min", "alpha.max"];

/// The slopes over a block of cells, bilinear between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Block {
    /// Least slope along each axis.
    pub min: Vec2,
    /// Largest slope along each axis.
    pub max: Vec2,
    /// Mean slope.
    pub mean: Vec2,
    /// Covariance of the slopes: xx xy yy.
    pub cov: [f32; 3],
    /// Least and largest width of the material's lobe, as alpha.
    pub alpha: [f32; 2],
}

impl Block {
    /// What keeps a block from being one of any slopes, roundings aside.
    pub(super) fn check(&self) -> Result<(), &'static str> {
        let Self { min, max, mean, cov: [xx, xy, yy], alpha: [least, most] } = *self;
        let off = Vec2::splat(1e-5) * (1.0 + mean.abs());
        if min.cmpgt(max).any() {
            return Err("the least slope is above the largest");
        }
        if mean.cmplt(min - off).any() || mean.cmpgt(max + off).any() {
            return Err("the mean slope is not between the least and the largest");
        }
        if xx < 0.0 || yy < 0.0 {
            return Err("a variance is negative");
        }
        if f64::from(xy).abs() > 1.0001 * (f64::from(xx) * f64::from(yy)).sqrt() + 1e-20 {
            return Err("the covariance is larger than the variances allow");
        }
        if least <= 0.0 || least > most || most > 1.0 {
            return Err("the widths are not above 0, up to 1 and in order");
        }
        Ok(())
    }
}

/// One level of the pyramid: blocks by row, from the upper left.
#[derive(Clone, Debug)]
pub struct Level {
    columns: usize,
    blocks: Vec<Block>,
}

/// A quadtree over the cells of a map.
///
/// A cell lies between four texel centres: cell (x, y) between the columns x and x + 1 and the rows y and y + 1, the
/// last ones between the last and the first. A block of level k holds `2^k` by `2^k` cells, fewer at the right and
/// lower edges: sizes halve and are rounded up (EXR's ROUND_UP) until one block holds the map. Level 0, single cells,
/// is in [`Pyramid::cells`] only: a query has the texels themselves.
#[derive(Clone, Debug)]
pub struct Pyramid {
    /// From level 1 on.
    levels: Vec<Level>,
}

/// The block of one cell.
fn cell(map: &SlopeMap, x: usize, y: usize) -> Block {
    let (s, a) = (map.cell(x, y), map.widths(x, y));
    // Bilinear: mean + gx X + gy Y + q X Y over -1/2..1/2, whose parts are uncorrelated.
    let (gx, gy, q) = (0.5 * (s[1] + s[3] - s[0] - s[2]), 0.5 * (s[2] + s[3] - s[0] - s[1]), s[0] - s[1] - s[2] + s[3]);
    let cov = |i: usize, j: usize| (gx[i] * gx[j] + gy[i] * gy[j]) / 12.0 + q[i] * q[j] / 144.0;
    Block {
        min: s[0].min(s[1]).min(s[2]).min(s[3]),
        max: s[0].max(s[1]).max(s[2]).max(s[3]),
        mean: 0.25 * (s[0] + s[1] + s[2] + s[3]),
        cov: [cov(0, 0), cov(0, 1), cov(1, 1)],
        alpha: [a[0].min(a[1]).min(a[2]).min(a[3]), a[0].max(a[1]).max(a[2]).max(a[3])],
    }
}

/// Blocks and the number of cells in each, merged; central moments by the parallel formula (Chan et al. 1979).
fn merged(parts: impl Iterator<Item = (Block, f64)>) -> (Block, f64) {
    let (mut all, mut count, mut mean, mut cov) = (Block::default(), 0.0, DVec2::ZERO, [0.0f64; 3]);
    for (part, n) in parts {
        if count == 0.0 {
            (all.min, all.max, all.alpha) = (part.min, part.max, part.alpha);
        }
        (all.min, all.max) = (all.min.min(part.min), all.max.max(part.max));
        all.alpha = [all.alpha[0].min(part.alpha[0]), all.alpha[1].max(part.alpha[1])];
        let (d, share) = (part.mean.as_dvec2() - mean, n / (count + n));
        for (k, product) in [d.x * d.x, d.x * d.y, d.y * d.y].into_iter().enumerate() {
            cov[k] += share * (f64::from(part.cov[k]) - cov[k] + (1.0 - share) * product);
        }
        mean += share * d;
        count += n;
    }
    (all.mean, all.cov) = (mean.as_vec2(), cov.map(|c| c as f32));
    (all, count)
}

impl Pyramid {
    pub(super) fn new(map: &SlopeMap) -> Self {
        let (columns, rows) = map.size();
        let mut below = Self::cells(map);
        let mut counts = vec![1.0; below.blocks.len()];
        let (mut size, mut levels) = ((columns, rows), Vec::new());
        while levels.is_empty() || size != (1, 1) {
            let (w, h) = size;
            size = (w.div_ceil(2), h.div_ceil(2));
            let parts = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))).map(|(x, y)| {
                let inside = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().map(|(i, j)| (2 * x + i, 2 * y + j));
                merged(
                    inside.filter(|(x, y)| *x < w && *y < h).map(|(x, y)| (below.blocks[y * w + x], counts[y * w + x])),
                )
            });
            let (blocks, next): (Vec<_>, Vec<_>) = parts.unzip();
            counts = next;
            below = Level { columns: size.0, blocks };
            levels.push(below.clone());
        }
        Self { levels }
    }

    /// From level 1 on, as they were.
    pub(super) fn from_levels(levels: Vec<Level>) -> Self {
        Self { levels }
    }

    /// Level 0: a block for each cell.
    pub fn cells(map: &SlopeMap) -> Level {
        let (columns, rows) = map.size();
        let blocks = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| cell(map, x, y));
        Level { columns, blocks: blocks.collect() }
    }

    /// Level 1, of 2 by 2 cells, and all above, to the one block that holds the map.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// A block of level 1 or above.
    #[inline]
    pub(super) fn block(&self, level: usize, x: usize, y: usize) -> &Block {
        let level = &self.levels[level - 1];
        &level.blocks[y * level.columns + x]
    }

    /// Number of the highest level.
    pub(super) fn top(&self) -> usize {
        self.levels.len()
    }
}

impl Level {
    /// Columns and rows of blocks.
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.blocks.len() / self.columns)
    }

    /// From [`Level::planes`].
    pub(super) fn from_planes(planes: ArrayView3<f32>) -> Self {
        let (_, rows, columns) = planes.dim();
        let block = |(y, x)| {
            let p = |c: usize| planes[[c, y, x]];
            let pair = |c: usize| Vec2::new(p(c), p(c + 1));
            let (min, max, mean) = (pair(0), pair(2), pair(4));
            Block { min, max, mean, cov: [p(6), p(7), p(8)], alpha: [p(9), p(10)] }
        };
        let blocks = (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))).map(block).collect();
        Self { columns, blocks }
    }

    /// The blocks, by row.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// For files: axes (channel, row, column), channels [`BLOCK_CHANNELS`]. Slopes and alpha are as in
    /// [`SlopeMap::planes`]; covariances are in squared slope. A shader that keeps these in half floats should round the
    /// least down and the largest up, or blocks are pruned that just reach h.
    pub fn planes(&self) -> Array3<f32> {
        let (columns, rows) = self.size();
        Array3::from_shape_fn((BLOCK_CHANNELS.len(), rows, columns), |(c, y, x)| {
            let b = &self.blocks[y * columns + x];
            match c {
                0 | 1 => b.min[c],
                2 | 3 => b.max[c - 2],
                4 | 5 => b.mean[c - 4],
                6..=8 => b.cov[c - 6],
                _ => b.alpha[c - 9],
            }
        })
    }
}
