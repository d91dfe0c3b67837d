//! The pixel's kernel over the surface.
//!
//! A biweight over an ellipse: smooth at its rim, so that flakes fade in and out, and zero beyond it, so that every flake
//! is found. `W(d) = 3 (1 - t)^2 / (pi sqrt(det C))` for `t = d^T C^-1 d < 1`, C the ellipse's tensor.

use std::f64::consts::PI;

use glam::{DMat2, DVec2};

/// Effective area `1 / integral W^2` of a round biweight of radius 1.
pub const BIWEIGHT_AREA: f64 = 5.0 * PI / 9.0;

/// Squared radius of the pixel's biweight, pixels squared: its variance per axis, an eighth of this, is that of a
/// Gaussian pixel filter of deviation 1/2.
pub const SUPPORT2: f64 = 2.0;

/// Longest kernel, in widths; longer footprints are widened, as texture samplers do. Work grows with its root.
pub const MOST_ANISOTROPY: f64 = 64.0;

/// Symmetric 2x2 tensor of a kernel's support: the boundary is `d^T C^-1 d = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Along u.
    pub xx: f64,
    /// Mixed term.
    pub xy: f64,
    /// Along v.
    pub yy: f64,
}

impl Ellipse {
    /// A round one.
    pub fn round(radius: f64) -> Self {
        Self { xx: radius * radius, xy: 0.0, yy: radius * radius }
    }

    /// The kernel of a pixel with this Jacobian (columns: change of the surface's coordinates along the screen's x and
    /// y), widened by a flake of this support radius, more than 0: flakes have a size, so close-ups show disks, not
    /// points. None if the Jacobian is not finite or its square overflows.
    pub fn of_pixel(jacobian: DMat2, flake: f64) -> Option<Self> {
        let (x, y) = (jacobian.x_axis, jacobian.y_axis);
        let r2 = flake * flake;
        let (xx, yy) = (SUPPORT2 * (x.x * x.x + y.x * y.x) + r2, SUPPORT2 * (x.y * x.y + y.y * y.y) + r2);
        let xy = SUPPORT2 * (x.x * x.y + y.x * y.y);
        let size = xx + yy + xy.abs();
        if size.is_nan() || size > 1e36 {
            return None;
        }
        Some(Self { xx, xy, yy }.at_most(MOST_ANISOTROPY))
    }

    /// Half the trace, and half the difference of the eigenvalues.
    fn mean_and_spread(self) -> (f64, f64) {
        let half = 0.5 * (self.xx - self.yy);
        (0.5 * (self.xx + self.yy), (half * half + self.xy * self.xy).sqrt())
    }

    /// Long and short support radius.
    pub fn radii(self) -> [f64; 2] {
        let (mean, spread) = self.mean_and_spread();
        let long = mean + spread;
        // From the determinant: the difference would lose the short axis of a long ellipse.
        [long.sqrt(), (self.determinant().max(0.0) / long).sqrt()]
    }

    /// Length over width, 1 or more.
    pub fn anisotropy(self) -> f64 {
        let [long, short] = self.radii();
        long / short
    }

    /// The same long axis, the short one widened until their ratio is `ratio` or less.
    fn at_most(self, ratio: f64) -> Self {
        let (mean, spread) = self.mean_and_spread();
        let (long, least) = (mean + spread, (mean + spread) / (ratio * ratio));
        if mean - spread >= least {
            return self;
        }
        // The part across the long axis goes from short to `least`; spread is not 0 here.
        let (half, scale) = (0.5 * (long - least), 1.0 / spread);
        let (cos, sin) = (0.5 * (self.xx - self.yy) * scale, self.xy * scale);
        let middle = 0.5 * (long + least);
        Self { xx: middle + half * cos, xy: half * sin, yy: middle - half * cos }
    }

    /// Determinant, `(long short)^2`.
    pub fn determinant(self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// Effective area of the kernel.
    pub fn area(self) -> f64 {
        BIWEIGHT_AREA * self.determinant().sqrt()
    }

    /// Lengths times `scale`.
    pub fn scaled(self, scale: f64) -> Self {
        let s2 = scale * scale;
        Self { xx: self.xx * s2, xy: self.xy * s2, yy: self.yy * s2 }
    }

    /// `d^T C^-1 d`, by a prepared inverse.
    #[inline(always)]
    pub fn inverse(self) -> Inverse {
        let d = 1.0 / self.determinant();
        Inverse { xx: self.yy * d, xy: -self.xy * d, yy: self.xx * d }
    }

    /// The boxes of side `side` that the ellipse about `centre` overlaps: calls `row(j, first i, last i)` for each row
    /// from below. Only rounding may add a box that it does not overlap.
    #[inline(always)]
    pub fn rows(self, centre: DVec2, side: f64, mut row: impl FnMut(i64, i64, i64)) {
        let per_side = 1.0 / side;
        let (ex, ey) = (self.xx.sqrt(), self.yy.sqrt());
        let slope = self.xy / self.yy;
        // Squared half width of the row through the centre; and the height at which the ellipse is widest.
        let (half2, widest) = ((self.xx - self.xy * slope).max(0.0), self.xy / ex);
        let (first, last) = (((centre.y - ey) * per_side).floor() as i64, ((centre.y + ey) * per_side).floor() as i64);
        let half = |d: f64| ((1.0 - d * d / self.yy).max(0.0) * half2).sqrt();
        for j in first..=last {
            let low = (j as f64 * side - centre.y).max(-ey);
            let high = ((j + 1) as f64 * side - centre.y).min(ey);
            let (h0, h1) = (half(low), half(high));
            let right = if low <= widest && widest <= high { ex } else { (low * slope + h0).max(high * slope + h1) };
            let left = if low <= -widest && -widest <= high { -ex } else { (low * slope - h0).min(high * slope - h1) };
            row(j, ((centre.x + left) * per_side).floor() as i64, ((centre.x + right) * per_side).floor() as i64);
        }
    }
}

/// Inverse of an [`Ellipse`].
#[derive(Clone, Copy, Debug)]
pub struct Inverse {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Inverse {
    /// Squared distance from the centre, 1 at the rim.
    #[inline(always)]
    pub fn of(self, d: DVec2) -> f64 {
        self.xx * d.x * d.x + 2.0 * self.xy * d.x * d.y + self.yy * d.y * d.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_worked_by_hand() {
        let e = Ellipse::of_pixel(DMat2::from_diagonal(DVec2::new(3.0, 1.0)), 0.5).unwrap();
        assert_eq!((e.xx, e.xy, e.yy), (18.25, 0.0, 2.25));
        // A degenerate Jacobian keeps the flake's own size, as far as the longest kernel allows.
        let line = Ellipse::of_pixel(DMat2::from_cols(DVec2::ONE, DVec2::ONE), 0.5).unwrap();
        let [long, short] = line.radii();
        assert!((long * long - 8.25).abs() < 1e-12 && (short - 0.5).abs() < 1e-9);
        let none = Ellipse::of_pixel(DMat2::ZERO, 0.5).unwrap();
        assert_eq!(none, Ellipse::round(0.5));
        let long = Ellipse::of_pixel(DMat2::from_cols(DVec2::new(3e3, 4e3), DVec2::ZERO), 0.5).unwrap().radii();
        assert!((long[0] / long[1] - MOST_ANISOTROPY).abs() < 1e-6, "{long:?}");
        assert!(Ellipse::of_pixel(DMat2::from_diagonal(DVec2::new(f64::NAN, 1.0)), 0.5).is_none());
        assert!(Ellipse::of_pixel(DMat2::from_diagonal(DVec2::new(1e300, 1.0)), 0.5).is_none());
    }

    #[test]
    fn rows_are_the_boxes_that_the_ellipse_overlaps() {
        let e = Ellipse::of_pixel(DMat2::from_cols(DVec2::new(4.0, 3.0), DVec2::new(-0.5, 0.7)), 0.3).unwrap();
        let (centre, side, inverse) = (DVec2::new(-3.3, 7.1), 1.5, e.inverse());
        let mut found = Vec::new();
        e.rows(centre, side, |j, first, last| found.extend((first..=last).map(|i| (i, j))));
        // Boxes of the points of a fine grid inside.
        let mut boxes = std::collections::BTreeSet::new();
        for a in -2000..2000 {
            for b in -2000..2000 {
                let d = DVec2::new(f64::from(a), f64::from(b)) * 0.005;
                if inverse.of(d) < 1.0 {
                    let at = (centre + d) / side;
                    boxes.insert((at.x.floor() as i64, at.y.floor() as i64));
                }
            }
        }
        assert!(boxes.iter().all(|b| found.contains(b)));
        assert!(found.len() <= boxes.len() + 2, "{} rows' boxes for {}", found.len(), boxes.len());
    }
}
