//! What a picture's values say about its meaning.

use glam::{DVec2, Vec2};

use super::source::SHORTEST_NORMAL;
use crate::image::{Raster, Size};

/// Calls `f` with the first three channels of every texel, row by row, until it says false; channels that the raster
/// lacks are 0. Whether it never did.
fn all_texels(raster: &Raster, mut f: impl FnMut([f32; 3]) -> bool) -> bool {
    let Size { width, height } = raster.size();
    let channels = raster.channels.len().min(3);
    let mut rows = [vec![0.0; width], vec![0.0; width], vec![0.0; width]];
    (0..height).all(|y| {
        rows.iter_mut().take(channels).enumerate().for_each(|(c, row)| raster.read(c, y, 0, row));
        (0..width).all(|x| f(rows.each_ref().map(|row| row[x])))
    })
}

/// How far float normals are from unit under one reading: the mean over texels of the length's error, at most 1 each,
/// so that no single texel decides; 1 for a normal that could not be used. Where z is rebuilt, of what x^2 + y^2 has
/// beyond 1, and the lean of the mean.
pub(super) fn off_unit(raster: &Raster, stored_z: bool, signed: bool) -> f64 {
    let decode = |v: f32| f64::from(if signed { v } else { 2.0 * v - 1.0 });
    let (mut off, mut mean) = (0.0, [0.0; 2]);
    all_texels(raster, |texel| {
        let [vx, vy, vz] = texel.map(decode);
        let xy = vx * vx + vy * vy;
        let length = (xy + vz * vz).sqrt();
        let error = if !stored_z {
            (xy - 1.0).max(0.0)
        } else if vz > 0.0 && length > f64::from(SHORTEST_NORMAL) {
            (length - 1.0).abs()
        } else {
            1.0
        };
        off += if error < 1.0 { error } else { 1.0 };
        if vx.is_finite() && vy.is_finite() {
            mean = [mean[0] + vx.clamp(-1.0, 1.0), mean[1] + vy.clamp(-1.0, 1.0)];
        }
        true
    });
    let lean = if stored_z { 0.0 } else { mean[0].abs() + mean[1].abs() };
    (off + lean) / raster.size().texels() as f64
}

/// Mean direction of a glTF anisotropy map (direction in the first two channels, strength in the third), weighted by
/// strength.
pub(super) fn mean_direction(raster: &Raster) -> Vec2 {
    let mut sum = DVec2::ZERO;
    all_texels(raster, |texel| {
        let [dx, dy, strength] = texel.map(f64::from);
        let direction = DVec2::new(2.0 * dx - 1.0, 2.0 * dy - 1.0) * strength;
        sum += if direction.is_finite() { direction } else { DVec2::ZERO };
        true
    });
    (sum / raster.size().texels() as f64).as_vec2()
}

/// Whether the first three channels are equal everywhere, within a JPEG's chroma error of two steps.
pub(super) fn is_gray(raster: &Raster) -> bool {
    all_texels(raster, |[r, g, b]| (r - g).abs() < 0.01 && (b - g).abs() < 0.01)
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

    #[test]
    fn float_normals_are_read_by_most_texels() {
        let map = |texel: &dyn Fn(usize) -> [f32; 3]| {
            Raster::new(Samples::F32(Array3::from_shape_fn((16, 16, 3), |(y, x, c)| texel(16 * y + x)[c])))
        };
        let signed = |raster: &Raster| off_unit(raster, true, true) < off_unit(raster, true, false);
        // Signed: islands in black, short normals. Packed: one hot texel, one that rings below 0.
        assert!(signed(&map(&|i| if i % 5 == 0 { [0.6, 0.0, 0.8] } else { [0.0; 3] })));
        assert!(signed(&map(&|_| [0.25, 0.1, 0.35])));
        assert!(!signed(&map(&|i| if i == 7 { [1e4, 1e4, 1e4] } else { [0.5, 0.5, 1.0] })));
        assert!(!signed(&map(&|i| if i == 7 { [-0.02, 0.5, 1.0] } else { [0.5, 0.5, 1.0] })));
    }
}
