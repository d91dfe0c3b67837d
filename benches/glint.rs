//! Glint ratios of a pixel, evaluations per second of one thread, with plain GGX D as the unit: all in one group, so that their
//! ratios are of one run.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DMat2, DVec2, DVec3};
use mipfold::glint::{
    BIWEIGHT_AREA, FlakeDensity, Flakes, Light, Macro, Probe, Query, SolidAngle, evaluator, glint_ratio, pcg4d, unit,
};
use mipfold::roughness::Alpha;

/// Pixels of each case.
const PIXELS: u32 = 4096;

/// Light over GGX of alpha 0.3, flakes of a thousandth of a steradian; the pixel's footprint is `size` wide.
fn query(n: u32, size: f64) -> Query {
    let h = pcg4d([n, 3, 3, 1]);
    Query {
        uv: DVec2::new(unit(h[0]), unit(h[1])) * 40.0,
        jacobian: DMat2::from_diagonal(DVec2::splat(size)),
        h: DVec3::new(0.1, -0.15, 1.0).normalize(),
        lobe: Macro::isotropic(Alpha(0.3)),
        flakes: Flakes::new(FlakeDensity(4e6), SolidAngle(1e-3), 1),
        light: Light::new(SolidAngle(6.8e-5), 0.7),
    }
}

/// Pixels with this many effective flakes on average: sizes over an octave, so that levels of detail are met in all phases.
fn probes(n_eff: f64) -> Vec<Probe> {
    let probe = |n: u32, size: f64| query(n, size).probe().expect("a query of finite numbers");
    let known = probe(0, 1e-2);
    let radius = (n_eff / (known.area * BIWEIGHT_AREA)).sqrt();
    let size = 1e-2 * radius / known.kernel.radii()[0];
    (0..PIXELS).map(|n| probe(n, size * (f64::from(n * 1597 % PIXELS) / f64::from(PIXELS) - 0.5).exp2())).collect()
}

fn glints(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("glint");
    group.throughput(Throughput::Elements(u64::from(PIXELS))).sample_size(30);
    let cosines: Vec<f64> = (0..PIXELS).map(|n| 1.0 - f64::from(n) * 1e-5).collect();
    group.bench_function("GGX D", |b| {
        b.iter(|| {
            // Walter et al. 2007, eq. 33.
            let d = |z: f64| {
                let q = z * z * (0.09 - 1.0) + 1.0;
                0.09 / (std::f64::consts::PI * q * q)
            };
            black_box(&cosines).iter().map(|z| black_box(d(*z))).sum::<f64>()
        })
    });
    let queries: Vec<_> = (0..PIXELS).map(|n| query(n, 5e-3)).collect();
    group.bench_function("query to probe", |b| {
        b.iter(|| black_box(&queries).iter().map(|q| q.probe().map_or(0.0, |p| p.n_eff())).sum::<f64>())
    });
    // Counts have a mean of some hundredths of N_eff in a box, about 0.1 for N_eff 2.
    for (name, counts) in [("field", &[0.1, 1.0, 10.0][..]), ("binomial", &[0.1, 1.0, 10.0, 100.0])] {
        let evaluator = evaluator(name).expect("of the library");
        for &n_eff in counts {
            let probes = probes(n_eff);
            group.bench_function(BenchmarkId::new(name, n_eff), |b| {
                b.iter(|| black_box(&probes).iter().map(|p| (evaluator.ratio)(p)).sum::<f64>())
            });
        }
        group.bench_function(BenchmarkId::new(name, "query to g"), |b| {
            b.iter(|| black_box(&queries).iter().map(|q| glint_ratio(evaluator, q)).sum::<f64>())
        });
    }
    group.finish();
}

criterion_group!(benches, glints);
criterion_main!(benches);
