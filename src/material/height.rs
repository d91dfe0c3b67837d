//! Normals from heights.

use ndarray::Array3;
use rayon::prelude::*;

use crate::image::{Raster, Samples, Wrap};

/// A 16-bit OpenGL normal map of a height channel, by central differences under the wrap mode. `scale` is the
/// height of a stored 1 over a stored 0, in widths of the texture, so that the result does not depend on the
/// resolution.
pub(super) fn normals(raster: &Raster, channel: usize, scale: f32, wrap: Wrap) -> Raster {
    let size = raster.size();
    let row = |y: usize| {
        let mut row = vec![0.0; size.width];
        raster.read(channel, y, 0, &mut row);
        row
    };
    // Half the height difference of the neighbours, two texels apart, per texel; texels are square.
    let k = 0.5 * scale * size.width as f32;
    let rows: Vec<Vec<u16>> = (0..size.height)
        .into_par_iter()
        .map(|y| {
            let here = row(y);
            let (above, below) =
                (row(wrap.index(y as isize - 1, size.height)), row(wrap.index(y as isize + 1, size.height)));
            let mut out = Vec::with_capacity(3 * size.width);
            for x in 0..size.width {
                let [left, right] = [-1, 1].map(|d| here[wrap.index(x as isize + d, size.width)]);
                // v is up, rows go down.
                let (sx, sy) = (k * (right - left), k * (above[x] - below[x]));
                let inverse = 1.0 / (1.0 + sx * sx + sy * sy).sqrt();
                let encode = |v: f32| ((0.5 + 0.5 * v) * 65535.0).round() as u16;
                out.extend([encode(-sx * inverse), encode(-sy * inverse), encode(inverse)]);
            }
            out
        })
        .collect();
    let samples = Array3::from_shape_vec((size.height, size.width, 3), rows.concat()).expect("one row a row");
    Raster::new(Samples::U16(samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_worked_by_hand() {
        // Height rises by 0.25 a texel to the right and by 0.125 a row downwards; 4 texels wide, scale 0.5: slopes
        // 0.25 * 0.5 * 4 = 0.5 along u and -0.25 along v.
        let heights = Array3::from_shape_fn((4, 4, 1), |(y, x, _)| 0.25 * x as f32 + 0.125 * y as f32);
        let map = normals(&Raster::new(Samples::F32(heights)), 0, 0.5, Wrap::Clamp);
        let n = [0, 1, 2].map(|c| 2.0 * map.at(1, 1, c) - 1.0);
        assert!((n[0] / n[2] + 0.5).abs() < 1e-3 && (n[1] / n[2] - 0.25).abs() < 1e-3, "{n:?}");
    }

    #[test]
    fn one_texel_is_flat() {
        let map = normals(&Raster::new(Samples::U8(Array3::from_elem((1, 1, 1), 77))), 0, 1.0, Wrap::Repeat);
        assert!((map.at(0, 0, 2) - 1.0).abs() < 1e-6);
    }
}
