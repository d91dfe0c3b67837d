//! A line through texels: its ends on their scale, and where each texel lies.

use super::scale::{Scale, WEIGHTS, between};

/// Texels of `C` channels, 0 to 255, and which of them count.
pub(super) struct Points<const C: usize> {
    pub(super) at: [[f32; 16]; C],
    pub(super) counts: [f32; 16],
}

/// A line: ranks of its ends by channel, indices of weights by texel, and the squared differences that it leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<const C: usize> {
    pub(super) ends: [[u8; 2]; C],
    pub(super) weights: [u8; 16],
    pub(super) error: f32,
}

/// Added and taken away, rounds to an integer.
const ROUND: f32 = 12_582_912.0;

/// Ends as numbers.
type Ends<const C: usize> = [[f32; 2]; C];

/// Fits a line: along the axis of most scatter at first, then in turns ends for the weights and weights for the ends. At
/// the end, every texel has the best weight there is.
pub(super) fn fit<const C: usize>(
    points: &Points<C>,
    scale: &Scale,
    bits: u32,
    turns: usize,
    starts: &[f32],
) -> Line<C> {
    let ends = first_ends(points);
    let mut best = Line { ends: [[0; 2]; C], weights: [0; 16], error: f32::INFINITY };
    for stretch in starts {
        let ends = ends.map(|[low, high]| {
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) * stretch);
            [middle - half, middle + half]
        });
        let mut weights = nearest_weights(points, &ends, bits);
        let mut last = f32::INFINITY;
        for _ in 0..turns {
            let ends = ends_for(points, &weights, scale);
            let line = with_ends(points, ends, scale, bits);
            if line.error < best.error {
                best = line;
            }
            if line.error >= last || line.error == 0.0 {
                break;
            }
            last = line.error;
            weights = line.weights.map(|index| f32::from(WEIGHTS[bits as usize][usize::from(index)]) / 64.0);
        }
    }
    best
}

/// The ends of the texels on the axis of most scatter.
fn first_ends<const C: usize>(points: &Points<C>) -> Ends<C> {
    let Points { at, counts } = points;
    let count = 1.0 / counts.iter().sum::<f32>();
    let mut centred = *at;
    let means: [f32; C] = std::array::from_fn(|c| dot(&at[c], counts) * count);
    for c in 0..C {
        for i in 0..16 {
            centred[c][i] = (at[c][i] - means[c]) * counts[i];
        }
    }
    let mut axis = [1.0; C];
    if C > 1 {
        let mut products = [[0.0; C]; C];
        for a in 0..C {
            for b in a..C {
                products[a][b] = dot(&centred[a], &centred[b]);
                products[b][a] = products[a][b];
            }
        }
        // The largest column is a start that is not at right angles to the axis.
        let longest = (0..C).max_by(|a, b| products[*a][*a].total_cmp(&products[*b][*b])).unwrap_or(0);
        axis = products[longest];
        for _ in 0..4 {
            let most = axis.iter().fold(1e-30f32, |most, v| most.max(v.abs()));
            let before = axis.map(|v| v / most);
            axis = products.map(|row| row.iter().zip(&before).map(|(a, b)| a * b).sum());
        }
    }
    let length = axis.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length <= 0.0 {
        return means.map(|mean| [mean; 2]);
    }
    axis = axis.map(|v| v / length);
    let mut along = [0.0; 16];
    for c in 0..C {
        for i in 0..16 {
            along[i] += centred[c][i] * axis[c];
        }
    }
    // Texels that do not count lie at 0, where the mean is.
    let (low, high) = along.iter().fold((0f32, 0f32), |(low, high), v| (low.min(*v), high.max(*v)));
    std::array::from_fn(|c| [means[c] + low * axis[c], means[c] + high * axis[c]])
}

fn dot(a: &[f32; 16], b: &[f32; 16]) -> f32 {
    let mut lanes = [0.0; 4];
    for i in 0..16 {
        lanes[i % 4] += a[i] * b[i];
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// Weights as if they were spread evenly: rounded places between two ends.
fn nearest_weights<const C: usize>(points: &Points<C>, ends: &Ends<C>, bits: u32) -> [f32; 16] {
    let steps = ((1 << bits) - 1) as f32;
    let length: f32 = ends.iter().map(|[low, high]| (high - low) * (high - low)).sum();
    let scale = if length > 0.0 { steps / length } else { 0.0 };
    let mut place = [0.0; 16];
    for c in 0..C {
        let [low, high] = ends[c];
        for i in 0..16 {
            place[i] += (points.at[c][i] - low) * (high - low);
        }
    }
    place.map(|v| ((v * scale).clamp(0.0, steps) + ROUND - ROUND) / steps)
}

/// The ends on their scale that leave the least squared differences if weights are as they are: of those around the
/// low end that is best of all numbers, each with the high end that is best for it.
fn ends_for<const C: usize>(points: &Points<C>, weights: &[f32; 16], scale: &Scale) -> [[u8; 2]; C] {
    let mut shares = [[0.0; 16]; 2];
    for i in 0..16 {
        shares[0][i] = (1.0 - weights[i]) * points.counts[i];
        shares[1][i] = weights[i] * points.counts[i];
    }
    let [low, high] = &shares;
    let (ll, lh, hh) = (dot(low, low), dot(low, high), dot(high, high));
    let determinant = ll * hh - lh * lh;
    std::array::from_fn(|c| {
        let values = &points.at[c];
        let (lv, hv) = (dot(low, values), dot(high, values));
        if determinant < 1e-3 * (ll + hh) {
            // One weight for all: any pair of ends with the mean at its place will do.
            let rank = scale.rank((lv + hv) / dot(&points.counts, &points.counts));
            return [rank, rank];
        }
        let middle = scale.rank((lv * hh - hv * lh) / determinant);
        let mut best = ([0; 2], f32::INFINITY);
        for a in middle.saturating_sub(1)..=middle.saturating_add(1).min((scale.count - 1) as u8) {
            let first = f32::from(scale.values[usize::from(a)]);
            let b = if hh > 1e-6 { scale.rank((hv - lh * first) / hh) } else { a };
            let second = f32::from(scale.values[usize::from(b)]);
            let error = first * (ll * first + 2.0 * (lh * second - lv)) + second * (hh * second - 2.0 * hv);
            if error < best.1 {
                best = ([a, b], error);
            }
        }
        best.0
    })
}

/// The best weights for ends, by trying all.
fn with_ends<const C: usize>(points: &Points<C>, ends: [[u8; 2]; C], scale: &Scale, bits: u32) -> Line<C> {
    let ends_of = ends.map(|ends| ends.map(|rank| scale.values[usize::from(rank)]));
    let (mut least, mut index) = ([f32::INFINITY; 16], [0.0f32; 16]);
    for (number, weight) in WEIGHTS[bits as usize][..1 << bits].iter().enumerate() {
        let colour = ends_of.map(|[low, high]| f32::from(between(low, high, *weight)));
        let number = number as f32;
        let mut error = [0.0; 16];
        for c in 0..C {
            for i in 0..16 {
                let off = points.at[c][i] - colour[c];
                error[i] += off * off;
            }
        }
        for i in 0..16 {
            let better = error[i] < least[i];
            index[i] = if better { number } else { index[i] };
            least[i] = if better { error[i] } else { least[i] };
        }
    }
    Line { ends, weights: index.map(|v| v as u8), error: dot(&least, &points.counts) }
}
