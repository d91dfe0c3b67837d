//! Laws of several lobes a texel.

use super::*;

fn several() -> impl Iterator<Item = Options> {
    let folds = all().filter(|(fold, _)| fold.has_mixtures());
    folds.flat_map(|(fold, form)| {
        [(2, false), (3, false), (4, false), (2, true)].map(|(lobes, shared_normal)| Options {
            fold,
            form,
            lobes,
            shared_normal,
            ..Options::default()
        })
    })
}

fn words(options: &Options) -> String {
    options.fold.name.to_string() + &crate::ndf::lobes_in_words(options.form, options.lobes, options.shared_normal)
}

/// 2x2 texels of two kinds: two lobes are those.
#[test]
fn footprints_of_two_lobes_give_them_back() {
    let kinds = [(Vec3::new(0.4, 0.1, 1.0).normalize(), 0.25), (Vec3::new(-0.3, 0.2, 1.0).normalize(), 0.5)];
    let texel = |kind: usize| (kinds[kind].0, kinds[kind].1, 1.0);
    let grid = Grid { size: Size::new(2, 2), texels: [0, 1, 1, 1].map(texel).to_vec(), tensor: None };
    for options in several().filter(|o| o.lobes == 2 && !o.shared_normal) {
        let lobes = &chain(&grid, &options).levels[0].lobes;
        for (j, weight) in [0.25, 0.75].into_iter().enumerate() {
            let (lobe, found) = lobes.slot(j, 0, 0);
            let off = distance(&lobe, &super::texel(kinds[j].0, kinds[j].1).0);
            // The foot of each reaches below the other.
            assert!(off < 0.03 && (found - weight).abs() < 0.02, "{} {j}: {off} {found}", words(&options));
        }
    }
}

/// Texels of a level that are given one kind of facet each and its mirror image, in random order.
#[test]
fn lobes_keep_their_slots_from_texel_to_texel_and_level_to_level() {
    let mut grid = Grid::random(Size::new(64, 64), 11);
    for pair in grid.texels.chunks_exact_mut(2) {
        let (side, lean) = (if pair[0].0.x > 0.0 { 0.4 } else { -0.4 }, 0.1 * pair[0].0.y);
        for (texel, side) in pair.iter_mut().zip([side, -side]) {
            *texel = (Vec3::new(side, lean, 1.0).normalize(), 0.3 + 0.1 * texel.1, 1.0);
        }
    }
    for options in several().filter(|o| o.lobes == 2 && !o.shared_normal) {
        let levels = chain(&grid, &options).levels;
        let first = levels.last().unwrap().lobes.slot(0, 0, 0).0.normal.x.signum();
        for (k, level) in levels.iter().enumerate() {
            let Size { width, height } = level.lobes.size();
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                for (j, side) in [first, -first].into_iter().enumerate() {
                    let (lobe, weight) = level.lobes.slot(j, x, y);
                    assert!(lobe.normal.x * side > 0.3, "{} level {k}: {lobe:?}", words(&options));
                    assert!((weight - 0.5).abs() < 0.05, "{} level {k}: {weight}", words(&options));
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn hostile_texels_give_lobes_and_shares(
        texels in prop::collection::vec((-1.0f32..1.0, -1.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0), 16)
    ) {
        let grid = hostile(&texels);
        for options in several() {
            for level in chain(&grid, &options).levels {
                let Size { width, height } = level.lobes.size();
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    let slots: Vec<_> = (0..options.lobes).map(|j| level.lobes.slot(j, x, y)).collect();
                    prop_assert!(crate::ndf::are_shares(slots.iter().map(|s| s.1)), "{} {slots:?}", words(&options));
                    for (lobe, _) in &slots {
                        let unit = (lobe.normal.length() - 1.0).abs() < 1e-5 && lobe.normal.z > 0.0;
                        let axes = lobe.axes();
                        let widths = axes.alpha_y.0 >= 0.0 && axes.alpha_x.0 <= 1.0 + 1e-6 && axes.angle.is_finite();
                        prop_assert!(unit && widths, "{} {lobe:?}", words(&options));
                        if options.shared_normal {
                            prop_assert!(lobe.normal.distance(slots[0].0.normal) < 1e-6);
                        }
                    }
                }
            }
        }
    }

    /// A lobe alone is all lobes, or the only one with a share.
    #[test]
    fn a_flat_texture_stays_itself(n in normal(), r in 0.1f32..0.75) {
        let grid = Grid { size: Size::new(4, 4), texels: vec![(n, r, 1.0); 16], tensor: None };
        let own = texel(n, r).0;
        for options in several() {
            for level in chain(&grid, &options).levels {
                for (lobe, _) in level.lobes.mixture(0, 0) {
                    let off = distance(&lobe, &own);
                    prop_assert!(off < 0.03, "{} {lobe:?}: {off}", words(&options));
                }
            }
        }
    }
}
