//! The same surface again and again, a little further away or a little to the side: what mips do in motion.

use glam::{Mat2, Vec2};

use super::geometry::hit;
use super::glint::Glints;
use super::picture::draw;
use super::texture::Texture;
use super::{Image, Sampling, Scene};
use crate::image::Size;
use crate::ndf::Lobes;

/// How the texture moves from frame to frame. The object and its lights stand still, so that every pixel that sees it
/// judges the texture in every frame, and nothing else changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The texture shrinks about its middle, from one level-0 texel a pixel to 16, by equal factors: the object grows
    /// as fast as the camera backs off, so it keeps its size in the picture.
    Zoom,
    /// At 8 texels a pixel, the texture moves 0.31 pixels to the right and 0.17 up in each frame: no two frames near
    /// each other repeat a phase of the pixels.
    Pan,
}

/// Level-0 texels along a side of a pixel at the end of a zoom: 4 octaves, so levels 0 to 4 are seen.
const ZOOM_TEXELS: f32 = 16.0;
/// And in a pan.
const PAN_TEXELS: f32 = 8.0;
/// Pixels from frame to frame of a pan.
const PAN_STEP: Vec2 = Vec2::new(0.31, 0.17);
/// A truth takes at least so many rays along a side of a pixel: enough to smooth the shape's rim.
const LEAST_RAYS: usize = 4;

impl Motion {
    /// Both.
    pub const ALL: [Motion; 2] = [Motion::Zoom, Motion::Pan];

    /// In reports: "zoom" or "pan".
    pub fn name(self) -> &'static str {
        match self {
            Motion::Zoom => "zoom",
            Motion::Pan => "pan",
        }
    }

    /// The truth of a sequence: one ray for each texel in the middle of the farthest frame, in either direction.
    /// More rays change the frames by little; the tests hold by how much.
    pub fn truth(self) -> Sampling {
        Sampling::Supersampled { per_side: self.farthest() as usize }
    }

    fn farthest(self) -> f32 {
        match self {
            Motion::Zoom => ZOOM_TEXELS,
            Motion::Pan => PAN_TEXELS,
        }
    }

    /// Level-0 texels along a side of a pixel in the middle of the picture.
    fn texels(self, frame: usize, frames: usize) -> f32 {
        match self {
            Motion::Zoom => ZOOM_TEXELS.powf(frame as f32 / (frames.max(2) - 1) as f32),
            Motion::Pan => PAN_TEXELS,
        }
    }
}

/// Pictures, each as [`render`](super::render) draws them, of a texture that moves. How often it repeats is the motion's
/// choice and not the scene's.
///
/// `per_side` of [`Sampling::Supersampled`] counts rays in the farthest frame; nearer ones get as many as keep rays
/// equally close on the surface, but at least 4. `done` is called after each frame, from any thread.
pub fn sequence(
    scene: &Scene,
    levels: &[Lobes],
    motion: Motion,
    frames: usize,
    pixels: usize,
    sampling: Sampling,
    done: &(dyn Fn() + Sync),
) -> Vec<Image> {
    moving(scene, levels, motion, frames, pixels, sampling, None, done)
}

/// [`sequence`] with flakes all over the object, one ray a pixel.
pub fn glinting_sequence(
    scene: &Scene,
    levels: &[Lobes],
    motion: Motion,
    frames: usize,
    pixels: usize,
    glints: &Glints,
    done: &(dyn Fn() + Sync),
) -> Vec<Image> {
    moving(scene, levels, motion, frames, pixels, Sampling::mips(1), Some(glints), done)
}

#[expect(clippy::too_many_arguments, reason = "those of both sequences")]
fn moving(
    scene: &Scene,
    levels: &[Lobes],
    motion: Motion,
    frames: usize,
    pixels: usize,
    sampling: Sampling,
    glints: Option<&Glints>,
    done: &(dyn Fn() + Sync),
) -> Vec<Image> {
    let texture = Texture::new(levels);
    let frame = |frame: usize| {
        let texels = motion.texels(frame, frames);
        let (scene, steps) = at_distance(scene, texture.size(), texels, pixels);
        let shift = match motion {
            Motion::Zoom => Vec2::ZERO,
            Motion::Pan => frame as f32 * (Mat2::from_cols(steps[0], steps[1]) * PAN_STEP),
        };
        let sampling = match sampling {
            Sampling::Supersampled { per_side } => {
                let share = (per_side as f32 * texels / motion.farthest()).ceil() as usize;
                Sampling::Supersampled { per_side: share.max(LEAST_RAYS.min(per_side)) }
            }
            mips => mips,
        };
        let image = draw(&scene, &texture, shift, pixels, sampling, glints);
        done();
        image
    };
    (0..frames).map(frame).collect()
}

impl Scene {
    /// The scene with as many repeats as put so many texels of level 0, which has this size, along the side of a pixel in
    /// the middle of a picture.
    pub fn at_texels(&self, size: Size, texels: f32, pixels: usize) -> Self {
        at_distance(self, size, texels, pixels).0
    }
}

/// The scene with as many repeats as put so many texels along the side of a pixel in the middle, and how texture
/// coordinates change over that pixel.
fn at_distance(scene: &Scene, size: Size, texels: f32, pixels: usize) -> (Scene, [Vec2; 2]) {
    let side = (size.texels() as f32).sqrt();
    let once = Scene { repeats: 1.0, ..scene.clone() };
    let middle = |scene: &Scene| hit(scene, Vec2::ZERO, pixels).expect("the middle of the picture is on the object");
    let scene = Scene { repeats: texels / (side * middle(&once).footprint), ..once };
    let steps = middle(&scene).steps;
    (scene, steps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;
    use crate::ndf::{Form, Lobe};
    use crate::render::{Shape, render};
    use crate::roughness::Alpha;
    use glam::Vec3;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Slow waves of normals: 16 texels long.
    fn waves(size: Size) -> Lobes {
        let wave = |i: usize| 0.3 * (i as f32 / 16.0 * std::f32::consts::TAU).sin();
        Lobes::from_fn(Form::Isotropic, size, |x, y| {
            Lobe::isotropic(Vec3::new(wave(x), wave(y), 1.0).normalize(), Alpha(0.3))
        })
    }

    fn change(a: &Image, b: &Image) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / b.sum()
    }

    #[test]
    fn distances_are_texels_a_pixel() {
        for (scene, size) in [(Scene::studio(), Size::new(64, 64)), (Scene::studio_panel(), Size::new(64, 16))] {
            let texture = Texture::new(&[waves(size)]);
            for texels in [1.0, 5.0, 16.0] {
                let (scene, [right, up]) = at_distance(&scene, texture.size(), texels, 48);
                let area =
                    (right * Vec2::new(64.0, size.height as f32)).perp_dot(up * Vec2::new(64.0, size.height as f32));
                assert!((area.sqrt() / texels - 1.0).abs() < 1e-3, "{area} {texels}");
                let found = hit(&scene, Vec2::ZERO, 48).unwrap().footprint * (size.texels() as f32).sqrt();
                assert!((found / texels - 1.0).abs() < 1e-4);
            }
        }
        let zoom: Vec<f32> = (0..5).map(|k| Motion::Zoom.texels(k, 5)).collect();
        assert_eq!(zoom, [1.0, 2.0, 4.0, 8.0, 16.0]);
        assert_eq!((Motion::Zoom.texels(0, 1), Motion::Pan.texels(3, 9)), (1.0, 8.0));
    }

    /// On a panel that faces the camera, where the texture has one size everywhere, 25 frames of a pan move it by 7.75
    /// pixels to the right and 4.25 up.
    #[test]
    fn a_pan_moves_by_parts_of_a_pixel() {
        let scene = Scene { shape: Shape::Plane { tilt: 0.0 }, ..Scene::studio() };
        let texture = Texture::new(&[waves(Size::new(256, 256))]);
        let (scene, steps) = at_distance(&scene, texture.size(), 1.0, 48);
        let at = |frames: f32, place: Vec2| {
            let shift = frames * (Mat2::from_cols(steps[0], steps[1]) * PAN_STEP);
            texture.base(hit(&scene, place, 48).unwrap().uv - shift).next().unwrap().0.normal
        };
        let place = Vec2::new(0.1, -0.2);
        let moved = place + 2.0 / 48.0 * Vec2::new(7.75, 4.25);
        assert!((at(100.0, moved) - at(75.0, place)).length() < 1e-3);
        assert!((at(100.0, place) - at(75.0, place)).length() > 1e-2);
    }

    /// The first frame is a still picture of the scene, and of so many rays a pixel.
    #[test]
    fn frames_are_pictures() {
        let levels = [waves(Size::new(64, 64)), waves(Size::new(32, 32))];
        for (motion, texels) in [(Motion::Zoom, 1.0), (Motion::Pan, 8.0)] {
            let (scene, _) = at_distance(&Scene::outdoor(), levels[0].size(), texels, 16);
            let frames =
                |sampling| sequence(&Scene::outdoor(), &levels, motion, 2, 16, sampling, &|| ()).swap_remove(0);
            assert_eq!(frames(Sampling::mips(1)), render(&scene, &levels, 16, Sampling::mips(1)));
            let per_side = if motion == Motion::Zoom { 4 } else { 8 };
            assert_eq!(frames(motion.truth()), render(&scene, &levels[..1], 16, Sampling::Supersampled { per_side }));
        }
    }

    /// Frames follow each other closely, and twice as many follow more closely.
    #[test]
    fn motion_is_continuous() {
        let levels = [waves(Size::new(128, 128))];
        let truth = |motion: Motion, frames| {
            sequence(&Scene::outdoor(), &levels, motion, frames, 16, Sampling::Supersampled { per_side: 6 }, &|| ())
        };
        let largest = |frames: &[Image]| frames.windows(2).map(|pair| change(&pair[0], &pair[1])).fold(0.0, f32::max);
        let [coarse, fine] = [17, 65].map(|frames| largest(&truth(Motion::Zoom, frames)));
        assert!(fine < 0.5 * coarse && fine > 0.0, "{fine} {coarse}");
        let pan = truth(Motion::Pan, 8);
        assert!(largest(&pan) < 0.1 && largest(&pan) > 0.0, "{}", largest(&pan));
    }

    /// What the usual number of rays leaves open, and what is counted.
    #[test]
    fn the_truth_has_rays_enough() {
        let levels = [waves(Size::new(128, 128))];
        for motion in Motion::ALL {
            let calls = AtomicUsize::new(0);
            let Sampling::Supersampled { per_side } = motion.truth() else { panic!("the truth is supersampled") };
            let draw = |per_side| {
                let sampling = Sampling::Supersampled { per_side };
                sequence(&Scene::outdoor(), &levels, motion, 3, 12, sampling, &|| {
                    calls.fetch_add(1, Ordering::Relaxed);
                })
            };
            let (usual, many) = (draw(per_side), draw(3 * per_side));
            assert_eq!(calls.load(Ordering::Relaxed), 6);
            for (usual, many) in usual.iter().zip(&many) {
                assert!(change(usual, many) < 0.02, "{motion:?}: {}", change(usual, many));
            }
        }
    }
}
