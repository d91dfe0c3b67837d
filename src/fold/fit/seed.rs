//! The footprint cut in parts, each a lobe: where the lobes of a mixture start.

use super::chunk::Atom;
use super::estimate::Estimate;
use super::lanes::Lanes;
use super::mixture::Part;
use super::scatter;
use crate::ndf::Form;

/// Share of a footprint that its parts cover, below which they are looked for in another way.
const APART: f32 = 0.8;

/// How many times more the other way must cover.
const BETTER: f32 = 1.25;

/// Overlap from which a lobe stands for an atom.
const COVERED: f32 = 0.5;

/// Distance that rounding alone may make.
const NOTHING: f32 = 3e-5;

/// The parts of the footprint, each a lobe as a single one starts; of those of a common centre, that of `shared`, how far they
/// reach from it.
#[inline(always)]
pub(super) fn parts<const LOBES: usize>(
    atoms: &[Atom],
    form: Form,
    up: Lanes,
    shared: Option<&Estimate>,
) -> [Part; LOBES] {
    let mut parts = lobes(atoms, &cut::<LOBES>(atoms, shared), form, shared);
    if shared.is_none() {
        let own = covered(atoms, &parts);
        let none = Lanes::all(f32::INFINITY);
        let apart = (APART * scatter::weight(atoms)).above(own, own, none);
        if apart != none {
            let peeled = peel::<LOBES>(atoms, form, up);
            choose(&mut parts, &peeled, covered(atoms, &peeled), BETTER * apart);
        }
    }
    parts
}

/// Takes other parts where `value` is larger than `least`.
#[inline(always)]
pub(super) fn choose<const LOBES: usize>(
    parts: &mut [Part; LOBES],
    others: &[Part; LOBES],
    value: Lanes,
    least: Lanes,
) {
    for (part, other) in parts.iter_mut().zip(others) {
        part.lobe = other.lobe.where_above(value, least, part.lobe);
        part.share = value.above(least, other.share, part.share);
        part.area = value.above(least, other.area, part.area);
    }
}

/// How much of the atoms the parts cover, each atom by the one that covers it best.
#[inline(always)]
pub(super) fn covered<const LOBES: usize>(atoms: &[Atom], parts: &[Part; LOBES]) -> Lanes {
    let areas = parts.map(|part| part.lobe.area());
    let mut sum = Lanes::default();
    for atom in atoms {
        let mut best = Lanes::default();
        for (part, area) in parts.iter().zip(areas) {
            let own = part.lobe.overlap(area, atom);
            best = own.above(best, own, best);
        }
        sum += atom.w * best;
    }
    sum
}

/// Whether an atom belongs to a part: 0 or 1.
type Members<const LOBES: usize> = [Vec<Lanes>; LOBES];

/// Takes from what is left, again and again, what its closest lobe covers; the last part is all that is then left, and its
/// closest lobe.
#[inline(always)]
fn peel<const LOBES: usize>(atoms: &[Atom], form: Form, up: Lanes) -> [Part; LOBES] {
    let mut members: Members<LOBES> = std::array::from_fn(|_| vec![Lanes::default(); atoms.len()]);
    let mut rest = atoms.to_vec();
    members[LOBES - 1].fill(Lanes::all(1.0));
    for part in 0..LOBES - 1 {
        let lobe = scatter::closest(&rest, form, up);
        let area = lobe.area();
        for (k, atom) in rest.iter_mut().enumerate() {
            let left = members[LOBES - 1][k];
            let taken = lobe.overlap(area, atom).above(Lanes::all(COVERED), left, Lanes::default());
            members[part][k] = taken;
            members[LOBES - 1][k] = left - taken;
            atom.w = taken.above(Lanes::default(), Lanes::default(), atom.w);
        }
    }
    let mut parts = lobes(atoms, &members, form, None);
    let Part { lobe, share, .. } = &mut parts[LOBES - 1];
    *lobe = scatter::closest(&rest, form, up).where_above(*share, Lanes::default(), *lobe);
    parts
}

/// Cuts the part with the largest weighted sum of squares at its mean, across the direction in which it is longest among
/// centre and width, until there are enough. Parts that share a centre, that of `shared`, are cut by how far they reach from
/// it.
#[inline(always)]
fn cut<const LOBES: usize>(atoms: &[Atom], shared: Option<&Estimate>) -> Members<LOBES> {
    let places: Vec<[Lanes; 3]> =
        atoms.iter().map(|atom| shared.map_or_else(|| place(atom), |e| reach(atom, e))).collect();
    let one = Lanes::all(1.0);
    let mut members: Members<LOBES> = std::array::from_fn(|_| vec![Lanes::default(); atoms.len()]);
    members[0].fill(one);
    for next in 1..LOBES {
        let (mut widest, mut which) = (Cell::default(), [Lanes::default(); LOBES]);
        widest.cost = Lanes::all(-1.0);
        for part in 0..next {
            let cell = Cell::of(atoms, &places, &members[part]);
            let other = cell.cost.above(widest.cost, Lanes::default(), one);
            which.iter_mut().for_each(|which| *which *= other);
            which[part] = one - other;
            (0..3).for_each(|q| {
                widest.mean[q] = other.above(Lanes::default(), widest.mean[q], cell.mean[q]);
                widest.axis[q] = other.above(Lanes::default(), widest.axis[q], cell.axis[q]);
            });
            widest.cost = other.above(Lanes::default(), widest.cost, cell.cost);
        }
        let [x, y, z] = widest.axis;
        let nothing = NOTHING * (x * x + y * y + z * z).sqrt();
        for (k, place) in places.iter().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|q| widest.axis[q] * (place[q] - widest.mean[q]));
            let beyond = (x + y + z).above(nothing, one, Lanes::default());
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
fn lobes<const LOBES: usize>(
    atoms: &[Atom],
    members: &Members<LOBES>,
    form: Form,
    shared: Option<&Estimate>,
) -> [Part; LOBES] {
    let mut parts = [Part::default(); LOBES];
    let mut all = Lanes::all(f32::MIN_POSITIVE);
    let mut all_area = all;
    for (part, members) in parts.iter_mut().zip(members) {
        let lobe = scatter::start(atoms, |k| atoms[k].w * members[k], shared);
        let [.., up] = lobe.direction();
        lobe.settle(form, up, Lanes::all(1.0), Lanes::default(), &mut part.lobe);
        atoms.iter().zip(members).for_each(|(atom, member)| {
            let weight = atom.w * *member;
            part.share += weight;
            part.area += weight * atom.tilt;
        });
        all += part.share;
        all_area += part.area;
    }
    let none = Lanes::default();
    let whole = parts.iter().rev().fold(parts[0].lobe, |whole, part| part.lobe.where_above(part.share, none, whole));
    for part in &mut parts {
        part.share *= all.inverse();
        part.area *= all_area.inverse();
        // Nothing was cut off: still a lobe.
        part.lobe = part.lobe.where_above(part.share, none, whole);
    }
    parts
}

/// What a cut of a part needs.
#[derive(Clone, Copy, Default)]
struct Cell {
    cost: Lanes,
    mean: [Lanes; 3],
    axis: [Lanes; 3],
}

/// Where an atom lies among others: the centre's normal projected on the disk, and the width seen there.
#[inline(always)]
fn place(atom: &Atom) -> [Lanes; 3] {
    let z = atom.tilt.inverse();
    let [xx, _, yy] = atom.scatter();
    [atom.x * z, atom.y * z, (0.5 * (xx + yy)).sqrt() * z]
}

/// How far an atom reaches from a centre.
#[inline(always)]
fn reach(atom: &Atom, from: &Estimate) -> [Lanes; 3] {
    let (x, y, [xx, _, yy]) = (atom.x - from.x, atom.y - from.y, atom.scatter());
    [(0.5 * (xx + yy + x * x + y * y)).sqrt(), Lanes::default(), Lanes::default()]
}

impl Cell {
    #[inline(always)]
    fn of(atoms: &[Atom], places: &[[Lanes; 3]], members: &[Lanes]) -> Self {
        let (mut weight, mut mean) = (Lanes::all(f32::MIN_POSITIVE), [Lanes::default(); 3]);
        for ((atom, place), member) in atoms.iter().zip(places).zip(members) {
            let w = atom.w * *member;
            weight += w;
            (0..3).for_each(|q| mean[q] += w * place[q]);
        }
        let mean = mean.map(|v| v * weight.inverse());
        let [mut xx, mut xy, mut yy, mut zz] = [Lanes::default(); 4];
        for ((atom, place), member) in atoms.iter().zip(places).zip(members) {
            let w = atom.w * *member;
            let [x, y, z] = [0, 1, 2].map(|q| place[q] - mean[q]);
            xx += w * x * x;
            xy += w * x * y;
            yy += w * y * y;
            zz += w * z * z;
        }
        let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let longest = middle + (half * half + xy * xy).sqrt();
        // An eigenvector of the larger eigenvalue, of any length: the longer of two forms of it.
        let (a, b) = (longest - yy, longest - xx);
        let none = Lanes::default();
        Self {
            cost: zz.above(longest, zz, longest),
            mean,
            axis: [
                zz.above(longest, none, a.above(b, a, xy)),
                zz.above(longest, none, a.above(b, xy, b)),
                zz.above(longest, Lanes::all(1.0), none),
            ],
        }
    }
}
