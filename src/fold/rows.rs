//! Rows of footprints to rows of lobes: the loops around the folds' formulas.

use glam::Vec3;

use crate::moments::{Block, Layout, Moments, plane};
use crate::ndf::{Lobe, RoughnessTensor};

/// A row of footprints, by plane.
pub struct MomentRow<'a> {
    planes: [&'a [f32]; plane::COUNT],
    width: usize,
}

/// A row of lobes: normal x y z, then the tensor xx xy yy in the bent frame.
pub struct LobeRow<'a> {
    /// Six planes.
    pub planes: [&'a mut [f32]; 6],
}

impl<'a> MomentRow<'a> {
    /// Row `y` of a block; `zeros` stands for planes that the layout lacks.
    pub(crate) fn new(block: &'a Block, layout: &Layout, y: usize, zeros: &'a [f32]) -> Self {
        Self { planes: block.rows(layout, y, zeros), width: block.width() }
    }

    /// A row of one plane.
    pub fn plane(&self, plane: usize) -> &[f32] {
        self.planes[plane]
    }

    /// The loop that the compiler turns into vector code: planes that `f` does not read cost nothing, since each
    /// is as long as the row and so needs no check.
    #[inline(always)]
    fn each(&self, mut f: impl FnMut(usize, &Moments)) {
        let planes = self.planes.map(|row| &row[..self.width]);
        for i in 0..self.width {
            let mut values = [0.0; plane::COUNT];
            for p in 0..plane::COUNT {
                values[p] = planes[p][i];
            }
            f(i, &Moments { values });
        }
    }

    /// Runs an isotropic fold: normal and alpha^2 of each footprint.
    #[inline(always)]
    pub fn isotropic(&self, out: &mut LobeRow, fold: impl Fn(&Moments) -> (Vec3, f32)) {
        let [x, y, z, xx, xy, yy] = &mut out.planes;
        let n = self.width;
        let (x, y, z, xx, yy) = (&mut x[..n], &mut y[..n], &mut z[..n], &mut xx[..n], &mut yy[..n]);
        xy[..n].fill(0.0);
        self.each(
            #[inline(always)]
            |i, moments| {
                let (normal, alpha2) = fold(moments);
                (x[i], y[i], z[i], xx[i], yy[i]) = (normal.x, normal.y, normal.z, alpha2, alpha2);
            },
        );
    }

    /// Runs an anisotropic fold and keeps the mean of its squared widths.
    #[inline(always)]
    pub fn isotropic_part(&self, out: &mut LobeRow, fold: impl Fn(&Moments) -> (Vec3, RoughnessTensor)) {
        self.isotropic(
            out,
            #[inline(always)]
            |moments| {
                let (normal, tensor) = fold(moments);
                (normal, tensor.mean())
            },
        );
    }

    /// Runs an anisotropic fold: normal and tensor, in the transported frame of that normal, of each footprint.
    #[inline(always)]
    pub fn anisotropic(&self, out: &mut LobeRow, fold: impl Fn(&Moments) -> (Vec3, RoughnessTensor)) {
        let [x, y, z, xx, xy, yy] = &mut out.planes;
        let n = self.width;
        let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
        let (xx, xy, yy) = (&mut xx[..n], &mut xy[..n], &mut yy[..n]);
        self.each(
            #[inline(always)]
            |i, moments| {
                let (normal, tensor) = fold(moments);
                let r = tensor.to_bent(normal);
                (x[i], y[i], z[i], xx[i], xy[i], yy[i]) = (normal.x, normal.y, normal.z, r.xx, r.xy, r.yy);
            },
        );
    }
}

/// A [`MomentFold`](super::MomentFold) by one formula for tensors: two widths, or the mean of their squares. A macro, for a
/// function that is handed on is not always inlined into the rows' loops.
macro_rules! tensor_fold {
    ($needs:expr, $lobe:ident) => {
        $crate::fold::MomentFold {
            needs: $needs,
            isotropic: |row, out| {
                row.isotropic_part(
                    out,
                    #[inline(always)]
                    |m| $lobe(m),
                )
            },
            anisotropic: Some(|row, out| {
                row.anisotropic(
                    out,
                    #[inline(always)]
                    |m| $lobe(m),
                )
            }),
        }
    };
}
pub(super) use tensor_fold;

/// A fold on a single footprint.
pub(super) fn one(fold: fn(&MomentRow, &mut LobeRow), moments: &Moments) -> Lobe {
    let planes = std::array::from_fn(|p| &moments.values[p..=p]);
    let mut out = [[0.0; 1]; 6];
    fold(&MomentRow { planes, width: 1 }, &mut LobeRow { planes: out.each_mut().map(|o| &mut o[..]) });
    let [x, y, z, xx, xy, yy] = out.map(|o| o[0]);
    Lobe { normal: Vec3::new(x, y, z), roughness: RoughnessTensor { xx, xy, yy } }
}

/// Unit length; up where the vector is too short to have a direction.
#[inline(always)]
pub(super) fn unit(v: Vec3) -> Vec3 {
    let length2 = v.dot(v);
    let usable = length2 > 1e-20;
    let scale = 1.0 / (if usable { length2 } else { 1.0 }).sqrt();
    Vec3::new(v.x * scale, v.y * scale, if usable { v.z * scale } else { 1.0 })
}
