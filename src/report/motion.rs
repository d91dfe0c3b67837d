//! The chains in motion, beside the truth.

use super::Motion;
use crate::codec::write_apng;
use crate::compare::{Candidate, score_motion};
use crate::image::Raster;
use crate::material::{Material, Texels, base_lobes};
use crate::ndf::Form;
use crate::render::{self, Image, Sampling, Scene, display, sequence, side_by_side, tonemap};

/// Pixels along a side of a picture: two animations of four pictures stay well below the page's 5 MB.
const PIXELS: usize = 72;
/// Each picture's pixels in the animation.
const ENLARGED: usize = 2;
/// As FLIP's authors take a screen: 0.7 m away, 0.7 m wide, 3840 pixels across (Andersson et al. 2020, sec. 3).
const PIXELS_PER_DEGREE: f32 = 67.0;
const MILLISECONDS: u16 = 90;

fn frames(motion: render::Motion) -> usize {
    match motion {
        render::Motion::Zoom => 20,
        render::Motion::Pan => 10,
    }
}

/// Zoom and pan of every chain, one ray a pixel through its mips, beside the supersampled truth; under an open sky with
/// a sun. `done` is called with the share of the work that is done.
pub fn motion(material: &Material, chains: &[Candidate], done: &(dyn Fn(f64) + Sync)) -> Vec<Motion> {
    let scene = Scene::outdoor();
    let form = if material.is_anisotropic() { Form::Anisotropic } else { Form::Isotropic };
    let base = [base_lobes(material, form)];
    let mut motions = Vec::new();
    for (i, motion) in render::Motion::ALL.into_iter().enumerate() {
        let share = |part: usize| (i + part) as f64 / render::Motion::ALL.len() as f64;
        done(share(0));
        let draw = |levels, sampling| -> Vec<Image> {
            sequence(&scene, levels, motion, frames(motion), PIXELS, sampling, &|| ())
        };
        let truth = draw(&base, motion.truth());
        let moving: Vec<Vec<Image>> = chains.iter().map(|chain| draw(&chain.levels, Sampling::mips(1))).collect();
        let shown = |frames: &[Image]| frames.iter().map(|frame| display(frame, scene.exposure)).collect::<Vec<_>>();
        let target = shown(&truth);
        let score = |(chain, frames): (&Candidate, &Vec<Image>)| {
            score_motion(motion.name(), &chain.name, &shown(frames), &target, PIXELS_PER_DEGREE)
        };
        let scores = chains.iter().zip(&moving).map(score).collect();
        let sheets: Vec<Raster> = (0..truth.len())
            .map(|k| {
                let picture = |frames: &[Image]| tonemap(&frames[k], scene.exposure);
                let pictures: Vec<(&str, Raster)> = chains
                    .iter()
                    .zip(&moving)
                    .map(|(chain, frames)| (chain.name.as_str(), picture(frames)))
                    .chain([("truth", picture(&truth))])
                    .collect();
                side_by_side(&pictures.iter().map(|(name, picture)| (*name, picture)).collect::<Vec<_>>(), ENLARGED)
            })
            .collect();
        let mut apng = Vec::new();
        write_apng(&mut apng, &sheets, MILLISECONDS, 0).expect("frames of one size, in memory");
        let size = sheets[0].size();
        motions.push(Motion { name: motion.name(), apng, size: (size.width, size.height), scores });
        done(share(1));
    }
    motions
}
