//! Footprints side by side, and what was fitted to them.

use glam::Vec3;

use super::lanes::{LANES, Lanes};
use crate::ndf::{Form, Lobe, MOST_LOBES, RoughnessTensor, SlopeLobe};
use crate::summary::{Entry, Summaries};

/// A lobe of each footprint, ready for fits: the scatter as its Cholesky factor, `P = L L^T`.
///
/// Its weight is the area of texels times n_z: that of the area itself would make D at normal incidence, to which a facet
/// contributes by `1 / n_z`; but views and lights of which one is not steep meet steep facets less than that, and fits with
/// this weight lie closer in lobe error.
#[derive(Clone, Copy, Default)]
pub struct Atom {
    /// Weight.
    pub w: Lanes,
    /// Area over weight: 1 / n_z.
    pub tilt: Lanes,
    /// Centre.
    pub x: Lanes,
    /// Centre.
    pub y: Lanes,
    /// Cholesky factor.
    pub l11: Lanes,
    /// Cholesky factor.
    pub l21: Lanes,
    /// Cholesky factor.
    pub l22: Lanes,
}

/// Footprints side by side.
#[derive(Default)]
pub struct Chunk {
    /// Their lobes; footprints with fewer have some of weight 0.
    pub atoms: Vec<Atom>,
    /// Their mean normals, unit.
    pub normal: [Lanes; 3],
}

/// A lobe fitted to each footprint of a chunk.
#[derive(Clone, Copy, Default)]
pub struct Fitted {
    /// Unit normal, x y z.
    pub normal: [Lanes; 3],
    /// Tensor xx xy yy, in the transported frame of the normal.
    pub tensor: [Lanes; 3],
    /// Share of the footprint.
    pub weight: Lanes,
}

/// Fits lobes to the footprints of a chunk; one entry of `out` for each lobe that is asked for.
pub type Fit = fn(chunk: &Chunk, shape: Shape, out: &mut [Fitted]);

/// What lobes may differ in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// One width or two.
    pub form: Form,
    /// Whether the lobes of a footprint share a normal.
    pub shared_normal: bool,
}

impl Atom {
    /// The Cholesky factor of a scatter.
    #[inline(always)]
    fn set(&mut self, i: usize, w: f32, [x, y]: [f32; 2], [xx, xy, yy]: [f32; 3]) {
        let l11 = xx.max(f32::MIN_POSITIVE).sqrt();
        let l21 = xy / l11;
        // At least a thousandth of the width across: rounding could leave nothing.
        let l22 = (yy - l21 * l21).max(1e-6 * yy).sqrt();
        let tilt = (1.0 + x * x + y * y).sqrt();
        (self.w.0[i], self.tilt.0[i], self.x.0[i], self.y.0[i]) = (w / tilt, tilt, x, y);
        (self.l11.0[i], self.l21.0[i], self.l22.0[i]) = (l11, l21, l22);
    }

    /// 1 where alpha^2 is more than so many times that of another atom, or less; else 0.
    #[inline(always)]
    pub fn unlike(&self, other: &Self, ratio: f32) -> Lanes {
        // The root of a narrow lobe's determinant is alpha^2 over the cube of n_z.
        let size = |atom: &Self, i: usize| atom.l11.0[i] * atom.l22.0[i] / atom.tilt.0[i].powi(3);
        let mut unlike = Lanes::default();
        for i in 0..LANES {
            let (a, b) = (size(self, i), size(other, i));
            unlike.0[i] = if a > ratio * b || b > ratio * a { 1.0 } else { 0.0 };
        }
        unlike
    }

    /// The scatter xx xy yy.
    #[inline(always)]
    pub fn scatter(&self) -> [Lanes; 3] {
        let Self { l11, l21, l22, .. } = *self;
        [l11 * l11, l11 * l21, l21 * l21 + l22 * l22]
    }

    /// A lobe of footprint `i`.
    pub(super) fn set_lane(&mut self, i: usize, Entry { weight, lobe: SlopeLobe { centre, scatter } }: &Entry) {
        self.set(i, *weight, centre.to_array(), [scatter.xx, scatter.xy, scatter.yy]);
    }
}

impl Chunk {
    /// Takes the summaries of row `y` from column `x` on; missing columns repeat the last.
    #[inline(always)]
    fn gather(&mut self, from: &Summaries, y: usize, x: usize, normals: [&[f32]; 3]) {
        let last = from.width() - 1;
        self.atoms.resize(from.lobes(), Atom::default());
        for (lobe, atom) in self.atoms.iter_mut().enumerate() {
            let rows: [&[f32]; 6] = std::array::from_fn(|quantity| from.row(y, lobe, quantity));
            for i in 0..LANES {
                let [w, cx, cy, xx, xy, yy] = rows.map(|row| row[(x + i).min(last)]);
                atom.set(i, w, [cx, cy], [xx, xy, yy]);
            }
        }
        for i in 0..LANES {
            let n = Vec3::from(normals.map(|row| row[(x + i).min(last)]));
            // A mean too short to have a direction points up.
            let n = n.try_normalize().unwrap_or(Vec3::Z);
            (self.normal[0].0[i], self.normal[1].0[i], self.normal[2].0[i]) = (n.x, n.y, n.z);
        }
    }
}

/// Fits a row of footprints. `planes` are those of a row of [`crate::ndf::Lobes`], `normals` the mean normals.
pub fn row(
    fit: Fit,
    shape: Shape,
    count: usize,
    from: &Summaries,
    y: usize,
    normals: [&[f32]; 3],
    planes: &mut [&mut [f32]],
) {
    let mut chunk = Chunk::default();
    let form = shape.form;
    let stride = form.planes() + usize::from(count > 1);
    for x in (0..from.width()).step_by(LANES) {
        let mut fitted = [Fitted::default(); MOST_LOBES];
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || chunk.gather(from, y, x, normals),
        );
        fit(&chunk, shape, &mut fitted[..count]);
        for i in 0..LANES.min(from.width() - x) {
            for (j, fitted) in fitted[..count].iter().enumerate() {
                let Lobe { normal: n, roughness: r } = fitted.lobe(i);
                let planes = &mut planes[j * stride..][..stride];
                let values = match form {
                    Form::Isotropic => [n.x, n.y, n.z, r.mean(), fitted.weight.0[i], 0.0, 0.0],
                    Form::Anisotropic => [n.x, n.y, n.z, r.xx, r.xy, r.yy, fitted.weight.0[i]],
                };
                planes.iter_mut().zip(values).for_each(|(plane, v)| plane[x + i] = v);
            }
        }
    }
}

/// Fits a single footprint: lobes with weights.
pub fn one(fit: Fit, shape: Shape, count: usize, entries: &[Entry], normal: Vec3) -> Vec<(Lobe, f32)> {
    let mut chunk = Chunk { normal: normal.to_array().map(Lanes::all), ..Chunk::default() };
    chunk.atoms.resize(entries.len(), Atom::default());
    for (atom, entry) in chunk.atoms.iter_mut().zip(entries) {
        (0..LANES).for_each(|i| atom.set_lane(i, entry));
    }
    let mut fitted = [Fitted::default(); MOST_LOBES];
    fit(&chunk, shape, &mut fitted[..count]);
    fitted[..count].iter().map(|fitted| (fitted.lobe(0), fitted.weight.0[0])).collect()
}

impl Fitted {
    /// The lobe of a footprint.
    pub fn lobe(&self, i: usize) -> Lobe {
        let normal = Vec3::from(self.normal.map(|v| v.0[i]));
        let [xx, xy, yy] = self.tensor.map(|v| v.0[i]);
        Lobe { normal, roughness: RoughnessTensor { xx, xy, yy }.to_bent(normal) }
    }
}
