//! The distance strip: one surface further and further away, by several chains and by the truth.

use super::sheet::{GAP, LINE, MARGIN, Sheet, width};
use super::{Sampling, Scene, render, tonemap};
use crate::image::Raster;
use crate::ndf::Lobes;

/// The usual distances: sizes of the object, as parts of a cell.
pub const DISTANCES: [f32; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Rays along one side of a pixel for chains: enough to smooth the shape.
const CHAIN_RAYS: usize = 4;
/// For the truth, rays along one side of a *cell's* pixel: an object half as large gets twice as many a pixel, so
/// rays stay equally close on the surface and every column costs the same.
const TRUTH_RAYS: f32 = 6.0;

/// Rows: one for each chain under its name, then the truth, which is level 0 of the first chain (there
/// is at least one), supersampled.
/// Columns: the same object at each of `distances` (parts of `cell`, 0 to 1), enlarged to `cell` x `cell` without
/// smoothing so that its pixels can be seen.
pub fn distance_strip(scene: &Scene, chains: &[(&str, &[Lobes])], cell: usize, distances: &[f32]) -> Raster {
    const TRUTH: &str = "truth";
    let names: Vec<&str> = chains.iter().map(|(name, _)| *name).chain([TRUTH]).collect();
    let names_width = names.iter().map(|name| width(name)).max().unwrap_or(0);
    let pitch = cell + GAP;
    let left = MARGIN + names_width + MARGIN;
    let top = MARGIN + LINE + MARGIN / 2;
    let mut sheet = Sheet::new(left + distances.len() * pitch - GAP + MARGIN, top + names.len() * pitch - GAP + MARGIN);

    for (row, name) in names.iter().enumerate() {
        sheet.write(name, MARGIN, top + row * pitch + (cell - LINE.min(cell)) / 2);
    }
    for (column, &distance) in distances.iter().enumerate() {
        let x = left + column * pitch;
        let label = label(distance);
        sheet.write(&label, x + (cell - width(&label).min(cell)) / 2, MARGIN);
        let pixels = ((cell as f32 * distance).round() as usize).max(1);
        for row in 0..names.len() {
            let (levels, sampling) = match chains.get(row) {
                Some((_, levels)) => (*levels, Sampling::mips(CHAIN_RAYS)),
                None => {
                    let per_side = (TRUTH_RAYS * cell as f32 / pixels as f32).ceil() as usize;
                    (&chains[0].1[..1], Sampling::Supersampled { per_side })
                }
            };
            let picture = tonemap(&render(scene, levels, pixels, sampling), scene.exposure);
            sheet.place(&picture, x, top + row * pitch, (cell, cell));
        }
    }
    sheet.raster()
}

/// "1", "1/2", or a decimal number.
fn label(distance: f32) -> String {
    let inverse = 1.0 / distance;
    if distance == 1.0 {
        "1".into()
    } else if (inverse - inverse.round()).abs() < 1e-3 {
        format!("1/{inverse:.0}")
    } else {
        format!("{distance:.2}")
    }
}
