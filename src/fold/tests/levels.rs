//! The chain against footprints summed one texel at a time.

use super::*;
use crate::image::spans;
use crate::summary::EXACT;

/// The footprint of a texel of level `k`, summed one texel at a time.
pub(super) fn footprint_of(grid: &Grid, k: usize, x: usize, y: usize) -> (Vec<(Lobe, f32)>, f32) {
    let target = grid.size.level(k);
    let across = &spans(grid.size.width, target.width)[x];
    let down = &spans(grid.size.height, target.height)[y];
    let (mut lobes, mut extra, mut area) = (Vec::new(), 0.0, 0.0);
    for (j, wy) in down.weights.iter().enumerate() {
        for (i, wx) in across.weights.iter().enumerate() {
            let (n, r, covered) = grid.at(across.first + i, down.first + j);
            lobes.push((texel(n, r).0, wx * wy * f32::max(covered, crate::moments::UNUSABLE_WEIGHT)));
            extra += wx * wy * (across.first + i) as f32;
            area += wx * wy;
        }
    }
    (lobes, extra / area)
}

#[test]
fn every_level_is_folded_from_the_exact_footprint_of_level_0() {
    // Powers of two, even and odd sides, strips, wider than a tile, more rows than a band.
    let sizes =
        [(8, 8), (12, 20), (7, 5), (64, 1), (1, 13), (30, 1), (96, 128), (1088, 3), (1152, 4), (2, 256), (1, 1)];
    for (width, height) in sizes {
        let grid = Grid::random(Size::new(width, height), (width * 1000 + height) as u64);
        for (fold, form) in all() {
            let options = Options { fold, form, ..Options::default() };
            let chain = chain(&grid, &options);
            assert_eq!(chain.levels.len() + 1, grid.size.level_count());
            for (k, level) in (1..).zip(&chain.levels) {
                let size = grid.size.level(k);
                assert_eq!(level.lobes.size(), size);
                for (x, y) in [(0, 0), (size.width - 1, size.height - 1), (size.width / 2, size.height / 3)] {
                    let (footprint, extra) = footprint_of(&grid, k, x, y);
                    let mut expected = fold.lobe(&footprint, form);
                    expected.roughness = expected.roughness.clamped(0.0, 1.0);
                    let error = distance(&expected, &level.lobes.at(x, y));
                    // A summary of unlike texels is not exact.
                    let most = if fold.searches() && footprint.len() > EXACT { 0.2 } else { 2e-4 };
                    assert!(error < most, "{} {form:?} {width}x{height} level {k} at {x},{y}: {error}", fold.name);
                    assert!((level.extras[(0, y, x)] - extra).abs() < 1e-4 * width as f32);
                }
            }
        }
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    for size in [Size::new(256, 128), Size::new(90, 75)] {
        let grid = Grid::random(size, 3);
        let options = Options { form: Form::Anisotropic, slope_moments: true, ..Options::default() };
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| chain(&grid, &options))
        };
        assert_eq!(run(1), run(5));
    }
}

#[test]
fn progress_ends_at_the_whole_and_changes_nothing() {
    for size in [Size::new(64, 16), Size::new(30, 7)] {
        let grid = Grid::random(size, 5);
        let options = Options::default();
        let shares = std::sync::Mutex::new(Vec::new());
        assert_eq!(chain_telling(&grid, &options, &|share| shares.lock().unwrap().push(share)), chain(&grid, &options));
        let mut shares = shares.into_inner().unwrap();
        shares.sort_by(f64::total_cmp);
        assert!(shares.len() > 5 && shares[0] > 0.0 && shares.last() == Some(&1.0), "{shares:?}");
    }
}

#[test]
fn strength_and_bounds() {
    let grid = Grid::random(Size::new(16, 16), 7);
    let top = |options: &Options| chain(&grid, options).levels.pop().unwrap().lobes.at(0, 0).roughness;
    for form in FORMS {
        let with = |strength| top(&Options { form, strength, ..Options::default() });
        let (none, half, all) = (with(0.0), with(0.5), with(1.0));
        let (footprint, _) = footprint_of(&grid, 4, 0, 0);
        let weight: f32 = footprint.iter().map(|(_, weight)| weight).sum();
        let base: f32 = footprint.iter().map(|(lobe, weight)| lobe.roughness.mean() * weight).sum::<f32>() / weight;
        assert!((none.mean() - base).abs() < 1e-5);
        assert!((half.mean() - 0.5 * (none.mean() + all.mean())).abs() < 1e-5);
        let bounded = top(&Options { form, min_alpha: Alpha(0.9), ..Options::default() }).axes();
        assert!((bounded.alpha_y.0 - 0.9).abs() < 1e-5);
        let bounded = top(&Options { form, max_alpha: Alpha(0.1), ..Options::default() }).axes();
        assert!((bounded.alpha_x.0 - 0.1).abs() < 1e-5);
    }
}

#[test]
fn smooth_texels_among_rough_ones_win_unless_the_average_is_asked_for() {
    let rough = |i: usize| if i.is_multiple_of(3) { 0.6 } else { 0.15 };
    let texels: Vec<_> = (0..64).map(|i| (Vec3::Z, rough(i), 1.0)).collect();
    let plain = texels.iter().map(|t| t.1).sum::<f32>() / 64.0;
    let grid = Grid { size: Size::new(8, 8), texels, tensor: None };
    for form in FORMS {
        let top = |at_least_average| {
            let options = Options { form, at_least_average, ..Options::default() };
            chain(&grid, &options).levels.pop().unwrap().lobes.at(0, 0).roughness.mean()
        };
        let average = PerceptualRoughness(plain).alpha().squared();
        assert!(top(false) < 0.5 * average, "{} {average}", top(false));
        assert!((top(true) / average - 1.0).abs() < 1e-5, "{} {average}", top(true));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn at_least_average_holds_in_every_form(seed in 0u64..1000, strength in prop::sample::select(vec![0.0f32, 0.5, 1.0, 3.0])) {
        let mut grid = Grid::random(Size::new(8, 8), seed);
        grid.texels.iter_mut().for_each(|texel| texel.2 = 1.0);
        let plain = grid.texels.iter().map(|t| t.1).sum::<f32>() / 64.0;
        let least = PerceptualRoughness(plain).alpha().squared();
        for (fold, form) in all() {
            for lobes in if fold.has_mixtures() { vec![1, 2, 4] } else { vec![1] } {
                let options = Options { fold, form, lobes, strength, at_least_average: true, ..Options::default() };
                for (lobe, _) in chain(&grid, &options).levels[2].lobes.mixture(0, 0) {
                    let mean = lobe.roughness.mean();
                    prop_assert!(mean > least * (1.0 - 1e-4), "{} {form:?}: {mean} {least}", fold.name);
                }
            }
        }
    }
}

#[test]
fn a_constant_tilted_anisotropic_texture_stays_itself_at_any_strength() {
    let axes = Axes { alpha_x: Alpha(0.65), alpha_y: Alpha(0.09), angle: 0.3 };
    let lobe = Lobe { normal: Vec3::new(0.5, 0.4, 0.7).normalize(), roughness: RoughnessTensor::from_axes(axes) };
    let grid = Grid { size: Size::new(8, 8), texels: vec![(lobe.normal, 0.3, 1.0); 64], tensor: Some(lobe.roughness) };
    for (fold, form) in all().filter(|(_, form)| *form == Form::Anisotropic) {
        for strength in [0.0, 0.5, 1.0, 2.0] {
            for level in chain(&grid, &Options { fold, form, strength, ..Options::default() }).levels {
                let error = distance(&lobe, &level.lobes.at(0, 0));
                assert!(error < 2e-5, "{} at strength {strength}: {error}", fold.name);
            }
        }
    }
}
