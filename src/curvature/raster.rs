//! A triangle over a grid of texels, cut exactly: the piece of it in every texel that it touches.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::moments::{Gather, NormalMoments};
use super::surface::Patch;

/// A corner of a cut piece: where, and the interpolated normal there before it is made unit.
#[derive(Clone, Copy, Default)]
struct Corner {
    at: DVec2,
    normal: DVec3,
}

/// A convex piece. Each of the four cuts adds one corner to a triangle at most.
#[derive(Clone, Copy, Default)]
struct Polygon {
    count: usize,
    corners: [Corner; 8],
}

/// Distance of two-point Gauss quadrature from the middle of a unit interval: exact for cubics.
const GAUSS: f64 = 0.288_675_134_594_812_9;

impl Polygon {
    fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: Corner) {
        // Only rounding could ask for more corners than a convex piece has.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// The part where the coordinate is at most (`keep` 1) or at least (`keep` -1) `bound` (Sutherland & Hodgman 1974).
    /// Into a polygon that is there already: they are large, and cut often.
    fn cut(&self, axis: usize, bound: f64, keep: f64, out: &mut Polygon) {
        out.count = 0;
        let Some(mut from) = self.corners().last() else { return };
        let depth = |c: &Corner| keep * (bound - c.at[axis]);
        for to in self.corners() {
            let (a, b) = (depth(from), depth(to));
            if (a < 0.0) != (b < 0.0) {
                let share = a / (a - b);
                let mut at = from.at.lerp(to.at, share);
                at[axis] = bound;
                out.push(Corner { at, normal: from.normal.lerp(to.normal, share) });
            }
            if b >= 0.0 {
                out.push(*to);
            }
            from = to;
        }
    }

    /// Lowest and highest x of the corners on a row's edge.
    fn extent_at(&self, y: f64) -> Option<(f64, f64)> {
        let on_edge = self.corners().iter().filter(|c| c.at.y == y).map(|c| c.at.x);
        on_edge.fold(None, |range, x| {
            let (low, high) = range.unwrap_or((x, x));
            Some((low.min(x), high.max(x)))
        })
    }

    /// Lowest and highest x.
    fn extent(&self) -> (f64, f64) {
        let all = self.corners().iter().map(|c| c.at.x);
        all.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
    }
}

impl Patch {
    /// Calls `found` with the column, the row and the moments of each piece of the patch in these rows of its level, which
    /// has `texels` texels.
    ///
    /// Normals vary linearly over the triangle and are made unit, as renderers do. Quadrature is exact for the second
    /// moments of the linear variation: four Gauss points in a texel that is covered whole, which gives the covariance
    /// `J J^T / 12` of a box with the Jacobian J, and three points for each triangle of a cut piece.
    pub fn pieces(&self, rows: Range<usize>, texels: f64, mut found: impl FnMut(usize, usize, &NormalMoments)) {
        let corner = |i: usize| Corner { at: self.corners[i], normal: self.normals[i] };
        let mut whole = Polygon { count: 3, ..Polygon::default() };
        whole.corners[..3].copy_from_slice(&[corner(0), corner(1), corner(2)]);
        let (mut half, mut strip, mut cut) = (whole, whole, whole);
        let slopes = self.slopes();
        let piece = |area: f64, gather: Gather| {
            let (mean, cov) = gather.mean_and_cov();
            let (weight, cover) = (area * self.density, area / texels);
            NormalMoments { weight, cover, mean, cov, tangent: self.tangent, side: self.side }
        };
        for row in rows {
            let (top, bottom) = (row as f64, row as f64 + 1.0);
            whole.cut(1, top, -1.0, &mut half);
            half.cut(1, bottom, 1.0, &mut strip);
            if strip.count < 3 {
                continue;
            }
            let full = match (strip.extent_at(top), strip.extent_at(bottom)) {
                (Some(a), Some(b)) => (a.0.max(b.0), a.1.min(b.1)),
                _ => (1.0, 0.0),
            };
            // Conversion stops at 0.
            let (left, right) = strip.extent();
            for column in (left.floor() as usize)..(right.ceil() as usize).min(self.columns) {
                let (start, end) = (column as f64, column as f64 + 1.0);
                if let Some(slopes) = slopes.filter(|_| full.0 <= start && end <= full.1) {
                    let middle = DVec2::new(start + 0.5, top + 0.5) - self.corners[0];
                    let mut gather = Gather::default();
                    for at in [(-GAUSS, -GAUSS), (GAUSS, -GAUSS), (-GAUSS, GAUSS), (GAUSS, GAUSS)] {
                        let d = middle + DVec2::from(at);
                        gather.add(1.0, self.unit(self.normals[0] + slopes[0] * d.x + slopes[1] * d.y));
                    }
                    found(column, row, &piece(1.0, gather));
                    continue;
                }
                strip.cut(0, start, -1.0, &mut half);
                half.cut(0, end, 1.0, &mut cut);
                let mut gather = Gather::default();
                let mut sum = 0.0;
                for pair in cut.corners().get(1..).unwrap_or_default().windows(2) {
                    let three = [cut.corners[0], pair[0], pair[1]];
                    let area = 0.5 * (three[1].at - three[0].at).perp_dot(three[2].at - three[0].at).abs();
                    if area <= 0.0 {
                        continue;
                    }
                    sum += area;
                    let mean = (three[0].normal + three[1].normal + three[2].normal) / 6.0;
                    three.iter().for_each(|c| gather.add(area, self.unit(mean + 0.5 * c.normal)));
                }
                if sum > 0.0 {
                    found(column, row, &piece(sum, gather));
                }
            }
        }
    }

    /// A normal made unit; the triangle's own where corners cancel.
    #[inline]
    fn unit(&self, n: DVec3) -> DVec3 {
        let length2 = n.length_squared();
        if length2 > 1e-24 { n / length2.sqrt() } else { self.face }
    }

    /// Change of the interpolated normal for a texel to the right and for a row down; nothing for a sliver too thin to
    /// say, which covers no texel whole.
    fn slopes(&self) -> Option<[DVec3; 2]> {
        let (e, f) = (self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]);
        let det = e.perp_dot(f);
        let (m, n) = (self.normals[1] - self.normals[0], self.normals[2] - self.normals[0]);
        (det.abs() > 1.0).then(|| [(m * f.y - n * e.y) / det, (n * e.x - m * f.x) / det])
    }
}
