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
    /// "one width" or "two widths".
    pub const fn widths(self) -> &'static str {
        match self {
            Form::Isotropic => "one width",
            Form::Anisotropic => "two widths",
        }
    }

    /// Planes of a [`Lobes`] image: normal x y z, then alpha^2, or xx xy yy of the tensor.
    pub const fn planes(self) -> usize {
        match self {
            Form::Isotropic => 4,
            Form::Anisotropic => 6,
        }
    }
}

/// What a fold's name lacks: nothing, ", two widths", ", 2 lobes", ", 2 lobes, two widths", ", 2 lobes sharing a normal".
pub fn lobes_in_words(form: Form, count: usize, shared_normal: bool) -> String {
    let lobes = if count == 1 { String::new() } else { format!(", {count} lobes") };
    let shared = if shared_normal { " sharing a normal" } else { "" };
    let widths = if form == Form::Anisotropic { ", two widths" } else { "" };
    format!("{lobes}{shared}{widths}")
}

/// Most lobes of a texel.
pub const MOST_LOBES: usize = 4;

/// Whether the weights of a texel's lobes are shares of it: from 0 up, and 1 together, but for 1e-3 of rounding.
pub fn are_shares(weights: impl Iterator<Item = f32>) -> bool {
    let sum = weights.fold(0.0, |sum, weight| if weight >= 0.0 { sum + weight } else { f32::NAN });
    (sum - 1.0).abs() <= 1e-3
}

/// One mip level as lobes: planes of f32, axes (plane, row, column). Planes 0..3 hold the unit normal; an
/// isotropic image adds alpha^2, an anisotropic one `R.xx R.xy R.yy` in the bent frame of the normal.
///
/// A texel may hold several lobes: then each has these planes and one more, its weight, one lobe after the other. A weight
/// is the share of the texel's area that the lobe stands for; they sum to 1. A lobe of weight 0 is not there, but it is
/// still a lobe: filtering mixes lobe `j` of a texel with lobe `j` of its neighbours and of the next level.
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
        Self::mixed_from_fn(form, 1, size, |_, x, y| (lobe(x, y), 1.0))
    }

    /// `count` lobes a texel, 1 to [`MOST_LOBES`]: `lobe(j, x, y)` gives lobe `j` of a texel and its weight, which counts
    /// only beside others.
    pub fn mixed_from_fn(
        form: Form,
        count: usize,
        size: Size,
        mut lobe: impl FnMut(usize, usize, usize) -> (Lobe, f32),
    ) -> Self {
        let mut lobes = Self::mixed_zeros(form, count, size);
        let stride = lobes.stride();
        for y in 0..size.height {
            for x in 0..size.width {
                for j in 0..count {
                    let (Lobe { normal, roughness: r }, weight) = lobe(j, x, y);
                    let values = match form {
                        Form::Isotropic => [normal.x, normal.y, normal.z, 0.5 * (r.xx + r.yy), 0.0, 0.0],
                        Form::Anisotropic => [normal.x, normal.y, normal.z, r.xx, r.xy, r.yy],
                    };
                    for (plane, value) in values.into_iter().take(form.planes()).enumerate() {
                        lobes.planes[(j * stride + plane, y, x)] = value;
                    }
                    if count > 1 {
                        lobes.planes[(j * stride + form.planes(), y, x)] = weight;
                    }
                }
            }
        }
        lobes
    }

    /// The same lobes in another form. One width keeps the mean of both.
    pub fn in_form(self, form: Form) -> Self {
        if self.form == form {
            return self;
        }
        Self::mixed_from_fn(form, self.count, self.size(), |j, x, y| self.slot(j, x, y))
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
        (0..self.count).map(move |j| self.slot(j, x, y)).filter(|(_, weight)| *weight > 0.0)
    }

    /// Lobe `j` of a texel and its weight, also if it is not there. Where texels have fewer lobes, as at level 0, it is the
    /// first lobe with weight 0.
    pub fn slot(&self, j: usize, x: usize, y: usize) -> (Lobe, f32) {
        let weight = match self.count {
            _ if j >= self.count => return (self.at(x, y), 0.0),
            1 => 1.0,
            _ => self.planes[(j * self.stride() + self.form.planes(), y, x)],
        };
        (self.lobe(j, x, y), weight)
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

    #[test]
    fn several_lobes_keep_their_places() {
        let lobe = |j: usize, x: usize, y: usize| {
            let normal = Vec3::new(0.1 * j as f32, 0.1 * x as f32, 1.0).normalize();
            (Lobe::isotropic(normal, Alpha::from_squared(0.1 * (1 + j + y) as f32)), [0.75, 0.0, 0.25][j])
        };
        for form in [Form::Isotropic, Form::Anisotropic] {
            let lobes = Lobes::mixed_from_fn(form, 3, Size::new(2, 2), lobe);
            assert_eq!((lobes.count(), lobes.stride()), (3, form.planes() + 1));
            assert_eq!([0, 1, 2].map(|j| lobes.slot(j, 1, 1)), [0, 1, 2].map(|j| lobe(j, 1, 1)));
            // A fourth lobe would be the first, of weight 0; the second is of weight 0.
            assert_eq!(lobes.slot(3, 1, 0), (lobe(0, 1, 0).0, 0.0));
            assert_eq!(lobes.mixture(1, 0).collect::<Vec<_>>(), [lobe(0, 1, 0), lobe(2, 1, 0)]);
            let other = lobes.clone().in_form(Form::Anisotropic);
            assert_eq!((other.form(), other.count()), (Form::Anisotropic, 3));
            assert_eq!(other.slot(2, 0, 1), lobe(2, 0, 1));
            assert_eq!(other.in_form(form), lobes);
        }
    }

    #[test]
    fn shares_sum_to_one() {
        for good in [&[1.0][..], &[0.25, 0.75], &[0.9995, 0.0], &[0.3, 0.3005, 0.4]] {
            assert!(are_shares(good.iter().copied()), "{good:?}");
        }
        for bad in [&[][..], &[0.5], &[1.2, -0.2], &[f32::NAN, 1.0], &[f32::INFINITY], &[0.5, 0.502]] {
            assert!(!are_shares(bad.iter().copied()), "{bad:?}");
        }
    }
}
