//! Folds that search: what they are near to.

use super::*;
use crate::ndf::disk;
use crate::random::Random;

/// Level 0 of smooth texels whose normals were drawn from a lobe.
fn drawn(lobe: &Lobe, side: usize) -> Grid {
    let mut random = Random::new(5, 1);
    let SlopeLobe { centre, scatter: p } = SlopeLobe::new(lobe);
    let l11 = p.xx.sqrt();
    let l21 = p.xy / l11;
    let l22 = (p.yy - l21 * l21).sqrt();
    let texels = (0..side * side).map(|i| {
        // Stratified squared radii `u / (1 - u)`, in any order.
        let u = ((i as f64 + random.uniform()) / (side * side) as f64) as f32;
        let (radius, (sin, cos)) =
            ((u / (1.0 - u)).sqrt(), (random.uniform() as f32 * std::f32::consts::TAU).sin_cos());
        let slope = glam::Vec2::new(l11 * cos, l21 * cos + l22 * sin) * radius + centre;
        (Vec3::new(-slope.x, -slope.y, 1.0).normalize(), 0.05, 1.0)
    });
    let mut texels: Vec<_> = texels.collect();
    for i in (1..texels.len()).rev() {
        texels.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
    Grid { size: Size::new(side, side), texels, tensor: None }
}

#[test]
fn texels_drawn_from_a_lobe_give_it_back_roughly() {
    let lobes = [(0.0, 0.1, 0.1), (0.0, 0.3, 0.1), (0.3, 0.2, 0.1), (0.3, 0.15, 0.15)];
    for (fold, form) in all().filter(|(fold, _)| fold.has_mixtures()) {
        for (tilt, alpha_x, alpha_y) in lobes.into_iter().filter(|l| form == Form::Anisotropic || l.1 == l.2) {
            let axes = Axes { alpha_x: Alpha(alpha_x), alpha_y: Alpha(alpha_y), angle: 0.5 };
            let normal = Vec3::new(tilt, 0.5 * tilt, 1.0).normalize();
            let lobe = Lobe { normal, roughness: RoughnessTensor::from_axes(axes) };
            let grid = drawn(&lobe, 64);
            let texels: Vec<_> = grid.texels.iter().map(|&(n, r, _)| texel(n, r)).collect();
            let top = chain(&grid, &Options { fold, form, ..Options::default() }).levels.pop().unwrap();
            // Robustness takes width away, and the merging of what lies far out adds more.
            let bounds = [(fold.lobe(&texels, form), 0.85..1.15), (top.lobes.at(0, 0), 0.9..1.25)];
            for (found, bounds) in bounds {
                let off = (found.normal - normal).length() / alpha_x;
                let widths = [found.axes().alpha_x.0 / alpha_x, found.axes().alpha_y.0 / alpha_y];
                assert!(off < 0.1, "{} {form:?}, {alpha_x}: off by {off} widths", fold.name);
                assert!(widths.iter().all(|w| bounds.contains(w)), "{} {form:?}, {alpha_x}: {widths:?}", fold.name);
            }
        }
    }
}

/// Bumps whose height swells along the rows; and tiles with steep edges and rough grout, of a period that no footprint has.
fn varied() -> [Grid; 2] {
    let size = Size::new(128, 128);
    let bumps = |x: f32, y: f32| {
        let height = 0.2 * (std::f32::consts::PI * x / 128.0).sin();
        (Vec3::new(height * (2.1 * x + 0.7 * y).sin(), height * (1.3 * x - 1.9 * y).sin(), 1.0).normalize(), 0.4, 1.0)
    };
    let tiles = |x: f32, y: f32| {
        let edge = |v: f32| match v % 11.0 {
            0.0 => -0.6,
            10.0 => 0.6,
            _ => 0.0,
        };
        let grout = x % 11.0 == 0.0 && y % 11.0 < 4.0;
        (Vec3::new(edge(x), edge(y), 1.0).normalize(), if grout { 0.8 } else { 0.3 }, 1.0)
    };
    let grid = |texel: &dyn Fn(f32, f32) -> (Vec3, f32, f32)| {
        let texels = (0..size.texels()).map(|i| texel((i % 128) as f32, (i / 128) as f32)).collect();
        Grid { size, texels, tensor: None }
    };
    [grid(&bumps), grid(&tiles)]
}

/// From texel to texel and from level to level, against how much the exact NDF of the footprints changes.
#[test]
fn what_varies_little_is_folded_to_what_varies_little() {
    for grid in &varied() {
        // 8x8 texels of level 4, and their parents.
        let changes = |at: &dyn Fn(usize, usize, usize) -> Vec<f64>| {
            let fine: Vec<_> = (0..64).map(|i| at(4, i % 8, i / 8)).collect();
            let coarse: Vec<_> = (0..16).map(|i| at(5, i % 4, i / 4)).collect();
            let rows = (0..64).filter(|i| i % 8 > 0).map(|i| disk::apart(&fine[i], &fine[i - 1])).sum::<f64>() / 56.0;
            let parent = |i: usize| &coarse[i / 16 * 4 + i % 8 / 2];
            [rows, (0..64).map(|i| disk::apart(&fine[i], parent(i))).sum::<f64>() / 64.0]
        };
        let truth = changes(&|k, x, y| disk::ndf(super::levels::footprint_of(grid, k, x, y).0.into_iter()));
        for (fold, form) in all().filter(|(fold, _)| fold.has_mixtures()) {
            for lobes in 1..=4 {
                let levels = chain(grid, &Options { fold, form, lobes, ..Options::default() }).levels;
                let own = changes(&|k, x, y| disk::ndf(levels[k - 1].lobes.mixture(x, y)));
                // One lobe varies less than the truth. How several share what is alike in many directions is left to
                // chance, and changes with little.
                let bound = if lobes == 1 { 1.0 } else { 1.9 };
                let held = own.iter().zip(truth).all(|(own, truth)| *own < bound * truth);
                assert!(held, "{} {form:?}, {lobes} lobes: {own:?} of {truth:?}", fold.name);
            }
        }
    }
}

/// Bumps alike on all sides, but for a step of 8 bits: no footprint of whole bumps may take a side for the whole, whatever the
/// phase of its roughness.
#[test]
fn bumps_alike_on_all_sides_stay_upright() {
    let size = Size::new(32, 32);
    // A sine, in 8 bits up to 255: the flat texels are a step apart, as rounding makes them.
    let sine = [0, 90, 127, 90, 1, -90, -127, -90];
    let rough: [fn(usize) -> usize; 2] = [|y| 50 + y % 5, |y| 30 + 8 * (y % 5)];
    for (height, rough) in [0.5f32, 0.7].into_iter().flat_map(|height| rough.map(|rough| (height, rough))) {
        let slope = |v: usize| height * sine[v % 8] as f32 / 127.0;
        let texel = |i: usize| {
            let (x, y) = (i % 32, i / 32);
            (Vec3::new(-slope(x), -slope(y), 1.0).normalize(), rough(y) as f32 / 255.0, 1.0)
        };
        let grid = Grid { size, texels: (0..size.texels()).map(texel).collect(), tensor: None };
        for form in FORMS {
            for level in &chain(&grid, &Options { form, ..Options::default() }).levels[3..] {
                let side = level.lobes.size().width;
                for i in 0..side * side {
                    let normal = level.lobes.at(i % side, i / side).normal;
                    assert!(normal.z > 0.999, "{form:?}, bumps of {height}, texel {i} of {side}x{side}: {normal}");
                }
            }
        }
    }
}
