//! The chart of directions: a square in which the flakes' normals are uniform, whatever the lobe.
//!
//! Flakes carry equal projected area, so a flake's normal m has density `D(m) cos m`. Slopes are whitened by the lobe's
//! mean and tensor; the fraction of flakes less steep than a whitened slope, with its direction, is a point of the unit
//! disk; and the concentric map of Shirley & Chiu 1997 takes the disk to the square. All steps keep areas in proportion,
//! so `dy = D(m) cos(m) dm` exactly, and one set of flakes serves every lobe.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DVec2, DVec3};

use crate::ndf::RoughnessTensor;
use crate::roughness::Alpha;

/// The tail of a lobe's slopes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tail {
    /// Trowbridge & Reitz 1975, Walter et al. 2007: `1 / (pi sqrt(det R) (1 + q)^2)`.
    #[default]
    Ggx,
    /// Beckmann: `exp(-q) / (pi sqrt(det R))`.
    Beckmann,
}

/// The smooth lobe that flakes make up, over slopes: any mean, any tensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Macro {
    /// Mean slope, `-(n.x, n.y) / n.z` of the lobe's normal n; 0 for the surface's own. Finite.
    pub mean: DVec2,
    /// Squared widths over slopes, in the tangent frame of h: at least [`Alpha::SMOOTHEST`] each way, smaller ones are
    /// raised to it.
    pub roughness: RoughnessTensor,
    /// GGX or Beckmann.
    pub tail: Tail,
}

impl Macro {
    /// A round GGX lobe about the surface's normal.
    pub fn isotropic(alpha: Alpha) -> Self {
        Self { mean: DVec2::ZERO, roughness: RoughnessTensor::isotropic(alpha), tail: Tail::Ggx }
    }

    /// The chart of this lobe; none if a number of it is not finite.
    pub fn chart(&self) -> Option<Chart> {
        let floor = f64::from(Alpha::SMOOTHEST.squared());
        let (xx, xy) = (f64::from(self.roughness.xx).max(floor), f64::from(self.roughness.xy));
        let yy = f64::from(self.roughness.yy).max(floor);
        if !(self.mean.is_finite() && (xx + xy.abs() + yy).is_finite()) {
            return None;
        }
        // Cholesky, not eigenvectors: it is continuous in the tensor.
        let lxx = xx.sqrt();
        let lxy = xy / lxx;
        let lyy = (yy - lxy * lxy).max(floor).sqrt();
        Some(Chart { mean: self.mean, lxx, lxy, lyy, tail: self.tail })
    }
}

/// Directions to points of the unit square and back, uniform for one lobe.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    mean: DVec2,
    lxx: f64,
    lxy: f64,
    lyy: f64,
    tail: Tail,
}

impl Chart {
    fn whitened(&self, h: DVec3) -> DVec2 {
        let d = DVec2::new(-h.x, -h.y) / h.z - self.mean;
        let x = d.x / self.lxx;
        DVec2::new(x, (d.y - self.lxy * x) / self.lyy)
    }

    /// `D(h) cos(h)`, 1/sr, for a unit h above the surface (`h.z > 0`): the density of flakes' normals.
    pub fn density(&self, h: DVec3) -> f64 {
        self.density_of(self.whitened(h), h.z)
    }

    fn density_of(&self, whitened: DVec2, z: f64) -> f64 {
        let q = whitened.length_squared();
        let shape = match self.tail {
            Tail::Ggx => 1.0 / ((1.0 + q) * (1.0 + q)),
            Tail::Beckmann => (-q).exp(),
        };
        shape / (PI * self.lxx * self.lyy * z * z * z)
    }

    /// The point of the square for a unit h with `h.z > 0`.
    pub fn square(&self, h: DVec3) -> DVec2 {
        self.square_and_density(h).0
    }

    /// [`Chart::square`] and [`Chart::density`] together.
    #[inline]
    pub fn square_and_density(&self, h: DVec3) -> (DVec2, f64) {
        let s = self.whitened(h);
        let q = s.length_squared();
        // sqrt(u) / |s|, with u the fraction of flakes less steep.
        let scale = match self.tail {
            Tail::Ggx => 1.0 / (1.0 + q).sqrt(),
            Tail::Beckmann if q < 1e-6 => 1.0 - 0.25 * q,
            Tail::Beckmann => ((1.0 - (-q).exp()) / q).sqrt(),
        };
        (disk_to_square(s * scale), self.density_of(s, h.z))
    }

    /// The unit normal of the flake at a point of the square, both coordinates 0 to 1.
    pub fn normal(&self, y: DVec2) -> DVec3 {
        let disk = square_to_disk(y);
        let u = disk.length_squared().min(1.0 - 1e-15);
        let scale = match self.tail {
            Tail::Ggx => 1.0 / (1.0 - u).sqrt(),
            Tail::Beckmann if u < 1e-6 => 1.0 + 0.25 * u,
            Tail::Beckmann => (-(1.0 - u).ln() / u).sqrt(),
        };
        let s = disk * scale;
        let slope = self.mean + DVec2::new(self.lxx * s.x, self.lxy * s.x + self.lyy * s.y);
        DVec3::new(-slope.x, -slope.y, 1.0).normalize()
    }
}

fn disk_to_square(d: DVec2) -> DVec2 {
    let r = d.length();
    let (a, b) = if d.x.abs() > d.y.abs() {
        let a = r.copysign(d.x);
        (a, a * (d.y / d.x).atan() / FRAC_PI_4)
    } else if r > 0.0 {
        let b = r.copysign(d.y);
        (b * (d.x / d.y).atan() / FRAC_PI_4, b)
    } else {
        (0.0, 0.0)
    };
    (DVec2::new(a, b) * 0.5 + 0.5).clamp(DVec2::ZERO, DVec2::ONE)
}

fn square_to_disk(y: DVec2) -> DVec2 {
    let (a, b) = (2.0 * y.x - 1.0, 2.0 * y.y - 1.0);
    if a.abs() > b.abs() {
        let (sin, cos) = (FRAC_PI_4 * b / a).sin_cos();
        a * DVec2::new(cos, sin)
    } else if b != 0.0 {
        let (sin, cos) = (FRAC_PI_4 * a / b).sin_cos();
        b * DVec2::new(sin, cos)
    } else {
        DVec2::ZERO
    }
}
