//! Scratched metal.

use super::Sample;
use super::maps::{Maps, Texel, smoothstep, uv};
use super::noise::{Noise, Random};
use super::relief::Relief;
use crate::roughness::PerceptualRoughness;

/// See [`Sample::about`].
pub const SAMPLE: Sample = Sample {
    name: "scratched-metal",
    about: "sparse crossing scratches on flat shiny metal: a sharp peak with heavy tails",
    make,
};

const SCRATCHES: usize = 110;

/// A straight groove that runs out at both ends; lengths in texture sides.
struct Scratch {
    middle: [f32; 2],
    direction: [f32; 2],
    half_length: f32,
    half_width: f32,
    depth: f32,
}

impl Scratch {
    fn random(random: &mut Random) -> Self {
        let half_width = random.between(1.6, 2.8) / 512.0;
        Self {
            middle: [random.between(0.0, 1.0), random.between(0.0, 1.0)],
            direction: random.direction(),
            half_length: random.between(0.04, 0.26),
            half_width,
            // The steepest part of the profile below slopes 1.54 times this ratio.
            depth: half_width * random.between(0.3, 0.75),
        }
    }

    /// Height of the groove at an offset from its middle, at most 0: profile `(1 - t^2)^2`, shallower to the ends.
    fn height(&self, [x, y]: [f32; 2]) -> f32 {
        let [c, s] = self.direction;
        let along = (c * x + s * y) / self.half_length;
        let across = (c * y - s * x) / self.half_width;
        let bowl = |t: f32| (1.0 - t * t).max(0.0);
        -self.depth * bowl(along) * bowl(across) * bowl(across)
    }

    /// Cuts the groove: walks the texels along its longer axis, and across only as far as it is wide.
    fn cut(&self, size: usize, relief: &mut Relief) {
        let side = size as f32;
        let [c, s] = self.direction;
        let steep = s.abs() > c.abs();
        let (major, minor) = if steep { (s, c) } else { (c, s) };
        let reach = (self.half_length * major.abs() * side).ceil() as isize;
        let width = (self.half_width / major.abs() * side).ceil() as isize + 1;
        let corner = self.middle.map(|m| (m * side).floor());
        for i in -reach..=reach {
            let centre = (i as f32 * minor / major).round() as isize;
            for j in centre - width..=centre + width {
                let (x, y) = if steep { (j, i) } else { (i, j) };
                let offset = [x as f32 / side, y as f32 / side];
                relief.lower(corner[0] as isize + x, corner[1] as isize + y, self.height(offset));
            }
        }
    }
}

fn make(size: usize, seed: u64) -> Maps {
    let mut random = Random::new(seed, 0);
    let mut grooves = Relief::from_fn(size, |_| 0.0);
    for _ in 0..SCRATCHES {
        Scratch::random(&mut random).cut(size, &mut grooves);
    }
    let haze = Noise::new(seed, 1, [24, 24]);
    Maps::from_fn(size, |x, y| {
        let cut = smoothstep(0.0, 1.0 / 1024.0, -grooves.at(x, y));
        Texel {
            normal: grooves.normal(x, y),
            occlusion: 1.0,
            roughness: PerceptualRoughness(0.22 + 0.02 * haze.at(uv(size, x, y)) + 0.2 * cut),
            metallic: 1.0,
        }
    })
}
