//! Pictures as data URIs.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ndarray::Array2;

use crate::codec::write_png;
use crate::error::{Error, Result};
use crate::image::{Raster, Samples};
use crate::render::heat;

/// A PNG that a page can hold in itself.
pub(super) fn png(raster: &Raster) -> Result<String> {
    let mut bytes = Vec::new();
    write_png(&mut bytes, raster).map_err(|source| Error::io("picture of the report".as_ref(), source))?;
    Ok(data("image/png", &bytes))
}

pub(super) fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// The scale of [`heat`], lying.
pub(super) fn heat_scale() -> Result<String> {
    png(&heat(&Array2::from_shape_fn((1, 128), |(_, x)| x as f32 / 127.0), 1.0))
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
    use ndarray::Array3;

    #[test]
    fn distance_worked_by_hand() {
        let picture = |r, g, b| Raster::new(Samples::U8(Array3::from_shape_vec((1, 1, 3), vec![r, g, b]).unwrap()));
        let found = distance(&picture(255, 10, 0), &picture(0, 10, 51))[(0, 0)];
        assert!((found - 0.4).abs() < 1e-6, "{found}");
    }
}
