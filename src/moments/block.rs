//! Rectangles of moments, planar, and their 2x2 merge.

use super::{COUNT, KINDS, Kind, Needs, RoughnessTensor, form, merge_mean, plane::*};
use super::{STEEPEST_Z, Vec3};

/// Which planes a [`Block`] holds, in the order of [`super::plane`], followed by plainly averaged extra channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Slot of each plane of [`super::plane`].
    slots: [Option<usize>; COUNT],
    /// How each slot merges; mean planes named by slot.
    pub(super) kinds: Vec<Kind>,
    extras: usize,
}

impl Layout {
    /// The planes in `needs` and `extras` further channels. Where all base lobes are isotropic, the mean tensor is
    /// one plane, read as xx and as yy.
    pub fn new(needs: Needs, isotropic: bool, extras: usize) -> Self {
        let mut slots = [None; COUNT];
        let mut kinds = Vec::new();
        for (plane, &kind) in KINDS.iter().enumerate() {
            if isotropic && plane == TENSOR + 1 {
                continue;
            } else if isotropic && plane == TENSOR + 2 {
                slots[plane] = slots[TENSOR];
            } else if plane == WEIGHT || needs.has(plane) {
                slots[plane] = Some(kinds.len());
                kinds.push(match kind {
                    Kind::Cov(a, b) => Kind::Cov(slots[a].expect("means first"), slots[b].expect("means first")),
                    other => other,
                });
            }
        }
        kinds.resize(kinds.len() + extras, Kind::Plain);
        Self { slots, kinds, extras }
    }

    /// Slot of an extra channel.
    pub fn extra(&self, index: usize) -> usize {
        debug_assert!(index < self.extras);
        self.kinds.len() - self.extras + index
    }

    /// Number of slots.
    pub fn slots(&self) -> usize {
        self.kinds.len()
    }
}

/// A rectangle of moments: one plane of f32 a slot of its [`Layout`], each by rows.
#[derive(Clone, Debug, Default)]
pub struct Block {
    width: usize,
    height: usize,
    data: Vec<f32>,
}

impl Block {
    /// Takes this size, keeping the allocation; the content is unspecified.
    pub fn resize(&mut self, layout: &Layout, width: usize, height: usize) {
        (self.width, self.height) = (width, height);
        self.data.resize(layout.slots() * width * height, 0.0);
    }

    /// Texels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// A row of a slot.
    pub fn row(&self, slot: usize, y: usize) -> &[f32] {
        &self.data[(slot * self.height + y) * self.width..][..self.width]
    }

    /// A row of a slot, to write.
    pub fn row_mut(&mut self, slot: usize, y: usize) -> &mut [f32] {
        &mut self.data[(slot * self.height + y) * self.width..][..self.width]
    }

    /// The same row of several slots, in rising order of slots, to write.
    pub fn rows_mut<const N: usize>(&mut self, slots: [usize; N], y: usize) -> [&mut [f32]; N] {
        let (width, height) = (self.width, self.height);
        let mut rest = self.data.as_mut_slice();
        let mut start = 0;
        slots.map(|slot| {
            let at = (slot * height + y) * width;
            let (row, tail) = std::mem::take(&mut rest)[at - start..].split_at_mut(width);
            (start, rest) = (at + width, tail);
            row
        })
    }

    /// Row `y`'s values of a plane, or zeros where the layout lacks it.
    fn plane_row<'a>(&'a self, layout: &Layout, plane: usize, y: usize, zeros: &'a [f32]) -> &'a [f32] {
        layout.slots[plane].map_or(&zeros[..self.width], |slot| self.row(slot, y))
    }

    /// All planes of row `y`; planes that the layout lacks read from `zeros`, at least as long as a row.
    pub fn rows<'a>(&'a self, layout: &Layout, y: usize, zeros: &'a [f32]) -> [&'a [f32]; COUNT] {
        std::array::from_fn(|plane| self.plane_row(layout, plane, y, zeros))
    }

    /// The moments of one texel.
    #[cfg(test)]
    pub fn at(&self, layout: &Layout, x: usize, y: usize) -> super::Moments {
        let values = std::array::from_fn(|p| layout.slots[p].map_or(0.0, |slot| self.row(slot, y)[x]));
        super::Moments { values }
    }

    /// Fills what follows from the level-0 quantities of row `y`: weight, normal and perceptual roughness must be
    /// there, and `tensors` holds xx xy yy in bent frames where the base lobes are anisotropic. Covariances are left
    /// alone: those of a single texel are 0, and [`Block::halve`] knows it.
    pub fn finish_texels(&mut self, layout: &Layout, y: usize, source: &TexelRows) {
        let slot = |plane| layout.slots[plane];
        if let Some(s) = slot(NORMAL) {
            for i in 0..3 {
                self.row_mut(s + i, y).copy_from_slice(source.normal[i]);
            }
        }
        let [nx, ny, nz] = source.normal;
        let width = self.width;
        let (nx, ny, nz, perceptual) = (&nx[..width], &ny[..width], &nz[..width], &source.perceptual[..width]);
        if let Some(s) = slot(SLOPE) {
            let [sx, sy] = self.rows_mut([s, s + 1], y);
            for i in 0..width {
                let k = -1.0 / nz[i].max(STEEPEST_Z);
                sx[i] = k * nx[i];
                sy[i] = k * ny[i];
            }
        }
        if let Some(s) = slot(PERCEPTUAL) {
            self.row_mut(s, y).copy_from_slice(perceptual);
        }
        let normal = |i: usize| Vec3::new(nx[i], ny[i], nz[i]);
        let base = |i: usize| match source.tensors {
            Some([xx, xy, yy]) => RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] }.to_transported(normal(i)),
            None => {
                let alpha = perceptual[i] * perceptual[i];
                RoughnessTensor { xx: alpha * alpha, xy: 0.0, yy: alpha * alpha }
            }
        };
        if let (Some(s), None) = (slot(TENSOR), slot(TENSOR + 1)) {
            for (out, r) in self.row_mut(s, y).iter_mut().zip(perceptual) {
                let alpha = r * r;
                *out = alpha * alpha;
            }
        } else if let Some(s) = slot(TENSOR) {
            let [xx, xy, yy] = self.rows_mut([s, s + 1, s + 2], y);
            for i in 0..width {
                let r = base(i);
                (xx[i], xy[i], yy[i]) = (r.xx, r.xy, r.yy);
            }
        }
        if let Some(s) = slot(FORM) {
            let [a, b, c, d, e, f] = self.rows_mut([s, s + 1, s + 2, s + 3, s + 4, s + 5], y);
            let isotropic = source.tensors.is_none();
            for i in 0..width {
                let n = normal(i);
                let values = if isotropic { isotropic_form(n, perceptual[i]) } else { form(n, base(i)) };
                (a[i], b[i], c[i], d[i], e[i], f[i]) =
                    (values[0], values[1], values[2], values[3], values[4], values[5]);
            }
        }
    }

    /// The covariances of single texels, for merges that read them.
    pub fn zero_covariances(&mut self, layout: &Layout, y: usize) {
        for (slot, kind) in layout.kinds.iter().enumerate() {
            if matches!(kind, Kind::Cov(..)) {
                self.row_mut(slot, y).fill(0.0);
            }
        }
    }

    /// Takes the content of row `y` of another block.
    pub fn copy_row(&mut self, layout: &Layout, other: &Block, y: usize) {
        self.resize(layout, other.width, 1);
        (0..layout.slots()).for_each(|slot| self.row_mut(slot, 0).copy_from_slice(other.row(slot, y)));
    }

    /// Writes a block of the same height from column `x` on.
    pub fn copy_columns(&mut self, layout: &Layout, other: &Block, x: usize) {
        for slot in 0..layout.slots() {
            for y in 0..other.height {
                self.row_mut(slot, y)[x..x + other.width].copy_from_slice(other.row(slot, y));
            }
        }
    }

    /// One-row blocks of equal width, stacked.
    pub fn stack(layout: &Layout, rows: &[Block]) -> Block {
        let mut out = Block::default();
        out.resize(layout, rows[0].width, rows.len());
        for slot in 0..layout.slots() {
            rows.iter().enumerate().for_each(|(y, row)| out.row_mut(slot, y).copy_from_slice(row.row(slot, 0)));
        }
        out
    }

    /// Each 2x2 of this block of two rows merged into one texel of row `y` of `out`, half as wide. The width must be
    /// even. `texels` says that these are single texels, whose covariances are 0 and need no reading.
    pub fn halve(&self, layout: &Layout, texels: bool, out: &mut Block, y: usize, scratch: &mut Quads) {
        debug_assert!(self.height == 2 && self.width == 2 * out.width);
        scratch.resize(layout, out.width);
        let first = self.row(0, 0)[0];
        // Bits that differ, gathered without a branch.
        let differing = |row: &[f32]| row.iter().fold(0, |bits, w| bits | (w.to_bits() ^ first.to_bits()));
        if differing(self.row(0, 0)) | differing(self.row(0, 1)) == 0 {
            out.row_mut(0, y).fill(4.0 * first);
            self.halve_with(layout, texels, out, y, scratch, &Equal);
        } else {
            let mut shares = std::mem::take(&mut scratch.shares);
            self.split(0, &mut shares);
            let [a, b, c, d] = &mut shares;
            for (i, total) in out.row_mut(0, y).iter_mut().enumerate() {
                *total = (a[i] + b[i]) + (c[i] + d[i]);
                let scale = 1.0 / *total;
                (a[i], b[i], c[i], d[i]) = (a[i] * scale, b[i] * scale, c[i] * scale, d[i] * scale);
            }
            self.halve_with(layout, texels, out, y, scratch, &Weighted(shares.each_ref().map(|s| &s[..])));
            scratch.shares = shares;
        }
    }

    /// The four children of each 2x2 of a slot, as four rows.
    fn split(&self, slot: usize, quads: &mut Quad) {
        let [a, b, c, d] = quads;
        for (row, (even, odd)) in [(0, (a, b)), (1, (c, d))] {
            for ((even, odd), pair) in even.iter_mut().zip(odd).zip(self.row(slot, row).chunks_exact(2)) {
                (*even, *odd) = (pair[0], pair[1]);
            }
        }
    }

    fn halve_with(
        &self,
        layout: &Layout,
        texels: bool,
        out: &mut Block,
        y: usize,
        scratch: &mut Quads,
        shares: &impl Shares,
    ) {
        let n = out.width;
        let Quads { deviations, covariances, .. } = scratch;
        for (slot, &kind) in layout.kinds.iter().enumerate().skip(1) {
            let out = &mut out.row_mut(slot, y)[..n];
            match kind {
                Kind::Weight => unreachable!("the weight is the first slot alone"),
                Kind::Mean | Kind::Plain => {
                    // What stays behind in the quad is the deviation from the mean, for the covariances.
                    let quad = &mut deviations[slot];
                    self.split(slot, quad);
                    let [a, b, c, d] = quad.each_mut().map(|q| &mut q[..n]);
                    for i in 0..n {
                        let share = if kind == Kind::Plain { [0.25; 4] } else { shares.of(i) };
                        let mean = merge_mean(share, [a[i], b[i], c[i], d[i]]);
                        out[i] = mean;
                        (a[i], b[i], c[i], d[i]) = (a[i] - mean, b[i] - mean, c[i] - mean, d[i] - mean);
                    }
                }
                Kind::Cov(first, second) => {
                    let quad = |slot: usize| deviations[slot].each_ref().map(|q| &q[..n]);
                    let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (quad(first), quad(second));
                    let product = |i| [a0[i] * b0[i], a1[i] * b1[i], a2[i] * b2[i], a3[i] * b3[i]];
                    if texels {
                        for i in 0..n {
                            out[i] = weighted(shares.of(i), product(i));
                        }
                    } else {
                        self.split(slot, covariances);
                        let [c0, c1, c2, c3] = covariances.each_ref().map(|q| &q[..n]);
                        for i in 0..n {
                            let p = product(i);
                            out[i] = weighted(shares.of(i), [c0[i] + p[0], c1[i] + p[1], c2[i] + p[2], c3[i] + p[3]]);
                        }
                    }
                }
            }
        }
    }
}

/// The four children of each texel of a row.
type Quad = [Vec<f32>; 4];

/// Scratch rows of [`Block::halve`].
#[derive(Default)]
pub struct Quads {
    shares: Quad,
    covariances: Quad,
    deviations: Vec<Quad>,
}

impl Quads {
    fn resize(&mut self, layout: &Layout, width: usize) {
        self.deviations.resize_with(layout.slots(), Quad::default);
        let quads = self.deviations.iter_mut().chain([&mut self.shares, &mut self.covariances]);
        quads.flatten().for_each(|row| row.resize(width, 0.0));
    }
}

/// The children's shares of the weight: nearly always equal, and then known to the compiler.
trait Shares {
    fn of(&self, i: usize) -> [f32; 4];
}

struct Equal;
struct Weighted<'a>([&'a [f32]; 4]);

impl Shares for Equal {
    #[inline(always)]
    fn of(&self, _: usize) -> [f32; 4] {
        [0.25; 4]
    }
}

impl Shares for Weighted<'_> {
    #[inline(always)]
    fn of(&self, i: usize) -> [f32; 4] {
        self.0.map(|share| share[i])
    }
}

#[inline(always)]
fn weighted(share: [f32; 4], value: [f32; 4]) -> f32 {
    (share[0] * value[0] + share[1] * value[1]) + (share[2] * value[2] + share[3] * value[3])
}

/// [`form`] of a lobe of one width: `alpha^2 (I - n n^T)`.
#[inline(always)]
fn isotropic_form(n: Vec3, perceptual: f32) -> [f32; 6] {
    let alpha = perceptual * perceptual;
    let a2 = alpha * alpha;
    let (x, y) = (a2 * n.x, a2 * n.y);
    [a2 - x * n.x, -x * n.y, -x * n.z, a2 - y * n.y, -y * n.z, a2 - a2 * n.z * n.z]
}

/// Level-0 quantities of one row.
pub struct TexelRows<'a> {
    /// Unit normals, x y z.
    pub normal: [&'a [f32]; 3],
    /// Perceptual roughness.
    pub perceptual: &'a [f32],
    /// Base tensors xx xy yy in the bent frames of the normals, where they are not isotropic.
    pub tensors: Option<[&'a [f32]; 3]>,
}
