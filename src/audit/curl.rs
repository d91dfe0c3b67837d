//! Whether slopes are those of a surface, under four readings of red and green.
//!
//! Slopes p = dh/du and q = dh/dv of a height h have no curl: dp/dv = dq/du. A flipped green turns q into -q, swapped
//! channels exchange p and q; each reading has a curl of its own, and that of the right one is rounding and damage
//! alone. Flipping both keeps the energy of the curl: whether bumps are dents needs a height map.

use super::subject::{Normals, bands};

/// How red and green may be read, as the file is read now or otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// As it is.
    AsRead,
    /// Green the other way up.
    Flipped,
    /// Red and green exchanged.
    Swapped,
    /// Exchanged, and one of them the other way.
    Turned,
}

/// All of them, in the order of [`Curl::energies`].
pub const READINGS: [Reading; 4] = [Reading::AsRead, Reading::Flipped, Reading::Swapped, Reading::Turned];

/// What the curl says.
#[derive(Clone, Copy, Debug)]
pub struct Curl {
    /// Energy of the curl under each reading over that of all four derivatives, 0 to 2. White noise has 1/2 for each.
    pub energies: [f64; 4],
    /// Standard error of the difference between the energies of the reading as it is and each other one, from the
    /// spread between parts of the map.
    pub errors: [f64; 4],
    /// Share of the texels whose slopes change by more than rounding.
    pub live: f64,
}

/// A change of the slope by one 8-bit step: smaller ones are mostly rounding.
const STEP: f32 = 2.0 / 255.0;

/// Usual derivatives are found from one row in so many. Not a power of two, with which patterns would agree.
const SAMPLED: usize = 7;

/// The map is cut into so many parts each way, for the error.
const PARTS: usize = 8;

/// Sums over texels: a^2 + b^2, 2ab, c^2 + d^2, 2cd of a = dp/dv, b = dq/du, c = dq/dv, d = dp/du, weighted;
/// live texels; texels; the squares of all four.
type Sums = [f64; 7];

fn add(a: Sums, b: &Sums) -> Sums {
    std::array::from_fn(|i| a[i] + b[i])
}

fn energies([aa, ab, cc, cd, ..]: Sums) -> [f64; 4] {
    let all = (aa + cc).max(f64::MIN_POSITIVE);
    [aa - ab, aa + ab, cc - cd, cc + cd].map(|energy| energy / all)
}

impl Curl {
    /// Of a map. Central differences, for those commute with the differences that normals were made by. Where derivatives
    /// are larger than usual, a texel weighs in by their shape and not by their size, so that a few steep walls do not
    /// decide; where they are smaller, it fades out, for what is left there is mostly rounding and compression.
    pub fn of(normals: &Normals) -> Self {
        let sampled = sum(normals, STEP * STEP, |row| row % SAMPLED == 0);
        let all = sampled.iter().flatten().fold([0.0; 7], add);
        let usual = (all[6] / all[5].max(1.0)) as f32;
        Self::from_parts(&sum(normals, usual.max(STEP * STEP), |_| true))
    }

    fn from_parts(parts: &[[Sums; PARTS]]) -> Self {
        let mut tiles = [[0.0; 7]; PARTS * PARTS];
        for (i, part) in parts.iter().enumerate() {
            for (j, sums) in part.iter().enumerate() {
                let tile = &mut tiles[i * PARTS / parts.len() * PARTS + j];
                *tile = add(*tile, sums);
            }
        }
        let all = tiles.iter().fold([0.0; 7], add);
        // Jackknife over the parts.
        let n = tiles.len() as f64;
        let without: Vec<[f64; 4]> =
            tiles.iter().map(|tile| energies(std::array::from_fn(|i| all[i] - tile[i]))).collect();
        let errors = std::array::from_fn(|r| {
            let difference = |e: &[f64; 4]| e[r] - e[0];
            let mean = without.iter().map(difference).sum::<f64>() / n;
            let spread = without.iter().map(|e| (difference(e) - mean).powi(2)).sum::<f64>();
            (spread * (n - 1.0) / n).sqrt()
        });
        Self { energies: energies(all), errors, live: all[4] / all[5].max(1.0) }
    }
}

/// Sums of bands of rows, by parts of their columns; `usual` is the square of the size of usual derivatives.
fn sum(normals: &Normals, usual: f32, wanted: impl Fn(usize) -> bool + Sync) -> Vec<[Sums; PARTS]> {
    let size = normals.size();
    let width = size.width;
    bands(size.height, |rows| {
        let mut sums = [[0.0; 7]; PARTS];
        let mut z = vec![0.0; width];
        let mut ring: [[Vec<f32>; 2]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; width]));
        let mut held = None;
        for y in rows.start.max(1)..rows.end.min(size.height.saturating_sub(1)) {
            if !wanted(y) {
                continue;
            }
            if held == Some(y - 1) {
                ring.rotate_left(1);
                let [p, q] = &mut ring[2];
                normals.slopes(y + 1, p, q, &mut z);
            } else {
                for (i, [p, q]) in ring.iter_mut().enumerate() {
                    normals.slopes(y + i - 1, p, q, &mut z);
                }
            }
            held = Some(y);
            for part in 0..PARTS {
                let columns = (part * width / PARTS).max(1)..((part + 1) * width / PARTS).min(width.saturating_sub(1));
                sums[part] = add(sums[part], &row(&ring, columns, usual));
            }
        }
        sums
    })
}

fn row(ring: &[[Vec<f32>; 2]; 3], columns: std::ops::Range<usize>, usual: f32) -> Sums {
    let [[above, above_q], [p, q], [below, below_q]] = ring;
    let mut sums = [0.0f32; 7];
    for x in columns {
        // v points up, rows go down.
        let (a, b) = (0.5 * (above[x] - below[x]), 0.5 * (q[x + 1] - q[x - 1]));
        let (c, d) = (0.5 * (above_q[x] - below_q[x]), 0.5 * (p[x + 1] - p[x - 1]));
        let size = a * a + b * b + c * c + d * d;
        // Not where a normal cannot be used.
        let weight = if size.is_finite() { 1.0 / (usual + size) } else { 0.0 };
        let [a, b, c, d] = [a, b, c, d].map(|v| if weight > 0.0 { v } else { 0.0 });
        sums[0] += weight * (a * a + b * b);
        sums[1] += weight * 2.0 * a * b;
        sums[2] += weight * (c * c + d * d);
        sums[3] += weight * 2.0 * c * d;
        sums[4] += if weight > 0.0 && size > STEP * STEP { 1.0 } else { 0.0 };
        sums[5] += 1.0;
        sums[6] += a * a + b * b + c * c + d * d;
    }
    sums.map(f64::from)
}
