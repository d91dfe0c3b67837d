//! A few GGX lobes together: those of the footprint's parts, moved by expectation maximisation over nodes as those of a
//! single lobe, where they then miss less of the footprint or share a normal.
//!
//! Based on: D. Peel, G. J. McLachlan, "Robust Mixture Modelling Using the t Distribution", 2000; the scatter's step is that
//! of Kent, Tyler and Vardi 1994. The footprint is a mixture itself: expectations over its lobes replace sums over samples.
//! No step makes a lobe narrower than the mean of the texels that it stands for: a few nodes in place of a lobe would.

use glam::Vec3;
use pulp::Simd;

use super::chunk::{Atom, Chunk, Fitted, Shape};
use super::estimate::Estimate;
use super::lanes::{Lanes, Rows, Which, scaled};
use super::nodes::{self, Nodes};
use super::read_out::{no_wider, read_out};
use super::scatter::{self, Metric};
use super::seed;

/// Steps; they lead to the least divergence, and after more of them away from the least lobe error.
const STEPS: usize = 3;

/// How many times more one way to cut must miss for another to replace it: where both are about as good, neighbours are cut
/// alike. The closer to 1, the closer mixtures lie, and the more they change from texel to texel.
const NOTICEABLE: f32 = 1.15;

/// So many slots of a summary to each lobe of the mixture leave nothing to move; texels of a chain's first level have four.
const FEW: usize = 2;

/// Share of the footprint that parts miss, from which they are looked for in another way.
const DOUBT: f32 = 0.25;

/// Least share of a lobe: below it stays as it is.
const LEAST_SHARE: f32 = 1e-6;

/// Numbers of a [`Part`].
const VALUES: usize = 7;

/// A lobe of the mixture.
#[derive(Clone, Copy)]
pub(super) struct Part<S: Simd> {
    /// Centre and scatter.
    pub lobe: Estimate<S>,
    /// Share of the atoms' weight.
    pub share: Lanes<S>,
    /// Share of the area.
    pub area: Lanes<S>,
}

impl<S: Simd> Part<S> {
    /// The lobe's values, then share and area.
    #[inline(always)]
    fn new([x, y, xx, xy, yy, share, area]: [Lanes<S>; VALUES]) -> Self {
        Self { lobe: Estimate::new([x, y, xx, xy, yy]), share, area }
    }

    /// The same.
    #[inline(always)]
    fn values(self) -> [Lanes<S>; VALUES] {
        let [x, y, xx, xy, yy] = self.lobe.values();
        [x, y, xx, xy, yy, self.share, self.area]
    }
}

/// Fits as many lobes as `out` has, from 2 on.
#[inline(always)]
pub fn fit<S: Simd>(simd: S, chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    match out.len() {
        2 => fit_some::<S, 2>(simd, chunk, shape, out),
        3 => fit_some::<S, 3>(simd, chunk, shape, out),
        _ => fit_some::<S, 4>(simd, chunk, shape, out),
    }
}

#[inline(always)]
fn fit_some<S: Simd, const LOBES: usize>(simd: S, chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    let form = shape.form;
    let shared = if shape.shared_normal { Some(scatter::closest_of_each(simd, chunk, form)) } else { None };
    let (mut found, mut atoms, mut nodes) = ([Rows::default(); LOBES], Vec::new(), Nodes::new());
    let mut doubtful = Vec::new();
    for first in (0..chunk.count).step_by(S::F32_LANES) {
        let which = Which::From(first);
        chunk.atoms(simd, which, &mut atoms);
        nodes.place(&atoms);
        let parts: [Part<S>; LOBES] = match &shared {
            Some(shared) => {
                let shared = Estimate::new(shared.load(simd, which));
                moved(&atoms, &nodes, shape, seed::cut_by_reach(&atoms, form, &shared))
            }
            None => {
                nodes.weigh(&atoms);
                let mut best = Best::new(&nodes, seed::cut(&atoms, form));
                if atoms.len() > LOBES {
                    best.or(&nodes, seed::cluster(&atoms, form));
                }
                if atoms.len() > FEW * LOBES {
                    best.or(&nodes, moved(&atoms, &nodes, shape, best.parts));
                }
                (best.missed + -DOUBT).append_positive(first, chunk.count, &mut doubtful);
                best.parts
            }
        };
        store(&mut found, which, &parts);
    }
    for some in doubtful.chunks(S::F32_LANES) {
        let which = Which::These(some);
        chunk.atoms(simd, which, &mut atoms);
        nodes.place(&atoms);
        nodes.weigh(&atoms);
        let [.., up] = chunk.normal.load(simd, which);
        let peeled = seed::peel::<S, LOBES>(&atoms, form, up);
        let mut best = Best::new(&nodes, load(simd, &found, which));
        best.or(&nodes, peeled);
        if atoms.len() > FEW * LOBES {
            best.or(&nodes, moved(&atoms, &nodes, shape, peeled));
        }
        store(&mut found, which, &best.parts);
    }
    for first in (0..chunk.count).step_by(S::F32_LANES) {
        let parts: [Part<S>; LOBES] = load(simd, &found, Which::From(first));
        for (part, out) in parts.iter().zip(out.iter_mut()) {
            // Lobes lie anywhere: their normals are looked for from their own centres.
            read_out(&part.lobe, form, &part.lobe.direction(), part.area, first, out);
        }
    }
    if shape.shared_normal {
        share_normal(chunk.count, out);
    }
}

/// Of several ways to cut footprints in parts, each replaces the one before where it misses noticeably less.
struct Best<S: Simd, const LOBES: usize> {
    parts: [Part<S>; LOBES],
    missed: Lanes<S>,
}

impl<S: Simd, const LOBES: usize> Best<S, LOBES> {
    #[inline(always)]
    fn new(nodes: &Nodes<S>, parts: [Part<S>; LOBES]) -> Self {
        Self { missed: nodes.missed(&parts), parts }
    }

    /// Or these, where they miss noticeably less.
    #[inline(always)]
    fn or(&mut self, nodes: &Nodes<S>, others: [Part<S>; LOBES]) {
        let missed = nodes.missed(&others);
        let most = NOTICEABLE * missed;
        for (part, other) in self.parts.iter_mut().zip(others) {
            part.lobe = other.lobe.where_above(self.missed, most, part.lobe);
            part.share = self.missed.above(most, other.share, part.share);
            part.area = self.missed.above(most, other.area, part.area);
        }
        self.missed = self.missed.above(most, missed, self.missed);
    }
}

#[inline(always)]
fn load<S: Simd, const LOBES: usize>(simd: S, from: &[Rows<VALUES>; LOBES], which: Which) -> [Part<S>; LOBES] {
    let mut parts = [Part::new(from[0].load(simd, which)); LOBES];
    for (part, rows) in parts.iter_mut().zip(from) {
        *part = Part::new(rows.load(simd, which));
    }
    parts
}

#[inline(always)]
fn store<S: Simd, const LOBES: usize>(to: &mut [Rows<VALUES>; LOBES], which: Which, parts: &[Part<S>; LOBES]) {
    for (rows, part) in to.iter_mut().zip(parts) {
        rows.store(which, part.values());
    }
}

/// The parts after a few steps.
#[inline(always)]
fn moved<S: Simd, const LOBES: usize>(
    atoms: &[Atom<S>],
    nodes: &Nodes<S>,
    shape: Shape,
    mut parts: [Part<S>; LOBES],
) -> [Part<S>; LOBES] {
    for _ in 0..STEPS {
        step(atoms, nodes, shape, &mut parts);
    }
    parts
}

/// Their metrics, by which each has the density of its share; the lobes get the least widths that these need.
#[inline(always)]
pub(super) fn metrics<S: Simd, const LOBES: usize>(parts: &mut [Part<S>; LOBES]) -> [Metric<S>; LOBES] {
    let zero = parts[0].share.like(0.0);
    let mut metrics = [Metric { xx: zero, xy: zero, yy: zero, root: zero }; LOBES];
    for (metric, part) in metrics.iter_mut().zip(parts) {
        *metric = Metric::new(&mut part.lobe);
        metric.root *= part.share;
    }
    metrics
}

/// One step.
#[inline(always)]
fn step<S: Simd, const LOBES: usize>(atoms: &[Atom<S>], nodes: &Nodes<S>, shape: Shape, parts: &mut [Part<S>; LOBES]) {
    let zero = parts[0].share.like(0.0);
    let metrics = metrics(parts);
    let mut sums = [Sums { share: zero, area: zero, w: zero, d: [zero; 2], dd: [zero; 3], own: [zero; 3] }; LOBES];
    for (k, atom) in atoms.iter().enumerate() {
        let mut shares = [zero; LOBES];
        let weight = 1.0 / nodes::COUNT as f32 * atom.w;
        let own = atom.scatter();
        for &[x, y] in &nodes.at[k * nodes::COUNT..(k + 1) * nodes::COUNT] {
            let (mut d, mut w, mut density) = ([[zero; 2]; LOBES], [zero; LOBES], [zero; LOBES]);
            let mut all = zero.like(f32::MIN_POSITIVE);
            for j in 0..LOBES {
                let (m, e) = (&metrics[j], &parts[j].lobe);
                let (dx, dy) = (x - e.x, y - e.y);
                d[j] = [dx, dy];
                (w[j], density[j]) = m.density(dx, dy);
                all += density[j];
            }
            let scale = weight * all.inverse();
            for j in 0..LOBES {
                let (share, [dx, dy]) = (density[j] * scale, d[j]);
                let g = share * w[j];
                let (gx, gy) = (g * dx, g * dy);
                shares[j] += share;
                sums[j].w += g;
                sums[j].d[0] += gx;
                sums[j].d[1] += gy;
                sums[j].dd[0] += gx * dx;
                sums[j].dd[1] += gx * dy;
                sums[j].dd[2] += gy * dy;
            }
        }
        for (sums, share) in sums.iter_mut().zip(shares) {
            sums.share += share;
            sums.area += share * atom.tilt;
            for q in 0..3 {
                sums.own[q] += share * own[q];
            }
        }
    }
    let (mut share, mut area) = (zero.like(f32::MIN_POSITIVE), zero.like(f32::MIN_POSITIVE));
    for sums in &sums {
        share += sums.share;
        area += sums.area;
    }
    let (share, area) = (share.inverse(), area.inverse());
    for (part, sums) in parts.iter_mut().zip(&sums) {
        (part.share, part.area) = (sums.share * share, sums.area * area);
    }
    let common = if shape.shared_normal { Some(common_shift(parts, &sums)) } else { None };
    for (part, sums) in parts.iter_mut().zip(&sums) {
        let next = sums.estimate(&part.lobe, common);
        let [.., up] = next.direction();
        next.settle(shape.form, up, part.share, zero.like(LEAST_SHARE), &mut part.lobe);
    }
}

/// Of a lobe: its share of weight and of area; sums of w, w d, w d d^T; and of the scatter of the texels in it.
#[derive(Clone, Copy)]
struct Sums<S: Simd> {
    share: Lanes<S>,
    area: Lanes<S>,
    w: Lanes<S>,
    d: [Lanes<S>; 2],
    dd: [Lanes<S>; 3],
    own: [Lanes<S>; 3],
}

impl<S: Simd> Sums<S> {
    /// The lobe with these sums about another, moved by the mean shift, or by a common one.
    #[inline(always)]
    fn estimate(&self, about: &Estimate<S>, common: Option<[Lanes<S>; 2]>) -> Estimate<S> {
        let inverse = self.w.max(f32::MIN_POSITIVE).inverse();
        let [x, y] = scaled(self.d, inverse);
        let [sx, sy] = match common {
            Some(shift) => shift,
            None => [x, y],
        };
        let share = self.share.max(f32::MIN_POSITIVE).inverse();
        let own = scaled(self.own, share);
        let [xx, xy, yy] = scaled(self.dd, inverse);
        let xx = 2.0 * (xx - 2.0 * x * sx + sx * sx) - own[0];
        let xy = 2.0 * (xy - x * sy - y * sx + sx * sy) - own[1];
        let yy = 2.0 * (yy - 2.0 * y * sy + sy * sy) - own[2];
        // What is wider than the texels' own scatter, in any direction.
        let wider = no_wider([xx, xy, yy], xx.like(f32::INFINITY));
        Estimate {
            x: about.x + sx,
            y: about.y + sy,
            xx: own[0] + wider[0],
            xy: own[1] + wider[1],
            yy: own[2] + wider[2],
        }
    }
}

/// The shift that lobes of a common centre agree on: their own, each with the weight of its certainty.
#[inline(always)]
fn common_shift<S: Simd>(parts: &[Part<S>], sums: &[Sums<S>]) -> [Lanes<S>; 2] {
    let zero = parts[0].share.like(0.0);
    let (mut all, mut shift) = (zero.like(f32::MIN_POSITIVE), [zero; 2]);
    for (part, sums) in parts.iter().zip(sums) {
        let certainty = (part.lobe.xx + part.lobe.yy).inverse();
        all += certainty * sums.w;
        for q in 0..2 {
            shift[q] += certainty * sums.d[q];
        }
    }
    scaled(shift, all.inverse())
}

/// Gives all lobes of each footprint their mean normal. Those of a common centre differ, by little, where they lie far from
/// upright.
fn share_normal(count: usize, out: &mut [Fitted]) {
    for i in 0..count {
        let mean: Vec3 = out.iter().map(|fitted| fitted.weight[i] * Vec3::from(fitted.normal.at(i))).sum();
        out.iter_mut().for_each(|fitted| fitted.normal.set(i, mean.normalize().to_array()));
    }
}
