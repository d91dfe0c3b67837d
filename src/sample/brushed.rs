//! Brushed metal.

use super::Sample;
use super::maps::{Maps, Texel, uv};
use super::noise::Noise;
use super::relief::Relief;
use crate::roughness::PerceptualRoughness;

/// See [`Sample::about`].
pub const SAMPLE: Sample =
    Sample { name: "brushed-metal", about: "fine streaks along u: variance along v alone, strongly anisotropic", make };

/// Streaks as lattice cells along u and v, and their heights.
const STREAKS: [([usize; 2], f32); 3] = [([11, 256], 1.0), ([7, 128], 1.2), ([4, 48], 1.2)];
const SLOPE_RMS: f32 = 0.28;

fn make(size: usize, seed: u64) -> Maps {
    let streaks = STREAKS.map(|(cells, height)| (Noise::new(seed, cells[1] as u64, cells), height));
    let wear = Noise::new(seed, 1, [9, 200]);
    let relief = Relief::from_fn(size, |uv| streaks.iter().map(|(noise, height)| height * noise.at(uv)).sum())
        .with_slopes(SLOPE_RMS);
    Maps::from_fn(size, |x, y| Texel {
        normal: relief.normal(x, y),
        occlusion: 1.0,
        roughness: PerceptualRoughness(0.27 + 0.07 * wear.at(uv(size, x, y))),
        metallic: 1.0,
    })
}
