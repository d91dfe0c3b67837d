//! One channel of a 4x4 block in 8 bytes: BC4, and twice BC5.
//!
//! A block holds two end values of 8 bit and 3 bits a texel that choose from a row of values between them (Direct3D 11.3
//! functional specification, section 19.5.11): eight evenly spaced ones if the first end is greater than the second, else
//! six and besides them 0 and 1. The row is much finer than 8 bit where a block is smooth, so values are fitted as they
//! are, and not rounded first: ends by least squares in turns with the choice of texels, then by trying their neighbours.

/// Rounding by [`ROUND`] is right up to 2^22, and vectorises where `f32::round` does not.
const ROUND: f32 = 12_582_912.0;

/// The most turns of least squares: few blocks take the last of them.
const TURNS: usize = 4;

/// The most steps of an end to a neighbouring value.
const STEPS: usize = 12;

/// How far from 0 and 255 values are taken to need a row of their own, at first.
const MARGINS: [f32; 3] = [0.5, 16.0, 40.0];

/// Two ends, `low <= high`, and the sum of squared differences that they leave.
#[derive(Clone, Copy, Debug)]
struct Ends {
    low: u8,
    high: u8,
    error: f32,
}

/// Encodes 16 values, row by row, in units of 1/255: 0 to 255, any fraction of it.
pub(super) fn encode(values: &[f32; 16]) -> [u8; 8] {
    let (low, high) = range(values.iter());
    let eight = if high > low { fit::<7>(values, low, high) } else { None };
    let exact = eight.is_some_and(|ends| ends.error == 0.0);

    // The values 0 and 1 are worth three of eight steps only if a texel is nearer to them than a step.
    let step = (high - low) / 7.0;
    let six = if !exact && (eight.is_none() || low <= step || 255.0 - high <= step) { six(values) } else { None };
    match (eight, six) {
        (Some(eight), Some(six)) if six.error < eight.error => pack::<5>(values, six),
        (Some(eight), _) => pack::<7>(values, eight),
        (None, Some(six)) => pack::<5>(values, six),
        (None, None) => {
            let middle = (0.5 * (low + high)).round() as i32;
            pack::<5>(values, ends::<5>(values, middle, middle).expect("equal ends make a row of six"))
        }
    }
}

/// The best row of six found, from several guesses of which texels 0 and 1 serve.
fn six(values: &[f32; 16]) -> Option<Ends> {
    MARGINS
        .iter()
        .filter_map(|margin| {
            let (low, high) = range(values.iter().filter(|v| (*margin..=255.0 - *margin).contains(*v)));
            // (If none is left, any ends will do.)
            fit::<5>(values, low.min(255.0), high.max(0.0))
        })
        .min_by(|a, b| a.error.total_cmp(&b.error))
}

fn range<'a>(values: impl Iterator<Item = &'a f32>) -> (f32, f32) {
    values.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Places on the row from `low` (0) to `high` (`N`), whole numbers.
fn places<const N: usize>(values: &[f32; 16], low: f32, high: f32) -> [f32; 16] {
    let scale = if high > low { N as f32 / (high - low) } else { 0.0 };
    let mut places = [0.0; 16];
    for i in 0..16 {
        places[i] = (((values[i] - low) * scale).clamp(0.0, N as f32) + ROUND) - ROUND;
    }
    places
}

/// Squared differences of the values from the row. A row of six (`N` is 5) has 0 and 255 besides.
fn errors<const N: usize>(values: &[f32; 16], places: &[f32; 16], low: f32, high: f32) -> [f32; 16] {
    let step = (high - low) / N as f32;
    let mut errors = [0.0; 16];
    for i in 0..16 {
        let difference = values[i] - (low + places[i] * step);
        errors[i] = difference * difference;
        if N == 5 {
            errors[i] = errors[i].min(values[i] * values[i]).min((255.0 - values[i]) * (255.0 - values[i]));
        }
    }
    errors
}

/// In four sums, so that it vectorises and is still the same everywhere.
fn sum(errors: &[f32; 16]) -> f32 {
    let mut sums = [0.0; 4];
    for four in errors.as_chunks::<4>().0 {
        for i in 0..4 {
            sums[i] += four[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Both ends as integers, with their error; nothing if a row of eight has equal ends, which the format cannot say.
fn ends<const N: usize>(values: &[f32; 16], low: i32, high: i32) -> Option<Ends> {
    let (low, high) = (low.clamp(0, 255) as u8, high.clamp(0, 255) as u8);
    if low > high || (N == 7 && low == high) {
        return None;
    }
    let (a, b) = (f32::from(low), f32::from(high));
    Some(Ends { low, high, error: sum(&errors::<N>(values, &places::<N>(values, a, b), a, b)) })
}

/// The best ends found for a row of `N` steps, from ends that are not integers yet.
fn fit<const N: usize>(values: &[f32; 16], low: f32, high: f32) -> Option<Ends> {
    let (mut low, mut high) = (low.min(high), high.max(low));
    let mut best = ends::<N>(values, low.floor() as i32, high.ceil() as i32);
    for _ in 0..TURNS {
        // Rounding may turn ends round that hardly differ.
        let Some(fitted) = least_squares::<N>(values, low, high) else { break };
        (low, high) = fitted;
        let found = ends::<N>(values, low.round() as i32, high.round() as i32);
        match (found, best) {
            (Some(new), Some(old)) if new.error >= old.error => break,
            (Some(_), _) => best = found,
            (None, _) => break,
        }
    }
    let mut best = best?;
    for _ in 0..STEPS {
        let (low, high) = (i32::from(best.low), i32::from(best.high));
        let neighbours = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1)];
        let found = neighbours
            .iter()
            .filter_map(|(a, b)| ends::<N>(values, low + a, high + b))
            .fold(best, |best, new| if new.error < best.error { new } else { best });
        if found.error >= best.error {
            break;
        }
        best = found;
    }
    Some(best)
}

/// The ends that fit best if every texel keeps its place on the row; as they are if the places say nothing about both;
/// none if they come out the wrong way round.
fn least_squares<const N: usize>(values: &[f32; 16], low: f32, high: f32) -> Option<(f32, f32)> {
    let places = places::<N>(values, low, high);
    let own = |i: usize| {
        // (A texel that 0 or 1 serve better says nothing about the ends.)
        let difference = values[i] - (low + places[i] * (high - low) / N as f32);
        N == 7 || difference.abs() <= values[i].min(255.0 - values[i])
    };
    let (mut aa, mut ab, mut bb, mut av, mut bv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for i in (0..16).filter(|i| own(*i)) {
        let b = places[i] / N as f32;
        let a = 1.0 - b;
        aa += a * a;
        ab += a * b;
        bb += b * b;
        av += a * values[i];
        bv += b * values[i];
    }
    let determinant = aa * bb - ab * ab;
    if determinant < 1e-4 {
        return Some((low, high));
    }
    let found = ((bb * av - ab * bv) / determinant, (aa * bv - ab * av) / determinant);
    (found.0 <= found.1).then_some(found)
}

/// The block: both ends, then 16 indices of 3 bits. Index 0 is the first end, 1 the second, the rest lie between.
fn pack<const N: usize>(values: &[f32; 16], ends: Ends) -> [u8; 8] {
    let (low, high) = (f32::from(ends.low), f32::from(ends.high));
    let places = places::<N>(values, low, high);
    let step = (high - low) / N as f32;
    let mut bits = 0u64;
    for i in 0..16 {
        let place = places[i] as u64;
        let from_first = if N == 7 { 7 - place } else { place };
        let mut index = match from_first {
            0 => 0,
            n if n == N as u64 => 1,
            n => n + 1,
        };
        if N == 5 {
            let difference = (values[i] - (low + places[i] * step)).abs();
            if values[i] < difference.min(255.0 - values[i]) {
                index = 6;
            } else if 255.0 - values[i] < difference {
                index = 7;
            }
        }
        bits |= index << (3 * i);
    }
    let (first, second) = if N == 7 { (ends.high, ends.low) } else { (ends.low, ends.high) };
    (u64::from(first) | u64::from(second) << 8 | bits << 16).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The row of values as the specification writes it, in units of 1/255.
    fn row(first: u8, second: u8) -> [f64; 8] {
        let (a, b) = (f64::from(first), f64::from(second));
        let mut row = [a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 255.0];
        if first > second {
            (2..8).for_each(|i| row[i] = ((8 - i) as f64 * a + (i - 1) as f64 * b) / 7.0);
        } else {
            (2..6).for_each(|i| row[i] = ((6 - i) as f64 * a + (i - 1) as f64 * b) / 5.0);
        }
        row
    }

    fn error(values: &[f32; 16], block: [u8; 8]) -> f64 {
        let row = row(block[0], block[1]);
        let bits = u64::from_le_bytes(block) >> 16;
        (0..16).map(|i| (row[(bits >> (3 * i) & 7) as usize] - f64::from(values[i])).powi(2)).sum()
    }

    /// The least error of all ends, each texel choosing the nearest value.
    fn least(values: &[f32; 16]) -> f64 {
        let mut least = f64::MAX;
        for first in 0..=255 {
            for second in 0..=255 {
                let row = row(first, second);
                let nearest = |v: &f32| row.iter().map(|r| (r - f64::from(*v)).powi(2)).fold(f64::MAX, f64::min);
                least = least.min(values.iter().map(nearest).sum());
            }
        }
        least
    }

    #[test]
    fn what_a_row_holds_is_exact() {
        let exact = |values: [f32; 16]| assert!(error(&values, encode(&values)) < 1e-7, "{values:?}");
        for value in [0.0, 1.0, 128.0, 254.0, 255.0] {
            exact([value; 16]);
        }
        exact(std::array::from_fn(|i| 40.0 + 10.0 * (i % 8) as f32));
        exact(std::array::from_fn(|i| [0.0, 100.0, 103.0, 115.0, 255.0][i % 5]));
        exact(std::array::from_fn(|i| [0.0, 255.0][i % 2]));
    }

    /// Values that differ by no more than their rounding: flat normals of float maps.
    #[test]
    fn rounding_noise_is_flat() {
        let next = |v: f32, ulps: i32| f32::from_bits(v.to_bits().wrapping_add_signed(ulps));
        for case in 0..4000i32 {
            let middle = [127.5, 127.500_01, 64.0, 254.999_98, 0.1][case as usize % 5];
            let values = std::array::from_fn(|i| {
                next(middle, (case * 31 + i as i32 * i as i32 * 7 + case / 5) % (2 + case % 4) - 1)
            });
            let error = error(&values, encode(&values));
            assert!(error < 16.0 * 0.26, "{values:?}: {error}");
        }
    }

    #[test]
    fn smooth_blocks_are_finer_than_8_bits() {
        let values = std::array::from_fn(|i| 127.3 + 0.04 * i as f32);
        // Rounded to 8 bits first, 127 and 128 are all that is left.
        let rounded: f64 = values.iter().map(|v: &f32| f64::from(v - v.round()).powi(2)).sum();
        let error = error(&values, encode(&values));
        assert!(error < rounded / 40.0, "{error} {rounded}");
    }

    #[test]
    fn close_to_the_best_ends_there_are() {
        let mut state = 7u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let (mut found, mut possible) = (0.0, 0.0);
        for case in 0..24 {
            let (centre, width) = (255.0 * random(), [2.0, 20.0, 120.0, 400.0][case % 4]);
            let values = std::array::from_fn(|_| (centre + width * (random() - 0.5)).clamp(0.0, 255.0));
            let (error, least) = (error(&values, encode(&values)), least(&values));
            assert!(error <= 1.25 * least + 1e-3, "case {case}: {error}, but {least} is possible");
            found += error;
            possible += least;
        }
        assert!(found < 1.05 * possible, "{found} {possible}");
    }
}
