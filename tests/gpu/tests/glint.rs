//! Glint ratios of shaders against the library's in f64, over a hundred thousand queries, in deviations sigma = sqrt((1 +
//! variation^2) / N_eff) of the ratio: their errors are rare rather than small, which bounds for each call do not tell.
//! `--nocapture` shows what is measured.

use std::fs;

use glam::{DMat2, DVec2, DVec3};
use mipfold_gpu_tests::case::SplitMix;
use mipfold_gpu_tests::cases::glint::{draw_lobe, flakes};
use mipfold_gpu_tests::cases::glint_chance::{draws, log};
use mipfold_gpu_tests::cases::glint_field::{draw_query, query};
use mipfold_gpu_tests::glint::{EVALUATORS, Light, Macro, Query, SolidAngle, Tail, glint_ratio};
use mipfold_gpu_tests::gpu::{Gpu, gpu, has_glslang, say, skipped};
use mipfold_gpu_tests::harness::results;
use mipfold_gpu_tests::ndf::RoughnessTensor;
use mipfold_gpu_tests::source::kernels;
use mipfold_gpu_tests::translate::Language;
use mipfold_gpu_tests::twins::glint::{GlintLight, GlintPixel};
use mipfold_gpu_tests::twins::{glint_binomial, glint_field};

/// Queries of each evaluator and language.
const QUERIES: usize = 100_000;

/// Most of them are within this many deviations.
const CLOSE: f64 = 5e-3;

fn able() -> Option<(&'static Gpu, &'static [Language])> {
    let Some(gpu) = gpu() else {
        skipped("no Vulkan adapter");
        return None;
    };
    if has_glslang() {
        return Some((gpu, &Language::ALL));
    }
    skipped("no glslangValidator: WGSL alone is run");
    Some((gpu, &[Language::Wgsl]))
}

/// Errors in deviations: how many are not close, and the largest with its query.
fn compare(what: &str, shader: &[Vec<f64>], truth: &[f64], deviations: &[f64], inputs: &[Vec<f64>]) -> (usize, f64) {
    let error = |i: usize| {
        assert!(shader[i][0].is_finite() && shader[i][0] >= 0.0, "{what}: {} at {:?}", shader[i][0], inputs[i]);
        (shader[i][0] - truth[i]).abs() / deviations[i]
    };
    let mut errors: Vec<(f64, usize)> = (0..truth.len()).map(|i| (error(i), i)).collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let far = errors.iter().filter(|e| e.0 > CLOSE).count();
    let (worst, at) = errors[errors.len() - 1];
    let quantile = errors[errors.len() * 999 / 1000].0;
    let (s, t) = (shader[at][0], truth[at]);
    say(&format!(
        "{what}: {far} of {} beyond {CLOSE} sigma, 99.9 % within {quantile:.1e}, worst {worst:.1e} ({s} for {t})\n",
        errors.len()
    ));
    (far, worst)
}

fn prepared(inputs: &[Vec<f64>]) -> Vec<(GlintPixel, GlintLight, u32, f64)> {
    use mipfold_gpu_tests::cases::glint::{light, pixel};
    // Rounded as shaders get them.
    let rounded = |a: &Vec<f64>| -> Vec<f64> { a.iter().map(|v| f64::from(*v as f32)).collect() };
    inputs
        .iter()
        .map(|a| {
            let mut p = pixel(&rounded(a));
            p.cell = [a[0] as i32, a[1] as i32];
            (p, light(&rounded(a)[8..]), a[14] as u32, f64::from(a[15] as f32))
        })
        .collect()
}

/// From kernels, directions and areas to g.
fn evaluator_agrees(name: &str, area_from: f64, far_allowed: usize, worst_allowed: f64) {
    let Some((gpu, languages)) = able() else { return };
    let inputs = draws(QUERIES, 61, |r| {
        let (n_eff, area, long) = (log(r, 0.01, 1.5e4), log(r, area_from, 0.43), log(r, 1.0, 64.0));
        // Equal ones, unequal ones, and few of them there.
        let varied = match r.unit() {
            ..0.6 => 0.0,
            ..0.9 => 3.0 * r.unit(),
            _ => log(r, 3.0, 99.9),
        };
        query(r, n_eff, area, long, varied)
    });
    let asked = prepared(&inputs);
    let truth: Vec<f64> = asked
        .iter()
        .map(|(p, l, seed, variation)| match name {
            "glint_field" => glint_field::glint_field(p, l, *seed, *variation),
            _ => glint_binomial::glint_binomial(p, l, *seed, *variation),
        })
        .collect();
    let deviation = |(p, l, _, v): &(GlintPixel, GlintLight, u32, f64)| {
        ((1.0 + v * v) / mipfold_gpu_tests::twins::glint::glint_effective(p, l)).sqrt()
    };
    let deviations: Vec<f64> = asked.iter().map(deviation).collect();
    for &language in languages {
        let shader = results(gpu, name, &format!("mf_{name}"), &inputs, language).unwrap_or_else(|e| panic!("{e}"));
        let what = format!("{name} ({}), areas from {area_from:.0e}", language.name());
        let (far, worst) = compare(&what, &shader, &truth, &deviations, &inputs);
        assert!(far <= far_allowed && worst <= worst_allowed, "{what}: {far} far, worst {worst}");
    }
}

#[test]
fn the_field_agrees() {
    evaluator_agrees("glint_field", 1e-6, QUERIES / 10_000, 0.05);
}

#[test]
fn the_field_agrees_for_the_rarest_answers() {
    evaluator_agrees("glint_field", 1e-9, QUERIES / 10_000, 0.05);
}

#[test]
fn counts_agree() {
    evaluator_agrees("glint_binomial", 1e-6, QUERIES / 10_000, 0.05);
}

/// A query as an application has it, and the scalars of the shader's functions: pixel (13), lobe and half vector (9).
fn whole_query(r: &mut SplitMix) -> (Query, Vec<f64>, Vec<f64>, f64) {
    let f = |v: f64| f64::from(v as f32);
    let cells = f(log(r, 50.0, 5e3));
    let size = log(r, 0.2, 300.0) / cells;
    let mut change = || f((r.unit() - 0.5) * size);
    let change = [change(), change(), change(), change()];
    let uv = [f((r.unit() - 0.5) * 64.0), f((r.unit() - 0.5) * 64.0)];
    let lobe: Vec<f64> = draw_lobe(r).into_iter().map(f).collect();
    let (theta, turn) = (1.3 * r.unit(), 6.3 * r.unit());
    let h = [f(theta.sin() * turn.cos()), f(theta.sin() * turn.sin()), f(theta.cos())];
    let omega = f(log(r, 1e-5, 2e-2));
    let seed = (r.bits() % 64) as f64;
    let more = [cells, seed, 0.0, 1.0, 1.0, 1.0, 0.0];
    let pixel = [&uv[..], &change[..], &more[..]].concat();
    let mut flakes = flakes(&more);
    flakes.lobe = SolidAngle(omega);
    let roughness = RoughnessTensor { xx: lobe[2] as f32, xy: lobe[3] as f32, yy: lobe[4] as f32 };
    let tail = if lobe[5] == 0.0 { Tail::Ggx } else { Tail::Beckmann };
    let query = Query {
        uv: DVec2::from(uv),
        jacobian: DMat2::from_cols(DVec2::new(change[0], change[1]), DVec2::new(change[2], change[3])),
        h: DVec3::from(h),
        lobe: Macro { mean: DVec2::new(lobe[0], lobe[1]), roughness, tail },
        flakes,
        light: Light::new(SolidAngle(0.0), 1.0),
    };
    (query, pixel, [&lobe[..], &h[..], &[omega]].concat(), omega)
}

/// From uv, Jacobian, lobe and half vector to g, all in shaders.
#[test]
fn whole_queries_agree() {
    let Some((gpu, languages)) = able() else { return };
    let mut random = SplitMix(62);
    let asked: Vec<_> = (0..QUERIES).map(|_| whole_query(&mut random)).collect();
    let pixels: Vec<_> = asked.iter().map(|a| a.1.clone()).collect();
    let lights: Vec<_> = asked.iter().map(|a| a.2.clone()).collect();
    let deviations: Vec<f64> = asked.iter().map(|a| a.0.probe().expect("finite").n_eff().powf(-0.5)).collect();
    for &language in languages {
        let call = |subject: &str, name: &str, inputs: &[Vec<f64>]| {
            results(gpu, subject, name, inputs, language).unwrap_or_else(|e| panic!("{e}"))
        };
        let (seen, from) = (call("glint", "mf_glint_pixel", &pixels), call("glint", "mf_glint_light", &lights));
        let arguments: Vec<Vec<f64>> =
            (0..QUERIES).map(|i| [&seen[i][..], &from[i][..], &pixels[i][6..]].concat()).collect();
        for (evaluator, subject) in EVALUATORS.iter().zip(["glint_field", "glint_binomial"]) {
            let truth: Vec<f64> = asked.iter().map(|a| glint_ratio(evaluator, &a.0)).collect();
            let shader = call(subject, &format!("mf_{subject}"), &arguments);
            let what = format!("{subject} from uv to g ({})", language.name());
            let (far, worst) = compare(&what, &shader, &truth, &deviations, &arguments);
            assert!(far <= QUERIES / 10_000 && worst <= 0.05, "{what}: {far} far, worst {worst}");
        }
    }
}

/// Means within 1e-3 and variances within 1 percent, but for what 40,000 intervals of u leave.
#[test]
fn counts_have_their_means_and_variances() {
    let Some((gpu, _)) = able() else { return };
    let samples = 40_000;
    for n in [0.5, 1.5, 10.0, 100.0, 1e4, 1e9] {
        for mean in [1e-3, 0.1, 1.0, 5.0, 11.0, 20.0, 100.0] {
            let p: f64 = mean / n;
            if p > 1.0 {
                continue;
            }
            let mut random = SplitMix(63);
            let at: Vec<f64> = (0..samples).map(|i| (f64::from(i) + random.unit()) / f64::from(samples)).collect();
            let inputs: Vec<_> = at.iter().map(|u| vec![n, p, u.clamp(1e-7, 0.999_999_9)]).collect();
            let counts = results(gpu, "glint_chance", "mf_binomial", &inputs, Language::Wgsl).unwrap();
            let m = counts.iter().map(|k| k[0]).sum::<f64>() / f64::from(samples);
            let v = counts.iter().map(|k| (k[0] - m).powi(2)).sum::<f64>() / f64::from(samples);
            let variance = mean * (1.0 - p * n / n.ceil());
            let slack = 8.0 * (mean.sqrt() + 1.0) / f64::from(samples);
            assert!((m - mean).abs() < 1e-3 * mean + slack, "n {n}, p {p}: mean {m}");
            assert!((v - variance).abs() < 0.01 * variance + 8.0 * slack, "n {n}, p {p}: variance {v}, not {variance}");
        }
    }
}

/// The number behind a constant of a text.
fn constant(subject: &str, name: &str) -> f64 {
    let text = fs::read_to_string(kernels().join("wgsl").join(format!("{subject}.wgsl"))).expect("a text");
    let line = text.lines().find(|l| l.starts_with(&format!("const {name}:"))).expect("the constant");
    line.split("= ").nth(1).and_then(|n| n.trim_end_matches(';').trim_end_matches('u').parse().ok()).expect("a number")
}

/// Flakes that one layer looks at, and cells that one grid has: the bounds of loops are far above.
#[test]
fn loops_are_as_long_as_pixels_need() {
    let most = [constant("glint_field", "MF_GLINT_MOST"), constant("glint_binomial", "MF_GLINT_CELLS")];
    let mut random = SplitMix(64);
    // Cells on average, as the text has them.
    for (long, cells) in [(1.0, 5.0), (4.0, 15.0), (16.0, 57.0), (64.0, 230.0)] {
        for area in [1e-9, 1e-7, 1e-5, 1e-3, 0.03, 0.43] {
            let mut found = Vec::new();
            for n_eff in [0.01, 0.1, 1.0, 1.5, 6.0] {
                let (mut sums, mut worst) = ([0.0; 2], [0.0f64; 2]);
                for _ in 0..200 {
                    let r = &mut random;
                    let about = n_eff * log(r, 0.7, 1.0);
                    let (pixel, light) = draw_query(r, about, area, long);
                    for (which, n) in
                        [flakes_seen(&pixel, &light), cells_seen(&pixel, r.unit())].into_iter().enumerate()
                    {
                        sums[which] += n / 200.0;
                        worst[which] = worst[which].max(n);
                    }
                }
                assert!(worst[0] < most[0] && worst[1] < most[1], "{worst:?}");
                assert!(
                    (sums[1] / cells - 1.0).abs() < 0.15 && worst[1] <= 410.0,
                    "{long}: {} cells, {}",
                    sums[1],
                    worst[1]
                );
                found.push(format!("{n_eff}: {:.0} ({}), {:.0} ({})", sums[0], worst[0], sums[1], worst[1]));
            }
            say(&format!(
                "length {long}, area {area:.0e}: flakes (most), cells (most) for N_eff {}\n",
                found.join("; ")
            ));
        }
    }
}

fn flakes_seen(pixel: &GlintPixel, light: &GlintLight) -> f64 {
    let radius = (light.area / mipfold_gpu_tests::glint::BIWEIGHT_AREA).sqrt();
    let k = glint_field::glint_level(pixel.kernel.root, radius).round() as u32;
    let blocks = 1i64 << k;
    let boxes = |y: f64| {
        let [a, b] = glint_field::glint_boxes(y, radius, blocks);
        (b - a + 1) as f64
    };
    let home = pixel.cell.map(|c| f64::from(c & (blocks as i32 - 1)));
    let mut found = 0.0;
    pixel.kernel.ellipse().rows(DVec2::from(home) + pixel.within, blocks as f64, |_, first, last| {
        found += (last - first + 1) as f64;
    });
    found * boxes(light.y.x) * boxes(light.y.y)
}

/// Turns of the loop over the finer grid's cells, one for a row that has none.
fn cells_seen(pixel: &GlintPixel, position: f64) -> f64 {
    let [_, short] = pixel.kernel.ellipse().radii();
    let [finest, narrow2, reach2] =
        ["FINEST", "NARROW2", "REACH2"].map(|name| constant("glint_binomial", &format!("MF_GLINT_{name}")));
    let e = pixel.kernel.ellipse().scaled(narrow2.sqrt() * finest / (short * (-position).exp2()));
    let (xx, yy, c) = (e.xx + reach2, e.yy + reach2, pixel.within - 0.5);
    let mut found = 0.0;
    for j in (c.y - yy.sqrt()).ceil() as i64..=(c.y + yy.sqrt()).floor() as i64 {
        let d = j as f64 - c.y;
        let half = ((1.0 - d * d / yy).max(0.0) * (xx - e.xy * e.xy / yy)).sqrt();
        let middle = c.x + d * e.xy / yy;
        found += ((middle + half).floor() - (middle - half).ceil() + 1.0).max(1.0);
    }
    found
}
