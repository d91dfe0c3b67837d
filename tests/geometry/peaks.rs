//! The highlight of each light alone: how bright, how wide, how steady.

use glam::{DVec2, Vec2};
use mipfold::render::{Image, Light};
use ndarray::Array2;

use super::methods::{Known, METHODS, lobe};
use super::sequence::Sequence;
use super::shapes::Object;

/// Of one light, over many places of the pixels' grid.
#[derive(Clone, Copy, Debug)]
pub struct Highlight {
    /// Brightest pixel over the truth's, mean over frames.
    pub peak: f64,
    /// Deviation of the highlight's light about its middle over the truth's.
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

/// How far from a pixel light counts as the highlight's: the lobe's tails would have no deviation.
const REACH: f64 = 4.0;

/// Deviation (pixels) of the light about its middle, within reach of the truth's brightest pixel.
fn width(image: &Image, truth: &Image) -> f64 {
    let (rows, columns, _) = truth.dim();
    let places = || (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x)));
    let (y0, x0) = places().max_by(|a, b| truth[(a.0, a.1, 1)].total_cmp(&truth[(b.0, b.1, 1)])).unwrap();
    let (mut light, mut first, mut second) = (0.0, DVec2::ZERO, 0.0);
    for (y, x) in places() {
        let d = DVec2::new(x as f64 - x0 as f64, y as f64 - y0 as f64);
        if d.length() <= REACH {
            let radiance = f64::from(image[(y, x, 1)]);
            (light, first, second) = (light + radiance, first + radiance * d, second + radiance * d.length_squared());
        }
    }
    (second / light - (first / light).length_squared()).sqrt()
}

/// Mean, and deviation over it.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (mean, variance.sqrt() / mean)
}

/// For one light of an object: by method.
pub fn highlights(object: &Object, light: Light, alpha: f64) -> Vec<Highlight> {
    let alone = object.under(vec![light]);
    let sequence = Sequence::metal(&alone, &places(), &[alpha]);
    let (truth, mask) = (&sequence.truth[0], &sequence.mask);
    let peaks = |images: &[Image]| images.iter().map(|image| peak(image, mask)).collect::<Vec<_>>();
    let widths = |images: &[Image]| {
        let ratio = |(image, truth): (&Image, &Image)| width(image, truth) / width(truth, truth);
        images.iter().zip(truth).map(ratio).sum::<f64>() / truth.len() as f64
    };
    let right = peaks(truth);
    METHODS
        .iter()
        .map(|method| {
            let frames = sequence.draw(&|f, light| lobe((method.tensor)(&Known::new(&alone, f, light, alpha))));
            let found = peaks(&frames);
            let ratios: Vec<f64> = found.iter().zip(&right).map(|(a, b)| a / b).collect();
            Highlight {
                peak: spread(&ratios).0,
                width: widths(&frames),
                unsteady: spread(&found).1,
                truth_unsteady: spread(&right).1,
            }
        })
        .collect()
}
