//! What glints of a map's own texels need, as a file: slopes, and the ranges and moments of blocks of them.

use std::io::{Seek, Write};
use std::path::Path;

use ndarray::Array3;

use crate::codec::{Channel, Depth, read_exr_levels, write_exr_covering};
use crate::error::{Error, Result};
use crate::glint::texels::{LEVEL_CHANNELS, TexelGlints};
use crate::image::Size;

/// Slopes, ranges and moments as mip-mapped EXR, 32 bit, channels [`LEVEL_CHANNELS`].
///
/// Level 0 is the map's size. Level k has a texel for each block of `2^k` by `2^k` cells between texels, and its sizes
/// are **rounded up** (EXR's ROUND_UP), not down as those of all other files here: a texel of level k lies over the
/// texels `2 x .. 2 x + 1` and `2 y .. 2 y + 1` of the level below as far as there are such.
///
/// # Errors
/// Whatever `out` returns.
pub fn write_texels(out: impl Write + Seek, glints: &TexelGlints) -> std::io::Result<()> {
    let channels = LEVEL_CHANNELS.map(|name| Channel { name: name.into(), depth: Depth::Float });
    let (width, height) = glints.slopes().size();
    let levels = glints.levels();
    write_exr_covering(out, &channels, Size::new(width, height), &|level, channel, y, x, row| {
        row.iter_mut().enumerate().for_each(|(i, out)| *out = levels[level][[channel, y, x + i]]);
    })
}

/// The glints in such a file. They answer as those that were written do, bit by bit.
///
/// # Errors
/// No EXR file, or one without these channels, sizes and finite values, or with ranges, variances or widths that no slopes
/// have.
pub fn read_texels(path: &Path) -> Result<TexelGlints> {
    let rasters = read_exr_levels(path)?;
    let names = &rasters[0].channels;
    let place = |name: &str| {
        let found = names.iter().position(|n| n == name);
        found.ok_or_else(|| Error::invalid(path, format!("channels {}", names.join(", ")), LEVEL_CHANNELS.join(", ")))
    };
    let from = LEVEL_CHANNELS.iter().map(|name| place(name)).collect::<Result<Vec<_>>>()?;
    let levels: Vec<_> = rasters
        .iter()
        .map(|raster| {
            let Size { width, height } = raster.size();
            Array3::from_shape_fn((from.len(), height, width), |(c, y, x)| raster.at(x, y, from[c]))
        })
        .collect();
    TexelGlints::from_levels(&levels)
        .map_err(|error| Error::invalid(path, error.to_string(), "slopes and their ranges"))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use glam::{DMat2, DVec2, DVec3};
    use ndarray::{Array2, Array3};

    use super::*;
    use crate::glint::texels::AlphaSource;
    use crate::roughness::Alpha;

    /// Slopes of a size that halves badly.
    fn normals() -> Array3<f32> {
        Array3::from_shape_fn((75, 37, 3), |(y, x, c)| {
            let s = |k: usize| 0.3 * (((x * 12 + y * 31 + 7 * k) * 2654435761 % 1000) as f32 / 500.0 - 1.0);
            [-s(0), -s(1), 1.0][c]
        })
    }

    #[test]
    fn a_file_answers_as_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let each = AlphaSource::Texels(Array2::from_shape_fn((75, 37), |(y, _)| 0.02 + 0.001 * y as f32));
        for alpha in [AlphaSource::Constant(Alpha(0.05)), each] {
            let glints = TexelGlints::new(&normals(), alpha).unwrap();
            let path = folder.path().join("slopes.exr");
            write_texels(fs::File::create(&path).unwrap(), &glints).unwrap();
            let sizes = read_exr_levels(&path).unwrap().iter().map(|level| level.size()).collect::<Vec<_>>();
            let rounded_up = [(37, 75), (19, 38), (10, 19), (5, 10), (3, 5), (2, 3), (1, 2), (1, 1)];
            assert_eq!(sizes, rounded_up.map(|(width, height)| Size::new(width, height)));
            let read = read_texels(&path).unwrap();
            for k in 0..40 {
                let t = f64::from(k) * 0.618;
                let (uv, j) = (DVec2::new(t, 1.7 * t), DMat2::IDENTITY * (0.01 + 0.3 * t.fract()));
                let h = DVec3::new(0.3 * t.sin(), 0.2 * t.cos(), 1.0).normalize();
                let (a, b) = (glints.ndf(uv, j, h), read.ndf(uv, j, h));
                assert!(a > 0.0 && a.to_bits() == b.to_bits(), "{a} {b}");
            }
        }
    }

    /// Files as they are written, but for one value: the channel, what it becomes on level 1, and the complaint.
    #[test]
    fn blocks_of_no_slopes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("slopes.exr");
        let glints = TexelGlints::new(&normals(), AlphaSource::Constant(Alpha(0.05))).unwrap();
        let levels = glints.levels();
        let channels = LEVEL_CHANNELS.map(|name| Channel { name: name.into(), depth: Depth::Float });
        let write = |changed: &str, to: f32| {
            let file = fs::File::create(&path).unwrap();
            write_exr_covering(file, &channels, Size::new(37, 75), &|level, channel, y, x, row| {
                row.iter_mut().enumerate().for_each(|(i, out)| {
                    let here = level == 1 && [y, x + i] == [3, 2] && LEVEL_CHANNELS[channel] == changed;
                    *out = if here { to } else { levels[level][[channel, y, x + i]] };
                });
            })
            .unwrap();
            read_texels(&path)
        };
        assert!(write("", 0.0).is_ok());
        for (changed, to, complaint) in [
            ("min.x", 9.0, "least slope"),
            ("max.y", -9.0, "least slope"),
            ("mean.x", 4.0, "mean slope"),
            ("cov.yy", -1e-3, "variance is negative"),
            ("cov.xy", 0.5, "covariance"),
            ("alpha.min", 0.0, "widths"),
            ("alpha.max", 0.01, "widths"),
        ] {
            let error = write(changed, to).unwrap_err().to_string();
            let place = "level 1, row 3, column 2";
            assert!(["slopes.exr", place, complaint].iter().all(|part| error.contains(part)), "{changed}: {error}");
        }
    }

    #[test]
    fn other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("slopes.exr");
        let write = |names: &[&str], value: f32| {
            let channels: Vec<_> = names.iter().map(|n| Channel { name: (*n).into(), depth: Depth::Float }).collect();
            let file = fs::File::create(&path).unwrap();
            write_exr_covering(file, &channels, Size::new(5, 3), &|_, _, _, _, out| out.fill(value)).unwrap();
            read_texels(&path).unwrap_err().to_string()
        };
        let error = write(&["R", "G"], 0.0);
        assert!(error.contains("G, R") && error.contains("min.x"), "{error}");
        let error = write(&LEVEL_CHANNELS, f32::NAN);
        assert!(error.contains("not finite"), "{error}");
        // Rounded down, as other files are.
        let channels = LEVEL_CHANNELS.map(|name| Channel { name: name.into(), depth: Depth::Float });
        let file = fs::File::create(&path).unwrap();
        crate::codec::write_exr(file, &channels, Size::new(5, 3), crate::image::Wrap::Repeat, &|_, _, _, _, out| {
            out.fill(0.5)
        })
        .unwrap();
        let error = read_texels(&path).unwrap_err().to_string();
        assert!(error.contains("level 1"), "{error}");
    }
}
