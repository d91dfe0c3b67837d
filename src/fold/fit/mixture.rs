//! A few GGX lobes together: those of the footprint's parts, two of them moved by expectation maximisation over the same nodes
//! as those of a single lobe, where they then still cover the footprint.
//!
//! Based on: D. Peel, G. J. McLachlan, "Robust Mixture Modelling Using the t Distribution", 2000; the scatter's step is that
//! of Kent, Tyler and Vardi 1994. The footprint is a mixture itself: expectations over its lobes replace sums over samples.
//! No step makes a lobe narrower than the mean of the texels that it stands for: a few nodes in place of a lobe would.

use std::f32::consts::FRAC_1_SQRT_2;

use super::chunk::{Atom, Chunk, Fitted, Shape};
use super::estimate::{Estimate, read_out};
use super::lanes::Lanes;
use super::scatter::{self, Metric, RING, Seen, closest};
use super::seed;

/// Places of the nodes of a lobe along its two axes.
const NODES: [[f32; 2]; 8] = {
    let (r1, r2) = (RING[0], RING[1] * FRAC_1_SQRT_2);
    [[r1, 0.0], [-r1, 0.0], [0.0, r1], [0.0, -r1], [r2, r2], [-r2, -r2], [r2, -r2], [-r2, r2]]
};

/// Steps of two lobes.
const STEPS: usize = 3;

/// How much more may be left uncovered after the steps, as a share of what was: beyond, they lead away from the parts.
const LOSS: f32 = 0.1;

/// Least share of a lobe: below it stays as it is.
const LEAST_SHARE: f32 = 1e-6;

/// A lobe of the mixture.
#[derive(Clone, Copy, Default)]
pub(super) struct Part {
    /// Centre and scatter.
    pub lobe: Estimate,
    /// Share of the atoms' weight.
    pub share: Lanes,
    /// Share of the area.
    pub area: Lanes,
}

/// Fits as many lobes as `out` has, from 2 on.
#[inline(always)]
pub fn fit(chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    match out.len() {
        2 => fit_some::<2>(chunk, shape, out),
        3 => fit_some::<3>(chunk, shape, out),
        _ => fit_some::<4>(chunk, shape, out),
    }
}

#[inline(always)]
fn fit_some<const LOBES: usize>(chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    let atoms = &chunk.atoms;
    let (form, up) = (shape.form, chunk.normal[2]);
    let shared = shape.shared_normal.then(|| closest(atoms, form, up));
    let mut parts: [Part; LOBES] = seed::parts(atoms, form, up, shared.as_ref());
    // Steps lead to the least divergence, away from the least lobe error: two lobes gain by a few, more lobes by none.
    if LOBES == 2 {
        let mut whole = shared.unwrap_or_else(|| closest(atoms, form, up));
        let metric = Metric::new(&mut whole);
        let axes = |atom: &Atom| {
            let Seen { a: [ax, ay], b: [bx, by], .. } = Seen::new(atom, &whole, &metric);
            [ax, ay, bx, by]
        };
        let axes: Vec<[Lanes; 4]> = atoms.iter().map(axes).collect();
        let mut moved = parts;
        (0..STEPS).for_each(|_| step(atoms, &axes, shape, &mut moved));
        if shape.shared_normal {
            parts = moved;
        } else {
            let own = seed::covered(atoms, &parts);
            let least = own - LOSS * (scatter::weight(atoms) - own);
            seed::choose(&mut parts, &moved, seed::covered(atoms, &moved), least);
        }
    }
    for (part, out) in parts.iter().zip(out.iter_mut()) {
        // Lobes lie anywhere: their normals are looked for from their own centres.
        *out = read_out(&part.lobe, shape.form, &part.lobe.direction(), part.area);
    }
    if shape.shared_normal {
        share_normal(out);
    }
}

/// One step.
#[inline(always)]
fn step<const LOBES: usize>(atoms: &[Atom], axes: &[[Lanes; 4]], shape: Shape, parts: &mut [Part; LOBES]) {
    let mut metrics = [Metric::default(); LOBES];
    for (metric, part) in metrics.iter_mut().zip(parts.iter_mut()) {
        *metric = Metric::new(&mut part.lobe);
        metric.root *= part.share;
    }
    let mut sums = [Sums::default(); LOBES];
    for (atom, [ax, ay, bx, by]) in atoms.iter().zip(axes) {
        let mut shares = [Lanes::default(); LOBES];
        let weight = 0.125 * atom.w;
        let own = atom.scatter();
        for [p, q] in NODES {
            let (x, y) = (atom.x + p * *ax + q * *bx, atom.y + p * *ay + q * *by);
            let (mut d, mut w, mut density) =
                ([[Lanes::default(); 2]; LOBES], [Lanes::default(); LOBES], [Lanes::default(); LOBES]);
            let mut all = Lanes::all(f32::MIN_POSITIVE);
            for j in 0..LOBES {
                let (m, e) = (&metrics[j], &parts[j].lobe);
                let (dx, dy) = (x - e.x, y - e.y);
                d[j] = [dx, dy];
                w[j] = (m.xx * dx * dx + 2.0 * m.xy * dx * dy + m.yy * dy * dy + 1.0).inverse();
                density[j] = m.root * w[j] * w[j];
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
            (0..3).for_each(|q| sums.own[q] += share * own[q]);
        }
    }
    let (mut share, mut area) = (Lanes::all(f32::MIN_POSITIVE), Lanes::all(f32::MIN_POSITIVE));
    for sums in &sums {
        share += sums.share;
        area += sums.area;
    }
    let (share, area) = (share.inverse(), area.inverse());
    for (part, sums) in parts.iter_mut().zip(&sums) {
        (part.share, part.area) = (sums.share * share, sums.area * area);
    }
    let common = shape.shared_normal.then(|| common_shift(parts, &sums));
    for (part, sums) in parts.iter_mut().zip(&sums) {
        let next = sums.estimate(&part.lobe, common);
        let [.., up] = next.direction();
        next.settle(shape.form, up, part.share, Lanes::all(LEAST_SHARE), &mut part.lobe);
    }
}

/// Of a lobe: its share of weight and of area; sums of w, w d, w d d^T; and of the scatter of the texels in it.
#[derive(Clone, Copy, Default)]
struct Sums {
    share: Lanes,
    area: Lanes,
    w: Lanes,
    d: [Lanes; 2],
    dd: [Lanes; 3],
    own: [Lanes; 3],
}

impl Sums {
    /// The lobe with these sums about another, moved by the mean shift, or by a common one.
    #[inline(always)]
    fn estimate(&self, about: &Estimate, common: Option<[Lanes; 2]>) -> Estimate {
        let inverse = self.w.max(f32::MIN_POSITIVE).inverse();
        let [x, y] = self.d.map(|d| d * inverse);
        let [sx, sy] = common.unwrap_or([x, y]);
        let share = self.share.max(f32::MIN_POSITIVE).inverse();
        let own = self.own.map(|own| own * share);
        let [xx, xy, yy] = self.dd.map(|dd| dd * inverse);
        let xx = 2.0 * (xx - 2.0 * x * sx + sx * sx) - own[0];
        let xy = 2.0 * (xy - x * sy - y * sx + sx * sy) - own[1];
        let yy = 2.0 * (yy - 2.0 * y * sy + sy * sy) - own[2];
        // What is wider than the texels' own scatter, in any direction.
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let spread = (half * half + xy * xy).sqrt();
        let (long, short) = ((mean + spread).max(0.0), (mean - spread).max(0.0));
        let (middle, turn) = (0.5 * (long + short), 0.5 * (long - short) * spread.max(f32::MIN_POSITIVE).inverse());
        Estimate {
            x: about.x + sx,
            y: about.y + sy,
            xx: own[0] + middle + turn * half,
            xy: own[1] + turn * xy,
            yy: own[2] + middle - turn * half,
        }
    }
}

/// The shift that lobes of a common centre agree on: their own, each with the weight of its certainty.
#[inline(always)]
fn common_shift(parts: &[Part], sums: &[Sums]) -> [Lanes; 2] {
    let (mut all, mut shift) = (Lanes::all(f32::MIN_POSITIVE), [Lanes::default(); 2]);
    for (part, sums) in parts.iter().zip(sums) {
        let certainty = (part.lobe.xx + part.lobe.yy).inverse();
        all += certainty * sums.w;
        (0..2).for_each(|q| shift[q] += certainty * sums.d[q]);
    }
    shift.map(|shift| shift * all.inverse())
}

/// Gives all lobes their mean normal. Those of a common centre differ, by little, where they lie far from upright.
#[inline(always)]
fn share_normal(out: &mut [Fitted]) {
    let mut mean = [Lanes::default(); 3];
    for fitted in out.iter() {
        (0..3).for_each(|q| mean[q] += fitted.weight * fitted.normal[q]);
    }
    let [x, y, z] = mean;
    let scale = (x * x + y * y + z * z).max(f32::MIN_POSITIVE).sqrt().inverse();
    out.iter_mut().for_each(|fitted| fitted.normal = mean.map(|v| v * scale));
}
