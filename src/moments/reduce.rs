//! Footprints of any size, with fractional borders.

use super::{Block, Kind, Layout, merge_cov, merge_mean};
use crate::image::Span;

/// Buffers that [`reduce_rows`] keeps between calls.
#[derive(Default)]
pub struct Scratch {
    source: Block,
    row: Block,
    shares: Vec<f32>,
}

/// One row of a coarser level: merges the source rows of `span_y`, each first merged along x by `spans_x`, into
/// the single row of `out`. `source` fills a one-row block with source row `y`.
pub fn reduce_rows(
    layout: &Layout,
    mut source: impl FnMut(usize, &mut Block),
    span_y: &Span,
    spans_x: &[Span],
    out: &mut Block,
    scratch: &mut Scratch,
) {
    let mut area = 0.0;
    for (j, &height) in span_y.weights.iter().enumerate() {
        source(span_y.first + j, &mut scratch.source);
        let target = if j == 0 { &mut *out } else { &mut scratch.row };
        reduce_row(layout, &scratch.source, spans_x, height, target, &mut scratch.shares);
        if j > 0 {
            join_rows(layout, out, &scratch.row, area, height);
        }
        area += height;
    }
}

/// Merges one row along x; weights are scaled by the share of the row's height that lies in the footprint.
fn reduce_row(layout: &Layout, source: &Block, spans: &[Span], height: f32, out: &mut Block, shares: &mut Vec<f32>) {
    out.resize(layout, spans.len(), 1);
    for (x, span) in spans.iter().enumerate() {
        let range = span.first..span.first + span.weights.len();
        let cells = |slot: usize| &source.row(slot, 0)[range.clone()];
        shares.clear();
        shares.extend(cells(0).iter().zip(&span.weights).map(|(w, area)| w * area));
        let total: f32 = shares.iter().sum();
        shares.iter_mut().for_each(|s| *s /= total);
        let area: f32 = span.weights.iter().sum();
        out.row_mut(0, 0)[x] = total * height;
        for (slot, &kind) in layout.kinds.iter().enumerate().skip(1) {
            let values = cells(slot);
            let first = values[0];
            out.row_mut(slot, 0)[x] = match kind {
                Kind::Weight => unreachable!("the weight is the first slot alone"),
                Kind::Mean => first + values.iter().zip(shares.iter()).map(|(v, s)| s * (v - first)).sum::<f32>(),
                Kind::Plain => {
                    first + values.iter().zip(&span.weights).map(|(v, w)| w / area * (v - first)).sum::<f32>()
                }
                Kind::Cov(a, b) => {
                    let (mean_a, mean_b) = (out.row(a, 0)[x], out.row(b, 0)[x]);
                    let pairs = cells(a).iter().zip(cells(b));
                    let terms = values.iter().zip(pairs).map(|(c, (a, b))| c + (a - mean_a) * (b - mean_b));
                    terms.zip(shares.iter()).map(|(term, share)| share * term).sum()
                }
            };
        }
    }
}

/// Joins `row`, `height` texels of area a column, into `sum`, which has `area` of them.
fn join_rows(layout: &Layout, sum: &mut Block, row: &Block, area: f32, height: f32) {
    let plain = [area / (area + height), height / (area + height)];
    for x in 0..sum.width() {
        let weights = [sum.row(0, 0)[x], row.row(0, 0)[x]];
        let total = weights[0] + weights[1];
        let share = weights.map(|w| w / total);
        // Covariances read the parts' means, so the slots are walked backwards: covariances follow their means.
        let pair = |sum: &Block, slot: usize| [sum.row(slot, 0)[x], row.row(slot, 0)[x]];
        for (slot, &kind) in layout.kinds.iter().enumerate().rev() {
            let value = match kind {
                Kind::Weight => total,
                Kind::Mean => merge_mean(share, pair(sum, slot)),
                Kind::Plain => merge_mean(plain, pair(sum, slot)),
                Kind::Cov(a, b) => {
                    let (a, b) = (pair(sum, a), pair(sum, b));
                    let means = [merge_mean(share, a), merge_mean(share, b)];
                    merge_cov(share, pair(sum, slot), a, b, means)
                }
            };
            sum.row_mut(slot, 0)[x] = value;
        }
    }
}
