//! The footprint cut in parts, each a lobe: where the lobes of a mixture start.

use pulp::Simd;

use super::chunk::Atom;
use super::estimate::Estimate;
use super::lanes::{Lanes, scaled};
use super::mixture::Part;
use super::scatter;
use crate::ndf::Form;

/// Overlap from which a lobe stands for an atom.
const COVERED: f32 = 0.5;

/// How often atoms go to the part that covers them best.
const ROUNDS: usize = 2;

/// Distance that rounding alone may make.
const NOTHING: f32 = 3e-5;

/// The footprint cut by place and width.
#[inline(always)]
pub(super) fn cut<S: Simd, const LOBES: usize>(atoms: &[Atom<S>], form: Form) -> [Part<S>; LOBES] {
    lobes(atoms, &halves::<S, LOBES>(atoms, None), form, None)
}

/// The footprint cut by how far its lobes reach from a centre, which the parts have in common.
#[inline(always)]
pub(super) fn cut_by_reach<S: Simd, const LOBES: usize>(
    atoms: &[Atom<S>],
    form: Form,
    from: &Estimate<S>,
) -> [Part<S>; LOBES] {
    lobes(atoms, &halves::<S, LOBES>(atoms, Some(from)), form, Some(from))
}

/// Parts about the most typical atom, about that of what it leaves, and so on; the last part is what is then left. Then each
/// atom goes to the part that covers it best, a few times.
#[inline(always)]
pub(super) fn cluster<S: Simd, const LOBES: usize>(atoms: &[Atom<S>], form: Form) -> [Part<S>; LOBES] {
    let (zero, one) = (atoms[0].w.like(0.0), atoms[0].w.like(1.0));
    let count = atoms.len();
    let mut overlaps = vec![one; count * count];
    for i in 0..count {
        let (lobe, area) = (atoms[i].estimate(), atoms[i].l11 * atoms[i].l22);
        for j in 0..i {
            let overlap = lobe.overlap(area, &atoms[j]);
            (overlaps[i * count + j], overlaps[j * count + i]) = (overlap, overlap);
        }
    }
    let mut seeds = [Estimate::nothing(zero); LOBES];
    let mut left = vec![one; count];
    for seed in &mut seeds[..LOBES - 1] {
        let mut most = zero.like(-1.0);
        for (atom, overlaps) in atoms.iter().zip(overlaps.chunks_exact(count)) {
            let mut covered = zero;
            for k in 0..count {
                covered += atoms[k].w * overlaps[k].above(left[k], left[k], overlaps[k]);
            }
            // What is not there is not typical.
            covered = atom.w.above(zero, covered, zero.like(-1.0));
            *seed = atom.estimate().where_above(covered, most, *seed);
            most = covered.above(most, covered, most);
        }
        let area = seed.area();
        for (left, atom) in left.iter_mut().zip(atoms) {
            let beyond = -seed.overlap(area, atom) + 1.0;
            *left = left.above(beyond, beyond, *left);
        }
    }
    seeds[LOBES - 1] = scatter::start(
        atoms,
        #[inline(always)]
        |k| atoms[k].w * left[k],
        None,
    );
    let mut parts = lobes(atoms, &members_of(atoms, &seeds), form, None);
    for _ in 1..ROUNDS {
        for (seed, part) in seeds.iter_mut().zip(&parts) {
            *seed = part.lobe;
        }
        parts = lobes(atoms, &members_of(atoms, &seeds), form, None);
    }
    parts
}

/// The atoms that each lobe covers best.
#[inline(always)]
fn members_of<S: Simd, const LOBES: usize>(atoms: &[Atom<S>], seeds: &[Estimate<S>; LOBES]) -> Members<S, LOBES> {
    let (zero, one) = (atoms[0].w.like(0.0), atoms[0].w.like(1.0));
    let mut members: Members<S, LOBES> = std::array::from_fn(|_| vec![zero; atoms.len()]);
    let mut most = vec![zero.like(-1.0); atoms.len()];
    for j in 0..LOBES {
        let area = seeds[j].area();
        for (k, atom) in atoms.iter().enumerate() {
            let overlap = seeds[j].overlap(area, atom);
            let own = overlap.above(most[k], one, zero);
            for earlier in &mut members[..j] {
                earlier[k] *= one - own;
            }
            members[j][k] = own;
            most[k] = overlap.above(most[k], overlap, most[k]);
        }
    }
    members
}

/// Whether an atom belongs to a part: 0 or 1.
type Members<S, const LOBES: usize> = [Vec<Lanes<S>>; LOBES];

/// Takes from what is left, again and again, what its closest lobe covers; the last part is all that is then left, and its
/// closest lobe.
#[inline(always)]
pub(super) fn peel<S: Simd, const LOBES: usize>(atoms: &[Atom<S>], form: Form, up: Lanes<S>) -> [Part<S>; LOBES] {
    let (zero, one) = (up.like(0.0), up.like(1.0));
    let mut members: Members<S, LOBES> = std::array::from_fn(|_| vec![zero; atoms.len()]);
    let mut rest = atoms.to_vec();
    members[LOBES - 1].fill(one);
    for part in 0..LOBES - 1 {
        let lobe = scatter::closest(&rest, form, up);
        let area = lobe.area();
        for (k, atom) in rest.iter_mut().enumerate() {
            let left = members[LOBES - 1][k];
            let taken = lobe.overlap(area, atom).above(up.like(COVERED), left, zero);
            members[part][k] = taken;
            members[LOBES - 1][k] = left - taken;
            atom.w = taken.above(zero, zero, atom.w);
        }
    }
    let mut parts = lobes(atoms, &members, form, None);
    let Part { lobe, share, .. } = &mut parts[LOBES - 1];
    *lobe = scatter::closest(&rest, form, up).where_above(*share, zero, *lobe);
    parts
}

/// Cuts the part with the largest weighted sum of squares at its mean, across the direction in which it is longest among
/// centre and width, until there are enough. Parts that share a centre, that of `shared`, are cut by how far they reach from
/// it.
#[inline(always)]
fn halves<S: Simd, const LOBES: usize>(atoms: &[Atom<S>], shared: Option<&Estimate<S>>) -> Members<S, LOBES> {
    let mut places = Vec::with_capacity(atoms.len());
    for atom in atoms {
        places.push(match shared {
            Some(e) => reach(atom, e),
            None => place(atom),
        });
    }
    let (zero, one) = (atoms[0].w.like(0.0), atoms[0].w.like(1.0));
    let mut members: Members<S, LOBES> = std::array::from_fn(|_| vec![zero; atoms.len()]);
    members[0].fill(one);
    for next in 1..LOBES {
        let mut widest = Cell { cost: zero.like(-1.0), mean: [zero; 3], axis: [zero; 3] };
        let mut which = [zero; LOBES];
        for part in 0..next {
            let cell = Cell::of(atoms, &places, &members[part]);
            let other = cell.cost.above(widest.cost, zero, one);
            for which in &mut which {
                *which *= other;
            }
            which[part] = one - other;
            for q in 0..3 {
                widest.mean[q] = other.above(zero, widest.mean[q], cell.mean[q]);
                widest.axis[q] = other.above(zero, widest.axis[q], cell.axis[q]);
            }
            widest.cost = other.above(zero, widest.cost, cell.cost);
        }
        let [x, y, z] = widest.axis;
        let nothing = NOTHING * (x * x + y * y + z * z).sqrt();
        for (k, place) in places.iter().enumerate() {
            let mut along = zero;
            for q in 0..3 {
                along += widest.axis[q] * (place[q] - widest.mean[q]);
            }
            let beyond = along.above(nothing, one, zero);
            for part in 0..next {
                let moved = members[part][k] * which[part] * beyond;
                members[part][k] = members[part][k] - moved;
                members[next][k] += moved;
            }
        }
    }
    members
}

/// The lobe of each part.
#[inline(always)]
fn lobes<S: Simd, const LOBES: usize>(
    atoms: &[Atom<S>],
    members: &Members<S, LOBES>,
    form: Form,
    shared: Option<&Estimate<S>>,
) -> [Part<S>; LOBES] {
    let (zero, one) = (atoms[0].w.like(0.0), atoms[0].w.like(1.0));
    let mut parts = [Part { lobe: Estimate::nothing(zero), share: zero, area: zero }; LOBES];
    let mut all = zero.like(f32::MIN_POSITIVE);
    let mut all_area = all;
    for (part, members) in parts.iter_mut().zip(members) {
        let lobe = scatter::start(
            atoms,
            #[inline(always)]
            |k| atoms[k].w * members[k],
            shared,
        );
        let [.., up] = lobe.direction();
        lobe.settle(form, up, one, zero, &mut part.lobe);
        for (atom, member) in atoms.iter().zip(members) {
            let weight = atom.w * *member;
            part.share += weight;
            part.area += weight * atom.tilt;
        }
        all += part.share;
        all_area += part.area;
    }
    let mut whole = parts[0].lobe;
    for part in parts.iter().rev() {
        whole = part.lobe.where_above(part.share, zero, whole);
    }
    for part in &mut parts {
        part.share *= all.inverse();
        part.area *= all_area.inverse();
        // Nothing was cut off: still a lobe.
        part.lobe = part.lobe.where_above(part.share, zero, whole);
    }
    parts
}

/// What a cut of a part needs.
#[derive(Clone, Copy)]
struct Cell<S: Simd> {
    cost: Lanes<S>,
    mean: [Lanes<S>; 3],
    axis: [Lanes<S>; 3],
}

/// Where an atom lies among others: the centre's normal projected on the disk, and the width seen there.
#[inline(always)]
fn place<S: Simd>(atom: &Atom<S>) -> [Lanes<S>; 3] {
    let z = atom.tilt.inverse();
    let [xx, _, yy] = atom.scatter();
    [atom.x * z, atom.y * z, (0.5 * (xx + yy)).sqrt() * z]
}

/// How far an atom reaches from a centre.
#[inline(always)]
fn reach<S: Simd>(atom: &Atom<S>, from: &Estimate<S>) -> [Lanes<S>; 3] {
    let (x, y, [xx, _, yy]) = (atom.x - from.x, atom.y - from.y, atom.scatter());
    [(0.5 * (xx + yy + x * x + y * y)).sqrt(), x.like(0.0), x.like(0.0)]
}

impl<S: Simd> Cell<S> {
    #[inline(always)]
    fn of(atoms: &[Atom<S>], places: &[[Lanes<S>; 3]], members: &[Lanes<S>]) -> Self {
        let zero = atoms[0].w.like(0.0);
        let (mut weight, mut mean) = (zero.like(f32::MIN_POSITIVE), [zero; 3]);
        for ((atom, place), member) in atoms.iter().zip(places).zip(members) {
            let w = atom.w * *member;
            weight += w;
            for q in 0..3 {
                mean[q] += w * place[q];
            }
        }
        let mean = scaled(mean, weight.inverse());
        let [mut xx, mut xy, mut yy, mut zz] = [zero; 4];
        for ((atom, place), member) in atoms.iter().zip(places).zip(members) {
            let w = atom.w * *member;
            let (x, y, z) = (place[0] - mean[0], place[1] - mean[1], place[2] - mean[2]);
            xx += w * x * x;
            xy += w * x * y;
            yy += w * y * y;
            zz += w * z * z;
        }
        let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let longest = middle + (half * half + xy * xy).sqrt();
        // An eigenvector of the larger eigenvalue, of any length: the longer of two forms of it.
        let (a, b) = (longest - yy, longest - xx);
        Self {
            cost: zz.above(longest, zz, longest),
            mean,
            axis: [
                zz.above(longest, zero, a.above(b, a, xy)),
                zz.above(longest, zero, a.above(b, xy, b)),
                zz.above(longest, zero.like(1.0), zero),
            ],
        }
    }
}
