//! Metal flakes.

use glam::Vec3;

use super::Sample;
use super::maps::{Maps, Texel, uv};
use super::noise::{Points, Random};
use crate::roughness::PerceptualRoughness;

/// See [`Sample::about`].
pub const SAMPLE: Sample = Sample {
    name: "flakes",
    about: "flakes of car paint, each flat and randomly tilted: glitter near by, a broad sheen far away",
    make,
};

/// Flakes along one side.
const FLAKES: usize = 84;
/// Standard deviation of a flake's slope, per axis.
const TILT: f32 = 0.16;

/// A flake of its own.
#[derive(Clone, Copy)]
struct Flake {
    normal: Vec3,
    roughness: PerceptualRoughness,
}

fn make(size: usize, seed: u64) -> Maps {
    let points = Points::new(seed, 0, FLAKES);
    let mut random = Random::new(seed, 1);
    let flakes: Vec<_> = (0..points.len())
        .map(|_| Flake {
            normal: Vec3::new(TILT * random.bell(), TILT * random.bell(), 1.0).normalize(),
            roughness: PerceptualRoughness(random.between(0.2, 0.32)),
        })
        .collect();
    Maps::from_fn(size, |x, y| {
        let Flake { normal, roughness } = flakes[points.nearest(uv(size, x, y)).index];
        Texel { normal, occlusion: 1.0, roughness, metallic: 1.0 }
    })
}
