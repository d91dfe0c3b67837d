//! Texels beside the surface take what their neighbours have, so that texture filters see no hole.

use rayon::prelude::*;

use crate::image::Size;
use crate::ndf::RoughnessTensor;

/// Fills the texels without surface (coverage 0) that are within `steps` texels of one with, each from the mean of its
/// neighbours filled a step before; the texture repeats.
pub(super) fn dilate(size: Size, tensors: &mut [RoughnessTensor], coverage: &[f32], steps: usize) {
    let (width, height) = (size.width, size.height);
    let mut filled: Vec<bool> = coverage.iter().map(|&c| c > 0.0).collect();
    let around = |i: usize| {
        let (x, y) = (i % width, i / width);
        let (columns, rows) = ([x + width - 1, x, x + 1], [y + height - 1, y, y + 1]);
        rows.into_iter().flat_map(move |y| columns.map(|x| y % height * width + x % width))
    };
    if filled.iter().all(|f| *f) || !filled.iter().any(|f| *f) {
        return;
    }
    let border = |i: &usize, filled: &[bool]| !filled[*i] && around(*i).any(|j| filled[j]);
    let mut front: Vec<usize> = (0..filled.len()).into_par_iter().filter(|i| border(i, &filled)).collect();
    for _ in 0..steps {
        // All is filled; there may be any number of steps left.
        if front.is_empty() {
            break;
        }
        let mean = |&i: &usize| {
            let (mut sum, mut count) = (RoughnessTensor::default(), 0.0);
            for j in around(i).filter(|&j| filled[j]) {
                (sum, count) = (sum + tensors[j], count + 1.0);
            }
            sum * (1.0 / count)
        };
        let means: Vec<RoughnessTensor> = front.par_iter().map(mean).collect();
        for (&i, mean) in front.iter().zip(means) {
            (tensors[i], filled[i]) = (mean, true);
        }
        let mut next: Vec<usize> = front.iter().flat_map(|&i| around(i)).filter(|&j| !filled[j]).collect();
        next.sort_unstable();
        next.dedup();
        front = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_reaches_as_far_as_asked_and_around_the_edge() {
        let size = Size::new(8, 1);
        let mut coverage = vec![0.0; 8];
        let mut tensors = vec![RoughnessTensor::default(); 8];
        (coverage[0], coverage[3]) = (1.0, 0.5);
        (tensors[0].xx, tensors[3].xx) = (1.0, 3.0);
        dilate(size, &mut tensors, &coverage, 2);
        let xx: Vec<f32> = tensors.iter().map(|t| t.xx).collect();
        assert_eq!(xx, [1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 1.0, 1.0]);
        dilate(size, &mut tensors, &[0.0; 8], 2);
        // Ends when all is filled.
        dilate(size, &mut tensors, &coverage, usize::MAX);
    }
}
