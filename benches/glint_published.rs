//! What glints cost, published and our own, beside the smooth lobe alone, on one thread: 1024 queries at a time.

use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mipfold::glint::Tail;

#[path = "../tests/glints/published/mod.rs"]
mod published;

use published::cases::Case;
use published::{Contender, Published};

/// Of one kind, at random.
const QUERIES: u32 = 1024;

/// The unit: a GGX lobe.
fn ggx(q: &Published) -> f64 {
    let a2 = f64::from(q.alpha.squared());
    let d = q.h.z * q.h.z * (a2 - 1.0) + 1.0;
    a2 / (PI * d * d)
}

fn measure(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    queries: impl Iterator<Item = Published>,
    ratio: impl Fn(&Published) -> f64,
) {
    let queries: Vec<_> = queries.collect();
    group.bench_with_input(BenchmarkId::from_parameter(name), &queries, |b, queries| {
        b.iter(|| queries.iter().map(|q| ratio(black_box(q))).sum::<f64>());
    });
}

fn ratios(criterion: &mut Criterion) {
    for anisotropy in [1.0, 8.0] {
        for n_eff in [0.1, 1.0, 10.0] {
            let case = Case { n_eff, anisotropy };
            let queries = |tail| (0..QUERIES).map(move |n| case.query(tail, n, 9));
            let mut group = criterion.benchmark_group(format!("glints, N_eff {n_eff}, anisotropy {anisotropy}"));
            group.throughput(Throughput::Elements(u64::from(QUERIES))).sample_size(20);
            group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
            measure(&mut group, "D of GGX", queries(Tail::Ggx), ggx);
            for contender in Contender::all() {
                measure(&mut group, contender.name, queries(contender.tail), |q| contender.ratio(q));
            }
            group.finish();
        }
    }
}

criterion_group!(benches, ratios);
criterion_main!(benches);
