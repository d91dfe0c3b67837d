//! Laws that every fold keeps, and the chain against footprints summed one texel at a time.

use glam::{Mat3, Vec3};
use proptest::prelude::*;

use super::*;
use crate::image::Size;
use crate::material::Texels;
use crate::ndf::{Axes, Frame, RoughnessTensor};
use crate::roughness::{Alpha, PerceptualRoughness};

mod levels;
mod mixtures;
mod searches;

const FORMS: [Form; 2] = [Form::Isotropic, Form::Anisotropic];

/// Every fold in every form that it defines, but for slow ones, which have tests of their own.
fn all() -> impl Iterator<Item = (&'static Fold, Form)> {
    let defined = |f: &'static Fold, form| form == Form::Isotropic || f.has_two_widths();
    let quick = FOLDS.iter().filter(|fold| !fold.is_slow());
    quick.flat_map(move |f| FORMS.map(|form| (f, form))).filter(move |(f, form)| defined(f, *form))
}

fn texel(normal: Vec3, perceptual: f32) -> (Lobe, f32) {
    (Lobe::isotropic(normal, Alpha(perceptual * perceptual)), 1.0)
}

prop_compose! {
    /// A unit normal up to 60 degrees from up.
    fn normal()(x in -1.0f32..1.0, y in -1.0f32..1.0) -> Vec3 {
        Vec3::new(x, y, 0.82).normalize()
    }
}

prop_compose! {
    fn footprint()(texels in prop::collection::vec((normal(), 0.1f32..0.9), 1..40)) -> Vec<(Vec3, f32)> {
        texels
    }
}

fn lobes(texels: &[(Vec3, f32)]) -> Vec<(Lobe, f32)> {
    texels.iter().map(|&(n, r)| texel(n, r)).collect()
}

/// The lobe's tensor as a 3x3 form, which does not depend on the choice of tangents.
fn form_of(lobe: &Lobe) -> Mat3 {
    let Frame { tangent: t, bitangent: b } = Frame::bent(lobe.normal);
    let r = lobe.roughness;
    let outer = |a: Vec3, b: Vec3| Mat3::from_cols(a * b.x, a * b.y, a * b.z);
    outer(t, t) * r.xx + (outer(t, b) + outer(b, t)) * r.xy + outer(b, b) * r.yy
}

fn distance(a: &Lobe, b: &Lobe) -> f32 {
    let difference = form_of(a) - form_of(b);
    let columns = [difference.x_axis, difference.y_axis, difference.z_axis];
    (a.normal - b.normal).length() + columns.iter().map(|c| c.length()).sum::<f32>()
}

proptest! {
    #[test]
    fn a_flat_footprint_gives_back_its_own_lobe(n in normal(), a in 0.01f32..1.0, ratio in 0.1f32..1.0,
                                                angle in -1.5f32..1.5, count in 1usize..30) {
        let axes = |ratio| Axes { alpha_x: Alpha(a), alpha_y: Alpha(a * ratio), angle };
        for (fold, form) in all() {
            let ratio = if form == Form::Isotropic { 1.0 } else { ratio };
            let lobe = Lobe { normal: n, roughness: RoughnessTensor::from_axes(axes(ratio)) };
            let folded = fold.lobe(&vec![(lobe, 1.0); count], form);
            // Steeper than 1 / alpha, the slopes' centre turns back: it tells a normal before and one after, the more roughly
            // the closer they are.
            let turn = (1.0 - a * n.truncate().length() / n.z).min(1.0 - a);
            let rounding = if !fold.searches() { 1e-6 } else if turn > 0.1 { 2e-4 } else { 2e-2 };
            prop_assert!((folded.normal - n).length() < rounding, "{} {form:?}: {}", fold.name, (folded.normal - n).length());
            let error = (folded.roughness - lobe.roughness) * (1.0 / (a * a));
            let most = 4.0 * rounding;
            prop_assert!(error.xx.abs() < most && error.xy.abs() < most && error.yy.abs() < most,
                "{} {form:?}: {error:?}", fold.name);
        }
    }

    #[test]
    fn turning_the_texture_turns_the_lobe(texels in footprint(), angle in -3.0f32..3.0, ratio in 0.2f32..1.0) {
        let turn = Mat3::from_rotation_z(angle);
        for (fold, form) in all() {
            // Anisotropic base lobes too, where the form can hold them.
            let ratio = if form == Form::Isotropic { 1.0 } else { ratio };
            let folded = |turned: bool| {
                let turned = texels.iter().map(|&(n, r)| {
                    let along = RoughnessTensor { xx: r.powi(4), xy: 0.0, yy: ratio * r.powi(4) };
                    let (sin, cos) = if turned { angle.sin_cos() } else { (0.0, 1.0) };
                    let m = if turned { turn * n } else { n };
                    (Lobe { normal: m, roughness: along.rotated(cos, sin).to_bent(m) }, 1.0)
                });
                fold.lobe(&turned.collect::<Vec<_>>(), form)
            };
            let (a, b) = (folded(false), folded(true));
            let rounding = if fold.searches() { 3e-2 } else { 1e-4 };
            let off = (turn * a.normal - b.normal).length();
            prop_assert!(off < rounding, "{} {form:?}: {off}", fold.name);
            let difference = turn * form_of(&a) * turn.transpose() - form_of(&b);
            let size = difference.x_axis.length() + difference.y_axis.length() + difference.z_axis.length();
            prop_assert!(size < rounding * (1.0 + a.roughness.mean()), "{} {form:?}: {size}", fold.name);
        }
    }

    #[test]
    fn steeper_slopes_never_lower_alpha(slopes in prop::collection::vec((-1.0f32..1.0, -1.0f32..1.0), 2..40),
                                        r in 0.1f32..0.9, k in 1.0f32..2.0) {
        // About a mean slope of 0, as normal strength scales them.
        let n = slopes.len() as f32;
        let mean = slopes.iter().fold((0.0, 0.0), |m, s| (m.0 + s.0 / n, m.1 + s.1 / n));
        let scaled = |k: f32| -> Vec<_> {
            slopes.iter().map(|s| texel(Vec3::new(-k * (s.0 - mean.0), -k * (s.1 - mean.1), 1.0).normalize(), r)).collect()
        };
        // Searches leave out what lies far off, the sooner the farther.
        for (fold, form) in all().filter(|(fold, _)| !fold.searches()) {
            let width = |k| fold.lobe(&scaled(k), form).roughness.mean();
            prop_assert!(width(k) >= width(1.0) * (1.0 - 1e-5), "{} {form:?}", fold.name);
        }
    }

    #[test]
    fn equal_copies_and_order_change_nothing(texels in footprint()) {
        let mut twice = texels.clone();
        twice.extend(texels.iter().rev());
        for (fold, form) in all() {
            let (once, twice) = (fold.lobe(&lobes(&texels), form), fold.lobe(&lobes(&twice), form));
            let rounding = if fold.searches() { 1e-2 } else { 2e-5 };
            prop_assert!(distance(&once, &twice) < rounding, "{} {form:?}", fold.name);
        }
    }

    #[test]
    fn never_smoother_than_the_smoothest_texel_or_the_plain_average(texels in footprint()) {
        let footprint = lobes(&texels);
        let smoothest = texels.iter().map(|t| t.1).fold(1.0, f32::min).powi(4);
        let plain = (texels.iter().map(|t| t.1).sum::<f32>() / texels.len() as f32).powi(4);
        for (fold, form) in all() {
            let axes = fold.lobe(&footprint, form).axes();
            // Means over a lobe of a footprint are taken at eight nodes of it.
            let nodes = if fold.searches() { 1e-2 } else { 1e-4 };
            prop_assert!(axes.alpha_y.squared() >= smoothest * (1.0 - nodes), "{} {form:?}", fold.name);
            let searches = fold.searches();
            let held = axes.alpha_y.squared() >= plain * (1.0 - 1e-4);
            prop_assert!(held || searches || form == Form::Anisotropic, "{}", fold.name);
        }
    }

    #[test]
    fn hostile_texels_stay_finite_and_bounded(
        texels in prop::collection::vec((-1.0f32..1.0, -1.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0), 16)
    ) {
        let grid = hostile(&texels);
        for (fold, form) in all() {
            for level in chain(&grid, &Options { fold, form, ..Options::default() }).levels {
                for y in 0..level.lobes.size().height {
                    for x in 0..level.lobes.size().width {
                        let lobe = level.lobes.at(x, y);
                        let unit = (lobe.normal.length() - 1.0).abs() < 1e-5 && lobe.normal.z >= 0.0;
                        prop_assert!(unit, "{} {form:?} {:?}", fold.name, lobe.normal);
                        let axes = lobe.axes();
                        prop_assert!(axes.alpha_y.0 >= 0.0 && axes.alpha_x.0 <= 1.0 + 1e-6 && axes.angle.is_finite(),
                            "{} {form:?} {axes:?}", fold.name);
                    }
                }
            }
        }
    }
}

/// 4x4 texels: directions down to the horizon, opposed pairs, mirrors.
fn hostile(texels: &[(f32, f32, f32, f32)]) -> Grid {
    let texel = |&(x, y, z, r): &(f32, f32, f32, f32)| {
        let n = Vec3::new(x.signum() * x.abs().powf(0.1), y, z * z * z + 1e-7).normalize();
        (n, if r < 0.2 { 0.0 } else { r }, if r > 0.9 { 0.0 } else { 1.0 })
    };
    Grid { size: Size::new(4, 4), texels: texels.iter().map(texel).collect(), tensor: None }
}

/// What each fold adds to alpha^2 for narrow Gaussian slopes, in units of twice their variance. `sggx` is half by
/// construction, `average` adds nothing.
#[test]
fn narrow_gaussian_slopes_give_the_stated_alpha() {
    let sigma = 0.02f64;
    // Equal-probability quantiles of a normal distribution, by bisection of its distribution function.
    let quantile = |p: f64| {
        let (mut low, mut high) = (-6.0f64, 6.0f64);
        for _ in 0..60 {
            let mid = 0.5 * (low + high);
            let steps = 2000;
            let cdf: f64 = (0..steps)
                .map(|i| (-0.5 * (-6.0 + (mid + 6.0) * (f64::from(i) + 0.5) / f64::from(steps)).powi(2)).exp())
                .sum::<f64>()
                * (mid + 6.0)
                / f64::from(steps)
                / std::f64::consts::TAU.sqrt();
            if cdf < p { low = mid } else { high = mid }
        }
        0.5 * (low + high)
    };
    let n = 64;
    let nodes: Vec<f64> = (0..n).map(|i| sigma * quantile((f64::from(i) + 0.5) / f64::from(n))).collect();
    let variance: f64 = nodes.iter().map(|s| s * s).sum::<f64>() / f64::from(n);
    assert!((variance / (sigma * sigma) - 1.0).abs() < 0.03, "quadrature of the variance: {variance}");
    let alpha = Alpha(0.05);
    let mut footprint = Vec::new();
    for sx in &nodes {
        for sy in &nodes {
            footprint.push(texel(Vec3::new(-*sx as f32, -*sy as f32, 1.0).normalize(), alpha.perceptual().0));
        }
    }
    for (fold, form) in all() {
        let expected = match fold.name {
            "average" => 0.0,
            "sggx" => 0.5,
            // To first order only: the smear is 0.4 of alpha.
            "ggx" | "ggx-lobe" => 1.07,
            _ => 1.0,
        };
        let lobe = fold.lobe(&footprint, form);
        let added = f64::from(lobe.roughness.mean() - alpha.squared()) / (2.0 * variance);
        assert!((added - expected).abs() < 0.01, "{} {form:?}: {added}", fold.name);
    }
}

/// Texels given one by one: normal, perceptual roughness, coverage; the extra channel counts columns.
struct Grid {
    size: Size,
    texels: Vec<(Vec3, f32, f32)>,
    /// The base lobes' tensor, where it is not the isotropic one of the roughness.
    tensor: Option<RoughnessTensor>,
}

impl Grid {
    fn at(&self, x: usize, y: usize) -> (Vec3, f32, f32) {
        self.texels[y * self.size.width + x]
    }

    fn random(size: Size, seed: u64) -> Self {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let texels = (0..size.texels())
            .map(|_| {
                let n = Vec3::new(next() - 0.5, next() - 0.5, 0.6 + 0.4 * next()).normalize();
                (n, 0.1 + 0.8 * next(), if next() < 0.1 { 0.0 } else { 1.0 })
            })
            .collect();
        Self { size, texels, tensor: None }
    }
}

impl Texels for Grid {
    fn size(&self) -> Size {
        self.size
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        let [nx, ny, nz] = out;
        for i in 0..nx.len() {
            let (n, _, covered) = self.at(x + i, y);
            (nx[i], ny[i], nz[i], coverage[i]) = (n.x, n.y, n.z, covered);
        }
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        (0..out.len()).for_each(|i| out[i] = self.at(x + i, y).1);
    }

    fn is_anisotropic(&self) -> bool {
        self.tensor.is_some()
    }

    fn tensors(&self, _: usize, _: usize, _: &[f32], [xx, xy, yy]: [&mut [f32]; 3]) {
        let tensor = self.tensor.unwrap();
        xx.fill(tensor.xx);
        xy.fill(tensor.xy);
        yy.fill(tensor.yy);
    }

    fn extras(&self) -> usize {
        1
    }

    fn extra(&self, _: usize, _: usize, x: usize, out: &mut [f32]) {
        (0..out.len()).for_each(|i| out[i] = (x + i) as f32);
    }
}

#[test]
fn names_are_unique_and_unknown_ones_are_listed() {
    for (i, fold) in FOLDS.iter().enumerate() {
        assert!(std::ptr::eq(Fold::by_name(fold.name).unwrap(), fold));
        assert!(FOLDS[..i].iter().all(|other| other.name != fold.name));
    }
    let error = Fold::by_name("tocsvig").err().unwrap().to_string();
    assert!(error.contains("'tocsvig'") && error.contains("toksvig, vmf"), "{error}");
}
