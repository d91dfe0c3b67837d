//! Equality with enumerations that know nothing of lookups, and statistics of flakes that know nothing of nets.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Case, moments};
use crate::glint::brute::{Cone, Parallelogram, Scatter, probability, solid_angle};
use crate::glint::field::{Weights, best_level, even_variance, layer, ratio, sum_at_level};
use crate::glint::net::Net;
use crate::glint::{BIWEIGHT_AREA, DEPTH, Macro, Probe, evaluator, gather};
use crate::roughness::Alpha;

/// The sum as it is defined, over a square of cells around the pixel: no rows, no blocks, no boxes.
fn enumerated(p: &Probe) -> f64 {
    let net = Net::new(p.seed, 0);
    let weights = Weights::new(1.0 + p.variation2 - even_variance(p.n_eff(), p.kernel.anisotropy()));
    let reach = p.kernel.xx.max(p.kernel.yy).sqrt().ceil() as i64 + 1;
    let home = [p.at.x.floor() as i64, p.at.y.floor() as i64];
    let inverse = glam::DMat2::from_cols_array(&[p.kernel.xx, p.kernel.xy, p.kernel.xy, p.kernel.yy]).inverse();
    let height = |area: f64| 5.0 / (3.0 * area);
    let mut sum = 0.0;
    for i in home[0] - reach..=home[0] + reach {
        for j in home[1] - reach..=home[1] + reach {
            let flake = net.flake([i as i32, j as i32]);
            let d = DVec2::new(i as f64 - p.at.x + flake.place.x, j as f64 - p.at.y + flake.place.y);
            let w = (1.0 - d.dot(inverse * d)).max(0.0).powi(2) * height(p.kernel.area());
            let a = (flake.y - p.y).abs();
            let a = a.min(1.0 - a);
            let k = (1.0 - a.length_squared() * BIWEIGHT_AREA / p.area).max(0.0).powi(2) * height(p.area);
            sum += w * k * weights.of(flake.mark);
        }
    }
    sum
}

fn random_case(n: u32) -> Case {
    let u = |k: u32| crate::glint::unit(crate::glint::pcg4d([n, k, 8, 8])[0]);
    let n_eff = 10f64.powf(-2.0 + 2.1 * u(0));
    let area = (10f64.powf(-3.5 + 3.0 * u(1))).max(n_eff / 3000.0).min(0.43);
    Case { n_eff, area, anisotropy: 32f64.powf(u(2)), angle: 6.3 * u(3) }
}

/// All levels, the fast path, the reference, gathered flakes and the definition, to 1e-12 of the largest part.
#[test]
fn field_is_the_sum_over_its_flakes() {
    let worst = (0..300u32)
        .into_par_iter()
        .map(|n| {
            let mut p = random_case(n).probe(n, 3);
            p.variation2 = f64::from(n % 3) * 0.5;
            // Differences of places of a million cells lose six digits in the definition, so stay near.
            p.at = (p.at * 1e-4).fract() * 900.0;
            let truth = enumerated(&p);
            let mut found = vec![evaluator("reference").unwrap()];
            if p.n_eff() <= 1.5 {
                found.push(evaluator("field").unwrap());
            }
            let mut values: Vec<f64> = found.iter().map(|e| (e.ratio)(&p)).collect();
            let best = best_level(p.kernel, p.radius());
            for k in best.saturating_sub(2)..=(best + 2).min(DEPTH) {
                values.push(sum_at_level(&p, k));
            }
            if p.kernel.area() < 400.0 {
                values.extend([sum_at_level(&p, 0), sum_at_level(&p, DEPTH.min(best + 3))]);
            }
            values.push(gather(&p, 1 << 20).unwrap().ratio(p.y, p.area));
            values.iter().map(|v| (v - truth).abs() / truth.max(1.0)).fold(0.0, f64::max)
        })
        .reduce(|| 0.0, f64::max);
    eprintln!("largest difference {worst:e}");
    assert!(worst < 1e-12, "{worst}");
}

/// The same in two other ways: the flakes of all boxes of a level are all flakes in the footprint, once.
#[test]
fn all_boxes_together_hold_all_flakes_once() {
    for n in 0..60 {
        let case = Case { n_eff: 0.5, area: 0.002, anisotropy: 1.0 + f64::from(n % 5), angle: f64::from(n) };
        let p = case.probe(n, 6);
        let gathered = gather(&p, 1 << 20).unwrap();
        let net = Net::new(p.seed, 0);
        for k in [1, 3] {
            let mut cells = Vec::new();
            p.kernel.rows(p.at, f64::from(1u32 << k), |j, first, last| {
                for i in first..=last {
                    for box_index in 0..1u32 << (2 * k) {
                        let digits = [box_index & ((1 << k) - 1), box_index >> k];
                        cells.push(net.cell(k, [i as i32, j as i32], digits));
                    }
                }
            });
            cells.sort_unstable();
            assert!(cells.windows(2).all(|w| w[0] != w[1]));
            assert!(gathered.flakes.iter().all(|f| cells.binary_search(&f.cell).is_ok()));
        }
    }
}

#[test]
fn flakes_are_sampled_in_proportion_to_their_weight() {
    let p = Case::round(0.3, 0.02).probe(4, 4);
    let gathered = gather(&p, 1000).unwrap();
    let mut drawn = std::collections::BTreeMap::new();
    let draws = 40_000;
    for i in 0..draws {
        let (flake, chance) = gathered.sample((f64::from(i) + 0.5) / f64::from(draws)).unwrap();
        drawn.entry(flake.cell).or_insert((0, chance)).0 += 1;
    }
    assert!(drawn.len() > 5);
    for (count, chance) in drawn.values() {
        assert!((f64::from(*count) / f64::from(draws) - chance).abs() <= 1.0 / f64::from(draws) + 1e-12);
    }
    assert!(gather(&p, 2).is_none());
}

/// Independent flakes in sheared pixels and cones: mean and variance of their number are those of a Poisson count with
/// the chance from quadrature, within 4 and 5 standard errors.
fn scattered(count: usize, queries: u32) {
    let lobe = Macro::isotropic(Alpha(0.3));
    let scatter = Scatter::new(count, &lobe, 7).unwrap();
    for (n, (theta, degrees)) in [(0.0f64, 4.0f64), (30.0, 6.0), (45.0, 2.0), (60.0, 6.0)].into_iter().enumerate() {
        let (sin, cos) = theta.to_radians().sin_cos();
        let cone = Cone { axis: DVec3::new(0.6 * sin, 0.8 * sin, cos), half_angle: degrees.to_radians() };
        let chance = probability(&lobe, cone).unwrap();
        // Eight times as long as wide, sheared, with two answers on average.
        let area = 2.0 / (count as f64 * chance);
        let width = (area / 8.0).sqrt();
        let edges = [DVec2::new(8.0 * width, 2.0 * width), DVec2::new(0.3 * width, width * (1.0 + 0.6 / 8.0))];
        let area = edges[0].perp_dot(edges[1]).abs();
        let expected = count as f64 * area * chance;
        let m = moments(queries, |q| {
            let h = crate::glint::pcg4d([q, n as u32, 5, 5]);
            let centre = DVec2::new(crate::glint::unit(h[0]), crate::glint::unit(h[1]));
            scatter.count(Parallelogram { centre, edges }, cone) as f64 / expected
        });
        let centre = lobe.chart().unwrap().density(cone.axis) * solid_angle(cone) / chance;
        eprintln!(
            "{theta} degrees, cone {degrees}: mean {:.3} +- {:.3}, variance {:.3} +- {:.3}; D cos at the middle {centre:.3}",
            m.mean,
            m.mean_error,
            m.variance * expected,
            m.variance_error * expected
        );
        // Queries share flakes, as places of pixels overlap: all flakes in cones bound the information.
        let shared = (1.0 + f64::from(queries) * 2.0 / (count as f64 * chance)).sqrt();
        assert!((m.mean - 1.0).abs() < 4.0 * m.mean_error * shared, "{theta}: mean {m:?}");
        assert!((m.variance * expected - 1.0).abs() < 5.0 * m.variance_error * expected * shared, "{theta}: {m:?}");
    }
}

#[test]
fn independent_flakes_are_poisson() {
    scattered(300_000, 2000);
}

#[test]
#[ignore = "six million flakes"]
fn independent_flakes_are_poisson_at_length() {
    scattered(6_000_000, 6000);
}

/// The kernels' sum over scattered flakes, normals and all, has the field's mean and variance: the chart, solid angles and
/// effective areas together.
#[test]
fn effective_areas_are_those_of_scattered_flakes() {
    for n_eff in [0.3, 3.0] {
        let m = moments(40_000, |n| crate::glint::brute::independent_ratio(n_eff, n, 9));
        assert!((m.mean - 1.0).abs() < 4.0 * m.mean_error, "{m:?}");
        assert!((m.variance * n_eff - 1.0).abs() < 5.0 * m.variance_error * n_eff, "{m:?}");
        let p = Case::round(n_eff, 0.01).probe(1, 1);
        assert!((p.n_eff() / n_eff - 1.0).abs() < 1e-12);
        assert!(ratio(&p) >= 0.0 && layer(&p, 0, 0.0) >= 0.0);
    }
}
