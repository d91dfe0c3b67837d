//! Bringing maps of one set to one size.

use ndarray::Array3;
use rayon::prelude::*;

use crate::image::{Raster, Samples, Size, Wrap};

/// Enlarges a raster bilinearly: texel centres at half integers, `wrap` beyond the border, as a renderer samples
/// it. 8-bit data becomes 16-bit, so that nothing is rounded twice.
pub(super) fn enlarge(raster: &Raster, size: Size, wrap: Wrap) -> Raster {
    let from = raster.size();
    let across = taps(from.width, size.width, wrap);
    let down = taps(from.height, size.height, wrap);
    let channels = raster.channels.len();
    // One row of the target, all channels.
    let row = |y: usize| {
        let (y0, y1, fy) = down[y];
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        let mut source = vec![0.0; from.width];
        let mut out = vec![0.0; size.width * channels];
        for c in 0..channels {
            raster.read(c, y0, 0, &mut source);
            let upper: Vec<f32> = across.iter().map(|&(x0, x1, fx)| mix(source[x0], source[x1], fx)).collect();
            raster.read(c, y1, 0, &mut source);
            for (x, &(x0, x1, fx)) in across.iter().enumerate() {
                out[x * channels + c] = mix(upper[x], mix(source[x0], source[x1], fx), fy);
            }
        }
        out
    };
    let dim = (size.height, size.width, channels);
    let rows = (0..size.height).into_par_iter();
    let samples = match raster.samples {
        Samples::F32(_) => Samples::F32(array(dim, rows.flat_map_iter(row).collect())),
        _ => {
            let round = |v: f32| (v * 65535.0).round() as u16;
            Samples::U16(array(dim, rows.flat_map_iter(|y| row(y).into_iter().map(round)).collect()))
        }
    };
    Raster { samples, channels: raster.channels.clone() }
}

fn array<T>(dim: (usize, usize, usize), samples: Vec<T>) -> Array3<T> {
    Array3::from_shape_vec(dim, samples).expect("one row a row")
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
