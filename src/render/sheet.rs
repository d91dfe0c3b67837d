//! Pictures and labels on a dark sheet.

use ndarray::Array3;

use super::font::{ADVANCE, GLYPH, dots};
use crate::image::{Raster, Samples};

/// Layout, in pixels of the sheet: the width of a dot of the letters, the height of a line, the space between cells,
/// and the margin.
const DOT: usize = 2;
pub(super) const LINE: usize = GLYPH.1 * DOT;
pub(super) const GAP: usize = 6;
pub(super) const MARGIN: usize = 14;
const PAPER: u8 = 24;
const INK: u8 = 208;

/// Pixels across that a line of text needs.
pub(super) fn width(text: &str) -> usize {
    text.chars().count() * ADVANCE * DOT
}

/// 8-bit RGB.
pub(super) struct Sheet(Array3<u8>);

impl Sheet {
    pub fn new(width: usize, height: usize) -> Self {
        Self(Array3::from_elem((height, width, 3), PAPER))
    }

    /// Letters whose top left dot is at column `x` and row `y`; what lies outside is cut off.
    pub fn write(&mut self, text: &str, x: usize, y: usize) {
        for (column, row) in dots(text) {
            for i in 0..DOT * DOT {
                let (x, y) = (x + column * DOT + i % DOT, y + row * DOT + i / DOT);
                for c in 0..3 {
                    if let Some(pixel) = self.0.get_mut((y, x, c)) {
                        *pixel = INK;
                    }
                }
            }
        }
    }

    /// Fills a cell of so many columns and rows, every pixel from the nearest of the picture.
    pub fn place(&mut self, picture: &Raster, left: usize, top: usize, (across, down): (usize, usize)) {
        let size = picture.size();
        let texel = |c: usize, y: usize, x: usize| match &picture.samples {
            Samples::U8(samples) => samples[(y, x, c)],
            _ => (255.0 * picture.at(x, y, c).clamp(0.0, 1.0) + 0.5) as u8,
        };
        // Gray and gray with alpha have one colour.
        let colours = picture.samples.channels() >= 3;
        for (y, x) in (0..down).flat_map(|y| (0..across).map(move |x| (y, x))) {
            for c in 0..3 {
                let from = texel(if colours { c } else { 0 }, y * size.height / down, x * size.width / across);
                self.0[(top + y, left + x, c)] = from;
            }
        }
    }

    pub fn raster(self) -> Raster {
        Raster::new(Samples::U8(self.0))
    }
}

/// Pictures in a row, each under its label and enlarged `scale` times without smoothing. Pictures of unequal height
/// keep to the top; a label wider than its picture widens its column. 8-bit RGB; alpha is left out.
pub fn side_by_side(pictures: &[(&str, &Raster)], scale: usize) -> Raster {
    let cell = |raster: &Raster| (raster.size().width * scale, raster.size().height * scale);
    let columns: Vec<usize> = pictures.iter().map(|(label, raster)| width(label).max(cell(raster).0)).collect();
    let tallest = pictures.iter().map(|(_, raster)| cell(raster).1).max().unwrap_or(0);
    let top = MARGIN + LINE + MARGIN / 2;
    let inner = columns.iter().sum::<usize>() + GAP * columns.len().saturating_sub(1);
    let mut sheet = Sheet::new(inner + 2 * MARGIN, top + tallest + MARGIN);
    let mut left = MARGIN;
    for ((label, raster), column) in pictures.iter().zip(columns) {
        sheet.write(label, left + (column - width(label)) / 2, MARGIN);
        sheet.place(raster, left + (column - cell(raster).0) / 2, top, cell(raster));
        left += column + GAP;
    }
    sheet.raster()
}

/// Pictures of one size in rows and columns that have names. 8-bit RGB.
pub fn grid(columns: &[&str], rows: &[(&str, Vec<Raster>)]) -> Raster {
    let cell = rows.iter().flat_map(|(_, pictures)| pictures).map(Raster::size).next();
    let (across, down) = cell.map_or((0, 0), |size| (size.width, size.height));
    let left = MARGIN + rows.iter().map(|(name, _)| width(name)).max().unwrap_or(0) + MARGIN;
    let top = MARGIN + LINE + MARGIN / 2;
    let pitch = columns.iter().map(|name| width(name)).max().unwrap_or(0).max(across) + GAP;
    let mut sheet =
        Sheet::new(left + columns.len() * pitch - GAP + MARGIN, top + rows.len() * (down + GAP) - GAP + MARGIN);
    for (i, name) in columns.iter().enumerate() {
        sheet.write(name, left + i * pitch + (pitch - GAP - width(name)) / 2, MARGIN);
    }
    for (j, (name, pictures)) in rows.iter().enumerate() {
        let y = top + j * (down + GAP);
        sheet.write(name, MARGIN, y + (down - LINE.min(down)) / 2);
        for (i, picture) in pictures.iter().enumerate() {
            sheet.place(picture, left + i * pitch + (pitch - GAP - across) / 2, y, (across, down));
        }
    }
    sheet.raster()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;

    #[test]
    fn pictures_stand_under_their_labels() {
        let plain = |width, height, value: u8| Raster::new(Samples::U8(Array3::from_elem((height, width, 3), value)));
        let (small, large) = (plain(20, 10, 100), plain(30, 12, 200));
        let sheet = side_by_side(&[("I", &small), ("a long label", &large)], 2);
        // Columns of 2 x 20 and of the label's 12 letters of 12 pixels; the taller picture has 24 rows.
        assert_eq!(sheet.size(), Size::new(14 + 40 + 6 + 144 + 14, 14 + 14 + 7 + 24 + 14));
        let Samples::U8(pixels) = &sheet.samples else { panic!("8-bit") };
        let count = |value: u8| pixels.iter().filter(|v| **v == value).count();
        assert_eq!(count(100), 3 * 40 * 20);
        assert_eq!(count(200), 3 * 60 * 24);
        assert!(count(INK) > 3 * 4 * 11);
        // The first picture's corner, and the second one in the middle of its column.
        assert_eq!((pixels[(35, 14, 0)], pixels[(34, 14, 0)], pixels[(35, 13, 0)]), (100, 24, 24));
        assert_eq!((pixels[(35, 60 + 42, 0)], pixels[(35, 60 + 41, 0)]), (200, 24));
        assert_eq!(side_by_side(&[], 3).size(), Size::new(28, 49));
    }

    #[test]
    fn grids_have_names_on_two_sides() {
        let plain = |value: u8| Raster::new(Samples::U8(Array3::from_elem((16, 20, 3), value)));
        let rows = [("ab", vec![plain(100), plain(101)]), ("c", vec![plain(102), plain(103)])];
        let sheet = grid(&["one", "three"], &rows);
        // Columns as wide as "three", 5 letters of 12 pixels; rows stand right of "ab".
        assert_eq!(sheet.size(), Size::new(14 + 24 + 14 + 60 + 6 + 60 + 14, 14 + 14 + 7 + 16 + 6 + 16 + 14));
        let Samples::U8(pixels) = &sheet.samples else { panic!("8-bit") };
        assert!((100..104).all(|value| pixels.iter().filter(|v| **v == value).count() == 3 * 20 * 16));
        assert_eq!((pixels[(35, 72, 0)], pixels[(57, 138, 0)]), (100, 103));
    }
}
