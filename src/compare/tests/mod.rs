//! The judge against brute force, against itself, and on what it must not depend on.

mod mixtures;
mod sampling;

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::measure::views;
use super::*;
use crate::image::Size;
use crate::material::{Texels, base_lobes};
use crate::ndf::{Form, Lobe, Lobes, Ndf, ShapeInvariant};
use crate::reference::tests::{Field, field, tilted};
use crate::reference::{Reading, directional_albedo};
use crate::roughness::Alpha;

/// Level 0 of a surface and further levels of one lobe each.
fn candidate(name: &str, base: &dyn Texels, lobe: Lobe) -> Candidate {
    let size = base.size();
    let mut levels = vec![base_lobes(base, Form::Isotropic)];
    levels.extend((1..size.level_count()).map(|k| Lobes::from_fn(Form::Isotropic, size.level(k), |_, _| lobe)));
    Candidate { name: name.into(), fold: None, levels }
}

fn run(base: &dyn Texels, chains: &[Candidate], settings: &Settings) -> Judgement {
    judge(base, chains, settings, &|_| ()).unwrap()
}

/// Four texels with wide lobes, so that brute force is quick.
fn four() -> Field {
    Field {
        size: Size::new(2, 2),
        normals: vec![tilted(0.2, 0.0), tilted(-0.3, 0.1), tilted(0.0, -0.2), tilted(0.1, 0.3)],
        perceptual: vec![0.5, 0.6, 0.55, 0.7],
    }
}

/// Directions of the upper hemisphere, equal areas.
fn hemisphere(n: usize) -> impl Iterator<Item = DVec3> {
    (0..n * n).map(move |i| {
        let (z, phi) = (((i % n) as f64 + 0.5) / n as f64, TAU * ((i / n) as f64 + 0.5) / n as f64);
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    })
}

/// Every figure of the one texel of level 1 of [`four`], summed over a grid with [`Lobe`]'s own functions.
#[test]
fn every_figure_agrees_with_brute_force() {
    let base = four();
    let texels: Vec<Lobe> =
        (0..4).map(|i| Lobe::isotropic(base.normals[i], Alpha(base.perceptual[i] * base.perceptual[i]))).collect();
    let lobe = Lobe::isotropic(tilted(0.05, 0.1), Alpha(0.5));
    let settings = Settings { directions: 40_000, levels: vec![1], ..Settings::default() };
    let judgement = run(&base, &[candidate("one", &base, lobe)], &settings);
    let found = &judgement.chains[0].levels[0];

    let (mut tv, mut hellinger2, mut kl) = (0.0, 0.0, 0.0);
    let (mut all_p, mut all_q) = (0.0, 0.0);
    const N: usize = 600;
    let area = TAU / (N * N) as f64;
    for m in hemisphere(N) {
        let p: f64 = texels.iter().map(|t| 0.25 * t.d(m) / f64::from(t.normal.z)).sum();
        let q = lobe.d(m) / f64::from(lobe.normal.z);
        (all_p, all_q) = (all_p + p * m.z * area, all_q + q * m.z * area);
        tv += 0.5 * (p - q).abs() * m.z * area;
        hellinger2 += 0.5 * (p.sqrt() - q.sqrt()).powi(2) * m.z * area;
        kl += if p > 0.0 && q > 0.0 { (p * (p / q).ln() - p + q) * m.z * area } else { 0.0 };
    }
    // Both sides hold 1, but for what leans below the surface.
    let both = 0.5 * (all_p + all_q);
    assert!((all_p - 1.0).abs() < 0.03 && (all_q - 1.0).abs() < 0.03);
    let (tv, hellinger2, kl) = (tv / both, hellinger2 / both, kl / all_p);
    let [mut distance, mut sum_ref, mut sum, mut all_ref, mut all] = [0.0; 5];
    for view in views() {
        let gain = |t: &Lobe| 1.0 / directional_albedo(t.normal.as_dvec3().dot(view), t.axes().alpha_x);
        for l in hemisphere(300) {
            let f_ref: f64 = texels.iter().map(|t| 0.25 * t.specular(view, l)).sum();
            let f = lobe.specular(view, l);
            (distance, sum_ref, sum) = (distance + (f - f_ref).abs(), sum_ref + f_ref, sum + f);
            all_ref += texels.iter().map(|t| 0.25 * t.specular(view, l) * gain(t)).sum::<f64>();
            all += f * gain(&lobe);
        }
    }
    let error = distance / (0.5 * (sum + sum_ref));
    let (energy, compensated) = (sum / sum_ref, all / all_ref);
    let dot = |n: Vec3, l: DVec3| n.as_dvec3().dot(l).max(0.0);
    let (mut diffuse, mut diffuse_ref) = (0.0, 0.0);
    for l in hemisphere(200) {
        let reference: f64 = texels.iter().map(|t| 0.25 * dot(t.normal, l)).sum();
        diffuse += (dot(lobe.normal, l) - reference).abs();
        diffuse_ref += reference;
    }
    let pairs = [
        ("lobe error", found.lobe_error.mean, error, found.lobe_error.stderr),
        ("tv", found.ndf_tv.mean, tv, found.ndf_tv.stderr),
        ("hellinger", found.ndf_hellinger.mean, hellinger2.sqrt(), found.ndf_hellinger.stderr),
        ("kl", found.ndf_kl.mean, kl, found.ndf_kl.stderr),
        ("energy", found.energy.mean, energy, found.energy.stderr),
        ("compensated", found.energy.compensated, compensated, found.energy.stderr),
        // 256 fixed lights against 40000.
        ("diffuse", found.diffuse_error.mean, diffuse / diffuse_ref, 0.01 * diffuse / diffuse_ref),
    ];
    for (name, found, expected, stderr) in pairs {
        assert!(stderr < 0.03 * expected, "{name}: stderr {stderr}");
        assert!((found - expected).abs() < 4.0 * stderr + 2e-3, "{name}: {found} +- {stderr}, expected {expected}");
    }
}

/// The round light by brute force: every light is a mean over 61 places. The narrowest lobe, of alpha 0.04, is near
/// what the judge's own places resolve.
#[test]
fn round_light_agrees_with_brute_force() {
    let mut base = four();
    base.perceptual[1] = 0.2;
    let texels: Vec<Lobe> =
        (0..4).map(|i| Lobe::isotropic(base.normals[i], Alpha(base.perceptual[i] * base.perceptual[i]))).collect();
    let lobe = Lobe::isotropic(tilted(-0.25, 0.05), Alpha(0.06));
    let settings = Settings { directions: 100_000, levels: vec![1], ..Settings::default() };
    let found = run(&base, &[candidate("one", &base, lobe)], &settings).chains[0].levels[0].lobe_error_light;
    let (mut distance, mut total) = (0.0, 0.0);
    for view in views() {
        for middle in hemisphere(200) {
            let turned = glam::DQuat::from_rotation_arc(DVec3::Z, middle);
            let (mut f, mut f_ref) = (0.0, 0.0);
            for k in 0..61 {
                let (r, phi) = (LIGHT_RADIUS.to_radians() * ((k as f64 + 0.5) / 61.0).sqrt(), 2.4 * k as f64);
                let l = turned * DVec3::new(r.sin() * phi.cos(), r.sin() * phi.sin(), r.cos());
                if l.z > 0.0 {
                    f += lobe.specular(view, l);
                    f_ref += texels.iter().map(|t| 0.25 * t.specular(view, l)).sum::<f64>();
                }
            }
            distance += (f - f_ref).abs();
            total += 0.5 * (f + f_ref);
        }
    }
    let error = distance / total;
    // The middles here end at the horizon, the judge's do not.
    let off = (found.mean - error).abs();
    assert!(found.stderr < 0.02 * error && off < 3.0 * found.stderr + 0.02 * error, "{found:?} {error}");
}

#[test]
fn identical_lobes_give_zero_to_the_last_bit() {
    let flat = Field { size: Size::new(8, 4), normals: vec![tilted(0.2, -0.1); 32], perceptual: vec![0.3; 32] };
    let bumpy = field(8, 4);
    let lobe = base_lobes(&flat, Form::Isotropic).at(0, 0);
    for (base, levels) in [(&flat, Vec::new()), (&bumpy, vec![0])] {
        let settings = Settings { levels, ..Settings::default() };
        for level in &run(base, &[candidate("same", base, lobe)], &settings).chains[0].levels {
            let zero = Summary::default();
            for summary in [
                level.lobe_error,
                level.lobe_error_light,
                level.ndf_tv,
                level.ndf_hellinger,
                level.ndf_kl,
                level.diffuse_error,
            ] {
                assert_eq!(summary, zero, "level {}", level.level);
            }
            assert_eq!((level.energy.mean, level.energy.compensated), (1.0, 1.0));
            assert_eq!(level.energy.views, [1.0; 5]);
        }
    }
}

#[test]
fn a_chain_passes_limits_of_zero_against_itself() {
    let flat = Field { size: Size::new(4, 4), normals: vec![Vec3::Z; 16], perceptual: vec![0.4; 16] };
    let same = candidate("same", &flat, base_lobes(&flat, Form::Isotropic).at(0, 0));
    let judgement = run(&flat, &[same], &Settings::default());
    let limits: Vec<Limit> = Metric::ALL.iter().map(|metric| format!("{}=0", metric.name).parse().unwrap()).collect();
    assert_eq!((judgement.chains[0].levels.len(), judgement.chains[0].breaches(&limits)), (3, vec![]));
    let wide = candidate("wide", &flat, Lobe::isotropic(Vec3::Z, Alpha(0.5)));
    let breaches = run(&flat, &[wide], &Settings::default()).chains[0].breaches(&limits);
    // Not the diffuse term, whose normals are right.
    assert_eq!(breaches.len(), 8, "{breaches:?}");
}

#[test]
fn disjoint_lobes_reach_the_largest_figures() {
    let base = Field { size: Size::new(2, 1), normals: vec![tilted(0.9, 0.0); 2], perceptual: vec![0.1; 2] };
    let away = Lobe::isotropic(tilted(-0.9, 0.0), Alpha(0.01));
    let settings = Settings { levels: vec![1], directions: 4000, ..Settings::default() };
    let level = &run(&base, &[candidate("away", &base, away)], &settings).chains[0].levels[0];
    assert!(level.ndf_tv.mean > 0.99 && level.ndf_tv.mean <= 1.0, "{level:?}");
    assert!(level.ndf_hellinger.mean > 0.95 && level.ndf_hellinger.mean <= 1.0, "{level:?}");
    assert!(level.lobe_error.mean > 1.98 && level.lobe_error.mean <= 2.0, "{level:?}");
}

/// A slope that hardly any view sees: whatever a chain shows instead, no figure leaves its range.
#[test]
fn steep_slopes_do_not_explode() {
    for slope in [2.0, 20.0] {
        let base = Field { size: Size::new(2, 2), normals: vec![tilted(slope, slope); 4], perceptual: vec![0.25; 4] };
        let flat = candidate("flat", &base, Lobe::isotropic(Vec3::Z, Alpha(0.5)));
        for seed in 1..20 {
            let settings = Settings { levels: vec![1], seed, ..Settings::default() };
            let level = &run(&base, std::slice::from_ref(&flat), &settings).chains[0].levels[0];
            assert!((0.5..=2.0).contains(&level.lobe_error.mean), "{level:?}");
            assert!((0.5..=1.0).contains(&level.ndf_tv.mean) && level.ndf_hellinger.mean <= 1.0, "{level:?}");
        }
    }
}

/// Texels that cannot be used change nothing about those that can: half of a map against the same half alone.
#[test]
fn unusable_texels_do_not_bend_the_figures() {
    let side = 32;
    let (a, b) = (tilted(0.5, 0.0), tilted(-0.5, 0.1));
    let whole = |usable: bool| {
        let normal = |i: usize| match (i % side, i / side) {
            (x, _) if usable && x < side / 2 => Vec3::NEG_Z,
            (x, _) if usable => {
                if x < 3 * side / 4 {
                    a
                } else {
                    b
                }
            }
            (x, _) => {
                if x < side / 2 {
                    a
                } else {
                    b
                }
            }
        };
        let normals = (0..side * side).map(normal).collect();
        Field { size: Size::new(side, side), normals, perceptual: vec![0.5; side * side] }
    };
    let judged = |base: &Field| {
        let chain = candidate("a", base, Lobe::isotropic(a, Alpha(0.25)));
        let settings = Settings { levels: vec![5], directions: 8000, ..Settings::default() };
        run(base, &[chain], &settings).chains.swap_remove(0).levels.swap_remove(0)
    };
    let (found, expected) = (judged(&whole(true)), judged(&whole(false)));
    let near = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs() < 4.0 * (a.1 * a.1 + b.1 * b.1).sqrt();
    for (a, b) in [(found.ndf_tv, expected.ndf_tv), (found.lobe_error, expected.lobe_error)] {
        assert!(near((a.mean, a.stderr), (b.mean, b.stderr)), "{a:?} {b:?}");
    }
    let energy = |level: &LevelScore| (level.energy.mean, level.energy.stderr);
    assert!(near(energy(&found), energy(&expected)), "{:?} {:?}", found.energy, expected.energy);
}

#[test]
fn figures_depend_on_no_other_chain_and_on_no_thread() {
    let base = field(64, 32);
    let lobe = |a| Lobe::isotropic(tilted(0.1, 0.0), Alpha(a));
    let (one, two) = (candidate("one", &base, lobe(0.3)), candidate("two", &base, lobe(0.6)));
    let settings = Settings { texels: Some(8), ..Settings::default() };
    let alone = run(&base, std::slice::from_ref(&one), &settings).chains.swap_remove(0);
    let mut short = two.clone();
    short.levels.truncate(3);
    let beside = run(&base, &[short, one], &settings).chains;
    assert_eq!((beside[0].levels.len(), beside[1].levels.len()), (3, 7));
    assert_eq!(beside[1], alone);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(pool.install(|| run(&base, &beside_of(&two), &settings)), run(&base, &[two], &settings));
}

fn beside_of(chain: &Candidate) -> [Candidate; 1] {
    [chain.clone()]
}

#[test]
fn texels_are_chosen_from_every_part_of_a_level() {
    let base = field(64, 16);
    let chain = candidate("flat", &base, Lobe::isotropic(Vec3::Z, Alpha(0.4)));
    let settings = Settings { texels: Some(16), directions: 5, levels: vec![0], ..Settings::default() };
    let level = run(&base, &[chain], &settings).chains.swap_remove(0).levels.swap_remove(0);
    assert_eq!((level.samples, level.width, level.height), (16, 64, 16));
    let far = level.worst.iter().filter(|texel| texel.x >= 64 || texel.y >= 16).count();
    assert_eq!((level.worst.len(), far), (8, 0));
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    let base = field(8, 8);
    let error = |levels: Vec<Lobes>| {
        let chain = Candidate { name: "mine".into(), fold: None, levels };
        judge(&base, &[chain], &Settings::default(), &|_| ()).unwrap_err().to_string()
    };
    let flat =
        |side| Lobes::from_fn(Form::Isotropic, Size::new(side, side), |_, _| Lobe::isotropic(Vec3::Z, Alpha(0.3)));
    assert_eq!(error(vec![]), "mine: found no levels; expected a chain with level 0 at least");
    assert_eq!(error(vec![flat(4)]), "mine: found level 0 of 4x4; expected 8x8, for the base is 8x8");
    assert_eq!(error(vec![flat(8), flat(3)]), "mine: found level 1 of 3x3; expected 4x4, for the base is 8x8");
    let deep = vec![flat(8), flat(4), flat(2), flat(1), flat(1)];
    assert_eq!(error(deep), "mine: found level 4 of 1x1; expected no further level, for the base is 8x8");
}

#[test]
fn progress_ends_at_one() {
    let base = field(16, 16);
    let chain = candidate("flat", &base, Lobe::isotropic(Vec3::Z, Alpha(0.4)));
    let told = std::sync::Mutex::new(Vec::new());
    judge(&base, &[chain], &Settings::default(), &|share| told.lock().unwrap().push(share)).unwrap();
    let told = told.into_inner().unwrap();
    let most = told.iter().copied().fold(0.0, f64::max);
    assert!(told.len() > 20 && (most - 1.0).abs() < 1e-12 && told.iter().all(|share| *share > 0.0 && *share <= 1.0));
}
