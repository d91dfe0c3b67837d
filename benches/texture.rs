//! Megatexels in a second (`Melem/s`) of block compression, on one thread, and of Zstandard.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mipfold::codec::decode;
use mipfold::codec::texture::{Effort, TexelFormat, Texture, encode, write_ktx2};
use mipfold::image::{Raster, Samples};
use mipfold::sample::by_name;
use ndarray::{Array3, concatenate};

const SIDE: usize = 512;

fn bench(criterion: &mut Criterion) {
    let maps = (by_name("hammered-metal").unwrap().make)(SIDE, 1);
    let Samples::U8(orm) = &maps.orm.samples else { unreachable!() };
    // The gloss in alpha, as some engines have it.
    let gloss = Array3::from_shape_fn((SIDE, SIDE, 1), |(y, x, _)| 255 - orm[(y, x, 1)]);
    let four = Raster::new(Samples::U8(concatenate![ndarray::Axis(2), orm.view(), gloss]));
    let normal = &maps.normal;

    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = criterion.benchmark_group("512x512 texels, 1 thread");
    group.sample_size(10).throughput(Throughput::Elements((SIDE * SIDE) as u64));
    let cases = [
        ("normals to BC4", normal, TexelFormat::Bc4, Effort::Fast),
        ("normals to BC5", normal, TexelFormat::Bc5, Effort::Fast),
        ("normals to BC7, fast", normal, TexelFormat::Bc7, Effort::Fast),
        ("normals to BC7, slow", normal, TexelFormat::Bc7, Effort::Slow),
        ("normals to UASTC, fast", normal, TexelFormat::Uastc, Effort::Fast),
        ("normals to UASTC, slow", normal, TexelFormat::Uastc, Effort::Slow),
        ("RGBA to BC7, fast", &four, TexelFormat::Bc7, Effort::Fast),
        ("RGBA to BC7, slow", &four, TexelFormat::Bc7, Effort::Slow),
        ("RGBA to UASTC, fast", &four, TexelFormat::Uastc, Effort::Fast),
        ("RGBA to UASTC, slow", &four, TexelFormat::Uastc, Effort::Slow),
    ];
    for (name, raster, format, effort) in cases {
        group.bench_function(name, |b| {
            b.iter(|| pool.install(|| black_box(encode(black_box(raster), format, effort)).len()));
        });
    }
    for format in [TexelFormat::Rg8, TexelFormat::Bc5, TexelFormat::Bc7, TexelFormat::Uastc] {
        let texture = Texture::encode(std::slice::from_ref(normal), format, Effort::Fast);
        let file = |zstd| {
            let mut file = Vec::new();
            write_ktx2(&mut file, &texture, zstd).unwrap();
            file
        };
        group.bench_function(BenchmarkId::new("write KTX 2 with Zstandard", format.name()), |b| {
            b.iter(|| pool.install(|| black_box(file(true)).len()));
        });
        for zstd in [false, true] {
            let id = BenchmarkId::new(if zstd { "read KTX 2 with Zstandard" } else { "read KTX 2" }, format.name());
            let file = file(zstd);
            group.bench_function(id, |b| {
                b.iter(|| pool.install(|| decode("a.ktx2".as_ref(), black_box(file.clone())).unwrap().bytes_len));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
