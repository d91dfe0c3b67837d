//! The judge.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::measure::{Counts, Figures, Questions, VIEWS, diffuse_lights};
use super::score::{ChainScore, Energy, Judgement, LevelScore, Place, Summary, WorstTexel};
use crate::error::{Error, Result};
use crate::image::Size;
use crate::material::Texels;
use crate::ndf::{Lobe, Lobes, are_shares};
use crate::random::Random;
use crate::reference::{Footprint, Means, Reading};

/// A mip chain to be judged.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// For reports and messages.
    pub name: String,
    /// How it was folded, if that is known.
    pub fold: Option<String>,
    /// Level 0 first; sizes as [`Size::level`]. A chain may stop before 1x1. Each level has the number of lobes that it
    /// likes: usually level 0 has one, and the others as many as they were folded to.
    pub levels: Vec<Lobes>,
}

impl Candidate {
    /// A chain that somebody else made.
    pub fn new(name: impl Into<String>, levels: Vec<Lobes>) -> Self {
        Self { name: name.into(), fold: None, levels }
    }
}

/// How closely the judge looks.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Settings {
    /// Texels judged in each level, at most; a seeded stratified choice where the level has more. Where footprints are
    /// so large that a level would cost more than [`LOBES_A_LEVEL`] lobes, fewer are, but never less than two. All of
    /// them, at any cost, if `None`.
    pub texels: Option<usize>,
    /// Half vectors drawn from each footprint, over all views; each chain's lobe adds half as many.
    pub directions: usize,
    /// How footprints are read.
    pub reading: Reading,
    /// Levels to judge; all if empty.
    pub levels: Vec<usize>,
    /// Of every choice.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { texels: Some(64), directions: 80, reading: Reading::default(), levels: Vec::new(), seed: 1 }
    }
}

/// Lobes that are read for one level, at most, unless two texels need more. A 2048x2048 material has 4 million: its
/// coarsest levels are judged by two texels or by their only one.
pub const LOBES_A_LEVEL: usize = 1 << 21;

/// What random numbers of a texel are for; a footprint's own choice is 1.
const FROM_TRUTH: u64 = 2;
const FROM_CHAIN: u64 = 3;
const PLACES: u64 = 4;

/// Texels that are listed as the worst of a level.
const WORST: usize = 8;

/// Judges one chain, and tells no progress.
///
/// # Errors
/// As [`judge`].
pub fn judge_one(base: &dyn Texels, chain: Candidate, settings: &Settings) -> Result<ChainScore> {
    Ok(judge(base, &[chain], settings, &|_| ())?.chains.swap_remove(0))
}

/// Judges chains of one surface. `done` is called with the share of the work that is done, 0 to 1, from any thread.
///
/// Figures depend on the base, the chain and the settings alone: not on other chains, nor on the number of threads.
///
/// # Errors
/// A chain without levels, or one whose level 0 or other levels do not have the sizes of the base's; a lobe that is none:
/// not finite, without width, or not facing out of the surface (of weight 0 too, for filtering reads it); weights below 0,
/// or that do not sum to 1 ([`are_shares`]).
pub fn judge(
    base: &dyn Texels,
    chains: &[Candidate],
    settings: &Settings,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Judgement> {
    let size = base.size();
    check(size, chains)?;
    let longest = chains.iter().map(|chain| chain.levels.len()).max().unwrap_or(0);
    let wanted = |level: &usize| settings.levels.is_empty() || settings.levels.contains(level);
    let bench: Vec<Bench> = (0..longest)
        .filter(wanted)
        .map(|level| {
            let chains = chains.iter().filter(|chain| level < chain.levels.len()).collect();
            let places = places(size, level, settings);
            Bench { base, settings, counts: Counts::new(settings.directions), level, chains, places }
        })
        .collect();
    let work: usize = bench.iter().map(Bench::work).sum();
    let (finished, tell) = (AtomicUsize::new(0), done);
    let advance = |texel: usize| {
        let finished = finished.fetch_add(texel, Ordering::Relaxed) + texel;
        tell(finished as f64 / work as f64);
    };
    let mut scores: Vec<ChainScore> = chains
        .iter()
        .map(|chain| ChainScore {
            name: chain.name.clone(),
            fold: chain.fold.clone(),
            lobes: chain.levels[0].form(),
            count: chain.levels.iter().map(Lobes::count).max().unwrap_or(1),
            levels: Vec::new(),
        })
        .collect();
    for bench in &bench {
        let mut levels = bench.judge(&advance).into_iter();
        let judged = scores.iter_mut().zip(chains).filter(|(_, chain)| bench.level < chain.levels.len());
        judged.for_each(|(score, _)| score.levels.extend(levels.next()));
    }
    Ok(Judgement { size, chains: scores })
}

fn check(size: Size, chains: &[Candidate]) -> Result<()> {
    for chain in chains {
        if chain.levels.is_empty() {
            return Err(Error::invalid_option(&chain.name, "no levels", "a chain with level 0 at least"));
        }
        for (k, level) in chain.levels.iter().enumerate() {
            let (found, expected) = (level.size(), size.level(k));
            if found != expected || k >= size.level_count() {
                let expected = if k < size.level_count() { expected.to_string() } else { "no further level".into() };
                let expected = format!("{expected}, for the base is {size}");
                return Err(Error::invalid_option(&chain.name, format!("level {k} of {found}"), expected));
            }
            let places = (0..found.texels()).into_par_iter().map(|i| (i % found.width, i / found.width));
            let fault = |(x, y)| fault(level, x, y).map(|fault| (x, y, fault));
            if let Some((x, y, (found, expected))) = places.find_map_first(fault) {
                let found = format!("{found} in level {k}, column {x}, row {y}");
                return Err(Error::invalid_option(&chain.name, found, expected));
            }
        }
    }
    Ok(())
}

/// What is wrong with a texel, and what would be right.
fn fault(level: &Lobes, x: usize, y: usize) -> Option<(String, &'static str)> {
    let slots = || (0..level.count()).map(|j| level.slot(j, x, y));
    if let Some((lobe, _)) = slots().find(|(lobe, _)| !is_lobe(lobe)) {
        return Some((format!("{lobe:?}"), "a normal that faces out, and finite widths"));
    }
    let weights = || slots().map(|(_, weight)| weight);
    (!are_shares(weights()))
        .then(|| (format!("weights {:?}", weights().collect::<Vec<_>>()), "weights from 0 up that sum to 1"))
}

/// A normal with a direction out of the surface, of any length, and a tensor with squared widths from 0 up.
fn is_lobe(Lobe { normal, roughness: r }: &Lobe) -> bool {
    let finite = normal.is_finite() && r.xx.is_finite() && r.xy.is_finite() && r.yy.is_finite();
    finite && normal.z > 0.0 && r.xx >= 0.0 && r.yy >= 0.0
}

/// The texels to judge: all of a level, or one anywhere in each cell of a grid.
fn places(base: Size, level: usize, settings: &Settings) -> Vec<Place> {
    let size = base.level(level);
    let footprint = settings.reading.lobes(base.texels().div_ceil(size.texels()));
    let most = match settings.texels {
        None => size.texels(),
        Some(most) => most.min((LOBES_A_LEVEL / footprint).max(2)).max(1),
    };
    if most >= size.texels() {
        return (0..size.texels()).map(|i| Place { x: i % size.width, y: i / size.width }).collect();
    }
    let shape = (most as f64 * size.width as f64 / size.height as f64).sqrt().round() as usize;
    let columns = shape.clamp(most.div_ceil(size.height), size.width.min(most)).max(1);
    let rows = (most / columns).clamp(1, size.height);
    let mut random = Random::for_texel(settings.seed, PLACES, level, (0, 0));
    let mut place = |i: usize, n: usize, side: usize| {
        (((i as f64 + random.uniform()) * side as f64 / n as f64) as usize).min(side - 1)
    };
    (0..columns * rows)
        .map(|i| Place { x: place(i % columns, columns, size.width), y: place(i / columns, rows, size.height) })
        .collect()
}

/// One level on the judge's bench.
struct Bench<'a> {
    base: &'a dyn Texels,
    settings: &'a Settings,
    counts: Counts,
    level: usize,
    /// Those that have the level.
    chains: Vec<&'a Candidate>,
    places: Vec<Place>,
}

impl Bench<'_> {
    fn truth(&self, place: Place) -> Footprint<'_> {
        Footprint::of_texel(self.base, self.settings.reading, self.settings.seed, self.level, (place.x, place.y))
    }

    /// Lobes times half vectors, and a little for what does not depend on the footprint.
    fn work(&self) -> usize {
        self.places.len() * self.texel_work()
    }

    fn texel_work(&self) -> usize {
        let texels = self.base.size().texels().div_ceil(self.base.size().level(self.level).texels());
        (self.settings.reading.lobes(texels) + 64) * self.counts.queries(self.chains.len())
    }

    /// One score a chain.
    fn judge(&self, advance: &(dyn Fn(usize) + Sync)) -> Vec<LevelScore> {
        let figures: Vec<Vec<Figures>> = self
            .places
            .par_iter()
            .with_max_len(1)
            .map(|place| {
                let figures = self.judge_texel(*place);
                advance(self.texel_work());
                figures
            })
            .collect();
        (0..self.chains.len())
            .map(|chain| self.score(&figures.iter().map(|texel| texel[chain]).collect::<Vec<_>>()))
            .collect()
    }

    fn judge_texel(&self, place: Place) -> Vec<Figures> {
        let truth = self.truth(place);
        let own: Vec<_> = self
            .chains
            .iter()
            .map(|chain| {
                let lobes = chain.levels[self.level].mixture(place.x, place.y);
                Footprint::of_lobes(&lobes.map(|(lobe, weight)| (lobe, f64::from(weight))).collect::<Vec<_>>())
            })
            .collect();
        let stream = |purpose| Random::for_texel(self.settings.seed, purpose, self.level, (place.x, place.y));
        let random = [stream(FROM_TRUTH), stream(FROM_CHAIN)];
        let questions = Questions::new(&truth, &own, self.counts, random);
        let lights = diffuse_lights();
        let groups = truth.means(&questions.queries, &lights);
        let all: Vec<&Means> = groups.iter().collect();
        let answers = Means::merged(&all);
        // Two ways to halve the groups of a subset.
        let half = |side: fn(usize) -> bool| {
            let kept: Vec<&Means> = all.iter().enumerate().filter(|(i, _)| side(*i)).map(|(_, means)| *means).collect();
            // The half vectors were drawn from the whole.
            Means { pdf: answers.pdf.clone(), ..Means::merged(&kept) }
        };
        let halves: Vec<Means> = if groups.len() < 4 {
            Vec::new()
        } else {
            vec![half(|i| i % 2 == 0), half(|i| i % 2 == 1), half(|i| i % 4 < 2), half(|i| i % 4 >= 2)]
        };
        let judge = |(chain, own): (usize, &Footprint)| {
            let own = own.means(&questions.queries, &lights).swap_remove(0);
            let mut figures = questions.figures(&answers, &own, chain);
            let partial: Vec<Figures> = halves.iter().map(|answers| questions.figures(answers, &own, chain)).collect();
            allow_for_choice(&mut figures, partial);
            figures
        };
        own.iter().enumerate().map(judge).collect()
    }

    fn score(&self, figures: &[Figures]) -> LevelScore {
        let size = self.base.size().level(self.level);
        let share = figures.len() as f64 / size.texels() as f64;
        let column = |i: usize| figures.iter().map(|f| *f.clone().estimates()[i]).collect::<Vec<_>>();
        let bias = |i: usize| figures.iter().map(|f| f.biases[i]).sum::<f64>() / figures.len() as f64;
        let summary = |i: usize| Summary::of(&column(i), share, bias(i));
        let reflected = |view: usize, side: usize| figures.iter().map(|f| f.view_energy[view][side]).sum::<f64>();
        let mut order: Vec<usize> = (0..figures.len()).collect();
        order.sort_by(|&a, &b| figures[b].lobe.0.total_cmp(&figures[a].lobe.0));
        let worst = |&i: &usize| {
            let Place { x, y } = self.places[i];
            WorstTexel { x, y, lobe_error: figures[i].lobe.0 }
        };
        let energy = summary(5);
        LevelScore {
            level: self.level,
            width: size.width,
            height: size.height,
            samples: figures.len(),
            lobe_error: summary(0),
            lobe_error_light: summary(1),
            ndf_tv: summary(2),
            ndf_hellinger: summary(3),
            ndf_kl: summary(4),
            energy: Energy {
                mean: energy.mean,
                stderr: energy.stderr,
                compensated: summary(6).mean,
                views: (0..VIEWS.len()).map(|view| reflected(view, 0) / reflected(view, 1)).collect(),
            },
            diffuse_error: summary(7),
            worst: order.iter().take(WORST).map(worst).collect(),
            median_texel: self.places[order[order.len() / 2]],
        }
    }
}

/// What the choice of a footprint's texels does to the figures, judged by `halves` of it: two ways to cut it in two. A
/// distance to a noisy mean is too large by a bias that falls as one over the number of texels, so that a half has twice
/// as much. It is taken off, and kept in `bias`; the spread is added to the variance.
fn allow_for_choice(figures: &mut Figures, mut halves: Vec<Figures>) {
    if halves.is_empty() {
        return;
    }
    let n = halves.len() as f64;
    let mut biases = [0.0; 8];
    for (i, (whole, variance)) in figures.estimates().into_iter().enumerate() {
        let values: Vec<f64> = halves.iter_mut().map(|figures| figures.estimates()[i].0).collect();
        let mean = values.iter().sum::<f64>() / n;
        biases[i] = mean - *whole;
        let corrected = *whole - biases[i];
        // Not `max`, which would make a perfect 0 of what is not a number.
        *whole = if corrected < 0.0 { 0.0 } else { corrected };
        // Halves have variance 2 s^2, and two that make up the whole lie as far on either side of it: the squares about
        // the mean of two such pairs sum to 4 s^2.
        *variance += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4.0;
    }
    figures.biases = biases;
}
