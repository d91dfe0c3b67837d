//! One flake per cell of a grid without bounds, such that every block of `2^k x 2^k` cells has exactly one flake in each
//! of the `4^k` boxes of side `2^-k` of the chart of directions, for every k up to [`DEPTH`].
//!
//! A flake's direction is a string of digits in base 4, coarsest first. The digit at level l is the flake's place among
//! the four children of its block of level l + 1, permuted at random: by a hash of that block *and* of the digits before.
//! Within a block, flakes of the same digits so far, one per child, then get four different next digits; so by induction
//! on l all `4^(l+1)` strings occur once in a block of level l + 1. Owen's scrambling (1995) of a Hammersley net is the
//! special case of two permutations, one by the block and one by the digits: then neighbours hold fixed pairs of
//! directions all over the largest block, and glints march across it when the light moves. Hashing both together leaves
//! only what the definition demands: the four flakes of the finest block lie in four different quarters of the chart.
//!
//! Read backwards, the digits of a box lead from a block down to the one cell whose flake is in that box, so a query that
//! is small in place and direction looks at few flakes at whatever level is cheapest, and all levels agree.

use glam::DVec2;

use super::hash::{fifth, mix, pcg4d, unit};

/// Digits that are stratified: blocks up to 4096 cells wide, directions down to a 4096th of the chart.
pub const DEPTH: u32 = 12;

/// What `x -> m x` does to the four digits in the field of four elements, m = 1, 2, 3 in bytes from below, two bits for
/// each digit. With an addition these are the 12 even permutations, under which every pair of digits meets every other
/// pair equally often.
const TIMES: u32 = 0x009C_78E4;
/// Their inverses.
const OVER: u32 = 0x0078_9CE4;

/// A flake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flake {
    /// Place in its cell, 0 to 1.
    pub place: DVec2,
    /// Direction in the chart, 0 to 1.
    pub y: DVec2,
    /// Uniform in 0..1, for its size.
    pub mark: f64,
}

/// The flakes of one seed and layer.
#[derive(Clone, Copy, Debug)]
pub struct Net {
    key: u32,
    jitter: [u32; 2],
}

/// Two coordinates of a block or a cell.
pub type Cell = [i32; 2];

/// A flake that is partly known: the hash of its cell.
#[derive(Clone, Copy)]
pub(super) struct Jitter([u32; 4]);

impl Jitter {
    #[inline(always)]
    pub(super) fn place(self) -> DVec2 {
        DVec2::new(unit(self.0[0]), unit(self.0[1]))
    }

    #[inline(always)]
    pub(super) fn y(self, digits: [u32; 2]) -> DVec2 {
        let scale = 1.0 / f64::from(1u32 << DEPTH);
        DVec2::new(f64::from(digits[0]) + unit(self.0[2]), f64::from(digits[1]) + unit(self.0[3])) * scale
    }

    #[inline(always)]
    pub(super) fn mark(self) -> f64 {
        fifth(self.0)
    }
}

impl Net {
    /// Nets of different seeds or layers have nothing to do with each other.
    #[inline]
    pub fn new(seed: u32, layer: u32) -> Self {
        let [key, a, b, _] = pcg4d([seed, layer, 0x51ED_2701, 0]);
        Self { key, jitter: [a, b] }
    }

    /// The flake of a cell.
    pub fn flake(&self, cell: Cell) -> Flake {
        let jitter = self.jitter(cell);
        Flake { place: jitter.place(), y: jitter.y(self.digits(cell, 0, DEPTH, [0, 0])), mark: jitter.mark() }
    }

    #[inline(always)]
    pub(super) fn jitter(&self, cell: Cell) -> Jitter {
        Jitter(pcg4d([cell[0] as u32, cell[1] as u32, self.jitter[0], self.jitter[1]]))
    }

    /// The permutation of a block's children: which multiplication, as a shift, and what is added.
    #[inline(always)]
    fn permutation(&self, level: u32, parent: Cell, digits: [u32; 2]) -> (u32, u32) {
        let key = self.key.wrapping_add(level.wrapping_mul(0x632B_E5AB));
        let h = mix([parent[0] as u32, parent[1] as u32], digits[0] | digits[1] << 16, key);
        (((((h << 2) >> 16) * 3) >> 16) << 3, h >> 30)
    }

    /// Digits of a cell's direction up to a level, as two numbers of so many bits, from the first k of them.
    #[inline(always)]
    pub(super) fn digits(&self, cell: Cell, k: u32, to: u32, mut digits: [u32; 2]) -> [u32; 2] {
        for level in k..to {
            let parent = [cell[0] >> (level + 1), cell[1] >> (level + 1)];
            let (times, plus) = self.permutation(level, parent, digits);
            let child = ((cell[0] >> level & 1) | (cell[1] >> level & 1) << 1) as u32;
            let digit = (TIMES >> times >> (2 * child) & 3) ^ plus;
            digits = [digits[0] << 1 | (digit & 1), digits[1] << 1 | digit >> 1];
        }
        digits
    }

    /// The cell of the flake in a box of the chart, within a block: block and box of level k.
    #[inline(always)]
    pub fn cell(&self, k: u32, block: Cell, mut digits: [u32; 2]) -> Cell {
        let mut cell = block;
        for level in (0..k).rev() {
            let digit = (digits[0] & 1) | (digits[1] & 1) << 1;
            digits = [digits[0] >> 1, digits[1] >> 1];
            let (times, plus) = self.permutation(level, cell, digits);
            let child = (OVER >> times >> (2 * (digit ^ plus)) & 3) as i32;
            cell = [cell[0] << 1 | (child & 1), cell[1] << 1 | child >> 1];
        }
        cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every block of every level to 5, here and far away, has one flake in each box; and lookups find it.
    #[test]
    fn all_levels_are_evenly_filled() {
        let net = Net::new(3, 1);
        for k in 0..=5u32 {
            let end = i32::MAX >> k;
            for block in [[0, 0], [-1, 3], [77, -1234], [end, -end - 1]] {
                let mut seen = vec![false; 1 << (2 * k)];
                for i in 0..1 << k {
                    for j in 0..1 << k {
                        let cell = [(block[0] << k) + i, (block[1] << k) + j];
                        let y = net.flake(cell).y * f64::from(1u32 << k);
                        let digits = [y.x as u32, y.y as u32];
                        assert_eq!(net.cell(k, block, digits), cell);
                        let first = &mut seen[(digits[0] << k | digits[1]) as usize];
                        assert!(!*first, "level {k}, block {block:?}: two flakes at {digits:?}");
                        *first = true;
                    }
                }
                assert!(seen.iter().all(|s| *s));
            }
        }
    }

    #[test]
    fn the_deepest_level_is_found_too() {
        let net = Net::new(9, 0);
        for n in 0..500 {
            let cell = [n * 7919 - 1_000_000, n * 104_729 % 65_536];
            let digits = net.digits(cell, 0, DEPTH, [0, 0]);
            assert_eq!(net.cell(DEPTH, [cell[0] >> DEPTH, cell[1] >> DEPTH], digits), cell);
            let k = (n % 13) as u32;
            let first = digits.map(|d| d >> (DEPTH - k));
            assert_eq!(net.digits(cell, k, DEPTH, first), digits);
        }
    }

    #[test]
    fn seeds_and_layers_differ() {
        let y = |seed, layer| Net::new(seed, layer).flake([5, 6]).y;
        assert_ne!(y(1, 0), y(2, 0));
        assert_ne!(y(1, 0), y(1, 1));
    }
}
