//! The texels' own distribution against brute force, and its promises one by one.

mod accuracy;
mod brute;
mod continuity;
mod cost;
mod dice;
mod hostile;
mod maps;
mod pruning;
mod spread;
mod work;

use glam::{DMat2, DVec2, DVec3};

use super::query::Query;
use super::ways::Ways;
use super::{AlphaSource, Footprint, TexelGlints, Visits};
use crate::roughness::Alpha;

/// Unit vector of a slope `-h.xy / h.z`.
fn half_vector(slope: DVec2) -> DVec3 {
    DVec3::new(-slope.x, -slope.y, 1.0).normalize()
}

/// The Jacobian of pixels `along` by `across` texels on a map of `size` columns and rows, turned by `angle`.
fn jacobian((along, across): (f64, f64), angle: f64, (columns, rows): (usize, usize)) -> DMat2 {
    let (axis, texel) = (DVec2::from_angle(angle), DVec2::new(1.0 / columns as f64, 1.0 / rows as f64));
    DMat2::from_cols(axis * along * texel, axis.perp() * across * texel)
}

fn glints(normals: &ndarray::Array3<f32>, alpha: f32) -> TexelGlints {
    TexelGlints::new(normals, AlphaSource::Constant(Alpha(alpha))).unwrap()
}

/// The exact D by other ways than the usual.
fn ask(glints: &TexelGlints, footprint: &Footprint, h: DVec3, ways: Ways) -> (f64, Visits) {
    match Query::new(&glints.slopes, &glints.pyramid, footprint, h, glints.tails) {
        Some(mut query) => {
            query.ways = ways;
            (query.sum(), query.visits)
        }
        None => Default::default(),
    }
}
