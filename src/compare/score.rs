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
    /// 95 of 100 texels lie below. Like the median, of figures with the noise of each texel's own draws.
    pub p95: f64,
    /// Standard error of the mean: from the choice of texels, and from the choice of directions.
    pub stderr: f64,
}

impl Summary {
    /// Of one value and the variance of its estimate for each judged texel, `share` of all texels of the level; and the
    /// mean bias that was taken off, of which as much may be left.
    pub(super) fn of(values: &[(f64, f64)], share: f64, bias: f64) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|v| v.0).sum::<f64>() / n;
        let noise = values.iter().map(|v| v.1).sum::<f64>() / n;
        let spread = values.iter().map(|v| (v.0 - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        // The spread between texels counts as far as texels were left out; it holds the noise of each already.
        let between = if spread < noise { 0.0 } else { spread - noise };
        let variance = ((1.0 - share) * between + noise) / n + bias * bias;
        let mut sorted: Vec<f64> = values.iter().map(|v| v.0).collect();
        sorted.sort_by(f64::total_cmp);
        Self { mean, median: quantile(&sorted, 0.5), p95: quantile(&sorted, 0.95), stderr: variance.sqrt() }
    }
}

/// Between the two nearest of sorted values (Hyndman & Fan 1996, type 7).
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let place = q * (sorted.len() - 1) as f64;
    let (low, t) = (place as usize, place.fract());
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (sorted[high] - sorted[low]) * t
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
    /// `mean` for each of the views ([`super::VIEWS`]).
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
    /// The headline: `integral |f - f_ref| / integral (f + f_ref) / 2`, over lights above the surface and five views
    /// together; 0 same, 2 disjoint.
    pub lobe_error: Summary,
    /// The same under a round light of 5 degrees radius. Lobes of alpha below 0.03 seem further from the truth than
    /// they are.
    pub lobe_error_light: Summary,
    /// Total variation between the NDFs above the surface, `integral |D - D_ref| / integral (D + D_ref)`; 0 same, 1
    /// disjoint.
    pub ndf_tv: Summary,
    /// Hellinger distance between the NDFs, 0 to 1.
    pub ndf_hellinger: Summary,
    /// Kullback-Leibler divergence of the chain's NDF from the truth, nats, over the normals that both have.
    pub ndf_kl: Summary,
    /// Energy ratios.
    pub energy: Energy,
    /// `integral |d - d_ref| / integral d_ref`, d the mean of max(0, n.l), by 256 lights (within 1 percent of itself).
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
    /// Lobes of a texel: the most of any level.
    pub count: usize,
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
    /// "one width", "2 lobes, two widths".
    pub fn lobes_in_words(&self) -> String {
        let widths = self.lobes.widths();
        if self.count == 1 { widths.into() } else { format!("{} lobes, {widths}", self.count) }
    }

    /// The level with the largest mean lobe error; `None` if no level was judged.
    pub fn worst_level(&self) -> Option<&LevelScore> {
        self.levels.iter().max_by(|a, b| a.lobe_error.mean.total_cmp(&b.lobe_error.mean))
    }
}
