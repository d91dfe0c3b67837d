//! One half vector against the texels under one kernel.

use glam::{DVec2, DVec3, Vec2};

use super::chance::{Chance, Die};
use super::element::stretched_lobe;
use super::errors;
use super::ways::{Range, Tails, Visits, Ways};
use super::{Block, Footprint, Pyramid, SlopeMap};

/// A half vector and all that is asked about it.
pub(super) struct Query<'a> {
    pub(super) map: &'a SlopeMap,
    pyramid: &'a Pyramid,
    pub(super) footprint: &'a Footprint,
    /// Axes of the frame of h.
    frame: [DVec3; 3],
    /// `1 + d^2` of the cut.
    pub(super) cut: f64,
    pub(super) ways: Ways,
    pub(super) visits: Visits,
    pub(super) chance: Chance,
}

impl<'a> Query<'a> {
    /// None for half vectors that are not above the surface.
    pub(super) fn new(
        map: &'a SlopeMap,
        pyramid: &'a Pyramid,
        footprint: &'a Footprint,
        h: DVec3,
        tails: Tails,
    ) -> Option<Self> {
        let h = h.try_normalize().filter(|h| h.z > 0.0)?;
        let (x, y) = h.any_orthonormal_pair();
        let cut = match tails {
            Tails::Kept => f64::INFINITY,
            Tails::Cut(reach) => 1.0 + reach * reach,
        };
        Some(Self {
            map,
            pyramid,
            footprint,
            frame: [x, y, h],
            cut,
            ways: Ways::BEST,
            visits: Visits::default(),
            chance: Chance::default(),
        })
    }

    /// The sum over all blocks at the tolerance of now.
    pub(super) fn sum(&mut self) -> f64 {
        let Footprint { centre, half, .. } = *self.footprint;
        let (columns, rows) = self.map.size();
        // Blocks about as large as the kernel, in each repetition of the map that it touches.
        let level = (half.max_element().log2().ceil().max(1.0) as usize).min(self.pyramid.top());
        let (first, last) = (centre - half, centre + half);
        let tiles = |first: f64, last: f64, size: usize| {
            ((first / size as f64).floor() as i64)..=((last / size as f64).floor() as i64)
        };
        let blocks = |first: f64, last: f64, origin: f64, size: usize| {
            let cell = |x: f64| ((x - origin).floor().clamp(0.0, size as f64 - 1.0) as usize) >> level;
            cell(first)..=cell(last)
        };
        let mut sum = 0.0;
        for tile_y in tiles(first.y, last.y, rows) {
            for tile_x in tiles(first.x, last.x, columns) {
                let origin = DVec2::new(tile_x as f64 * columns as f64, tile_y as f64 * rows as f64);
                for y in blocks(first.y, last.y, origin.y, rows) {
                    for x in blocks(first.x, last.x, origin.x, columns) {
                        sum += self.block(level, (x, y), origin, 1.0);
                    }
                }
            }
        }
        sum.max(0.0)
    }

    /// The coordinates of a normal in the frame of h.
    #[inline]
    pub(super) fn seen(&self, s: DVec2) -> DVec3 {
        let [x, y, h] = self.frame;
        let n = DVec3::new(-s.x, -s.y, 1.0);
        DVec3::new(n.dot(x), n.dot(y), n.dot(h))
    }

    /// Integral over a block; `weight` is as in [`Query::settle`].
    fn block(&mut self, level: usize, (x, y): (usize, usize), origin: DVec2, weight: f64) -> f64 {
        let (columns, rows) = self.map.size();
        let (x0, y0) = (x << level, y << level);
        let (x1, y1) = (((x + 1) << level).min(columns), ((y + 1) << level).min(rows));
        let half = 0.5 * DVec2::new((x1 - x0) as f64, (y1 - y0) as f64);
        let centre = origin + DVec2::new(x0 as f64, y0 as f64) + half;
        if self.footprint.misses(centre, half) {
            return 0.0;
        }
        self.visits.nodes += 1;
        let block = self.pyramid.block(level, x, y);
        let Block { min, max, alpha, .. } = *block;
        let corners = [min, Vec2::new(max.x, min.y), Vec2::new(min.x, max.y), max].map(|s| self.seen(s.as_dvec2()));
        let range = Range::new(&corners, 1.0 / f64::from(alpha[1]));
        if self.ways.prune && range.near > self.cut {
            return 0.0;
        }
        let (side, ways) = (2.0 * half.max_element() * self.footprint.inverse_minor, &self.ways);
        // Cells of other widths have other cuts too.
        let even = alpha[1] <= 1.02 * alpha[0];
        let below = |query: &mut Self, weight: f64| {
            let mut sum = 0.0;
            if level > 1 {
                let (below_columns, below_rows) = (columns.div_ceil(1 << (level - 1)), rows.div_ceil(1 << (level - 1)));
                for j in 2 * y..(2 * y + 2).min(below_rows) {
                    for i in 2 * x..(2 * x + 2).min(below_columns) {
                        sum += query.block(level - 1, (i, j), origin, weight);
                    }
                }
            } else {
                for j in y0..y1 {
                    for i in x0..x1 {
                        sum += query.cell((i, j), origin, weight);
                    }
                }
            }
            sum
        };
        if ways.moments && even && side <= ways.kernel_block && range.within(self.cut) {
            let few = range.few(ways.far, [ways.extent_block, ways.extent_block_far]);
            let (widest, cells, Chance { tau, guess, .. }) = (f64::from(alpha[1]), (x1 - x0) * (y1 - y0), self.chance);
            let around = self.footprint.around(centre, half) * cells as f64;
            // Not where even a dim estimate would be looked into.
            let dim = || errors::block(0.1 * guess, &range, widest, cells) * around;
            if few || (tau > 0.0 && weight * dim() < tau) {
                let (kernel, change, mean) = self.moments(block, centre, half);
                if few || kernel == 0.0 {
                    return kernel * mean;
                }
                let mean = mean.min(errors::highest(&range, widest));
                // Four points miss some of a kernel that bends, most where it ends.
                let bent = 0.1 * (kernel - self.footprint.at(centre) * cells as f64).abs();
                let tilted = errors::tilted(change * cells as f64, mean, &range);
                let error = kernel.max(around) * errors::block(mean, &range, widest, cells) + bent * mean + tilted;
                let die = Die::Block([x0 as u32, y0 as u32], level as u32);
                return self.settle(error, (die, weight), |_| kernel * mean, below);
            }
        }
        below(self, weight)
    }

    /// A block by its moments: the kernel over it, by how much it changes there, and the mean of four lobes with, together,
    /// the mean and covariance of its slopes. What of the covariance is less than the lobe's own width, or than the distance of h, is between their
    /// normals, the rest in their widths.
    fn moments(&mut self, block: &Block, centre: DVec2, half: DVec2) -> (f64, f64, f64) {
        self.visits.points += 1;
        let nodes = Footprint::nodes(centre, half).map(|x| self.footprint.at(x));
        let kernel = nodes.iter().sum::<f64>();
        if kernel == 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let [a, b, c, d] = nodes;
        let change = a.max(b).max(c.max(d)) - a.min(b).min(c.min(d));
        let alpha = 0.5 * f64::from(block.alpha[0] + block.alpha[1]);
        let ([xx, xy, yy], mean) = (block.cov.map(f64::from), block.mean.as_dvec2());
        // Cholesky, the larger diagonal first.
        let (a, b) = if xx >= yy {
            let l = xx.max(0.0).sqrt();
            let across = if l > 0.0 { xy / l } else { 0.0 };
            (DVec2::new(l, across), DVec2::new(0.0, (yy - across * across).max(0.0).sqrt()))
        } else {
            let l = yy.sqrt();
            let across = xy / l;
            (DVec2::new(across, l), DVec2::new((xx - across * across).max(0.0).sqrt(), 0.0))
        };
        // Far from h the lobe is wide enough: its tail is no longer than it was.
        let at = self.seen(mean);
        let away = at.truncate().length_squared() / (at.z * at.z).max(1e-4);
        let wide = (xx + yy) / (xx + yy + alpha * alpha + away);
        let step = (2.0 * (1.0 - wide)).sqrt();
        let frame = |v: DVec2| self.seen(mean + v) - at;
        let axes = [a, b].map(|v| frame(v) * (2.0 * wide).sqrt());
        let (a, b) = (a * step, b * step);
        let lobes = [mean + a, mean - a, mean + b, mean - b].map(|s| stretched_lobe(self.seen(s), alpha, axes));
        (kernel * half.x * half.y, change, 0.25 * lobes.into_iter().sum::<f64>())
    }
}
