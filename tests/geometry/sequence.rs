//! An object that moves by parts of a pixel, and its truth.

use glam::{Vec2, Vec3};
use mipfold::ndf::Lobe;
use mipfold::render::{Fragment, Image, Light, PointLobe};
use mipfold::roughness::Alpha;
use ndarray::Array2;

use super::shapes::Object;

/// Over as many frames as are drawn, one pixel to the right and a third of one up.
pub const WAY: Vec2 = Vec2::new(1.0, 0.37);

/// Samples along a side of a pixel of the truth: 1024 in all.
pub const PER_SIDE: usize = 32;

pub struct Sequence<'a> {
    pub object: &'a Object,
    fragments: Vec<Array2<Option<Fragment>>>,
    /// By rule, then by frame.
    pub truth: Vec<Vec<Image>>,
    /// Pixels that see one surface in all frames.
    pub mask: Array2<bool>,
}

/// Frame by frame, one pixel in all.
pub fn steps(frames: usize) -> Vec<Vec2> {
    (0..frames).map(|k| k as f32 / frames as f32 * WAY).collect()
}

impl<'a> Sequence<'a> {
    /// Smooth metal: one truth for each width.
    pub fn metal(object: &'a Object, offsets: &[Vec2], alphas: &[f64]) -> Self {
        let lobes: Vec<Lobe> = alphas.iter().map(|a| Lobe::isotropic(Vec3::Z, Alpha(*a as f32))).collect();
        let rules: Vec<_> = lobes.iter().map(|lobe| move |_: &_| *lobe).collect();
        Self::new(object, offsets, &rules.iter().map(|rule| rule as PointLobe).collect::<Vec<_>>())
    }

    /// One truth for each of `lobes`; the picture is moved by `offsets`, pixels.
    pub fn new(object: &'a Object, offsets: &[Vec2], lobes: &[PointLobe]) -> Self {
        let (scene, pixels) = (object.scene(), object.pixels);
        let mut mask = Array2::from_elem((pixels, pixels), true);
        let (mut fragments, mut truth) = (Vec::new(), vec![Vec::new(); lobes.len()]);
        for &offset in offsets {
            let frame = scene.truth(pixels, offset, PER_SIDE, lobes);
            mask.zip_mut_with(&frame.whole, |all, here| *all &= here);
            truth.iter_mut().zip(frame.images).for_each(|(sequence, image)| sequence.push(image));
            fragments.push(scene.fragments(pixels, offset));
        }
        Self { object, fragments, truth, mask }
    }

    /// All frames, one sample a pixel.
    pub fn draw(&self, lobe: &(dyn Fn(&Fragment, &Light) -> Lobe + Sync)) -> Vec<Image> {
        self.fragments.iter().map(|fragments| self.object.scene().shade(fragments, lobe)).collect()
    }
}
