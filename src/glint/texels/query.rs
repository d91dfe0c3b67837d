//! One half vector against the texels under one kernel.

use glam::{DVec2, DVec3, Vec2};

use super::element::{fan, lobe, share};
use super::{Block, Footprint, Pyramid, SlopeMap};

/// Halvings of a cell.
const DEEPEST: usize = 12;

/// What becomes of the tails of the material's lobe, which for GGX fall as the fourth power only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Tails {
    /// They are kept, coarsely sampled where they are below 1e-4 of the peak: energy is whole.
    #[default]
    Kept,
    /// Texels all of whose normals are further from h than this many alphas (as tangents) do not count, and are not
    /// visited where the pyramid tells. Much quicker on rough maps; up to `1 / (1 + x^2)` of the energy is lost.
    Cut(f64),
}

/// What a query visited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Blocks of the pyramid whose ranges were looked at.
    pub nodes: usize,
    /// Cells whose texels were read.
    pub texels: usize,
    /// Pieces of cells integrated in closed form.
    pub closed: usize,
    /// Pieces of cells, and blocks, evaluated at four points.
    pub points: usize,
}

impl std::ops::AddAssign for Visits {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.texels += other.texels;
        self.closed += other.closed;
        self.points += other.points;
    }
}

/// How a query goes about it. Tests compare others with [`Ways::BEST`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Blocks out of reach are not entered.
    pub(super) prune: bool,
    /// Blocks that their moments stand for are not entered.
    pub(super) moments: bool,
    /// Pieces narrower in position than in slope are integrated in closed form, not divided until points do.
    pub(super) closed: bool,
    /// Longest side of a piece, over the shorter radius of the kernel, on which the kernel is taken as linear.
    pub(super) kernel_linear: f64,
    /// The same where it is taken at Gauss nodes.
    pub(super) kernel_nodes: f64,
    /// The same for a block that its moments stand for.
    pub(super) kernel_block: f64,
    /// Largest squared extent of a piece, in widths of the lobe at its distance, that Gauss nodes do for.
    pub(super) extent_nodes: f64,
    /// The same for the moments of a block.
    pub(super) extent_block: f64,
    /// `1 + d^2` for a distance of d widths from which the tail of the lobe need not be resolved,
    pub(super) far: f64,
    /// how much larger the squared extent of a piece may then be, over `1 + d^2`,
    pub(super) extent_nodes_far: f64,
    /// and that of a block.
    pub(super) extent_block_far: f64,
    /// Departure of a piece from its triangles, in widths of the lobe at its distance.
    pub(super) twist: f64,
    /// Ratio of the squared lengths of N within a piece up to which their powers are taken as linear.
    pub(super) steepening: f64,
    /// Ratio of the widths within a piece up to which it has one.
    pub(super) widening: f64,
}

impl Ways {
    /// Errors in balance.
    pub(super) const BEST: Self = Self {
        prune: true,
        moments: true,
        closed: true,
        kernel_linear: 0.25,
        kernel_nodes: 0.36,
        kernel_block: 0.25,
        extent_nodes: 0.36,
        extent_block: 0.1,
        far: 101.0,
        extent_nodes_far: 4.0,
        extent_block_far: 1.0,
        twist: 0.04,
        steepening: 1.1,
        widening: 1.1,
    };
}

/// A half vector and all that is asked about it.
pub(super) struct Query<'a> {
    map: &'a SlopeMap,
    pyramid: &'a Pyramid,
    footprint: &'a Footprint,
    /// Axes of the frame of h.
    frame: [DVec3; 3],
    /// `1 + d^2` of the cut.
    cut: f64,
    pub(super) ways: Ways,
    visits: Visits,
}

/// A square piece of a cell: normals at its corners (x first) in the frame of h, and where it is.
struct Piece {
    p: [DVec3; 4],
    centre: DVec2,
    half: f64,
    /// Widths of the lobe at the corners.
    alpha: [f64; 4],
}

/// Where normals lie, in widths of the lobe.
struct Range {
    /// `1 + d^2` of the nearest.
    near: f64,
    /// Squared diagonal of their box.
    extent: f64,
}

impl Range {
    /// Of all convex combinations of the corners.
    #[inline]
    fn new(p: &[DVec3; 4], inverse: f64) -> Self {
        let (min, max) = (p[0].min(p[1]).min(p[2].min(p[3])), p[0].max(p[1]).max(p[2].max(p[3])));
        let apart = min.truncate().max(-max.truncate()).max(DVec2::ZERO).length_squared();
        let inverse2 = inverse * inverse;
        let near = if max.z > 0.0 { 1.0 + apart * inverse2 / (max.z * max.z) } else { f64::INFINITY };
        let z = min.z.max(0.05);
        Self { near, extent: (max - min).truncate().length_squared() * inverse2 / (z * z) }
    }

    /// Whether all normals are nearer than a cut, for certain.
    #[inline]
    fn within(&self, cut: f64) -> bool {
        cut.is_infinite() || ((self.near - 1.0).sqrt() + self.extent.sqrt()).powi(2) < cut - 1.0
    }

    /// Whether points stand for these normals.
    #[inline]
    fn few(&self, far: f64, extent: [f64; 2]) -> bool {
        self.extent <= self.near * if self.near > far { extent[1] } else { extent[0] }
    }
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
        Some(Self { map, pyramid, footprint, frame: [x, y, h], cut, ways: Ways::BEST, visits: Visits::default() })
    }

    /// D(h), and what was visited.
    pub(super) fn evaluate(mut self) -> (f64, Visits) {
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
                        sum += self.block(level, (x, y), origin);
                    }
                }
            }
        }
        (sum.max(0.0), self.visits)
    }

    /// The coordinates of a normal in the frame of h.
    #[inline]
    fn seen(&self, s: DVec2) -> DVec3 {
        let [x, y, h] = self.frame;
        let n = DVec3::new(-s.x, -s.y, 1.0);
        DVec3::new(n.dot(x), n.dot(y), n.dot(h))
    }

    /// Integral over a block.
    fn block(&mut self, level: usize, (x, y): (usize, usize), origin: DVec2) -> f64 {
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
        if ways.moments
            && even
            && side <= ways.kernel_block
            && range.few(ways.far, [ways.extent_block, ways.extent_block_far])
            && range.within(self.cut)
        {
            return self.moments(block, centre, half);
        }
        let mut sum = 0.0;
        if level > 1 {
            let (below_columns, below_rows) = (columns.div_ceil(1 << (level - 1)), rows.div_ceil(1 << (level - 1)));
            for j in 2 * y..(2 * y + 2).min(below_rows) {
                for i in 2 * x..(2 * x + 2).min(below_columns) {
                    sum += self.block(level - 1, (i, j), origin);
                }
            }
        } else {
            for j in y0..y1 {
                for i in x0..x1 {
                    sum += self.cell((i, j), origin);
                }
            }
        }
        sum
    }

    /// A block by its moments: four slopes with the same mean and covariance.
    fn moments(&mut self, block: &Block, centre: DVec2, half: DVec2) -> f64 {
        self.visits.points += 1;
        let kernel: f64 = Footprint::nodes(centre, half).iter().map(|x| self.footprint.at(*x)).sum();
        if kernel == 0.0 {
            return 0.0;
        }
        let inverse = 2.0 / f64::from(block.alpha[0] + block.alpha[1]);
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
        let (a, b) = (a * std::f64::consts::SQRT_2, b * std::f64::consts::SQRT_2);
        let value: f64 =
            [mean + a, mean - a, mean + b, mean - b].into_iter().map(|s| lobe(self.seen(s), inverse)).sum();
        0.25 * kernel * value * half.x * half.y
    }

    /// Integral over the cell between four texels.
    fn cell(&mut self, (x, y): (usize, usize), origin: DVec2) -> f64 {
        let centre = origin + DVec2::new(x as f64, y as f64) + 0.5;
        if self.footprint.misses(centre, DVec2::splat(0.5)) {
            return 0.0;
        }
        self.visits.texels += 1;
        let p = self.map.cell(x, y).map(|s| self.seen(s.as_dvec2()));
        let alpha = self.map.widths(x, y).map(f64::from);
        let widest = alpha.into_iter().fold(0.0, f64::max);
        if Range::new(&p, 1.0 / widest).near > self.cut {
            return 0.0;
        }
        self.piece(Piece { p, centre, half: 0.5, alpha }, 0)
    }

    /// Integral over a piece of a cell.
    fn piece(&mut self, piece: Piece, depth: usize) -> f64 {
        let Piece { p, centre, half, alpha } = &piece;
        let (mean, uneven) = widths(alpha, self.ways.widening);
        let (range, ways) = (Range::new(p, 1.0 / mean), &self.ways);
        let side = 2.0 * half * self.footprint.inverse_minor;
        let few = range.few(ways.far, [ways.extent_nodes, ways.extent_nodes_far]);
        if (!uneven && side <= ways.kernel_nodes && few) || depth == DEEPEST {
            return self.points(&piece, mean);
        }
        if ways.closed && !uneven && side <= ways.kernel_linear && self.straight(&piece, mean, &range) {
            return self.triangles(&piece, mean);
        }
        let (p, alpha) = (quarters(p, |a, b| 0.5 * (a + b)), quarters(alpha, |a, b| 0.5 * (a + b)));
        let half = 0.5 * half;
        let mut sum = 0.0;
        for (k, to) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().enumerate() {
            let centre = *centre + DVec2::from(to) * half;
            if !self.footprint.misses(centre, DVec2::splat(half)) {
                sum += self.piece(Piece { p: p[k], centre, half, alpha: alpha[k] }, depth + 1);
            }
        }
        sum
    }

    /// Whether four triangles about its middle stand for a piece.
    #[inline]
    fn straight(&self, piece: &Piece, alpha: f64, range: &Range) -> bool {
        let (p, ways) = (&piece.p, &self.ways);
        let twist = (p[0] - p[1] - p[2] + p[3]).length() / (16.0 * alpha);
        let steep = p.map(|p| p.length_squared());
        let (least, most) = (steep[0].min(steep[1]).min(steep[2].min(steep[3])), steep.into_iter().fold(0.0, f64::max));
        twist * twist <= ways.twist * ways.twist * range.near
            && (most <= ways.steepening * least || range.near > ways.far)
    }

    /// Kernel and lobe at Gauss nodes.
    fn points(&mut self, piece: &Piece, alpha: f64) -> f64 {
        self.visits.points += 1;
        self.mean(piece, |p| lobe(p, 1.0 / alpha)) * 4.0 * piece.half * piece.half
    }

    /// Mean of the kernel times something, at Gauss nodes.
    #[inline]
    fn mean(&self, piece: &Piece, of: impl Fn(DVec3) -> f64) -> f64 {
        // The nodes of -1/2..1/2, as shares of the far corner along each axis.
        const NEAR: f64 = 0.211_324_865_405_187_1;
        const WITH: f64 = 1.0 - NEAR;
        let p = &piece.p;
        let upper = [p[0] * WITH + p[2] * NEAR, p[1] * WITH + p[3] * NEAR];
        let lower = [p[0] * NEAR + p[2] * WITH, p[1] * NEAR + p[3] * WITH];
        let along = |[a, b]: [DVec3; 2]| [a * WITH + b * NEAR, a * NEAR + b * WITH];
        let at = [along(upper), along(lower)];
        let mut sum = 0.0;
        for (node, p) in Footprint::nodes(piece.centre, DVec2::splat(piece.half)).iter().zip(at.as_flattened()) {
            let kernel = self.footprint.at(*node);
            if kernel > 0.0 {
                sum += kernel * of(*p);
            }
        }
        0.25 * sum
    }

    /// The closed form, its kernel linear over four triangles.
    fn triangles(&mut self, piece: &Piece, alpha: f64) -> f64 {
        let Piece { p, centre, half, .. } = piece;
        let mean = self.mean(piece, |p| share(p, 1.0 / alpha));
        let corner = |x: f64, y: f64| self.footprint.at(*centre + DVec2::new(x, y) * *half);
        let kernel = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(0.0, 0.0)];
        if mean == 0.0 || kernel == [0.0; 5] {
            return self.points(piece, alpha);
        }
        self.visits.closed += 1;
        4.0 * half * half * fan(p, &kernel, mean, 1.0 / alpha)
    }
}

/// Mean of widths, and whether their ratio is above a limit.
#[inline]
fn widths(alpha: &[f64; 4], ratio: f64) -> (f64, bool) {
    let (least, most) = (alpha[0].min(alpha[1]).min(alpha[2].min(alpha[3])), alpha.iter().copied().fold(0.0, f64::max));
    (0.25 * alpha.iter().sum::<f64>(), most > ratio * least)
}

/// Corner values of the four quarters of a bilinear piece, from those of the piece.
#[inline]
fn quarters<T: Copy>(v: &[T; 4], mid: impl Fn(T, T) -> T) -> [[T; 4]; 4] {
    let (above, left, right, below) = (mid(v[0], v[1]), mid(v[0], v[2]), mid(v[1], v[3]), mid(v[2], v[3]));
    let middle = mid(above, below);
    [
        [v[0], above, left, middle],
        [above, v[1], middle, right],
        [left, middle, v[2], below],
        [middle, right, below, v[3]],
    ]
}
