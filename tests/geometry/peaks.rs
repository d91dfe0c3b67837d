//! The highlight of each light alone: how bright, how wide, how steady.

use glam::Vec2;
use mipfold::render::{Image, Light};
use ndarray::Array2;

use super::methods::{Known, Method, lobe};
use super::sequence::Sequence;
use super::shapes::Object;

/// Of one light, over many places of the pixels' grid.
#[derive(Clone, Copy, Debug)]
pub struct Highlight {
    /// Brightest pixel over the truth's, mean over frames.
    pub peak: f64,
    /// Pixels above half the truth's brightest over those of the truth, all frames together.
    pub width: f64,
    /// Deviation of the brightest pixel from frame to frame over its mean; beside it, that of the truth.
    pub unsteady: f64,
    pub truth_unsteady: f64,
}

/// Sixteen places, a quarter of a pixel apart.
fn places() -> Vec<Vec2> {
    (0..16).map(|i| 0.25 * Vec2::new((i % 4) as f32, (i / 4) as f32)).collect()
}

/// Brightest pixel, green.
fn peak(image: &Image, mask: &Array2<bool>) -> f64 {
    mask.indexed_iter().filter(|(_, m)| **m).map(|((y, x), _)| image[(y, x, 1)]).fold(0.0, f32::max).into()
}

fn above(image: &Image, mask: &Array2<bool>, level: f64) -> usize {
    mask.indexed_iter().filter(|((y, x), m)| **m && f64::from(image[(*y, *x, 1)]) > level).count()
}

/// Mean, and deviation over it.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (mean, variance.sqrt() / mean)
}

/// For one light of an object: by method.
pub fn highlights(object: &Object, light: Light, alpha: f64, methods: &[Method]) -> Vec<Highlight> {
    let alone = object.under(vec![light]);
    let sequence = Sequence::metal(&alone, &places(), &[alpha]);
    let (truth, mask) = (&sequence.truth[0], &sequence.mask);
    let peaks = |images: &[Image]| images.iter().map(|image| peak(image, mask)).collect::<Vec<_>>();
    let wide = |images: &[Image], peaks: &[f64]| -> usize {
        images.iter().zip(peaks).map(|(image, peak)| above(image, mask, 0.5 * peak)).sum()
    };
    let right = peaks(truth);
    methods
        .iter()
        .map(|method| {
            let frames = sequence.draw(&|f, light| lobe((method.tensor)(&Known::new(&alone, f, light, alpha))));
            let found = peaks(&frames);
            let ratios: Vec<f64> = found.iter().zip(&right).map(|(a, b)| a / b).collect();
            Highlight {
                peak: spread(&ratios).0,
                width: wide(&frames, &right) as f64 / wide(truth, &right) as f64,
                unsteady: spread(&found).1,
                truth_unsteady: spread(&right).1,
            }
        })
        .collect()
}
