use glam::{DMat2, DVec2};
use ndarray::{Array2, Array3};

use super::*;
use crate::glint::texels::{InvalidTexels, Tails};

#[test]
fn bad_normals_are_flat() {
    let mut map = maps::flat(8, DVec2::ZERO);
    let bad = [f32::NAN, f32::INFINITY, -1.0, 0.0];
    for (k, z) in bad.into_iter().enumerate() {
        map[[k, k, 2]] = z;
    }
    map[[5, 5, 0]] = f32::NAN;
    let (with, without) = (glints(&map, 0.1), glints(&maps::flat(8, DVec2::ZERO), 0.1));
    let j = jacobian((3.0, 3.0), 0.0, (8, 8));
    let h = half_vector(DVec2::new(0.05, 0.02));
    assert_eq!(with.ndf(DVec2::splat(0.7), j, h), without.ndf(DVec2::splat(0.7), j, h));
}

#[test]
fn whatever_is_asked_the_answer_is_finite() {
    let mut steep = maps::spikes(9, 3.0);
    steep[[3, 3, 2]] = 1e-30;
    let single = Array3::from_shape_vec((1, 1, 3), vec![0.1, 0.2, 0.9]).unwrap();
    let strip = maps::spikes(7, 0.3).view().split_at(ndarray::Axis(0), 1).0.to_owned();
    let nan = f64::NAN;
    let uvs = [(0.3, 0.4), (-1e9, 1e15), (1e300, -1e300), (nan, 0.0), (f64::INFINITY, 0.0), (1.0, 0.0)];
    let one = DMat2::IDENTITY;
    let scales = [0.0, 1e-320, 1e-12, 1e-3, 0.1, 2.0, 1e9, 1e300, nan, f64::INFINITY];
    let mut jacobians: Vec<DMat2> = scales.iter().map(|s| one * *s).collect();
    jacobians.push(DMat2::from_cols(DVec2::new(0.1, 0.1), DVec2::new(0.1, 0.1)));
    jacobians.push(DMat2::from_cols(DVec2::new(5.0, 0.0), DVec2::ZERO));
    let halves = [
        DVec3::Z,
        half_vector(DVec2::new(0.1, -0.2)),
        half_vector(DVec2::new(1e8, 1.0)),
        DVec3::NEG_Z,
        DVec3::X,
        DVec3::ZERO,
        DVec3::splat(nan),
        DVec3::splat(1e200),
    ];
    for map in [&steep, &single, &strip] {
        for alpha in [0.0, 0.1, 7.0, f32::NAN] {
            let glints = glints(map, alpha).with_tails(if alpha == 0.0 { Tails::Cut(nan) } else { Tails::Kept });
            for uv in uvs {
                for j in &jacobians {
                    // One of the slow ones.
                    let few = if j.x_axis.x.abs() > 1.0 { 1 } else { halves.len() };
                    for h in &halves[..few] {
                        let d = glints.ndf(uv.into(), *j, *h);
                        assert!(d.is_finite() && d >= 0.0, "{d} alpha {alpha} uv {uv:?} J {j} h {h}");
                    }
                }
            }
        }
    }
}

#[test]
fn shapes_are_checked() {
    let alpha = || AlphaSource::Constant(Alpha(0.1));
    assert_eq!(TexelGlints::new(&Array3::zeros((4, 4, 2)), alpha()).unwrap_err(), InvalidTexels::Shape(4, 4, 2));
    assert_eq!(TexelGlints::new(&Array3::zeros((0, 4, 3)), alpha()).unwrap_err(), InvalidTexels::Shape(0, 4, 3));
    let other = AlphaSource::Texels(Array2::zeros((3, 4)));
    let error = TexelGlints::new(&Array3::zeros((4, 4, 3)), other).unwrap_err();
    assert_eq!(error.to_string(), "widths of 3 rows and 4 columns do not fit normals of 4 rows and 4 columns");
}

/// Rows run down from v = 1, and slopes are those of the normal.
#[test]
fn the_map_is_the_right_way_up() {
    let mut map = maps::flat(4, DVec2::ZERO);
    let n = half_vector(DVec2::new(0.3, 0.1)).as_vec3();
    for c in 0..3 {
        map[[0, 2, c]] = n[c];
    }
    let glints = glints(&map, 0.02);
    let j = jacobian((0.05, 0.05), 0.0, (4, 4));
    let at = DVec2::new(2.5 / 4.0, 1.0 - 0.5 / 4.0);
    let (there, elsewhere) =
        (glints.ndf(at, j, n.as_dvec3()), glints.ndf(DVec2::new(at.x, 0.5 / 4.0), j, n.as_dvec3()));
    assert!(there > 100.0 * elsewhere, "{there} {elsewhere}");
    assert_eq!(glints.ndf(at + DVec2::new(3.0, -5.0), j, n.as_dvec3()), there);
}

/// What a file may hold that no map has.
#[test]
fn levels_of_no_slopes_are_refused() {
    use crate::glint::texels::LEVEL_CHANNELS;

    let levels = glints(&maps::spikes(13, 0.3), 0.05).levels();
    assert!(TexelGlints::from_levels(&levels).is_ok());
    let changed = |k: usize, channel: &str, to: f32| {
        let mut levels = levels.clone();
        let c = LEVEL_CHANNELS.iter().position(|name| *name == channel).unwrap();
        let (_, rows, columns) = levels[k].dim();
        levels[k][[c, rows - 1, columns - 1]] = to;
        TexelGlints::from_levels(&levels).map(|_| ()).unwrap_err()
    };
    for (k, size) in [13, 7, 4, 2, 1].into_iter().enumerate() {
        for (channel, to, part) in [
            ("min.x", 9.0, "least"),
            ("max.y", -9.0, "least"),
            ("mean.y", 1.0, "mean"),
            ("cov.xx", -1e-6, "negative"),
            ("cov.yy", -1e-6, "negative"),
            ("cov.xy", 1.0, "covariance"),
            ("alpha.min", 0.0, "widths"),
            ("alpha.min", -0.1, "widths"),
            ("alpha.max", 0.04, "widths"),
            ("alpha.max", 1.5, "widths"),
        ] {
            match changed(k, channel, to) {
                InvalidTexels::Block(level, place, what) => {
                    assert_eq!((level, place), (k, [size - 1; 2]));
                    assert!(what.contains(part), "{channel} {to}: {what}");
                }
                other => panic!("{channel} {to}: {other}"),
            }
        }
        assert_eq!(changed(k, "cov.xy", f32::NAN), InvalidTexels::NotFinite(k));
    }
    let mut more = levels.clone();
    more.push(levels[4].clone());
    assert_eq!(TexelGlints::from_levels(&more).unwrap_err(), InvalidTexels::LevelCount(6, 5));
    assert_eq!(TexelGlints::from_levels(&levels[..4]).unwrap_err(), InvalidTexels::LevelCount(4, 5));
}

/// Maps of all kinds pass, those of one texel with and without their one block.
#[test]
fn levels_of_maps_are_taken() {
    let single = Array3::from_shape_vec((1, 1, 3), vec![0.1, 0.2, 0.9]).unwrap();
    // Steps that vanish beside the slope, and slopes at the limit.
    let nearly = Array3::from_shape_fn((9, 6, 3), |(y, x, c)| [3.0 + 1e-6 * x as f32, 1e-20 * y as f32, 1.0][c]);
    let cliffs = Array3::from_shape_fn((6, 9, 3), |(y, x, c)| [(x % 2) as f32 * 9.0, y as f32, 1e-9][c]);
    for map in [&single, &nearly, &cliffs, &maps::flat(5, DVec2::ONE), &maps::scratches(33, 2.0)] {
        for alpha in [0.0, 0.3, 2.0] {
            let levels = glints(map, alpha).levels();
            TexelGlints::from_levels(&levels).unwrap();
            if map.dim().0 == 1 {
                TexelGlints::from_levels(&levels[..1]).unwrap();
            }
        }
    }
}

#[test]
fn a_pixel_that_is_no_pixel_gets_the_folded_lobe() {
    let glints = glints(&maps::spikes(8, 0.3), 0.1);
    let blended = |uv, j| glints.blended((uv, j), DVec3::Z, Default::default(), |h| 7.0 * h.z);
    assert_eq!(blended(DVec2::ZERO, DMat2::IDENTITY * f64::NAN), 7.0);
    assert_eq!(blended(DVec2::new(f64::INFINITY, 0.0), DMat2::IDENTITY), 7.0);
    assert!(blended(DVec2::ZERO, DMat2::IDENTITY * 0.1) != 7.0);
}
