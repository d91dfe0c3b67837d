//! The GGX lobe.

use std::f64::consts::PI;

use glam::Vec3;

use super::{Axes, RoughnessTensor, ShapeInvariant};
use crate::roughness::Alpha;

/// A texel: a normal and a width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit, z out of the surface.
    pub normal: Vec3,
    /// Width, in the bent frame of the normal ([`super::Frame::bent`]).
    pub roughness: RoughnessTensor,
}

impl Lobe {
    /// A lobe of one width.
    pub fn isotropic(normal: Vec3, alpha: Alpha) -> Self {
        Self { normal, roughness: RoughnessTensor::isotropic(alpha) }
    }

    /// Widths and direction of the larger one, measured from the bent tangent.
    pub fn axes(&self) -> Axes {
        self.roughness.axes()
    }
}

impl ShapeInvariant for Lobe {
    fn normal(&self) -> Vec3 {
        self.normal
    }

    fn roughness(&self) -> RoughnessTensor {
        self.roughness
    }

    fn unit_d(&self, p2: f64, z: f64) -> f64 {
        let q = p2 + z * z;
        1.0 / (PI * q * q)
    }

    fn unit_radius(&self, u: f64) -> f64 {
        (u / (1.0 - u).max(f64::MIN_POSITIVE)).sqrt()
    }

    /// `(sqrt(1 + tan^2) - 1) / 2` (Heitz 2014, eq. 72).
    fn unit_lambda(&self, tan2: f64) -> f64 {
        0.5 * ((1.0 + tan2).sqrt() - 1.0)
    }
}
