//! Folding alone, from floats in memory, against the time that reading those floats takes: Mtexel/s by fold.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mipfold::fold::{FOLDS, Options, chain};
use mipfold::image::Size;
use mipfold::material::Texels;
use mipfold::ndf::Form;

const SIDE: usize = 2048;

/// Planes of floats: normal x y z, perceptual roughness.
struct Planes([Vec<f32>; 4]);

impl Planes {
    fn waves() -> Self {
        let mut planes: [Vec<f32>; 4] = std::array::from_fn(|_| Vec::with_capacity(SIDE * SIDE));
        for i in 0..SIDE * SIDE {
            let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
            let (sx, sy) = (0.3 * (0.7 * x + 0.2 * y).sin(), 0.2 * (0.1 * x - 0.9 * y).cos());
            let z = 1.0 / (1.0 + sx * sx + sy * sy).sqrt();
            [-sx * z, -sy * z, z, 0.3].into_iter().zip(&mut planes).for_each(|(v, plane)| plane.push(v));
        }
        Self(planes)
    }
}

impl Texels for Planes {
    fn size(&self) -> Size {
        Size::new(SIDE, SIDE)
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        for (out, plane) in out.into_iter().zip(&self.0) {
            out.copy_from_slice(&plane[y * SIDE + x..][..out.len()]);
        }
        coverage.fill(1.0);
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        out.copy_from_slice(&self.0[3][y * SIDE + x..][..out.len()]);
    }
}

fn folds(criterion: &mut Criterion) {
    let texels = Planes::waves();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut group = criterion.benchmark_group(format!("fold, {threads} threads"));
        group.throughput(Throughput::Elements((SIDE * SIDE) as u64)).sample_size(20);
        group.bench_function("read the floats", |b| {
            b.iter(|| {
                let sum = |plane: &Vec<f32>| {
                    plane.chunks_exact(16).fold([0.0f32; 16], |mut sum, chunk| {
                        sum.iter_mut().zip(chunk).for_each(|(s, v)| *s += v);
                        sum
                    })
                };
                black_box(texels.0.each_ref().map(sum))
            });
        });
        for form in [Form::Isotropic, Form::Anisotropic] {
            let mut bench = |name: &str, options: Options| {
                group.bench_function(BenchmarkId::new(name, format!("{form:?}")), |b| {
                    b.iter(|| pool.install(|| chain(black_box(&texels), &options)));
                });
            };
            // One `ggx-lobe` would take minutes.
            let folds = FOLDS.iter().filter(|fold| !fold.is_slow());
            for fold in folds.filter(|fold| form == Form::Isotropic || fold.has_two_widths()) {
                bench(fold.name, Options { fold, form, ..Options::default() });
            }
            for lobes in [2, 4] {
                bench(&format!("{} lobes", lobes), Options { form, lobes, ..Options::default() });
            }
        }
    }
}

criterion_group!(benches, folds);
criterion_main!(benches);
