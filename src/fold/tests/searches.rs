//! Folds that search: what they are near to.

use super::*;
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

/// Along rows and from level to level, alpha and normal vary little more than those of the best formula.
#[test]
fn what_varies_smoothly_is_folded_smoothly() {
    let mut grid = Grid::random(Size::new(128, 128), 3);
    for (i, texel) in grid.texels.iter_mut().enumerate() {
        let (x, y) = ((i % 128) as f32, (i / 128) as f32);
        // Bumps whose height swells along the rows.
        let height = 0.2 * (std::f32::consts::PI * x / 128.0).sin();
        let n = Vec3::new(height * (2.1 * x + 0.7 * y).sin(), height * (1.3 * x - 1.9 * y).sin(), 1.0);
        *texel = (n.normalize(), 0.4, 1.0);
    }
    let variation = |fold: &'static Fold, form| {
        let levels = chain(&grid, &Options { fold, form, ..Options::default() }).levels;
        let lobes = &levels[3].lobes;
        let row = |y: usize| (1..8).map(move |x| distance(&lobes.at(x, y), &lobes.at(x - 1, y)));
        let across: f32 = (0..8).flat_map(row).sum();
        let down: f32 = (0..8)
            .flat_map(|y| (0..8).map(move |x| (x, y)))
            .map(|(x, y)| distance(&levels[4].lobes.at(x / 2, y / 2), &lobes.at(x, y)))
            .sum();
        [across, down]
    };
    for form in FORMS {
        let [across, down] = variation(Fold::by_name("projected").unwrap(), form);
        for fold in FOLDS.iter().filter(|fold| fold.has_mixtures()) {
            let [a, d] = variation(fold, form);
            assert!(a < 1.5 * across && d < 1.5 * down, "{} {form:?}: {a} of {across}, {d} of {down}", fold.name);
        }
    }
}
