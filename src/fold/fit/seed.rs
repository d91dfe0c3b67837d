//! The footprint cut in parts, each a lobe: where the lobes of a mixture start.

use super::chunk::Atom;
use super::lanes::Lanes;
use super::mixture::Part;
use super::scatter::{self, Estimate};

/// Cuts the part with the largest weighted sum of squares at its mean, across the direction in which it is longest among
/// centre and width, until there are enough; each part starts as a single lobe does. Parts that share a centre, that of
/// `shared`, are cut by how far they reach from it.
#[inline(always)]
pub(super) fn parts<const LOBES: usize>(atoms: &[Atom], shared: Option<&Estimate>) -> [Part; LOBES] {
    let places: Vec<[Lanes; 3]> =
        atoms.iter().map(|atom| shared.map_or_else(|| place(atom), |e| reach(atom, e))).collect();
    let one = Lanes::all(1.0);
    // Whether an atom belongs to a part: 0 or 1.
    let mut members: [Vec<Lanes>; LOBES] = std::array::from_fn(|_| vec![Lanes::default(); atoms.len()]);
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
    let mut parts = [Part::default(); LOBES];
    let mut all = Lanes::all(f32::MIN_POSITIVE);
    let mut all_area = all;
    for (part, members) in parts.iter_mut().zip(&members) {
        part.lobe = scatter::start(atoms, |k| atoms[k].w * members[k], shared);
        atoms.iter().zip(members).for_each(|(atom, member)| {
            let weight = atom.w * *member;
            part.share += weight;
            part.area += weight * atom.tilt;
        });
        all += part.share;
        all_area += part.area;
    }
    let whole = parts[0].lobe;
    for part in &mut parts {
        part.share *= all.inverse();
        part.area *= all_area.inverse();
        // Nothing was cut off: still a lobe.
        part.lobe = part.lobe.where_above(part.share, Lanes::default(), whole);
    }
    parts
}

/// Distance that rounding alone may make.
const NOTHING: f32 = 3e-5;

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
