//! The one loop over levels.
//!
//! Every level is folded from the exact footprint of level 0. As long as both sides halve exactly, a coarser
//! level's footprints are unions of the finer one's, so moments are merged 2x2, row by row, in tiles that stay in the
//! cache, and only the top is kept. Beyond that, a level is merged from the coarsest kept level whose footprints
//! nest in its own, or else from the texels, with fractional weights at the borders.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::{DEFAULT_FOLD, Fold, Level, Method, curvature, level::Band, slots};
use crate::image::{Size, spans};
use crate::material::Texels;
use crate::moments::{Block, Layout, Needs, Quads, Scratch, TexelRows, UNUSABLE_WEIGHT, reduce_rows};
use crate::ndf::{Form, Lobes};
use crate::roughness::Alpha;
use crate::summary::{self, Summaries};

/// Levels that one pass over the texels folds: bands of 64 rows are enough to keep many cores busy.
const TRUNK_LEVELS: usize = 6;

/// Texels in a row of a tile: two rows of every level, of some ten planes, are 160 KiB, which a core's own cache
/// holds. A multiple of `2^TRUNK_LEVELS`.
const TILE_WIDTH: usize = 1024;

/// What to fold, and how.
#[derive(Clone, Copy)]
pub struct Options {
    /// The method.
    pub fold: &'static Fold,
    /// One width or two. A method without an anisotropic form gives one.
    pub form: Form,
    /// Lobes a texel, 1 to [`crate::ndf::MOST_LOBES`].
    pub lobes: usize,
    /// Whether the lobes of a texel differ in width alone: what engines with one normal and two roughnesses shade.
    pub shared_normal: bool,
    /// Share of what the fold adds to the mean alpha^2: 0 nothing, 1 all of it; more exaggerates. `average` adds nothing.
    pub strength: f32,
    /// Whether a lobe's squared width, or the mean of both, is at least that of the mean perceptual roughness. Folds that
    /// search may otherwise follow the smooth texels of a footprint of smooth and rough ones.
    pub at_least_average: bool,
    /// Smallest width written in any level but the first.
    pub min_alpha: Alpha,
    /// Largest width written in any level but the first.
    pub max_alpha: Alpha,
    /// Whether to keep the raw slope moments too.
    pub slope_moments: bool,
    /// Whether to keep the length of the mean normal too.
    pub mean_length: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            fold: DEFAULT_FOLD,
            form: Form::Isotropic,
            lobes: 1,
            shared_normal: false,
            strength: 1.0,
            at_least_average: false,
            min_alpha: Alpha(0.0),
            max_alpha: Alpha(1.0),
            slope_moments: false,
            mean_length: false,
        }
    }
}

/// The levels below the first; level 0 is the material's own texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Size of level 0.
    pub size: Size,
    /// Levels 1, 2, ... down to 1x1; empty for a 1x1 material.
    pub levels: Vec<Level>,
}

impl Chain {
    /// All levels as lobes, level 0, which is `base`, first: what a renderer or a judge takes.
    pub fn into_lobes(self, base: Lobes) -> Vec<Lobes> {
        std::iter::once(base).chain(self.levels.into_iter().map(|level| level.lobes)).collect()
    }
}

/// Folds all levels of a material, in parallel; the result does not depend on the number of threads.
pub fn chain(texels: &dyn Texels, options: &Options) -> Chain {
    chain_telling(texels, options, &|_| ())
}

/// [`chain`], with `done` called with the share of the work that is done, 0 to 1, row by row and from any thread: for folds
/// that search, and so take seconds.
pub fn chain_telling(texels: &dyn Texels, options: &Options, done: &(dyn Fn(f64) + Sync)) -> Chain {
    let size = texels.size();
    assert!(options.lobes == 1 || options.fold.has_mixtures(), "the fold gives one lobe a texel");
    let (needs, most) = match &options.fold.method {
        Method::Moments(fold) => (fold.needs, 0),
        Method::Lobes { most, .. } => (Needs::NORMAL, *most),
    };
    let needs = needs.and(if options.slope_moments { Needs::SLOPE_COV } else { Needs::NORMAL });
    let needs = if options.strength == 1.0 { needs } else { needs.and(Needs::TENSOR) };
    let needs = if options.at_least_average { needs.and(Needs::PERCEPTUAL) } else { needs };
    let layout = Layout::new(needs, !texels.is_anisotropic(), texels.extras());
    let count = size.level_count();
    let mut levels: Vec<_> = (1..count).map(|k| Level::zeros(options, size.level(k), texels.extras())).collect();
    let work: usize = levels.iter().map(|level| level.lobes.size().texels()).sum();
    let folded = AtomicUsize::new(0);
    let advance = |texels: usize| done((folded.fetch_add(texels, Ordering::Relaxed) + texels) as f64 / work as f64);
    let job = Job { texels, options, layout: &layout, most, size, advance: &advance };
    let trunk = halvings(size);
    let sources: Vec<_> = (0..count).map(|k| job.source(trunk, k)).collect();
    // What is known of the levels that a coarser level is merged from.
    let mut kept: Vec<Option<Kept>> = (0..count).map(|_| None).collect();
    let (halved, rest) = levels.split_at_mut(trunk);
    if trunk > 0 {
        kept[trunk] = job.fold_trunk(halved, sources.contains(&trunk));
    }
    for (k, level) in (trunk + 1..).zip(rest) {
        let keep = sources[k..].contains(&k);
        kept[k] = job.fold_level(level, kept[sources[k]].as_ref(), size.level(k), keep);
    }
    if options.lobes > 1 {
        slots::order(&mut levels);
    }
    if let Some(baked) = texels.curvature() {
        curvature::add(&mut levels, baked, options);
    }
    Chain { size, levels }
}

/// How many times both sides of `size` halve exactly, up to [`TRUNK_LEVELS`].
fn halvings(size: Size) -> usize {
    (size.width.trailing_zeros().min(size.height.trailing_zeros()) as usize).min(TRUNK_LEVELS)
}

struct Job<'a> {
    texels: &'a dyn Texels,
    options: &'a Options,
    layout: &'a Layout,
    /// Most lobes of a summary; 0 where the fold reads none.
    most: usize,
    size: Size,
    /// Told how many texels of any level were folded.
    advance: &'a (dyn Fn(usize) + Sync),
}

/// Moments of the texels of a level, and their summaries.
#[derive(Default)]
struct Kept {
    moments: Block,
    summaries: Summaries,
}

impl Kept {
    fn stack(layout: &Layout, rows: Vec<Kept>) -> Self {
        let (moments, summaries): (Vec<_>, Vec<_>) = rows.into_iter().map(|k| (k.moments, k.summaries)).unzip();
        Self { moments: Block::stack(layout, &moments), summaries: Summaries::stack(&summaries) }
    }
}

impl Job<'_> {
    /// The level that level `k > trunk` is merged from: the coarsest whose footprints nest in its own, or 0.
    fn source(&self, trunk: usize, k: usize) -> usize {
        let target = self.size.level(k);
        let nests = |j: &usize| {
            let source = self.size.level(*j);
            source.width.is_multiple_of(target.width) && source.height.is_multiple_of(target.height)
        };
        (trunk.max(1)..k).rev().find(nests).unwrap_or(0)
    }

    /// Lobes of a summary of level `k` of those that halve exactly.
    fn lobes(&self, k: usize) -> usize {
        self.most.min(1 << (2 * k).min(16))
    }

    /// Folds levels 1 to `levels.len()`, each as soon as two rows of the finer one are there. Returns what is known of the
    /// last if it is to be kept.
    fn fold_trunk(&self, levels: &mut [Level], keep: bool) -> Option<Kept> {
        let depth = levels.len();
        let top = self.size.level(depth);
        let mut bands: Vec<Vec<Band>> = (0..top.height).map(|_| Vec::with_capacity(depth)).collect();
        for (k, level) in levels.iter_mut().enumerate() {
            bands.iter_mut().zip(level.bands(1 << (depth - 1 - k))).for_each(|(bands, band)| bands.push(band));
        }
        let rows: Vec<Kept> = bands
            .into_par_iter()
            .enumerate()
            .map_init(Buffers::default, |buffers, (row, mut bands)| {
                let mut kept = Kept::default();
                kept.moments.resize(self.layout, if keep { top.width } else { 0 }, 1);
                kept.summaries.resize(if keep { top.width } else { 0 }, 1, self.lobes(depth));
                for x in (0..self.size.width).step_by(TILE_WIDTH) {
                    let width = TILE_WIDTH.min(self.size.width - x);
                    self.fold_tile(&mut bands, (x, row << depth), width, buffers);
                    if keep {
                        kept.moments.copy_columns(self.layout, &buffers.blocks[depth], x >> depth);
                        kept.summaries.copy_columns(&buffers.summaries[depth], x >> depth);
                    }
                }
                kept
            })
            .collect();
        keep.then(|| Kept::stack(self.layout, rows))
    }

    /// Folds the levels above `2^levels` rows of texels; two rows of each level are alive at a time. The single row
    /// of the last level is left in `buffers`.
    fn fold_tile(&self, bands: &mut [Band], (x, y): (usize, usize), width: usize, buffers: &mut Buffers) {
        let depth = bands.len();
        let Buffers { blocks, summaries, quads, joining, scratch } = buffers;
        blocks.resize_with(depth + 1, Block::default);
        summaries.resize_with(depth + 1, Summaries::default);
        for k in 0..=depth {
            let height = if k < depth { 2 } else { 1 };
            blocks[k].resize(self.layout, width >> k, height);
            summaries[k].resize(width >> k, height, self.lobes(k));
        }
        for row in 0..1 << depth {
            self.read_texels(x, y + row, &mut blocks[0], &mut summaries[0], row % 2, scratch);
            // An odd row completes a row of the next level, and that one perhaps another.
            for k in 0..(row + 1).trailing_zeros() as usize {
                let (fine, coarse) = blocks.split_at_mut(k + 1);
                let (coarse, at) = (&mut coarse[0], row >> (k + 1));
                let slot = at % coarse.height();
                fine[k].halve(self.layout, k == 0, coarse, slot, quads);
                let (finer, joined) = summaries.split_at_mut(k + 1);
                if self.most > 0 {
                    finer[k].halve(&mut joined[0], slot, joining);
                }
                bands[k].fold_row(self.options, self.layout, coarse, &joined[0], slot, (x >> (k + 1), at), scratch);
                (self.advance)(coarse.width());
            }
        }
    }

    /// Folds one level from what was kept, or from the texels where there is nothing.
    fn fold_level(&self, level: &mut Level, source: Option<&Kept>, size: Size, keep: bool) -> Option<Kept> {
        let from = source.map_or(self.size, |kept| Size::new(kept.moments.width(), kept.moments.height()));
        let (across, down) = (spans(from.width, size.width), spans(from.height, size.height));
        let rows: Vec<Kept> = level
            .bands(1)
            .into_par_iter()
            .zip(&down)
            .map_init(LevelBuffers::default, |buffers, (mut band, span)| {
                let LevelBuffers { reduce, texels, gather, texel_row, spare } = buffers;
                let mut row = Kept::default();
                gather.start(size.width);
                let mut rows = span.weights.iter();
                let fill = |y: usize, out: &mut Block| {
                    let height = *rows.next().expect("as many rows as the span has");
                    match source {
                        Some(kept) => {
                            out.copy_row(self.layout, &kept.moments, y);
                            gather.add(&kept.summaries, y, height, &across, self.most);
                        }
                        None => {
                            out.resize(self.layout, self.size.width, 1);
                            texel_row.resize(self.size.width, 1, self.most.min(1));
                            self.read_texels(0, y, out, texel_row, 0, texels);
                            out.zero_covariances(self.layout, 0);
                            gather.add(texel_row, 0, height, &across, self.most);
                        }
                    }
                };
                reduce_rows(self.layout, fill, span, &across, &mut row.moments, reduce);
                gather.finish(self.most, &mut row.summaries);
                band.fold_row(self.options, self.layout, &row.moments, &row.summaries, 0, (0, 0), spare);
                (self.advance)(size.width);
                if keep { row } else { Kept::default() }
            })
            .collect();
        keep.then(|| Kept::stack(self.layout, rows))
    }

    /// The moments, and where the fold reads them the lobes, of a row of texels from column `x` of row `y` on, into row
    /// `to` of `block` and of `summaries`.
    fn read_texels(
        &self,
        x: usize,
        y: usize,
        block: &mut Block,
        summaries: &mut Summaries,
        to: usize,
        scratch: &mut Vec<f32>,
    ) {
        let texels = texel_row(self.texels, x, y, block.row_mut(0, to), scratch);
        block.finish_texels(self.layout, to, &texels);
        if self.most > 0 {
            summaries.fill_texels(to, block.row(0, to), &texels);
        }
        for i in 0..self.texels.extras() {
            self.texels.extra(i, y, x, block.row_mut(self.layout.extra(i), to));
        }
    }
}

/// One row of texels in `scratch`, with the weights in `weight`.
fn texel_row<'a>(
    texels: &dyn Texels,
    x: usize,
    y: usize,
    weight: &mut [f32],
    scratch: &'a mut Vec<f32>,
) -> TexelRows<'a> {
    let n = weight.len();
    scratch.resize(scratch.len().max(7 * n), 0.0);
    let mut rows = scratch.chunks_exact_mut(n);
    let [nx, ny, nz, perceptual, xx, xy, yy] = std::array::from_fn(|_| rows.next().expect("seven rows"));
    texels.normals(y, x, [&mut *nx, &mut *ny, &mut *nz], weight);
    weight.iter_mut().for_each(|w| *w = w.max(UNUSABLE_WEIGHT));
    texels.perceptual(y, x, perceptual);
    let tensors = texels.is_anisotropic().then(|| {
        texels.tensors(y, x, perceptual, [&mut *xx, &mut *xy, &mut *yy]);
        [&*xx, &*xy, &*yy]
    });
    TexelRows { normal: [nx, ny, nz], perceptual, tensors }
}

/// Two rows of each level of a tile, and scratch rows.
#[derive(Default)]
struct Buffers {
    blocks: Vec<Block>,
    summaries: Vec<Summaries>,
    quads: Quads,
    joining: summary::Buffers,
    scratch: Vec<f32>,
}

#[derive(Default)]
struct LevelBuffers {
    reduce: Scratch,
    texels: Vec<f32>,
    gather: summary::Gather,
    texel_row: Summaries,
    spare: Vec<f32>,
}
