//! One object from near to far, by every chain and by the truth.

use crate::compare::Candidate;
use crate::error::Result;
use crate::ndf::Lobes;
use crate::render::{DISTANCES, Sampling, Scene, heat, render, tonemap};

use super::MANY;
use super::pictures::{distance, png};

/// How finely pictures are drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Pixels of the largest picture of the strip.
    pub cell: usize,
    /// Rays along one side of a pixel for chains, enough to smooth the shape.
    pub chain_rays: usize,
    /// Rays along one side of a pixel of the largest picture for the truth; further away rays stay as close on the
    /// surface.
    pub truth_rays: usize,
    /// Cells along one side of a picture of a distribution.
    pub disk: usize,
}

impl Default for Look {
    fn default() -> Self {
        Self { cell: 192, chain_rays: 3, truth_rays: 6, disk: 72 }
    }
}

impl Look {
    /// As large as so many chains can be drawn.
    pub fn of(chains: usize) -> Self {
        let usual = Self::default();
        // Whole pixels at 1/16, so that all pictures show the same ball.
        let cell = 16 * (smaller(usual.cell as f64, chains) / 16.0).round() as usize;
        Self { cell: cell.max(32), disk: smaller(usual.disk as f64, chains).round() as usize, ..usual }
    }
}

/// The side of a picture of which every chain has one: where more than [`MANY`] chains share the page's 5 MB, so much
/// smaller that all of them have as many pixels as those of [`MANY`].
pub(super) fn smaller(side: f64, chains: usize) -> f64 {
    side * (MANY as f64 / chains.max(MANY) as f64).sqrt()
}

/// A mean distance of this much of the display's range is drawn white. Fixed, so that reports can be compared.
pub(super) const HOTTEST: f32 = 0.25;

/// Pictures at one distance.
pub(super) struct Column {
    /// Part of the largest size.
    pub distance: f32,
    pub truth: String,
    /// Picture, error map, and mean error, 0 to 1.
    pub chains: Vec<(String, String, f32)>,
}

/// The finest level that a picture needs. The pixel in the middle of the studio's sphere spans the least of the texture,
/// 0.38 `repeats / pixels` of it, which is 1.4 levels finer than `repeats / pixels`; two are kept.
fn finest(levels: &[Lobes], scene: &Scene, pixels: usize) -> usize {
    let texels = scene.repeats / pixels as f32 * (levels[0].size().texels() as f32).sqrt();
    ((texels.log2().floor() as isize - 2).max(0) as usize).min(levels.len() - 1)
}

/// All columns; `base` is level 0 of the truth.
pub(super) fn columns(base: &Lobes, chains: &[Candidate], look: Look, done: &dyn Fn(f64)) -> Result<Vec<Column>> {
    let scene = Scene::studio();
    let draw = |levels: &[Lobes], pixels, sampling| tonemap(&render(&scene, levels, pixels, sampling), scene.exposure);
    let mut columns = Vec::new();
    for (i, &distance_) in DISTANCES.iter().enumerate() {
        let pixels = ((look.cell as f32 * distance_).round() as usize).max(1);
        let per_side = (look.truth_rays * look.cell).div_ceil(pixels);
        let truth = draw(std::slice::from_ref(base), pixels, Sampling::Supersampled { per_side });
        let mut drawn = Vec::new();
        for chain in chains {
            let from = finest(&chain.levels, &scene, pixels);
            let picture = draw(&chain.levels[from..], pixels, Sampling::mips(look.chain_rays));
            let error = distance(&picture, &truth);
            let mean = error.mean().unwrap_or(0.0);
            drawn.push((png(&picture)?, png(&heat(&error, HOTTEST))?, mean));
        }
        columns.push(Column { distance: distance_, truth: png(&truth)?, chains: drawn });
        done((i + 1) as f64 / DISTANCES.len() as f64);
    }
    Ok(columns)
}

/// "full size", "1/4 size".
pub(super) fn distance_name(distance: f32) -> String {
    if distance == 1.0 { "full size".into() } else { format!("1/{:.0} size", 1.0 / distance) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;
    use crate::ndf::{Form, Lobe};
    use crate::roughness::Alpha;
    use glam::Vec3;

    /// Leaving out fine levels must not change a picture.
    #[test]
    fn levels_left_out_are_not_missed() {
        let size = Size::new(256, 256);
        let levels: Vec<_> = (0..size.level_count())
            .map(|k| {
                Lobes::from_fn(Form::Isotropic, size.level(k), |x, y| {
                    let normal = Vec3::new(0.1 * ((x * 7 + y * 3) % 5) as f32, 0.05 * k as f32, 1.0).normalize();
                    Lobe::isotropic(normal, Alpha(0.05 + 0.1 * k as f32))
                })
            })
            .collect();
        let scene = Scene::studio();
        for pixels in [24, 12, 6, 3] {
            let from = finest(&levels, &scene, pixels);
            assert!(pixels > 12 || from > 0);
            let draw = |levels: &[Lobes]| render(&scene, levels, pixels, Sampling::mips(3));
            let furthest =
                draw(&levels).iter().zip(&draw(&levels[from..])).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(furthest < 1e-4, "{pixels} pixels from level {from}: {furthest}");
        }
    }
}
