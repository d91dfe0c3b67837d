//! The judge's inner loops: GGX evaluations per second, one thread.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use mipfold::ndf::{Axes, Lobe, RoughnessTensor};
use mipfold::reference::{Diffuse, Footprint, Queries};
use mipfold::roughness::Alpha;

const LOBES: usize = 4096;
const NORMALS: usize = 512;

/// Lobes of two widths, tilted every way.
fn lobes() -> Vec<(Lobe, f64)> {
    let lobe = |i: usize| {
        let (sin, cos) = (i as f32 * 2.4).sin_cos();
        let tilt = 0.4 * (i as f32 / LOBES as f32).sqrt();
        let axes = Axes { alpha_x: Alpha(0.3), alpha_y: Alpha(0.1), angle: i as f32 };
        let normal = Vec3::new(tilt * cos, tilt * sin, 1.0).normalize();
        (Lobe { normal, roughness: RoughnessTensor::from_axes(axes) }, 1.0)
    };
    (0..LOBES).map(lobe).collect()
}

fn normals() -> Vec<DVec3> {
    let normal = |i: usize| {
        let (sin, cos) = (i as f64 * 2.4).sin_cos();
        let r = (i as f64 / NORMALS as f64).sqrt() * 0.7;
        DVec3::new(r * cos, r * sin, (1.0 - r * r).sqrt())
    };
    (0..NORMALS).map(normal).collect()
}

fn judge(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let (lobes, normals) = (lobes(), normals());
    let footprint = Footprint::of_lobes(&lobes);
    let mut queries = Queries::default();
    for (i, m) in normals.iter().enumerate() {
        if i % (NORMALS / 4) == 0 {
            queries.start_view(DVec3::new(0.1 * i as f64 / NORMALS as f64, 0.0, 1.0).normalize());
        }
        queries.push_half(*m);
    }
    let mut group = criterion.benchmark_group("judge");
    group.throughput(Throughput::Elements((LOBES * NORMALS) as u64));
    group.bench_function("density", |b| b.iter(|| pool.install(|| footprint.density(black_box(&normals)))));
    let none = Diffuse::default();
    group.bench_function("density and shading", |b| b.iter(|| footprint.means(black_box(&queries), &none)));
    group.finish();
}

criterion_group!(benches, judge);
criterion_main!(benches);
