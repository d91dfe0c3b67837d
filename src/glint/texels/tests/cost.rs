//! What ways of asking cost, and what they are off by: a table, printed on request.

use glam::{DMat2, DVec2};

use super::brute::Brute;
use super::*;
use crate::glint::texels::Tails;

/// Time that this thread has run for, in nanoseconds: what else runs on the machine does not count. Linux has it.
fn run_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    stat.split(' ').next().and_then(|ns| ns.parse().ok()).unwrap_or(f64::NAN)
}

/// Its result, and nanoseconds for each of `count` parts, over enough calls for a clock that ticks slowly.
fn timed<T>(count: usize, mut f: impl FnMut() -> T) -> (T, f64) {
    let (start, mut calls) = (run_time(), 0);
    loop {
        let result = f();
        calls += 1;
        let took = run_time() - start;
        if took > 5e7 || calls == 10_000 {
            return (result, took / (calls * count) as f64);
        }
    }
}

/// One Gaussian a texel in position and slope (Yan et al. 2016): half a maximum's width of a texel in position, the
/// slopes' own change across it, and the material's lobe as a Gaussian of variance `alpha^2 / 2`.
fn gaussians(glints: &TexelGlints, footprint: &Footprint, h: DVec3, alpha: f64) -> f64 {
    let position = 1.0 / (8.0 * 2f64.ln());
    // That of the kernel, from its own box and corners: variances are squared radii over 8.
    let (centre, half) = footprint.bounds();
    let form = footprint.unit.transpose() * footprint.unit;
    let kernel = form.inverse() * 0.125;
    let seen = (kernel + DMat2::IDENTITY * position).inverse();
    let s_h = -h.truncate() / h.z;
    let density = |d: DVec2, inverse: DMat2| {
        inverse.determinant().sqrt() / std::f64::consts::TAU * (-0.5 * d.dot(inverse * d)).exp()
    };
    let (first, last) = ((centre - 1.2 * half - 1.0).floor(), (centre + 1.2 * half + 1.0).ceil());
    let mut sum = 0.0;
    for y in first.y as i64..=last.y as i64 {
        for x in first.x as i64..=last.x as i64 {
            let at = DVec2::new(x as f64, y as f64);
            let weight = density(centre - at, seen);
            let slope = |x: f64, y: f64| glints.slopes().at(at + DVec2::new(x, y)).0;
            let change = DMat2::from_cols(
                0.5 * (slope(1.0, 0.0) - slope(-1.0, 0.0)),
                0.5 * (slope(0.0, 1.0) - slope(0.0, -1.0)),
            );
            let shift = position * (seen * (centre - at));
            let left = DMat2::IDENTITY * position - seen * (position * position);
            let cov = change * left * change.transpose() + DMat2::IDENTITY * (0.5 * alpha * alpha);
            sum += weight * density(s_h - slope(0.0, 0.0) - change * shift, cov.inverse());
        }
    }
    sum / h.z.powi(4)
}

/// Ways to sum against the exact sum: errors and costs.
#[test]
#[ignore = "a table of costs, a minute alone on a machine"]
fn chances_compared() {
    for (name, map, reach) in [
        ("bumps", maps::bumps(128, 0.2), 0.3),
        ("spikes", maps::spikes(128, 0.3), 0.3),
        ("scratches", maps::scratches(128, 0.3), 0.3),
        ("steep", maps::spikes(128, 1.5), 1.5),
    ] {
        for alpha in [0.005f32, 0.02, 0.1, 0.3] {
            for width in [16.0, 64.0] {
                let glints = glints(&map, alpha);
                let j = jacobian((width, width), 0.4, (128, 128));
                let footprint = glints.footprint(DVec2::new(0.37, 0.58), j).unwrap();
                let half: Vec<DVec3> = (0..6)
                    .map(|k| half_vector(reach * (2.0 * DVec2::new(maps::noise(3, k, 0), maps::noise(4, k, 0)) - 1.0)))
                    .collect();
                let n = half.len();
                let query =
                    |h: &DVec3| Query::new(&glints.slopes, &glints.pyramid, &footprint, *h, Tails::Kept).unwrap();
                let (truth, full) = timed(n, || half.iter().map(|h| query(h).sum()).collect::<Vec<_>>());
                let (all, ns) = timed(n, || half.iter().map(|h| query(h).evaluate()).collect::<Vec<_>>());
                let (d, visits): (Vec<f64>, Vec<Visits>) = all.into_iter().unzip();
                let mean = |of: fn(&Visits) -> usize| visits.iter().map(of).sum::<usize>() / n;
                let off = d.iter().zip(&truth).map(|(d, t)| (d - t).abs()).sum::<f64>() / truth.iter().sum::<f64>();
                let rel = (d.iter().zip(&truth).map(|(d, t)| (d / t - 1.0).powi(2)).sum::<f64>() / n as f64).sqrt();
                let most = d.iter().zip(&truth).map(|(d, t)| (d / t - 1.0).abs()).fold(0.0, f64::max);
                println!(
                    "{name:9} {alpha:5} {width:4} L1 {off:.1e} rms {rel:.1e} most {most:.1e} {:6.0} us from {:6.0}: {} blocks, \
                     {} texels, {} closed, {} points",
                    ns * 1e-3,
                    full * 1e-3,
                    mean(|v| v.nodes),
                    mean(|v| v.texels),
                    mean(|v| v.closed),
                    mean(|v| v.points)
                );
            }
        }
    }
}

#[test]
#[ignore = "a table of costs, a minute alone on a machine"]
fn ways_compared() {
    let ways = [
        ("closed form", Ways::BEST, Tails::Kept),
        ("quadrature", Ways { closed: false, ..Ways::BEST }, Tails::Kept),
        ("cut at 12", Ways::BEST, Tails::Cut(12.0)),
    ];
    for (name, map) in
        [("bumps", maps::bumps(128, 0.2)), ("spikes", maps::spikes(128, 0.3)), ("scratches", maps::scratches(128, 0.3))]
    {
        for alpha in [0.005f32, 0.02, 0.1] {
            for width in [1.0, 4.0, 16.0, 64.0] {
                let glints = glints(&map, alpha);
                let j = jacobian((width, width), 0.4, (128, 128));
                let footprint = glints.footprint(DVec2::new(0.37, 0.58), j).unwrap();
                let per_texel = (0.9 / f64::from(alpha)).clamp(6.0, (600.0 / width).max(6.0)) as usize;
                let brute = Brute::with(&glints, &footprint, per_texel, |map, x| map.slopes().at(x));
                let half: Vec<DVec3> = (0..12)
                    .map(|k| half_vector(0.3 * (2.0 * DVec2::new(maps::noise(3, k, 0), maps::noise(4, k, 0)) - 1.0)))
                    .collect();
                let n = half.len();
                let (truth, ns) = timed(n, || half.iter().map(|h| brute.ndf_alone(*h)).collect::<Vec<_>>());
                println!("{name} alpha {alpha} width {width}: brute force {} samples, {ns:.0} ns", brute.len());
                let off = |d: &[f64]| {
                    let off: f64 = d.iter().zip(&truth).map(|(d, t)| (d - t).abs()).sum();
                    off / truth.iter().sum::<f64>()
                };
                for (way, ways, tails) in ways {
                    let glints = glints.clone().with_tails(tails);
                    let (all, ns) =
                        timed(n, || half.iter().map(|h| ask(&glints, &footprint, *h, ways)).collect::<Vec<_>>());
                    let (d, visits): (Vec<f64>, Vec<Visits>) = all.into_iter().unzip();
                    let mean = |of: fn(&Visits) -> usize| visits.iter().map(of).sum::<usize>() / n;
                    println!(
                        "  {way:12} L1 {:.1e} {ns:8.0} ns: {} blocks, {} texels, {} closed, {} points",
                        off(&d),
                        mean(|v| v.nodes),
                        mean(|v| v.texels),
                        mean(|v| v.closed),
                        mean(|v| v.points)
                    );
                }
                let (d, ns) = timed(n, || {
                    half.iter().map(|h| gaussians(&glints, &footprint, *h, f64::from(alpha))).collect::<Vec<_>>()
                });
                println!("  {:12} L1 {:.1e} {ns:8.0} ns", "Gaussians", off(&d));
            }
        }
    }
}
