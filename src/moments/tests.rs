use proptest::prelude::*;

use super::*;
use crate::image::spans;
use crate::ndf::Axes;
use crate::roughness::Alpha;

prop_compose! {
    fn texel()(x in -0.7f32..0.7, y in -0.7f32..0.7, r in 0.05f32..1.0, ratio in 0.3f32..1.0, angle in -1.5f32..1.5,
               weight in 0.1f32..4.0) -> Moments {
        let normal = Vec3::new(x, y, 1.0).normalize();
        let axes = Axes { alpha_x: Alpha(r * r), alpha_y: Alpha(r * r * ratio), angle };
        Moments::texel(weight, normal, r, RoughnessTensor::from_axes(axes))
    }
}

fn assert_close(a: &Moments, b: &Moments, tolerance: f32) -> Result<(), TestCaseError> {
    for (i, (a, b)) in a.values.iter().zip(&b.values).enumerate() {
        prop_assert!((a - b).abs() <= tolerance * a.abs().max(1.0), "plane {i}: {a} {b}");
    }
    Ok(())
}

/// Straight from the definitions, in f64.
fn whole(texels: &[Moments]) -> Moments {
    let total: f64 = texels.iter().map(|t| f64::from(t.weight())).sum();
    let mean = |f: &dyn Fn(&Moments) -> f64| texels.iter().map(|t| f64::from(t.weight()) * f(t)).sum::<f64>() / total;
    let mut out = Moments::default();
    for (i, kind) in KINDS.iter().enumerate() {
        out.values[i] = match *kind {
            Kind::Weight => total as f32,
            Kind::Mean | Kind::Plain => mean(&|t| f64::from(t.values[i])) as f32,
            Kind::Cov(a, b) => {
                let (ma, mb) = (mean(&|t| f64::from(t.values[a])), mean(&|t| f64::from(t.values[b])));
                mean(&|t| (f64::from(t.values[a]) - ma) * (f64::from(t.values[b]) - mb)) as f32
            }
        };
    }
    out
}

/// Layout, block and the texels it was made from, all with every plane.
fn block_of(texels: &[Moments], width: usize) -> (Layout, Block) {
    let layout = Layout::new(Needs::ALL, false, 0);
    let mut block = Block::default();
    block.resize(&layout, width, texels.len() / width);
    for (i, texel) in texels.iter().enumerate() {
        for slot in 0..layout.slots() {
            block.row_mut(slot, i / width)[i % width] = texel.values[slot];
        }
    }
    (layout, block)
}

proptest! {
    #[test]
    fn nothing_is_the_identity(a in texel()) {
        prop_assert_eq!(a + Moments::default(), a);
        prop_assert_eq!(Moments::default() + a, a);
    }

    #[test]
    fn grouping_and_order_do_not_matter(a in texel(), b in texel(), c in texel()) {
        assert_close(&((a + b) + c), &(a + (b + c)), 2e-6)?;
        assert_close(&(a + b), &(b + a), 2e-6)?;
    }

    #[test]
    fn adding_in_place_equals_adding(a in texel(), b in texel()) {
        let mut sum = a;
        sum += b;
        prop_assert_eq!(sum, a + b);
    }

    #[test]
    fn the_whole_equals_its_parts(texels in prop::collection::vec(texel(), 1..200), cut in 0usize..200) {
        let cut = cut.min(texels.len());
        let (left, right) = texels.split_at(cut);
        let merged = left.iter().copied().sum::<Moments>() + right.iter().copied().sum::<Moments>();
        assert_close(&merged, &whole(&texels), 1e-5)?;
    }

    #[test]
    fn splitting_in_equal_copies_changes_nothing(a in texel(), b in texel()) {
        let halves = (a.scaled(0.5) + b.scaled(0.5)) + (a.scaled(0.5) + b.scaled(0.5));
        assert_close(&halves, &(a + b), 2e-6)?;
    }

    #[test]
    fn a_flat_footprint_has_no_variance_at_all(a in texel(), n in 1usize..50) {
        let sum: Moments = std::iter::repeat_n(a, n).sum();
        for i in [NORMAL_COV, NORMAL_COV + 3, SLOPE_COV, SLOPE_COV + 2] {
            prop_assert_eq!(sum.values[i], 0.0);
        }
        prop_assert_eq!(sum.normal(), a.normal());
    }

    #[test]
    fn blocks_merge_like_single_moments(texels in prop::collection::vec(texel(), 16), same_weight in any::<bool>()) {
        let texels: Vec<_> = texels.iter().map(|t| if same_weight { t.scaled(1.0 / t.weight()) } else { *t }).collect();
        let (layout, block) = block_of(&texels, 8);
        let (mut once, mut twice, mut scratch) = (Block::default(), Block::default(), Quads::default());
        once.resize(&layout, 4, 2);
        block.halve(&layout, true, &mut once, 0, &mut scratch);
        block.halve(&layout, true, &mut once, 1, &mut scratch);
        twice.resize(&layout, 2, 1);
        once.halve(&layout, false, &mut twice, 0, &mut scratch);
        for x in 0..4 {
            let quad = [2 * x, 2 * x + 1, 2 * x + 8, 2 * x + 9].map(|i| texels[i]);
            assert_close(&once.at(&layout, x, 0), &whole(&quad), 2e-6)?;
        }
        for x in 0..2 {
            let sixteen: Vec<_> = (0..16).map(|i| texels[(i / 4 % 2) * 8 + 4 * x + i % 4]).collect();
            assert_close(&twice.at(&layout, x, 0), &whole(&sixteen), 2e-6)?;
        }
    }

    #[test]
    fn fractional_footprints_weigh_by_area(texels in prop::collection::vec(texel(), 7 * 5), level in 0usize..3) {
        let (layout, block) = block_of(&texels, 7);
        let (width, height) = ([3, 1, 2][level], [2, 1, 1][level]);
        let (across, down) = (spans(7, width), spans(5, height));
        let (mut out, mut scratch) = (Block::default(), Scratch::default());
        for y in 0..height {
            let row = |y: usize, out: &mut Block| {
                out.resize(&layout, 7, 1);
                (0..layout.slots()).for_each(|slot| out.row_mut(slot, 0).copy_from_slice(block.row(slot, y)));
            };
            reduce_rows(&layout, row, &down[y], &across, &mut out, &mut scratch);
            for (x, span) in across.iter().enumerate() {
                let mut parts = Vec::new();
                for (j, wy) in down[y].weights.iter().enumerate() {
                    for (i, wx) in span.weights.iter().enumerate() {
                        parts.push(texels[(down[y].first + j) * 7 + span.first + i].scaled(wx * wy));
                    }
                }
                assert_close(&out.at(&layout, x, 0), &whole(&parts), 5e-6)?;
            }
        }
    }
}

#[test]
fn two_texels_worked_by_hand() {
    // Slopes +0.5 and -0.5 in x, equal weights: mean 0, variance 0.25. Normals (-+1, 0, 2) / sqrt 5.
    let texel = |x: f32| Moments::texel(1.0, Vec3::new(x, 0.0, 2.0).normalize(), 0.5, RoughnessTensor::default());
    let sum = texel(-1.0) + texel(1.0);
    assert_eq!(sum.weight(), 2.0);
    assert!((sum.slope_cov().xx - 0.25).abs() < 1e-7 && sum.slope().length() < 1e-7);
    assert!((sum.normal() - Vec3::new(0.0, 0.0, 2.0 / 5.0f32.sqrt())).length() < 1e-7);
    assert!((sum.normal_cov()[0] - 0.2).abs() < 1e-7);
}

#[test]
fn narrow_variance_survives_a_steep_mean() {
    // Slopes 1 +- 0.0141 (variance 2e-4, alpha 0.02): raw moments in f32 would leave 1e-7 of noise.
    let texel = |s: f32| Moments::texel(1.0, Vec3::new(-s, 0.0, 1.0).normalize(), 0.0, RoughnessTensor::default());
    let d = 2e-4f32.sqrt();
    let sum: Moments = (0..4096).map(|i| texel(if i % 2 == 0 { 1.0 + d } else { 1.0 - d })).sum();
    assert!((sum.slope_cov().xx / 2e-4 - 1.0).abs() < 1e-3, "{}", sum.slope_cov().xx);
}

#[test]
fn one_texel_on_its_side_cannot_own_a_coarse_footprint() {
    let side = Vec3::new(-1.0, 0.0, 0.004).normalize();
    let flat = (0..4095).map(|_| Moments::texel(1.0, Vec3::Z, 0.3, RoughnessTensor::default()));
    let sum = flat.sum::<Moments>() + Moments::texel(1.0, side, 0.3, RoughnessTensor::default());
    assert!(sum.slope_cov().xx < 0.0062, "{}", sum.slope_cov().xx);
    let bound = |z: f32| (1.0 / (z * z) - 1.0) / 4096.0;
    assert!((bound(STEEPEST_Z) - 0.006).abs() < 2e-4 && (bound(1.0 / 255.0) - 16.0).abs() < 0.2);
    assert!((STEEPEST_Z.acos().to_degrees() - 78.5).abs() < 0.05);
}

#[test]
fn an_unusable_texel_is_ignored_beside_any_other() {
    let bad = Moments::texel(UNUSABLE_WEIGHT, Vec3::Z, 1.0, RoughnessTensor::isotropic(Alpha(1.0)));
    let good = Moments::texel(1.0, Vec3::new(0.6, 0.0, 0.8), 0.2, RoughnessTensor::isotropic(Alpha(0.04)));
    let sum = bad + good + bad;
    assert!((sum.normal() - good.normal()).length() < 1e-6 && (sum.perceptual() - 0.2).abs() < 1e-6);
    assert_eq!((bad + bad).normal(), Vec3::Z);
}
