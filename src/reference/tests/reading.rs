//! Ways to read a footprint, and what must not matter.

use super::*;

#[test]
fn bilinear_normals_meet_the_texels_and_lie_between() {
    let field = field(4, 4);
    let reading = |per_side| Reading {
        interpolation: Interpolation::Bilinear { per_side, wrap: Wrap::Repeat },
        ..Reading::default()
    };
    // One place in the middle of a texel is the texel.
    let constant = Footprint::of_texel(&field, Reading::default(), 1, 1, (1, 0));
    let middle = Footprint::of_texel(&field, reading(1), 1, 1, (1, 0));
    for m in directions() {
        assert!(close(middle.d(m), constant.d(m), 1e-5));
    }
    // A ramp between two columns, by hand: three places are 1/3 apart.
    let two =
        Field { size: Size::new(2, 1), normals: vec![tilted(0.2, 0.0), tilted(-0.2, 0.0)], perceptual: vec![0.5, 0.7] };
    let texel = Footprint::of_texel(&two, reading(3), 1, 0, (0, 0));
    let place = |t: f32| {
        let normal = two.normals[0].lerp(two.normals[1], t).normalize();
        let r = 0.5 + 0.2 * t;
        (Lobe::isotropic(normal, Alpha(r * r)), 1.0)
    };
    // By repetition both neighbours are the other column.
    let list = Footprint::of_lobes(&[place(1.0 / 3.0), place(0.0), place(1.0 / 3.0)]);
    assert_eq!(texel.lobes(), 9);
    for m in directions() {
        assert!(close(texel.d(m), list.d(m), 1e-4), "{} {}", texel.d(m), list.d(m));
    }
    // Finer places converge.
    let (fine, finer) =
        (Footprint::of_texel(&field, reading(4), 1, 2, (0, 0)), Footprint::of_texel(&field, reading(8), 1, 2, (0, 0)));
    assert!(close(fine.d(DVec3::Z), finer.d(DVec3::Z), 0.02));
}

#[test]
fn a_subset_is_close_to_the_whole_and_in_groups() {
    let mut field = field(64, 64);
    field.perceptual.iter_mut().for_each(|r| *r = r.max(0.5));
    let whole = Footprint::of_texel(&field, Reading::default(), 1, 6, (0, 0));
    let part = Footprint::of_texel(&field, Reading { most_texels: Some(512), ..Reading::default() }, 5, 6, (0, 0));
    assert!(part.lobes() <= 512 && part.lobes() >= 450, "{}", part.lobes());
    let mut queries = Queries::default();
    queries.start_view(DVec3::Z);
    directions().iter().for_each(|m| queries.push_half(*m));
    let groups = part.means(&queries, &Diffuse::default());
    assert_eq!(groups.len(), 8);
    let merged = Means::merged(&groups.iter().collect::<Vec<_>>());
    let truth = whole.means(&queries, &Diffuse::default()).swap_remove(0);
    for j in 0..queries.len() {
        // The groups tell the error: 5 standard errors of a mean of eight for any of 40 directions.
        let variance = groups.iter().map(|group| (group.d[j] - merged.d[j]).powi(2)).sum::<f64>() / (8.0 * 7.0);
        let error = (merged.d[j] - truth.d[j]).abs();
        assert!(error < 5.0 * variance.sqrt() && error < 0.5 * truth.d[j], "{} {}", merged.d[j], truth.d[j]);
    }
    // As many texels as there are is all of them.
    let all = Footprint::of_texel(&field, Reading { most_texels: Some(4096), ..Reading::default() }, 5, 6, (0, 0));
    assert_eq!(all.d(DVec3::Z), whole.d(DVec3::Z));
}

#[test]
fn nothing_depends_on_threads() {
    let field = field(512, 300);
    let ask = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Footprint::of_texel(&field, Reading::default(), 1, 9, (0, 0)).density(&directions()))
    };
    assert_eq!(ask(1), ask(3));
}

#[test]
fn equal_lobes_give_that_lobe_to_the_last_bit() {
    let lobe = lobes()[2];
    let same = Field { size: Size::new(33, 21), normals: vec![lobe.normal; 33 * 21], perceptual: vec![0.37; 33 * 21] };
    let mut queries = Queries::default();
    queries.start_view(DVec3::new(0.3, 0.2, 0.9).normalize());
    directions().iter().for_each(|l| queries.push_light(*l));
    let lights = Diffuse::new(&directions());
    let many = Footprint::of_texel(&same, Reading::default(), 1, 3, (1, 1)).means(&queries, &lights).swap_remove(0);
    let base = crate::material::base_lobes(&same, crate::ndf::Form::Isotropic).at(3, 4);
    let one = Footprint::of_lobes(&[(base, 0.2)]).means(&queries, &lights).swap_remove(0);
    assert_eq!(Means { weight: 1.0, ..many }, Means { weight: 1.0, ..one });
}
