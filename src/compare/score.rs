//! What the judge says.

use serde::Serialize;

use crate::image::Size;
use crate::ndf::Form;

/// A figure over the judged texels of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Mean over texels.
    pub mean: f64,
    /// Half of the texels lie below.
    pub median: f64,
    /// 95 of 100 texels lie below.
    pub p95: f64,
    /// Standard error of the mean: from the choice of texels, and from the choice of directions.
    pub stderr: f64,
}

/// Reflected energy of the chain over that of the truth, white metal (F = 1): means over views and texels, 1 is right.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Single scattering, as most renderers shade.
    pub mean: f64,
    /// Standard error of `mean`.
    pub stderr: f64,
    /// With multiple-scattering compensation on both sides (Turquin 2019).
    pub compensated: f64,
    /// `mean` for each of the views (0, 30, 30, 60 and 60 degrees).
    pub views: Vec<f64>,
}

/// A texel of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Column.
    pub x: usize,
    /// Row, from the top.
    pub y: usize,
}

/// A judged texel and its lobe error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WorstTexel {
    /// Column.
    pub x: usize,
    /// Row, from the top.
    pub y: usize,
    /// Its lobe error, 0 to 2.
    pub lobe_error: f64,
}

/// One level of one chain.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LevelScore {
    /// 0 is the finest.
    pub level: usize,
    /// Texels across.
    pub width: usize,
    /// Texels down.
    pub height: usize,
    /// Texels that were judged.
    pub samples: usize,
    /// The headline: `integral |f - f_ref| / integral f_ref` over lights, averaged over five views; 0 same, 2 disjoint.
    pub lobe_error: Summary,
    /// The same under a round light of 5 degrees radius.
    pub lobe_error_light: Summary,
    /// Total variation between the NDFs, 0 same, 1 disjoint.
    pub ndf_tv: Summary,
    /// Hellinger distance between the NDFs, 0 to 1.
    pub ndf_hellinger: Summary,
    /// Kullback-Leibler divergence of the chain's NDF from the truth, nats.
    pub ndf_kl: Summary,
    /// Energy ratios.
    pub energy: Energy,
    /// `integral |d - d_ref| / integral d_ref` over lights, d the mean of max(0, n.l).
    pub diffuse_error: Summary,
    /// The texels of largest lobe error among the judged ones, worst first, at most 8.
    pub worst: Vec<WorstTexel>,
    /// The judged texel whose lobe error is the median.
    pub median_texel: Place,
}

/// One chain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChainScore {
    /// As the candidate's.
    pub name: String,
    /// As the candidate's.
    pub fold: Option<String>,
    /// One width or two.
    pub lobes: Form,
    /// Finest first.
    pub levels: Vec<LevelScore>,
}

/// How a chain looks in motion, one sample a pixel beside the supersampled truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionScore {
    /// "zoom" or "pan".
    pub motion: &'static str,
    /// Name of the chain.
    pub chain: String,
    /// Mean over frames of the pictures' mean FLIP error, 0 to 1.
    pub flip_mean: f64,
    /// 95th percentile of the FLIP error over all pixels of all frames.
    pub flip_p95: f64,
    /// Change from frame to frame that the truth does not show, over the change that it does show; 0 is right.
    pub flicker: f64,
}

/// What the judge says of all chains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// Of level 0.
    pub size: Size,
    /// As the candidates.
    pub chains: Vec<ChainScore>,
}

impl ChainScore {
    /// The level with the largest mean lobe error; `None` if no level was judged.
    pub fn worst_level(&self) -> Option<&LevelScore> {
        self.levels.iter().max_by(|a, b| a.lobe_error.mean.total_cmp(&b.lobe_error.mean))
    }
}
