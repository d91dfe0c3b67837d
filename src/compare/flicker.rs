//! Sequences of pictures: what changes that should not.

use ndarray::Array3;
use rayon::prelude::*;

use super::{MotionScore, flip};

/// A truth that changes by less than one step of an 8-bit display counts as changing by one: what is divided by it is
/// then an error in steps that could be seen, even where the truth stands still.
const STEP: f64 = 1.0 / 255.0;

/// Change from frame to frame that the truth does not show, over the change that it does show: the root mean square of
/// `(frame_t - frame_(t-1)) - (truth_t - truth_(t-1))` over that of `truth_t - truth_(t-1)`, or over a step of an 8-bit
/// display (1/255) if that is more. 0 is right; 1 is as much wrong change as right one, or frames that stand
/// still while the truth moves. A constant error is no flicker.
///
/// Both are display-encoded, 0 to 1, axes (row, column, channel), as the eye sees changes more alike there than in
/// radiance. Fewer than two frames do not flicker.
///
/// # Panics
/// If the sequences differ in length or any pictures in size.
pub fn flicker(frames: &[Array3<f32>], truth: &[Array3<f32>]) -> f64 {
    assert_eq!(frames.len(), truth.len(), "sequences of one length are compared");
    let (mut wrong, mut right, mut count) = (0.0, 0.0, 0usize);
    for (frames, truth) in frames.windows(2).zip(truth.windows(2)) {
        let size = frames[0].dim();
        assert!([&frames[1], &truth[0], &truth[1]].iter().all(|image| image.dim() == size), "pictures of one size");
        let values = frames[0].iter().zip(&frames[1]).zip(truth[0].iter().zip(&truth[1]));
        for ((before, after), (true_before, true_after)) in values {
            let expected = f64::from(*true_after) - f64::from(*true_before);
            wrong += (f64::from(*after) - f64::from(*before) - expected).powi(2);
            right += expected * expected;
            count += 1;
        }
    }
    let root_mean = |sum: f64| (sum / count.max(1) as f64).sqrt();
    root_mean(wrong) / root_mean(right).max(STEP)
}

/// How a sequence of pictures looks beside the truth: FLIP of each frame, and flicker. Both display-encoded sRGB, 0 to 1;
/// `pixels_per_degree` as of [`flip`].
///
/// # Panics
/// As [`flip`] and [`flicker`]; if there is no frame.
pub fn score_motion(
    motion: &'static str,
    chain: &str,
    frames: &[Array3<f32>],
    truth: &[Array3<f32>],
    pixels_per_degree: f32,
) -> MotionScore {
    assert!(!frames.is_empty(), "there is at least one frame");
    let flicker = flicker(frames, truth);
    let errors = |(truth, frame): (_, _)| flip(truth, frame, pixels_per_degree).into_iter().collect::<Vec<f32>>();
    let mut errors: Vec<f32> = truth.par_iter().zip(frames).map(errors).collect::<Vec<_>>().concat();
    // In the order of the pixels, so equal on any number of threads. Frames have one size: the mean of their means.
    let flip_mean = errors.iter().map(|error| f64::from(*error)).sum::<f64>() / errors.len() as f64;
    let rank = (0.95 * (errors.len() - 1) as f64).round() as usize;
    let flip_p95 = f64::from(*errors.select_nth_unstable_by(rank, f32::total_cmp).1);
    MotionScore { motion, chain: chain.to_owned(), flip_mean, flip_p95, flicker }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(values: &[f32]) -> Vec<Array3<f32>> {
        values.iter().map(|v| Array3::from_elem((6, 8, 3), *v)).collect()
    }

    #[test]
    fn flicker_worked_by_hand() {
        let truth = frames(&[0.2, 0.3, 0.4]);
        assert_eq!(flicker(&truth, &truth), 0.0);
        // A constant error does not flicker; standing still is an error of 1, moving twice as far too.
        assert!(flicker(&frames(&[0.5, 0.6, 0.7]), &truth) < 1e-6);
        assert!((flicker(&frames(&[0.3, 0.3, 0.3]), &truth) - 1.0).abs() < 1e-6);
        assert!((flicker(&frames(&[0.2, 0.4, 0.6]), &truth) - 1.0).abs() < 1e-6);
        // Wrong changes of 0.2 and -0.3 over right ones of 0.1: sqrt((0.1^2 + 0.4^2) / 2) / 0.1.
        assert!((flicker(&frames(&[0.2, 0.4, 0.1]), &truth) - 8.5f64.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn a_truth_that_stands_still_counts_in_steps() {
        let still = frames(&[0.5, 0.5, 0.5]);
        assert_eq!(flicker(&still, &still), 0.0);
        let step = 1.0 / 255.0;
        assert!((flicker(&frames(&[0.5, 0.5 + step, 0.5]), &still) - 1.0).abs() < 1e-4);
        assert!((flicker(&frames(&[0.5, 0.5 + 2.0 * step, 0.5]), &still) - 2.0).abs() < 1e-4);
        assert_eq!(flicker(&still[..1], &still[..1]), 0.0);
        assert_eq!(flicker(&[], &[]), 0.0);
    }

    #[test]
    fn scores_are_over_all_frames() {
        let truth = frames(&[0.5; 40]);
        let mut seen = truth.clone();
        // One frame of forty is wrong everywhere: below the 95th percentile. Three are above it.
        seen[7].fill(0.6);
        let one = score_motion("zoom", "mine", &seen, &truth, 67.0);
        let error = f64::from(flip(&truth[7], &seen[7], 67.0)[(0, 0)]);
        assert_eq!((one.motion, one.chain.as_str(), one.flip_p95), ("zoom", "mine", 0.0));
        assert!((one.flip_mean - error / 40.0).abs() < 1e-6 && one.flicker > 0.0);
        seen[8].fill(0.6);
        seen[9].fill(0.6);
        let three = score_motion("zoom", "mine", &seen, &truth, 67.0);
        assert!((three.flip_p95 - error).abs() < 1e-6);
        let same = score_motion("pan", "truth", &truth, &truth, 67.0);
        assert_eq!((same.flip_mean, same.flip_p95, same.flicker), (0.0, 0.0, 0.0));
    }
}
