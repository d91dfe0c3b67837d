//! How far pictures are from the truth.

use mipfold::compare::flicker;
use mipfold::render::{Image, display};
use ndarray::Array2;

/// Of a sequence, beside the truth's, over the pixels that see one surface in all frames.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// Root mean square of the difference in radiance, over that of the truth.
    pub error: f64,
    /// Root mean square of the difference in display values, 0 to 1. What is dim counts here: the tails of a GGX
    /// lobe, which grow with its width, though a pixel's curvature gives none.
    pub shown: f64,
    /// Wrong change of radiance from frame to frame over the truth's own change: 0 is right.
    pub flicker: f64,
    /// The same of display values, as `mipfold::compare` has it.
    pub shown_flicker: f64,
    /// Mean radiance over the truth's.
    pub energy: f64,
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v * v, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// The exposure that shows a truth well: its root mean square becomes 1.
pub fn exposure(truth: &[Image]) -> f32 {
    let seen = truth.iter().flatten().filter(|v| **v > 0.0).map(|v| f64::from(*v));
    1.0 / root_mean_square(seen).max(1e-12) as f32
}

/// Radiance that metal reflects of its surroundings besides the lights, times the exposure: mid grey on the display.
const SURROUNDINGS: f32 = 0.2;

/// Black where a pixel is not judged.
fn masked(frames: &[Image], mask: &Array2<bool>) -> Vec<Image> {
    let cut = |frame: &Image| {
        Image::from_shape_fn(frame.dim(), |(y, x, c)| if mask[(y, x)] { frame[(y, x, c)] } else { 0.0 })
    };
    frames.iter().map(cut).collect()
}

pub fn figures(frames: &[Image], truth: &[Image], mask: &Array2<bool>, exposure: f32) -> Figures {
    let (frames, truth) = (masked(frames, mask), masked(truth, mask));
    let share = (mask.iter().filter(|m| **m).count() as f64 / mask.len() as f64).sqrt();
    let off = |a: &[Image], b: &[Image]| {
        root_mean_square(a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b)))
    };
    let sum = |images: &[Image]| images.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    let black: Vec<Image> = truth.iter().map(|t| Image::zeros(t.dim())).collect();
    let shown = |images: &[Image]| {
        images.iter().map(|image| display(&(image + SURROUNDINGS / exposure), exposure)).collect::<Vec<_>>()
    };
    let (seen, right) = (shown(&frames), shown(&truth));
    let steps = |images: &[Image]| images.windows(2).map(|pair| &pair[1] - &pair[0]).collect::<Vec<_>>();
    let right_steps = steps(&truth);
    Figures {
        error: off(&frames, &truth) / off(&truth, &black),
        shown: off(&seen, &right) / share,
        flicker: off(&steps(&frames), &right_steps) / off(&right_steps, &black[1..]),
        shown_flicker: flicker(&seen, &right),
        energy: sum(&frames) / sum(&truth),
    }
}
