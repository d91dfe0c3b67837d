//! Which lobe of a mixture stands in which slot.
//!
//! Textures are filtered slot by slot: lobe `j` of a texel is mixed with lobe `j` of its neighbours and of the next level. So
//! the order is passed down the chain: the lobes of the coarsest texel stand by width, sharpest first, and those of every
//! other texel where they lie nearest to those of the texel above it: of all orders, the one with the least sum of squared
//! distances of normal and alpha, weighed by the shares of both. Neighbours have a texel above them in common, or ones that
//! were put in order by the same texel further up.

use ndarray::ArrayViewMut3;
use rayon::prelude::*;

use super::Level;
use crate::ndf::{Form, Lobes, MOST_LOBES};

/// Puts the lobes of all levels in order.
pub(super) fn order(levels: &mut [Level]) {
    for k in (0..levels.len()).rev() {
        let (finer, coarser) = levels.split_at_mut(k + 1);
        order_level(&mut finer[k].lobes, coarser.first().map(|level| &level.lobes));
    }
}

fn order_level(lobes: &mut Lobes, above: Option<&Lobes>) {
    let (form, count, stride, size) = (lobes.form(), lobes.count(), lobes.stride(), lobes.size());
    let orders = orders(count);
    let rows: Vec<_> = lobes.bands_mut(1).collect();
    rows.into_par_iter().enumerate().for_each(|(y, mut row)| {
        for x in 0..size.width {
            let own = slots(form, count, |plane| row[(plane, 0, x)]);
            let order = match above {
                None => by_width(&own[..count]),
                Some(above) => {
                    let (u, v) = (x * above.size().width / size.width, y * above.size().height / size.height);
                    let theirs = slots(form, count, |plane| above.planes()[(plane, v, u)]);
                    nearest(&orders, &own[..count], &theirs[..count])
                }
            };
            reorder(&mut row, x, stride, &order[..count]);
        }
    });
}

/// Share, normal on the disk, and alpha of a lobe.
#[derive(Clone, Copy, Default)]
struct Slot {
    weight: f32,
    place: [f32; 3],
}

fn slots(form: Form, count: usize, plane: impl Fn(usize) -> f32) -> [Slot; MOST_LOBES] {
    let stride = form.planes() + 1;
    let mut slots = [Slot::default(); MOST_LOBES];
    for (j, slot) in slots[..count].iter_mut().enumerate() {
        let p = |i: usize| plane(j * stride + i);
        let alpha2 = match form {
            Form::Isotropic => p(3),
            Form::Anisotropic => 0.5 * (p(3) + p(5)),
        };
        *slot = Slot { weight: p(form.planes()), place: [p(0), p(1), alpha2.sqrt()] };
    }
    slots
}

/// All orders of so many lobes: entry `j` tells which lobe goes to slot `j`.
fn orders(count: usize) -> Vec<[usize; MOST_LOBES]> {
    let mut orders = vec![[0; MOST_LOBES]];
    for j in 0..count {
        let taken = |order: &[usize; MOST_LOBES], lobe| order[..j].contains(&lobe);
        let next = |order: [usize; MOST_LOBES]| {
            (0..count).filter(move |lobe| !taken(&order, *lobe)).map(move |lobe| {
                let mut order = order;
                order[j] = lobe;
                order
            })
        };
        orders = orders.into_iter().flat_map(next).collect();
    }
    orders
}

fn by_width(own: &[Slot]) -> [usize; MOST_LOBES] {
    let mut order = [0, 1, 2, 3];
    order[..own.len()].sort_by(|a, b| own[*a].place[2].total_cmp(&own[*b].place[2]));
    order
}

fn nearest(orders: &[[usize; MOST_LOBES]], own: &[Slot], theirs: &[Slot]) -> [usize; MOST_LOBES] {
    let distance = |a: &Slot, b: &Slot| {
        let squares = a.place.iter().zip(b.place).map(|(a, b)| (a - b) * (a - b));
        (a.weight + b.weight) * squares.sum::<f32>()
    };
    let cost = |order: &[usize]| theirs.iter().zip(order).map(|(t, lobe)| distance(&own[*lobe], t)).sum::<f32>();
    let (mut best, mut least) = (orders[0], f32::INFINITY);
    for order in orders {
        let cost = cost(&order[..own.len()]);
        if cost < least {
            (best, least) = (*order, cost);
        }
    }
    best
}

fn reorder(row: &mut ArrayViewMut3<'_, f32>, x: usize, stride: usize, order: &[usize]) {
    for i in 0..stride {
        let mut values = [0.0; MOST_LOBES];
        order.iter().zip(&mut values).for_each(|(lobe, value)| *value = row[(lobe * stride + i, 0, x)]);
        (0..order.len()).for_each(|j| row[(j * stride + i, 0, x)] = values[j]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_orders_are_tried() {
        for (count, factorial) in [(2, 2), (3, 6), (4, 24)] {
            let mut orders = orders(count);
            assert_eq!(orders.len(), factorial);
            orders.sort_unstable();
            orders.dedup();
            assert_eq!(orders.len(), factorial);
            assert!(orders.iter().all(|order| (0..count).all(|lobe| order[..count].contains(&lobe))));
        }
    }
}
