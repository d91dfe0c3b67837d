//! Cells, and pieces of them: points, the closed form, or quarters.

use glam::{DVec2, DVec3};

use super::Footprint;
use super::chance::{Die, Path};
use super::element::{fan, lobe, share};
use super::errors;
use super::query::Query;
use super::ways::Range;

/// Halvings of a cell.
const DEEPEST: usize = 12;

/// A square piece of a cell: normals at its corners (x first) in the frame of h, and where it is.
struct Piece {
    p: [DVec3; 4],
    centre: DVec2,
    half: f64,
    /// Widths of the lobe at the corners.
    alpha: [f64; 4],
    /// Of which cell of the map.
    cell: [u32; 2],
}

impl Piece {
    #[inline]
    fn die(&self, of: Path, k: u32) -> Die {
        Die::Piece(self.cell, of.die(k))
    }
}

impl Query<'_> {
    /// Integral over the cell between four texels.
    pub(super) fn cell(&mut self, (x, y): (usize, usize), origin: DVec2, weight: f64) -> f64 {
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
        let cell = [x as u32, y as u32];
        self.piece(&Piece { p, centre, half: 0.5, alpha, cell }, 0, (Path::CELL, weight))
    }

    /// Integral over a piece of a cell.
    fn piece(&mut self, piece: &Piece, depth: usize, (of, weight): (Path, f64)) -> f64 {
        let Piece { p, half, alpha, .. } = piece;
        let (mean, uneven) = widths(alpha, self.ways.widening);
        let (range, ways) = (Range::new(p, 1.0 / mean), &self.ways);
        let side = 2.0 * half * self.footprint.inverse_minor;
        let few = range.few(ways.far, [ways.extent_nodes, ways.extent_nodes_far]);
        if (!uneven && side <= ways.kernel_nodes && few) || depth == DEEPEST {
            return self.points(piece, mean);
        }
        if !ways.closed || uneven || side > ways.kernel_linear {
            return self.divided(piece, depth, (of, weight));
        }
        if self.chance.tau == 0.0 {
            let straight = self.straight(piece, mean, &range);
            return if straight { self.triangles(piece, mean) } else { self.divided(piece, depth, (of, weight)) };
        }
        let kernel = 4.0 * half * half * self.footprint.around(piece.centre, DVec2::splat(*half));
        if range.near > 4.0 && range.extent > 4.0 * range.near {
            let error = kernel * errors::beside(&range, mean);
            let some = |_: &mut Self| 0.5 * error;
            return self.settle(error, (piece.die(of, 0), weight), some, |query, weight| {
                query.at_points(piece, (&range, mean, kernel), depth, (of, weight))
            });
        }
        self.at_points(piece, (&range, mean, kernel), depth, (of, weight))
    }

    /// Points stand for a piece, or else triangles, or else its quarters.
    fn at_points(
        &mut self,
        piece: &Piece,
        (range, alpha, kernel): (&Range, f64, f64),
        depth: usize,
        (of, weight): (Path, f64),
    ) -> f64 {
        let error = kernel * errors::points(range, alpha);
        let points = |query: &mut Self| query.points(piece, alpha);
        self.settle(error, (piece.die(of, 1), weight), points, |query, weight| {
            if query.straight(piece, alpha, range) {
                return query.triangles(piece, alpha);
            }
            let (twist, steepening) = (twist(&piece.p, alpha), steepening(&piece.p));
            let error = kernel * errors::triangles(twist, steepening, range, alpha);
            let closed = |query: &mut Self| query.triangles(piece, alpha);
            query.settle(error, (piece.die(of, 2), weight), closed, |query, weight| {
                query.divided(piece, depth, (of, weight))
            })
        })
    }

    /// Integral over the quarters of a piece.
    fn divided(&mut self, piece: &Piece, depth: usize, (of, weight): (Path, f64)) -> f64 {
        let Piece { p, centre, half, alpha, cell } = piece;
        let (p, alpha) = (quarters(p, |a, b| 0.5 * (a + b)), quarters(alpha, |a, b| 0.5 * (a + b)));
        let half = 0.5 * half;
        let mut sum = 0.0;
        for (k, to) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().enumerate() {
            let centre = *centre + DVec2::from(to) * half;
            if !self.footprint.misses(centre, DVec2::splat(half)) {
                let quarter = Piece { p: p[k], centre, half, alpha: alpha[k], cell: *cell };
                sum += self.piece(&quarter, depth + 1, (of.quarter(k as u32), weight));
            }
        }
        sum
    }

    /// Whether four triangles about its middle stand for a piece.
    #[inline]
    fn straight(&self, piece: &Piece, alpha: f64, range: &Range) -> bool {
        let (p, ways) = (&piece.p, &self.ways);
        let twist = twist(p, alpha);
        twist * twist <= ways.twist * ways.twist * range.near
            && (range.near > ways.far || steepening(p) <= ways.steepening)
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

/// Distance of a piece from its triangles, in widths of the lobe at distance 0.
#[inline]
fn twist(p: &[DVec3; 4], alpha: f64) -> f64 {
    (p[0] - p[1] - p[2] + p[3]).length() / (16.0 * alpha)
}

/// Ratio of the squares of the longest and the shortest normal of a piece.
#[inline]
fn steepening(p: &[DVec3; 4]) -> f64 {
    let squared = p.map(|p| p.length_squared());
    squared.into_iter().fold(0.0, f64::max) / squared[0].min(squared[1]).min(squared[2].min(squared[3]))
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
