//! How far panes are from the truth, in linear radiance.

use crate::renderer::Picture;

/// Figures of one pane over the frames of one distance. All are shares of the truth's mean radiance, and count the pixels
/// that the sphere covers wholly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Root of the mean square of pane - truth.
    pub error: f64,
    /// Mean of the pane over that of the truth.
    pub brightness: f64,
    /// Mean of abs((pane - pane before) - (truth - truth before)): change that should not be, or that is missing.
    pub flicker: f64,
    /// Mean of abs(pane - pane before).
    pub change: f64,
}

/// Of a pane beside the truth, frame by frame; at least one frame, and pictures of one size.
pub fn figures(pane: &[Picture], truth: &[Picture]) -> Figures {
    let whole = whole_pixels(truth);
    let values = |picture: &'_ Picture| -> Vec<f64> {
        whole.iter().flat_map(|&i| picture.pixels[i][..3].iter().map(|&v| f64::from(v))).collect()
    };
    let (pane, truth): (Vec<_>, Vec<_>) = (pane.iter().map(values).collect(), truth.iter().map(values).collect());
    let frames = pane.iter().zip(&truth);
    let (square, mean) = (
        average(frames.clone().flat_map(|(p, t)| p.iter().zip(t).map(|(p, t)| (p - t).powi(2)))),
        average(truth.iter().flatten().copied()),
    );
    let brightness = average(pane.iter().flatten().copied()) / mean;
    let steps = |of: &[Vec<f64>]| -> Vec<f64> {
        of.windows(2).flat_map(|w| w[1].iter().zip(&w[0]).map(|(after, before)| after - before)).collect()
    };
    let (pane, truth) = (steps(&pane), steps(&truth));
    Figures {
        error: square.sqrt() / mean,
        brightness,
        flicker: average(pane.iter().zip(&truth).map(|(p, t)| (p - t).abs())) / mean,
        change: average(pane.iter().map(|p| p.abs())) / mean,
    }
}

/// Pixels that the sphere covers in all frames. The mesh's corners turn, so that its rim is not quite the same in each.
pub fn whole_pixels(truth: &[Picture]) -> Vec<usize> {
    let covered = |&i: &usize| truth.iter().all(|frame| frame.pixels[i][3] >= 1.0);
    (0..truth[0].pixels.len()).filter(covered).collect()
}

fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    sum / f64::from(count.max(1))
}
