//! Hammered metal.

use super::Sample;
use super::maps::{Maps, Texel, smoothstep, uv};
use super::noise::{Noise, Points};
use super::relief::Relief;
use crate::roughness::PerceptualRoughness;

/// See [`Sample::about`].
pub const SAMPLE: Sample =
    Sample { name: "hammered-metal", about: "round dents side by side: smooth, isotropic, no two normals alike", make };

/// Hammer strokes along one side.
const STROKES: usize = 20;
const SLOPE_RMS: f32 = 0.32;
/// How far the ridges between dents are rounded, in squared cells.
const ROUNDING: f32 = 0.3;

fn make(size: usize, seed: u64) -> Maps {
    let strokes = Points::new(seed, 0, STROKES);
    // Each stroke leaves a paraboloid; the lowest one shows. Where two are equally low, a parabola joins them.
    let relief = Relief::from_fn(size, |uv| {
        let nearest = strokes.nearest(uv);
        let join = (1.0 - (nearest.second - nearest.first) / ROUNDING).max(0.0);
        nearest.first - 0.25 * ROUNDING * join * join
    })
    .with_slopes(SLOPE_RMS);
    let wear = Noise::new(seed, 1, [40, 40]);
    Maps::from_fn(size, |x, y| {
        let uv = uv(size, x, y);
        let nearest = strokes.nearest(uv);
        let ridge = 1.0 - smoothstep(0.0, 0.35, nearest.second - nearest.first);
        Texel {
            normal: relief.normal(x, y),
            occlusion: 1.0,
            roughness: PerceptualRoughness(0.22 + 0.03 * wear.at(uv) + 0.12 * ridge),
            metallic: 1.0,
        }
    })
}
