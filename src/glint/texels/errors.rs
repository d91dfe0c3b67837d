//! What estimates are off by: root mean squares, as measured on noise, bumps and scratches.

use std::f64::consts::FRAC_1_PI;

use super::ways::Range;

/// A bound of the lobe over a range, from its nearest normal.
pub(super) fn highest(range: &Range, alpha: f64) -> f64 {
    // Lobes are functions of tangents; their sines end at the horizon.
    let near = range.near.min(1e12);
    let bent = 1.0 + alpha * alpha * (near - 1.0);
    FRAC_1_PI * (bent / (alpha * near)).powi(2)
}

/// The mean over a block by its moments, `mean` its estimate.
#[inline]
pub(super) fn block(mean: f64, range: &Range, alpha: f64, cells: usize) -> f64 {
    let (highest, wide) = (highest(range, alpha), range.extent / range.near);
    let root = (cells as f64).sqrt();
    let spiky =
        if range.near > 4.0 { 0.5 } else { 0.2 } * (highest * mean / root * (32.0 / wide.sqrt()).min(1.0)).sqrt();
    spiky.min(0.0025 * highest * wide * root)
}

/// The integral over a block by its moments, for the kernel's change over it, times its area, and the lobe's going together:
/// on smooth maps with wide lobes that is all there is.
#[inline]
pub(super) fn tilted(change: f64, mean: f64, range: &Range) -> f64 {
    0.05 * change * mean * (range.extent / range.near).sqrt().min(1.0)
}

/// The mean over a cell away from h by half of this: what its nearest part may have.
#[inline]
pub(super) fn beside(range: &Range, alpha: f64) -> f64 {
    let width = (range.extent / range.near).sqrt();
    0.5 * highest(range, alpha) / width * (8.0 / width).min(1.0)
}

/// The mean over a piece by four points.
#[inline]
pub(super) fn points(range: &Range, alpha: f64) -> f64 {
    let wide = range.extent / range.near;
    highest(range, alpha)
        * (6e-4 * wide * wide).min(0.008 + 0.04 * (16.0 / wide.sqrt()).min(1.0) / (range.near * range.near))
}

/// The mean over a piece by triangles that are off it by `twist` widths of the lobe, the squares of its normals' lengths
/// being up to a factor `steepening` apart.
#[inline]
pub(super) fn triangles(twist: f64, steepening: f64, range: &Range, alpha: f64) -> f64 {
    let wide = range.extent / range.near;
    let folded = if range.near > 4.0 { 0.05 } else { 0.15 };
    let off = (folded * twist / range.near.sqrt()).min(0.2) + (0.03 * (steepening - 1.0)).min(0.1);
    highest(range, alpha) * off / wide.sqrt().max(1.0)
}
