//! From file names to a material.

use std::path::{Path, PathBuf};

use glam::Vec2;
use rayon::prelude::*;

use super::generate::distinct_stems;
use super::guess::{is_gray, mean_direction, off_unit};
use super::inputs::colour;
use super::source::{MapFile, Material, NormalSource, Origin};
use super::{ChannelRef, DEFAULT_HEIGHT_SCALE, DEFAULT_ROUGHNESS, Inputs, RoughnessInput};
use super::{NormalRange, NormalY, NormalZ, Role};
use super::{height, names, resample, same_path};
use crate::codec::{self, Decoded};
use crate::error::{Error, Result};
use crate::image::Size;

/// Reads all maps of a material and brings them to one size.
///
/// # Errors
/// Files that cannot be read; channels that a file lacks; a set without any map to fold.
pub fn load(inputs: &Inputs) -> Result<Material> {
    load_with(inputs, &codec::read)
}

/// How [`load_with`] comes by the picture of a path.
pub type ReadPicture<'a> = &'a (dyn Fn(&Path) -> Result<Decoded> + Sync);

/// As [`load`], with pictures from wherever `read` takes them: an archive, memory, an engine's own assets. See
/// [`codec::decode`].
///
/// # Errors
/// As [`load`], and those of `read`.
pub fn load_with(inputs: &Inputs, read: ReadPicture) -> Result<Material> {
    let Builder { material, paths, .. } = assemble(inputs, read, true)?;
    let normal = material.normal.as_ref().and_then(|source| paths.get(source.map)).cloned().unwrap_or_default();
    material.checked(&normal)
}

/// A coarser level of maps whose level 0 was loaded: a few texels do not tell what a map is, so nothing is guessed or
/// refused by their values, and nothing warned about.
///
/// # Errors
/// As [`load_with`], but for those that values cause.
pub(super) fn load_level(inputs: &Inputs, read: ReadPicture) -> Result<Material> {
    Ok(assemble(inputs, read, false)?.material)
}

fn assemble<'a>(inputs: &Inputs, read: ReadPicture<'a>, by_value: bool) -> Result<Builder<'a>> {
    let mut builder = Builder { material: empty(inputs), paths: Vec::new(), read, by_value };
    let (normal, height) = (inputs.normal.as_deref(), inputs.height.as_deref());
    let width = inputs.roughness.file();
    if normal.is_none() && height.is_none() && width.is_none() && inputs.flat.is_none() {
        return Err(Error::invalid_option(&inputs.name, "no maps", "a normal map, a height map or a roughness map"));
    }
    if !(1e-3..=1e3).contains(&builder.material.normal_scale) {
        let found = builder.material.normal_scale.to_string();
        return Err(Error::invalid_option("normal scale", found, "a number from 0.001 to 1000"));
    }
    let plain = [&inputs.occlusion, &inputs.metal].map(|input| input.as_ref().map(|channel| channel.path.as_path()));
    builder.read_all([normal, width, inputs.anisotropy.as_deref()].into_iter().chain(plain).flatten())?;
    match (normal, height) {
        (Some(path), height) => {
            builder.add_normal(path, inputs.normal_z, inputs.normal_range)?;
            if height.is_some() {
                builder.note("the height map is not needed: there is a normal map");
            }
        }
        (None, Some(path)) => builder.add_height(path, inputs)?,
        (None, None) => builder.note("no normal map: the surface is taken as flat"),
    }
    match &inputs.roughness {
        RoughnessInput::Roughness(channel) => {
            builder.add_width(channel, Role::Roughness)?;
            builder.scale_width(inputs.roughness_factor.unwrap_or(1.0));
        }
        RoughnessInput::Smoothness(channel) => builder.add_width(channel, Role::Smoothness)?,
        RoughnessInput::Constant(r) => builder.material.constant = *r,
        RoughnessInput::Missing => builder.note(format!(
            "no roughness given: perceptual roughness {} everywhere (--roughness sets it)",
            DEFAULT_ROUGHNESS.0
        )),
    }
    if let Some(path) = &inputs.anisotropy {
        builder.add_anisotropy(path)?;
    }
    builder.material.occlusion = builder.plain(inputs.occlusion.as_ref(), "occlusion")?;
    builder.material.metal = builder.plain(inputs.metal.as_ref(), "metalness")?;
    builder.finish(inputs);
    Ok(builder)
}

fn empty(inputs: &Inputs) -> Material {
    Material {
        name: inputs.name.clone(),
        size: Size::new(1, 1),
        maps: Vec::new(),
        normal_y: inputs.normal_y,
        normal_scale: inputs.normal_scale.unwrap_or(1.0),
        wrap: inputs.wrap,
        notes: inputs.notes.clone(),
        warnings: inputs.warnings.clone(),
        mesh: None,
        flakes: None,
        normal: None,
        width: None,
        constant: DEFAULT_ROUGHNESS,
        anisotropy: None,
        anisotropy_lean: Vec2::ZERO,
        occlusion: None,
        metal: None,
        others: Vec::new(),
    }
}

struct Builder<'a> {
    material: Material,
    read: ReadPicture<'a>,
    /// The path that each map was read from.
    paths: Vec<PathBuf>,
    /// Whether values may tell what a map is.
    by_value: bool,
}

impl Builder<'_> {
    fn note(&mut self, note: impl Into<String>) {
        self.material.notes.push(note.into());
    }

    /// Reads each distinct file once, side by side.
    fn read_all<'a>(&mut self, paths: impl Iterator<Item = &'a Path>) -> Result<()> {
        let mut distinct: Vec<&Path> = Vec::new();
        paths.for_each(|path| {
            if !distinct.iter().any(|other| same_path(other, path)) {
                distinct.push(path);
            }
        });
        let decoded: Vec<_> = distinct.par_iter().map(|path| (self.read)(path)).collect();
        for (path, decoded) in distinct.into_iter().zip(decoded) {
            self.push_file(path, decoded?);
        }
        Ok(())
    }

    fn push_file(&mut self, path: &Path, decoded: Decoded) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        decoded.notes.iter().for_each(|note| self.note(format!("{name}: {note}")));
        let raster = decoded.raster;
        self.material.maps.push(MapFile {
            stem: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            bits: raster.bits(),
            roles: vec![Role::Other(0); raster.channels.len()],
            signed: false,
            origin: Origin::File {
                path: path.to_owned(),
                sha256: decoded.sha256,
                size: raster.size(),
                format: decoded.format,
                plain_png: decoded.plain_png,
                derived: false,
                scaled: false,
            },
            raster,
        });
        self.paths.push(path.to_owned());
    }

    fn map_of(&self, path: &Path) -> usize {
        self.paths.iter().position(|p| same_path(p, path)).expect("read before")
    }

    fn assign(&mut self, map: usize, channel: usize, role: Role) -> Result<()> {
        let slot = &mut self.material.maps[map].roles[channel];
        if !matches!(slot, Role::Other(_)) {
            let found = format!("the {} channel used twice, as {slot:?} and as {role:?}", colour(channel));
            return Err(Error::invalid(&self.paths[map], found, "one use of each channel"));
        }
        *slot = role;
        Ok(())
    }

    fn add_normal(&mut self, path: &Path, z: NormalZ, range: NormalRange) -> Result<()> {
        let map = self.map_of(path);
        let raster = &self.material.maps[map].raster;
        let count = raster.channels.len();
        if count < 2 {
            return Err(Error::invalid(
                path,
                "a gray picture as normal map",
                "two (XY) or three (XYZ) channels; a height map is given with --height",
            ));
        }
        let stored = match z {
            NormalZ::Auto => count >= 3,
            NormalZ::Stored if count < 3 => {
                return Err(Error::invalid(path, "two channels", "three channels for --normal-z stored"));
            }
            NormalZ::Stored => true,
            NormalZ::Rebuild => false,
        };
        if self.by_value && count >= 3 && is_gray(raster) {
            let expected = "a tangent-space normal map, whose channels differ; a height map is given with --height";
            return Err(Error::invalid(path, "a gray picture stored as colour, as normal map", expected));
        }
        let floats = raster.bits() == 32;
        let signed = floats
            && match range {
                NormalRange::Signed => true,
                NormalRange::Unsigned => false,
                NormalRange::Auto => off_unit(raster, stored, true) < off_unit(raster, stored, false),
            };
        self.material.maps[map].signed = signed;
        if floats && range == NormalRange::Auto {
            let (read, other) = if signed { ("-1..1", "unsigned") } else { ("0..1", "signed") };
            self.note(format!(
                "float normals read as {read}, which is more nearly unit; --normal-range {other} differs"
            ));
        }
        let channels = [Some(0), Some(1), stored.then_some(2)];
        for (channel, role) in channels.into_iter().zip([Role::NormalX, Role::NormalY, Role::NormalZ]) {
            if let Some(channel) = channel {
                self.assign(map, channel, role)?;
            }
        }
        let y = self.material.normal_y;
        if let Some(named) = names::convention(path)
            && named != y
        {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            let warning =
                format!("{file} is read as {}, but its name says {}; see --normal-y", y.describe(), named.describe());
            self.material.warnings.push(warning);
        }
        self.note(format!("normal map read as {}; --normal-y changes it", y.describe()));
        self.material.normal = Some(NormalSource { map, channels });
        Ok(())
    }

    fn add_height(&mut self, path: &Path, inputs: &Inputs) -> Result<()> {
        let decoded = (self.read)(path)?;
        let scale = inputs.height_scale.unwrap_or(DEFAULT_HEIGHT_SCALE);
        let raster = height::normals(&decoded.raster, 0, scale, inputs.wrap);
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.note(format!(
            "normals derived from {name} with a height range of {scale} texture widths (--height-scale)"
        ));
        let map = self.material.maps.len();
        self.push_file(path, decoded);
        let file = &mut self.material.maps[map];
        file.stem += "_normal";
        (file.raster, file.bits) = (raster, 16);
        file.roles = vec![Role::NormalX, Role::NormalY, Role::NormalZ];
        if let Origin::File { plain_png, derived, .. } = &mut file.origin {
            (*plain_png, *derived) = (None, true);
        }
        self.material.normal_y = NormalY::OpenGl;
        self.material.normal = Some(NormalSource { map, channels: [Some(0), Some(1), Some(2)] });
        Ok(())
    }

    /// The channel of a map that an input names.
    fn channel_of(&self, map: usize, input: &ChannelRef, what: &str) -> Result<usize> {
        let names = &self.material.maps[map].raster.channels;
        let count = names.len();
        let channel = input.index(count);
        if channel < count {
            return Ok(channel);
        }
        let found = if count == 1 { "one channel (gray)".into() } else { format!("channels {}", names.join(" ")) };
        Err(Error::invalid(&input.path, found, format!("a channel {} for the {what}", colour(channel))))
    }

    /// Where a channel is that nothing is folded into.
    fn plain(&self, input: Option<&ChannelRef>, what: &str) -> Result<Option<(usize, usize)>> {
        let Some(input) = input else { return Ok(None) };
        let map = self.map_of(&input.path);
        let channel = self.channel_of(map, input, what)?;
        if !matches!(self.material.maps[map].roles[channel], Role::Other(_)) {
            let found = format!("the {} channel used twice, once as {what}", colour(channel));
            return Err(Error::invalid(&input.path, found, "one use of each channel"));
        }
        Ok(Some((map, channel)))
    }

    fn add_width(&mut self, input: &ChannelRef, role: Role) -> Result<()> {
        let map = self.map_of(&input.path);
        let word = if role == Role::Roughness { "roughness" } else { "smoothness" };
        let channel = self.channel_of(map, input, word)?;
        let count = self.material.maps[map].raster.channels.len();
        let file = input.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let gray = count < 2 || (count >= 3 && is_gray(&self.material.maps[map].raster));
        if gray && count >= 3 && input.channel.is_none() {
            // Gray stored as colour: all three channels are the roughness, and come back as such.
            for other in [0, 2] {
                self.assign(map, other, role)?;
            }
        }
        if !gray && input.channel.is_none() {
            let channel = if count == 2 { "gray" } else { colour(channel) };
            self.note(format!("{word}: {file}, {channel} channel; FILE:r|g|b|a names another"));
        }
        self.assign(map, channel, role)?;
        self.material.width = Some((map, channel));
        Ok(())
    }

    /// Multiplies the factor of a renderer into the roughness.
    fn scale_width(&mut self, factor: f32) {
        let Some((map, channel)) = self.material.width.filter(|_| factor != 1.0) else { return };
        let file = &mut self.material.maps[map];
        file.raster.samples.scale(channel, factor);
        if let Origin::File { plain_png, scaled, .. } = &mut file.origin {
            (*plain_png, *scaled) = (None, true);
        }
        let stem = file.stem.clone();
        self.note(format!("{stem}: the roughness factor {factor} is multiplied in; set it to 1 beside these maps"));
    }

    fn add_anisotropy(&mut self, path: &Path) -> Result<()> {
        let map = self.map_of(path);
        let names = &self.material.maps[map].raster.channels;
        if names.len() < 3 {
            let found = format!("{} channels", names.len());
            return Err(Error::invalid(path, found, "three: direction in red and green, strength in blue (glTF)"));
        }
        for (channel, role) in [Role::AnisotropyX, Role::AnisotropyY, Role::AnisotropyStrength].into_iter().enumerate()
        {
            self.assign(map, channel, role)?;
        }
        self.material.anisotropy = Some((map, [0, 1, 2]));
        self.material.anisotropy_lean = mean_direction(&self.material.maps[map].raster);
        Ok(())
    }

    /// Brings all maps to the largest size, numbers the plain channels, and adds the maps that are missing.
    fn finish(&mut self, inputs: &Inputs) {
        // A third channel that is nothing else holds z, also where it was not trusted: it is written again.
        if let Some(source) = &self.material.normal
            && let Some(role @ Role::Other(_)) = self.material.maps[source.map].roles.get_mut(2)
        {
            *role = Role::NormalZ;
        }
        let sizes: Vec<_> = self.material.maps.iter().map(|map| map.raster.size()).collect();
        let width = sizes.iter().map(|s| s.width).max();
        let height = sizes.iter().map(|s| s.height).max();
        let largest = width.zip(height).map(|(width, height)| Size::new(width, height));
        let size = inputs.sides.fit(largest.or(inputs.flat).unwrap_or(Size::new(1, 1)));
        self.material.size = size;
        for (i, from) in sizes.into_iter().enumerate() {
            if from != size {
                let map = &mut self.material.maps[i];
                map.raster = resample::enlarge(&map.raster, size, self.material.wrap);
                let note = format!("{} enlarged from {from} to {size} (bilinear)", map.stem);
                self.note(note);
            }
        }
        if self.material.width.is_none() {
            self.material.add_constant_roughness();
        }
        let material = &mut self.material;
        for (m, map) in material.maps.iter_mut().enumerate() {
            for (c, role) in map.roles.iter_mut().enumerate() {
                if matches!(role, Role::Other(_)) {
                    *role = Role::Other(material.others.len());
                    material.others.push((m, c));
                }
            }
        }
        distinct_stems(&mut material.maps);
    }
}
