//! The lobes under one texel.

use glam::DVec3;
use ndarray::Array2;
use rayon::prelude::*;

use super::kernel::{Diffuse, Means, Queries, accumulate, add_density};
use super::lobe::PreparedLobe;
use super::{directional_albedo, rows};
use crate::image::{Size, Span, Wrap, span};
use crate::material::Texels;
use crate::ndf::{Lobe, Ndf};
use crate::random::Random;
use crate::roughness::Alpha;

/// What lies between the centres of level 0's texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Nothing: each texel is a square of one lobe.
    #[default]
    Constant,
    /// Normals and perceptual roughness are interpolated between the centres, at `per_side` x `per_side` places in each
    /// texel.
    Bilinear {
        /// Places along one side of a texel.
        per_side: usize,
        /// What lies beyond the border.
        #[serde(skip)]
        wrap: Wrap,
    },
}

impl Interpolation {
    /// Lobes that stand for one texel.
    fn places(self) -> usize {
        match self {
            Interpolation::Constant => 1,
            Interpolation::Bilinear { per_side, .. } => (per_side * per_side).max(1),
        }
    }
}

impl Reading {
    /// Lobes that stand for a footprint of so many texels, at most.
    pub fn lobes(&self, texels: usize) -> usize {
        match self.most_texels {
            Some(most) if most < texels => most,
            _ => texels * self.interpolation.places(),
        }
    }
}

/// How a footprint is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Reading {
    /// Between the texels.
    pub interpolation: Interpolation,
    /// At most so many texels of a footprint, a seeded stratified choice; all of them if `None`. Where lobes are narrower
    /// than the gaps between the chosen normals, distances come out too large, by more than their stated error.
    pub most_texels: Option<usize>,
}

/// Lobes that are prepared and evaluated together: few enough to stay in the cache.
const BLOCK: usize = 256;

/// Texels that one thread evaluates at a time, at least: enough to be worth a task.
const TASK: usize = 1 << 14;

/// Tasks that a footprint is cut into, at most: each holds sums of its own for all that is asked.
const TASKS: usize = 64;

/// What random numbers of a texel are for: here, which of a footprint's texels stand for it.
const CHOICE: u64 = 1;

/// Groups that a subset of a footprint is split into, to tell its standard error.
const GROUPS: usize = 8;

/// The weighted lobes under one texel of a level, or any other mixture of lobes.
///
/// As an [`Ndf`], `d` is the footprint NDF `sum w_i D_i(m) / (n_i . z)` with weights that sum to 1, normalised to
/// `integral d(m) (m . z) dm = 1`: what a normal-mapped renderer shows from straight above. `sample` draws a lobe by its
/// weight and a normal of it, with the density `pdf(m) = sum w_i D_i(m) (m . n_i)`.
pub struct Footprint<'a> {
    source: Source<'a>,
    /// The values of this lobe are subtracted from every other's, and added again to the mean.
    control: PreparedLobe,
}

enum Source<'a> {
    /// All texels of a rectangle.
    Rectangle { texels: &'a dyn Texels, interpolation: Interpolation, x: Span, y: Span },
    /// A subset of them, or lobes from elsewhere; in groups that are told apart.
    Lobes(Vec<Vec<PreparedLobe>>),
}

impl<'a> Footprint<'a> {
    /// The footprint of the texel at column `x` and row `y` of level `level` of `texels`; `seed` chooses a subset.
    pub fn of_texel(texels: &'a dyn Texels, reading: Reading, seed: u64, level: usize, (x, y): (usize, usize)) -> Self {
        let (source, target) = (texels.size(), texels.size().level(level));
        let (x_span, y_span) = (span(source.width, target.width, x), span(source.height, target.height, y));
        let count = x_span.weights.len() * y_span.weights.len();
        match reading.most_texels {
            Some(most) if most < count => {
                let random = Random::for_texel(seed, CHOICE, level, (x, y));
                Self::of_groups(subset(texels, reading.interpolation, &x_span, &y_span, most, random))
            }
            _ => {
                let control = pick(texels, reading.interpolation, &x_span, &y_span, [0.0; 2]);
                let source = Source::Rectangle { texels, interpolation: reading.interpolation, x: x_span, y: y_span };
                Self { source, control }
            }
        }
    }

    /// A mixture of lobes with weights above 0, which need not sum to 1. At least one.
    pub fn of_lobes(lobes: &[(Lobe, f64)]) -> Footprint<'static> {
        Footprint::of_groups(vec![lobes.iter().map(|(lobe, weight)| PreparedLobe::new(lobe, *weight)).collect()])
    }

    fn of_groups(groups: Vec<Vec<PreparedLobe>>) -> Self {
        let control = groups[0][0].clone();
        Self { source: Source::Lobes(groups), control }
    }

    /// Number of lobes.
    pub fn lobes(&self) -> usize {
        match &self.source {
            Source::Rectangle { interpolation, x, y, .. } => x.weights.len() * y.weights.len() * interpolation.places(),
            Source::Lobes(groups) => groups.iter().map(Vec::len).sum(),
        }
    }

    /// Calls `f` with the lobes in blocks; different tasks make partial results of their own, in order. One list of
    /// results for each group.
    fn partial<T: Send>(&self, zero: impl Fn() -> T + Sync, f: impl Fn(&[PreparedLobe], &mut T) + Sync) -> Vec<Vec<T>> {
        let (texels, interpolation, x, y) = match &self.source {
            Source::Lobes(groups) => {
                let group = |lobes: &Vec<PreparedLobe>| {
                    let mut partial = zero();
                    lobes.chunks(BLOCK).for_each(|block| f(block, &mut partial));
                    vec![partial]
                };
                return groups.iter().map(group).collect();
            }
            Source::Rectangle { texels, interpolation, x, y } => (*texels, *interpolation, x, y),
        };
        let rows_a_task = (TASK / x.weights.len()).max(y.weights.len().div_ceil(TASKS)).max(1);
        let tasks: Vec<T> = y
            .weights
            .par_chunks(rows_a_task)
            .enumerate()
            .map(|(task, weights)| {
                let mut partial = zero();
                let mut block = Vec::with_capacity(2 * BLOCK);
                for (i, weight) in weights.iter().enumerate() {
                    let row = y.first + task * rows_a_task + i;
                    for (k, columns) in x.weights.chunks(BLOCK).enumerate() {
                        let first = x.first + k * BLOCK;
                        rows::append(texels, interpolation, row, f64::from(*weight), first, columns, &mut block);
                        if block.len() >= BLOCK {
                            f(&block, &mut partial);
                            block.clear();
                        }
                    }
                }
                f(&block, &mut partial);
                partial
            })
            .collect();
        vec![tasks]
    }

    /// Means over the lobes at all half vectors and lights; one for each group of a subset, else one.
    pub fn means(&self, queries: &Queries, lights: &Diffuse) -> Vec<Means> {
        let gain = |cos: f64, alpha: f64| 1.0 / directional_albedo(cos, Alpha(alpha as f32)).max(1e-3);
        let mut control = Means::zeros(queries, lights);
        let one = [self.control.clone().weighing(1.0)];
        accumulate(&one, &gain, queries, lights, &Means::zeros(queries, lights), &mut control);
        let partial = self.partial(
            || Means::zeros(queries, lights),
            |lobes, sums| accumulate(lobes, &gain, queries, lights, &control, sums),
        );
        let mean = |parts: Vec<Means>| {
            let weight: f64 = parts.iter().map(|part| part.weight).sum();
            let mut mean = Means { weight, ..control.clone() };
            for mut part in parts {
                for (mean, sum) in mean.planes().into_iter().zip(part.planes()) {
                    mean.iter_mut().zip(sum).for_each(|(mean, sum)| *mean += *sum / weight);
                }
            }
            mean
        };
        partial.into_iter().map(mean).collect()
    }

    /// The footprint NDF at each of `normals` (unit); 1/sr.
    pub fn density(&self, normals: &[DVec3]) -> Vec<f64> {
        let planes = [0, 1, 2].map(|i| normals.iter().map(|m| m[i]).collect::<Vec<_>>());
        let at = planes.each_ref().map(Vec::as_slice);
        let partial = self.partial(
            || (0.0, vec![0.0; normals.len()]),
            |lobes, (weight, sums)| {
                *weight += lobes.iter().map(|lobe| lobe.weight).sum::<f64>();
                add_density(lobes, at, sums);
            },
        );
        let mut density = vec![0.0; normals.len()];
        let mut weight = 0.0;
        for (w, sums) in partial.into_iter().flatten() {
            weight += w;
            density.iter_mut().zip(sums).for_each(|(density, sum)| *density += sum);
        }
        density.iter_mut().for_each(|density| *density /= weight);
        density
    }

    /// The footprint NDF over a square window of the projected disk: `n` x `n` cell centres, row 0 at the top (largest
    /// y), for m.x in `centre.0 +- half_width` and m.y likewise; 0 outside the disk. On the projected disk the density
    /// of normals is D itself, `D(m) (m . z) dm = D dx dy`: the sum times the cell's area is 1 where the window holds
    /// all of it.
    pub fn disk(&self, centre: (f64, f64), half_width: f64, n: usize) -> Array2<f64> {
        let place = |i: usize| ((2 * i + 1) as f64 / n as f64 - 1.0) * half_width;
        let normal = |i: usize| {
            let (x, y) = (centre.0 + place(i % n), centre.1 - place(i / n));
            DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
        };
        // Beyond the disk z is not a number.
        let inside: Vec<(usize, DVec3)> = (0..n * n).map(|i| (i, normal(i))).filter(|(_, m)| m.z > 0.0).collect();
        let normals: Vec<DVec3> = inside.iter().map(|(_, m)| *m).collect();
        let mut disk = Array2::zeros((n, n));
        for ((i, _), d) in inside.iter().zip(self.density(&normals)) {
            disk[(i / n, i % n)] = d;
        }
        disk
    }

    /// Mean normal of the footprint by area, not normalised: `integral of D_A m dm`, and for lights that every texel
    /// faces the exact diffuse mean is its product with them.
    pub fn mean_normal(&self) -> DVec3 {
        let partial = self.partial(
            || (0.0, DVec3::ZERO),
            |lobes, (weight, sum)| {
                for lobe in lobes {
                    *weight += lobe.weight;
                    *sum += lobe.weight * lobe.normal;
                }
            },
        );
        let parts = || partial.iter().flatten();
        parts().map(|part| part.1).sum::<DVec3>() / parts().map(|part| part.0).sum::<f64>()
    }

    /// A normal, from four uniform numbers in 0..1: two choose the place in the footprint, two the normal of the lobe
    /// there. Its density is that of [`Means::pdf`].
    pub fn draw(&self, [a, b, c, d]: [f64; 4]) -> DVec3 {
        let lobe = match &self.source {
            Source::Lobes(groups) => {
                let lobes = || groups.iter().flatten();
                let mut left = a * lobes().map(|lobe| lobe.weight).sum::<f64>();
                let found = lobes().find(|lobe| {
                    left -= lobe.weight;
                    left < 0.0
                });
                // Rounding may leave a little.
                found.or(lobes().last()).expect("a footprint has a lobe").clone()
            }
            Source::Rectangle { texels, interpolation, x, y } => pick(*texels, *interpolation, x, y, [a, b]),
        };
        lobe.sample([c, d])
    }
}

/// A lobe of the footprint by its weight: the one at a place, 0..1 along x and y, if it is usable there, else at another
/// place that is as likely as any. Where nothing is usable everything weighs the same.
fn pick(texels: &dyn Texels, interpolation: Interpolation, x: &Span, y: &Span, place: [f64; 2]) -> PreparedLobe {
    const TRIES: usize = 10_000;
    let first = at(texels, interpolation, x, y, place);
    if first.weight >= 1.0 {
        return first;
    }
    let mut random = Random::new(place[0].to_bits(), place[1].to_bits());
    let mut tried = first.clone();
    for _ in 0..TRIES {
        if random.uniform() < tried.weight {
            return tried;
        }
        tried = at(texels, interpolation, x, y, [random.uniform(), random.uniform()]);
    }
    first
}

/// The lobe at a place of the footprint. Its weight is its coverage, 0 to 1.
fn at(texels: &dyn Texels, interpolation: Interpolation, x: &Span, y: &Span, [a, b]: [f64; 2]) -> PreparedLobe {
    let (i, s) = locate(x, a);
    let (j, t) = locate(y, b);
    let mut found = Vec::new();
    rows::append(texels, interpolation, j, 1.0, i, &[1.0], &mut found);
    // Of the places inside the texel, the one where the rest of the numbers points.
    let per_side = (found.len() as f64).sqrt().round();
    let place = (t * per_side) as usize * per_side as usize + (s * per_side) as usize;
    let mut lobe = found.swap_remove(place.min(found.len() - 1));
    lobe.weight *= per_side * per_side;
    lobe
}

/// The texel in which the share `u` of a span lies, and the share of that texel.
fn locate(span: &Span, u: f64) -> (usize, f64) {
    let total: f64 = span.weights.iter().map(|w| f64::from(*w)).sum();
    let mut left = u * total;
    let last = span.weights.len() - 1;
    for (i, w) in span.weights.iter().enumerate() {
        let w = f64::from(*w);
        if left < w || i == last {
            return (span.first + i, (left / w).clamp(0.0, 1.0));
        }
        left -= w;
    }
    unreachable!("a span has a last texel")
}

/// `most` or fewer places of a footprint, one in each cell of a grid, in [`GROUPS`] groups that are spread alike.
fn subset(
    texels: &dyn Texels,
    interpolation: Interpolation,
    x: &Span,
    y: &Span,
    most: usize,
    mut random: Random,
) -> Vec<Vec<PreparedLobe>> {
    let Size { width, height } = Size::new(x.weights.len(), y.weights.len());
    let columns = (((most * width) as f64 / height as f64).sqrt() as usize).clamp(1, most.clamp(1, width));
    let rows = (most / columns).clamp(1, height);
    let mut groups = vec![Vec::new(); GROUPS.min(rows * columns)];
    let count = groups.len();
    for cell in 0..rows * columns {
        let (i, j) = (cell % columns, cell / columns);
        let place = |i: usize, n: usize, u: f64| (i as f64 + u) / n as f64;
        let (u, v) = (random.uniform(), random.uniform());
        // Unusable texels stay unusable here: the choice is of places.
        let lobe = at(texels, interpolation, x, y, [place(i, columns, u), place(j, rows, v)]);
        // Neighbouring rows start with different groups.
        groups[(i + 3 * j) % count].push(lobe);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

impl Ndf for Footprint<'_> {
    fn d(&self, m: DVec3) -> f64 {
        self.density(&[m])[0]
    }

    /// The digits of the two numbers are split: the first ones choose the place, the others the normal.
    fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        const CELLS: f64 = (1u64 << 20) as f64;
        let split = |u: f64| ((u * CELLS).floor() / CELLS, (u * CELLS).fract());
        let ((a, c), (b, d)) = (split(u), split(v));
        self.draw([a, b, c, d])
    }

    fn pdf(&self, m: DVec3) -> f64 {
        let mut queries = Queries::default();
        queries.start_view(DVec3::Z);
        queries.push_half(m);
        let groups = self.means(&queries, &Diffuse::default());
        let weight: f64 = groups.iter().map(|means| means.weight).sum();
        groups.iter().map(|means| means.weight * means.pdf[0]).sum::<f64>() / weight
    }
}
