//! Sums by estimates and dice against exact ones, at a spread of 0.003.

use super::*;
use crate::glint::texels::Tails;

/// Relative differences at pixels and half vectors all over a map: mean, root mean square, largest.
fn differences(glints: &TexelGlints, width: f64, reach: f64, count: i64) -> [f64; 3] {
    let j = jacobian((width, 0.8 * width), 0.4, glints.slopes().size());
    let off: Vec<f64> = (0..count)
        .map(|k| {
            let r = |i| maps::noise(31, k, i);
            let h = half_vector(reach * (2.0 * DVec2::new(r(0), r(1)) - 1.0));
            let footprint = glints.footprint(DVec2::new(r(2), r(3)), j).unwrap();
            let exact = ask(glints, &footprint, h, Ways::BEST).0;
            let query = Query::new(&glints.slopes, &glints.pyramid, &footprint, h, Tails::Kept).unwrap();
            query.spread(3e-3).0 / exact - 1.0
        })
        .collect();
    let mean = |of: fn(f64) -> f64| off.iter().map(|d| of(*d)).sum::<f64>() / count as f64;
    [mean(|d| d), mean(|d| d * d).sqrt(), off.iter().fold(0.0, |m, d| d.abs().max(m))]
}

#[test]
fn sums_are_spread_as_said() {
    for (name, map, reach) in [
        ("bumps", maps::bumps(256, 0.2), 0.2),
        ("spikes", maps::spikes(256, 0.3), 0.3),
        ("scratches", maps::scratches(256, 0.3), 0.2),
        ("steep", maps::spikes(256, 1.0), 0.6),
    ] {
        for alpha in [0.02, 0.1, 0.3] {
            for width in [8.0, 16.0] {
                let [mean, rms, most] = differences(&glints(&map, alpha), width, reach, 24);
                println!("{name:9} {alpha:5} {width:4}: mean {mean:8.1e} rms {rms:.1e} most {most:.1e}");
                // The mean of 24 is within 3 of its own deviations of none.
                assert!(mean.abs() < 0.7 * rms.max(3e-3) && rms < 9e-3 && most < 0.03, "{name} {alpha} {width}");
            }
        }
    }
}
