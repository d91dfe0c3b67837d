//! The chains in motion, beside the truth.

use super::svg::cut;
use super::{MANY, Motion};
use crate::codec::write_apng;
use crate::compare::{Candidate, MotionScore, score_motion};
use crate::image::Raster;
use crate::material::{Material, surface_lobes};
use crate::render::{self, Image, Sampling, Scene, display, sequence, side_by_side, tonemap};

/// Pixels along a side of a picture: two animations of four pictures stay well below the page's 5 MB.
const PIXELS: usize = 72;
/// Each picture's pixels in the animation.
const ENLARGED: usize = 2;
/// Pixels of a letter above a picture.
const LETTER: usize = 12;
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
    motion_with(material, chains, PIXELS, done)
}

fn motion_with(material: &Material, chains: &[Candidate], pixels: usize, done: &(dyn Fn(f64) + Sync)) -> Vec<Motion> {
    let scene = Scene::outdoor();
    let base = [surface_lobes(material)];
    let mut motions = Vec::new();
    for (i, motion) in render::Motion::ALL.into_iter().enumerate() {
        let share = |part: usize| (i + part) as f64 / render::Motion::ALL.len() as f64;
        done(share(0));
        let draw = |levels, sampling| -> Vec<Image> {
            sequence(&scene, levels, motion, frames(motion), pixels, sampling, &|| ())
        };
        let truth = draw(&base, motion.truth());
        let moving: Vec<Vec<Image>> = chains.iter().map(|chain| draw(&chain.levels, Sampling::mips(1))).collect();
        let on_display =
            |frames: &[Image]| frames.iter().map(|frame| display(frame, scene.exposure)).collect::<Vec<_>>();
        let target = on_display(&truth);
        let score = |(chain, frames): (&Candidate, &Vec<Image>)| {
            score_motion(motion.name(), &chain.name, &on_display(frames), &target, PIXELS_PER_DEGREE)
        };
        let scores: Vec<MotionScore> = chains.iter().zip(&moving).map(score).collect();
        let shown = to_show(&scores);
        let sheets: Vec<Raster> = (0..truth.len())
            .map(|k| {
                let picture = |frames: &[Image]| tonemap(&frames[k], scene.exposure);
                let chosen = shown.iter().map(|&i| (label(&chains[i].name, pixels), picture(&moving[i])));
                let pictures: Vec<(String, Raster)> = chosen.chain([("truth".into(), picture(&truth))]).collect();
                let labelled: Vec<_> = pictures.iter().map(|(name, picture)| (name.as_str(), picture)).collect();
                side_by_side(&labelled, ENLARGED)
            })
            .collect();
        let mut apng = Vec::new();
        write_apng(&mut apng, &sheets, MILLISECONDS, 0).expect("frames of one size, in memory");
        let size = sheets[0].size();
        let shown = shown.into_iter().map(|i| chains[i].name.clone()).collect();
        motions.push(Motion { name: motion.name(), apng, shown, size: (size.width, size.height), scores });
        done(share(1));
    }
    motions
}

/// What of a name fits over a picture, in the pictures' small alphabet; an ellipsis is not in that.
fn label(name: &str, pixels: usize) -> String {
    cut(name, pixels * ENLARGED / LETTER).replace('\u{2026}', ".")
}

/// All chains, or of many the two that look most like the truth and the one that looks least like it, in their order.
fn to_show(scores: &[MotionScore]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    if scores.len() > MANY {
        order.sort_by(|&a, &b| scores[a].flip_mean.total_cmp(&scores[b].flip_mean));
        order = vec![order[0], order[1], order[scores.len() - 1]];
        order.sort_unstable();
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::base_lobes;
    use crate::ndf::Form;

    /// Two chains of a material of 16 x 16 texels: scores stand in the order of the chains, and the animation has as
    /// many frames and pixels as it says.
    #[test]
    fn pictures_and_scores_belong_to_their_chains() {
        let maps = (crate::sample::by_name("tiles").unwrap().make)(16, 1);
        let inputs = crate::material::Inputs {
            name: "tiles".into(),
            normal: Some("n.png".into()),
            roughness: crate::material::RoughnessInput::Constant(crate::roughness::PerceptualRoughness(0.3)),
            ..Default::default()
        };
        let read = |path: &std::path::Path| {
            let mut bytes = Vec::new();
            crate::codec::write_png(&mut bytes, &maps.normal).unwrap();
            crate::codec::decode(path, bytes)
        };
        let material = crate::material::load_with(&inputs, &read).unwrap();
        let base = base_lobes(&material, Form::Isotropic);
        let chain = |name: &str, alpha: Option<f32>| {
            let lobe = |k: usize, x: usize, y: usize| match alpha {
                Some(alpha) => crate::ndf::Lobe::isotropic(glam::Vec3::Z, crate::roughness::Alpha(alpha)),
                None => base.at(x << k, y << k),
            };
            let level =
                |k: usize| crate::ndf::Lobes::from_fn(Form::Isotropic, base.size().level(k), |x, y| lobe(k, x, y));
            Candidate::new(name, (0..5).map(level).collect())
        };
        let chains = [chain("a name that is much too long", Some(1.0)), chain("near", None)];
        let shares = std::sync::Mutex::new(Vec::new());
        // "truth" just fits.
        const SMALL: usize = 32;
        let motions = motion_with(&material, &chains, SMALL, &|share| shares.lock().unwrap().push(share));
        assert!(shares.lock().unwrap().is_sorted() && shares.lock().unwrap().last() == Some(&1.0));
        assert_eq!(motions.iter().map(|m| m.name).collect::<Vec<_>>(), ["zoom", "pan"]);
        for motion in &motions {
            let names: Vec<_> = motion.scores.iter().map(|score| score.chain.as_str()).collect();
            assert_eq!(names, ["a name that is much too long", "near"]);
            assert_eq!(motion.shown, names);
            assert!(motion.scores[0].flip_mean > 1.5 * motion.scores[1].flip_mean, "{:?}", motion.scores);
            let reader = png::Decoder::new(std::io::Cursor::new(&motion.apng)).read_info().unwrap();
            let info = reader.info();
            assert_eq!((info.width as usize, info.height as usize), motion.size);
            // Three pictures of equal width: no name widens its column.
            assert_eq!(motion.size.0, 3 * SMALL * ENLARGED + 2 * 6 + 2 * 14);
            assert_eq!(info.animation_control.unwrap().num_frames, if motion.name == "zoom" { 20 } else { 10 });
        }
    }

    #[test]
    fn of_many_the_best_and_the_worst_are_shown() {
        let score =
            |flip_mean| MotionScore { motion: "zoom", chain: String::new(), flip_mean, flip_p95: 0.0, flicker: 0.0 };
        assert_eq!(to_show(&[0.3, 0.1, 0.2].map(score)), [0, 1, 2]);
        assert_eq!(to_show(&[0.3, 0.5, 0.2, 0.4, 0.1].map(score)), [1, 2, 4]);
    }
}
