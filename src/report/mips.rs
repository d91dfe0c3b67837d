//! All levels of all chains in one picture.

use ndarray::Array3;

use super::pictures::png;
use super::svg::{Svg, number};
use crate::compare::Candidate;
use crate::error::Result;
use crate::image::{Raster, Samples, Size};
use crate::ndf::Lobes;

/// Units that level 0 is wide, and each level beside the finer one. The true half would leave nothing to see of the
/// coarse ones.
const LARGEST: f64 = 148.0;
const SHRINK: f64 = 0.8;
const GAP: f64 = 8.0;
const LEFT: f64 = 96.0;
const TOP: f64 = 22.0;

/// Texels along a side are enlarged a whole number of times, or every n-th is taken, so that they stay crisp. `target`
/// is about the size wanted; the result is (width, height, n).
fn shown(size: Size, target: f64) -> (f64, f64, usize) {
    let side = size.width.max(size.height);
    let step = (side as f64 / target).ceil().max(1.0) as usize;
    let larger = if step == 1 { (target / side as f64).round().max(1.0) } else { 1.0 };
    (size.width.div_ceil(step) as f64 * larger, size.height.div_ceil(step) as f64 * larger, step)
}

/// Every `step`-th texel: normals as colours, or perceptual roughness as gray.
fn picture(lobes: &Lobes, step: usize, normals: bool) -> Raster {
    let Size { width, height } = lobes.size();
    let mut out = Array3::zeros((height.div_ceil(step), width.div_ceil(step), if normals { 3 } else { 1 }));
    let byte = |v: f32| (255.0 * v.clamp(0.0, 1.0)).round() as u8;
    for ((y, x, c), out) in out.indexed_iter_mut() {
        let lobe = lobes.at((x * step + step / 2).min(width - 1), (y * step + step / 2).min(height - 1));
        *out = if normals {
            byte(0.5 + 0.5 * lobe.normal[c])
        } else {
            byte(crate::roughness::Alpha::from_squared(lobe.roughness.mean()).perceptual().0)
        };
    }
    Raster::new(Samples::U8(out))
}

/// The picture: two rows for each chain, normals above perceptual roughness, level 0 on the left.
pub(super) fn strip(chains: &[Candidate]) -> Result<String> {
    let count = chains.iter().map(|chain| chain.levels.len()).max().unwrap_or(0);
    let base = chains.first().map_or(Size::new(1, 1), |chain| chain.levels[0].size());
    let targets: Vec<f64> = (0..count).map(|k| LARGEST * SHRINK.powi(k as i32)).collect();
    let shapes: Vec<_> = targets.iter().enumerate().map(|(k, t)| shown(base.level(k), *t)).collect();
    let mut columns = vec![LEFT];
    for ((w, ..), target) in shapes.iter().zip(&targets) {
        columns.push(columns[columns.len() - 1] + w.max(target * 0.75) + GAP);
    }
    let row = shapes.iter().map(|(_, h, _)| *h).fold(24.0, f64::max);
    let height = TOP + chains.len() as f64 * (2.0 * row + GAP + 22.0) + 8.0;
    let description = "Normals as colours above perceptual roughness as gray, black smooth and white rough, for every \
                       level of every chain.";
    let mut svg = Svg::new("mips", "mips", (columns[count], height), "All levels of all chains", description);
    for k in 0..count {
        svg.text((columns[k], 13.0), "tick", "start", &k.to_string());
    }
    for (i, chain) in chains.iter().enumerate() {
        let top = TOP + i as f64 * (2.0 * row + GAP + 22.0) + 16.0;
        svg.text((0.0, top - 5.0), "row-name", "start", &chain.name);
        for (normals, y, what) in [(true, top, "normals"), (false, top + row + GAP, "roughness")] {
            svg.text((0.0, y + 0.5 * row + 4.0), "tick", "start", what);
            for (k, lobes) in chain.levels.iter().enumerate() {
                let (width, height, step) = shown(lobes.size(), targets[k]);
                let title = format!("{}, {what}, level {k}", chain.name);
                svg.open("g", &[]);
                svg.element("title", &[], &title);
                svg.shape(
                    "image",
                    &[
                        ("x", &number(columns[k])),
                        ("y", &number(y)),
                        ("width", &number(width)),
                        ("height", &number(height)),
                        ("preserveAspectRatio", &"none"),
                        ("href", &png(&picture(lobes, step, normals))?),
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
    fn levels_are_shown_crisp_and_bounded() {
        assert_eq!(shown(Size::new(4096, 2048), 148.0), (147.0, 74.0, 28));
        assert_eq!(shown(Size::new(256, 256), 148.0), (128.0, 128.0, 2));
        assert_eq!(shown(Size::new(8, 8), 38.0), (40.0, 40.0, 1));
        assert_eq!(shown(Size::new(1, 1), 20.0), (20.0, 20.0, 1));
        assert_eq!(shown(Size::new(300, 1), 148.0), (100.0, 1.0, 3));
    }
}
