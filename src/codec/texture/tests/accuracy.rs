//! What blocks cost, on bumps made by code: asserted closely enough that the table of the module's documentation holds.

use super::*;

const SIDE: usize = 256;

/// Slopes of waves of many lengths, 0.25 root mean square, and of a few steep dents.
fn slope(x: usize, y: usize) -> [f64; 2] {
    let (x, y) = (x as f64 / SIDE as f64, y as f64 / SIDE as f64);
    let mut slope = [0.0; 2];
    for i in 1..=24 {
        // The golden angle spreads directions evenly.
        let (sin, cos) = (2.399963 * f64::from(i)).sin_cos();
        let frequency = std::f64::consts::TAU * (1.0 + 0.9 * f64::from(i));
        let wave = 0.07 * (frequency * (cos * x + sin * y) + 5.0 * f64::from(i * i)).cos();
        slope[0] += cos * wave;
        slope[1] += sin * wave;
    }
    for (u, v) in [(0.3, 0.2), (0.7, 0.6), (0.15, 0.8)] {
        let (dx, dy) = (x - u, y - v);
        let dent = 900.0 * (-(dx * dx + dy * dy) * 3000.0).exp();
        slope[0] += dent * dx * 0.05;
        slope[1] += dent * dy * 0.05;
    }
    slope
}

fn normal(x: usize, y: usize) -> [f64; 3] {
    let [a, b] = slope(x, y);
    let length = (1.0 + a * a + b * b).sqrt();
    [-a / length, -b / length, 1.0 / length]
}

/// The normals as a texture has them, not rounded: 0 to 1.
fn normals() -> Raster {
    let samples = Array3::from_shape_fn((SIDE, SIDE, 3), |(y, x, c)| (0.5 + 0.5 * normal(x, y)[c]) as f32);
    Raster::new(Samples::F32(samples))
}

/// Occlusion, roughness, metalness: smooth, smooth, and patches of 0 and 1.
fn packed() -> Raster {
    let samples = Array3::from_shape_fn((SIDE, SIDE, 3), |(y, x, c)| match c {
        0 => (1.0 - 0.3 * normal(x, y)[0].abs()) as f32,
        1 => (0.4 + 0.6 * normal(x, y)[1]) as f32,
        _ => {
            if value(x / 9, y / 9, 0) > 0.6 {
                1.0
            } else {
                0.0
            }
        }
    });
    Raster::new(Samples::F32(samples))
}

struct Cost {
    psnr: f64,
    mean_degrees: f64,
    worst_degrees: f64,
}

/// Peak signal to noise in decibels over the channels that the format has and the raster too, and the angles between
/// normals if the channels are such; the third coordinate of two channels is what is left of unit length.
fn cost(raster: &Raster, format: TexelFormat, effort: Effort) -> Cost {
    let size = raster.size();
    let back = decode(&encode(raster, format, effort), size, format);
    let channels = format.channels().min(raster.samples.channels());
    let (mut squares, mut sum, mut worst) = (0.0, 0.0, 0f64);
    for (y, x) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (y, x))) {
        let difference = |c| f64::from(back.at(x, y, c)) - f64::from(raster.at(x, y, c));
        squares += (0..channels).map(|c| difference(c) * difference(c)).sum::<f64>();
        let axis = |c| 2.0 * f64::from(back.at(x, y, c)) - 1.0;
        let flat = [axis(0), if channels > 1 { axis(1) } else { 0.0 }];
        let z = match channels {
            3 => axis(2),
            _ => (1.0 - flat[0] * flat[0] - flat[1] * flat[1]).max(0.0).sqrt(),
        };
        let length = (flat[0] * flat[0] + flat[1] * flat[1] + z * z).sqrt();
        let n = normal(x, y);
        let cosine = (n[0] * flat[0] + n[1] * flat[1] + n[2] * z) / length;
        let degrees = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        sum += degrees;
        worst = worst.max(degrees);
    }
    let count = (size.texels() * channels) as f64;
    Cost { psnr: -10.0 * (squares / count).log10(), mean_degrees: sum / size.texels() as f64, worst_degrees: worst }
}

fn hold(name: &str, cost: &Cost, psnr: f64, mean: f64, worst: f64) {
    let Cost { psnr: found, mean_degrees, worst_degrees } = cost;
    let line = format!("{name}: {found:.2} dB, {mean_degrees:.3} degrees on average, {worst_degrees:.2} at worst");
    let near = |found: f64, expected: f64, tolerance: f64| (found - expected).abs() <= tolerance;
    assert!(near(*found, psnr, 0.05) && near(*mean_degrees, mean, 0.01) && near(*worst_degrees, worst, 0.5), "{line}");
}

#[test]
fn what_blocks_cost_normals() {
    let normals = normals();
    let of = |format, effort| cost(&normals, format, effort);
    hold("Rg8", &of(TexelFormat::Rg8, Effort::Fast), 58.93, 0.174, 0.35);
    hold("Bc5", &of(TexelFormat::Bc5, Effort::Fast), 49.62, 0.467, 2.37);
    hold("Bc7, fast", &of(TexelFormat::Bc7, Effort::Fast), 39.76, 1.502, 14.69);
    hold("Bc7, slow", &of(TexelFormat::Bc7, Effort::Slow), 44.54, 0.943, 6.04);
    hold("Uastc, fast", &of(TexelFormat::Uastc, Effort::Fast), 44.28, 0.979, 5.95);
    hold("Uastc, slow", &of(TexelFormat::Uastc, Effort::Slow), 44.68, 0.943, 5.34);
}

#[test]
fn what_blocks_cost_packed_maps() {
    let packed = packed();
    let psnr = |format, effort, expected: f64| {
        let found = cost(&packed, format, effort).psnr;
        assert!((found - expected).abs() <= 0.05, "{format:?} {effort:?}: {found:.2} dB");
    };
    psnr(TexelFormat::Bc4, Effort::Fast, 55.46);
    psnr(TexelFormat::Bc7, Effort::Fast, 42.35);
    psnr(TexelFormat::Bc7, Effort::Slow, 46.85);
    psnr(TexelFormat::Uastc, Effort::Fast, 45.40);
    psnr(TexelFormat::Uastc, Effort::Slow, 45.91);
}
