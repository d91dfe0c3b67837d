//! A whole build, from PNG files to PNG files, against decoding and encoding the same two files alone; one thread, so
//! that times are CPU times and their ratio holds whatever the machine does.

use std::hint::black_box;
use std::io::sink;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use mipfold::codec::{self, write_png};
use mipfold::fold::{Options, chain};
use mipfold::image::{Raster, Samples};
use mipfold::material::{ChannelRef, Inputs, LevelView, RoughnessInput, load};
use mipfold::output::{Plan, Request, write};
use mipfold::sample::by_name;
use ndarray::{Axis, Slice};

const SIDE: usize = 4096;

/// A normal map and a gray roughness map with the noise of real 8-bit pictures.
fn make_inputs(folder: &Path) -> Inputs {
    let maps = (by_name("hammered-metal").unwrap().make)(SIDE, 1);
    let (Samples::U8(mut normal), Samples::U8(orm)) = (maps.normal.samples, maps.orm.samples) else { unreachable!() };
    let mut state = 1u32;
    normal.iter_mut().for_each(|v| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *v = v.saturating_add((state >> 30) as u8);
    });
    let roughness = orm.slice_axis(Axis(2), Slice::from(1..2)).to_owned();
    let save = |name: &str, samples| {
        let path = folder.join(name);
        let mut bytes = Vec::new();
        write_png(&mut bytes, &Raster::new(Samples::U8(samples))).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let roughness = RoughnessInput::Roughness(ChannelRef { path: save("roughness.png", roughness), channel: None });
    Inputs { name: "bench".into(), normal: Some(save("normal.png", normal)), roughness, ..Inputs::default() }
}

fn build(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let inputs = make_inputs(folder.path());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = criterion.benchmark_group("4096x4096 PNG pair, 1 thread");
    group.sample_size(10);
    let options = Options::default();
    group.bench_function("read, fold, write all levels as PNG", |b| {
        let request = Request { force: true, ..Request::new(folder.path().join("out")) };
        b.iter(|| {
            pool.install(|| {
                let material = load(black_box(&inputs)).unwrap();
                let chain = chain(&material, &options);
                let plan = Plan::new(&material, &options, &request);
                write(&material, &chain, &options, &plan, &request, &|| ()).unwrap();
            });
        });
    });
    let material = load(&inputs).unwrap();
    group.bench_function("fold alone", |b| b.iter(|| pool.install(|| chain(black_box(&material), &options))));
    let chain = chain(&material, &options);
    let view = |level: usize| {
        let folded = level.checked_sub(1).map(|i| (&chain.levels[i].lobes, &chain.levels[i].extras));
        LevelView { material: &material, folded, main_axis: 0.0 }
    };
    let RoughnessInput::Roughness(roughness) = &inputs.roughness else { unreachable!() };
    let files = [inputs.normal.clone().unwrap(), roughness.path.clone()];
    let decode = || files.each_ref().map(|file| codec::read(black_box(file)).unwrap().raster);
    group.bench_function("decode both, encode both", |b| {
        b.iter(|| decode().iter().for_each(|raster| write_png(sink(), raster).unwrap()));
    });
    let mips: Vec<_> = (1..=chain.levels.len()).flat_map(|k| [0, 1].map(|map| view(k).raster(map))).collect();
    group.bench_function("decode both, encode all levels", |b| {
        b.iter(|| {
            decode().iter().for_each(|raster| write_png(sink(), raster).unwrap());
            mips.iter().for_each(|raster| write_png(sink(), raster).unwrap());
        });
    });
    group.bench_function("pack level 1", |b| b.iter(|| [0, 1].map(|map| black_box(view(1).raster(map).size()))));
}

criterion_group!(benches, build);
criterion_main!(benches);
