//! An image of lobes, planar.

use glam::Vec3;
use ndarray::iter::AxisChunksIterMut;
use ndarray::{Array3, ArrayView3, Axis, Ix3};

use super::{Lobe, RoughnessTensor};
use crate::image::Size;

/// How much of a lobe's shape is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// One width: the drop-in form for every engine.
    Isotropic,
    /// Two widths and a direction.
    Anisotropic,
}

impl Form {
    /// Planes of a [`Lobes`] image: normal x y z, then alpha^2, or xx xy yy of the tensor.
    pub const fn planes(self) -> usize {
        match self {
            Form::Isotropic => 4,
            Form::Anisotropic => 6,
        }
    }
}

/// Most lobes of a texel.
pub const MOST_LOBES: usize = 4;

/// One mip level as lobes: planes of f32, axes (plane, row, column). Planes 0..3 hold the unit normal; an
/// isotropic image adds alpha^2, an anisotropic one `R.xx R.xy R.yy` in the bent frame of the normal.
///
/// A texel may hold several lobes: then each has these planes and one more, its weight, one lobe after the other. A weight
/// is the share of the texel's area that the lobe stands for; they sum to 1, and a lobe of weight 0 is not there.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobes {
    form: Form,
    count: usize,
    planes: Array3<f32>,
}

impl Lobes {
    /// All zeros, to be filled.
    pub fn zeros(form: Form, size: Size) -> Self {
        Self::mixed_zeros(form, 1, size)
    }

    /// All zeros, `count` lobes a texel, 1 to [`MOST_LOBES`].
    pub fn mixed_zeros(form: Form, count: usize, size: Size) -> Self {
        assert!((1..=MOST_LOBES).contains(&count));
        let planes = if count == 1 { form.planes() } else { count * (form.planes() + 1) };
        Self { form, count, planes: Array3::zeros((planes, size.height, size.width)) }
    }

    /// One lobe a texel.
    pub fn from_fn(form: Form, size: Size, mut lobe: impl FnMut(usize, usize) -> Lobe) -> Self {
        let mut lobes = Self::zeros(form, size);
        for y in 0..size.height {
            for x in 0..size.width {
                let Lobe { normal, roughness: r } = lobe(x, y);
                let values = match form {
                    Form::Isotropic => [normal.x, normal.y, normal.z, 0.5 * (r.xx + r.yy), 0.0, 0.0],
                    Form::Anisotropic => [normal.x, normal.y, normal.z, r.xx, r.xy, r.yy],
                };
                for (plane, value) in values.into_iter().take(form.planes()).enumerate() {
                    lobes.planes[(plane, y, x)] = value;
                }
            }
        }
        lobes
    }

    /// Isotropic or anisotropic.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Lobes a texel.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Planes from the first of a lobe to the first of the next one.
    pub fn stride(&self) -> usize {
        self.form.planes() + usize::from(self.count > 1)
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        let (_, height, width) = self.planes.dim();
        Size::new(width, height)
    }

    /// The lobe of a texel; the first, of several.
    pub fn at(&self, x: usize, y: usize) -> Lobe {
        self.lobe(0, x, y)
    }

    /// All lobes of a texel that are there, each with its weight.
    pub fn mixture(&self, x: usize, y: usize) -> impl Iterator<Item = (Lobe, f32)> + '_ {
        let weight = move |j: usize| match self.count {
            1 => 1.0,
            _ => self.planes[(j * self.stride() + self.form.planes(), y, x)],
        };
        (0..self.count).map(move |j| (self.lobe(j, x, y), weight(j))).filter(|(_, weight)| *weight > 0.0)
    }

    /// Lobe `j` of a texel.
    fn lobe(&self, j: usize, x: usize, y: usize) -> Lobe {
        let p = |plane| self.planes[(j * self.stride() + plane, y, x)];
        let roughness = match self.form {
            Form::Isotropic => RoughnessTensor { xx: p(3), xy: 0.0, yy: p(3) },
            Form::Anisotropic => RoughnessTensor { xx: p(3), xy: p(4), yy: p(5) },
        };
        Lobe { normal: Vec3::new(p(0), p(1), p(2)), roughness }
    }

    /// The planes, axes (plane, row, column).
    pub fn planes(&self) -> ArrayView3<'_, f32> {
        self.planes.view()
    }

    /// The planes, cut into bands of `rows` rows, to be filled side by side.
    pub fn bands_mut(&mut self, rows: usize) -> AxisChunksIterMut<'_, f32, Ix3> {
        self.planes.axis_chunks_iter_mut(Axis(1), rows)
    }

    /// One row of one plane.
    pub fn row(&self, plane: usize, y: usize) -> &[f32] {
        let width = self.planes.dim().2;
        let start = (plane * self.planes.dim().1 + y) * width;
        &self.planes.as_slice().expect("standard layout")[start..start + width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roughness::Alpha;

    #[test]
    fn stores_what_it_was_given() {
        let lobe = |x: usize, y: usize| Lobe {
            normal: Vec3::new(0.1 * x as f32, 0.0, 1.0).normalize(),
            roughness: RoughnessTensor { xx: 0.1 + 0.1 * y as f32, xy: 0.01, yy: 0.2 },
        };
        let lobes = Lobes::from_fn(Form::Anisotropic, Size::new(3, 2), lobe);
        assert_eq!(lobes.at(2, 1), lobe(2, 1));
        assert_eq!(lobes.row(5, 1), [0.2; 3]);
        let flat = Lobes::from_fn(Form::Isotropic, Size::new(1, 1), |_, _| Lobe::isotropic(Vec3::Z, Alpha(0.5)));
        assert_eq!(flat.at(0, 0), Lobe::isotropic(Vec3::Z, Alpha(0.5)));
    }
}
