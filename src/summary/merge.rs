//! Many lobes of the slope plane become fewer.

use glam::{Vec2, Vec4, Vec4Swizzles};

use crate::ndf::{RoughnessTensor, SlopeLobe};

/// A lobe of a summary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Level-0 texels that it stands for.
    pub weight: f32,
    /// Where and how wide it is.
    pub lobe: SlopeLobe,
}

/// Where an entry lies among others: the centre's normal projected on the disk, and the width seen there.
#[derive(Clone, Copy, Default)]
struct Placed {
    /// And 1.
    place: Vec4,
    weight: f32,
    entry: usize,
}

/// Entries that will become one.
#[derive(Clone, Copy)]
struct Cell {
    start: usize,
    end: usize,
    /// Mean place, and 0.
    mean: Vec4,
    /// The direction in which places differ most, of any length.
    axis: Vec4,
    /// Weighted sum of squares along it.
    cost: f32,
}

/// Buffers of [`merge_to`].
#[derive(Default)]
pub struct Scratch {
    placed: Vec<Placed>,
    beyond: Vec<Placed>,
    cells: Vec<Cell>,
    merged: Vec<Entry>,
}

/// One lobe for several, of a weight above 0: the mean centre, and the mean scatter widened by the centres' covariance.
///
/// Beside a whole that is much wider, a lobe of scatter P counts as second moments do, by its nodes in a fit, whose covariance
/// is P: so the covariance C of the centres adds to it as it is. (By itself the smeared lobe would be closest to `P + 2 C`
/// down to `P + 1.2 C`, but many such would widen the whole.) Here `C = E|d| E[d d^T / |d|]` for differences d from the mean:
/// the covariance of two equal parts, and finite where lobes lie as a lobe's own slopes do, which have no covariance.
#[inline(always)]
pub fn merge(entries: impl Iterator<Item = Entry> + Clone) -> Entry {
    // Differences from the first keep equal entries as they are.
    let first = entries.clone().next().expect("something to merge").lobe;
    let (mut weight, mut shift, mut scatter) = (0.0, Vec2::ZERO, RoughnessTensor::default());
    for e in entries.clone() {
        weight += e.weight;
        shift += (e.lobe.centre - first.centre) * e.weight;
        scatter = scatter + (e.lobe.scatter - first.scatter) * e.weight;
    }
    let inverse = 1.0 / weight;
    let centre = first.centre + shift * inverse;
    let (mut covariance, mut length) = (RoughnessTensor::default(), 0.0);
    for e in entries {
        let d = e.lobe.centre - centre;
        let off = d.length();
        let share = e.weight * inverse;
        length += off * share;
        let scale = share / off.max(f32::MIN_POSITIVE);
        covariance = covariance + RoughnessTensor { xx: d.x * d.x, xy: d.x * d.y, yy: d.y * d.y } * scale;
    }
    let scatter = first.scatter + scatter * inverse + covariance * length;
    Entry { weight, lobe: SlopeLobe { centre, scatter } }
}

/// Merges `entries` to at most `most`, near ones first: cells are cut at their mean, across the direction in which they
/// are longest, the cell with the largest weighted sum of squares first. What is near is measured by the shape of the whole.
pub fn merge_to(entries: &mut Vec<Entry>, most: usize, scratch: &mut Scratch) {
    if entries.len() > most {
        pulp::Arch::new().dispatch(MergeTo { entries, most, scratch });
    }
}

/// [`merge_to`], compiled for several processors. A type, and no closure: calls of closures are not inlined there.
struct MergeTo<'a> {
    entries: &'a mut Vec<Entry>,
    most: usize,
    scratch: &'a mut Scratch,
}

impl pulp::WithSimd for MergeTo<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        cut_and_merge(self.entries, self.most, self.scratch);
    }
}

#[inline(always)]
fn cut_and_merge(entries: &mut Vec<Entry>, most: usize, scratch: &mut Scratch) {
    let Scratch { placed, beyond, cells, merged } = scratch;
    place(entries, placed);
    beyond.resize(placed.len(), Placed::default());
    // Places are relative to the mean; widths are not.
    let about = Vec4::Z * placed[0].place;
    let whole = Sums::of(placed, about);
    cells.clear();
    cells.push(whole.cell(0, placed.len(), about));
    while cells.len() < most {
        let mut widest = 0;
        for i in 1..cells.len() {
            if cells[i].cost > cells[widest].cost {
                widest = i;
            }
        }
        if cells[widest].cost <= 0.0 {
            break;
        }
        match cut(placed, beyond, &cells[widest]) {
            Some([below, above]) => {
                cells[widest] = below;
                cells.push(above);
            }
            // Rounding: the entries are as good as equal.
            None => cells[widest].cost = 0.0,
        }
    }
    merged.clear();
    for c in &*cells {
        merged.push(match &placed[c.start..c.end] {
            [one] => entries[one.entry],
            members => merge(members.iter().map(|p| entries[p.entry])),
        });
    }
    std::mem::swap(entries, merged);
}

/// How much of a round shape is mixed with that of the whole. Without, a long tail makes what lies in it near; with much, lobes
/// across a long whole are merged.
const ROUND: f32 = 0.2;

/// Places of entries relative to the whole: to its mean and shape, and to its width.
#[inline(always)]
fn place(entries: &[Entry], placed: &mut Vec<Placed>) {
    placed.clear();
    let (mut sum, mut own) = (Vec4::ZERO, RoughnessTensor::default());
    for (i, Entry { weight, lobe: SlopeLobe { centre, scatter } }) in entries.iter().enumerate() {
        let z2 = 1.0 / (1.0 + centre.length_squared());
        let z = z2.sqrt();
        let place = Vec4::new(centre.x * z, centre.y * z, scatter.mean().sqrt() * z, 1.0);
        sum += *weight * place;
        own = own + *scatter * (z2 * weight);
        placed.push(Placed { place, weight: *weight, entry: i });
    }
    let inverse = 1.0 / sum.w;
    let about = sum * inverse * Vec4::new(1.0, 1.0, 0.0, 0.0);
    let sums = Sums::of(placed, about);
    // Of the differences from the mean themselves: of differences of sums, narrow footprints would keep rounding alone.
    let [xx, xy, yy, _] = sums.second.to_array();
    let whole = (own + RoughnessTensor { xx, xy, yy }) * inverse;
    let (middle, round) = (whole.mean(), ROUND * whole.mean());
    let l11 = (whole.xx + round).sqrt();
    let l21 = whole.xy / l11;
    let l22 = (whole.yy + round - l21 * l21).sqrt();
    let scale = Vec4::new(l11, l22, middle.sqrt(), 1.0).recip();
    let skew = -l21 * scale.x;
    for Placed { place, .. } in placed {
        let d = *place - about;
        *place = scale * (d + Vec4::Y * (skew * d.x));
    }
}

/// Weighted sums of differences d and of their products.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// x, y, z, 1.
    first: Vec4,
    /// xx, xy, yy, zz.
    second: Vec4,
}

impl Sums {
    /// Of places about another, whose last is 0.
    #[inline(always)]
    fn of(placed: &[Placed], about: Vec4) -> Self {
        let mut sums = Self::default();
        for p in placed {
            sums.add(p.weight, p.place - about);
        }
        sums
    }

    /// `d` with 1 as its last.
    #[inline(always)]
    fn add(&mut self, weight: f32, d: Vec4) {
        let weighted = weight * d;
        self.first += weighted;
        self.second += weighted.xxyz() * d.xyyz();
    }

    /// The mean's d, and the sums of products about it.
    #[inline(always)]
    fn about_mean(&self) -> (Vec4, [f32; 4]) {
        let mean = self.first * (1.0 / self.first.w);
        (mean.with_w(0.0), (self.second - self.first.xxyz() * mean.xyyz()).to_array())
    }

    /// The cell of these entries, of which the sums are about a place.
    #[inline(always)]
    fn cell(&self, start: usize, end: usize, about: Vec4) -> Cell {
        if end == start + 1 {
            return Cell { start, end, mean: about, axis: Vec4::ZERO, cost: 0.0 };
        }
        let (mean, [xx, xy, yy, zz]) = self.about_mean();
        let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let longest = middle + (half * half + xy * xy).sqrt();
        let (cost, axis) = if zz > longest {
            (zz, Vec4::Z)
        } else {
            // An eigenvector of the larger eigenvalue, of any length: the longer of two forms of it.
            let (a, b) = (longest - yy, longest - xx);
            (longest, if a > b { Vec4::new(a, xy, 0.0, 0.0) } else { Vec4::new(xy, b, 0.0, 0.0) })
        };
        Cell { start, end, mean: about + mean, axis, cost }
    }
}

/// Cuts a cell at its mean: what lies below comes first. None if nothing lies on one side. `beyond` is scratch.
///
/// A group that is tight beside its distance from this mean knows its own extent only to rounding, and its first cut may lie in
/// any direction; its parts are cut about a mean of their own.
///
/// Without branches, which would be mispredicted half the time: every entry is written to both sides, and one of them moves on.
#[inline(always)]
fn cut(placed: &mut [Placed], beyond: &mut [Placed], cell: &Cell) -> Option<[Cell; 2]> {
    let Cell { start, end, mean, axis, .. } = *cell;
    let members = &mut placed[start..end];
    let beyond = &mut beyond[..members.len()];
    let (mut below, mut above) = (Sums::default(), Sums::default());
    let mut count = 0;
    for i in 0..members.len() {
        let p = members[i];
        let d = p.place - mean;
        let is_above = axis.dot(d) >= 0.0;
        let weight = if is_above { p.weight } else { 0.0 };
        above.add(weight, d);
        below.add(p.weight - weight, d);
        members[count] = p;
        beyond[i - count] = p;
        count += usize::from(!is_above);
    }
    let rest = members.len() - count;
    members[count..].copy_from_slice(&beyond[..rest]);
    let middle = start + count;
    if count == 0 || rest == 0 {
        return None;
    }
    Some([below.cell(start, middle, mean), above.cell(middle, end, mean)])
}
