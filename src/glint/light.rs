//! Solid angles: of a light, of a flake's own lobe, and of what a pixel sees of half vectors.

use std::f64::consts::PI;

use glam::DVec3;

use super::chart::Tail;
use super::footprint::{BIWEIGHT_AREA, SUPPORT2};
use crate::roughness::Alpha;

/// Steradians, 0 or more.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct SolidAngle(pub f64);

impl SolidAngle {
    /// Of half vectors that a flake with a lobe of its own answers: the effective area `1 / integral K^2` of the lobe's
    /// slope density K, `3 pi alpha^2` for GGX and `2 pi alpha^2` for Beckmann. The macro lobe then is the flakes'
    /// normals spread by this lobe.
    pub fn of_flake(alpha: Alpha, tail: Tail) -> Self {
        let a2 = f64::from(alpha.0) * f64::from(alpha.0);
        match tail {
            Tail::Ggx => Self(3.0 * PI * a2),
            Tail::Beckmann => Self(2.0 * PI * a2),
        }
    }

    /// Of a round light seen under this half angle, radians: 0.00465 for the sun.
    pub fn of_cone(half_angle: f64) -> Self {
        let s = (0.5 * half_angle).sin();
        Self(4.0 * PI * s * s)
    }
}

/// A light as a pixel's half vectors see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Of the light from the surface; 0 for a point.
    pub solid_angle: SolidAngle,
    /// Cosine of light and half vector: `d(half vector) = d(light) / (4 l.h)` (Walter et al. 2007).
    pub l_dot_h: f64,
    /// Derivatives of the unit half vector, tangent frame, along the screen's x and y, per pixel. 0 if not known: small
    /// footprints on flat surfaces.
    pub half_vector_per_pixel: [DVec3; 2],
}

impl Light {
    /// A light without change of the half vector over the pixel.
    pub fn new(solid_angle: SolidAngle, l_dot_h: f64) -> Self {
        Self { solid_angle, l_dot_h, half_vector_per_pixel: [DVec3::ZERO; 2] }
    }

    /// Effective solid angle of half vectors that make a flake of this lobe shine in the pixel: flake and light add, and
    /// the pixel's own spread of half vectors is added to their sum as tensors are, so that a spread along one direction
    /// counts.
    pub fn half_vectors(&self, flake: SolidAngle) -> SolidAngle {
        let round = flake.0.max(0.0) + self.solid_angle.0.max(0.0) / (4.0 * self.l_dot_h.abs().max(1e-3));
        let [dx, dy] = self.half_vector_per_pixel;
        if dx == DVec3::ZERO && dy == DVec3::ZERO {
            return SolidAngle(round);
        }
        // Squared support radius of the round part, and the tensor of the pixel's.
        let r2 = round / BIWEIGHT_AREA;
        let (xx, xy, yy) = (SUPPORT2 * dx.length_squared(), SUPPORT2 * dx.dot(dy), SUPPORT2 * dy.length_squared());
        SolidAngle(BIWEIGHT_AREA * ((r2 + xx) * (r2 + yy) - xy * xy).max(r2 * r2).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_vectors_worked_by_hand() {
        let sun = Light::new(SolidAngle::of_cone(0.1), 0.5);
        assert!((sun.solid_angle.0 / (PI * 0.01) - 1.0).abs() < 1e-3);
        let omega = sun.half_vectors(SolidAngle(0.002)).0;
        assert!((omega - (0.002 + sun.solid_angle.0 / 2.0)).abs() < 1e-12);
        // A spread of equal derivatives adds its own area; one along a line adds too.
        let mut wide = sun;
        wide.half_vector_per_pixel = [DVec3::X * 0.01, DVec3::Y * 0.01];
        let both = wide.half_vectors(SolidAngle(0.002)).0;
        assert!((both - omega - BIWEIGHT_AREA * SUPPORT2 * 1e-4).abs() < 1e-12);
        wide.half_vector_per_pixel = [DVec3::X * 0.01, DVec3::X * 0.01];
        let line = wide.half_vectors(SolidAngle(0.002)).0;
        assert!(line > omega && line < both + 1e-4);
        assert!((SolidAngle::of_flake(Alpha(0.1), Tail::Beckmann).0 - 0.02 * PI).abs() < 1e-7);
    }

    /// Effective areas of the two lobes, by quadrature of their squared slope densities.
    #[test]
    fn flake_lobes_have_these_effective_areas() {
        for (tail, shape) in [
            (Tail::Ggx, (|q| 1.0 / (PI * (1.0 + q) * (1.0 + q))) as fn(f64) -> f64),
            (Tail::Beckmann, |q| (-q).exp() / PI),
        ] {
            // q = x / (1 - x), dA = pi dq at unit width.
            let n = 20_000;
            let squares: f64 = (0..n)
                .map(|i| (f64::from(i) + 0.5) / f64::from(n))
                .map(|x| PI * shape(x / (1.0 - x)).powi(2) / (1.0 - x).powi(2) / f64::from(n))
                .sum();
            let omega = SolidAngle::of_flake(Alpha(1.0), tail).0;
            assert!((1.0 / squares / omega - 1.0).abs() < 1e-6, "{tail:?}: {}", 1.0 / squares);
        }
    }
}
