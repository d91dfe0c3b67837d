//! Vertices that are the same point, and sets that are joined.

use std::collections::HashMap;

use glam::Vec3;

/// For each key the number of the first equal key's group; groups are numbered 0, 1, ... as they appear. Also the
/// number of groups.
pub(super) fn weld<const N: usize>(keys: impl Iterator<Item = [u32; N]>) -> (Vec<u32>, usize) {
    let mut groups: HashMap<[u32; N], u32> = HashMap::with_capacity(keys.size_hint().0);
    let ids = keys
        .map(|key| {
            let next = groups.len() as u32;
            *groups.entry(key).or_insert(next)
        })
        .collect();
    (ids, groups.len())
}

/// The bits of a number, the same for both zeros.
pub(super) fn bits(x: f32) -> u32 {
    (x + 0.0).to_bits()
}

/// The group of each position: equal positions are one point, whatever else their vertices differ in.
pub(super) fn by_position(positions: &[Vec3]) -> (Vec<u32>, usize) {
    weld(positions.iter().map(|p| p.to_array().map(bits)))
}

/// Disjoint sets with path halving; the root of a set is its smallest member, so that the result does not depend on
/// the order of unions.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    /// `count` sets of one member.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The smallest member of the set of `i`.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let up = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = up;
            i = up;
        }
        i
    }

    /// Joins two sets.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_keys_share_a_group() {
        let (ids, count) = weld([[1u32], [2], [1], [3], [2]].into_iter());
        assert_eq!((ids, count), (vec![0, 1, 0, 2, 1], 3));
        let (ids, count) = by_position(&[Vec3::ZERO, Vec3::X, -Vec3::ZERO]);
        assert_eq!((ids, count), (vec![0, 1, 0], 2));
    }

    #[test]
    fn joined_sets_have_the_smallest_member_as_root() {
        let mut sets = Sets::new(5);
        sets.join(4, 2);
        sets.join(3, 4);
        assert_eq!((0..5).map(|i| sets.root(i)).collect::<Vec<_>>(), [0, 1, 2, 2, 2]);
    }
}
