//! Which triangle each sample sees.

use std::ops::Range;

use super::projected::{Projected, Screen};

const NOTHING: u32 = u32::MAX;

/// Samples of some rows: a depth buffer.
pub(super) struct Band {
    screen: Screen,
    first_row: usize,
    /// 1 / depth, and a place in the list of triangles.
    samples: Vec<(f64, u32)>,
}

impl Band {
    /// Draws the rows. Of triangles at one depth the first is seen; both sides of a triangle are.
    pub fn new(triangles: &[Projected], screen: Screen, rows: Range<usize>) -> Self {
        let side = screen.samples;
        let mut samples = vec![(0.0, NOTHING); side * rows.len()];
        for (place, triangle) in triangles.iter().enumerate() {
            let first = (triangle.rows.start as usize).max(rows.start);
            for row in first..(triangle.rows.end as usize).min(rows.end) {
                let line = &mut samples[(row - rows.start) * side..][..side];
                for column in triangle.columns.clone() {
                    let Some(near) = triangle.near(screen.ray(f64::from(column), row as f64)) else { continue };
                    let sample = &mut line[column as usize];
                    if near > sample.0 {
                        *sample = (near, place as u32);
                    }
                }
            }
        }
        Self { screen, first_row: rows.start, samples }
    }

    /// Depth ahead of a sample and the place of the triangle that it sees.
    pub fn at(&self, column: usize, row: usize) -> Option<(f64, usize)> {
        let (near, place) = self.samples[(row - self.first_row) * self.screen.samples + column];
        (place != NOTHING).then(|| (1.0 / near, place as usize))
    }
}
