//! Drawing.

use glam::{Vec2, Vec3};
use ndarray::Array3;
use rayon::prelude::*;

use super::Scene;
use super::geometry::{hit, ray};
use super::glint::Glints;
use super::shade::Lighting;
use super::texture::{Filter, Texture};
use crate::image::{Raster, Samples};
use crate::ndf::{Lobe, Lobes};

/// Radiance, linear RGB, axes (row, column, channel).
pub type Image = Array3<f32>;

/// Where lobes come from. Either way a pixel is the mean radiance of `per_side` x `per_side` rays, each through the
/// middle of its share of the pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// From the chain, at the level that fits the whole pixel. One ray is what a game draws; more rays
    /// smooth the shape's rim and curvature, and leave what the chain does to the texture.
    Mips {
        /// Rays along one side of a pixel.
        per_side: usize,
        /// How levels are looked up.
        filter: Filter,
    },
    /// From level 0, bilinear: the truth, once rays lie closer than texels.
    Supersampled {
        /// Rays along one side of a pixel.
        per_side: usize,
    },
}

impl Sampling {
    /// Trilinear look-ups in the chain.
    pub fn mips(per_side: usize) -> Self {
        Self::Mips { per_side, filter: Filter::Trilinear }
    }
}

/// A square picture, `pixels` wide, of the scene's object covered in a mip chain: `levels`, level 0 first, each half
/// as large as the one before, repeating.
pub fn render(scene: &Scene, levels: &[Lobes], pixels: usize, sampling: Sampling) -> Image {
    draw(scene, &Texture::new(levels), Vec2::ZERO, pixels, sampling, None)
}

/// [`render`], with flakes all over it.
pub fn render_glints(scene: &Scene, levels: &[Lobes], pixels: usize, sampling: Sampling, glints: &Glints) -> Image {
    draw(scene, &Texture::new(levels), Vec2::ZERO, pixels, sampling, Some(glints))
}

/// [`render`], with the texture moved on by `shift` in texture coordinates.
pub(super) fn draw(
    scene: &Scene,
    texture: &Texture,
    shift: Vec2,
    pixels: usize,
    sampling: Sampling,
    glints: Option<&Glints>,
) -> Image {
    let (Sampling::Mips { per_side, .. } | Sampling::Supersampled { per_side }) = sampling;
    let lighting = Lighting::new(&scene.lights, scene.environment, scene.f0);
    let radiance = |place: Vec2| {
        let Some(hit) = hit(scene, place, pixels) else {
            return scene.environment.map_or(scene.background, |sky| sky.radiance(ray(place)));
        };
        let uv = hit.uv - shift;
        let flakes = glints.map(|glints| glints.at(scene, place, pixels, per_side, &hit, shift));
        // A texel of several lobes shines as its parts do, each by its share of the area.
        let part = |(lobe, weight): (Lobe, f32)| match weight {
            0.0 => Vec3::ZERO,
            _ => weight * lighting.glinting(&lobe, hit.position, hit.normal, hit.frame, hit.view, flakes.as_ref()),
        };
        match sampling {
            Sampling::Mips { filter: Filter::Trilinear, .. } => texture.mipped(uv, hit.footprint).map(part).sum(),
            Sampling::Mips { filter: Filter::Anisotropic { taps }, .. } => {
                texture.anisotropic(uv, hit.steps, taps).map(part).sum()
            }
            Sampling::Supersampled { .. } => texture.base(uv).map(part).sum(),
        }
    };
    // Rays count from the picture's top left corner.
    let rays = (pixels * per_side) as f32;
    let place = |ray: usize| (2 * ray + 1) as f32 / rays - 1.0;
    let pixel = |x: usize, y: usize| {
        let row = |y: usize| -> Vec3 {
            (x * per_side..(x + 1) * per_side).map(|x| radiance(Vec2::new(place(x), -place(y)))).sum()
        };
        (y * per_side..(y + 1) * per_side).map(row).sum::<Vec3>() / (per_side * per_side) as f32
    };
    let mut image = Image::zeros((pixels, pixels, 3));
    let rows = image.as_slice_mut().expect("standard layout").par_chunks_mut(3 * pixels);
    rows.enumerate().for_each(|(y, row)| {
        for (x, out) in row.chunks_exact_mut(3).enumerate() {
            out.copy_from_slice(&pixel(x, y).to_array());
        }
    });
    image
}

/// sRGB, 0 to 1: `1 - exp(-exposure x radiance)` per channel, which keeps highlights apart that plain clipping would
/// make all white, then the curve of IEC 61966-2-1.
pub fn display(image: &Image, exposure: f32) -> Image {
    image.mapv(|radiance| {
        let linear = 1.0 - (-exposure * radiance).exp();
        if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
    })
}

/// [`display`] in 8 bits.
pub fn tonemap(image: &Image, exposure: f32) -> Raster {
    Raster::new(Samples::U8(display(image, exposure).mapv(|encoded| (255.0 * encoded + 0.5) as u8)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;
    use crate::ndf::Form;
    use crate::roughness::Alpha;

    /// Of one mixture everywhere, a picture is the weighted sum of the pictures of its lobes.
    #[test]
    fn a_mixture_is_the_weighted_sum_of_its_lobes() {
        let lobe = |x: f32, y: f32, alpha| Lobe::isotropic(Vec3::new(x, y, 1.0).normalize(), Alpha(alpha));
        let parts = [(lobe(0.3, 0.1, 0.2), 0.5), (lobe(-0.4, 0.0, 0.5), 0.2), (lobe(0.0, 0.2, 0.1), 0.3)];
        let size = Size::new(8, 8);
        let scene = Scene::outdoor();
        for filter in [Filter::Trilinear, Filter::Anisotropic { taps: 4 }] {
            let draw = |level: &dyn Fn(Size) -> Lobes| {
                let levels: Vec<Lobes> = (0..size.level_count()).map(|k| level(size.level(k))).collect();
                render(&scene, &levels, 12, Sampling::Mips { per_side: 1, filter })
            };
            let found = draw(&|size| Lobes::mixed_from_fn(Form::Isotropic, 3, size, |j, _, _| parts[j]));
            let mut sum = Image::zeros(found.dim());
            let mut background = 0.0;
            for (lobe, weight) in parts {
                sum.scaled_add(weight, &draw(&|size| Lobes::from_fn(Form::Isotropic, size, |_, _| lobe)));
                background += weight;
            }
            assert!((background - 1.0).abs() < 1e-6);
            let off = found.iter().zip(&sum).map(|(a, b)| (a - b).abs() / (1e-3 + b.abs())).fold(0.0, f32::max);
            assert!(off < 1e-4, "{filter:?}: {off}");
        }
    }

    #[test]
    fn tonemap_worked_by_hand() {
        // exp(-ln 2) leaves half, which sRGB encodes as 0.7354; the curve's straight part starts from 0.
        let radiance = [0.0, 0.001, 0.5 * std::f32::consts::LN_2, 1e9];
        let image = Array3::from_shape_fn((1, 4, 3), |(_, x, _)| radiance[x]);
        let raster = tonemap(&image, 2.0);
        let bytes = [0, 1, 2, 3].map(|x| (255.0 * raster.at(x, 0, 1)).round());
        assert_eq!(bytes, [0.0, 7.0, 188.0, 255.0]);
    }
}
