//! The definition, summed over dense samples of interpolated slopes.

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::super::{Footprint, TexelGlints};

/// Samples under one kernel.
pub struct Brute(Vec<Sample>);

struct Sample {
    normal: DVec3,
    alpha: f64,
    /// Kernel over the projected area of the lobe's ellipsoid.
    weight: f64,
}

/// GGX about a normal, as in every renderer.
fn ggx(n: DVec3, h: DVec3, alpha: f64) -> f64 {
    let (cos2, a2) = (n.dot(h).powi(2), alpha * alpha);
    let sin2 = n.cross(h).length_squared();
    a2 / (std::f64::consts::PI * (cos2 * a2 + sin2).powi(2))
}

impl Brute {
    /// With `per_texel` samples along each side of a texel.
    pub fn new(glints: &TexelGlints, uv: DVec2, jacobian: DMat2, per_texel: usize) -> Self {
        Self::with(glints, &glints.footprint(uv, jacobian).unwrap(), per_texel, |map, x| map.slopes().at(x))
    }

    /// The same with another interpolation.
    pub fn with(
        glints: &TexelGlints,
        kernel: &Footprint,
        per_texel: usize,
        slope: impl Fn(&TexelGlints, DVec2) -> (DVec2, f64) + Sync,
    ) -> Self {
        let step = 1.0 / per_texel as f64;
        let (first, last) = ((kernel.centre - kernel.half).floor(), (kernel.centre + kernel.half).ceil());
        let lines = ((last.y - first.y) / step) as usize;
        let columns = ((last.x - first.x) / step) as usize;
        let line = |j: usize| {
            let mut samples = Vec::new();
            for i in 0..columns {
                let x = first + (DVec2::new(i as f64, j as f64) + 0.5) * step;
                let w = kernel.at(x);
                if w > 0.0 {
                    let (s, alpha) = slope(glints, x);
                    let length = (1.0 + s.length_squared()).sqrt();
                    let normal = DVec3::new(-s.x, -s.y, 1.0) / length;
                    let area = (normal.z.powi(2) + alpha * alpha * (1.0 - normal.z.powi(2))).sqrt();
                    samples.push(Sample { normal, alpha, weight: w * step * step / area });
                }
            }
            samples
        };
        Self((0..lines).into_par_iter().flat_map_iter(line).collect())
    }

    pub fn ndf(&self, h: DVec3) -> f64 {
        self.0.par_iter().map(|s| s.weight * ggx(s.normal, h, s.alpha)).sum()
    }

    /// On this thread alone.
    pub fn ndf_alone(&self, h: DVec3) -> f64 {
        self.0.iter().map(|s| s.weight * ggx(s.normal, h, s.alpha)).sum()
    }

    /// Samples under the kernel.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}
