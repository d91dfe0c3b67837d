//! Twins of `kernels/wgsl/glint.wgsl`: where they can, they ask the library's own glints.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DMat2, DVec2, DVec3};

use crate::glint::{BIWEIGHT_AREA, Ellipse, FlakeDensity, Flakes, Light, Macro, Probe, SolidAngle, Tail};
use crate::roughness::Alpha;

/// A pixel's kernel over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlintKernel {
    /// (xx, xy, yy), cells squared.
    pub tensor: DVec3,
    /// Root of its determinant.
    pub root: f64,
}

/// A pixel in units of flakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlintPixel {
    /// Of its centre.
    pub cell: [i32; 2],
    /// Place in it.
    pub within: DVec2,
    /// Its kernel.
    pub kernel: GlintKernel,
}

/// A light as a pixel's flakes see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlintLight {
    /// Of the half vector in the chart.
    pub y: DVec2,
    /// Effective share of flakes that answer.
    pub area: f64,
    /// The half vector in widths of what answers.
    pub widths: DVec2,
}

impl GlintKernel {
    /// Of an ellipse.
    pub fn of(e: Ellipse) -> Self {
        Self { tensor: DVec3::new(e.xx, e.xy, e.yy), root: e.determinant().max(0.0).sqrt() }
    }

    /// With the tensor's long axis and the root's area: a rounded tensor of a long ellipse knows its short axis badly.
    pub fn ellipse(self) -> Ellipse {
        let DVec3 { x: xx, y: xy, z: yy } = self.tensor;
        let half = 0.5 * (xx - yy);
        let spread = half.hypot(xy);
        let long = 0.5 * (xx + yy) + spread;
        let short = self.root * self.root / long;
        if spread <= 1e-5 * long {
            return Ellipse { xx, xy, yy };
        }
        let (middle, scale) = (0.5 * (long + short), 0.5 * (long - short) / spread);
        Ellipse { xx: middle + scale * half, xy: scale * xy, yy: middle - scale * half }
    }
}

impl GlintPixel {
    /// The library's form of a pixel's question about a light.
    pub fn probe(&self, light: &GlintLight, seed: u32, variation: f64) -> Probe {
        let variation = variation.clamp(0.0, flake_variation(3.0, 0.0));
        Probe {
            at: DVec2::new(f64::from(self.cell[0]), f64::from(self.cell[1])) + self.within,
            kernel: self.kernel.ellipse(),
            y: light.y,
            area: light.area,
            widths: light.widths,
            seed,
            variation2: variation * variation,
        }
    }
}

/// Variation of flakes of which only a share is there.
pub fn flake_variation(variation: f64, share: f64) -> f64 {
    let flakes = Flakes::new(FlakeDensity(1.0), SolidAngle(0.0), 0);
    Flakes { size_variation: variation, share, ..flakes }.variation2().sqrt()
}

/// Concentric map of Shirley & Chiu 1997, by the angle in eighths.
pub fn disk_to_square(d: DVec2) -> DVec2 {
    let r = d.length();
    if r == 0.0 {
        return DVec2::splat(0.5);
    }
    let (major, minor) = if d.x.abs() > d.y.abs() { (d.x, d.y) } else { (d.y, d.x) };
    let (a, b) = (r * major.signum(), r * major.signum() * (minor / major).atan() / FRAC_PI_4);
    let square = if d.x.abs() > d.y.abs() { DVec2::new(a, b) } else { DVec2::new(b, a) };
    (0.5 + 0.5 * square).clamp(DVec2::ZERO, DVec2::ONE)
}

/// The way back.
pub fn square_to_disk(y: DVec2) -> DVec2 {
    let s = 2.0 * y - 1.0;
    if s == DVec2::ZERO {
        DVec2::ZERO
    } else if s.x.abs() > s.y.abs() {
        s.x * DVec2::from_angle(FRAC_PI_4 * s.y / s.x)
    } else {
        let turned = DVec2::from_angle(FRAC_PI_4 * s.x / s.y);
        s.y * DVec2::new(turned.y, turned.x)
    }
}

/// Cholesky factor (xx, xy, yy).
pub fn glint_factor(tensor: DVec3) -> DVec3 {
    let least = f64::from(Alpha::SMOOTHEST.squared());
    let xx = tensor.x.max(least).sqrt();
    let xy = tensor.y / xx;
    DVec3::new(xx, xy, (tensor.z.max(least) - xy * xy).max(least).sqrt())
}

/// Point of the square, and `D(h) cos(h)`. None if the lobe is not finite.
pub fn glint_point(lobe: &Macro, h: DVec3) -> Option<(DVec2, f64)> {
    lobe.chart().map(|chart| chart.square_and_density(h))
}

/// The normal at a point of the square.
pub fn glint_normal(lobe: &Macro, y: DVec2) -> Option<DVec3> {
    lobe.chart().map(|chart| chart.normal(y))
}

/// Effective solid angle of a flake's lobe.
pub fn flake_solid_angle(alpha: f64, tail: Tail) -> f64 {
    SolidAngle::of_flake(Alpha(alpha as f32), tail).0
}

/// Of a round light.
pub fn cone_solid_angle(half_angle: f64) -> f64 {
    2.0 * PI * (1.0 - half_angle.cos())
}

/// Of half vectors that make a flake shine in the pixel.
pub fn glint_half_vectors(flake: f64, light: &Light) -> f64 {
    light.half_vectors(SolidAngle(flake)).0
}

/// The half vector of a light; area 0 where nothing can be asked.
pub fn glint_light(lobe: &Macro, h: DVec3, omega: f64) -> GlintLight {
    let none = GlintLight { y: DVec2::splat(0.5), area: 0.0, widths: DVec2::ZERO };
    let h = h.normalize();
    if h.z <= 0.0 {
        return none;
    }
    glint_point(lobe, h).map_or(none, |(y, density)| GlintLight {
        y,
        area: (density * omega).clamp(Probe::LEAST_AREA, Probe::MOST_AREA),
        widths: DVec2::new(h.x, h.y) * (2.0 / (1.0 + h.z) / omega.max(Probe::LEAST_AREA)).sqrt(),
    })
}

/// The whole part repeats after 2^32.
fn whole_and_rest(v: f64) -> (f64, f64) {
    (f64::from(v.floor() as i64 as i32), v - v.floor())
}

/// `m x` of numbers with 24 bits: exact.
pub fn whole_product(m: f64, x: f64) -> (f64, f64) {
    whole_and_rest(m * x)
}

/// `dot(m, x)`.
pub fn whole_dot(m: DVec2, x: DVec2) -> (f64, f64) {
    whole_and_rest(m.dot(x))
}

/// The kernel of a pixel with this Jacobian (columns), in cells.
pub fn glint_kernel(jacobian: DMat2, flake: f64) -> Option<GlintKernel> {
    Ellipse::of_pixel(jacobian, flake).map(GlintKernel::of)
}

/// `C^(-1/2)`, by eigenvalues.
pub fn glint_inverse_root(kernel: GlintKernel) -> DVec3 {
    let e = kernel.ellipse();
    let half = 0.5 * (e.xx - e.yy);
    let spread = half.hypot(e.xy);
    let long = (0.5 * (e.xx + e.yy) + spread).sqrt();
    let (low, high) = (1.0 / long, long / kernel.root);
    let (middle, scale) = (0.5 * (high + low), if spread > 0.0 { 0.5 * (high - low) / spread } else { 0.0 });
    DVec3::new(middle - scale * half, -scale * e.xy, middle + scale * half)
}

/// Length over width, by eigenvalues.
pub fn glint_anisotropy(kernel: GlintKernel) -> f64 {
    let [long, _] = kernel.ellipse().radii();
    (long * long / kernel.root).max(1.0)
}

/// A pixel in units of flakes; none where g is 1.
pub fn glint_pixel(uv: DVec2, jacobian: DMat2, flakes: &Flakes) -> Option<GlintPixel> {
    let to_cells = flakes.to_cells();
    let size = (flakes.coverage.clamp(1e-6, 1.0) / BIWEIGHT_AREA).sqrt();
    let kernel = glint_kernel(to_cells * jacobian, size)?;
    let at = to_cells * uv;
    let cell = [at.x.floor() as i64 as i32, at.y.floor() as i64 as i32];
    Some(GlintPixel { cell, within: at - at.floor(), kernel })
}

/// Effective number of answering flakes.
pub fn glint_effective(pixel: &GlintPixel, light: &GlintLight) -> f64 {
    BIWEIGHT_AREA * pixel.kernel.root * light.area
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glint::MOST_ANISOTROPY;

    #[test]
    fn the_square_comes_back_from_the_disk() {
        for i in 0..=20 {
            for j in 0..=20 {
                let y = DVec2::new(f64::from(i), f64::from(j)) / 20.0;
                let d = square_to_disk(y);
                assert!(d.length() <= 1.0 + 1e-12 && (disk_to_square(d) - y).length() < 1e-12, "{y}");
            }
        }
    }

    #[test]
    fn inverse_roots_squared_are_inverses() {
        for (x, y) in [(DVec2::new(3.0, 1.0), DVec2::new(-0.2, 0.7)), (DVec2::new(40.0, 30.0), DVec2::new(0.1, 0.5))] {
            let kernel = glint_kernel(DMat2::from_cols(x, y), 0.5).unwrap();
            let s = glint_inverse_root(kernel);
            let e = kernel.ellipse();
            for d in [DVec2::X, DVec2::Y, DVec2::new(2.0, -1.0)] {
                let root = DVec2::new(s.x * d.x + s.y * d.y, s.y * d.x + s.z * d.y).length_squared();
                assert!((root / e.inverse().of(d) - 1.0).abs() < 1e-9);
            }
            assert!(glint_anisotropy(kernel) <= MOST_ANISOTROPY * (1.0 + 1e-9));
        }
    }
}
