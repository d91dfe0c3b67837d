//! What the values of a channel look like.

use ndarray::Array3;

use super::subject::bands;
use crate::image::{Raster, Samples};

/// Bins of the histogram of a channel.
const BINS: usize = 256;

/// Values of one channel, integers scaled to 0..1.
#[derive(Clone, Debug)]
pub struct Stats {
    /// Least finite value.
    pub min: f64,
    /// Largest finite value.
    pub max: f64,
    /// Mean of the finite values.
    pub mean: f64,
    /// Their standard deviation.
    pub deviation: f64,
    /// How many different values there are; none for floats.
    pub distinct: Option<usize>,
    /// Whether a 16-bit channel holds nothing but 8-bit values: both bytes alike, as encoders widen them.
    pub widened: bool,
    /// Share of the texels in each 256th of 0..1.
    histogram: Vec<f64>,
}

impl Stats {
    /// Of one channel.
    pub fn of(raster: &Raster, channel: usize) -> Self {
        match &raster.samples {
            Samples::U8(samples) => Self::counted(&counts(samples, channel, 256), 255.0),
            Samples::U16(samples) => Self::counted(&counts(samples, channel, 65536), 65535.0),
            Samples::F32(_) => Self::floats(raster, channel),
        }
    }

    fn counted(counts: &[u64], most: f64) -> Self {
        let used = || counts.iter().enumerate().filter(|(_, n)| **n > 0).map(|(v, n)| (v as f64 / most, *n as f64));
        let total: f64 = used().map(|(_, n)| n).sum();
        let mean = used().map(|(v, n)| v * n).sum::<f64>() / total;
        let variance = used().map(|(v, n)| (v - mean).powi(2) * n).sum::<f64>() / total;
        let mut histogram = vec![0.0; BINS];
        used().for_each(|(v, n)| histogram[((v * BINS as f64) as usize).min(BINS - 1)] += n / total);
        let widened = counts.len() > 256 && counts.iter().enumerate().all(|(v, n)| *n == 0 || v % 257 == 0);
        Self {
            min: used().next().map_or(0.0, |(v, _)| v),
            max: used().next_back().map_or(0.0, |(v, _)| v),
            mean,
            deviation: variance.sqrt(),
            distinct: Some(used().count()),
            widened,
            histogram,
        }
    }

    fn floats(raster: &Raster, channel: usize) -> Self {
        let size = raster.size();
        let (mut min, mut max, mut sums, mut histogram) = (f64::INFINITY, f64::NEG_INFINITY, [0.0; 3], vec![0.0; BINS]);
        let mut row = vec![0.0; size.width];
        for y in 0..size.height {
            raster.read(channel, y, 0, &mut row);
            for v in row.iter().filter(|v| v.is_finite()).map(|v| f64::from(*v)) {
                (min, max) = (min.min(v), max.max(v));
                sums = [sums[0] + 1.0, sums[1] + v, sums[2] + v * v];
                histogram[((v.clamp(0.0, 1.0) * BINS as f64) as usize).min(BINS - 1)] += 1.0;
            }
        }
        let n = sums[0].max(1.0);
        let mean = sums[1] / n;
        histogram.iter_mut().for_each(|share| *share /= n);
        let deviation = (sums[2] / n - mean * mean).max(0.0).sqrt();
        let (min, max) = if sums[0] > 0.0 { (min, max) } else { (0.0, 0.0) };
        Self { min, max, mean, deviation, distinct: None, widened: false, histogram }
    }

    /// Whether all texels are one value, but for `tolerance`.
    pub fn is_constant(&self, tolerance: f64) -> bool {
        self.max - self.min <= tolerance
    }

    /// Share of the texels from `low` to `high`.
    pub fn share(&self, low: f64, high: f64) -> f64 {
        let bin = |v: f64| ((v * BINS as f64) as usize).min(BINS - 1);
        self.histogram[bin(low)..=bin(high)].iter().sum()
    }
}

fn counts<T: Copy + Into<usize> + Sync>(samples: &Array3<T>, channel: usize, values: usize) -> Vec<u64> {
    let (rows, width, channels) = samples.dim();
    let samples = samples.as_slice().expect("rasters are in standard layout");
    // Few bands: each has counts of its own.
    let parts = bands(rows.div_ceil(ROWS), |parts| {
        let mut counts = vec![0u32; values];
        for part in parts {
            let (from, to) = (part * ROWS, ((part + 1) * ROWS).min(rows));
            let texels = samples[from * width * channels..to * width * channels].chunks_exact(channels);
            texels.for_each(|texel| counts[texel[channel].into()] += 1);
        }
        counts
    });
    let mut all = vec![0; values];
    parts.iter().for_each(|part| all.iter_mut().zip(part).for_each(|(all, n)| *all += u64::from(*n)));
    all
}

const ROWS: usize = 16;

/// Pearson's correlation from sums of 1, a, b, a^2, b^2, ab; 0 where one of them does not vary.
pub fn correlation([n, a, b, aa, bb, ab]: [f64; 6]) -> f64 {
    let (va, vb) = (aa - a * a / n, bb - b * b / n);
    let least = 1e-12 * (aa + bb);
    if n < 3.0 || va <= least || vb <= least { 0.0 } else { (ab - a * b / n) / (va * vb).sqrt() }
}
