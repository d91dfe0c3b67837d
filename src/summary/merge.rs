//! Many lobes of the slope plane become fewer.

use glam::Vec2;

use crate::ndf::{RoughnessTensor, SlopeLobe};

/// A lobe of a summary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Level-0 texels that it stands for.
    pub weight: f32,
    /// Where and how wide it is.
    pub lobe: SlopeLobe,
}

/// An entry, and where it lies among others: the centre's normal projected on the disk, and the width seen there.
#[derive(Clone, Copy, Default)]
struct Placed {
    entry: Entry,
    place: [f32; 3],
}

/// Entries that will become one.
#[derive(Clone, Copy)]
struct Cell {
    start: usize,
    end: usize,
    /// Weighted sum of squares along `axis`.
    cost: f32,
    axis: [f32; 3],
    cut: f32,
}

/// Buffers of [`merge_to`].
#[derive(Default)]
pub struct Scratch {
    placed: Vec<Placed>,
    cells: Vec<Cell>,
}

/// One lobe for several, of a weight above 0: the mean centre, and the mean scatter widened by the centres' covariance.
///
/// Beside a whole that is much wider, a lobe of scatter P counts as second moments do, by its nodes in a fit, whose covariance
/// is P: so the covariance C of the centres adds to it as it is. (By itself the smeared lobe would be closest to `P + 2 C`
/// down to `P + 1.2 C`, but many such would widen the whole.) Here `C = E|d| E[d d^T / |d|]` for differences d from the mean:
/// the covariance of two equal parts, and finite where lobes lie as a lobe's own slopes do, which have no covariance.
pub fn merge(entries: impl Iterator<Item = Entry> + Clone) -> Entry {
    let weight: f32 = entries.clone().map(|e| e.weight).sum();
    let share = |e: &Entry| e.weight / weight;
    // Differences from the first keep equal entries as they are.
    let first = entries.clone().next().expect("something to merge").lobe;
    let (mut shift, mut scatter) = (Vec2::ZERO, first.scatter);
    for e in entries.clone() {
        shift += (e.lobe.centre - first.centre) * share(&e);
        scatter = scatter + (e.lobe.scatter - first.scatter) * share(&e);
    }
    let centre = first.centre + shift;
    let (mut covariance, mut length) = (RoughnessTensor::default(), 0.0);
    for e in entries {
        let d = e.lobe.centre - centre;
        let off = d.length();
        length += off * share(&e);
        let scale = share(&e) / off.max(f32::MIN_POSITIVE);
        covariance = covariance + RoughnessTensor { xx: d.x * d.x, xy: d.x * d.y, yy: d.y * d.y } * scale;
    }
    Entry { weight, lobe: SlopeLobe { centre, scatter: scatter + covariance * length } }
}

/// Merges `entries` to at most `most`, near ones first: cells are cut at their mean, across the direction in which they
/// are longest, the cell with the largest weighted sum of squares first. What is near is measured by the shape of the whole.
pub fn merge_to(entries: &mut Vec<Entry>, most: usize, scratch: &mut Scratch) {
    if entries.len() <= most {
        return;
    }
    let Scratch { placed, cells } = scratch;
    placed.clear();
    placed.extend(entries.iter().map(|&entry| {
        let SlopeLobe { centre, scatter } = entry.lobe;
        let z = 1.0 / (1.0 + centre.length_squared()).sqrt();
        Placed { entry, place: [centre.x * z, centre.y * z, scatter.mean().sqrt() * z] }
    }));
    relate(placed);
    cells.clear();
    cells.push(cell(placed, 0, placed.len()));
    while cells.len() < most {
        let mut widest = 0;
        for i in 1..cells.len() {
            if cells[i].cost > cells[widest].cost {
                widest = i;
            }
        }
        let Cell { start, end, cost, axis, cut } = cells[widest];
        if cost <= 0.0 {
            break;
        }
        let middle = start + partition(&mut placed[start..end], axis, cut);
        if middle == start || middle == end {
            // Rounding: the entries are as good as equal.
            cells[widest].cost = 0.0;
            continue;
        }
        cells[widest] = cell(placed, start, middle);
        let other = cell(placed, middle, end);
        cells.push(other);
    }
    entries.clear();
    entries.extend(cells.iter().map(|c| merge(placed[c.start..c.end].iter().map(|p| p.entry))));
}

/// How much of a round shape is mixed with that of the whole. Without, a long tail makes what lies in it near; with much, lobes
/// across a long whole are merged.
const ROUND: f32 = 0.2;

/// Takes places relative to the whole: to its shape, and to its width.
fn relate(placed: &mut [Placed]) {
    let (mut weight, mut mean) = (0.0, Vec2::ZERO);
    for Placed { entry, place: [x, y, _] } in &*placed {
        weight += entry.weight;
        mean += entry.weight * Vec2::new(*x, *y);
    }
    mean /= weight;
    let mut whole = RoughnessTensor::default();
    for Placed { entry, place: [x, y, _] } in &*placed {
        let SlopeLobe { centre, scatter } = entry.lobe;
        let (x, y, z2) = (x - mean.x, y - mean.y, 1.0 / (1.0 + centre.length_squared()));
        whole = whole + (scatter * z2 + RoughnessTensor { xx: x * x, xy: x * y, yy: y * y }) * (entry.weight / weight);
    }
    let (middle, round) = (whole.mean(), ROUND * whole.mean());
    let l11 = (whole.xx + round).sqrt();
    let l21 = whole.xy / l11;
    let l22 = (whole.yy + round - l21 * l21).sqrt();
    for Placed { place: [x, y, z], .. } in placed {
        *x = (*x - mean.x) / l11;
        *y = (*y - mean.y - l21 * *x) / l22;
        *z /= middle.sqrt();
    }
}

fn cell(placed: &[Placed], start: usize, end: usize) -> Cell {
    let members = &placed[start..end];
    if members.len() == 1 {
        return Cell { start, end, cost: 0.0, axis: [0.0; 3], cut: 0.0 };
    }
    let (mut weight, mut mean) = (0.0, [0.0; 3]);
    for Placed { entry, place } in members {
        weight += entry.weight;
        (0..3).for_each(|i| mean[i] += entry.weight * place[i]);
    }
    (0..3).for_each(|i| mean[i] /= weight);
    let (mut spread, mut widths) = (RoughnessTensor::default(), 0.0);
    for Placed { entry, place } in members {
        let w = entry.weight;
        let [x, y, z] = [0, 1, 2].map(|i| place[i] - mean[i]);
        spread.xx += w * x * x;
        spread.xy += w * x * y;
        spread.yy += w * y * y;
        widths += w * z * z;
    }
    let (middle, half) = spread.mean_and_spread();
    let longest = middle + half;
    let (cost, axis) = if widths > longest {
        (widths, [0.0, 0.0, 1.0])
    } else {
        // An eigenvector of the larger eigenvalue, of any length: the longer of two forms of it.
        let (a, b) = (longest - spread.yy, longest - spread.xx);
        (longest, if a > b { [a, spread.xy, 0.0] } else { [spread.xy, b, 0.0] })
    };
    Cell { start, end, cost, axis, cut: along(axis, mean) }
}

#[inline(always)]
fn along(axis: [f32; 3], place: [f32; 3]) -> f32 {
    axis[0] * place[0] + axis[1] * place[1] + axis[2] * place[2]
}

/// Moves what lies below the cut to the front; how many that are.
fn partition(placed: &mut [Placed], axis: [f32; 3], cut: f32) -> usize {
    let mut below = 0;
    for i in 0..placed.len() {
        if along(axis, placed[i].place) < cut {
            placed.swap(below, i);
            below += 1;
        }
    }
    below
}
