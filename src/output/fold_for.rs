//! A fold with what extra maps and the verdict need beside the lobes.

use crate::curvature;
use crate::fold::{Chain, Level, Options, chain_telling};
use crate::image::Size;
use crate::material::{Extra, LARGEST_ENERGY, Material, Texels};
use crate::ndf::RoughnessTensor;
use crate::reference::average_albedo;
use crate::roughness::Alpha;

/// Folds a material, with all that its extra maps show, and with what plain mips of its roughness would be; `done` as of
/// [`chain_telling`].
pub fn fold_for(material: &Material, options: &Options, extras: &[Extra], done: &(dyn Fn(f64) + Sync)) -> Chain {
    let options = Options { mean_length: extras.contains(&Extra::Diffuse), ..*options };
    chain_telling(&WithMore { material, albedo: extras.contains(&Extra::Energy) }, &options, done)
}

/// Perceptual roughness of two widths: that of their geometric mean.
pub fn geometric_roughness(tensor: RoughnessTensor) -> f32 {
    // The determinant is alpha_x^2 alpha_y^2; roughness is the root of alpha.
    tensor.determinant().max(0.0).sqrt().sqrt().sqrt()
}

/// The channel of [`fold_for`]'s chain that holds the plain average of the perceptual roughness.
pub fn plain_roughness(level: &Level) -> usize {
    level.extras.dim().0 - 1
}

/// Single-scattering albedo of a lobe, averaged over views by their cosine. Two widths count by their geometric mean.
pub fn albedo(roughness: RoughnessTensor) -> f32 {
    average_albedo(Alpha(roughness.determinant().max(0.0).sqrt().sqrt())) as f32
}

/// By how much to multiply what the lobe reflects, so that it is what the footprint does.
pub fn energy_scale(footprint: f32, own: f32) -> f32 {
    (footprint / own).clamp(0.0, LARGEST_ENERGY)
}

/// A surface with more channels that are averaged plainly: its albedo, if that is wanted, and its perceptual roughness.
struct WithMore<'a> {
    material: &'a Material,
    albedo: bool,
}

impl Texels for WithMore<'_> {
    fn size(&self) -> Size {
        self.material.size()
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        self.material.normals(y, x, out, coverage);
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        self.material.perceptual(y, x, out);
    }

    fn is_anisotropic(&self) -> bool {
        self.material.is_anisotropic()
    }

    fn tensors(&self, y: usize, x: usize, perceptual: &[f32], out: [&mut [f32]; 3]) {
        self.material.tensors(y, x, perceptual, out);
    }

    fn curvature(&self) -> Option<&[curvature::Level]> {
        self.material.curvature()
    }

    fn extras(&self) -> usize {
        self.material.extras() + usize::from(self.albedo) + 1
    }

    fn extra(&self, index: usize, y: usize, x: usize, out: &mut [f32]) {
        if index < self.material.extras() {
            return self.material.extra(index, y, x, out);
        }
        let plain = index + 1 == self.extras();
        self.material.perceptual(y, x, out);
        if self.material.is_anisotropic() {
            let perceptual = out.to_vec();
            let [mut xx, mut xy, mut yy] = [perceptual.clone(), perceptual.clone(), perceptual.clone()];
            self.material.tensors(y, x, &perceptual, [&mut xx, &mut xy, &mut yy]);
            let tensor = |i| RoughnessTensor { xx: xx[i], xy: xy[i], yy: yy[i] };
            let of = if plain { geometric_roughness } else { albedo };
            out.iter_mut().enumerate().for_each(|(i, out)| *out = of(tensor(i)));
        } else if !plain {
            out.iter_mut().for_each(|r| *r = average_albedo(Alpha(*r * *r)) as f32);
        }
    }
}
