//! A chain from a lobes file: six channels, all levels, nothing rounded to 8 bits.

use std::path::Path;

use glam::Vec3;
use ndarray::Array3;

use super::{LevelChain, right_size};
use crate::codec::{self, Decoded};
use crate::error::{Error, Result};
use crate::image::{Raster, Samples, Size};
use crate::material::source::SHORTEST_NORMAL;
use crate::material::{ChannelRef, Inputs, Material, NormalRange, NormalZ, Origin, RoughnessInput, load_with};
use crate::ndf::{Axes, Form, Gltf, Lobe, Lobes, RoughnessTensor};
use crate::roughness::Alpha;

/// The channels of a lobes file: unit normal (OpenGL, +Y up), widths, and the angle in radians from the lobe's
/// tangent (the +u axis made orthogonal to the normal) to the axis of the larger width.
pub const LOBE_CHANNELS: [&str; 6] = ["n.x", "n.y", "n.z", "alpha.x", "alpha.y", "angle"];

/// Reads the chain of a `NAME_lobes.exr` that a build wrote, or of any OpenEXR file with its channels `n.x n.y n.z
/// alpha.x alpha.y angle`. It has one width if `alpha.x` equals `alpha.y` everywhere.
///
/// # Errors
/// Another file, a channel that is missing, levels of the wrong size, and texels that are no lobe: a number that is not
/// finite, a normal without direction or one that does not point out of the surface, a width outside 0..1.
pub fn read_lobes(path: &Path) -> Result<LevelChain> {
    let pictures = codec::read_levels(path)?;
    let size = pictures[0].raster.size();
    let mut channels = [0; 6];
    for (place, name) in channels.iter_mut().zip(LOBE_CHANNELS) {
        let names = &pictures[0].raster.channels;
        *place = names.iter().position(|other| other == name).ok_or_else(|| {
            let found = format!("{} with channels {}", pictures[0].format, names.join(" "));
            Error::invalid(path, found, format!("a lobes file, with a channel {name}"))
        })?;
    }
    for (k, picture) in pictures.iter().enumerate() {
        right_size(path, picture.raster.size(), size, k)?;
        sound(path, &picture.raster, channels, k)?;
    }
    let round = |picture: &Decoded| every(&picture.raster, channels, |[.., x, y, _]| x == y);
    let form = if pictures.iter().all(round) { Form::Isotropic } else { Form::Anisotropic };
    let levels = pictures.iter().map(|picture| lobes(&picture.raster, channels, form)).collect::<Vec<_>>();
    let level_0 = material(path, &pictures[0], &levels[0])?;
    Ok(LevelChain { levels, level_0, fold: None, container: None })
}

/// The six values of a texel.
fn texel(raster: &Raster, channels: [usize; 6], x: usize, y: usize) -> [f32; 6] {
    channels.map(|channel| raster.at(x, y, channel))
}

fn every(raster: &Raster, channels: [usize; 6], f: impl Fn([f32; 6]) -> bool) -> bool {
    let Size { width, height } = raster.size();
    (0..height).all(|y| (0..width).all(|x| f(texel(raster, channels, x, y))))
}

/// Whether every texel is a lobe.
fn sound(path: &Path, raster: &Raster, channels: [usize; 6], level: usize) -> Result<()> {
    let Size { width, height } = raster.size();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let values = texel(raster, channels, x, y);
        let [nx, ny, nz, ax, ay, _] = values;
        let directed = nz > 0.0 && Vec3::new(nx, ny, nz).length() > SHORTEST_NORMAL;
        let width = 0.0..=1.0;
        if values.iter().all(|v| v.is_finite()) && directed && width.contains(&ax) && width.contains(&ay) {
            continue;
        }
        let found = format!("{values:?} at column {x}, row {y} of level {level}");
        return Err(Error::invalid(path, found, "a finite normal with z above 0 and widths from 0 to 1"));
    }
    Ok(())
}

fn lobes(raster: &Raster, channels: [usize; 6], form: Form) -> Lobes {
    Lobes::from_fn(form, raster.size(), |x, y| {
        let [nx, ny, nz, ax, ay, angle] = texel(raster, channels, x, y);
        let axes = Axes { alpha_x: Alpha(ax), alpha_y: Alpha(ay), angle: if ax == ay { 0.0 } else { angle } };
        let normal = Vec3::new(nx, ny, nz);
        // As written, where that is a unit vector already.
        let normal = if (normal.length_squared() - 1.0).abs() < 1e-6 { normal } else { normal.normalize() };
        Lobe { normal, roughness: RoughnessTensor::from_axes(axes) }
    })
}

/// Level 0 as a material: its lobes as float maps, anisotropy in glTF's form.
fn material(path: &Path, picture: &Decoded, lobes: &Lobes) -> Result<Material> {
    let Size { width, height } = lobes.size();
    let map = |texel: &dyn Fn(Lobe) -> [f32; 3]| Decoded {
        raster: Raster::new(Samples::F32(Array3::from_shape_fn((height, width, 3), |(y, x, c)| {
            texel(lobes.at(x, y))[c]
        }))),
        format: picture.format,
        notes: Vec::new(),
        sha256: picture.sha256.clone(),
        bytes_len: picture.bytes_len,
        plain_png: None,
    };
    let part = |name: &str| path.with_extension(name);
    let (normal, width, anisotropy) = (part("normal"), part("roughness"), part("anisotropy"));
    let read = |wanted: &Path| {
        Ok(if wanted == normal {
            map(&|lobe| lobe.normal.to_array())
        } else if wanted == width {
            map(&|lobe| [lobe.axes().alpha_y.perceptual().0; 3])
        } else {
            map(&|lobe| {
                let Gltf { strength, direction, .. } = Gltf::from_axes(lobe.axes());
                [0.5 + 0.5 * direction.x, 0.5 + 0.5 * direction.y, strength]
            })
        })
    };
    let inputs = Inputs {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        normal: Some(normal.clone()),
        roughness: RoughnessInput::Roughness(ChannelRef { path: width.clone(), channel: Some(0) }),
        anisotropy: (lobes.form() == Form::Anisotropic).then(|| anisotropy.clone()),
        normal_z: NormalZ::Stored,
        normal_range: NormalRange::Signed,
        ..Inputs::default()
    };
    let mut material = load_with(&inputs, &read)?;
    // The maps above are not files that anyone could look for.
    let origin = format!("level 0 of {}", path.file_name().unwrap_or_default().to_string_lossy());
    material.maps.iter_mut().for_each(|map| map.origin = Origin::Generated(origin.clone()));
    material.notes = vec![format!("normals and widths: {origin}")];
    Ok(material)
}
