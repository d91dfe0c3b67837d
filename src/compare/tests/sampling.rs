//! What the stated errors are worth.

use super::*;

/// Half the directions and half the texels: the change stays within the stated errors; and those are not idle.
#[test]
fn halving_the_sample_stays_within_the_stated_error() {
    let base = field(256, 256);
    let chain = candidate("flat", &base, Lobe::isotropic(Vec3::Z, Alpha(0.4)));
    let at = |texels, directions, seed| {
        let levels = vec![2, 4, 6];
        let settings = Settings { texels: Some(texels), directions, levels, seed, ..Settings::default() };
        run(&base, std::slice::from_ref(&chain), &settings).chains.swap_remove(0).levels
    };
    let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    for seed in 1..=6 {
        let full = at(64, 80, seed);
        for half in [at(32, 80, seed + 10), at(64, 40, seed + 20)] {
            for (a, b) in full.iter().zip(&half) {
                let pairs = [
                    (a.lobe_error, b.lobe_error),
                    (a.ndf_tv, b.ndf_tv),
                    (a.ndf_hellinger, b.ndf_hellinger),
                    (a.lobe_error_light, b.lobe_error_light),
                ];
                for (a, b) in pairs {
                    let z = (a.mean - b.mean) / (a.stderr.powi(2) + b.stderr.powi(2)).sqrt();
                    (worst, sum, count) = (worst.max(z.abs()), sum + z * z, count + 1.0);
                }
            }
        }
    }
    // 144 comparisons: 4 standard errors would be passed once in 100 such tests; evenly spread draws do better.
    assert!(worst < 4.0, "{worst}");
    let rms = (sum / count).sqrt();
    assert!((0.3..1.2).contains(&rms), "stated errors are {} of the true ones", 1.0 / rms);
}

#[test]
fn subsets_of_footprints_state_their_error() {
    let mut base = field(128, 128);
    // Narrower lobes would leave gaps between those of a subset, which no half of it can tell.
    base.perceptual.iter_mut().for_each(|r| *r = r.max(0.35));
    let chain = candidate("flat", &base, Lobe::isotropic(Vec3::Z, Alpha(0.4)));
    let at = |most_texels, seed| {
        let reading = Reading { most_texels, ..Reading::default() };
        let settings = Settings { texels: Some(4), directions: 400, levels: vec![7], reading, seed };
        run(&base, std::slice::from_ref(&chain), &settings).chains[0].levels[0].ndf_tv
    };
    let whole = at(None, 1);
    let (mut outside, mut stated) = (0, 0.0);
    for seed in 0..12 {
        let part = at(Some(256), seed);
        outside += usize::from((part.mean - whole.mean).abs() > 2.5 * part.stderr);
        stated += part.stderr / 12.0;
    }
    assert!(outside <= 2 && stated > whole.stderr, "{outside} of 12 beyond 2.5 standard errors");
}

/// Rough normals, many texels: subsets of any size agree with the whole, and nothing comes out as a perfect 0.
#[test]
fn subsets_of_rough_footprints_are_neither_flattered_nor_lost() {
    let mut random = crate::random::Random::new(9, 9);
    let mut normal = || tilted(random.uniform() as f32 - 0.5, random.uniform() as f32 - 0.5);
    let normals = (0..128 * 128).map(|_| normal()).collect();
    let base = Field { size: Size::new(128, 128), normals, perceptual: vec![0.4; 128 * 128] };
    let chain = candidate("flat", &base, Lobe::isotropic(Vec3::Z, Alpha(0.45)));
    let at = |most_texels, seed| {
        let reading = Reading { most_texels, ..Reading::default() };
        let settings = Settings { texels: None, directions: 80, levels: vec![3], reading, seed };
        run(&base, std::slice::from_ref(&chain), &settings).chains.swap_remove(0).levels.swap_remove(0)
    };
    let whole = at(None, 1);
    for most in [16, 32] {
        for seed in 1..4 {
            let part = at(Some(most), seed);
            let pairs = [(part.lobe_error, whole.lobe_error), (part.ndf_tv, whole.ndf_tv), (part.ndf_kl, whole.ndf_kl)];
            for (part, whole) in pairs {
                let error = (part.stderr.powi(2) + whole.stderr.powi(2)).sqrt();
                assert!(part.stderr.is_finite() && (part.mean - whole.mean).abs() < 4.0 * error, "{part:?} {whole:?}");
                assert!(part.mean > 0.5 * whole.mean, "{part:?} {whole:?}");
            }
        }
    }
}

#[test]
fn what_is_no_lobe_is_refused() {
    let base = field(4, 4);
    let good = Lobe::isotropic(Vec3::Z, Alpha(0.3));
    let wrong = [
        Lobe { normal: Vec3::new(f32::NAN, 0.0, 1.0), ..good },
        Lobe { normal: Vec3::ZERO, ..good },
        Lobe { normal: Vec3::NEG_Z, ..good },
        Lobe::isotropic(Vec3::Z, Alpha(f32::NAN)),
        Lobe::isotropic(Vec3::Z, Alpha(f32::INFINITY)),
    ];
    for lobe in wrong {
        let error = judge(&base, &[candidate("mine", &base, lobe)], &Settings::default(), &|_| ()).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("mine: found Lobe") && text.contains("in level 1, column 0, row 0"), "{text}");
    }
}
