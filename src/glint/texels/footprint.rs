//! The kernel of a pixel, in texels.

use std::f64::consts::{FRAC_1_PI, SQRT_2};

use glam::{DMat2, DVec2};

/// A width in texels of the finest level.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct TexelWidth(pub f64);

/// Radius of the kernel in pixels: a biweight kernel of radius R has the variance `R^2 / 8` along each axis, here that of
/// a Gaussian of half a pixel.
const RADIUS: f64 = SQRT_2;
/// Least radius in texels: nearer, the slopes under a pixel are all but one.
const LEAST: f64 = 1.0 / 16.0;
/// Largest radius in texels: pixels that cover more see that much of the map. The folded lobe is their answer.
const MOST: f64 = 1024.0;
/// The same in sizes of the map, beyond which all of it counts alike.
const MOST_MAPS: f64 = 4.0;
/// Largest ratio of the radii.
const MOST_ANISOTROPIC: f64 = 64.0;
/// Node of two-point Gauss quadrature on -1..1.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// The biweight kernel `3 / (pi a b) (1 - r^2)^2` on the ellipse of a pixel: smooth, of integral 1, zero outside.
///
/// Texel coordinates run to the right and down, and the centre of the first texel is at 0.
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    pub(super) centre: DVec2,
    /// Half the sides of the ellipse's box.
    pub(super) half: DVec2,
    /// From texels to the unit disc.
    pub(super) unit: DMat2,
    /// Over the shorter radius.
    pub(super) inverse_minor: f64,
    peak: f64,
    width: TexelWidth,
}

impl Footprint {
    /// The kernel at `uv` for the columns duv/dx and duv/dy, on a map of `size` columns and rows; none if either is not
    /// finite.
    pub(super) fn new(uv: DVec2, jacobian: DMat2, (columns, rows): (usize, usize)) -> Option<Self> {
        let size = DVec2::new(columns as f64, rows as f64);
        let turned = uv - uv.floor();
        let centre = DVec2::new(turned.x, 1.0 - turned.y) * size - 0.5;
        let a = DMat2::from_cols(jacobian.x_axis * size, jacobian.y_axis * size);
        // Squares must not overflow: what is wider than any map is as wide as the widest.
        let most = a.x_axis.abs().max(a.y_axis.abs()).max_element();
        if !(uv.is_finite() && most.is_finite()) {
            return None;
        }
        let a = if most > 1e6 { a * (1e6 / most) } else { a };
        let flip = |v: DVec2| DVec2::new(v.x, -v.y);
        let (p, q) = (flip(a.x_axis), flip(a.y_axis));
        let (xx, xy, yy) = (p.x * p.x + q.x * q.x, p.x * p.y + q.x * q.y, p.y * p.y + q.y * q.y);
        let (mean, apart) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let major = (mean + apart).sqrt();
        let minor = p.perp_dot(q).abs() / major.max(f64::MIN_POSITIVE);
        let angle = 0.5 * xy.atan2(0.5 * (xx - yy));
        let axis = DVec2::from_angle(angle);
        let long = (RADIUS * major).clamp(LEAST, MOST.min(MOST_MAPS * size.max_element()));
        let short = (RADIUS * minor).clamp((long / MOST_ANISOTROPIC).max(LEAST), long);
        Some(Self {
            centre,
            half: DVec2::new((axis * DVec2::new(long, short)).length(), (axis * DVec2::new(short, long)).length()),
            unit: DMat2::from_cols(axis / long, axis.perp() / short).transpose(),
            inverse_minor: 1.0 / short,
            peak: 3.0 * FRAC_1_PI / (long * short),
            width: TexelWidth(major),
        })
    }

    /// The longer width of the pixel.
    pub fn width(&self) -> TexelWidth {
        self.width
    }

    /// Its centre, and half the sides of its box, in texel coordinates.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        (self.centre, self.half)
    }

    /// The kernel at a point in texel coordinates, per texel: its integral over them is 1.
    #[inline]
    pub fn at(&self, x: DVec2) -> f64 {
        let rest = (1.0 - (self.unit * (x - self.centre)).length_squared()).max(0.0);
        self.peak * rest * rest
    }

    /// The kernel that errors over a rectangle go with: where it lies across the edge, of its nearest part too.
    #[inline]
    pub(super) fn around(&self, centre: DVec2, half: DVec2) -> f64 {
        self.at(centre).max(0.4 * self.at(self.centre.clamp(centre - half, centre + half)))
    }

    /// Whether a rectangle given by its centre and half its sides lies outside for certain.
    #[inline]
    pub(super) fn misses(&self, centre: DVec2, half: DVec2) -> bool {
        let d = self.unit * (centre - self.centre);
        let (along, across) = (self.unit.x_axis.abs() * half.x + self.unit.y_axis.abs() * half.y).into();
        let apart = DVec2::new((d.x.abs() - along).max(0.0), (d.y.abs() - across).max(0.0));
        apart.length_squared() >= 1.0
    }

    /// Gauss nodes of a rectangle, 2 by 2, x first.
    #[inline]
    pub(super) fn nodes(centre: DVec2, half: DVec2) -> [DVec2; 4] {
        let (x, y) = (half.x * GAUSS, half.y * GAUSS);
        [(-x, -y), (x, -y), (-x, y), (x, y)].map(|(x, y)| centre + DVec2::new(x, y))
    }
}
