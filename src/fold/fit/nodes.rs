//! Places in the slope plane that stand for a footprint: some in each of its lobes.

use std::f32::consts::FRAC_1_SQRT_2;

use pulp::Simd;

use super::chunk::Atom;
use super::lanes::Lanes;
use super::mixture::{Part, metrics};
use super::scatter::{self, Metric, RING, Seen};

/// Nodes of a lobe.
pub(super) const COUNT: usize = 8;

/// Their places along its two axes: two rings, at the radii of the two Gauss-Legendre points of the radial distribution.
const PLACES: [[f32; 2]; COUNT] = {
    let (r1, r2) = (RING[0], RING[1] * FRAC_1_SQRT_2);
    [[r1, 0.0], [-r1, 0.0], [0.0, r1], [0.0, -r1], [r2, r2], [-r2, -r2], [r2, -r2], [-r2, r2]]
};

/// The nodes of all lobes of each footprint, [`COUNT`] a lobe.
pub struct Nodes<S: Simd> {
    /// Slopes.
    pub at: Vec<[Lanes<S>; 2]>,
    /// Weight of each node of a lobe, as a share of that of all.
    share: Vec<Lanes<S>>,
    /// 1 / (pi density of the footprint).
    rarity: Vec<Lanes<S>>,
}

impl<S: Simd> Nodes<S> {
    /// None yet.
    pub fn new() -> Self {
        Self { at: Vec::new(), share: Vec::new(), rarity: Vec::new() }
    }

    /// Those of some footprints, without their densities.
    #[inline(always)]
    pub fn place(&mut self, atoms: &[Atom<S>]) {
        self.at.clear();
        let mut whole = scatter::start(
            atoms,
            #[inline(always)]
            |k| atoms[k].w,
            None,
        );
        // Nodes turn with the footprint if their axes follow any lobe that does.
        let metric = Metric::new(&mut whole);
        for atom in atoms {
            let Seen { a: [ax, ay], b: [bx, by], .. } = Seen::new(atom, &whole, &metric);
            for [p, q] in PLACES {
                self.at.push([atom.x + p * ax + q * bx, atom.y + p * ay + q * by]);
            }
        }
    }

    /// The footprints' densities there, for [`Self::missed`].
    #[inline(always)]
    pub fn weigh(&mut self, atoms: &[Atom<S>]) {
        let all = scatter::weight(atoms).max(f32::MIN_POSITIVE).inverse();
        self.share.clear();
        self.rarity.clear();
        self.rarity.resize(self.at.len(), all.like(0.0));
        for atom in atoms {
            self.share.push(1.0 / COUNT as f32 * atom.w * all);
            let (i11, i22) = (atom.l11.inverse(), atom.l22.inverse());
            let scale = atom.w * all * i11 * i22;
            for (density, [x, y]) in self.rarity.iter_mut().zip(&self.at) {
                let along = (*x - atom.x) * i11;
                let across = (*y - atom.y - atom.l21 * along) * i22;
                let w = (along * along + across * across + 1.0).inverse();
                *density += scale * w * w;
            }
        }
        for density in &mut self.rarity {
            *density = density.max(f32::MIN_POSITIVE).inverse();
        }
    }

    /// How much of the footprint lobes miss, 0 to 1: half the integral of the difference of both densities, so half the lobe
    /// error if all that is reflected were seen alike.
    #[inline(always)]
    pub fn missed<const LOBES: usize>(&self, parts: &[Part<S>; LOBES]) -> Lanes<S> {
        let (zero, one) = (parts[0].share.like(0.0), parts[0].share.like(1.0));
        let mut lobes = *parts;
        let metrics = metrics(&mut lobes);
        let mut sum = zero;
        for (k, share) in self.share.iter().enumerate() {
            let mut missed = zero;
            for i in k * COUNT..(k + 1) * COUNT {
                let [x, y] = self.at[i];
                let mut density = zero;
                for j in 0..LOBES {
                    density += metrics[j].density(x - lobes[j].lobe.x, y - lobes[j].lobe.y).1;
                }
                // What is not a number stays so, and is never the least.
                let held = density * self.rarity[i];
                missed += one - held.above(one, one, held);
            }
            sum += *share * missed;
        }
        sum
    }
}
