//! What a block's texels tell before anything is tried: how far they scatter about a line through them, through some of
//! them, or through some of their channels.

use super::block::{TWO, TWO_OF_THREE};

/// Texels by channel.
pub(super) type Planes = [[f32; 16]; 4];

/// Patterns of two lines, those of both kinds.
pub(super) const PATTERNS: usize = TWO.len() + TWO_OF_THREE.len();

/// Rounded up for vectors.
const LANES: usize = 56;

/// For each texel, which patterns have it on the second line.
static SECOND: [[f32; LANES]; 16] = {
    let mut second = [[0.0; LANES]; 16];
    let mut texel = 0;
    while texel < 16 {
        let mut pattern = 0;
        while pattern < PATTERNS {
            let mask = if pattern < TWO.len() { TWO[pattern] } else { TWO_OF_THREE[pattern - TWO.len()] };
            second[texel][pattern] = (mask >> texel & 1) as f32;
            pattern += 1;
        }
        texel += 1;
    }
    second
};

/// What a set of points scatters: along the line that fits best, and about it, each the sum of squares.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scatter {
    pub(super) along: f32,
    pub(super) about: f32,
}

/// Sums of squares and products about the mean, of four channels.
pub(super) fn products(planes: &Planes) -> [[f32; 4]; 4] {
    let mut centred = *planes;
    for plane in &mut centred {
        let mean = plane.iter().sum::<f32>() / 16.0;
        plane.iter_mut().for_each(|v| *v -= mean);
    }
    let product = |a: usize, b: usize| centred[a].iter().zip(&centred[b]).map(|(a, b)| a * b).sum();
    let mut products = [[0.0; 4]; 4];
    for a in 0..4 {
        for b in a..4 {
            products[a][b] = product(a, b);
            products[b][a] = products[a][b];
        }
    }
    products
}

/// The scatter of some of the channels.
///
/// Of a symmetric matrix, trace and sum of squares are those of its eigenvalues; two of them follow if there are no more
/// than two that matter. So it is with normals, which lie on a surface, and nearly so with most else.
pub(super) fn scatter(products: &[[f32; 4]; 4], channels: &[usize]) -> Scatter {
    let (mut trace, mut squares) = (0.0, 0.0);
    for a in channels {
        trace += products[*a][*a];
        squares += channels.iter().map(|b| products[*a][*b] * products[*a][*b]).sum::<f32>();
    }
    split(trace, squares)
}

fn split(trace: f32, squares: f32) -> Scatter {
    let about = 0.5 * (trace - (2.0 * squares - trace * trace).max(0.0).sqrt());
    Scatter { along: trace - about, about }
}

/// The scatter of both lines together, of each pattern.
pub(super) fn of_patterns<const C: usize>(planes: &Planes) -> [Scatter; PATTERNS] {
    let means: [f32; C] = std::array::from_fn(|c| planes[c].iter().sum::<f32>() / 16.0);
    // Sums over the second line; those over the first are what is left.
    let mut count = [0.0; LANES];
    let mut sums = [[0.0; LANES]; C];
    let mut products = [[[0.0; LANES]; C]; C];
    let mut totals = [[0.0; C]; C];
    for i in 0..16 {
        let second = &SECOND[i];
        let centred: [f32; C] = std::array::from_fn(|c| planes[c][i] - means[c]);
        add(&mut count, second, 1.0);
        for a in 0..C {
            add(&mut sums[a], second, centred[a]);
            for b in a..C {
                add(&mut products[a][b], second, centred[a] * centred[b]);
                totals[a][b] += centred[a] * centred[b];
            }
        }
    }
    // (Lanes beyond the last pattern are of no use, and of no number.)
    let (mut traces, mut squares) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
    for a in 0..C {
        for b in a..C {
            let times = if a == b { 1.0 } else { 2.0 };
            for p in 0..LANES {
                // About the common mean, the sums of both lines are each other's negative.
                let shift = sums[a][p] * sums[b][p];
                let first = totals[a][b] - products[a][b][p] - shift / (16.0 - count[p]);
                let second = products[a][b][p] - shift / count[p];
                squares[0][p] += times * first * first;
                squares[1][p] += times * second * second;
                if a == b {
                    traces[0][p] += first;
                    traces[1][p] += second;
                }
            }
        }
    }
    let mut about = [0.0; LANES];
    for p in 0..LANES {
        about[p] = split(traces[0][p], squares[0][p]).about + split(traces[1][p], squares[1][p]).about;
    }
    std::array::from_fn(|p| Scatter { along: traces[0][p] + traces[1][p] - about[p], about: about[p] })
}

fn add(to: &mut [f32; LANES], from: &[f32; LANES], times: f32) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += from * times);
}
