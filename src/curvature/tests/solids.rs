//! Shapes whose answer is known.

use std::f64::consts::TAU;

use glam::DVec2;

use super::super::{BakeOptions, Baked, Mesh, bake};
use super::shapes::{Shape, cylinder, exact, plane, sphere, torus, whole};
use crate::image::Size;

fn baked(mesh: &Mesh, width: usize, height: usize) -> Baked {
    bake(mesh, Size::new(width, height), &BakeOptions::default(), &|_| ()).unwrap()
}

/// Largest difference from the exact tensor over a level, as a share of the largest eigenvalue there; every `step`-th
/// texel, away from the `rim` first and last rows.
fn worst(baked: &Baked, k: usize, shape: Shape, step: usize, rim: usize) -> f64 {
    let level = &baked.levels[k];
    let size = level.size();
    let mut worst = 0f64;
    for y in (rim..size.height - rim).step_by(step) {
        for x in (0..size.width).step_by(step) {
            let texel = DVec2::new(1.0 / size.width as f64, 1.0 / size.height as f64);
            let low = DVec2::new(x as f64, (size.height - 1 - y) as f64) * texel;
            let [xx, xy, yy] = exact(shape, low, low + texel, 8);
            let found = level.added[[y, x]];
            for (a, b) in [(found.xx, xx), (found.xy, xy), (found.yy, yy)] {
                worst = worst.max((f64::from(a) - b).abs() / (xx + yy));
            }
        }
    }
    worst
}

#[test]
fn a_plane_adds_nothing() {
    let baked = baked(&whole(plane, [7, 5]), 64, 32);
    let most = baked.levels.iter().flat_map(|level| &level.added).map(|k| k.xx.max(k.yy)).fold(0.0, f32::max);
    assert!(most < 1e-13, "{most}");
    assert!(baked.levels.iter().all(|level| level.coverage.iter().all(|c| (c - 1.0).abs() < 1e-6)));
}

#[test]
fn a_cylinder_spreads_around_and_not_along() {
    let baked = baked(&whole(cylinder, [512, 4]), 128, 64);
    for (k, level) in baked.levels.iter().enumerate() {
        let angle = TAU / level.size().width as f64;
        // Normals evenly over an arc: mean square of the sine about its middle, minus nothing.
        let around = 1.0 - angle.sin() / angle;
        for added in &level.added {
            if level.size().width == 2 {
                // Half the cylinder in a texel.
                assert!((added.xx - 1.0).abs() < 1e-4, "{added:?}");
            }
            if level.size().width > 1 {
                assert!((f64::from(added.xx) - around).abs() < 1e-4 * around, "{k}: {added:?} {around}");
                assert!(added.xy.abs() < 1e-6 * added.xx && added.yy < 1e-6 * added.xx, "{k}: {added:?}");
            } else {
                // All the way around normals cancel, and there is no tangent plane.
                assert!((added.xx - 2.0 / 3.0).abs() < 1e-4 && added.xx == added.yy, "{added:?}");
            }
        }
    }
}

#[test]
fn a_sphere_spreads_by_its_angles() {
    let baked = baked(&whole(sphere, [512, 256]), 128, 64);
    // First order: alpha^2 is twice a twelfth of the squared angle along each axis.
    let (around, up) = (TAU / 128.0, 0.5 * TAU / 64.0);
    for y in [20, 32, 45] {
        let latitude = 0.25 * TAU - (y as f64 + 0.5) * up;
        let added = baked.levels[0].added[[y, 5]];
        let [xx, yy] = [around * latitude.cos(), up].map(|angle| angle * angle / 6.0);
        assert!((f64::from(added.xx) / xx - 1.0).abs() < 1e-3, "row {y}: {added:?}, {xx}");
        assert!((f64::from(added.yy) / yy - 1.0).abs() < 1e-3, "row {y}: {added:?}, {yy}");
    }
    // A hemisphere in a texel: a third is the mean square of a coordinate over it.
    for added in &baked.levels[6].added {
        assert!((added.xx - 2.0 / 3.0).abs() < 1e-3 && (added.yy - 2.0 / 3.0).abs() < 1e-3, "{added:?}");
    }
    for k in 0..5 {
        let worst = worst(&baked, k, sphere, 5 >> k.min(2), 2 >> k);
        assert!(worst < 1e-4, "level {k}: {worst}");
    }
}

#[test]
fn a_torus_spreads_as_its_exact_normals_do() {
    let baked = baked(&whole(torus, [384, 192]), 96, 48);
    for k in 0..5 {
        let worst = worst(&baked, k, torus, 5 >> k.min(2), 0);
        assert!(worst < 1e-4, "level {k}: {worst}");
    }
}

#[test]
fn triangles_larger_than_texels_spread_as_they_are_shaded() {
    // 24 quads around, 15 degrees each: linear normals made unit differ from the circle by the angle's square.
    let baked = baked(&whole(cylinder, [24, 2]), 240, 16);
    let angle = TAU / 240.0;
    let mean = baked.levels[0].added.iter().map(|k| f64::from(k.xx)).sum::<f64>() / (240.0 * 16.0);
    assert!((mean / (angle * angle / 6.0) - 1.0).abs() < 0.02, "{mean}");
    let coarse = baked.levels[3].added.iter().map(|k| f64::from(k.xx)).sum::<f64>() / (30.0 * 2.0);
    assert!((coarse / (1.0 - (8.0 * angle).sin() / (8.0 * angle)) - 1.0).abs() < 0.01, "{coarse}");
}
