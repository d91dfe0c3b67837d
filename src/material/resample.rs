//! Bringing maps of one set to one size.

use ndarray::Array3;

use crate::image::{Raster, Samples, Size, Wrap};

/// Enlarges a raster bilinearly: texel centres at half integers, `wrap` beyond the border, as a renderer samples
/// it. 8-bit data becomes 16-bit, so that nothing is rounded twice.
pub(super) fn enlarge(raster: &Raster, size: Size, wrap: Wrap) -> Raster {
    let from = raster.size();
    let across = taps(from.width, size.width, wrap);
    let down = taps(from.height, size.height, wrap);
    let sample = |x: usize, y: usize, c: usize| {
        let ((x0, x1, fx), (y0, y1, fy)) = (across[x], down[y]);
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        let row = |y| mix(raster.at(x0, y, c), raster.at(x1, y, c), fx);
        mix(row(y0), row(y1), fy)
    };
    let dim = (size.height, size.width, raster.channels.len());
    let samples = match raster.samples {
        Samples::F32(_) => Samples::F32(Array3::from_shape_fn(dim, |(y, x, c)| sample(x, y, c))),
        _ => Samples::U16(Array3::from_shape_fn(dim, |(y, x, c)| (sample(x, y, c) * 65535.0).round() as u16)),
    };
    Raster { samples, channels: raster.channels.clone() }
}

/// For each target texel: two source texels and the share of the second.
fn taps(from: usize, to: usize, wrap: Wrap) -> Vec<(usize, usize, f32)> {
    (0..to)
        .map(|i| {
            let at = (i as f64 + 0.5) * from as f64 / to as f64 - 0.5;
            let first = at.floor() as isize;
            (wrap.index(first, from), wrap.index(first + 1, from), (at - at.floor()) as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubling_worked_by_hand() {
        let raster = Raster::new(Samples::U8(Array3::from_shape_vec((1, 2, 1), vec![0, 255]).unwrap()));
        let row = |wrap| {
            let big = enlarge(&raster, Size::new(4, 1), wrap);
            (0..4).map(|x| big.at(x, 0, 0)).collect::<Vec<_>>()
        };
        let close = |a: Vec<f32>, b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
        assert!(close(row(Wrap::Clamp), [0.0, 0.25, 0.75, 1.0]));
        assert!(close(row(Wrap::Repeat), [0.25, 0.25, 0.75, 0.75]));
    }

    #[test]
    fn constants_stay_and_floats_stay_floats() {
        let raster = Raster::new(Samples::F32(Array3::from_elem((3, 5, 1), -0.7)));
        let big = enlarge(&raster, Size::new(11, 8), Wrap::Mirror);
        assert_eq!((big.size(), big.bits()), (Size::new(11, 8), 32));
        assert!((0..11).all(|x| (big.at(x, 7, 0) + 0.7).abs() < 1e-6));
    }
}
