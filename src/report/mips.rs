//! All levels of all chains in one picture.

use ndarray::Array3;

use super::pictures::png;
use super::strip::smaller;
use super::svg::{Svg, number};
use crate::compare::Candidate;
use crate::error::Result;
use crate::image::{Raster, Samples, Size};
use crate::ndf::Lobes;
use crate::roughness::Alpha;

/// Units that level 0 is wide, and each level beside the finer one. The true half would leave nothing to see of the
/// coarse ones.
const LARGEST: f64 = 148.0;
const SHRINK: f64 = 0.84;
const GAP: f64 = 8.0;
const LEFT: f64 = 96.0;
const TOP: f64 = 22.0;
/// Between chains, with room for a name.
const PITCH: f64 = 40.0;

/// Texels of a level that a pixel of its picture averages along a side, at most; of finer levels every n-th texel is
/// taken.
const DENSEST: usize = 4;

/// Pixels of the picture of a level, the longer side `target`.
fn shown(size: Size, target: f64) -> Size {
    let scale = target / size.width.max(size.height) as f64;
    let side = |n: usize| ((n as f64 * scale).round() as usize).max(1);
    Size::new(side(size.width), side(size.height))
}

/// For each of `to` pixels the texels of `from` under it, and how much of the pixel each fills. Where texels are larger
/// than pixels only the pixels on their borders mix two, so that texels stay crisp and equally wide.
fn shares(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    let ratio = from as f64 / to as f64;
    let step = (from / (DENSEST * to)).max(1);
    let pixel = |i: usize| {
        let (low, high) = (i as f64 * ratio, (i + 1) as f64 * ratio);
        let texels = (low as usize..((high - 1e-9).ceil() as usize).min(from)).step_by(step);
        let share = |j: usize| (high.min((j + 1) as f64) - low.max(j as f64)) as f32;
        let total: f32 = texels.clone().map(share).sum();
        texels.map(|j| (j, share(j) / total)).collect()
    };
    (0..to).map(pixel).collect()
}

/// Normals as colours, or perceptual roughness as gray; of several lobes the mean by weight.
fn picture(lobes: &Lobes, to: Size, normals: bool) -> Raster {
    let from = lobes.size();
    let (across, down) = (shares(from.width, to.width), shares(from.height, to.height));
    let channels = if normals { 3 } else { 1 };
    let mut out = Array3::zeros((to.height, to.width, channels));
    for (y, rows) in down.iter().enumerate() {
        for (x, columns) in across.iter().enumerate() {
            let mut sum = [0.0; 3];
            for &(j, down) in rows {
                for &(i, across) in columns {
                    for (lobe, weight) in lobes.mixture(i, j) {
                        let values = if normals {
                            (0.5 * lobe.normal + 0.5).to_array()
                        } else {
                            [Alpha::from_squared(lobe.roughness.mean()).perceptual().0, 0.0, 0.0]
                        };
                        (0..3).for_each(|c| sum[c] += down * across * weight * values[c]);
                    }
                }
            }
            (0..channels).for_each(|c| out[(y, x, c)] = (255.0 * sum[c].clamp(0.0, 1.0)).round() as u8);
        }
    }
    Raster::new(Samples::U8(out))
}

/// The picture: two rows for each chain, normals above perceptual roughness, level 0 on the left.
pub(super) fn strip(chains: &[Candidate]) -> Result<String> {
    let count = chains.iter().map(|chain| chain.levels.len()).max().unwrap_or(0);
    let base = chains.first().map_or(Size::new(1, 1), |chain| chain.levels[0].size());
    let largest = smaller(LARGEST, chains.len());
    let targets: Vec<f64> = (0..count).map(|k| largest * SHRINK.powi(k as i32)).collect();
    let mut columns = vec![LEFT];
    for (k, target) in targets.iter().enumerate() {
        // Room for the number of a level that is narrow.
        let width = (shown(base.level(k), *target).width as f64).max(16.0);
        columns.push(columns[k] + width + GAP);
    }
    let row = targets.iter().enumerate().map(|(k, t)| shown(base.level(k), *t).height as f64).fold(24.0, f64::max);
    let height = TOP + chains.len() as f64 * (2.0 * row + GAP + PITCH) + 8.0;
    let description = "Normals as colours above perceptual roughness as gray, black smooth and white rough, for every \
                       level of every chain.";
    let mut svg = Svg::new("mips", "mips", (columns[count], height), "All levels of all chains", description);
    for k in 0..count {
        svg.text((columns[k], 13.0), "tick", "start", &k.to_string());
    }
    for (i, chain) in chains.iter().enumerate() {
        let top = TOP + i as f64 * (2.0 * row + GAP + PITCH) + 20.0;
        svg.text((0.0, top - 8.0), "row-name", "start", &chain.name);
        for (normals, y, what) in [(true, top, "normals"), (false, top + row + GAP, "roughness")] {
            svg.text((0.0, y + 0.5 * row + 4.0), "tick", "start", what);
            for (k, lobes) in chain.levels.iter().enumerate() {
                let size = shown(lobes.size(), targets[k]);
                let title = format!("{}, {what}, level {k}", chain.name);
                svg.open("g", &[]);
                svg.element("title", &[], &title);
                svg.shape(
                    "image",
                    &[
                        ("x", &number(columns[k])),
                        ("y", &number(y)),
                        ("width", &size.width),
                        ("height", &size.height),
                        ("preserveAspectRatio", &"none"),
                        ("href", &png(&picture(lobes, size, normals))?),
                    ],
                );
                svg.close("g");
            }
        }
    }
    Ok(svg.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_bounded_and_texels_have_their_share() {
        assert_eq!(shown(Size::new(4096, 2048), 148.0), Size::new(148, 74));
        assert_eq!(shown(Size::new(300, 1), 148.0), Size::new(148, 1));
        assert_eq!(shown(Size::new(1, 1), 20.0), Size::new(20, 20));
        assert_eq!(shares(2, 3), [vec![(0, 1.0)], vec![(0, 0.5), (1, 0.5)], vec![(1, 1.0)]]);
        assert_eq!(shares(4, 2), [vec![(0, 0.5), (1, 0.5)], vec![(2, 0.5), (3, 0.5)]]);
        for (from, to) in [(4096, 148), (1, 20), (37, 36), (100, 148)] {
            let shares = shares(from, to);
            assert!(shares.iter().all(|p| p.len() <= 2 * DENSEST + 1), "{from} to {to}");
            assert!(shares.iter().all(|p| (p.iter().map(|s| s.1).sum::<f32>() - 1.0).abs() < 1e-5));
        }
    }
}
