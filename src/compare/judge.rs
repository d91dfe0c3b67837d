//! The judge.

use std::f64::consts::SQRT_2;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::measure::{Counts, Figures, Questions, diffuse_lights};
use super::score::{ChainScore, Energy, Judgement, LevelScore, Place, Summary, WorstTexel};
use crate::error::{Error, Result};
use crate::image::Size;
use crate::material::Texels;
use crate::ndf::Lobes;
use crate::reference::{Footprint, Means, Random, Reading};

/// A mip chain to be judged.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// For reports and messages.
    pub name: String,
    /// How it was folded, if that is known.
    pub fold: Option<String>,
    /// Level 0 first; sizes as [`Size::level`]. A chain may stop before 1x1.
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
    /// so large that a level would cost more than [`LOBES_A_LEVEL`] lobes, fewer are, but never less than two.
    pub texels: usize,
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
        Self { texels: 64, directions: 80, reading: Reading::default(), levels: Vec::new(), seed: 1 }
    }
}

/// Lobes that are read for one level, at most, unless two texels need more. A 2048x2048 material has 4 million: its
/// coarsest levels are judged by two texels or by their only one.
pub const LOBES_A_LEVEL: usize = 1 << 21;

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
/// A chain without levels, or one whose level 0 or other levels do not have the sizes of the base's.
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
        }
    }
    Ok(())
}

/// The texels to judge: all of a level, or one anywhere in each cell of a grid.
fn places(base: Size, level: usize, settings: &Settings) -> Vec<Place> {
    let size = base.level(level);
    let footprint = base.texels().div_ceil(size.texels()).min(settings.reading.most_texels.unwrap_or(usize::MAX));
    let most = settings.texels.min(LOBES_A_LEVEL / footprint.max(1)).max(2.min(settings.texels)).max(1);
    if most >= size.texels() {
        return (0..size.texels()).map(|i| Place { x: i % size.width, y: i / size.width }).collect();
    }
    let shape = (most as f64 * size.width as f64 / size.height as f64).sqrt().round() as usize;
    let columns = shape.clamp(most.div_ceil(size.height), size.width.min(most)).max(1);
    let rows = (most / columns).clamp(1, size.height);
    let mut random = Random::new(settings.seed, level as u64);
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
        Footprint::of_texel(self.base, self.settings.reading, self.level, place.x, place.y)
    }

    /// Lobes times half vectors, and a little for what does not depend on the footprint.
    fn work(&self) -> usize {
        self.places.iter().map(|place| self.texel_work(*place)).sum()
    }

    fn texel_work(&self, place: Place) -> usize {
        (self.truth(place).lobes() + 64) * self.counts.queries(self.chains.len())
    }

    /// One score a chain.
    fn judge(&self, advance: &(dyn Fn(usize) + Sync)) -> Vec<LevelScore> {
        let figures: Vec<Vec<Figures>> = self
            .places
            .par_iter()
            .with_max_len(1)
            .map(|place| {
                let figures = self.judge_texel(*place);
                advance(self.texel_work(*place));
                figures
            })
            .collect();
        (0..self.chains.len())
            .map(|chain| self.score(&figures.iter().map(|texel| texel[chain]).collect::<Vec<_>>()))
            .collect()
    }

    fn judge_texel(&self, place: Place) -> Vec<Figures> {
        let truth = self.truth(place);
        let lobe = |chain: &&Candidate| chain.levels[self.level].at(place.x, place.y);
        let own: Vec<_> = self.chains.iter().map(|chain| Footprint::of_lobes(&[(lobe(chain), 1.0)])).collect();
        let stream = ((self.level as u64 + 1) << 48) ^ ((place.y as u64) << 24) ^ place.x as u64;
        let random = [stream, !stream].map(|stream| Random::new(self.settings.seed, stream));
        let questions = Questions::new(&truth, &own, self.counts, random);
        let lights = diffuse_lights();
        let groups = truth.means(&questions.queries, &lights);
        let all: Vec<&Means> = groups.iter().collect();
        let answers = Means::merged(&all);
        // Two ways to halve the groups of a subset.
        let half = |side: fn(usize) -> bool| {
            let kept: Vec<&Means> = all.iter().enumerate().filter(|(i, _)| side(*i)).map(|(_, means)| *means).collect();
            Means::merged(&kept)
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
        let summary = |i: usize| Summary::of(&column(i), share);
        let mean = |f: &dyn Fn(&Figures) -> f64| figures.iter().map(f).sum::<f64>() / figures.len() as f64;
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
                views: (0..5).map(|view| mean(&|f| f.view_energy[view])).collect(),
            },
            diffuse_error: summary(7),
            worst: order.iter().take(WORST).map(worst).collect(),
            median_texel: self.places[order[order.len() / 2]],
        }
    }
}

/// What the choice of a footprint's texels does to the figures, judged by `halves` of it. The distance to a noisy mean
/// is too large by a bias that falls as one over the root of the number of texels, so that a half has sqrt(2) times as
/// much: it is taken off, and counts as error together with the spread, of which halves have sqrt(2) times as much too.
fn allow_for_choice(figures: &mut Figures, mut halves: Vec<Figures>) {
    if halves.is_empty() {
        return;
    }
    let n = halves.len() as f64;
    for (i, (whole, variance)) in figures.estimates().into_iter().enumerate() {
        let values: Vec<f64> = halves.iter_mut().map(|figures| figures.estimates()[i].0).collect();
        let mean = values.iter().sum::<f64>() / n;
        let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let bias = (mean - *whole) / (SQRT_2 - 1.0);
        *whole = (*whole - bias).max(0.0);
        *variance += 0.5 * spread + bias * bias;
    }
}
