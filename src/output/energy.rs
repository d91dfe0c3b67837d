//! What a folded lobe reflects, beside what its footprint does.

use crate::curvature;
use crate::fold::{Chain, Options, chain_telling};
use crate::image::Size;
use crate::material::{Extra, LARGEST_ENERGY, Material, Texels};
use crate::ndf::RoughnessTensor;
use crate::reference::average_albedo;
use crate::roughness::Alpha;

/// Folds a material, with all that its extra maps show; `done` as of [`chain_telling`].
pub fn fold_for(material: &Material, options: &Options, extras: &[Extra], done: &(dyn Fn(f64) + Sync)) -> Chain {
    let options = Options { mean_length: extras.contains(&Extra::Diffuse), ..*options };
    if extras.contains(&Extra::Energy) {
        chain_telling(&WithAlbedo(material), &options, done)
    } else {
        chain_telling(material, &options, done)
    }
}

/// Single-scattering albedo of a lobe, averaged over views by their cosine. Two widths count by their geometric mean.
pub fn albedo(roughness: RoughnessTensor) -> f32 {
    average_albedo(Alpha(roughness.determinant().max(0.0).sqrt().sqrt())) as f32
}

/// By how much to multiply what the lobe reflects, so that it is what the footprint does.
pub fn energy_scale(footprint: f32, own: f32) -> f32 {
    (footprint / own).clamp(0.0, LARGEST_ENERGY)
}

/// A surface with its albedo as one more channel that is averaged plainly: the last.
struct WithAlbedo<'a>(&'a Material);

impl Texels for WithAlbedo<'_> {
    fn size(&self) -> Size {
        self.0.size()
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        self.0.normals(y, x, out, coverage);
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        self.0.perceptual(y, x, out);
    }

    fn is_anisotropic(&self) -> bool {
        self.0.is_anisotropic()
    }

    fn tensors(&self, y: usize, x: usize, perceptual: &[f32], out: [&mut [f32]; 3]) {
        self.0.tensors(y, x, perceptual, out);
    }

    fn curvature(&self) -> Option<&[curvature::Level]> {
        self.0.curvature()
    }

    fn extras(&self) -> usize {
        self.0.extras() + 1
    }

    fn extra(&self, index: usize, y: usize, x: usize, out: &mut [f32]) {
        if index < self.0.extras() {
            return self.0.extra(index, y, x, out);
        }
        self.0.perceptual(y, x, out);
        if self.0.is_anisotropic() {
            let perceptual = out.to_vec();
            let [mut xx, mut xy, mut yy] = [perceptual.clone(), perceptual.clone(), perceptual.clone()];
            self.0.tensors(y, x, &perceptual, [&mut xx, &mut xy, &mut yy]);
            let tensor = |i| RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] };
            out.iter_mut().enumerate().for_each(|(i, out)| *out = albedo(tensor(i)));
        } else {
            out.iter_mut().for_each(|r| *r = average_albedo(Alpha(*r * *r)) as f32);
        }
    }
}
