//! One mip level on its way out: rows of moments become rows of lobes and of plain channels.

use glam::Vec3;
use ndarray::{Array2, Array3, ArrayViewMut2, ArrayViewMut3, Axis};

use super::{LobeRow, Method, MomentRow, Options, fit};
use crate::image::Size;
use crate::moments::{Block, Layout, plane};
use crate::ndf::{Form, Lobes, RoughnessTensor};
use crate::roughness::PerceptualRoughness;
use crate::summary::Summaries;

/// One level of a [`super::Chain`].
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The folded lobes.
    pub lobes: Lobes,
    /// The plainly averaged channels, axes (channel, row, column).
    pub extras: Array3<f32>,
    /// If asked for: mean slope x y, then raw second moments xx yy xy; axes (moment, row, column).
    pub slope_moments: Option<Array3<f32>>,
    /// If asked for: length of the mean unit normal, axes (row, column). What a renormalised normal has too much of.
    pub mean_length: Option<Array2<f32>>,
}

impl Level {
    pub(super) fn zeros(options: &Options, size: Size, extras: usize) -> Self {
        let planes = |n| Array3::zeros((n, size.height, size.width));
        Self {
            lobes: Lobes::mixed_zeros(options.form, options.lobes, size),
            extras: planes(extras),
            slope_moments: options.slope_moments.then(|| planes(5)),
            mean_length: options.mean_length.then(|| Array2::zeros((size.height, size.width))),
        }
    }

    /// The level cut into bands of `rows` rows, to be filled side by side.
    pub(super) fn bands(&mut self, rows: usize) -> Vec<Band<'_>> {
        let form = self.lobes.form();
        let mut slopes = self.slope_moments.as_mut().map(|s| s.axis_chunks_iter_mut(Axis(1), rows));
        let lobes = self.lobes.bands_mut(rows);
        let extras = self.extras.axis_chunks_iter_mut(Axis(1), rows);
        let slopes = std::iter::from_fn(|| Some(slopes.as_mut().and_then(Iterator::next)));
        let mut lengths = self.mean_length.as_mut().map(|l| l.axis_chunks_iter_mut(Axis(0), rows));
        let lengths = std::iter::from_fn(|| Some(lengths.as_mut().and_then(Iterator::next)));
        let bands = lobes.zip(extras).zip(slopes).zip(lengths);
        bands.map(|(((lobes, extras), slopes), lengths)| Band { form, lobes, extras, slopes, lengths }).collect()
    }
}

/// Some rows of a [`Level`].
pub(super) struct Band<'a> {
    form: Form,
    lobes: ArrayViewMut3<'a, f32>,
    extras: ArrayViewMut3<'a, f32>,
    slopes: Option<ArrayViewMut3<'a, f32>>,
    lengths: Option<ArrayViewMut2<'a, f32>>,
}

/// Row `y`, from column `x`, `n` texels, of the planes of a band.
fn plane_rows<'a>(
    planes: &'a mut ArrayViewMut3<'_, f32>,
    y: usize,
    x: usize,
    n: usize,
) -> impl Iterator<Item = &'a mut [f32]> {
    planes.axis_iter_mut(Axis(0)).map(move |plane| {
        let row = plane.index_axis_move(Axis(0), y).into_slice().expect("rows are contiguous");
        &mut row[x..x + n]
    })
}

impl Band<'_> {
    /// Folds row `from` of `block` into row `y` of the band, starting at column `x`; folds that read lobes take them from
    /// the same row of `summaries`. `spare` is scratch.
    #[expect(clippy::too_many_arguments, reason = "one call for both kinds of fold")]
    pub fn fold_row(
        &mut self,
        options: &Options,
        layout: &Layout,
        block: &Block,
        summaries: &Summaries,
        from: usize,
        (x, y): (usize, usize),
        spare: &mut Vec<f32>,
    ) {
        let n = block.width();
        spare.resize(spare.len().max(3 * n), 0.0);
        let (zeros, unused) = spare[..3 * n].split_at_mut(n);
        zeros.fill(0.0);
        let row = MomentRow::new(block, layout, from, zeros);
        match &options.fold.method {
            Method::Moments(fold) => {
                let unused = unused.split_at_mut(n);
                // An isotropic image holds xx alone; the other two go to scratch.
                let mut planes = plane_rows(&mut self.lobes, y, x, n).chain([unused.0, unused.1]);
                let mut out = LobeRow { planes: std::array::from_fn(|_| planes.next().expect("six planes")) };
                fold.rows(self.form)(&row, &mut out);
            }
            Method::Lobes { fit, .. } => {
                let mut planes: Vec<&mut [f32]> = plane_rows(&mut self.lobes, y, x, n).collect();
                let normals = [0, 1, 2].map(|i| row.plane(plane::NORMAL + i));
                let shape = fit::Shape { form: self.form, shared_normal: options.shared_normal };
                fit::row(*fit, shape, options.lobes, summaries, from, normals, &mut planes);
            }
        }
        let stride = self.lobes.dim().0 / options.lobes;
        let mut planes: Vec<&mut [f32]> = plane_rows(&mut self.lobes, y, x, n).collect();
        for lobe in planes.chunks_exact_mut(stride) {
            limit(options, self.form, &row, lobe);
        }
        for (i, extra) in plane_rows(&mut self.extras, y, x, n).enumerate() {
            extra.copy_from_slice(block.row(layout.extra(i), from));
        }
        if let Some(lengths) = &mut self.lengths {
            let [nx, ny, nz] = [0, 1, 2].map(|i| row.plane(plane::NORMAL + i));
            for (i, out) in lengths.row_mut(y).iter_mut().skip(x).take(n).enumerate() {
                *out = Vec3::new(nx[i], ny[i], nz[i]).length().min(1.0);
            }
        }
        if let Some(slopes) = &mut self.slopes {
            let [sx, sy] = [0, 1].map(|i| row.plane(plane::SLOPE + i));
            let [xx, xy, yy] = [0, 1, 2].map(|i| row.plane(plane::SLOPE_COV + i));
            for (moment, out) in plane_rows(slopes, y, x, n).enumerate() {
                for (i, out) in out.iter_mut().enumerate() {
                    *out = match moment {
                        0 => sx[i],
                        1 => sy[i],
                        2 => xx[i] + sx[i] * sx[i],
                        3 => yy[i] + sy[i] * sy[i],
                        _ => xy[i] + sx[i] * sy[i],
                    };
                }
            }
        }
    }
}

/// Strength and bounds: `R = base + strength (fold - base)`, widened to the plain average if that is asked for, eigenvalues
/// clamped. A fold that does not start from the mean tensor adds nothing to it that could be scaled. `planes` are those of
/// a lobe.
fn limit(options: &Options, form: Form, row: &MomentRow, planes: &mut [&mut [f32]]) {
    let (low, high) = (options.min_alpha.squared(), options.max_alpha.squared());
    let n = planes[0].len();
    let k = options.strength;
    let scaled = k != 1.0 && options.fold.widens();
    // Where smooth texels win, less than the mean is not exaggerated: it would be a mirror.
    let share = |folded: f32, base: f32| if folded < base { k.min(1.0) } else { k };
    let [bxx, bxy, byy] = [0, 1, 2].map(|i| &row.plane(plane::TENSOR + i)[..n]);
    let base = |i: usize| RoughnessTensor { xx: bxx[i], xy: bxy[i], yy: byy[i] };
    let plain = options.at_least_average.then(|| &row.plane(plane::PERCEPTUAL)[..n]);
    let plain = |i: usize| plain.map_or(0.0, |p| PerceptualRoughness(p[i]).alpha().squared());
    match form {
        Form::Isotropic => {
            let a2 = &mut planes[3][..n];
            if scaled {
                for i in 0..n {
                    let base = base(i).mean();
                    a2[i] = base + (a2[i] - base) * share(a2[i], base);
                }
            }
            a2.iter_mut().enumerate().for_each(|(i, a2)| *a2 = a2.max(plain(i)).max(low).min(high));
        }
        Form::Anisotropic => {
            let [nx, ny, nz, xx, xy, yy, ..] = planes else { unreachable!("two widths are six planes") };
            let (xx, xy, yy) = (&mut xx[..n], &mut xy[..n], &mut yy[..n]);
            if scaled {
                for i in 0..n {
                    let base = base(i).to_bent(Vec3::new(nx[i], ny[i], nz[i]));
                    let folded = RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] };
                    let mixed = base + (folded - base) * share(folded.mean(), base.mean());
                    (xx[i], xy[i], yy[i]) = (mixed.xx, mixed.xy, mixed.yy);
                }
            }
            for i in 0..n {
                let r = RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] }.clamped(0.0, 1.0);
                // Towards the widest, whose mean is 1.
                let lack = plain(i) - r.mean();
                let raised = |t: f32| r * (1.0 - t) + RoughnessTensor { xx: t, xy: 0.0, yy: t };
                let r = if lack > 0.0 { raised(lack / (1.0 - r.mean())) } else { r }.clamped(low, high);
                (xx[i], xy[i], yy[i]) = (r.xx, r.xy, r.yy);
            }
        }
    }
}
