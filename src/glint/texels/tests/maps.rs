//! Normal maps to try.

use glam::DVec2;
use ndarray::Array3;

/// A uniform number in 0..1 of a texel (SplitMix64's finaliser).
pub fn noise(seed: u64, x: i64, y: i64) -> f64 {
    let mut z = [x as u64, y as u64].iter().fold(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15), |z, v| {
        let z = (z ^ v.wrapping_mul(0xD1B5_4A32_D192_ED03)).wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z ^ (z >> 27)
    });
    z = z.wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

fn from_slopes((columns, rows): (usize, usize), slope: impl Fn(usize, usize) -> DVec2) -> Array3<f32> {
    Array3::from_shape_fn((rows, columns, 3), |(y, x, c)| {
        let s = slope(x, y);
        (glam::DVec3::new(-s.x, -s.y, 1.0).normalize())[c] as f32
    })
}

/// All texels alike.
pub fn flat(size: usize, slope: DVec2) -> Array3<f32> {
    from_slopes((size, size), |_, _| slope)
}

/// Smooth bumps a few texels wide, that repeat.
pub fn bumps(size: usize, steepness: f64) -> Array3<f32> {
    let wave = |k: u64, x: usize, y: usize| {
        let n = size as f64 / 6.0;
        let (fx, fy) = ((noise(k, 1, 0) * n).round() - (0.5 * n).round(), (noise(k, 2, 0) * n).round());
        let phase = std::f64::consts::TAU * ((fx * x as f64 + fy * y as f64) / size as f64 + noise(k, 3, 0));
        DVec2::new(fx, fy).normalize_or_zero() * phase.cos()
    };
    from_slopes((size, size), |x, y| (0..12).map(|k| wave(k, x, y)).sum::<DVec2>() * (steepness / 6f64.sqrt()))
}

/// Every texel a slope of its own, evenly over a square.
pub fn spikes(size: usize, steepness: f64) -> Array3<f32> {
    from_slopes((size, size), |x, y| {
        let (x, y) = (x as i64, y as i64);
        steepness * (2.0 * DVec2::new(noise(1, x, y), noise(2, x, y)) - 1.0)
    })
}

/// Straight grooves of two texels on a polished ground.
pub fn scratches(size: usize, steepness: f64) -> Array3<f32> {
    let cuts: Vec<(DVec2, f64)> = (0..size as i64 / 3)
        .map(|k| {
            let normal = DVec2::from_angle(std::f64::consts::TAU * noise(7, k, 0));
            (normal, (noise(7, k, 1) - 0.5) * 1.4 * size as f64)
        })
        .collect();
    from_slopes((size, size), |x, y| {
        let at = DVec2::new(x as f64, y as f64) - 0.5 * size as f64;
        cuts.iter()
            .map(|(normal, offset)| {
                let d = (at.dot(*normal) - offset) / 1.5;
                *normal * steepness * d * (1.0 - d * d).max(0.0).powi(2) * 3.5
            })
            .sum()
    })
}
