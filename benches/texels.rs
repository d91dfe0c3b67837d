//! Queries of a normal map's own texels: one pixel and half vector, one thread.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{DMat2, DVec2, DVec3};
use mipfold::glint::texels::{AlphaSource, TexelGlints};
use mipfold::roughness::Alpha;
use ndarray::Array3;

const SIDE: usize = 256;
/// Half vectors, one after the other.
const HALF: usize = 8;

/// A uniform number in -1..1 of a texel.
fn noise(seed: u64, x: usize, y: usize) -> f64 {
    let z = (seed << 40 | (x as u64) << 20 | y as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((z ^ (z >> 32)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Every texel a slope of its own: the worst there is.
fn spikes(x: usize, y: usize) -> DVec2 {
    0.3 * DVec2::new(noise(1, x, y), noise(2, x, y))
}

/// Smooth bumps.
fn bumps(x: usize, y: usize) -> DVec2 {
    let (u, v) = (x as f64 * std::f64::consts::TAU / 32.0, y as f64 * std::f64::consts::TAU / 16.0);
    0.2 * DVec2::new((u + v.sin()).cos(), (v + u.cos()).sin())
}

fn texels(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("texels");
    group.sample_size(10);
    type Map = fn(usize, usize) -> DVec2;
    let maps: [(&str, Map); 2] = [("bumps", bumps), ("spikes", spikes)];
    for (name, slope) in maps {
        let normals = Array3::from_shape_fn((SIDE, SIDE, 3), |(y, x, c)| {
            let s = slope(x, y);
            DVec3::new(-s.x, -s.y, 1.0).normalize()[c] as f32
        });
        for alpha in [0.02, 0.1] {
            let glints = TexelGlints::new(&normals, AlphaSource::Constant(Alpha(alpha))).expect("a map");
            for width in [1.0, 4.0, 16.0, 64.0] {
                let jacobian = DMat2::IDENTITY * (width / SIDE as f64);
                let mut k = 0;
                group.bench_function(BenchmarkId::new(format!("{name} alpha {alpha}"), width), |b| {
                    b.iter(|| {
                        k = (k + 1) % HALF;
                        let h = DVec3::new(0.2 * noise(3, k, 0), 0.2 * noise(4, k, 0), 1.0).normalize();
                        glints.ndf(DVec2::new(0.37, 0.58), jacobian, black_box(h))
                    });
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, texels);
criterion_main!(benches);
