//! What a block says about the way to ETC1 and to the alpha of ETC2, so that who transcodes need not search.
//!
//! The ends and weights of a block are of no use to ETC1: it takes a block's texels once decoded, the average of each half
//! of them, and moves a texel from there along gray only. The hints say which halves, how exactly their averages are
//! kept, how far texels move, and where an average is better rounded the other way (Khronos Data Format 1.4, chapters 21
//! and 25). The two hints for BC1 would spare its encoder work at the cost of quality; they are never given.

use super::bits::{Reader, Writer};
use super::block::Mode;
use super::{Texels, encode::Search};

/// How far ETC1 moves texels along gray, up or down: a little or a lot.
const MOVES: [[i32; 2]; 8] = [[2, 8], [5, 17], [9, 29], [13, 42], [18, 60], [24, 80], [33, 106], [47, 183]];

/// How far the alpha of ETC2 moves from its base: the least four first, the fourth and the last the farthest.
#[rustfmt::skip]
const ALPHA_MOVES: [[i16; 8]; 16] = [
    [-3, -6, -9, -15, 2, 5, 8, 14], [-3, -7, -10, -13, 2, 6, 9, 12], [-2, -5, -8, -13, 1, 4, 7, 12], [-2, -4, -6, -13, 1, 3, 5, 12],
    [-3, -6, -8, -12, 2, 5, 7, 11], [-3, -7, -9, -11, 2, 6, 8, 10], [-4, -7, -8, -11, 3, 6, 7, 10], [-3, -5, -8, -11, 2, 4, 7, 10],
    [-2, -6, -8, -10, 1, 5, 7, 9], [-2, -5, -8, -10, 1, 4, 7, 9], [-2, -4, -8, -10, 1, 3, 7, 9], [-2, -5, -7, -10, 1, 4, 6, 9],
    [-3, -4, -7, -10, 2, 3, 6, 9], [-1, -2, -3, -10, 0, 1, 2, 9], [-4, -6, -8, -9, 3, 5, 7, 8], [-3, -5, -7, -9, 2, 4, 6, 8],
];

/// Of a block that is not solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Hints {
    /// Upper and lower half, not left and right.
    flip: bool,
    /// Averages of 5 bit, the second near the first; not of 4 bit.
    near: bool,
    /// Rows of [`MOVES`].
    moves: [u8; 2],
    /// How averages are rounded.
    bias: u8,
    /// A row of [`ALPHA_MOVES`] and, from bit 4, what it is multiplied by.
    alpha: u8,
}

impl Hints {
    /// Leaves out the hints of a block.
    pub(super) fn skip(mode: &Mode, fields: &mut Reader) {
        let bc1 = if mode.few_hints { 1 } else { 2 };
        let bias = if mode.few_hints { 0 } else { 5 };
        for count in [bc1, 8, bias, if mode.channels == 3 { 0 } else { 8 }] {
            fields.take(count);
        }
    }

    pub(super) fn put(&self, mode: &Mode, fields: &mut Writer) {
        fields.put(0, if mode.few_hints { 1 } else { 2 });
        fields.put(u8::from(self.flip) | u8::from(self.near) << 1 | self.moves[0] << 2 | self.moves[1] << 5, 8);
        if !mode.few_hints {
            fields.put(self.bias, 5);
        }
        if mode.channels != 3 {
            fields.put(self.alpha, 8);
        }
    }

    /// For a block that decodes to these texels.
    pub(super) fn new(mode: &Mode, texels: &Texels, search: Search) -> Self {
        let colours = search.ways(texels).map(|(flip, near)| Self::colours(mode, texels, flip, near));
        let (_, best) = colours.min_by_key(|(error, _)| *error).expect("there is a way at least");
        Self { alpha: if mode.channels == 3 { 0 } else { alpha(texels) }, ..best }
    }

    /// The best of the rest, and the squared differences that ETC1 leaves, but for those of values beyond 0 and 255.
    fn colours(mode: &Mode, texels: &Texels, flip: bool, near: bool) -> (i32, Self) {
        let most = if near { 31 } else { 15 };
        let sums = [0, 1].map(|half| {
            let mut sum = [0; 3];
            for i in texels_of(flip, half) {
                (0..3).for_each(|c| sum[c] += i32::from(texels[i][c]));
            }
            sum
        });
        let value = |v: i32| if near { v << 3 | v >> 2 } else { v * 17 };
        let mut bases = sums.map(|sum| sum.map(|v| (v * most + 1020) / 2040));
        let mut bias = 0;
        if !mode.few_hints {
            // What each channel of each half loses by each way to round it.
            let mut losses = [[0; 4]; 6];
            for (i, losses) in losses.iter_mut().enumerate() {
                let (sum, base) = (sums[i / 3][i % 3], bases[i / 3][i % 3]);
                for (by, loss) in (-2..).zip(losses) {
                    let off = sum - 8 * value(moved(base, most, by));
                    *loss = off * off;
                }
            }
            let loss = |way: &[i8; 6]| -> i32 { (0..6).map(|i| losses[i][(way[i] + 2) as usize & 3]).sum() };
            bias = (0..32).min_by_key(|bias| loss(&BIASES[*bias])).unwrap_or(0);
            for i in 0..6 {
                bases[i / 3][i % 3] = moved(bases[i / 3][i % 3], most, i32::from(BIASES[bias][i]));
            }
        }
        if near {
            bases[1] = std::array::from_fn(|c| bases[0][c] + (bases[1][c] - bases[0][c]).clamp(-4, 3));
        }
        let bases = bases.map(|base| base.map(value));
        let bias = bias as u8;
        let [first, second] = [0, 1].map(|half| moves(texels, flip, half, bases[half]));
        (first.0 + second.0, Self { flip, near, moves: [first.1, second.1], bias, alpha: 0 })
    }
}

impl Search {
    /// Ways to be tried: flipped or not, averages near each other or not.
    fn ways(self, texels: &Texels) -> impl Iterator<Item = (bool, bool)> {
        let all = [(false, false), (false, true), (true, false), (true, true)];
        let likely = match self {
            Search::Few => Some(likely(texels)),
            Search::Many => None,
        };
        all.into_iter().filter(move |way| likely.is_none_or(|likely| likely == *way))
    }
}

/// The halves with averages farther apart, and 5 bit if these allow it.
fn likely(texels: &Texels) -> (bool, bool) {
    let mut quarters = [[0i32; 3]; 4];
    for (i, texel) in texels.iter().enumerate() {
        (0..3).for_each(|c| quarters[i / 8 * 2 + i / 2 % 2][c] += i32::from(texel[c]));
    }
    let [a, b, c, d] = quarters;
    let across: [i32; 3] = std::array::from_fn(|i| b[i] + d[i] - a[i] - c[i]);
    let down: [i32; 3] = std::array::from_fn(|i| c[i] + d[i] - a[i] - b[i]);
    let length = |v: [i32; 3]| v.iter().map(|v| v * v).sum::<i32>();
    let flip = length(down) > length(across);
    // Eight texels; a step of 5 bit is 8.2 values.
    (flip, (if flip { down } else { across }).iter().all(|v| (-4 * 66..3 * 66 + 33).contains(v)))
}

/// The eight texels of a half.
fn texels_of(flip: bool, half: usize) -> impl Iterator<Item = usize> {
    (0..8).map(move |i| if flip { 8 * half + i } else { i / 2 * 4 + 2 * half + i % 2 })
}

/// Squared differences that the best row of moves leaves a half, and the row.
fn moves(texels: &Texels, flip: bool, half: usize, base: [i32; 3]) -> (i32, u8) {
    // What transcoders choose moves by: brightness, in 256ths.
    let bright = |v: [i32; 3]| 54 * v[0] + 183 * v[1] + 19 * v[2];
    let mut off = [(0, 0, 0); 8];
    for (to, i) in off.iter_mut().zip(texels_of(flip, half)) {
        let d: [i32; 3] = std::array::from_fn(|c| i32::from(texels[i][c]) - base[c]);
        *to = (bright(d), d.iter().sum(), d.iter().map(|d| d * d).sum());
    }
    let error = |[little, lot]: [i32; 2]| -> i32 {
        let one = |(bright, sum, square): (i32, i32, i32)| {
            let by = if bright.abs() < 128 * (little + lot) { little } else { lot };
            let by = if bright < 0 { -by } else { by };
            square - 2 * by * sum + 3 * by * by
        };
        off.iter().map(|off| one(*off)).sum()
    };
    (0..8).map(|row| (error(MOVES[usize::from(row)]), row)).min().expect("there are eight rows")
}

/// How a bias moves the red, green and blue average of the first half and of the second, in steps.
#[rustfmt::skip]
static BIASES: [[i8; 6]; 32] = {
    let mut biases = [[0; 6]; 32];
    let mut bias = 0;
    while bias < 32 {
        let thirds = [bias % 3 - 1, bias / 3 % 3 - 1, bias / 9 % 3 - 1];
        let mut i = 0;
        while i < 6 {
            biases[bias as usize][i] = thirds[i % 3];
            i += 1;
        }
        bias += 1;
    }
    // Those that would be twice or beyond the last: one average, all averages of one half, or all.
    biases[2] = [-1, 0, 0, 0, 0, 0];
    biases[5] = [0, -1, 0, 0, 0, 0];
    biases[6] = [0, 0, -1, 0, 0, 0];
    biases[7] = [1, 0, 0, 0, 0, 0];
    biases[11] = [0, 1, 0, 0, 0, 0];
    biases[15] = [0, 0, 1, 0, 0, 0];
    biases[18] = [0, 0, 0, -1, 0, 0];
    biases[19] = [0, 0, 0, 0, -1, 0];
    biases[20] = [0, 0, 0, 0, 0, -1];
    biases[21] = [0, 0, 0, 1, 0, 0];
    biases[24] = [0, 0, 0, 0, 1, 0];
    biases[8] = [0, 0, 0, 0, 0, 1];
    biases[10] = [-2; 6];
    biases[27] = [-1, -1, -1, 0, 0, 0];
    biases[28] = [1, 1, 1, -1, -1, -1];
    biases[29] = [0, 0, 0, 1, 1, 1];
    biases[30] = [0, 0, 0, -1, -1, -1];
    biases[31] = [1, 1, 1, 0, 0, 0];
    biases
};

/// An average of 0 to `most`, moved; from both ends of the scale one step more inwards, and away from them otherwise.
fn moved(value: i32, most: i32, by: i32) -> i32 {
    match value {
        0 if by == -2 => 3,
        0 => by + 1,
        _ if value == most => most + by - 1,
        _ if (0..=most).contains(&(value + by)) => value + by,
        _ => value - by,
    }
}

/// The hint for alpha: a row, and what it is multiplied by.
fn alpha(texels: &Texels) -> u8 {
    let alphas = texels.map(|texel| i16::from(texel[3]));
    let (low, high) = alphas.iter().fold((255, 0), |(low, high), a| (low.min(*a), high.max(*a)));
    let mut best = (i32::MAX, 0);
    for (row, moves) in (0..).zip(&ALPHA_MOVES) {
        let (least, most) = (moves[3], moves[7]);
        let base =
            (f32::from(low) + f32::from(high - low) * f32::from(-least) / f32::from(most - least)).round() as i16;
        let fitting = (high - low) / (most - least);
        for times in [fitting, fitting + 1].map(|times| times.clamp(1, 15)) {
            let mut off = [i16::MAX; 16];
            for by in moves {
                let value = (base + by * times).clamp(0, 255);
                off.iter_mut().zip(&alphas).for_each(|(off, a)| *off = (*off).min((value - a).abs()));
            }
            let error = off.iter().map(|off| i32::from(*off) * i32::from(*off)).sum();
            best = best.min((error, row | (times as u8) << 4));
        }
    }
    best.1
}

/// Of a solid block: adds the one of ETC1's colours that is nearest.
pub(super) fn put_solid(colour: [u8; 4], fields: &mut Writer) {
    let mut best = (i32::MAX, [0; 3], 0, 0, false);
    for (near, moves) in [(true, MOVES), (false, MOVES)] {
        let (most, expand) = if near { (31, 0) } else { (15, 1) };
        let value = |v: i32| if expand == 0 { v << 3 | v >> 2 } else { v * 17 };
        for (row, [little, lot]) in moves.into_iter().enumerate() {
            for (way, by) in [-lot, -little, little, lot].into_iter().enumerate() {
                let mut error = 0;
                let base = std::array::from_fn(|c| {
                    let wanted = i32::from(colour[c]);
                    let about = ((wanted - by).clamp(0, 255) * most + 127) / 255;
                    let bases = (about - 1).max(0)..=(about + 1).min(most);
                    let off = |base: &i32| ((value(*base) + by).clamp(0, 255) - wanted).abs();
                    let base = bases.min_by_key(off).expect("a base is near");
                    error += off(&base) * off(&base);
                    base as u8
                });
                if error < best.0 {
                    best = (error, base, row as u8, way as u8, near);
                }
            }
        }
    }
    let (_, base, row, way, near) = best;
    fields.put(u8::from(near), 1);
    fields.put(row, 3);
    fields.put(way, 2);
    base.iter().for_each(|v| fields.put(*v, 5));
}
