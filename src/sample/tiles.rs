//! Glazed tiles.

use super::Sample;
use super::maps::{Maps, Texel, smoothstep, uv};
use super::noise::{Noise, Random};
use super::relief::Relief;
use crate::roughness::PerceptualRoughness;

/// See [`Sample::about`].
pub const SAMPLE: Sample = Sample {
    name: "tiles",
    about: "flat glossy tiles, each a little tilted, and rare deep rough grout: two surfaces in one footprint",
    make,
};

/// Tiles along one side.
const TILES: usize = 8;
/// Half the grout's width, the rounded edge's width and its depth, in tiles.
const GROUT: f32 = 0.03;
const EDGE: f32 = 0.06;
const DEPTH: f32 = 0.05;
/// Slope of a tile, per axis.
const TILT: f32 = 0.035;

/// A tile of its own: how it was laid and how it was glazed.
struct Tile {
    tilt: [f32; 2],
    gloss: f32,
}

/// The tile at texture coordinates, and the place in it, -0.5 to 0.5 on both axes.
fn place([u, v]: [f32; 2]) -> (usize, [f32; 2]) {
    let [x, y] = [u, v].map(|c| c * TILES as f32);
    let index = (y.floor() as usize % TILES) * TILES + x.floor() as usize % TILES;
    (index, [x - x.floor() - 0.5, y - y.floor() - 0.5])
}

/// 0 in the grout, 1 on the flat of a tile: a rectangle with round corners.
fn glaze([x, y]: [f32; 2]) -> f32 {
    let corner = 2.0 * EDGE;
    let outside = |c: f32| (c.abs() - (0.5 - GROUT - corner)).max(0.0);
    let (dx, dy) = (outside(x), outside(y));
    1.0 - smoothstep(corner - EDGE, corner, (dx * dx + dy * dy).sqrt())
}

fn make(size: usize, seed: u64) -> Maps {
    let mut random = Random::new(seed, 0);
    let tiles: Vec<_> = (0..TILES * TILES)
        .map(|_| Tile { tilt: [TILT * random.bell(), TILT * random.bell()], gloss: random.between(-1.0, 1.0) })
        .collect();
    let waviness = Noise::new(seed, 1, [3 * TILES, 3 * TILES]);
    let sand = Noise::new(seed, 2, [24 * TILES, 24 * TILES]);
    let relief = Relief::from_fn(size, |uv| {
        let (index, [x, y]) = place(uv);
        let Tile { tilt: [tx, ty], .. } = tiles[index];
        let top = DEPTH + tx * x + ty * y + 0.003 * waviness.at(uv);
        let floor = 0.005 * sand.at(uv);
        (floor + (top - floor) * glaze([x, y])) / TILES as f32
    });
    Maps::from_fn(size, |x, y| {
        let uv = uv(size, x, y);
        let (index, place) = place(uv);
        let glaze = glaze(place);
        let (tile, grout) = (0.2 + 0.04 * tiles[index].gloss, 0.85 + 0.08 * sand.at(uv));
        Texel {
            normal: relief.normal(x, y),
            occlusion: 0.6 + 0.4 * glaze,
            roughness: PerceptualRoughness(grout + (tile - grout) * smoothstep(0.0, 0.4, glaze)),
            metallic: 0.0,
        }
    })
}
