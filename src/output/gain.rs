//! Whether folding was worth it.

use glam::Vec2;
use rayon::prelude::*;
use serde::Serialize;

use super::fold_for::{geometric_roughness, plain_roughness};
use crate::fold::{Chain, Level};
use crate::moments;
use crate::ndf::{Lobe, Lobes, RoughnessTensor};

/// How far a folded chain is from plain mips.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// By how much the perceptual roughness differs, in 99 of 100 texels of every level by no more than this: 0 to 1.
    pub roughness: f32,
    /// The level where it differs most.
    pub level: usize,
}

impl Gain {
    /// Below this nobody sees a difference: two and a half steps of 8 bits.
    pub const NOTHING: f32 = 0.01;

    /// In words.
    pub fn describe(&self) -> String {
        let Gain { roughness, level } = self;
        if *roughness < Self::NOTHING {
            format!("folding changes the roughness by at most {roughness:.3}: nothing to gain over plain mips")
        } else {
            format!("folding changes the roughness by up to {roughness:.2} (level {level})")
        }
    }
}

/// Texels that may differ by more: 1 in so many.
const OUTLIERS: usize = 100;

/// Compares a chain of [`super::fold_for`] with what plain mips of the roughness would be. Of two widths the geometric mean
/// counts, and a mixture is taken for one lobe as wide as all of it.
pub fn gain(chain: &Chain) -> Gain {
    let levels: Vec<f32> = chain.levels.par_iter().map(difference).collect();
    let most = levels.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    most.map_or(Gain { roughness: 0.0, level: 0 }, |(i, roughness)| Gain { roughness: *roughness, level: i + 1 })
}

fn difference(level: &Level) -> f32 {
    /// Steps from 0 to 1.
    const STEPS: usize = 4096;
    let (lobes, size) = (&level.lobes, level.lobes.size());
    let channel = plain_roughness(level);
    let mut counts = vec![0usize; STEPS + 1];
    for y in 0..size.height {
        for x in 0..size.width {
            let folded = perceptual(lobes, x, y);
            let difference = (folded - level.extras[(channel, y, x)]).abs().min(1.0);
            counts[(difference * STEPS as f32).ceil() as usize] += 1;
        }
    }
    let mut left = size.texels() / OUTLIERS;
    for step in (0..=STEPS).rev() {
        if counts[step] > left {
            return step as f32 / STEPS as f32;
        }
        left -= counts[step];
    }
    0.0
}

/// Perceptual roughness of the lobe that is as wide as all of a texel's.
fn perceptual(lobes: &Lobes, x: usize, y: usize) -> f32 {
    let slope = |lobe: &Lobe| moments::slope(lobe.normal);
    let mean: Vec2 = lobes.mixture(x, y).map(|(lobe, weight)| weight * slope(&lobe)).sum();
    let tensors = lobes.mixture(x, y).map(|(lobe, weight)| {
        let (d, r) = (slope(&lobe) - mean, lobe.roughness);
        [r.xx + d.x * d.x, r.xy + d.x * d.y, r.yy + d.y * d.y].map(|v| weight * v)
    });
    let [xx, xy, yy] = tensors.fold([0.0; 3], |sum, part| [0, 1, 2].map(|i| sum[i] + part[i]));
    geometric_roughness(RoughnessTensor { xx, xy, yy })
}
