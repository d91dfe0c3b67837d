//! The Beckmann lobe.

use std::f64::consts::PI;

use glam::Vec3;

use super::student::TailExponent;
use super::{RoughnessTensor, ShapeInvariant};

/// A lobe of Gaussian slopes with the covariance `R / 2`: `P22(s) = exp(-s^T R^-1 s) / (pi sqrt(det R))`
/// (Beckmann & Spizzichino 1963; Heitz 2014, section 5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    /// Unit, z out of the surface.
    pub normal: Vec3,
    /// Width, in the bent frame of the normal ([`super::Frame::bent`]).
    pub roughness: RoughnessTensor,
}

impl ShapeInvariant for Beckmann {
    fn normal(&self) -> Vec3 {
        self.normal
    }

    fn roughness(&self) -> RoughnessTensor {
        self.roughness
    }

    fn unit_d(&self, p2: f64, z: f64) -> f64 {
        // As one exponent, since towards the horizon both factors leave the range of f64.
        (-p2 / (z * z) - 4.0 * z.ln()).exp() / PI
    }

    fn unit_radius(&self, u: f64) -> f64 {
        (-(-u).ln_1p()).sqrt()
    }

    /// `(erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi))` with `a = 1 / tan` (Heitz 2014, section 5).
    fn unit_lambda(&self, tan2: f64) -> f64 {
        TailExponent::BECKMANN.unit_lambda(tan2)
    }
}
