use glam::DVec2;

use super::*;
use crate::glint::texels::{TexelWidth, Transition};

/// Mean and standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
}

/// Pixels and half vectors at random.
fn tries(count: i64) -> impl Iterator<Item = (DVec2, DVec3)> {
    (0..count).map(|k| {
        let r = |i| maps::noise(21, k, i);
        (DVec2::new(r(0), r(1)), half_vector(0.25 * (2.0 * DVec2::new(r(2), r(3)) - 1.0)))
    })
}

#[test]
fn a_pan_is_continuous() {
    for width in [1.0, 4.0] {
        let glints = glints(&maps::spikes(64, 0.3), 0.02);
        let j = jacobian((width, width), 0.3, (64, 64));
        let (mut values, mut most) = (Vec::new(), 0.0f64);
        for (uv, h) in tries(200) {
            let (a, b) = (glints.ndf(uv, j, h), glints.ndf(uv + j.x_axis / 256.0, j, h));
            values.push(a);
            most = most.max((a - b).abs());
        }
        let deviation = spread(&values).1;
        println!("width {width}: 1/256 pixel changes D by up to {:.4} of its deviation", most / deviation);
        assert!(most < 0.1 * deviation);
    }
}

#[test]
fn a_turn_is_continuous() {
    let glints = glints(&maps::spikes(64, 0.3), 0.02);
    let j = jacobian((4.0, 4.0), 0.3, (64, 64));
    let (mut values, mut most) = (Vec::new(), 0.0f64);
    for (uv, h) in tries(200) {
        let turned = (h + DVec3::X * 0.02 / 256.0).normalize();
        let (a, b) = (glints.ndf(uv, j, h), glints.ndf(uv, j, turned));
        values.push(a);
        most = most.max((a - b).abs());
    }
    let deviation = spread(&values).1;
    println!("1/256 of alpha changes D by up to {:.4} of its deviation", most / deviation);
    assert!(most < 0.03 * deviation);
}

/// GGX with the mean slope and, as LEAN has it, twice the covariance of the footprint, about the mean normal: what a
/// mip chain would hold.
fn folded(glints: &TexelGlints, alpha: f64) -> impl Fn(DVec3) -> f64 {
    let top = glints.pyramid().levels().last().unwrap().blocks()[0];
    let wide = (alpha * alpha + f64::from(top.cov[0] + top.cov[2])).sqrt();
    let n = half_vector(top.mean.as_dvec2());
    move |h| {
        let (cos2, sin2, a2) = (n.dot(h).powi(2), n.cross(h).length_squared(), wide * wide);
        a2 / (std::f64::consts::PI * (cos2 * a2 + sin2).powi(2)) / n.z
    }
}

/// No pop under zoom, and the mean over the map stays.
#[test]
fn a_zoom_through_the_transition_is_continuous() {
    let glints = glints(&maps::spikes(64, 0.3), 0.05);
    let transition = Transition { from: TexelWidth(4.0), to: TexelWidth(16.0) };
    let far = folded(&glints, 0.05);
    let all: Vec<_> = tries(30).collect();
    let at = |width: f64| -> Vec<f64> {
        let j = jacobian((width, width), 0.3, (64, 64));
        all.iter().map(|(uv, h)| glints.blended((*uv, j), *h, transition, &far)).collect()
    };
    let octaves = 4.0;
    let mut before = at(2.0);
    let deviation = spread(&before).1;
    let mut most = 0.0f64;
    for octave in [0.0, 0.99, 1.0, 1.5, 2.0, 2.5, 3.0, 3.01, octaves] {
        before.clone_from(&at(2.0 * 2f64.powf(octave)));
        let after = at(2.0 * 2f64.powf(octave + 1.0 / 256.0));
        let step = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!(
            "width {:5.2}: step {:.4}, deviation {:.3}",
            2.0 * 2f64.powf(octave),
            step / deviation,
            spread(&before).1 / deviation
        );
        most = most.max(step / deviation);
    }
    assert!(most < 0.05, "{most}");
    let exact: Vec<f64> = all.iter().map(|(_, h)| far(*h)).collect();
    assert_eq!(at(16.0), exact);
}

/// Largest change of D over a zoom by an octave's 64th, in the larger of D and the mean D: of the exact sums and of those
/// by estimates, with the folded lobe coming in. What estimates add is within a few of their spreads.
#[test]
fn no_step_of_a_zoom_is_larger_than_the_map_makes_it() {
    let transition = Transition { from: TexelWidth(4.0), to: TexelWidth(16.0) };
    for (name, map, alpha) in [("spikes", maps::spikes(64, 0.3), 0.05f32), ("scratches", maps::scratches(64, 0.3), 0.1)]
    {
        let glints = glints(&map, alpha);
        let far = folded(&glints, f64::from(alpha));
        let all: Vec<_> = tries(2).collect();
        let (mut most, mut last) = ([0.0f64; 2], Vec::<[f64; 2]>::new());
        for step in 0..=3 * 64 {
            let width = 2.5 * 2f64.powf(f64::from(step) / 64.0);
            let j = jacobian((width, width), 0.3, (64, 64));
            let now: Vec<[f64; 2]> = all
                .iter()
                .map(|(uv, h)| {
                    let footprint = glints.footprint(*uv, j).unwrap();
                    let share = transition.folded_share(footprint.width());
                    let exact = if share < 1.0 { ask(&glints, &footprint, *h, Ways::BEST).0 } else { 0.0 };
                    [(1.0 - share) * exact + share * far(*h), glints.blended((*uv, j), *h, transition, &far)]
                })
                .collect();
            let mean = now.iter().map(|d| d[0]).sum::<f64>() / now.len() as f64;
            for (now, last) in now.iter().zip(&last) {
                for k in 0..2 {
                    most[k] = most[k].max((now[k] - last[k]).abs() / now[k].max(mean));
                }
            }
            last = now;
        }
        println!("{name}: largest change over 2^(1/64): exact {:.4}, by estimates {:.4}", most[0], most[1]);
        assert!(most[1] < most[0] + 0.02, "{name} {most:?}");
    }
}

#[test]
fn shares_run_from_nothing_to_all() {
    let t = Transition::default();
    let share = |w: f64| t.folded_share(TexelWidth(w));
    assert_eq!([share(0.0), share(16.0), share(32.0), share(64.0), share(1e9)], [0.0, 0.0, 0.5, 1.0, 1.0]);
    for k in 0..600 {
        assert!(share(8.0 * 1.01f64.powi(k)) <= share(8.0 * 1.01f64.powi(k + 1)));
    }
    let step = Transition { from: TexelWidth(8.0), to: TexelWidth(8.0) };
    assert_eq!([7.9, 8.0].map(|w| step.folded_share(TexelWidth(w))), [0.0, 1.0]);
    assert!(step.folded_share(TexelWidth(f64::NAN)).is_finite());
}
