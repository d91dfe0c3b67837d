//! Footprints side by side, and what was fitted to them.

use glam::{Vec2, Vec3};
use pulp::Simd;

use super::estimate::Estimate;
use super::lanes::{FOOTPRINTS, Lanes, Row, Rows, Which};
use crate::fold::rows::unit;
use crate::ndf::{Form, Lobe, MOST_LOBES, RoughnessTensor, SlopeLobe};
use crate::summary::{Entry, QUANTITIES, Summaries};

/// Footprints side by side.
#[derive(Default)]
pub struct Chunk {
    /// So many; beyond them, the last is repeated.
    pub count: usize,
    /// Their lobes, as summaries have them: weight, centre x y, scatter xx xy yy. Footprints with fewer have some of weight 0.
    pub lobes: Vec<Rows<QUANTITIES>>,
    /// Their mean normals, unit.
    pub normal: Rows<3>,
}

/// A lobe of each footprint, ready for fits: the scatter as its Cholesky factor, `P = L L^T`.
///
/// Its weight is the area of texels times n_z: that of the area itself would make D at normal incidence, to which a facet
/// contributes by `1 / n_z`; but views and lights of which one is not steep meet steep facets less than that, and fits with
/// this weight lie closer in lobe error.
#[derive(Clone, Copy)]
pub struct Atom<S: Simd> {
    /// Weight.
    pub w: Lanes<S>,
    /// Area over weight: 1 / n_z.
    pub tilt: Lanes<S>,
    /// Centre.
    pub x: Lanes<S>,
    /// Centre.
    pub y: Lanes<S>,
    /// Cholesky factor.
    pub l11: Lanes<S>,
    /// Cholesky factor.
    pub l21: Lanes<S>,
    /// Cholesky factor.
    pub l22: Lanes<S>,
}

/// A lobe fitted to each footprint of a chunk.
#[derive(Clone, Copy)]
pub struct Fitted {
    /// Unit normal, x y z.
    pub normal: Rows<3>,
    /// Tensor xx xy yy, in the transported frame of the normal.
    pub tensor: Rows<3>,
    /// Share of the footprint.
    pub weight: Row,
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

impl<S: Simd> Atom<S> {
    /// From weight, centre x y and scatter xx xy yy.
    #[inline(always)]
    pub fn new([w, x, y, xx, xy, yy]: [Lanes<S>; QUANTITIES]) -> Self {
        let l11 = xx.max(f32::MIN_POSITIVE).sqrt();
        let l21 = xy * l11.inverse();
        // At least a thousandth of the width across: rounding could leave nothing.
        let (l22, least) = (yy - l21 * l21, 1e-6 * yy);
        let l22 = l22.above(least, l22, least).sqrt();
        let tilt = (x * x + y * y + 1.0).sqrt();
        Self { w: w * tilt.inverse(), tilt, x, y, l11, l21, l22 }
    }

    /// 1 where alpha^2 is more than so many times that of another atom, or less; else 0.
    #[inline(always)]
    pub fn unlike(&self, other: &Self, ratio: f32) -> Lanes<S> {
        // The root of a narrow lobe's determinant is alpha^2 over the cube of n_z.
        let a = self.l11 * self.l22 * (other.tilt * other.tilt * other.tilt);
        let b = other.l11 * other.l22 * (self.tilt * self.tilt * self.tilt);
        let (yes, no) = (a.like(1.0), a.like(0.0));
        a.above(ratio * b, yes, b.above(ratio * a, yes, no))
    }

    /// The lobe itself.
    #[inline(always)]
    pub fn estimate(&self) -> Estimate<S> {
        let [xx, xy, yy] = self.scatter();
        Estimate { x: self.x, y: self.y, xx, xy, yy }
    }

    /// The scatter xx xy yy.
    #[inline(always)]
    pub fn scatter(&self) -> [Lanes<S>; 3] {
        let Self { l11, l21, l22, .. } = *self;
        [l11 * l11, l11 * l21, l21 * l21 + l22 * l22]
    }
}

impl Chunk {
    /// A single footprint; `normal` is its mean normal.
    pub fn of(entries: &[Entry], normal: Vec3) -> Self {
        let lobe = |&Entry { weight, lobe: SlopeLobe { centre, scatter } }: &Entry| {
            Rows([weight, centre.x, centre.y, scatter.xx, scatter.xy, scatter.yy].map(|v| [v; FOOTPRINTS]))
        };
        let normal = Rows(normal.to_array().map(|v| [v; FOOTPRINTS]));
        Self { count: 1, lobes: entries.iter().map(lobe).collect(), normal }
    }

    /// The lobes of footprint `i`.
    pub fn footprint(&self, i: usize) -> impl Iterator<Item = Entry> + Clone {
        self.lobes.iter().map(move |rows| {
            let [weight, x, y, xx, xy, yy] = rows.at(i);
            Entry { weight, lobe: SlopeLobe { centre: Vec2::new(x, y), scatter: RoughnessTensor { xx, xy, yy } } }
        })
    }

    /// The lobes of some footprints.
    #[inline(always)]
    pub fn atoms<S: Simd>(&self, simd: S, which: Which, out: &mut Vec<Atom<S>>) {
        out.clear();
        for lobe in &self.lobes {
            out.push(Atom::new(lobe.load(simd, which)));
        }
    }

    /// Takes the summaries of row `y` from column `x` on; missing columns repeat the last.
    fn gather(&mut self, from: &Summaries, y: usize, x: usize, normals: [&[f32]; 3]) {
        self.count = FOOTPRINTS.min(from.width() - x);
        self.lobes.resize(from.lobes(), Rows::default());
        for (lobe, rows) in self.lobes.iter_mut().enumerate() {
            for (quantity, row) in rows.0.iter_mut().enumerate() {
                fill(row, &from.row(y, lobe, quantity)[x..]);
            }
        }
        let [nx, ny, nz] = &mut self.normal.0;
        [&mut *nx, &mut *ny, &mut *nz].into_iter().zip(normals).for_each(|(row, from)| fill(row, &from[x..]));
        for i in 0..FOOTPRINTS {
            let n = unit(Vec3::new(nx[i], ny[i], nz[i]));
            (nx[i], ny[i], nz[i]) = (n.x, n.y, n.z);
        }
    }
}

/// Takes the first numbers; missing ones repeat the last.
fn fill(row: &mut Row, from: &[f32]) {
    match from.first_chunk() {
        Some(whole) => *row = *whole,
        None => (0..FOOTPRINTS).for_each(|i| row[i] = from[i.min(from.len() - 1)]),
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
    for x in (0..from.width()).step_by(FOOTPRINTS) {
        let mut fitted = [Fitted::default(); MOST_LOBES];
        chunk.gather(from, y, x, normals);
        fit(&chunk, shape, &mut fitted[..count]);
        for i in 0..chunk.count {
            for (j, fitted) in fitted[..count].iter().enumerate() {
                let Lobe { normal: n, roughness: r } = fitted.lobe(i);
                let planes = &mut planes[j * stride..][..stride];
                let values = match form {
                    Form::Isotropic => [n.x, n.y, n.z, r.mean(), fitted.weight[i], 0.0, 0.0],
                    Form::Anisotropic => [n.x, n.y, n.z, r.xx, r.xy, r.yy, fitted.weight[i]],
                };
                planes.iter_mut().zip(values).for_each(|(plane, v)| plane[x + i] = v);
            }
        }
    }
}

/// Fits a single footprint: lobes with weights.
pub fn one(fit: Fit, shape: Shape, count: usize, entries: &[Entry], normal: Vec3) -> Vec<(Lobe, f32)> {
    let mut fitted = [Fitted::default(); MOST_LOBES];
    fit(&Chunk::of(entries, normal), shape, &mut fitted[..count]);
    fitted[..count].iter().map(|fitted| (fitted.lobe(0), fitted.weight[0])).collect()
}

impl Default for Fitted {
    fn default() -> Self {
        Self { normal: Rows::default(), tensor: Rows::default(), weight: [0.0; FOOTPRINTS] }
    }
}

impl Fitted {
    /// The lobe of a footprint.
    pub fn lobe(&self, i: usize) -> Lobe {
        let (normal, [xx, xy, yy]) = (Vec3::from(self.normal.at(i)), self.tensor.at(i));
        Lobe { normal, roughness: RoughnessTensor { xx, xy, yy }.to_bent(normal) }
    }
}
