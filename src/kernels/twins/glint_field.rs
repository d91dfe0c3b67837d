//! Twins of `kernels/wgsl/glint_field.wgsl`. The net is written once more from its definition, with keys as arguments; that it
//! is the library's is seen by [`glint_flake`], which asks the library. Sums are over all cells under the kernel.

use std::f64::consts::PI;

use glam::DVec2;

use super::glint::{GlintKernel, GlintLight, GlintPixel};
use super::glint_chance::pcg4d;
use crate::glint::{BIWEIGHT_AREA, DEPTH, Ellipse, Flake, Net, evaluator};

/// The even permutations of four digits keep 0 but for what is added; these are the images under m = 1, 2, 3 in the field of
/// four elements.
const TIMES: [[u32; 4]; 3] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2]];

/// Keys of a layer.
pub fn glint_net(seed: u32, layer: u32) -> [u32; 3] {
    let [a, b, c, _] = pcg4d([seed, layer, 0x51ED_2701, 0]);
    [a, b, c]
}

/// The short hash.
pub fn glint_mix(block: [i32; 2], prefix: u32, key: u32) -> u32 {
    let product = |v: u32, m: u32| (u64::from(v) * u64::from(m)) as u32;
    let sum = u64::from(product(block[0] as u32, 0x9E37_79B1)) + u64::from(product(block[1] as u32, 0x85EB_CA77));
    let mut h = (sum + u64::from(key)) as u32;
    h ^= h >> 15;
    h = product(h ^ product(prefix, 0xC2B2_AE3D), 0x2C1B_3C6D);
    h ^= h >> 14;
    product(h, 0x297A_2D39)
}

/// Which product, as a shift by bytes, and what is added: bits 29 to 14 scaled to three, and the top two.
pub fn glint_permutation(key: u32, level: i32, block: [i32; 2], digits: [u32; 2]) -> [u32; 2] {
    let key = key.wrapping_add((level as u32).wrapping_mul(0x632B_E5AB));
    let h = glint_mix(block, digits[0] | digits[1] << 16, key);
    [8 * (3 * (h >> 14 & 0xFFFF) / 65_536), h >> 30]
}

/// Digits k to `to` after the first k.
pub fn glint_digits(key: u32, cell: [i32; 2], k: i32, to: i32, first: [u32; 2]) -> [u32; 2] {
    (k..to).fold(first, |digits, level| {
        let parent = cell.map(|c| c.div_euclid(2 << level));
        let [shift, plus] = glint_permutation(key, level, parent, digits);
        let [i, j] = cell.map(|c| c.div_euclid(1 << level).rem_euclid(2) as usize);
        let digit = TIMES[shift as usize / 8][i + 2 * j] ^ plus;
        [2 * digits[0] + digit % 2, 2 * digits[1] + digit / 2]
    })
}

/// The cell in a block with these digits: at each level the child that has the digit.
pub fn glint_cell(key: u32, k: i32, block: [i32; 2], digits: [u32; 2]) -> [i32; 2] {
    (0..k).rev().fold(block, |cell, level| {
        let done = (k - 1 - level) as u32;
        let here = digits.map(|d| d >> done);
        let [shift, plus] = glint_permutation(key, level, cell, here.map(|d| d / 2));
        let digit = here[0] % 2 + 2 * (here[1] % 2);
        let child = (0..4).find(|c| TIMES[shift as usize / 8][*c] ^ plus == digit).expect("a permutation") as i32;
        [cell[0].wrapping_mul(2) + child % 2, cell[1].wrapping_mul(2) + child / 2]
    })
}

/// The flake of a cell, by the library.
pub fn glint_flake(seed: u32, layer: u32, cell: [i32; 2]) -> Flake {
    Net::new(seed, layer).flake(cell)
}

/// The fit to the variance of evenly filled nets.
pub fn glint_even_variance(n_eff: f64, anisotropy: f64) -> f64 {
    1.0 / (1.0 + 0.79 * n_eff.powf(0.75) / (1.0 + anisotropy.sqrt()))
}

/// The positive root of `a^2 = v (1 + 2a)`.
pub fn glint_exponent(variance: f64) -> f64 {
    let v = variance.max(0.0);
    v + (v * v + v).sqrt()
}

/// Centre, reach, slope, across, widest, in boxes.
pub fn glint_rows(kernel: GlintKernel, centre: DVec2, side: f64) -> [f64; 7] {
    let e = kernel.ellipse();
    let (c, reach) = (centre / side, DVec2::new(e.xx.sqrt(), e.yy.sqrt()) / side);
    [c.x, c.y, reach.x, reach.y, e.xy / e.yy, kernel.root / (e.yy.sqrt() * side), e.xy / (e.xx.sqrt() * side)]
}

/// First and last box of a row, by the library, from what [`glint_rows`] gives.
pub fn glint_row(rows: [f64; 7], j: i64) -> Option<[i64; 2]> {
    let [x, y, ex, ey, slope, across, _] = rows;
    let yy = ey * ey;
    let e = Ellipse { xx: across * across + slope * slope * yy, xy: slope * yy, yy };
    debug_assert!((e.xx.sqrt() / ex - 1.0).abs() < 1e-3);
    let mut found = None;
    e.rows(DVec2::new(x, y), 1.0, |row, first, last| {
        if row == j {
            found = Some([first, last]);
        }
    });
    found
}

/// Boxes about a coordinate of the chart.
pub fn glint_boxes(y: f64, radius: f64, blocks: i64) -> [i64; 2] {
    let side = blocks as f64;
    let boxes = [((y - radius) * side).floor() as i64, ((y + radius) * side).floor() as i64];
    if boxes[1] - boxes[0] >= blocks - 1 { [0, blocks - 1] } else { boxes }
}

/// A difference on a circle of 4096.
pub fn glint_apart(d: f64) -> f64 {
    (d + 2048.0).rem_euclid(4096.0) - 2048.0
}

/// The cheapest level before rounding.
pub fn glint_level(root: f64, radius: f64) -> f64 {
    (0.25 * root.log2() - 0.5 * radius.log2()).clamp(0.0, f64::from(DEPTH))
}

/// The sum over a layer's flakes, cell by cell.
pub fn glint_layer(pixel: &GlintPixel, light: &GlintLight, seed: u32, layer: u32, variance: f64) -> f64 {
    let scale = 0.5f64.powi(layer as i32);
    let net = Net::new(seed, layer);
    let e = pixel.kernel.ellipse().scaled(scale);
    let (inverse, exponent) = (e.inverse(), glint_exponent(variance));
    let at = (DVec2::new(f64::from(pixel.cell[0]), f64::from(pixel.cell[1])) + pixel.within) * scale;
    let radius2 = light.area / BIWEIGHT_AREA;
    let mut sum = 0.0;
    for j in (at.y - e.yy.sqrt()).floor() as i64..=(at.y + e.yy.sqrt()).floor() as i64 {
        for i in (at.x - e.xx.sqrt()).floor() as i64..=(at.x + e.xx.sqrt()).floor() as i64 {
            let flake = net.flake([i as i32, j as i32]);
            let t = inverse.of(DVec2::new(i as f64, j as f64) + flake.place - at);
            let d = flake.y - light.y;
            let s = (d - d.round()).length_squared() / radius2;
            if t < 1.0 && s < 1.0 {
                sum += ((1.0 - t) * (1.0 - s)).powi(2) * (1.0 + exponent) * flake.mark.powf(exponent);
            }
        }
    }
    sum * 9.0 / (PI * PI * e.determinant().sqrt() * radius2)
}

/// The library's evaluator.
pub fn glint_field(pixel: &GlintPixel, light: &GlintLight, seed: u32, variation: f64) -> f64 {
    (evaluator("field").expect("of the library").ratio)(&pixel.probe(light, seed, variation))
}

#[cfg(test)]
mod tests {
    use super::super::glint_chance::{fifth, unit};
    use super::*;

    #[test]
    fn the_net_of_the_definition_is_the_librarys() {
        for n in 0..300i32 {
            let cell = [n * 7919 - 1_000_000, n * 104_729 % 65_536];
            let [key, a, b] = glint_net(n as u32 % 5, 1);
            let flake = glint_flake(n as u32 % 5, 1, cell);
            let digits = glint_digits(key, cell, 0, DEPTH as i32, [0, 0]);
            assert_eq!(digits.map(f64::from), (flake.y * 4096.0).floor().to_array());
            let h = pcg4d([cell[0] as u32, cell[1] as u32, a, b]);
            assert_eq!((flake.mark, flake.place.x), (fifth(h), unit(h[0])));
            let k = n % 13;
            let block = cell.map(|c| c >> k);
            assert_eq!(glint_cell(key, k, block, digits.map(|d| d >> (12 - k))), cell);
            assert_eq!(Net::new(n as u32 % 5, 1).cell(k as u32, block, digits.map(|d| d >> (12 - k))), cell);
        }
    }
}
