//! Would another tail than GGX's be better? Best lobes of each kind against the footprints of real maps.
#![allow(clippy::print_stdout)]

mod common;

use std::path::Path;

use glam::{DVec3, Vec3};
use mipfold::fold::{Tail, best_student};
use mipfold::image::span;
use mipfold::material::{Inputs, Material, RoughnessInput, Texels, load};
use mipfold::ndf::{Lobe, Ndf, Student, TailExponent};
use mipfold::random::{Random, Spread};
use mipfold::reference::{Diffuse, Footprint, Queries};
use mipfold::roughness::{Alpha, PerceptualRoughness};
use rayon::prelude::*;

const LEVELS: [usize; 3] = [2, 4, 6];
const ALPHAS: [f32; 4] = [0.05, 0.1, 0.2, 0.4];
/// Texels of a level.
const TEXELS: usize = 12;
/// Normals by which a total variation is measured: for one texel its standard error is below 0.5 / sqrt(2000) = 0.011.
const DRAWS: usize = 2000;

/// The texels under one of a level, those that can be used, all of one width.
fn footprint(material: &Material, alpha: f32, level: usize, (x, y): (usize, usize)) -> Vec<(Lobe, f64)> {
    let (size, target) = (material.size(), material.size().level(level));
    let (x, y) = (span(size.width, target.width, x), span(size.height, target.height, y));
    let mut planes = vec![vec![0.0; x.weights.len()]; 4];
    let mut lobes = Vec::new();
    for (j, wy) in y.weights.iter().enumerate() {
        let [nx, ny, nz, coverage] = &mut planes[..] else { unreachable!("four planes") };
        material.normals(y.first + j, x.first, [&mut *nx, &mut *ny, &mut *nz], coverage);
        for (i, wx) in x.weights.iter().enumerate().filter(|(i, _)| coverage[*i] > 0.0) {
            let lobe = Lobe::isotropic(Vec3::new(nx[i], ny[i], nz[i]), Alpha(alpha));
            lobes.push((lobe, f64::from(wx * wy)));
        }
    }
    lobes
}

/// Normals of a footprint, with their densities there: one estimate for every lobe that is compared.
struct Truth {
    normals: Vec<DVec3>,
    /// Footprint NDF.
    density: Vec<f64>,
    /// What a normal stands for.
    share: Vec<f64>,
}

impl Truth {
    fn new(lobes: &[(Lobe, f64)], random: &mut Random) -> Self {
        let footprint = Footprint::of_lobes(lobes);
        let (mut queries, mut spread) = (Queries::default(), Spread::new(random));
        queries.start_view(DVec3::Z);
        let mut normals: Vec<_> = (0..DRAWS).map(|_| footprint.draw(spread.point())).collect();
        normals.retain(|m| m.z > 0.0);
        normals.iter().for_each(|m| queries.push_half(*m));
        let means = footprint.means(&queries, &Diffuse::default()).swap_remove(0);
        let share: Vec<f64> =
            normals.iter().zip(means.d.iter().zip(&means.pdf)).map(|(m, (d, pdf))| d * m.z / pdf).collect();
        let total: f64 = share.iter().sum();
        Self { normals, density: means.d, share: share.into_iter().map(|share| share / total).collect() }
    }

    /// `integral of max(0, D - D_lobe) (m . z)`, which is half of that of the absolute difference.
    fn total_variation(&self, lobe: &Student) -> f64 {
        let up = f64::from(lobe.normal.z);
        let one = |((m, d), share): ((&DVec3, &f64), &f64)| share * (1.0 - lobe.d(*m) / up / d).max(0.0);
        self.normals.iter().zip(&self.density).zip(&self.share).map(one).sum()
    }

    /// The least that a lobe of this tail reaches in other widths of the same proportions.
    fn least(&self, lobe: &Student, tail: TailExponent) -> f64 {
        let at = |log: f64| {
            let roughness = lobe.roughness * (2.0 * log).exp() as f32;
            self.total_variation(&Student { roughness, tail, ..*lobe })
        };
        // A coarse scan, since there may be several minima, then finer ones about the best.
        let (mut best, mut step) = ((at(0.0), 0.0), 0.25);
        for centre in (-6..=6).map(|i| f64::from(i) * step) {
            best = if at(centre) < best.0 { (at(centre), centre) } else { best };
        }
        while step > 0.02 {
            step *= 0.5;
            for centre in [best.1 - step, best.1 + step] {
                best = if at(centre) < best.0 { (at(centre), centre) } else { best };
            }
        }
        best.0
    }
}

/// Of one texel: total variations, and the exponent that fits best.
#[derive(Clone, Copy, Default)]
struct Texel {
    ggx: f64,
    free: f64,
    /// Of the best width for this very figure: Beckmann, GGX, the best of a row of tails.
    least: [f64; 3],
    tail: f64,
}

fn texel(lobes: &[(Lobe, f64)], mut random: Random) -> Texel {
    let truth = Truth::new(lobes, &mut random);
    let ggx = best_student(lobes, Tail::Fixed(TailExponent::GGX));
    let free = best_student(lobes, Tail::Free);
    let tails = [1.6, 1.8, 2.0, 2.5, 3.0, 4.0, 8.0, f32::INFINITY].map(|tail| truth.least(&ggx, TailExponent(tail)));
    Texel {
        ggx: truth.total_variation(&ggx),
        free: truth.total_variation(&free),
        least: [tails[7], tails[2], tails.into_iter().fold(f64::MAX, f64::min)],
        tail: f64::from(free.tail.0),
    }
}

fn material(normal: &Path) -> Material {
    load(&Inputs {
        normal: Some(normal.into()),
        roughness: RoughnessInput::Constant(PerceptualRoughness(0.5)),
        ..Inputs::default()
    })
    .unwrap()
}

/// A row of a table: means, and the middle exponent.
fn row(name: &str, texels: &[Texel]) {
    let mean = |f: &dyn Fn(&Texel) -> f64| texels.iter().map(f).sum::<f64>() / texels.len() as f64;
    let mut tails: Vec<f64> = texels.iter().map(|texel| texel.tail).collect();
    tails.sort_by(f64::total_cmp);
    let (ggx, free) = (mean(&|t| t.ggx), mean(&|t| t.free));
    let least = [0, 1, 2].map(|i| mean(&|t: &Texel| t.least[i]));
    println!(
        "| {name} | {:.1} | {ggx:.3} | {free:.3} | {:+.0} % | {} |",
        tails[tails.len() / 2],
        100.0 * (free / ggx - 1.0),
        least.map(|v| format!("{v:.3}")).join(" | ")
    );
}

/// `cargo test --test tails -- --ignored --nocapture`
#[test]
#[ignore = "minutes; its figures are in the README"]
fn what_another_tail_would_gain_on_real_maps() {
    let Some(textures) = common::textures() else { return };
    const MAPS: [&str; 11] = [
        "rock058",
        "bark014",
        "fabric_knitted_006",
        "fabric_pattern_07",
        "metal027",
        "brushed_metal009",
        "scratched_gold",
        "carpaint_flakes",
        "tiles107",
        "chainmail004",
        "paper001",
    ];
    let head = "gamma | GGX | free tail | change | least Beckmann | least GGX | least of any tail |";
    let mut all = Vec::new();
    for name in MAPS {
        let file = ["normal.jpg", "normal.png"].map(|file| textures.join(name).join(file));
        let material = material(file.iter().find(|file| file.exists()).unwrap());
        let mut cases = Vec::new();
        for alpha in ALPHAS {
            for level in LEVELS {
                let size = material.size().level(level);
                let mut random = Random::new(1, level as u64);
                cases.extend((0..TEXELS).map(|i| {
                    let mut pick = |n: usize| ((random.uniform() * n as f64) as usize).min(n - 1);
                    let place = (pick(size.width), pick(size.height));
                    (alpha, level, place, Random::new(2, (i + 100 * level) as u64))
                }));
            }
        }
        let measured: Vec<(f32, usize, Texel)> = cases
            .into_par_iter()
            .map(|(alpha, level, place, random)| {
                (alpha, level, texel(&footprint(&material, alpha, level, place), random))
            })
            .collect();
        all.push((name, measured));
    }
    let table = |title: &str, rows: &[(String, Vec<Texel>)]| {
        println!("\n| {title} | {head}\n|{}", "---|".repeat(8));
        rows.iter().for_each(|(name, texels)| row(name, texels));
    };
    let of = |keep: &dyn Fn(&str, f32, usize) -> bool| -> Vec<Texel> {
        let texels = all.iter().flat_map(|(name, measured)| measured.iter().map(move |(a, l, t)| (*name, *a, *l, *t)));
        texels.filter(|(name, a, l, _)| keep(name, *a, *l)).map(|(.., t)| t).collect()
    };
    for alpha in ALPHAS {
        let rows: Vec<_> =
            all.iter().map(|(name, _)| ((*name).to_owned(), of(&|n, a, _| n == *name && a == alpha))).collect();
        table(&format!("alpha {alpha}"), &rows);
    }
    let rows: Vec<_> = ALPHAS
        .iter()
        .flat_map(|alpha| {
            LEVELS.map(|level| (format!("alpha {alpha}, level {level}"), of(&|_, a, l| a == *alpha && l == level)))
        })
        .chain(ALPHAS.map(|alpha| (format!("alpha {alpha}"), of(&|_, a, _| a == alpha))))
        .collect();
    table("all", &rows);
    // The widest choice is never worse than a part of it.
    assert!(all.iter().flat_map(|(_, m)| m).all(|(.., t)| t.least[2] <= t.least[0].min(t.least[1])));
}
