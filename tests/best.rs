//! How close the folds come to the best that a single GGX lobe can do: of texels of real maps the lobe of least lobe error
//! is searched by brute force, in f64, against the exact footprint.
//!
//! `cargo test --test best -- --ignored --nocapture`; what begins with `sample_` takes a minute, all of it twelve.
#![allow(clippy::print_stdout)]

mod common;

use glam::Vec3;
use mipfold::compare::VIEWS;
use mipfold::fold::{FOLDS, Fold, Options, chain};
use mipfold::image::Size;
use mipfold::material::{ChannelRef, Inputs, Material, RoughnessInput, Texels, base_lobes, load};
use mipfold::ndf::{Axes, Form, Lobe, RoughnessTensor};
use mipfold::random::{Random, Spread};
use mipfold::reference::{Diffuse, Footprint, Queries, Reading};
use mipfold::roughness::{Alpha, PerceptualRoughness};
use rayon::prelude::*;

/// Texels of a side of the squares that are cut from maps; whole footprints up to level 6.
const SIDE: usize = 64;
const LEVELS: [usize; 4] = [1, 2, 4, 6];
const FORMS: [Form; 2] = [Form::Anisotropic, Form::Isotropic];
/// Half vectors a view by which a lobe is searched, and others by which all are judged.
const SEARCHED: usize = 512;
const JUDGED: usize = 1024;
/// Folds from which a search starts; it starts from the most alike of so many texels too.
const STARTS: [&str; 3] = ["projected", "ggx", "ggx-lobe"];
const TEXELS: usize = 16;
/// Folds of mixtures, their lobes, and their errors over that of the best single lobe, at most: at a constant alpha, and at the
/// maps' own roughness, where the mean is that of one map of mirrors, all turned differently.
const MIXTURES: [(&str, usize, [f64; 2]); 4] =
    [("ggx", 2, [0.85, 0.92]), ("ggx", 4, [0.5, 0.66]), ("ggx-lobe", 2, [0.75, 0.75]), ("ggx-lobe", 4, [0.42, 0.52])];

/// A square of a map, with its own roughness or a constant alpha.
struct Square<'a> {
    material: &'a Material,
    alpha: Option<f32>,
    corner: (usize, usize),
}

impl Texels for Square<'_> {
    fn size(&self) -> Size {
        Size::new(SIDE, SIDE)
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        self.material.normals(self.corner.1 + y, self.corner.0 + x, out, coverage);
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        match self.alpha {
            Some(alpha) => out.fill(Alpha(alpha).perceptual().0),
            None => self.material.perceptual(self.corner.1 + y, self.corner.0 + x, out),
        }
    }
}

/// The lobe error against one footprint, by half vectors of the judge's views: half of them are drawn from the footprint,
/// the others from some lobes.
struct Error {
    queries: Queries,
    /// What each half vector stands for.
    share: Vec<f64>,
    truth: Vec<f64>,
}

fn means(footprint: &Footprint, queries: &Queries) -> mipfold::reference::Means {
    footprint.means(queries, &Diffuse::default()).swap_remove(0)
}

impl Error {
    fn new(footprint: &Footprint, lobes: &[Lobe], halves: usize, mut random: Random) -> Self {
        let own: Vec<Footprint> = lobes.iter().map(|lobe| Footprint::of_lobes(&[(*lobe, 1.0)])).collect();
        let sources: Vec<(&Footprint, usize)> = std::iter::once((footprint, halves / 2))
            .chain(own.iter().map(|f| (f, (halves / 2).div_ceil(own.len()))))
            .collect();
        let mut spreads: Vec<Spread> = sources.iter().map(|_| Spread::new(&mut random)).collect();
        let mut queries = Queries::default();
        for (slant, around) in VIEWS {
            let ((sin, cos), (y, x)) = (slant.to_radians().sin_cos(), around.to_radians().sin_cos());
            queries.start_view(glam::DVec3::new(sin * x, sin * y, cos));
            for ((source, count), spread) in sources.iter().zip(&mut spreads) {
                (0..*count).for_each(|_| queries.push_half(source.draw(spread.point())));
            }
        }
        let total: usize = sources.iter().map(|(_, count)| count).sum();
        let mut density = vec![0.0; queries.len()];
        let mut truth = Vec::new();
        for (i, (source, count)) in sources.iter().enumerate() {
            let means = means(source, &queries);
            density.iter_mut().zip(means.pdf).for_each(|(d, pdf)| *d += pdf * *count as f64 / total as f64);
            truth = if i == 0 { means.specular } else { truth };
        }
        let share = queries.views().zip(queries.ranges()).flat_map(|(view, range)| {
            let (queries, density) = (&queries, &density);
            range.map(move |j| view.dot(queries.half(j)).max(0.0) / density[j])
        });
        let share: Vec<f64> = share.collect();
        Self { queries, share, truth }
    }

    fn of(&self, lobe: &Lobe) -> f64 {
        self.of_mixture(&[(*lobe, 1.0)])
    }

    fn of_mixture(&self, lobes: &[(Lobe, f64)]) -> f64 {
        let own = means(&Footprint::of_lobes(lobes), &self.queries).specular;
        let (mut apart, mut both) = (0.0, 0.0);
        for ((f, truth), share) in own.iter().zip(&self.truth).zip(&self.share) {
            apart += share * (f - truth).abs();
            both += share * 0.5 * (f + truth);
        }
        apart / both
    }

    /// The best lobe of a form, searched from one lobe, and again from where that ends.
    fn best(&self, form: Form, start: Lobe) -> Lobe {
        let mut best = start;
        for size in [0.3, 0.1] {
            let from = best;
            let (x, _) = minimum(if form == Form::Isotropic { 3 } else { 5 }, size, |x| self.of(&moved(from, x)));
            best = moved(from, &x);
        }
        best
    }
}

/// A lobe turned by two slopes, in its widths; wider by the exponential of a third number, or with the last three making its
/// own factor of two widths.
fn moved(lobe: Lobe, x: &[f64]) -> Lobe {
    let Axes { alpha_x, alpha_y, angle } = lobe.axes();
    let (sin, cos) = angle.sin_cos();
    let (along, across) = (x[0] as f32 * alpha_x.0, x[1] as f32 * alpha_y.0);
    let slope = lobe.normal.truncate() / -lobe.normal.z;
    let slope = slope + glam::Vec2::new(cos * along - sin * across, sin * along + cos * across);
    let normal = Vec3::new(-slope.x, -slope.y, 1.0).normalize();
    let (wider, skew, other) = if x.len() == 3 { (x[2], 0.0, x[2]) } else { (x[2], x[3], x[4]) };
    let (a, b, c) = (alpha_x.0 * wider.exp() as f32, alpha_y.0 * skew as f32, alpha_y.0 * other.exp() as f32);
    let roughness = RoughnessTensor { xx: a * a, xy: a * b, yy: b * b + c * c }.rotated(cos, sin);
    Lobe { normal, roughness: roughness.clamped(1e-8, 1.0) }
}

/// Nelder and Mead's search from 0.
fn minimum(n: usize, size: f64, f: impl Fn(&[f64]) -> f64) -> (Vec<f64>, f64) {
    let mut corners: Vec<(Vec<f64>, f64)> = (0..=n)
        .map(|i| {
            let x: Vec<f64> = (0..n).map(|k| if i == k + 1 { size } else { 0.0 }).collect();
            let value = f(&x);
            (x, value)
        })
        .collect();
    for _ in 0..100 * n {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        if corners[n].1 - corners[0].1 < 1e-4 * corners[0].1 {
            break;
        }
        let at = |t: f64| -> (Vec<f64>, f64) {
            let mean = |k: usize| corners[..n].iter().map(|(x, _)| x[k]).sum::<f64>() / n as f64;
            let x: Vec<f64> = (0..n).map(|k| mean(k) + t * (mean(k) - corners[n].0[k])).collect();
            let value = f(&x);
            (x, value)
        };
        let (best, second, worst) = (corners[0].1, corners[n - 1].1, corners[n].1);
        let reflected = at(1.0);
        let next = if reflected.1 < best {
            let further = at(2.0);
            if further.1 < reflected.1 { further } else { reflected }
        } else if reflected.1 < second {
            reflected
        } else {
            at(if reflected.1 < worst { 0.5 } else { -0.5 })
        };
        if next.1 < worst {
            corners[n] = next;
            continue;
        }
        let centre = corners[0].0.clone();
        for (x, value) in &mut corners[1..] {
            x.iter_mut().zip(&centre).for_each(|(x, c)| *x = 0.5 * (*x + c));
            *value = f(x);
        }
    }
    corners.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

/// Errors at one texel: of every contender, then of the best, then of the mixtures.
struct Case {
    map: usize,
    alpha: usize,
    form: Form,
    errors: Vec<f64>,
}

/// Folds with a form of their own.
fn contenders(form: Form) -> Vec<&'static Fold> {
    FOLDS.iter().filter(|fold| form == Form::Isotropic || fold.has_two_widths()).collect()
}

fn judge(square: &Square, map: usize, alpha: usize, seed: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    for form in FORMS {
        let (folds, base) = (contenders(form), base_lobes(square, form));
        let chains: Vec<_> =
            folds.iter().map(|&fold| chain(square, &Options { fold, form, ..Options::default() })).collect();
        let mixtures = MIXTURES.map(|(name, lobes, _)| {
            let fold = Fold::by_name(name).unwrap();
            chain(square, &Options { fold, form, lobes, ..Options::default() })
        });
        for level in LEVELS {
            let side = SIDE >> level;
            let mut random = Random::new(seed, level as u64);
            let [x, y] = [(); 2].map(|()| (random.uniform() * side as f64) as usize);
            let footprint = Footprint::of_texel(square, Reading::default(), 1, level, (x, y));
            let mut lobes: Vec<Lobe> = chains.iter().map(|chain| chain.levels[level - 1].lobes.at(x, y)).collect();
            // Several starts, for there may be several minima: some folds, and the most alike of some texels.
            let error = Error::new(&footprint, &lobes, SEARCHED, Random::new(seed, 100));
            let starts = folds.iter().zip(&lobes).filter(|(fold, _)| STARTS.contains(&fold.name));
            let found: Vec<Lobe> = starts.map(|(_, lobe)| error.best(form, *lobe)).collect();
            let mut inside = |at: usize| (at << level) + (random.uniform() * (1 << level) as f64) as usize;
            let texels: Vec<Lobe> = (0..TEXELS).map(|_| base.at(inside(x), inside(y))).collect();
            let texel = texels.into_iter().min_by(|a, b| error.of(a).total_cmp(&error.of(b))).unwrap();
            let error = Error::new(&footprint, &[texel], SEARCHED, Random::new(seed, 100));
            lobes.extend(found);
            lobes.push(error.best(form, texel));
            let error = Error::new(&footprint, &lobes, JUDGED, Random::new(seed, 200));
            let mut errors: Vec<f64> = lobes.iter().map(|lobe| error.of(lobe)).collect();
            let best = errors.iter().copied().fold(f64::MAX, f64::min);
            errors.truncate(folds.len());
            errors.push(best);
            for chain in &mixtures {
                let mixture = chain.levels[level - 1].lobes.mixture(x, y);
                let mixture: Vec<(Lobe, f64)> = mixture.map(|(lobe, weight)| (lobe, f64::from(weight))).collect();
                errors.push(error.of_mixture(&mixture));
            }
            cases.push(Case { map, alpha, form, errors });
        }
    }
    cases
}

fn material(folder: &std::path::Path) -> (Material, bool) {
    let file =
        |stem: &str| ["jpg", "png"].map(|end| folder.join(format!("{stem}.{end}"))).into_iter().find(|f| f.exists());
    let roughness = file("roughness").map(|path| RoughnessInput::Roughness(ChannelRef { path, channel: None }));
    let own = roughness.is_some();
    let inputs = Inputs {
        normal: file("normal"),
        roughness: roughness.unwrap_or(RoughnessInput::Constant(PerceptualRoughness(0.5))),
        ..Inputs::default()
    };
    (load(&inputs).unwrap(), own)
}

/// Mean over cases of the error of a contender.
fn mean(cases: &[&Case], of: impl Fn(&Case) -> f64) -> f64 {
    cases.iter().map(|case| of(case)).sum::<f64>() / cases.len() as f64
}

/// Judges some squares of each map, prints a table, and checks it.
fn compare(maps: &[&str], alphas: &[Option<f32>], squares: usize) {
    let Some(textures) = common::textures() else { return };
    let cases: Vec<Case> = maps
        .iter()
        .enumerate()
        .flat_map(|(map, name)| {
            let (material, own) = material(&textures.join(name));
            let size = material.size();
            let jobs: Vec<(usize, usize)> = (0..alphas.len())
                .filter(|alpha| own || alphas[*alpha].is_some())
                .flat_map(|alpha| (0..squares).map(move |square| (alpha, square)))
                .collect();
            let cases: Vec<Case> = jobs
                .into_par_iter()
                .flat_map_iter(|(alpha, square)| {
                    let seed = (map * squares + square) as u64;
                    let mut random = Random::new(seed, 50);
                    let mut place = |side: usize| (random.uniform() * (side / SIDE) as f64) as usize * SIDE;
                    let corner = (place(size.width), place(size.height));
                    judge(&Square { material: &material, alpha: alphas[alpha], corner }, map, alpha, seed)
                })
                .collect();
            cases
        })
        .collect();
    let mut faults = Vec::new();
    for form in FORMS {
        let folds = contenders(form);
        let index = |name: &str| folds.iter().position(|fold| fold.name == name).unwrap();
        let (ggx, search, best) = (index("ggx"), index("ggx-lobe"), folds.len());
        let best_formula = |cases: &[&Case]| {
            let formulas = (0..folds.len()).filter(|i| !folds[*i].searches());
            formulas.min_by(|a, b| mean(cases, |c| c.errors[*a]).total_cmp(&mean(cases, |c| c.errors[*b]))).unwrap()
        };
        println!(
            "\n| {form:?}: alpha | best formula of moments | `ggx` | `ggx-lobe` | best lobe |{} |\n|---|---|---|---|---{}|",
            MIXTURES.map(|(name, lobes, _)| format!(" `{name}`, {lobes} lobes")).join(" |"),
            "|---".repeat(MIXTURES.len())
        );
        for (i, alpha) in alphas.iter().enumerate() {
            let of = |keep: &dyn Fn(&Case) -> bool| -> Vec<&Case> {
                cases.iter().filter(|case| case.form == form && case.alpha == i && keep(case)).collect()
            };
            let all = of(&|_| true);
            let formula = best_formula(&all);
            let error = |k: usize| mean(&all, |case| case.errors[k]);
            let [f, g, s, b] = [formula, ggx, search, best].map(error);
            let mixtures: [f64; MIXTURES.len()] = std::array::from_fn(|k| error(best + 1 + k));
            let name = alpha.map_or("the map's".into(), |alpha| alpha.to_string());
            println!(
                "| {name} | {f:.4} (`{}`) | {g:.4} ({:.3}) | {s:.4} ({:.3}) | {b:.4} | {} |",
                folds[formula].name,
                g / b,
                s / b,
                mixtures.map(|error| format!("{error:.4} ({:.3})", error / b)).join(" | ")
            );
            let mut expect = |what: &str, good: bool| {
                if !good {
                    faults.push(format!("{form:?}, alpha {name}: {what}"));
                }
            };
            expect(&format!("ggx is {:.3} of the best", g / b), g <= 1.15 * b);
            for ((name, lobes, most), error) in MIXTURES.into_iter().zip(mixtures) {
                let most = most[usize::from(alpha.is_none())];
                expect(&format!("{lobes} lobes of {name} are {:.3} of the best one", error / b), error <= most * b);
            }
            expect(&format!("ggx-lobe is {:.3} of the best", s / b), s <= 1.03 * b);
            for (map, name) in maps.iter().enumerate() {
                let cases = of(&|case| case.map == map);
                if cases.is_empty() {
                    continue;
                }
                let formula = best_formula(&cases);
                let difference = |case: &Case| case.errors[ggx] - 1.03 * case.errors[formula];
                let worse = mean(&cases, difference);
                let spread = mean(&cases, |case| (difference(case) - worse).powi(2));
                let deviation = (spread / (cases.len() - 1) as f64).sqrt();
                let ratio = mean(&cases, |case| case.errors[ggx]) / mean(&cases, |case| case.errors[formula]);
                let what = format!("on {name} ggx is {ratio:.3} of {}", folds[formula].name);
                expect(&what, worse <= deviation);
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
#[ignore = "a minute; .ci/run does it"]
fn sample_of_maps() {
    compare(&["bark014", "tiles107", "brushed_metal009"], &[Some(0.1), Some(0.4)], 2);
}

#[test]
#[ignore = "twelve minutes"]
fn all_maps() {
    const MAPS: [&str; 10] = [
        "bark014",
        "brushed_metal009",
        "chainmail004",
        "metal027",
        "paper001",
        "rock058",
        "tiles107",
        "fabric_knitted_006",
        "scratched_gold",
        "copper_tiles_01",
    ];
    compare(&MAPS, &[Some(0.05), Some(0.1), Some(0.2), Some(0.4), None], 3);
}
