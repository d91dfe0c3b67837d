//! Pictures as data URIs.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ndarray::{Array2, Array3};

use crate::codec::write_png;
use crate::error::{Error, Result};
use crate::image::{Raster, Samples};

/// A PNG that a page can hold in itself.
pub(super) fn png(raster: &Raster) -> Result<String> {
    let mut bytes = Vec::new();
    write_png(&mut bytes, raster).map_err(|source| Error::io("picture of the report".as_ref(), source))?;
    Ok(data("image/png", &bytes))
}

pub(super) fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// Colours of heat from 0 to 1, sRGB: lighter without a break, so that they also read in gray.
const HEAT: [[f32; 3]; 6] = [
    [10.0, 9.0, 14.0],
    [58.0, 24.0, 92.0],
    [142.0, 36.0, 96.0],
    [217.0, 78.0, 52.0],
    [246.0, 163.0, 44.0],
    [253.0, 246.0, 190.0],
];

fn heat_colour(v: f32) -> [u8; 3] {
    let place = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) } * (HEAT.len() - 1) as f32;
    let i = (place as usize).min(HEAT.len() - 2);
    std::array::from_fn(|c| (HEAT[i][c] + (HEAT[i + 1][c] - HEAT[i][c]) * (place - i as f32)).round() as u8)
}

/// Values 0 to 1 as heat.
pub(super) fn heat(values: &Array2<f32>) -> Raster {
    let (rows, columns) = values.dim();
    let mut out = Array3::zeros((rows, columns, 3));
    for ((y, x), v) in values.indexed_iter() {
        for (c, byte) in heat_colour(*v).into_iter().enumerate() {
            out[(y, x, c)] = byte;
        }
    }
    Raster::new(Samples::U8(out))
}

/// The scale of [`heat`], lying.
pub(super) fn heat_scale() -> Result<String> {
    png(&heat(&Array2::from_shape_fn((1, 128), |(_, x)| x as f32 / 127.0)))
}

/// Mean over the colours of the distance between two 8-bit pictures of one size, 0 to 1.
pub(super) fn distance(a: &Raster, b: &Raster) -> Array2<f32> {
    let (Samples::U8(a), Samples::U8(b)) = (&a.samples, &b.samples) else { unreachable!("8-bit pictures") };
    let (rows, columns, channels) = a.dim();
    Array2::from_shape_fn((rows, columns), |(y, x)| {
        let sum: u32 = (0..channels).map(|c| u32::from(a[(y, x, c)].abs_diff(b[(y, x, c)]))).sum();
        sum as f32 / (255 * channels) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_gets_lighter_without_a_break() {
        let luma = |v: f32| {
            let [r, g, b] = heat_colour(v).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((1..=200).all(|i| luma(i as f32 / 200.0) > luma((i - 1) as f32 / 200.0) - 0.5));
        assert!(luma(1.0) - luma(0.0) > 200.0);
        assert_eq!(heat_colour(f32::NAN), heat_colour(0.0));
        assert_eq!(heat_colour(9.0), [253, 246, 190]);
    }

    #[test]
    fn distance_worked_by_hand() {
        let picture = |r, g, b| Raster::new(Samples::U8(Array3::from_shape_vec((1, 1, 3), vec![r, g, b]).unwrap()));
        let found = distance(&picture(255, 10, 0), &picture(0, 10, 51))[(0, 0)];
        assert!((found - 0.4).abs() < 1e-6, "{found}");
    }
}
