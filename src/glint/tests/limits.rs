//! Queries as users ask them: any lobe and angle, any size, and what makes no sense.

use glam::{DMat2, DVec2, DVec3};

use super::moments;
use crate::glint::{
    EVALUATORS, FlakeDensity, Flakes, Light, Macro, Query, SolidAngle, Streak, Tail, evaluator, glint_ratio, pcg4d,
    unit,
};
use crate::ndf::RoughnessTensor;
use crate::roughness::Alpha;

/// A pixel of some hundred flakes; `n` moves it about, within one material.
fn query(n: u32) -> Query {
    let h = pcg4d([n, 3, 3, 1]);
    Query {
        uv: DVec2::new(unit(h[0]), unit(h[1])) * 40.0 - 20.0,
        jacobian: DMat2::from_cols(DVec2::new(8e-3, 2e-3), DVec2::new(-1e-3, 4e-3)),
        h: DVec3::new(0.1, -0.15, 1.0).normalize(),
        lobe: Macro::isotropic(Alpha(0.3)),
        flakes: Flakes::new(FlakeDensity(4e6), SolidAngle(2e-3), n % 16),
        light: Light::new(SolidAngle(1e-3), 0.7),
    }
}

/// Half vectors of 0 to 75 degrees, all lobes: the mean is 1 within 5 standard errors.
#[test]
fn mean_is_one_for_any_lobe_and_angle() {
    let sheared = RoughnessTensor { xx: 0.2, xy: 0.05, yy: 0.02 };
    for (case, tail) in [Tail::Ggx, Tail::Beckmann].into_iter().enumerate() {
        for lobe in [
            Macro { tail, ..Macro::isotropic(Alpha(0.4)) },
            Macro { mean: DVec2::new(0.3, -0.1), roughness: sheared, tail },
        ] {
            for (step, theta) in [0.0f64, 25.0, 50.0, 75.0].into_iter().enumerate() {
                let (sin, cos) = theta.to_radians().sin_cos();
                // Beckmann lobes have no flakes left far out.
                if lobe.chart().unwrap().density(DVec3::new(sin, 0.0, cos)) < 1e-5 {
                    assert_eq!(tail, Tail::Beckmann);
                    continue;
                }
                for evaluator in &EVALUATORS[..2] {
                    let m = moments(1500, |n| {
                        let mut q = query(n + 10_000 * (2 * step + case) as u32);
                        let phi = 0.4 * unit(pcg4d([n, 1, 1, 2])[0]) - 0.2;
                        q.h = DVec3::new(sin * phi.cos(), sin * phi.sin(), cos);
                        // As many flakes wherever the lobe is dim, where it can be.
                        q.jacobian *= (0.1 / lobe.chart().unwrap().density(q.h)).clamp(0.5, 100.0).sqrt();
                        q.lobe = lobe;
                        glint_ratio(evaluator, &q)
                    });
                    assert!(
                        (m.mean - 1.0).abs() < 5.0 * m.mean_error + 1e-3,
                        "{} at {theta}, {lobe:?}: {} +- {}",
                        evaluator.name,
                        m.mean,
                        m.mean_error
                    );
                }
            }
        }
    }
}

/// With more and more flakes the ratio tends to 1 as one over the root of their number.
#[test]
fn many_flakes_are_smooth() {
    for evaluator in &EVALUATORS[..2] {
        for alpha in [0.1, 0.3, 0.6] {
            let mut points = Vec::new();
            for octave in 0..4 {
                let change = |n: u32| {
                    let mut q = query(n);
                    q.lobe = Macro::isotropic(Alpha(alpha));
                    q.h = DVec3::new(0.5 * f64::from(alpha), 0.0, 1.0).normalize();
                    q.flakes.density.0 *= 4f64.powi(octave);
                    q
                };
                let m = moments(3000, |n| glint_ratio(evaluator, &change(n)));
                points.push((change(0).probe().unwrap().n_eff().ln(), 0.5 * m.variance.ln()));
            }
            let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
            let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
            let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x));
            eprintln!("{}, alpha {alpha}: slope {slope:.3} from N_eff {:.1}", evaluator.name, points[0].0.exp());
            assert!((slope + 0.5).abs() < 0.03, "{}, alpha {alpha}: {slope}", evaluator.name);
        }
    }
}

/// A flake shines the same in total wherever its normal is, though the lobe around it is measured by the density at the
/// half vector: the integral of its share over all half vectors is 1, with a deviation below 0.03 for lobes of a
/// thousandth of a steradian.
#[test]
fn flakes_have_the_same_energy_in_any_direction() {
    let lobe = Macro::isotropic(Alpha(0.3));
    let chart = lobe.chart().unwrap();
    let area = |y: DVec2| chart.density(chart.normal(y)) * 1e-3;
    let m = moments(300, |n| {
        let h = pcg4d([n, 8, 1, 3]);
        let y = DVec2::new(unit(h[0]), unit(h[1])) * 0.96 + 0.02;
        let reach = 1.5 * (area(y) / crate::glint::BIWEIGHT_AREA).sqrt();
        let mut sum = 0.0;
        for i in -40..40 {
            for j in -40..40 {
                let d = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * (reach / 40.0);
                let a = area((y + d).clamp(DVec2::splat(1e-9), DVec2::splat(1.0 - 1e-9)));
                let rest = (1.0 - d.length_squared() * crate::glint::BIWEIGHT_AREA / a).max(0.0);
                sum += 5.0 / (3.0 * a) * rest * rest * (reach / 40.0).powi(2);
            }
        }
        sum
    });
    eprintln!("energy of flakes: {:.4}, deviation {:.4}", m.mean, m.variance.sqrt());
    assert!((m.mean - 1.0).abs() < 0.005 && m.variance.sqrt() < 0.03, "{m:?}");
}

/// Scratches: the mean is 1, and pixels along a scratch are more alike than pixels across.
#[test]
fn scratches_run_along_their_direction() {
    for evaluator in &EVALUATORS[..2] {
        let streaked = |n: u32| {
            let mut q = query(n);
            q.flakes.streak = Some(Streak { ratio: 16.0, angle: 0.5 });
            q.jacobian = DMat2::from_diagonal(DVec2::splat(2e-4));
            q
        };
        let m = moments(8000, |n| glint_ratio(evaluator, &streaked(n)));
        assert!((m.mean - 1.0).abs() < 5.0 * m.mean_error, "{}: {m:?}", evaluator.name);
        let alike = |angle: f64| {
            let pairs: Vec<_> = (0..8000)
                .map(|n| {
                    let mut q = streaked(n);
                    let here = glint_ratio(evaluator, &q);
                    q.uv += DVec2::from_angle(angle) * 5e-4;
                    (here, glint_ratio(evaluator, &q))
                })
                .collect();
            super::correlation(&pairs)
        };
        let (along, across) = (alike(0.5), alike(0.5 + std::f64::consts::FRAC_PI_2));
        eprintln!("{}: correlation along {along:.3}, across {across:.3}", evaluator.name);
        assert!(along > across + 0.4, "{}: {along} and {across}", evaluator.name);
    }
}

/// A footprint that is turned with the surface sees the same statistics.
#[test]
fn turned_footprints_have_the_same_statistics() {
    for evaluator in &EVALUATORS[..2] {
        for angle in [0.0, 0.4, 0.785, 1.3] {
            let m = moments(20_000, |n| {
                let mut q = query(n);
                let shear = DMat2::from_cols(DVec2::new(4e-3, 0.0), DVec2::new(1e-3, 5e-4));
                q.jacobian = DMat2::from_angle(angle) * shear;
                glint_ratio(evaluator, &q)
            });
            let mut q = query(0);
            q.jacobian = DMat2::from_cols(DVec2::new(4e-3, 0.0), DVec2::new(1e-3, 5e-4));
            let v = m.variance * q.probe().unwrap().n_eff();
            eprintln!("{}, turned by {angle}: mean {:.3} +- {:.3}, V* {v:.3}", evaluator.name, m.mean, m.mean_error);
            assert!((m.mean - 1.0).abs() < 0.01 + 4.0 * m.mean_error, "{}, {angle}: {m:?}", evaluator.name);
            assert!((v - 1.0).abs() < 0.1, "{}, {angle}: V* {v}", evaluator.name);
        }
    }
}

#[test]
fn whatever_is_asked_the_answer_is_a_ratio() {
    let odd =
        [0.0, -0.0, 1e-300, -1e-12, 1.0, -3.7, 65_536.5, 1e9, -1e17, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let mut asked = 0;
    for evaluator in EVALUATORS {
        for v in odd {
            let changes: [fn(&mut Query, f64); 14] = [
                |q, v| q.uv.x = v,
                |q, v| q.jacobian.x_axis.y = v,
                |q, v| q.jacobian = DMat2::from_cols(DVec2::splat(v), DVec2::splat(v)),
                |q, v| q.jacobian = DMat2::from_diagonal(DVec2::splat(v)),
                |q, v| q.h = DVec3::new(v, 0.0, 1.0),
                |q, v| q.h.z = v,
                |q, v| q.lobe.mean.x = v,
                |q, v| q.lobe.roughness = RoughnessTensor::isotropic(Alpha(v as f32)),
                |q, v| q.flakes.density.0 = v,
                |q, v| q.flakes.lobe.0 = v,
                |q, v| q.flakes.size_variation = v,
                |q, v| q.flakes.coverage = v,
                |q, v| q.light.solid_angle.0 = v,
                |q, v| q.light.half_vector_per_pixel[0].x = v,
            ];
            for (n, change) in changes.iter().enumerate() {
                let mut q = query(1);
                q.flakes.density.0 = 1e5;
                change(&mut q, v);
                let g = glint_ratio(evaluator, &q);
                assert!(g.is_finite() && g >= 0.0, "{}, change {n} to {v}: {g}", evaluator.name);
                asked += 1;
            }
        }
    }
    assert_eq!(asked, 3 * 13 * 14);
}

/// Close-ups, no Jacobian at all, far-away places: the mean stays 1.
#[test]
fn mean_is_one_at_the_limits() {
    type Change = fn(&mut Query);
    let changes: [(&str, Change); 4] = [
        ("a point", |q| q.jacobian = DMat2::ZERO),
        ("a line", |q| q.jacobian = DMat2::from_cols(DVec2::new(3e-3, 2e-3), DVec2::ZERO)),
        ("few flakes", |q| q.flakes.density.0 = 1e3),
        ("far away", |q| q.uv *= 1e6),
    ];
    for (what, change) in changes {
        for evaluator in &EVALUATORS[..2] {
            let m = moments(20_000, |n| {
                let mut q = query(n);
                // Wide lights, so that some flakes answer; places of any density.
                q.light = Light::new(SolidAngle(0.3), 0.7);
                q.uv *= 100.0;
                change(&mut q);
                glint_ratio(evaluator, &q)
            });
            eprintln!("{}, {what}: mean {:.3} +- {:.3}", evaluator.name, m.mean, m.mean_error);
            assert!((m.mean - 1.0).abs() < 5.0 * m.mean_error, "{}, {what}: {m:?}", evaluator.name);
        }
    }
}

#[test]
fn evaluators_are_found_by_name() {
    for e in EVALUATORS {
        assert_eq!(evaluator(e.name).unwrap().name, e.name);
    }
    assert!(evaluator("none").is_none());
}
