//! Statistics, equality with truths, continuity, limits. Samples are fixed by seeds; limits are stated in standard
//! errors. Heavy samples are ignored, with smaller ones that run. `--nocapture` shows what is measured.

#![allow(clippy::print_stderr)]

mod chart;
mod lights;
mod limits;
mod motion;
mod oracle;
mod variance;

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::footprint::Ellipse;
use super::hash::{pcg4d, unit};
use super::probe::Probe;

/// A stretched footprint of effective area `n_eff / area`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub(super) n_eff: f64,
    pub(super) area: f64,
    pub(super) anisotropy: f64,
    pub(super) angle: f64,
}

impl Case {
    pub(super) fn round(n_eff: f64, area: f64) -> Self {
        Self { n_eff, area, anisotropy: 1.0, angle: 0.0 }
    }

    fn kernel(&self) -> Ellipse {
        let r2 = Ellipse::round(1.0).area();
        let short2 = self.n_eff / self.area / r2 / self.anisotropy;
        let turn = DMat2::from_angle(self.angle);
        let long = turn.x_axis * (short2.sqrt() * self.anisotropy);
        let short = turn.y_axis * short2.sqrt();
        Ellipse {
            xx: long.x * long.x + short.x * short.x,
            xy: long.x * long.y + short.x * short.y,
            yy: long.y * long.y + short.y * short.y,
        }
    }

    /// A query at a random place, in a random direction, of one of 64 surfaces.
    pub(super) fn probe(&self, n: u32, stream: u32) -> Probe {
        let (h, more) = (pcg4d([n, stream, 1, 77]), pcg4d([n, stream, 2, 77]));
        Probe {
            at: DVec2::new(unit(h[0]) - 0.5, unit(h[1]) - 0.5) * 1e6,
            kernel: self.kernel(),
            y: DVec2::new(unit(h[2]), unit(h[3])),
            area: self.area,
            widths: DVec2::new(unit(more[0]), unit(more[1])) * 100.0,
            seed: more[2] % 64,
            variation2: 0.0,
        }
    }
}

/// Mean and variance of `value` over 0..count, and the standard error of each (of the variance from the fourth moment).
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    pub(super) mean: f64,
    pub(super) variance: f64,
    pub(super) mean_error: f64,
    pub(super) variance_error: f64,
}

pub(super) fn moments(count: u32, value: impl Fn(u32) -> f64 + Sync) -> Moments {
    let sums = (0..count)
        .into_par_iter()
        .map(|n| {
            let d = value(n) - 1.0;
            [d, d * d, d * d * d, d * d * d * d]
        })
        .reduce(|| [0.0; 4], |a, b| std::array::from_fn(|i| a[i] + b[i]));
    let [m, m2, m3, m4] = sums.map(|s| s / f64::from(count));
    let variance = m2 - m * m;
    let fourth = m4 - 4.0 * m * m3 + 6.0 * m * m * m2 - 3.0 * m.powi(4);
    let root = f64::from(count).sqrt();
    Moments {
        mean: 1.0 + m,
        variance,
        mean_error: variance.max(0.0).sqrt() / root,
        variance_error: (fourth - variance * variance).max(0.0).sqrt() / root,
    }
}

/// The value below which this share of them lies; sorts them.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() as f64 * share) as usize).min(values.len() - 1)]
}

/// `value` over 0..count.
pub(super) fn sample(count: u32, value: impl Fn(u32) -> f64 + Sync + Send) -> Vec<f64> {
    (0..count).into_par_iter().map(value).collect()
}

/// Correlation of pairs.
pub(super) fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / n;
    let (a, b) = (mean(&|p| p.0), mean(&|p| p.1));
    let (aa, bb) = (mean(&|p| (p.0 - a).powi(2)), mean(&|p| (p.1 - b).powi(2)));
    mean(&|p| (p.0 - a) * (p.1 - b)) / (aa * bb).sqrt()
}
