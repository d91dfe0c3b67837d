//! What a picture's values say about its meaning.

use crate::image::{Raster, Size};

/// How far float normals are from unit under one reading: mean deviation of the length, or, where z is rebuilt, of
/// x^2 + y^2 beyond 1, and the lean of the mean.
pub(super) fn off_unit(raster: &Raster, stored_z: bool, signed: bool) -> f64 {
    let Size { width, height } = raster.size();
    let decode = |v: f32| f64::from(if signed { v } else { 2.0 * v - 1.0 });
    let mut rows = [vec![0.0; width], vec![0.0; width], vec![0.0; width]];
    let (mut off, mut mean, mut count) = (0.0, [0.0; 2], 0.0);
    for y in 0..height {
        let channels = if stored_z { 3 } else { 2 };
        rows.iter_mut().take(channels).enumerate().for_each(|(c, row)| raster.read(c, y, 0, row));
        for x in 0..width {
            let [vx, vy, vz] = rows.each_ref().map(|row| decode(row[x]));
            let xy = vx * vx + vy * vy;
            let error = if stored_z { ((xy + vz * vz).sqrt() - 1.0).abs() } else { (xy - 1.0).max(0.0) };
            if error.is_finite() {
                (off, count) = (off + error, count + 1.0);
                (mean[0], mean[1]) = (mean[0] + vx, mean[1] + vy);
            }
        }
    }
    let lean = if stored_z { 0.0 } else { mean[0].abs() + mean[1].abs() };
    if count > 0.0 { (off + lean) / count } else { f64::INFINITY }
}

/// Whether the first three channels are equal everywhere, within a JPEG's chroma error of two steps.
pub(super) fn is_gray(raster: &Raster) -> bool {
    let Size { width, height } = raster.size();
    let mut rows = [vec![0.0; width], vec![0.0; width], vec![0.0; width]];
    (0..height).all(|y| {
        rows.iter_mut().enumerate().for_each(|(c, row)| raster.read(c, y, 0, row));
        (0..width).all(|x| (rows[0][x] - rows[1][x]).abs() < 0.01 && (rows[2][x] - rows[1][x]).abs() < 0.01)
    })
}

#[cfg(test)]
mod tests {
    use ndarray::Array3;

    use super::*;
    use crate::image::Samples;

    #[test]
    fn gray_stored_as_colour_is_seen() {
        let picture = |g: u8| {
            Raster::new(Samples::U8(Array3::from_shape_fn((2, 2, 3), |(_, _, c)| if c == 1 { g } else { 100 })))
        };
        assert!(is_gray(&picture(101)) && !is_gray(&picture(110)));
    }
}
