//! A folded level back into the channels it came from.

use std::borrow::Cow;

use ndarray::Array3;

use super::{MapFile, Material, Origin, Role};
use crate::image::{Raster, Samples, Size};
use crate::ndf::{Axes, Form, Gltf, Lobes, RoughnessTensor};

/// How channels are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// 0..1, as integer files hold: normals as `0.5 + 0.5 v`.
    Unsigned,
    /// As float files hold: normals as -1..1, everything else as 0..1 (directions of anisotropy too, as glTF has them).
    Signed,
}

/// One folded level of a material, to be packed: level 0 has no lobes, since it is the input's own pixels.
#[derive(Clone, Copy)]
pub struct LevelView<'a> {
    /// The material.
    pub material: &'a Material,
    /// Lobes and plainly averaged channels (axes channel, row, column), for levels from 1 on.
    pub folded: Option<(&'a Lobes, &'a Array3<f32>)>,
    /// Radians: directions of anisotropy are written on this one's side. An axis has two; where neighbours choose
    /// differently, filtering the map cancels them.
    pub main_axis: f32,
}

impl<'a> LevelView<'a> {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.folded.map_or(self.material.size, |(lobes, _)| lobes.size())
    }

    /// Part of row `y` of a channel of a map, from column `x` on.
    pub fn row(&self, map: usize, channel: usize, encoding: Encoding, y: usize, x: usize, out: &mut [f32]) {
        let file = &self.material.maps[map];
        let role = file.roles[channel];
        match self.folded {
            None => {
                file.raster.read(channel, y, x, out);
                own_pixels(file, role, encoding, out);
                if let (Origin::Generated(_), Role::AnisotropyX | Role::AnisotropyY) = (&file.origin, role) {
                    // Of no strength; the direction is that of the levels to come, which it is mixed with.
                    let (sin, cos) = self.main_axis.sin_cos();
                    out.fill(0.5 + 0.5 * if role == Role::AnisotropyX { cos } else { sin });
                }
            }
            Some((lobes, others)) => {
                if let Role::Other(index) = role {
                    let row = others.index_axis(ndarray::Axis(0), index);
                    let row = row.index_axis_move(ndarray::Axis(0), y);
                    out.iter_mut().zip(row.iter().skip(x)).for_each(|(out, v)| *out = *v);
                } else {
                    let n = out.len();
                    self.of_lobe(role, encoding, lobes.form(), |plane| &lobes.row(plane, y)[x..x + n], out);
                }
            }
        }
    }

    /// What a channel holds of lobes, one a texel, whose planes are those of [`Lobes`].
    pub(super) fn of_lobe<'p>(
        &self,
        role: Role,
        encoding: Encoding,
        form: Form,
        part: impl Fn(usize) -> &'p [f32],
        out: &mut [f32],
    ) {
        match role {
            Role::NormalX | Role::NormalY | Role::NormalZ => {
                self.normal(role, encoding, [part(0), part(1), part(2)], out);
            }
            Role::Roughness | Role::Smoothness if form == Form::Isotropic => {
                for (out, a2) in out.iter_mut().zip(part(3)) {
                    let r = a2.sqrt().sqrt();
                    *out = if role == Role::Smoothness { 1.0 - r } else { r };
                }
            }
            role => {
                let planes = if form == Form::Isotropic { [3, 3, 3] } else { [3, 4, 5] };
                let [xx, xy, yy] = planes.map(part);
                for (i, out) in out.iter_mut().enumerate() {
                    let xy = if form == Form::Isotropic { 0.0 } else { xy[i] };
                    let axes = RoughnessTensor { xx: xx[i], xy, yy: yy[i] }.axes();
                    *out = anisotropic(role, axes, self.main_axis);
                }
            }
        }
    }

    /// Back through the renderer's own normal scale, then to the file's convention.
    fn normal(&self, role: Role, encoding: Encoding, [nx, ny, nz]: [&[f32]; 3], out: &mut [f32]) {
        let (k, sign) = (1.0 / self.material.normal_scale, self.material.normal_y.sign());
        let (part, factor) = match role {
            Role::NormalX => (nx, k),
            Role::NormalY => (ny, k * sign),
            _ => (nz, 1.0),
        };
        let (scale, offset) = if encoding == Encoding::Signed { (1.0, 0.0) } else { (0.5, 0.5) };
        if k == 1.0 {
            out.iter_mut().zip(part).for_each(|(out, v)| *out = offset + scale * factor * v);
            return;
        }
        for (i, out) in out.iter_mut().enumerate() {
            let length2 = k * k * (nx[i] * nx[i] + ny[i] * ny[i]) + nz[i] * nz[i];
            *out = offset + scale * factor * part[i] / length2.sqrt();
        }
    }

    /// The whole level of a map as an integer raster: 16 bit for float maps, else the map's own depth. Level 0 is the
    /// map's own raster where the depth allows.
    pub fn raster(&self, map: usize) -> Cow<'a, Raster> {
        let file = &self.material.maps[map];
        let bits = file.bits.min(16);
        let ready = !(matches!(file.origin, Origin::Generated(_)) && file.channel(Role::AnisotropyX).is_some());
        if self.folded.is_none() && file.raster.bits() == bits && ready {
            return Cow::Borrowed(&file.raster);
        }
        // Level 0 is the input's own pixels, however long its normals are.
        let xy = self.folded.and_then(|_| file.channel(Role::NormalX).zip(file.channel(Role::NormalY)));
        let row = |channel: usize, y: usize, row: &mut [f32]| self.row(map, channel, Encoding::Unsigned, y, 0, row);
        let samples = quantised(self.size(), file.roles.len(), bits, xy, row);
        Cow::Owned(Raster { samples, channels: file.raster.channels.clone() })
    }
}

/// A picture of 8 or 16 bits from rows of channels, 0..1: `row` fills row y of a channel. The channels `xy` are a normal's.
pub(crate) fn quantised(
    size: Size,
    channels: usize,
    bits: u8,
    xy: Option<(usize, usize)>,
    row: impl Fn(usize, usize, &mut [f32]),
) -> Samples {
    let dim = (size.height, size.width, channels);
    if bits == 8 {
        let samples = rounded(size, channels, xy, row, 255, |v| v as u8);
        Samples::U8(Array3::from_shape_vec(dim, samples).expect("every sample"))
    } else {
        let samples = rounded(size, channels, xy, row, 65535, |v| v as u16);
        Samples::U16(Array3::from_shape_vec(dim, samples).expect("every sample"))
    }
}

/// All samples, texel by texel, rounded to 0..max.
fn rounded<T: Copy + Default>(
    Size { width, height }: Size,
    channels: usize,
    xy: Option<(usize, usize)>,
    fill: impl Fn(usize, usize, &mut [f32]),
    max: i32,
    narrow: impl Fn(i32) -> T,
) -> Vec<T> {
    let mut row = vec![0.0; width];
    let mut rounded = vec![vec![0; width]; channels];
    let mut samples = vec![T::default(); width * height * channels];
    for (y, out) in samples.chunks_exact_mut(width * channels).enumerate() {
        for (channel, rounded) in rounded.iter_mut().enumerate() {
            fill(channel, y, &mut row);
            rounded.iter_mut().zip(&row).for_each(|(rounded, v)| *rounded = round(v.clamp(0.0, 1.0) * max as f32));
        }
        if let Some((cx, cy)) = xy {
            for i in 0..width {
                (rounded[cx][i], rounded[cy][i]) = inside_unit_disk(rounded[cx][i], rounded[cy][i], max);
            }
        }
        for (channel, rounded) in rounded.iter().enumerate() {
            out.chunks_exact_mut(channels).zip(rounded).for_each(|(texel, v)| texel[channel] = narrow(*v));
        }
    }
    samples
}

/// The nearest integer of 0..65535, ties to even: adding 1.5 * 2^23 leaves it in the low bits, and unlike a saturating
/// cast is one instruction in vector code.
#[inline(always)]
fn round(v: f32) -> i32 {
    const MAGIC: f32 = 12_582_912.0;
    ((v + MAGIC).to_bits() & 0xffff) as i32
}

/// The nearest stored pair towards the centre whose decoded x^2 + y^2 is at most 1: renderers that rebuild z take the
/// root of what is left.
fn inside_unit_disk(mut x: i32, mut y: i32, max: i32) -> (i32, i32) {
    let side = |v: i32| i64::from(2 * v - max);
    while side(x) * side(x) + side(y) * side(y) > i64::from(max) * i64::from(max) {
        let longest = if side(x).abs() >= side(y).abs() { &mut x } else { &mut y };
        *longest -= side(*longest).signum() as i32;
    }
    (x, y)
}

/// Level 0 in another encoding, and without what is not a number.
fn own_pixels(file: &MapFile, role: Role, encoding: Encoding, out: &mut [f32]) {
    let normal = matches!(role, Role::NormalX | Role::NormalY | Role::NormalZ);
    for v in out {
        if normal {
            let signed = if file.signed { *v } else { 2.0 * *v - 1.0 };
            let flat = if role == Role::NormalZ { 1.0 } else { 0.0 };
            let signed = if signed.is_finite() { signed } else { flat };
            *v = if encoding == Encoding::Signed { signed } else { 0.5 + 0.5 * signed };
        } else if !v.is_finite() {
            *v = if role == Role::Roughness { 1.0 } else { 0.0 };
        }
    }
}

/// What a channel holds for a lobe of two widths: the smaller width as roughness, and glTF's strength and direction, on
/// the side of `main_axis`.
fn anisotropic(role: Role, axes: Axes, main_axis: f32) -> f32 {
    let Gltf { alpha, strength, direction } = Gltf::from_axes(axes.sided(main_axis));
    match role {
        Role::Roughness => alpha.perceptual().0,
        Role::Smoothness => alpha.perceptual().smoothness(),
        Role::AnisotropyX => 0.5 + 0.5 * direction.x,
        Role::AnisotropyY => 0.5 + 0.5 * direction.y,
        _ => strength,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roughness::Alpha;
    use proptest::prelude::*;

    #[test]
    fn rounds_to_the_nearest_integer() {
        for i in 0..=65535 {
            let v = i as f32;
            assert_eq!((round(v), round((v - 0.49).max(0.0)), round((v + 0.49).min(65535.0))), (i, i, i));
        }
    }

    proptest! {
        #[test]
        fn rounded_normals_never_leave_the_unit_disk(angle in 0.0f32..6.3, radius in 0.0f32..1.0, wide in any::<bool>()) {
            let max = if wide { 65535 } else { 255 };
            let round = |v: f32| ((0.5 + 0.5 * v) * max as f32 + 0.5) as i32;
            let (x, y) = (round(radius * angle.cos()), round(radius * angle.sin()));
            let (nx, ny) = inside_unit_disk(x, y, max);
            let decode = |v: i32| 2.0 * f64::from(v) / f64::from(max) - 1.0;
            prop_assert!(decode(nx).powi(2) + decode(ny).powi(2) <= 1.0);
            prop_assert!((nx - x).abs() <= 1 && (ny - y).abs() <= 1);
        }

        #[test]
        fn directions_of_neighbours_stay_on_one_side(angle in 1.2f32..1.9) {
            // Axes on both sides of the vertical, where the angle's own range has its seam.
            let angle = if angle > std::f32::consts::FRAC_PI_2 { angle - std::f32::consts::PI } else { angle };
            let axes = Axes { alpha_x: Alpha(0.5), alpha_y: Alpha(0.1), angle };
            prop_assert!(anisotropic(Role::AnisotropyY, axes, std::f32::consts::FRAC_PI_2) > 0.9);
        }
    }
}
