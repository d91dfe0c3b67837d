//! The distance strip: one surface further and further away, by several chains and by the truth.

use ndarray::Array3;

use super::font::{ADVANCE, GLYPH, dots};
use super::{Sampling, Scene, render, tonemap};
use crate::image::{Raster, Samples};
use crate::ndf::Lobes;

/// The usual distances: sizes of the object, as parts of a cell.
pub const DISTANCES: [f32; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Rays along one side of a pixel for chains: enough to smooth the shape.
const CHAIN_RAYS: usize = 4;
/// For the truth, rays along one side of a *cell's* pixel: an object half as large gets twice as many a pixel, so
/// rays stay equally close on the surface and every column costs the same.
const TRUTH_RAYS: f32 = 6.0;

/// Layout, in pixels of the strip: the width of a dot of the letters, the space between cells, and the margin.
const DOT: usize = 2;
const GAP: usize = 6;
const MARGIN: usize = 14;
const PAPER: u8 = 24;
const INK: u8 = 208;

/// Rows: one for each chain under its name, then the truth, which is level 0 of the first chain (there
/// is at least one), supersampled.
/// Columns: the same object at each of `distances` (parts of `cell`, 0 to 1), enlarged to `cell` x `cell` without
/// smoothing so that its pixels can be seen.
pub fn distance_strip(scene: &Scene, chains: &[(&str, &[Lobes])], cell: usize, distances: &[f32]) -> Raster {
    const TRUTH: &str = "truth";
    let names: Vec<&str> = chains.iter().map(|(name, _)| *name).chain([TRUTH]).collect();
    let letters = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let (line, pitch) = (GLYPH.1 * DOT, cell + GAP);
    let left = MARGIN + letters * ADVANCE * DOT + MARGIN;
    let top = MARGIN + line + MARGIN / 2;
    let size = (top + names.len() * pitch - GAP + MARGIN, left + distances.len() * pitch - GAP + MARGIN, 3);
    let mut sheet = Array3::from_elem(size, PAPER);

    for (row, name) in names.iter().enumerate() {
        write(&mut sheet, name, MARGIN, top + row * pitch + (cell - line.min(cell)) / 2);
    }
    for (column, &distance) in distances.iter().enumerate() {
        let x = left + column * pitch;
        let label = label(distance);
        let width = label.chars().count() * ADVANCE * DOT;
        write(&mut sheet, &label, x + (cell - width.min(cell)) / 2, MARGIN);
        let pixels = ((cell as f32 * distance).round() as usize).max(1);
        for row in 0..names.len() {
            let (levels, sampling) = match chains.get(row) {
                Some((_, levels)) => (*levels, Sampling::Mips { per_side: CHAIN_RAYS }),
                None => {
                    let per_side = (TRUTH_RAYS * cell as f32 / pixels as f32).ceil() as usize;
                    (&chains[0].1[..1], Sampling::Supersampled { per_side })
                }
            };
            let picture = tonemap(&render(scene, levels, pixels, sampling), scene.exposure);
            enlarge(&picture, &mut sheet, x, top + row * pitch, cell);
        }
    }
    Raster::new(Samples::U8(sheet))
}

/// Fills a square cell, every pixel from the nearest of the picture.
fn enlarge(picture: &Raster, sheet: &mut Array3<u8>, left: usize, top: usize, cell: usize) {
    let Samples::U8(picture) = &picture.samples else { unreachable!("tone mapped pictures are 8-bit") };
    let pixels = picture.dim().0;
    for (y, x) in (0..cell).flat_map(|y| (0..cell).map(move |x| (y, x))) {
        for c in 0..3 {
            sheet[(top + y, left + x, c)] = picture[(y * pixels / cell, x * pixels / cell, c)];
        }
    }
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

/// Letters whose top left dot is at column `x` and row `y`; what lies outside is cut off.
fn write(sheet: &mut Array3<u8>, text: &str, x: usize, y: usize) {
    for (column, row) in dots(text) {
        for i in 0..DOT * DOT {
            let (x, y) = (x + column * DOT + i % DOT, y + row * DOT + i / DOT);
            for c in 0..3 {
                if let Some(pixel) = sheet.get_mut((y, x, c)) {
                    *pixel = INK;
                }
            }
        }
    }
}
