//! Woven cloth.

use super::Sample;
use super::maps::{Maps, Texel, smoothstep, uv};
use super::noise::Noise;
use super::relief::Relief;
use crate::roughness::PerceptualRoughness;

/// See [`Sample::about`].
pub const SAMPLE: Sample = Sample {
    name: "woven-cloth",
    about: "plain weave of smooth thread: two crossed sets of cylinders, a distribution with two ridges",
    make,
};

/// Threads along one side; even, so that over and under meet across the border.
const THREADS: usize = 24;
/// How far a thread swings up and down, and how round it is, in threads.
const SWING: f32 = 0.10;
const ROUND: f32 = 0.22;
/// Half of a thread's width, in threads.
const HALF_WIDTH: f32 = 0.47;
const FIBRE: f32 = 0.006;

/// A wave of period 2 between -1 and 1 that is 1 at 0.5: cubic arcs in place of a sine.
fn wave(x: f32) -> f32 {
    let t = x - 2.0 * (0.5 * x).floor();
    let rise = 1.0 - 2.0 * (t - 0.5 - 2.0 * ((t - 0.5) * 0.5).round()).abs();
    0.5 * rise * (3.0 - rise * rise)
}

/// Heights of the warp (along v) and the weft (along u) in threads, without fibres.
fn threads([u, v]: [f32; 2]) -> [f32; 2] {
    let (x, y) = (u * THREADS as f32, v * THREADS as f32);
    let round = |c: f32| {
        let t = (c - c.floor() - 0.5) / HALF_WIDTH;
        ROUND * (1.0 - t * t)
    };
    [SWING * wave(y + x.floor()) + round(x), SWING * wave(x + y.floor() + 1.0) + round(y)]
}

fn make(size: usize, seed: u64) -> Maps {
    // Fibres run along their thread: many cells across it, few along it.
    let (fine, coarse) = (THREADS * 7, THREADS * 2);
    let fibres = [Noise::new(seed, 0, [fine, coarse]), Noise::new(seed, 1, [coarse, fine])];
    let fibre = |uv: [f32; 2]| {
        let [warp, weft] = threads(uv);
        fibres[usize::from(weft > warp)].at(uv)
    };
    let height = |uv: [f32; 2]| {
        let [warp, weft] = threads(uv);
        warp.max(weft) + FIBRE * fibre(uv)
    };
    let relief = Relief::from_fn(size, |uv| height(uv) / THREADS as f32);
    Maps::from_fn(size, |x, y| {
        let uv = uv(size, x, y);
        let depth = 1.0 - smoothstep(-0.02, 0.2, height(uv));
        Texel {
            normal: relief.normal(x, y),
            occlusion: 1.0 - 0.5 * depth,
            roughness: PerceptualRoughness(0.34 + 0.06 * fibre(uv) + 0.25 * depth),
            metallic: 0.0,
        }
    })
}
