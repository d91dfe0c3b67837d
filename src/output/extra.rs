//! The maps of [`Extra`], level by level.

use ndarray::Array3;

use super::exr::view;
use super::fold_for::{albedo, energy_scale};
use crate::fold::{Chain, Level};
use crate::image::{Raster, Samples, Size};
use crate::material::{Encoding, Extra, LARGEST_ENERGY, LevelView, Material, Texels};
use crate::ndf::{Burley, Form, RoughnessTensor, TensorRoot};

/// Level `k` of an extra map.
pub struct ExtraLevel<'a> {
    extra: Extra,
    view: LevelView<'a>,
    /// Of the chain; nothing at level 0.
    level: Option<&'a Level>,
    k: usize,
}

impl<'a> ExtraLevel<'a> {
    /// Of a chain that was folded for it: see [`super::fold_for`].
    pub fn new(material: &'a Material, chain: &'a Chain, extra: Extra, k: usize) -> Self {
        Self { extra, view: view(material, chain, k), level: k.checked_sub(1).map(|i| &chain.levels[i]), k }
    }

    /// Part of row `y` of a channel, from column `x` on.
    pub fn row(&self, channel: usize, encoding: Encoding, y: usize, x: usize, out: &mut [f32]) {
        match self.extra {
            Extra::Diffuse => match self.level {
                None => out.fill(1.0),
                Some(level) => {
                    let lengths = level.mean_length.as_ref().expect("folded with mean lengths");
                    out.iter_mut().zip(lengths.row(y).iter().skip(x)).for_each(|(out, v)| *out = *v);
                }
            },
            Extra::Energy => {
                let unit = if encoding == Encoding::Signed { 1.0 } else { LARGEST_ENERGY };
                for (i, out) in out.iter_mut().enumerate() {
                    *out = self.level.map_or(1.0, |level| {
                        let own = level.lobes.mixture(x + i, y).map(|(lobe, w)| w * albedo(lobe.roughness)).sum();
                        energy_scale(level.extras[(self.view.material.extras(), y, x + i)], own)
                    }) / unit;
                }
            }
            Extra::Flakes => {
                let flakes = self.view.material.flakes.as_ref().expect("a plan is checked for its flakes");
                let level = &flakes.levels[self.k];
                out.iter_mut().zip(x..).for_each(|(out, x)| *out = level.get((y, x, channel)).copied().unwrap_or(0.0));
            }
            Extra::Axes | Extra::Burley | Extra::Tensor | Extra::Curvature => {
                let tensors = match self.extra {
                    Extra::Curvature => self.added(y, x, out.len()),
                    _ => self.tensors(y, x, out.len()),
                };
                for (out, tensor) in out.iter_mut().zip(tensors) {
                    *out = self.read_out(tensor, encoding)[channel];
                }
            }
        }
    }

    /// Part of row `y` of the lobes' tensors.
    fn tensors(&self, y: usize, x: usize, n: usize) -> Vec<RoughnessTensor> {
        let [mut xx, mut xy, mut yy] = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        match (self.level, self.view.material) {
            (None, material) => {
                let mut perceptual = vec![0.0; n];
                material.perceptual(y, x, &mut perceptual);
                if material.is_anisotropic() {
                    material.tensors(y, x, &perceptual, [&mut xx, &mut xy, &mut yy]);
                } else {
                    xx = perceptual.iter().map(|r| r.powi(4)).collect();
                    yy.copy_from_slice(&xx);
                }
            }
            (Some(Level { lobes, .. }), _) => {
                let planes = if lobes.form() == Form::Isotropic { [3, 3, 3] } else { [3, 4, 5] };
                for (out, plane) in [&mut xx, &mut xy, &mut yy].into_iter().zip(planes) {
                    out.copy_from_slice(&lobes.row(plane, y)[x..x + n]);
                }
                if lobes.form() == Form::Isotropic {
                    xy.fill(0.0);
                }
            }
        }
        (0..n).map(|i| RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] }).collect()
    }

    /// Part of row `y` of what the mesh adds.
    fn added(&self, y: usize, x: usize, n: usize) -> Vec<RoughnessTensor> {
        let mesh = self.view.material.mesh.as_ref().expect("a plan is checked for its mesh");
        mesh.added[self.k].added.row(y).iter().skip(x).take(n).copied().collect()
    }

    fn read_out(&self, tensor: RoughnessTensor, encoding: Encoding) -> [f32; 3] {
        let (axes, main) = (tensor.axes(), self.view.main_axis);
        match (self.extra, encoding) {
            (Extra::Tensor, Encoding::Unsigned) => TensorRoot::from_tensor(tensor).encoded(),
            // A root holds widths up to 1, and a mesh may add up to twice the square of that.
            (Extra::Curvature, Encoding::Unsigned) => TensorRoot::from_tensor(tensor.clamped(0.0, 1.0)).encoded(),
            (Extra::Curvature, Encoding::Signed) => [tensor.xx, tensor.yy, tensor.xy],
            (Extra::Tensor, Encoding::Signed) => {
                let root = TensorRoot::from_tensor(tensor);
                [root.xx, root.yy, root.xy]
            }
            (Extra::Burley, _) => {
                let burley = Burley::from_axes(axes, main);
                [burley.alpha.perceptual().0, burley.anisotropy, burley.rotation]
            }
            (_, Encoding::Unsigned) => [axes.alpha_x.perceptual().0, axes.alpha_y.perceptual().0, axes.turns(main)],
            (_, Encoding::Signed) => [axes.alpha_x.0, axes.alpha_y.0, std::f32::consts::TAU * axes.turns(main)],
        }
    }

    /// The whole level: 16 bit beside maps of more than 8.
    pub fn raster(&self) -> Raster {
        let Size { width, height } = self.view.size();
        let channels = self.extra.channels(Encoding::Unsigned).len();
        let mut values = Array3::zeros((height, width, channels));
        let mut row = vec![0.0; width];
        for y in 0..height {
            for c in 0..channels {
                self.row(c, Encoding::Unsigned, y, 0, &mut row);
                row.iter().enumerate().for_each(|(x, v)| values[(y, x, c)] = v.clamp(0.0, 1.0));
            }
        }
        Raster::new(if bits(self.view.material) == 8 {
            Samples::U8(values.mapv(|v: f32| (v * 255.0).round() as u8))
        } else {
            Samples::U16(values.mapv(|v: f32| (v * 65535.0).round() as u16))
        })
    }
}

/// Bits a sample of extra maps in PNG: as many as the finest map of the material has, at most 16.
pub fn bits(material: &Material) -> u8 {
    if material.maps.iter().any(|map| map.bits > 8) { 16 } else { 8 }
}
