//! Flakes on a material: how many, what they are like, and maps of where they are.
//!
//! Both maps of a chain are plain means over footprints, so that hardware may filter them on. *Density* counts flakes
//! over the whole surface, so it is that of the flakes' own places times the mask: of a footprint that flakes half cover, the
//! two means apart would not tell how many there are. *Mask* is the share of the surface that is flakes.

use ndarray::{Array2, Array3, Axis};
use serde::{Deserialize, Serialize};

use super::inputs::LETTERS;
use super::{ChannelRef, ReadPicture, resample};
use crate::error::{Error, Result};
use crate::glint::{FlakeDensity, Flakes, SolidAngle, Streak, Tail};
use crate::image::{Raster, Samples, Size, Wrap, spans};
use crate::roughness::PerceptualRoughness;

/// Flakes as manifests describe them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlakesAbout {
    /// Flakes on one repeat of the texture, where the density map is white: flakes per unit of area of uv.
    pub density: f64,
    /// Perceptual roughness of a flake's own lobe.
    pub roughness: f32,
    /// Standard deviation of the flakes' areas over their mean.
    pub size_variation: f64,
    /// Share of the surface that flakes cover in close-ups.
    pub coverage: f64,
    /// Another seed, another surface.
    pub seed: u32,
    /// Length over width, for scratches.
    pub streak: Option<f64>,
    /// Direction of scratches, degrees from u towards v.
    pub streak_angle: f64,
    /// Files of density and mask, as given, with their digests.
    pub files: Vec<FlakesFile>,
}

/// A map of flakes that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlakesFile {
    /// As given; what is not Unicode in it is replaced.
    pub path: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// "density" or "mask".
    pub role: String,
    /// The channel that was read: "r", "g", "b" or "a".
    pub channel: String,
}

impl FlakesAbout {
    /// What glints are asked with.
    pub fn flakes(&self) -> Flakes {
        let alpha = PerceptualRoughness(self.roughness).alpha();
        let lobe = SolidAngle::of_flake(alpha, Tail::Ggx);
        let streak = self.streak.map(|ratio| Streak { ratio, angle: self.streak_angle.to_radians() });
        let size_variation = self.size_variation;
        Flakes {
            size_variation,
            coverage: self.coverage,
            streak,
            ..Flakes::new(FlakeDensity(self.density), lobe, self.seed)
        }
    }
}

/// Flakes of a material.
#[derive(Clone, Debug)]
pub struct MaterialFlakes {
    /// What they are like.
    pub about: FlakesAbout,
    /// Density over that of `about`, and mask; axes (row, column, which), level 0 first. None where flakes are everywhere.
    pub levels: Vec<Array3<f32>>,
}

/// Where flakes are, in files: linear, 0 to 1, white everywhere without.
#[derive(Clone, Debug, Default)]
pub struct FlakePlaces {
    /// Flakes over the most there are.
    pub density: Option<ChannelRef>,
    /// Share of the surface.
    pub mask: Option<ChannelRef>,
}

impl FlakePlaces {
    /// Reads the maps, brings them to a material's size and filters them.
    ///
    /// # Errors
    /// Files that cannot be read; channels that a file lacks.
    pub fn load(&self, mut about: FlakesAbout, size: Size, wrap: Wrap, read: ReadPicture) -> Result<MaterialFlakes> {
        if self.density.is_none() && self.mask.is_none() {
            return Ok(MaterialFlakes { about, levels: Vec::new() });
        }
        let mut plane = |channel: &Option<ChannelRef>, role: &str| -> Result<Option<Array2<f32>>> {
            let Some(channel) = channel else { return Ok(None) };
            let (plane, file) = read_plane(channel, role, read)?;
            about.files.push(file);
            Ok(Some(plane))
        };
        let (density, mask) = (plane(&self.density, "density")?, plane(&self.mask, "mask")?);
        // Multiplied before anything is averaged, so at a size that holds both.
        let sizes = [&density, &mask].into_iter().flatten().map(|plane| plane.dim());
        let (height, width) = sizes.fold((size.height, size.width), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let whole = |plane: Option<Array2<f32>>| match plane {
            Some(plane) => enlarged(plane, Size::new(width, height), wrap),
            None => Array2::ones((height, width)),
        };
        let mask = whole(mask);
        let density = whole(density) * &mask;
        let levels = (0..size.level_count()).map(|k| {
            let size = size.level(k);
            let mut level = Array3::zeros((size.height, size.width, 2));
            level.index_axis_mut(Axis(2), 0).assign(&shrunk(&density, size));
            level.index_axis_mut(Axis(2), 1).assign(&shrunk(&mask, size));
            level
        });
        let levels = levels.collect();
        Ok(MaterialFlakes { about, levels })
    }
}

/// A channel of a file, 0 to 1.
fn read_plane(channel: &ChannelRef, role: &str, read: ReadPicture) -> Result<(Array2<f32>, FlakesFile)> {
    let decoded = read(&channel.path)?;
    let raster = &decoded.raster;
    let count = raster.samples.channels();
    let index = channel.index(count);
    let letter = LETTERS.get(index).copied().unwrap_or("r");
    if index >= count {
        let found = format!("{count} channel{}", if count == 1 { "" } else { "s" });
        return Err(Error::invalid(&channel.path, found, format!("a channel {letter} with the flakes' {role}")));
    }
    let size = raster.size();
    let plane = Array2::from_shape_fn((size.height, size.width), |(y, x)| {
        let value = raster.at(x, y, index);
        if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
    });
    let path = channel.path.to_string_lossy().into_owned();
    Ok((plane, FlakesFile { path, sha256: decoded.sha256, role: role.into(), channel: letter.into() }))
}

/// At a size that is no smaller, as a renderer would sample it.
fn enlarged(plane: Array2<f32>, size: Size, wrap: Wrap) -> Array2<f32> {
    let (height, width) = plane.dim();
    if (width, height) == (size.width, size.height) {
        return plane;
    }
    let raster = Raster::new(Samples::F32(plane.insert_axis(Axis(2))));
    let large = resample::enlarge(&raster, size, wrap);
    Array2::from_shape_fn((size.height, size.width), |(y, x)| large.at(x, y, 0))
}

/// Means over the footprints of a smaller size.
fn shrunk(plane: &Array2<f32>, size: Size) -> Array2<f32> {
    let (height, width) = plane.dim();
    let (across, down) = (spans(width, size.width), spans(height, size.height));
    let share = 1.0 / (width as f32 / size.width as f32);
    let rows = Array2::from_shape_fn((height, size.width), |(y, x)| {
        let span = &across[x];
        span.weights.iter().zip(span.first..).map(|(w, x)| w * plane[(y, x)]).sum::<f32>() * share
    });
    let share = 1.0 / (height as f32 / size.height as f32);
    Array2::from_shape_fn((size.height, size.width), |(y, x)| {
        let span = &down[y];
        span.weights.iter().zip(span.first..).map(|(w, y)| w * rows[(y, x)]).sum::<f32>() * share
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::codec::{decode, write_png};

    fn about() -> FlakesAbout {
        FlakesAbout {
            density: 1e6,
            roughness: 0.2,
            size_variation: 0.5,
            coverage: 0.7,
            seed: 3,
            streak: Some(20.0),
            streak_angle: 90.0,
            files: Vec::new(),
        }
    }

    fn picture(size: Size, value: fn(usize, usize) -> u8) -> Vec<u8> {
        let samples = Array3::from_shape_fn((size.height, size.width, 1), |(y, x, _)| value(x, y));
        let mut bytes = Vec::new();
        write_png(&mut bytes, &Raster::new(Samples::U8(samples))).unwrap();
        bytes
    }

    fn places(density: Option<&str>, mask: Option<&str>) -> FlakePlaces {
        FlakePlaces { density: density.map(ChannelRef::parse), mask: mask.map(ChannelRef::parse) }
    }

    /// Flakes on half of the columns, dense on the lower half of the rows: a quarter of the most, on half of the surface.
    #[test]
    fn means_of_maps_count_flakes() {
        let read = |path: &Path| {
            let bytes = match path.to_str().unwrap() {
                "d.png" => picture(Size::new(6, 4), |_, y| if y < 2 { 0 } else { 255 }),
                _ => picture(Size::new(6, 4), |x, _| if x % 2 == 0 { 255 } else { 0 }),
            };
            decode(path, bytes)
        };
        let size = Size::new(6, 4);
        let both = places(Some("d.png"), Some("m.png")).load(about(), size, Wrap::Repeat, &read).unwrap();
        assert_eq!(both.levels.len(), 3);
        assert_eq!(both.levels[0].dim(), (4, 6, 2));
        assert_eq!((both.levels[0][(3, 0, 0)], both.levels[0][(3, 1, 0)], both.levels[0][(0, 0, 0)]), (1.0, 0.0, 0.0));
        for level in &both.levels {
            let mean = |which: usize| level.index_axis(Axis(2), which).mean().unwrap();
            assert!((mean(0) - 0.25).abs() < 1e-6 && (mean(1) - 0.5).abs() < 1e-6, "{} {}", mean(0), mean(1));
        }
        let of = |file: &FlakesFile| [file.path.clone(), file.role.clone(), file.channel.clone()];
        let files: Vec<_> = both.about.files.iter().map(of).collect();
        assert_eq!(files, [["d.png", "density", "r"], ["m.png", "mask", "r"]]);
        // Without a mask the surface is all flakes, and so are its levels.
        let one = places(Some("d.png"), None).load(about(), size, Wrap::Repeat, &read).unwrap();
        assert!(one.levels.iter().all(|level| level.index_axis(Axis(2), 1).iter().all(|m| (m - 1.0).abs() < 1e-6)));
        let none = places(None, None).load(about(), size, Wrap::Repeat, &read).unwrap();
        assert!(none.levels.is_empty() && none.about.files.is_empty());
    }

    /// Density and mask are multiplied where they are fine, not where the material is coarse: flakes on every other column,
    /// and dense on the same columns or on the others.
    #[test]
    fn products_are_taken_before_means() {
        let read = |path: &Path| {
            let odd = usize::from(path.ends_with("odd.png"));
            let bytes = match odd {
                0 => picture(Size::new(16, 1), |x, _| if x % 2 == 0 { 255 } else { 0 }),
                _ => picture(Size::new(16, 1), |x, _| if x % 2 == 1 { 255 } else { 0 }),
            };
            decode(path, bytes)
        };
        for (density, expected) in [("even.png", 0.5), ("odd.png", 0.0)] {
            let flakes =
                places(Some(density), Some("even.png")).load(about(), Size::new(2, 1), Wrap::Repeat, &read).unwrap();
            assert!((flakes.levels[0][(0, 0, 0)] - expected).abs() < 1e-6, "{density}");
            assert!((flakes.levels[0][(0, 0, 1)] - 0.5).abs() < 1e-6, "{density}");
        }
    }

    /// A mask of another size keeps its mean; a channel that is not there is named.
    #[test]
    fn maps_come_in_any_size() {
        let read = |path: &Path| decode(path, picture(Size::new(8, 2), |x, _| if x < 2 { 255 } else { 0 }));
        for size in [Size::new(4, 4), Size::new(16, 1), Size::new(8, 8)] {
            let flakes = places(None, Some("m.png")).load(about(), size, Wrap::Repeat, &read).unwrap();
            let top = flakes.levels.last().unwrap();
            assert!((top[(0, 0, 1)] - 0.25).abs() < 1e-5 && top.dim() == (1, 1, 2), "{size}: {top}");
        }
        let error = places(None, Some("m.png:b")).load(about(), Size::new(4, 4), Wrap::Repeat, &read).unwrap_err();
        assert!(error.to_string().contains("m.png") && error.to_string().contains("a channel b"), "{error}");
    }

    #[test]
    fn the_parameters_are_those_of_queries() {
        let flakes = about().flakes();
        assert_eq!((flakes.density.0, flakes.seed, flakes.size_variation, flakes.coverage), (1e6, 3, 0.5, 0.7));
        let streak = flakes.streak.unwrap();
        assert!((streak.angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12 && streak.ratio == 20.0);
        assert!((flakes.lobe.0 - 3.0 * std::f64::consts::PI * 0.0016).abs() < 1e-7);
    }
}
