//! How far a mip chain is from the truth: distances between NDFs and between lobes as seen, energy, diffuse light; and
//! of pictures and sequences of them. Nothing here knows how a chain was made.
//!
//! What a test of an engine asks: does my chain stay close enough to the truth at every level?
//!
//! ```
//! use mipfold::compare::{Candidate, Limit, Settings, judge_one};
//! use mipfold::image::Size;
//! use mipfold::material::base_lobes;
//! use mipfold::ndf::{Form, Lobe, Lobes};
//! use mipfold::roughness::Alpha;
//! # struct Plaster;
//! # impl mipfold::material::Texels for Plaster {
//! #     fn size(&self) -> Size { Size::new(8, 8) }
//! #     fn normals(&self, _: usize, _: usize, [nx, ny, nz]: [&mut [f32]; 3], usable: &mut [f32]) {
//! #         nx.fill(0.0); ny.fill(0.0); nz.fill(1.0); usable.fill(1.0);
//! #     }
//! #     fn perceptual(&self, _: usize, _: usize, out: &mut [f32]) { out.fill(0.5) }
//! # }
//!
//! // Level 0 as a renderer reads it (any `Texels`), and the levels that your own code made of it.
//! let base = Plaster;
//! let mut levels = vec![base_lobes(&base, Form::Isotropic)];
//! for k in 1..4 {
//!     levels.push(Lobes::from_fn(Form::Isotropic, Size::new(8, 8).level(k), |_x, _y| {
//!         Lobe::isotropic(glam::Vec3::Z, Alpha(0.25))
//!     }));
//! }
//! let score = judge_one(&base, Candidate::new("plaster", levels), &Settings::default())?;
//! score.keeps(&[Limit::lobe_error(0.15)]).expect("the chain stays within 0.15 lobe error at every level");
//! # Ok::<(), mipfold::Error>(())
//! ```

mod flicker;
mod flip;
mod judge;
mod limit;
mod measure;
mod score;
#[cfg(test)]
mod tests;

pub use flicker::{flicker, score_motion};
pub use flip::flip;
pub use judge::{Candidate, LOBES_A_LEVEL, Settings, judge, judge_one};
pub(crate) use limit::level_range;
pub use limit::{Breach, Limit, Metric};
pub use measure::{LIGHT_RADIUS, VIEWS};
pub use score::{ChainScore, Energy, Judgement, LevelScore, MotionScore, Place, Summary, WorstTexel};
