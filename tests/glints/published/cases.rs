//! Queries at random: places, directions, angles of the footprint, and phases of every method's levels of detail.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};
use mipfold::glint::{BIWEIGHT_AREA, Macro, SUPPORT2, Tail, pcg4d, unit};
use mipfold::roughness::Alpha;

use super::Published;

/// Of all queries.
pub const ALPHA: Alpha = Alpha(0.3);

/// What queries have in common.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Effective number of flakes that answer.
    pub n_eff: f64,
    /// Length of the pixel's footprint over its width.
    pub anisotropy: f64,
}

/// What is left to chance in a query, and may be fixed instead.
#[derive(Clone, Copy, Debug)]
pub struct Free {
    /// Width of the pixel over uv: `2^-8` to `2^-7`, an octave.
    pub width: f64,
    /// Angle of its long side from u.
    pub angle: f64,
    /// Share of all flakes that answer: 0.002 to 0.008, an octave of levels of direction.
    pub share: f64,
    /// Direction, as a point of the chart.
    pub y: DVec2,
}

impl Free {
    /// The n-th of a stream. Directions keep off the chart's rim, which is the horizon: there a small step may lead out.
    pub fn new(n: u32, stream: u32) -> Self {
        let h = pcg4d([n, stream, 1, 0x6C1]);
        let y = pcg4d([n, stream, 2, 0x6C1]);
        Self {
            width: (unit(h[0]) - 8.0).exp2(),
            angle: TAU * unit(h[1]),
            share: 0.002 * 4f64.powf(unit(h[2])),
            y: DVec2::new(unit(y[0]), unit(y[1])) * 0.9 + 0.05,
        }
    }
}

impl Case {
    /// The n-th query of a stream, of one of 64 surfaces.
    pub fn query(&self, tail: Tail, n: u32, stream: u32) -> Published {
        self.fixed(tail, n, stream, Free::new(n, stream))
    }

    /// The same with nothing but the place left to chance.
    pub fn fixed(&self, tail: Tail, n: u32, stream: u32, free: Free) -> Published {
        let h = pcg4d([n, stream, 3, 0x6C1]);
        let turn = DMat2::from_angle(free.angle);
        let jacobian = DMat2::from_cols(turn.x_axis * (free.width * self.anisotropy), turn.y_axis * free.width);
        let chart = Macro { tail, ..Macro::isotropic(ALPHA) }.chart().expect("a finite lobe");
        let normal = chart.normal(free.y);
        let area = BIWEIGHT_AREA * SUPPORT2 * jacobian.determinant().abs();
        Published {
            at: DVec2::new(unit(h[0]), unit(h[1])) * 4096.0,
            jacobian,
            h: normal,
            alpha: ALPHA,
            tail,
            density: self.n_eff / (area * free.share),
            flake: free.share / chart.density(normal),
            seed: h[2] % 64,
        }
    }
}
