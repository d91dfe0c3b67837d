//! Megatexels in a second (`Melem/s`) on one thread: blocks made and decoded, and whole KTX 2 files.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mipfold::codec::decode as read;
use mipfold::codec::texture::{Effort, TexelFormat, Texture, decode, encode, write_ktx2};
use mipfold::image::{Raster, Samples};
use mipfold::sample::by_name;
use ndarray::Array3;

const SIDE: usize = 512;

fn bench(criterion: &mut Criterion) {
    let maps = (by_name("hammered-metal").unwrap().make)(SIDE, 1);
    let Samples::U8(orm) = &maps.orm.samples else { unreachable!() };
    // The gloss in alpha, as some engines have it.
    let packed =
        Array3::from_shape_fn((SIDE, SIDE, 4), |(y, x, c)| if c < 3 { orm[(y, x, c)] } else { 255 - orm[(y, x, 1)] });
    let normals = ("normals", &maps.normal);
    let packed = ("packed with alpha", &Raster::new(Samples::U8(packed)));
    let (opaque, both) = ([normals], [normals, packed]);
    let (fast, efforts) = ([Effort::Fast], [Effort::Fast, Effort::Slow]);
    let cases = [
        (TexelFormat::Bc4, fast.as_slice(), opaque.as_slice()),
        (TexelFormat::Bc5, &fast, &opaque),
        (TexelFormat::Bc7, &efforts, &both),
        (TexelFormat::Uastc, &efforts, &both),
    ];

    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = criterion.benchmark_group("texture");
    group.sample_size(10).throughput(Throughput::Elements((SIDE * SIDE) as u64));
    for (format, efforts, maps) in cases {
        for (map, raster) in maps {
            for effort in efforts {
                let id =
                    BenchmarkId::new(format!("encode {}", format.name()), format!("{map}, {effort:?}").to_lowercase());
                group.bench_function(id, |b| {
                    b.iter(|| pool.install(|| black_box(encode(black_box(raster), format, *effort)).len()));
                });
            }
            let bytes = encode(raster, format, Effort::Fast);
            group.bench_function(BenchmarkId::new(format!("decode {}", format.name()), map), |b| {
                b.iter(|| pool.install(|| black_box(decode(black_box(&bytes), raster.size(), format)).size()));
            });
        }
    }
    for format in [TexelFormat::Rg8, TexelFormat::Bc5, TexelFormat::Bc7, TexelFormat::Uastc] {
        let texture = Texture::encode(std::slice::from_ref(normals.1), format, Effort::Fast);
        let file = |zstd: Option<Effort>| {
            let mut file = Vec::new();
            write_ktx2(&mut file, &texture, zstd).unwrap();
            file
        };
        for (packing, zstd) in
            [("", None), (" with Zstandard", Some(Effort::Fast)), (" with Zstandard, slow", Some(Effort::Slow))]
        {
            group.bench_function(BenchmarkId::new(format!("write KTX 2{packing}"), format.name()), |b| {
                b.iter(|| pool.install(|| black_box(file(zstd)).len()));
            });
            let file = file(zstd);
            group.bench_function(BenchmarkId::new(format!("read KTX 2{packing}"), format.name()), |b| {
                b.iter(|| pool.install(|| read("a.ktx2".as_ref(), black_box(file.clone())).unwrap().bytes_len));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
