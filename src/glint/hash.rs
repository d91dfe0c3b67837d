//! Integer hashing: the source of chance for flakes, the same bits on every processor.
//!
//! Seeds are never made from floats: a rounding would move whole glints.

/// Four 32-bit words from four, well mixed in every bit: pcg4d of Jarzynski & Olano 2020, "Hash functions for GPU
/// rendering". All arithmetic wraps.
#[inline(always)]
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = v.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    w ^= w >> 16;
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// A uniform number from the top 23 bits, in the middle of its interval: never 0, never 1.
///
/// 23 bits and a half are what f32 holds exactly. With 24 the upper half of the range would round, the last value to 1,
/// and a shader would not agree with the processor.
#[inline(always)]
pub fn unit(bits: u32) -> f64 {
    (f64::from(bits >> 9) + 0.5) * (1.0 / 8_388_608.0)
}

/// A fifth uniform number of a hash, from the low bytes of its four words, which [`unit()`] leaves alone.
#[inline(always)]
pub fn fifth([x, y, z, w]: [u32; 4]) -> f64 {
    unit((x & 255) << 24 | (y & 255) << 16 | (z & 255) << 8 | (w & 255))
}

/// The digit of a scrambled net: 32 bits from a place, a direction so far and a key, for permutations of four.
///
/// Shorter than [`pcg4d`], since many are needed for a flake: three products deep.
#[inline(always)]
pub(super) fn mix(place: [u32; 2], prefix: u32, key: u32) -> u32 {
    let mut h = place[0].wrapping_mul(0x9E37_79B1).wrapping_add(place[1].wrapping_mul(0x85EB_CA77)).wrapping_add(key);
    h ^= h >> 15;
    h = (h ^ prefix.wrapping_mul(0xC2B2_AE3D)).wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 14;
    h.wrapping_mul(0x297A_2D39)
}

/// [`mix`] of four places, a square of two by two: two products each.
#[inline(always)]
pub(super) fn four(place: [u32; 2], prefix: u32, key: u32) -> [u32; 4] {
    let [x, y] = [0x9E37_79B1u32, 0x85EB_CA77];
    let first = place[0].wrapping_mul(x).wrapping_add(place[1].wrapping_mul(y)).wrapping_add(key);
    let (right, mask) = (first.wrapping_add(x), prefix.wrapping_mul(0xC2B2_AE3D));
    [first, right, first.wrapping_add(y), right.wrapping_add(y)].map(|h| {
        let h = ((h ^ h >> 15) ^ mask).wrapping_mul(0x2C1B_3C6D);
        (h ^ h >> 14).wrapping_mul(0x297A_2D39)
    })
}

#[cfg(test)]
#[allow(clippy::type_complexity)]
mod tests {
    use super::*;

    #[test]
    fn pcg4d_gives_the_words_of_its_definition() {
        // Worked out apart from this code, with integers of any length.
        let cases = [
            ([0, 0, 0, 0], [0x0f02_f829, 0x2d56_8769, 0x32b0_c43b, 0xd325_48ea]),
            ([1, 2, 3, 4], [0x3622_cd16, 0xf114_71d8, 0xe110_9b3f, 0x02b9_4c2f]),
            ([u32::MAX, 0, u32::MAX, 911], [0xc991_114b, 0xb9d8_1572, 0x40e2_43dd, 0x7fc9_9828]),
        ];
        for (v, expected) in cases {
            assert_eq!(pcg4d(v), expected, "{v:x?}");
        }
    }

    #[test]
    fn four_mixes_are_those_of_four_places() {
        for n in 0..1000 {
            let [x, y, prefix, key] = pcg4d([n, 5, 6, 7]);
            let places =
                [[x, y], [x.wrapping_add(1), y], [x, y.wrapping_add(1)], [x.wrapping_add(1), y.wrapping_add(1)]];
            assert_eq!(four([x, y], prefix, key), places.map(|place| mix(place, prefix, key)));
        }
    }

    /// Words of neighbouring boxes of one cell, and of the same box of neighbouring cells, are independent: chi-squared of
    /// pairs on a grid of 16 x 16 within 5 standard deviations, for the top bits and for rare small words.
    #[test]
    fn words_of_boxes_are_pairwise_independent() {
        let words = |i: u32, j: u32, a: u32| {
            let [_, _, prefix, key] = pcg4d([i, j, 3, 1]);
            four([a, 40], prefix, key)
        };
        for shift in [28, 24, 20] {
            // Of the words with smaller top bits.
            let bins = |a: u32, b: u32| {
                let top = |w: u32| w >> shift;
                (top(a) < 16 && top(b) < 16).then_some((top(a) << 4 | top(b)) as usize)
            };
            let side = if shift == 28 { 300 } else { 1200 };
            let mut cells = vec![[0u32; 256]; 5];
            for i in 0..side {
                for j in 0..side {
                    let [first, right, up, both] = words(i, j, i & 7);
                    let [beside, ..] = words(i + 1, j, i & 7);
                    for (n, other) in [right, up, both, beside].into_iter().enumerate() {
                        bins(first, other).into_iter().for_each(|bin| cells[n][bin] += 1);
                    }
                    bins(right, up).into_iter().for_each(|bin| cells[4][bin] += 1);
                }
            }
            for (n, cells) in cells.iter().enumerate() {
                let found = cells.iter().sum::<u32>();
                assert!(excess(cells).abs() < 5.0, "pair {n}: {}", excess(cells));
                // All the pairs: as many as chance makes.
                let share = 16.0 * f64::from(1u32 << shift) / 4_294_967_296.0;
                let expected = f64::from(side * side) * share * share;
                let off = (f64::from(found) - expected) / expected.sqrt();
                assert!(off.abs() < 5.0, "pair {n}, shift {shift}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn units_are_exact_in_f32_and_inside_their_range() {
        for bits in [0, 1 << 9, 0x7fff_ffff, 0x8000_0000, 0xdead_beef, u32::MAX] {
            let u = unit(bits);
            assert!(u > 0.0 && u < 1.0);
            assert_eq!(f64::from(u as f32), u);
        }
    }

    /// Chi-squared of counts in equal cells, in standard deviations above its mean.
    fn excess(cells: &[u32]) -> f64 {
        let mean = cells.iter().sum::<u32>() as f64 / cells.len() as f64;
        let chi2: f64 = cells.iter().map(|c| (f64::from(*c) - mean).powi(2) / mean).sum();
        let freedom = (cells.len() - 1) as f64;
        (chi2 - freedom) / (2.0 * freedom).sqrt()
    }

    /// The five numbers of a cell's hash, each pair of them on a grid of 16 x 16, over neighbouring cells: chi-squared
    /// within 5 standard deviations (ten pairs).
    #[test]
    fn the_five_numbers_of_a_hash_are_uniform_and_pairwise_independent() {
        let mut cells = vec![[0u32; 256]; 10];
        for n in 0..200_000u32 {
            let h = pcg4d([n % 447, n / 447, 7, 911]);
            let u = [unit(h[0]), unit(h[1]), unit(h[2]), unit(h[3]), fifth(h)].map(|u| (u * 16.0) as usize);
            let pairs = (0..5).flat_map(|a| (0..a).map(move |b| (a, b)));
            for (pair, (a, b)) in pairs.enumerate() {
                cells[pair][u[a] * 16 + u[b]] += 1;
            }
        }
        for (pair, cells) in cells.iter().enumerate() {
            assert!(excess(cells).abs() < 5.0, "pair {pair}: {}", excess(cells));
        }
    }

    /// Top bits of the short hash over neighbouring places and prefixes, with the same of the next place, the next
    /// prefix and the next key: chi-squared within 5 standard deviations.
    #[test]
    fn short_hashes_of_neighbours_are_independent() {
        type Step = fn([u32; 2], u32, u32) -> u32;
        let steps: [Step; 5] = [
            |[i, j], p, k| mix([i.wrapping_add(1), j], p, k),
            |[i, j], p, k| mix([i, j.wrapping_add(1)], p, k),
            |[i, j], p, k| mix([i, j], p + 1, k),
            |[i, j], p, k| mix([i, j], p + 65_536, k),
            |[i, j], p, k| mix([i, j], p, k.wrapping_add(0x9E37_79B9)),
        ];
        for (n, step) in steps.iter().enumerate() {
            let mut cells = [0u32; 576];
            for m in 0..200_000u32 {
                let (place, prefix) = ([m % 61, m / 61 % 53], (m / 3233 % 8) | (m / 25_864) << 16);
                let top = |h: u32| ((u64::from(h) * 24) >> 32) as usize;
                cells[top(mix(place, prefix, 5)) * 24 + top(step(place, prefix, 5))] += 1;
            }
            assert!(excess(&cells).abs() < 5.0, "step {n}: {}", excess(&cells));
        }
    }
}
