//! Summaries of the texels of a level, row by row.

use super::merge::{Entry, Scratch, merge_to};
use crate::image::Span;
use crate::moments::TexelRows;
use crate::ndf::{Lobe, RoughnessTensor, SlopeLobe};
use crate::roughness::Alpha;

/// Of a lobe of a summary: weight, centre x y, scatter xx xy yy.
pub const QUANTITIES: usize = 6;

/// Mirrors are as smooth as this, so that their density exists; far below what 16 bits of perceptual roughness can tell.
const SMOOTHEST: Alpha = Alpha(1e-6);

/// Rows of summaries of equal size, one plane of f32 a quantity and lobe. Lobes of weight 0 are not there.
#[derive(Clone, Debug, Default)]
pub struct Summaries {
    width: usize,
    height: usize,
    lobes: usize,
    data: Vec<f32>,
}

impl Summaries {
    /// Takes this size, keeping the allocation; the content is unspecified.
    pub fn resize(&mut self, width: usize, height: usize, lobes: usize) {
        (self.width, self.height, self.lobes) = (width, height, lobes);
        self.data.resize(QUANTITIES * lobes * width * height, 0.0);
    }

    /// Texels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Lobes of each summary.
    pub fn lobes(&self) -> usize {
        self.lobes
    }

    /// The row of a quantity of a lobe.
    pub fn row(&self, y: usize, lobe: usize, quantity: usize) -> &[f32] {
        let plane = (y * self.lobes + lobe) * QUANTITIES + quantity;
        &self.data[plane * self.width..][..self.width]
    }

    /// All quantities of a lobe, to write.
    fn lobe_mut(&mut self, y: usize, lobe: usize) -> [&mut [f32]; QUANTITIES] {
        let first = (y * self.lobes + lobe) * QUANTITIES * self.width;
        let mut rows = self.data[first..][..QUANTITIES * self.width].chunks_exact_mut(self.width);
        std::array::from_fn(|_| rows.next().expect("six quantities"))
    }

    /// Row `y` from texels, one lobe each.
    pub fn fill_texels(&mut self, y: usize, weight: &[f32], texels: &TexelRows) {
        debug_assert!(self.lobes == 1);
        let n = self.width;
        let floor = SMOOTHEST.squared();
        let [nx, ny, nz] = texels.normal.map(|row| &row[..n]);
        let [w, x, y, xx, xy, yy] = self.lobe_mut(y, 0);
        w.copy_from_slice(&weight[..n]);
        let mut put = |i: usize, lobe: SlopeLobe| {
            (x[i], y[i]) = (lobe.centre.x, lobe.centre.y);
            (xx[i], xy[i], yy[i]) = (lobe.scatter.xx, lobe.scatter.xy, lobe.scatter.yy);
        };
        let normal = |i: usize| glam::Vec3::new(nx[i], ny[i], nz[i]);
        match texels.tensors {
            None => {
                let perceptual = &texels.perceptual[..n];
                for i in 0..n {
                    let alpha = perceptual[i] * perceptual[i];
                    put(i, SlopeLobe::isotropic(normal(i), (alpha * alpha).max(floor)));
                }
            }
            Some([txx, txy, tyy]) => {
                for i in 0..n {
                    let roughness = RoughnessTensor { xx: txx[i], xy: txy[i], yy: tyy[i] };
                    let roughness = roughness.clamped(floor, f32::MAX);
                    put(i, SlopeLobe::new(&Lobe { normal: normal(i), roughness }));
                }
            }
        }
    }

    /// Appends the lobes of a summary, their weight scaled.
    pub fn append(&self, x: usize, y: usize, scale: f32, out: &mut Vec<Entry>) {
        for lobe in 0..self.lobes {
            let [weight, cx, cy, xx, xy, yy] = std::array::from_fn(|q| self.row(y, lobe, q)[x]);
            let weight = weight * scale;
            if weight > 0.0 {
                let scatter = RoughnessTensor { xx, xy, yy };
                let lobe = SlopeLobe { centre: glam::Vec2::new(cx, cy), scatter };
                out.push(Entry { weight, lobe });
            }
        }
    }

    /// Writes a summary of at most as many lobes as fit.
    pub fn put(&mut self, x: usize, y: usize, entries: &[Entry]) {
        for lobe in 0..self.lobes {
            // What is not there must be a lobe too, for arithmetic.
            let none = || Entry { weight: 0.0, lobe: entries[0].lobe };
            let Entry { weight, lobe: SlopeLobe { centre, scatter } } = entries.get(lobe).copied().unwrap_or_else(none);
            let values = [weight, centre.x, centre.y, scatter.xx, scatter.xy, scatter.yy];
            self.lobe_mut(y, lobe).into_iter().zip(values).for_each(|(row, value)| row[x] = value);
        }
    }

    /// Joins each 2x2 of this block of two rows into a summary of row `y` of `out`, half as wide.
    pub fn halve(&self, out: &mut Summaries, y: usize, buffers: &mut Buffers) {
        debug_assert!(self.height == 2 && self.width == 2 * out.width);
        if 4 * self.lobes <= out.lobes {
            for child in 0..4 {
                for lobe in 0..self.lobes {
                    let target = out.lobe_mut(y, child * self.lobes + lobe);
                    for (quantity, row) in target.into_iter().enumerate() {
                        let source = self.row(child / 2, lobe, quantity)[child % 2..].iter().step_by(2);
                        row.iter_mut().zip(source).for_each(|(out, v)| *out = *v);
                    }
                }
            }
            return;
        }
        let Buffers { entries, scratch } = buffers;
        for x in 0..out.width {
            entries.clear();
            for child in 0..4 {
                self.append(2 * x + child % 2, child / 2, 1.0, entries);
            }
            merge_to(entries, out.lobes, scratch);
            out.put(x, y, entries);
        }
    }

    /// Writes a block of one row from column `x` on.
    pub fn copy_columns(&mut self, other: &Summaries, x: usize) {
        for lobe in 0..self.lobes {
            for (quantity, row) in self.lobe_mut(0, lobe).into_iter().enumerate() {
                row[x..x + other.width].copy_from_slice(other.row(0, lobe, quantity));
            }
        }
    }

    /// One-row blocks of equal size, stacked.
    pub fn stack(rows: &[Summaries]) -> Summaries {
        let Summaries { width, lobes, .. } = rows[0];
        let data = rows.iter().flat_map(|row| &row.data).copied().collect();
        Summaries { width, height: rows.len(), lobes, data }
    }
}

/// Buffers of [`Summaries::halve`].
#[derive(Default)]
pub struct Buffers {
    entries: Vec<Entry>,
    scratch: Scratch,
}

/// Summaries of footprints of any size, with fractional borders, gathered row by row of the source.
#[derive(Default)]
pub struct Gather {
    texels: Vec<Vec<Entry>>,
    scratch: Scratch,
}

impl Gather {
    /// Starts a row of so many texels.
    pub fn start(&mut self, width: usize) {
        self.texels.resize_with(width, Vec::new);
        self.texels.iter_mut().for_each(Vec::clear);
    }

    /// Adds row `y` of a source, of which the share `height` lies in the footprints. Nothing, if `most` is 0.
    pub fn add(&mut self, source: &Summaries, y: usize, height: f32, across: &[Span], most: usize) {
        if most == 0 {
            return;
        }
        for (entries, span) in self.texels.iter_mut().zip(across) {
            for (i, width) in span.weights.iter().enumerate() {
                source.append(span.first + i, y, width * height, entries);
                if entries.len() > 4 * most {
                    merge_to(entries, most, &mut self.scratch);
                }
            }
        }
    }

    /// Writes the summaries of at most `most` lobes as a block of one row.
    pub fn finish(&mut self, most: usize, out: &mut Summaries) {
        out.resize(self.texels.len(), 1, most);
        for (x, entries) in self.texels.iter_mut().enumerate().take(out.width * most.min(1)) {
            merge_to(entries, most, &mut self.scratch);
            out.put(x, 0, entries);
        }
    }
}
