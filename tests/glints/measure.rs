//! What is measured of a contender in a case, from one sample of queries.

use glam::DVec2;
use mipfold::glint::{BIWEIGHT_AREA, pcg4d, unit};
use rayon::prelude::*;

use crate::published::cases::Case;
use crate::published::{Contender, Published};

/// Changes by a small movement, in deviations of the ratio itself: a method that hardly glints gains nothing by it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pops {
    /// 99.99th percentile.
    pub rare: f64,
    /// Largest.
    pub most: f64,
}

/// A contender in a case.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// Mean of the ratio and its standard error.
    pub mean: [f64; 2],
    /// Variance times N_eff, and its standard error from the fourth moment.
    pub variance: [f64; 2],
    /// A pan of 1/256 pixel.
    pub pan: Pops,
    /// A zoom of 2^(1/256).
    pub zoom: Pops,
    /// A step of 1/4096 of the chart of directions: 1/180 to 1/360 of a flake's lobe.
    pub turn: Pops,
    /// Correlation with the ratio of a light two radii of the flake's lobe away: the flakes of one cannot answer the other.
    pub neighbour: f64,
    /// Correlation with the ratio of a light that mirrors the half vector about the normal.
    pub mirrored: f64,
}

impl Figures {
    /// Deviation of the mean from 1 beyond three standard errors.
    pub fn bias(&self) -> f64 {
        ((self.mean[0] - 1.0).abs() - 3.0 * self.mean[1]).max(0.0)
    }

    /// Deviation of V* from 1 beyond three standard errors.
    pub fn variance_off(&self) -> f64 {
        ((self.variance[0] - 1.0).abs() - 3.0 * self.variance[1]).max(0.0)
    }

    /// The worst of the three movements.
    pub fn worst(&self) -> Pops {
        let worst = |of: fn(&Pops) -> f64| [self.pan, self.zoom, self.turn].iter().map(of).fold(0.0, f64::max);
        Pops { rare: worst(|p| p.rare), most: worst(|p| p.most) }
    }
}

/// Of `count` queries.
pub fn figures(contender: &Contender, case: Case, count: u32) -> Figures {
    let sample: Vec<[f64; 6]> = (0..count)
        .into_par_iter()
        .map(|n| {
            let q = case.query(contender.tail, n, 1);
            [q, panned(q, n), zoomed(q), turned(q, direction(n) / 4096.0), neighbour(q, n), mirrored(q)]
                .map(|q| contender.ratio(&q))
        })
        .collect();
    let (mean, variance) = moments(&sample.iter().map(|s| s[0]).collect::<Vec<_>>());
    let sigma = variance[0].sqrt();
    let pops = |step: usize| {
        let mut changes: Vec<_> = sample.iter().map(|s| (s[step] - s[0]).abs() / sigma).collect();
        changes.sort_by(f64::total_cmp);
        let rare = changes[((changes.len() as f64 * 0.9999) as usize).min(changes.len() - 1)];
        Pops { rare, most: changes[changes.len() - 1] }
    };
    let correlation = |other: usize| correlation(sample.iter().map(|s| (s[0], s[other])));
    Figures {
        mean,
        variance: variance.map(|v| v * case.n_eff),
        pan: pops(1),
        zoom: pops(2),
        turn: pops(3),
        neighbour: correlation(4),
        mirrored: correlation(5),
    }
}

/// A direction of one's own for each sample.
fn direction(n: u32) -> DVec2 {
    DVec2::from_angle(std::f64::consts::TAU * unit(pcg4d([n, 4, 4, 4])[0]))
}

fn panned(q: Published, n: u32) -> Published {
    Published { at: q.at + q.jacobian * direction(n) / 256.0, ..q }
}

fn zoomed(q: Published) -> Published {
    Published { jacobian: q.jacobian * 2f64.powf(1.0 / 256.0), ..q }
}

/// By a step on the chart of the lobe. Steps that lead over its rim go the other way.
fn turned(q: Published, step: DVec2) -> Published {
    let chart = q.lobe().chart().expect("a finite lobe");
    let y = chart.square(q.h);
    let step = DVec2::select((y + step).cmpgt(DVec2::ONE) | (y + step).cmplt(DVec2::ZERO), -step, step);
    Published { h: chart.normal(y + step), ..q }
}

fn neighbour(q: Published, n: u32) -> Published {
    turned(q, direction(n) * 2.0 * (q.share() / BIWEIGHT_AREA).sqrt())
}

fn mirrored(q: Published) -> Published {
    Published { h: glam::DVec3::new(-q.h.x, -q.h.y, q.h.z), ..q }
}

/// Mean and variance, each with its standard error.
pub fn moments(values: &[f64]) -> ([f64; 2], [f64; 2]) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let central = |power: i32| values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / count;
    let (variance, fourth) = (central(2), central(4));
    let errors = [variance, (fourth - variance * variance).max(0.0)].map(|v| (v / count).sqrt());
    ([mean, errors[0]], [variance, errors[1]])
}

fn correlation(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let count = pairs.clone().count() as f64;
    let (a, b) = pairs.clone().fold((0.0, 0.0), |(a, b), p| (a + p.0 / count, b + p.1 / count));
    let (aa, ab, bb) = pairs.fold((0.0, 0.0, 0.0), |(aa, ab, bb), p| {
        let (x, y) = (p.0 - a, p.1 - b);
        (aa + x * x, ab + x * y, bb + y * y)
    });
    ab / (aa * bb).sqrt()
}
