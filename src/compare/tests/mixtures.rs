//! Chains whose texels hold several lobes.

use super::*;

/// Two facets side by side, and again: the whole truth of level 1 is two lobes.
fn facets() -> Field {
    let normals = [tilted(0.3, 0.1), tilted(-0.4, 0.0)];
    Field { size: Size::new(4, 2), normals: [normals; 4].concat(), perceptual: [[0.4, 0.6]; 4].concat() }
}

/// Level 0 as it is, and two lobes a texel with these weights above it: those of [`facets`].
fn two_lobes(base: &Field, weights: [f32; 2]) -> Candidate {
    let own = base_lobes(base, Form::Isotropic);
    let [a, b] = [0, 1].map(|x| own.at(x, 0));
    let level = |k| {
        Lobes::mixed_from_fn(Form::Isotropic, 2, base.size.level(k), |j, _, _| [(a, weights[0]), (b, weights[1])][j])
    };
    Candidate::new("two", vec![own, level(1), level(2)])
}

#[test]
fn a_mixture_that_is_its_footprint_is_right_in_every_figure() {
    let base = facets();
    let score = judge_one(&base, two_lobes(&base, [0.5, 0.5]), &Settings::default()).unwrap();
    assert_eq!((score.lobes, score.count, score.lobes_in_words().as_str()), (Form::Isotropic, 2, "2 lobes, one width"));
    assert_eq!(score.levels.len(), 3);
    for level in &score.levels {
        let figures = [level.lobe_error, level.lobe_error_light, level.ndf_tv, level.diffuse_error];
        assert!(figures.iter().all(|figure| figure.p95.abs() < 1e-9), "{level:?}");
        assert!(level.ndf_kl.mean.abs() < 1e-9 && level.ndf_hellinger.mean < 1e-6, "{level:?}");
        assert!((level.energy.mean - 1.0).abs() < 1e-9 && (level.energy.compensated - 1.0).abs() < 1e-9, "{level:?}");
    }
}

/// A lobe that is not there does not count, and neither does the order of the others.
#[test]
fn order_and_absent_lobes_do_not_matter() {
    let base = field(8, 8);
    let [a, b] = [Lobe::isotropic(tilted(0.2, 0.0), Alpha(0.3)), Lobe::isotropic(tilted(-0.1, 0.2), Alpha(0.5))];
    let error = |lobes: &[(Lobe, f32)]| {
        let mut levels = vec![base_lobes(&base, Form::Isotropic)];
        let mixed = |k| Lobes::mixed_from_fn(Form::Isotropic, lobes.len(), base.size.level(k), |j, _, _| lobes[j]);
        levels.extend((1..4).map(mixed));
        let settings = Settings { directions: 400, ..Settings::default() };
        judge_one(&base, Candidate::new("mixed", levels), &settings).unwrap().levels[2].lobe_error
    };
    let two = error(&[(a, 0.25), (b, 0.75)]);
    assert_eq!(error(&[(a, 0.25), (b, 0.75), (a, 0.0)]), two);
    let turned = error(&[(b, 0.75), (a, 0.25)]);
    assert!((turned.mean - two.mean).abs() < 4.0 * two.stderr.hypot(turned.stderr), "{two:?} {turned:?}");
    // Another mixture is another chain.
    assert!((error(&[(a, 0.75), (b, 0.25)]).mean - two.mean).abs() > 0.05);
    assert_eq!(error(&[(a, 1.0), (b, 0.0)]), error(&[(a, 1.0)]));
}

/// The weights are those of the area: others are further off.
#[test]
fn wrong_weights_are_seen() {
    let base = facets();
    let settings = Settings { directions: 400, levels: vec![1], ..Settings::default() };
    let error = |weights| judge_one(&base, two_lobes(&base, weights), &settings).unwrap().levels[0].lobe_error.mean;
    let (little, much) = (error([0.6, 0.4]), error([0.9, 0.1]));
    assert!(little > 0.1 && much > 2.0 * little, "{little} {much}");
}

#[test]
fn what_is_no_mixture_is_refused() {
    let base = facets();
    let refused = |weights| {
        let error = judge_one(&base, two_lobes(&base, weights), &Settings::default()).unwrap_err().to_string();
        assert!(error.contains("two") && error.contains("level 1, column 0, row 0"), "{error}");
        assert!(error.contains("weights") && error.contains("sum to 1"), "{error}");
    };
    refused([0.5, 0.4]);
    refused([1.5, -0.5]);
    refused([f32::NAN, 1.0]);
    refused([f32::INFINITY, 0.0]);
    judge_one(&base, two_lobes(&base, [0.5004, 0.5]), &Settings::default()).unwrap();
    // Filtering reads lobes of weight 0 too.
    let mut chain = two_lobes(&base, [1.0, 0.0]);
    let size = base.size.level(1);
    chain.levels[1] = Lobes::mixed_zeros(Form::Isotropic, 2, size);
    let error = judge_one(&base, chain, &Settings::default()).unwrap_err().to_string();
    assert!(error.contains("a normal that faces out"), "{error}");
}
