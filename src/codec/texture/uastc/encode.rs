//! From texels to blocks: which modes are worth trying, and the best of those tried.

use super::bits::Writer;
use super::block::{self, Block, MODES, Patterns, TWO, TWO_OF_THREE};
use super::fit::{Line, Points, fit};
use super::hints::{self, Hints};
use super::statistics::{PATTERNS, Planes, Scatter, of_patterns, products, scatter};
use crate::codec::texture::Effort;

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Search {
    Few,
    Many,
}

/// Encodes four rows of RGBA, a multiple of 4 texels wide, to a row of blocks.
pub(in crate::codec::texture) fn encode(strip: &[u8], effort: Effort, blocks: &mut [u8]) {
    let search = match effort {
        Effort::Fast => Search::Few,
        Effort::Slow => Search::Many,
    };
    let texels = strip.as_chunks::<4>().0;
    let width = texels.len() / 4;
    for (x, block) in (0..width).step_by(4).zip(blocks.as_chunks_mut::<16>().0) {
        let texels = std::array::from_fn(|i| texels[i / 4 * width + x + i % 4]);
        *block = encode_block(&texels, search);
    }
}

pub(super) fn encode_block(texels: &super::Texels, search: Search) -> [u8; 16] {
    if texels.iter().all(|texel| texel == &texels[0]) {
        let mut fields = Writer::default();
        block::pack_solid(texels[0], &mut fields);
        hints::put_solid(texels[0], &mut fields);
        return fields.block();
    }
    let planes: Planes = std::array::from_fn(|c| std::array::from_fn(|i| f32::from(texels[i][c])));
    let block = if texels.iter().all(|texel| texel[3] == 255) {
        best::<3>(&planes, search)
    } else {
        best::<4>(&planes, search)
    };
    block.pack(&Hints::new(&MODES[block.mode], &block.texels(), search))
}

/// A way to encode a block, and the squared differences to be expected of it.
#[derive(Clone, Copy, Debug)]
struct Way {
    mode: usize,
    /// A pattern, or the channel apart.
    choice: usize,
    expected: f32,
}

/// The best block of the ways that promise most.
fn best<const C: usize>(planes: &Planes, search: Search) -> Block {
    let mut ways = ways::<C>(planes, search);
    let tried = match search {
        Search::Few => 2,
        Search::Many => 16,
    };
    if ways.len() > tried {
        ways.select_nth_unstable_by(tried - 1, |a, b| a.expected.total_cmp(&b.expected));
        ways.truncate(tried);
    }
    ways.sort_unstable_by(|a, b| a.expected.total_cmp(&b.expected));
    let mut best: Option<(Block, f32)> = None;
    for way in ways {
        let found = try_way::<C>(planes, way, search);
        if best.as_ref().is_none_or(|best| found.1 < best.1) {
            best = Some(found);
        }
        if best.as_ref().is_some_and(|best| best.1 == 0.0) {
            break;
        }
    }
    let (mut block, _) = best.expect("a way was tried");
    block.anchor();
    block
}

/// All ways, with what is to be expected of each.
fn ways<const C: usize>(planes: &Planes, search: Search) -> Vec<Way> {
    let (one, two, apart): (&[usize], &[(usize, Patterns)], &[usize]) = match (C, search) {
        (3, _) => (&[0, 1, 5, 18], &[(2, Patterns::Two), (4, Patterns::Two), (7, Patterns::TwoOfThree)], &[6]),
        (_, Search::Few) => (&[10, 12, 14], &[], &[11]),
        (_, Search::Many) => (&[10, 12, 14], &[(9, Patterns::Two)], &[11, 13]),
    };
    let mut ways = Vec::with_capacity(160);
    let products = products(planes);
    let all = [0, 1, 2, 3];
    let whole = scatter(&products, &all[..C]);
    for mode in one {
        ways.push(Way { mode: *mode, choice: 0, expected: expected::<C>(*mode, whole) });
    }
    for mode in apart {
        for choice in 0..C {
            let others: [usize; 3] = std::array::from_fn(|i| if i < choice { i } else { i + 1 });
            let Scatter { along, about } = scatter(&products, &others[..C - 1]);
            let both = Scatter { along: along + products[choice][choice], about };
            ways.push(Way { mode: *mode, choice, expected: expected::<C>(*mode, both) });
        }
    }
    let least = ways.iter().map(|way| way.expected).fold(f32::INFINITY, f32::min);
    if !two.is_empty() && (search == Search::Many || least > 16.0 * C as f32 * GOOD) {
        let found: [Scatter; PATTERNS] = of_patterns::<C>(planes);
        for (mode, patterns) in two {
            let (from, count) = match patterns {
                Patterns::TwoOfThree => (TWO.len(), TWO_OF_THREE.len()),
                _ => (0, TWO.len()),
            };
            let found = found[from..][..count].iter().enumerate();
            let found =
                found.map(|(choice, scatter)| Way { mode: *mode, choice, expected: expected::<C>(*mode, *scatter) });
            match search {
                Search::Few => ways.extend(found.min_by(|a, b| a.expected.total_cmp(&b.expected))),
                Search::Many => ways.extend(found),
            }
        }
    }
    ways
}

/// What is left of scatter along a line by as many weights as a mode has, all that lies about it, and what the scale of
/// ends adds.
fn expected<const C: usize>(mode: usize, scatter: Scatter) -> f32 {
    let mode = &MODES[mode];
    let steps = ((1 << mode.weight_bits) - 1) as f32;
    let step = 255.0 / (mode.scale.count - 1) as f32;
    scatter.about + scatter.along / (steps * steps) + 16.0 * C as f32 * step * step * QUANTISED
}

/// Squared difference of a value that is good enough not to look for patterns, where little is tried.
const GOOD: f32 = 4.0;

/// What a scale adds, of the square of its step: less than the 1/12 of rounding, for weights make up for some of it.
const QUANTISED: f32 = 0.03;

fn try_way<const C: usize>(planes: &Planes, way: Way, search: Search) -> (Block, f32) {
    let mode = &MODES[way.mode];
    let mut block = Block { mode: way.mode, pattern: 0, apart: None, ends: [[[0; 2]; 4]; 3], weights: [[0; 16]; 2] };
    let mut error = 0.0;
    let code = |rank: u8| mode.scale.codes[usize::from(rank)];
    if mode.dual {
        block.apart = Some(way.choice);
        let single = Points { at: [planes[way.choice]], counts: [1.0; 16] };
        let line = run(&single, mode, search);
        block.ends[0][way.choice] = line.ends[0].map(code);
        block.weights[1] = line.weights;
        error += line.error;
        let other = |i: usize| if i < way.choice { i } else { i + 1 };
        if C == 3 {
            let line = run(&Points { at: [planes[other(0)], planes[other(1)]], counts: [1.0; 16] }, mode, search);
            (0..2).for_each(|c| block.ends[0][other(c)] = line.ends[c].map(code));
            block.weights[0] = line.weights;
            error += line.error;
        } else {
            let at = [planes[other(0)], planes[other(1)], planes[other(2)]];
            let line = run(&Points { at, counts: [1.0; 16] }, mode, search);
            (0..3).for_each(|c| block.ends[0][other(c)] = line.ends[c].map(code));
            block.weights[0] = line.weights;
            error += line.error;
        }
        return (block, error);
    }
    block.pattern = way.choice;
    let at: [[f32; 16]; C] = std::array::from_fn(|c| planes[c]);
    let lines = if mode.patterns == Patterns::None { 1 } else { 2 };
    for number in 0..lines {
        let on = |i: usize| mode.patterns.line(way.choice, i) == number;
        let line = run(&Points { at, counts: std::array::from_fn(|i| f32::from(u8::from(on(i)))) }, mode, search);
        (0..C).for_each(|c| block.ends[number][c] = line.ends[c].map(code));
        (0..16).filter(|i| on(*i)).for_each(|i| block.weights[0][i] = line.weights[i]);
        error += line.error;
    }
    (block, error)
}

fn run<const C: usize>(points: &Points<C>, mode: &block::Mode, search: Search) -> Line<C> {
    match search {
        Search::Few => fit(points, mode.scale, mode.weight_bits, 2, &[1.0]),
        Search::Many => fit(points, mode.scale, mode.weight_bits, 6, &[1.0, 0.9, 1.1]),
    }
}
