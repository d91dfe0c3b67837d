//! Moments by texel for one island at a time, and how a level becomes the next.

use super::moments::{NormalMoments, rounded};
use crate::ndf::RoughnessTensor;

/// A rectangle of texels of which few hold anything.
#[derive(Default)]
pub(super) struct Grid {
    width: usize,
    /// Where in `cells` each texel is; [`NOWHERE`] for most.
    slots: Vec<u32>,
    /// Texels that hold something, in the order in which they were first touched.
    cells: Vec<(u32, NormalMoments)>,
}

const NOWHERE: u32 = u32::MAX;

impl Grid {
    /// Makes room for `width` by `height` texels; the grid must be empty.
    pub fn resize(&mut self, width: usize, height: usize) {
        debug_assert!(self.cells.is_empty());
        self.width = width;
        self.slots.clear();
        self.slots.resize(width * height, NOWHERE);
    }

    /// Merges moments into a texel.
    #[inline]
    pub fn add(&mut self, column: usize, row: usize, moments: &NormalMoments) {
        let texel = row * self.width + column;
        let slot = &mut self.slots[texel];
        if *slot == NOWHERE {
            *slot = self.cells.len() as u32;
            self.cells.push((texel as u32, *moments));
        } else {
            self.cells[*slot as usize].1 += moments;
        }
    }

    /// Column, row and moments of each texel that holds something.
    pub fn texels(&self) -> impl Iterator<Item = (usize, usize, &NormalMoments)> {
        self.cells.iter().map(|(texel, m)| (*texel as usize % self.width, *texel as usize / self.width, m))
    }

    /// Merges texels into those of the next level, `ratio` columns and rows into one.
    pub fn coarsen(&self, ratio: [usize; 2], into: &mut Grid) {
        for (column, row, moments) in self.texels() {
            into.add(column / ratio[0], row / ratio[1], moments);
        }
    }

    /// Empties the grid, at the cost of what it held.
    pub fn clear(&mut self) {
        for (texel, _) in self.cells.drain(..) {
            self.slots[texel as usize] = NOWHERE;
        }
    }
}

/// A texel of the result in the making: what the islands on it have in common.
#[derive(Clone, Copy, Default)]
pub(super) struct Pool {
    weight: f64,
    tensor: [f64; 3],
    cover: f64,
    islands: u32,
}

impl Pool {
    /// Adds an island. Its spread is about its own mean and in its own frame: that two islands of a texel look
    /// different ways is no spread that a pixel would ever see.
    pub fn add(&mut self, island: &NormalMoments) {
        self.weight += island.weight;
        let share = island.weight / self.weight;
        for (pooled, own) in self.tensor.iter_mut().zip(island.tensor()) {
            *pooled += share * (own - *pooled);
        }
        self.cover += island.cover;
        self.islands += 1;
    }

    /// The added tensor, and the covered share of a texel that is `texels`-th of the texture.
    pub fn read(&self, texels: usize) -> (RoughnessTensor, f32) {
        (rounded(self.tensor), (self.cover * texels as f64) as f32)
    }

    /// Whether more than one island has a part in the texel.
    pub fn is_shared(&self) -> bool {
        self.islands > 1
    }
}
