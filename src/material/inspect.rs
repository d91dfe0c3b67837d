//! What is wrong with the texels of a material, counted.

use rayon::prelude::*;

use super::source::SHORTEST_NORMAL;
use super::{Material, Texels};

/// Counts over level 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Findings {
    /// Texels.
    pub texels: usize,
    /// Normals that point into the surface or along it (z <= 0).
    pub behind: usize,
    /// Normals that are not a number, or too short to have a direction.
    pub directionless: usize,
    /// Roughness that is not a number.
    pub roughness_not_finite: usize,
    /// Roughness outside 0..1.
    pub roughness_outside: usize,
    /// Mean length of the stored normals.
    pub mean_length: f64,
    /// Mean of the stored x and y, -1..1.
    pub mean_xy: [f64; 2],
    /// Mean absolute x and y about their own mean.
    pub spread_xy: f64,
}

impl Findings {
    /// Normals that the fold ignores.
    pub fn unusable(&self) -> usize {
        self.behind + self.directionless
    }

    /// Whether the normals look sRGB-encoded: flat is stored as 188,188,255, so x and y lean by 0.47 alike and
    /// normals are far longer than 1. Real surfaces do not lean to +x +y by 25 degrees in the mean.
    pub fn looks_srgb(&self) -> bool {
        self.mean_xy.iter().all(|m| m.abs() > 0.35 && m.abs() < 0.6)
            && (self.mean_xy[0].abs() - self.mean_xy[1].abs()).abs() < 0.1
            && self.mean_length > 1.1
    }

    fn add(mut self, o: &Findings) -> Self {
        self.texels += o.texels;
        self.behind += o.behind;
        self.directionless += o.directionless;
        self.roughness_not_finite += o.roughness_not_finite;
        self.roughness_outside += o.roughness_outside;
        self.mean_length += o.mean_length;
        (0..2).for_each(|i| self.mean_xy[i] += o.mean_xy[i]);
        self
    }
}
