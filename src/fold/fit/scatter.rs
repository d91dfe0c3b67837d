//! The closest GGX lobe, by the fixed point of the Student-t scatter estimate.
//!
//! Based on: J. T. Kent, D. E. Tyler, Y. Vardi, "A Curious Likelihood Identity for the Multivariate t-Distribution", 1994,
//! whose parameter-expanded steps these are; H. Fujisawa, S. Eguchi, "Robust Parameter Estimation with a Small Bias Against
//! Heavy Contamination", 2008, for the weights.
//!
//! In the slope plane a footprint is a mixture of Student-t densities with two degrees of freedom, and a GGX lobe is one
//! of them. The one closest in the sense of Kullback and Leibler has `E[w (s - u)] = 0` and
//! `P = 2 E[w (s - u)(s - u)^T] / E[w]` with `w = 1 / (1 + (s - u)^T P^-1 (s - u))`. Means over a lobe of the footprint
//! are taken at eight nodes: two rings, at the radii of the two Gauss-Legendre points of the radial distribution, of four
//! nodes each. They give a single lobe back exactly, and are exact for lobes that are narrow beside the whole.

use std::f32::consts::FRAC_1_SQRT_2;

use pulp::Simd;

use super::chunk::{Atom, Chunk};
use super::estimate::Estimate;
use super::lanes::{Lanes, Rows, Which};
use crate::ndf::Form;

/// Squared radii of the rings: `u / (1 - u)` at `u = 1/2 -+ 1/(2 sqrt 3)`, so `2 -+ sqrt 3`.
const RING2: [f32; 2] = [0.267_949_2, 3.732_051];

/// Radii of the rings.
pub(super) const RING: [f32; 2] = [0.517_638_1, 1.931_851_7];

/// Lobes far out count less, by this power of their mean w: the estimate leans from that of Kullback and Leibler, which
/// follows every outlier, towards robust ones, which lie closer in lobe error. On real maps powers from 0.35 to 0.5 did
/// best; this one is a square root. None of them changes a single lobe.
const LEAN: f32 = 0.5;

/// Least determinant of a scatter, over the product of its diagonal: f32 tells no less.
const THINNEST: f32 = 1e-5;

/// Least diagonal of a scatter: that of the smoothest texels. With it no square of a ratio to the steepest slopes
/// leaves the range of f32.
const LEAST: f32 = 1e-12;

/// Steps from a start that is near already: thirty would change the mean lobe error by less than a hundredth of itself.
const STEPS: usize = 3;

/// Ratio of squared widths from which texels are smooth and rough ones: that of alpha is 2.
const UNLIKE: f32 = 4.0;

/// Share of the weight below which an atom is as good as absent.
const ABSENT: f32 = 1e-6;

/// Share of a footprint that one lobe covers, below which it has parts that lie apart. On real maps 0.6 and 0.75 did as well.
const APART: f32 = 0.7;

/// Share that the most typical texel's lobe must cover to be the one: no other part could take its place, so that between equal
/// ones neither rounding nor a neighbour decides. Without such a part the lobe stays that which began at the mean, or the one
/// about the smooth texels, and neighbours are cut alike. Overlaps with what was merged tell too little to choose by less: of
/// bumps alike on all sides they may favour a side by the roughness's phase.
const MAJORITY: f32 = 0.55;

/// How much more another lobe must cover than the first.
const MORE: f32 = 1.02;

/// Share by which smooth ones are preferred: of two texels alone, each covers as much.
const SMOOTH: f32 = 0.02;

/// The inverse of a scatter.
#[derive(Clone, Copy)]
pub struct Metric<S: Simd> {
    /// Inverse.
    pub xx: Lanes<S>,
    /// Inverse.
    pub xy: Lanes<S>,
    /// Inverse.
    pub yy: Lanes<S>,
    /// Root of its determinant.
    pub root: Lanes<S>,
}

impl<S: Simd> Metric<S> {
    /// Of the scatter of an estimate, which is given the least width across if rounding has left none.
    #[inline(always)]
    pub fn new(e: &mut Estimate<S>) -> Self {
        (e.xx, e.yy) = (e.xx.max(LEAST), e.yy.max(LEAST));
        let product = e.xx * e.yy;
        let most = (1.0 - THINNEST) * product * (e.xy * e.xy).max(f32::MIN_POSITIVE).inverse();
        e.xy *= most.sqrt().min(1.0);
        let inverse = (product - e.xy * e.xy).inverse();
        Self { xx: e.yy * inverse, xy: -(e.xy * inverse), yy: e.xx * inverse, root: inverse.sqrt() }
    }

    /// `w = 1 / (1 + d^T P^-1 d)` at a distance from the centre, and pi times the density there.
    #[inline(always)]
    pub fn density(&self, dx: Lanes<S>, dy: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
        let w = (self.xx * dx * dx + 2.0 * self.xy * dx * dy + self.yy * dy * dy + 1.0).inverse();
        (w, self.root * w * w)
    }
}

/// An atom seen from an estimate: its distance, and its axes `v = L q` for orthogonal q, of which the first points where w
/// changes most, so that turning the footprint turns the nodes.
pub struct Seen<S: Simd> {
    /// Centre minus centre.
    pub d: [Lanes<S>; 2],
    /// `1 + d^T P^-1 d`.
    pub far: Lanes<S>,
    /// How fast that grows along the first axis, halved.
    pub slope: Lanes<S>,
    /// First axis.
    pub a: [Lanes<S>; 2],
    /// Second axis.
    pub b: [Lanes<S>; 2],
}

impl<S: Simd> Seen<S> {
    #[inline(always)]
    pub fn new(atom: &Atom<S>, e: &Estimate<S>, m: &Metric<S>) -> Self {
        let (dx, dy) = (atom.x - e.x, atom.y - e.y);
        let (mx, my) = (m.xx * dx + m.xy * dy, m.xy * dx + m.yy * dy);
        // Products stay in the range of f32 even for a smooth lobe seen from the horizon.
        let b1 = (atom.l11 * mx + atom.l21 * my).max(-1e18).min(1e18);
        let b2 = (atom.l22 * my).max(-1e18).min(1e18);
        let slope = (b1 * b1 + b2 * b2).sqrt();
        let inverse = slope.max(f32::MIN_POSITIVE).inverse();
        let cos = slope.above(slope.like(0.0), b1 * inverse, slope.like(1.0));
        let sin = b2 * inverse;
        let a = [atom.l11 * cos, atom.l21 * cos + atom.l22 * sin];
        let b = [-(atom.l11 * sin), atom.l22 * cos - atom.l21 * sin];
        Self { d: [dx, dy], far: dx * mx + dy * my + 1.0, slope, a, b }
    }
}

/// The closest lobe of each footprint of a chunk: centre x y and scatter xx xy yy.
///
/// Few footprints leave some to choose from: the search of all those goes side by side.
#[inline(always)]
pub fn closest_of_each<S: Simd>(simd: S, chunk: &Chunk, form: Form) -> Rows<5> {
    let (mut found, mut atoms, mut doubtful) = (Rows::default(), Vec::new(), Vec::new());
    for first in (0..chunk.count).step_by(S::F32_LANES) {
        let which = Which::From(first);
        chunk.atoms(simd, which, &mut atoms);
        let [.., up] = chunk.normal.load(simd, which);
        let e = near(&atoms, form, up);
        found.store(which, e.values());
        let Doubts { unlike, apart, .. } = Doubts::new(&atoms, &e);
        (unlike + apart).append_positive(first, chunk.count, &mut doubtful);
    }
    for some in doubtful.chunks(S::F32_LANES) {
        let which = Which::These(some);
        chunk.atoms(simd, which, &mut atoms);
        let [.., up] = chunk.normal.load(simd, which);
        let e = Estimate::new(found.load(simd, which));
        found.store(which, settled(&atoms, form, up, e).values());
    }
    found
}

/// The closest lobe of each footprint; `up` is the z of its mean normal.
#[inline(always)]
pub fn closest<S: Simd>(atoms: &[Atom<S>], form: Form, up: Lanes<S>) -> Estimate<S> {
    settled(atoms, form, up, near(atoms, form, up))
}

/// A lobe that is near the closest one.
#[inline(always)]
fn near<S: Simd>(atoms: &[Atom<S>], form: Form, up: Lanes<S>) -> Estimate<S> {
    let mut e = start(
        atoms,
        #[inline(always)]
        |k| atoms[k].w,
        None,
    );
    for _ in 0..STEPS {
        step::<S, false>(atoms, form, up, &mut e);
    }
    e
}

/// Why a lobe may not be the one to take; above 0 for footprints of which that holds.
struct Doubts<S: Simd> {
    /// There are smooth and rough texels.
    unlike: Lanes<S>,
    /// It leaves much uncovered: there are parts that lie apart.
    apart: Lanes<S>,
    /// How much it covers.
    covered: Lanes<S>,
    /// Weight of all atoms.
    all: Lanes<S>,
}

impl<S: Simd> Doubts<S> {
    #[inline(always)]
    fn new(atoms: &[Atom<S>], e: &Estimate<S>) -> Self {
        let (zero, all, covered) = (e.x.like(0.0), weight(atoms), covered(atoms, e));
        let mut unlike = zero;
        for atom in atoms {
            // What is as good as absent is like any other.
            unlike += atom.w.above(ABSENT * all, atom.unlike(&atoms[0], UNLIKE), zero);
        }
        Self { unlike, apart: (APART * all).above(covered, all, zero), covered, all }
    }
}

/// The lobe to take, given the one near the closest.
///
/// Parts that lie apart, or smooth and rough texels together, leave some to choose from, about all, about the smooth ones and
/// about the texel that is most typical: of these it is the one that covers most, the last only if that is a majority.
#[inline(always)]
fn settled<S: Simd>(atoms: &[Atom<S>], form: Form, up: Lanes<S>, mut first: Estimate<S>) -> Estimate<S> {
    let (zero, none) = (up.like(0.0), up.like(f32::INFINITY));
    let Doubts { unlike, apart, covered: own, all } = Doubts::new(atoms, &first);
    if !(unlike + apart).any_above(zero) {
        return first;
    }
    // Footprints without doubts keep their first.
    let mut most = (unlike + apart).above(zero, own, none);
    if unlike.any_above(zero) {
        let mut smoother = start(
            atoms,
            #[inline(always)]
            |k| {
                let [xx, _, yy] = atoms[k].scatter();
                atoms[k].w * (xx + yy).max(LEAST).inverse()
            },
            None,
        );
        for _ in 0..2 * STEPS {
            step::<S, true>(atoms, form, up, &mut smoother);
        }
        let mut least = unlike.above(zero, most, none);
        smoother.replace_if_better(atoms, MORE, &mut first, &mut least);
        most = unlike.above(zero, least, most);
    }
    let (mut typical, mut best) = (first, zero);
    for a in atoms {
        a.estimate().replace_if_better(atoms, 1.0, &mut typical, &mut best);
    }
    for _ in 0..2 * STEPS {
        step::<S, true>(atoms, form, up, &mut typical);
    }
    let majority = MAJORITY * all;
    most = most.above(majority, most, majority);
    typical.replace_if_better(atoms, MORE, &mut first, &mut most);
    first
}

impl<S: Simd> Estimate<S> {
    /// Takes the place of another where it covers so many times more.
    #[inline(always)]
    fn replace_if_better(self, atoms: &[Atom<S>], more: f32, other: &mut Self, most: &mut Lanes<S>) {
        let own = covered(atoms, &self);
        let least = more * *most;
        *other = self.where_above(own, least, *other);
        *most = own.above(least, own, *most);
    }
}

/// Weight of all atoms.
#[inline(always)]
pub fn weight<S: Simd>(atoms: &[Atom<S>]) -> Lanes<S> {
    let mut all = atoms[0].w;
    for atom in &atoms[1..] {
        all += atom.w;
    }
    all
}

/// How much of the atoms a lobe covers.
#[inline(always)]
fn covered<S: Simd>(atoms: &[Atom<S>], e: &Estimate<S>) -> Lanes<S> {
    let (mut sum, area) = (e.x.like(0.0), e.area());
    for atom in atoms {
        sum += atom.w * e.overlap(area, atom);
    }
    sum * (-SMOOTH * area * (area + 1.0).inverse() + 1.0)
}

/// A start that needs no iteration: the mean slope, or the centre of `about`, and the second moments about it, each weighed
/// by the inverse of its root: those of absolute values, which GGX has, where it has no second moments. A single lobe is its
/// own start. `weight` is that of an atom.
#[inline(always)]
pub fn start<S: Simd>(
    atoms: &[Atom<S>],
    weight: impl Fn(usize) -> Lanes<S>,
    about: Option<&Estimate<S>>,
) -> Estimate<S> {
    let zero = atoms[0].w.like(0.0);
    let mut all = zero;
    let mut e = Estimate::nothing(zero);
    for (k, a) in atoms.iter().enumerate() {
        let w = weight(k);
        all += w;
        e.x += w * a.x;
        e.y += w * a.y;
    }
    let inverse = all.max(f32::MIN_POSITIVE).inverse();
    (e.x, e.y) = match about {
        Some(about) => (about.x, about.y),
        None => (e.x * inverse, e.y * inverse),
    };
    let mut length = zero;
    for (k, a) in atoms.iter().enumerate() {
        let (dx, dy, w) = (a.x - e.x, a.y - e.y, weight(k) * inverse);
        let [xx, xy, yy] = a.scatter();
        let (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        let root = (0.5 * (xx + yy)).sqrt();
        let share = w * root.max(f32::MIN_POSITIVE).inverse();
        length += w * root;
        e.xx += share * xx;
        e.xy += share * xy;
        e.yy += share * yy;
    }
    (e.xx, e.xy, e.yy) = (e.xx * length, e.xy * length, e.yy * length);
    e
}

/// w at opposite nodes d +- v, their sum and their difference: w is the inverse of `a +- 2 b` there.
#[inline(always)]
fn pair<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    // Rounding must not make the farther one negative.
    let (low, least) = (a - 2.0 * b, 1e-6 * a);
    let low = low.above(least, low, least);
    let inverse = (low * (a + 2.0 * b)).inverse();
    (2.0 * a * inverse, -4.0 * b * inverse)
}

/// One step. `up` is the z of the mean normal.
#[inline(always)]
fn step<S: Simd, const ROBUST: bool>(atoms: &[Atom<S>], form: Form, up: Lanes<S>, e: &mut Estimate<S>) {
    let m = Metric::new(e);
    // Sums of w, w d, w d d^T; the parts of tr(P^-1 w d d^T) that lie between atoms and in all.
    let zero = up.like(0.0);
    let mut sums = [zero; 8];
    for atom in atoms {
        let Seen { d: [dx, dy], far, slope, a: [ax, ay], b: [bx, by] } = Seen::new(atom, e, &m);
        let (ux, uy) = (m.xx * ax + m.xy * ay, m.xy * ax + m.yy * ay);
        let (q11, q12) = (ax * ux + ay * uy, bx * ux + by * uy);
        let q22 = bx * (m.xx * bx + m.xy * by) + by * (m.xy * bx + m.yy * by);
        let (r1, half) = (RING[0], 0.5 * RING2[1]);
        let r2 = FRAC_1_SQRT_2 * RING[1];
        let (w1, v1) = pair(far + RING2[0] * q11, r1 * slope);
        let w2 = 2.0 * (far + RING2[0] * q22).inverse();
        let (w3, v3) = pair(far + half * (q11 + q22 + 2.0 * q12), r2 * slope);
        let (w4, v4) = pair(far + half * (q11 + q22 - 2.0 * q12), r2 * slope);
        let all = (w1 + w2) + (w3 + w4);
        let outer = half * (w3 + w4);
        let (c11, c12, c22) = (RING2[0] * w1 + outer, half * (w3 - w4), RING2[0] * w2 + outer);
        let (e1, e2) = (r1 * v1 + r2 * (v3 + v4), r2 * (v3 - v4));
        let (ex, ey) = (ax * e1 + bx * e2, ay * e1 + by * e2);
        let mean = 0.125 * all;
        let g = atom.w * if ROBUST { mean } else { mean.sqrt() };
        let sxx = all * dx * dx + 2.0 * dx * ex + c11 * ax * ax + 2.0 * c12 * ax * bx + c22 * bx * bx;
        let sxy = all * dx * dy + dx * ey + dy * ex + c11 * ax * ay + c12 * (ax * by + ay * bx) + c22 * bx * by;
        let syy = all * dy * dy + 2.0 * dy * ey + c11 * ay * ay + 2.0 * c12 * ay * by + c22 * by * by;
        sums[0] += g * all;
        sums[1] += g * (all * dx + ex);
        sums[2] += g * (all * dy + ey);
        sums[3] += g * sxx;
        sums[4] += g * sxy;
        sums[5] += g * syy;
        sums[6] += g * all * (far + -1.0);
        sums[7] += g * (m.xx * sxx + 2.0 * m.xy * sxy + m.yy * syy);
    }
    let [weight, x, y, xx, xy, yy, between, whole] = sums;
    let inverse = weight.max(f32::MIN_POSITIVE).inverse();
    let (x, y) = (x * inverse, y * inverse);
    // Leaning takes width away. Of narrow atoms that make up the density that should come out, w is uniform in 0..1, so
    // that P = 2 (1 + LEAN) E[w^LEAN w d d^T] / E[w^LEAN w]; for a single atom nothing leans, and for a slight smear
    // as good as nothing.
    let apart = (between * whole.max(f32::MIN_POSITIVE).inverse()).min(1.0);
    let scale = 2.0 * (if ROBUST { 1.0 } else { LEAN } * apart * apart + 1.0);
    let mut next = *e;
    (next.x, next.y) = (e.x + x, e.y + y);
    next.xx = scale * (xx * inverse - x * x);
    next.xy = scale * (xy * inverse - x * y);
    next.yy = scale * (yy * inverse - y * y);
    next.settle(form, up, weight, zero, e);
}
