//! A chain from a lobes file: six channels a lobe, all levels, nothing rounded to 8 bits.

use std::path::Path;

use glam::Vec3;
use ndarray::Array3;

use super::{LevelChain, right_size};
use crate::codec::{self, Decoded};
use crate::error::{Error, Result};
use crate::image::{Raster, Samples, Size};
use crate::material::source::SHORTEST_NORMAL;
use crate::material::{ChannelRef, Inputs, Material, NormalRange, NormalZ, Origin, RoughnessInput, load_with};
use crate::ndf::{Axes, Form, Gltf, Lobe, Lobes, MOST_LOBES, RoughnessTensor, are_shares};
use crate::roughness::Alpha;

/// The channels of a lobes file: unit normal (OpenGL, +Y up), widths, and the angle in radians from the lobe's
/// tangent (the +u axis made orthogonal to the normal) to the axis of the larger width.
pub const LOBE_CHANNELS: [&str; 6] = ["n.x", "n.y", "n.z", "alpha.x", "alpha.y", "angle"];

/// The channels of a file of so many lobes a texel: [`LOBE_CHANNELS`] alone of one; of several a `weight` after them, and
/// then the same again for each further lobe with its number, counted from 2: `n2.x n2.y n2.z alpha2.x alpha2.y angle2
/// weight2`.
pub fn lobe_channels(count: usize) -> Vec<String> {
    let names = LOBE_CHANNELS.into_iter().chain((count > 1).then_some("weight"));
    let numbered = |j: usize, name: &str| match (j, name.split_once('.')) {
        (0, _) => name.to_owned(),
        (_, Some((head, tail))) => format!("{head}{}.{tail}", j + 1),
        (_, None) => format!("{name}{}", j + 1),
    };
    (0..count).flat_map(|j| names.clone().map(move |name| numbered(j, name))).collect()
}

/// Places of a lobe's six channels, and of its weight.
#[derive(Clone, Copy)]
struct Places {
    lobe: [usize; 6],
    weight: Option<usize>,
}

/// Where the channels of all lobes are. There are as many lobes as there are normals.
fn places(path: &Path, picture: &Decoded) -> Result<Vec<Places>> {
    let names = &picture.raster.channels;
    let has = |name: &String| names.contains(name);
    let count =
        (2..=MOST_LOBES).rev().find(|count| lobe_channels(*count)[7 * (count - 1)..].iter().any(has)).unwrap_or(1);
    let place = |name: String| {
        names.iter().position(|other| *other == name).ok_or_else(|| {
            let found = format!("{} with channels {}", picture.format, names.join(" "));
            Error::invalid(path, found, format!("a lobes file, with a channel {name}"))
        })
    };
    let channels = lobe_channels(count).into_iter().map(place).collect::<Result<Vec<_>>>()?;
    let lobes = channels.chunks(channels.len() / count);
    Ok(lobes.map(|c| Places { lobe: std::array::from_fn(|i| c[i]), weight: c.get(6).copied() }).collect())
}

/// Reads the chain of a `NAME_lobes.exr` that a build wrote, or of any OpenEXR file with the channels of
/// [`lobe_channels`]. It has one width if `alpha.x` equals `alpha.y` everywhere. Level 0 has one lobe, the first.
///
/// # Errors
/// Another file, a channel that is missing, levels of the wrong size, and texels that are no lobes: a number that is not
/// finite, a normal without direction or one that does not point out of the surface, a width outside 0..1; weights that do
/// not sum to 1; several lobes at level 0.
pub fn read_lobes(path: &Path) -> Result<LevelChain> {
    let pictures = codec::read_levels(path)?;
    let size = pictures[0].raster.size();
    let places = places(path, &pictures[0])?;
    for (k, picture) in pictures.iter().enumerate() {
        right_size(path, picture.raster.size(), size, k)?;
        sound(path, &picture.raster, &places, k)?;
    }
    let round = |picture: &Decoded| places.iter().all(|p| every(&picture.raster, p.lobe, |[.., x, y, _]| x == y));
    let form = if pictures.iter().all(round) { Form::Isotropic } else { Form::Anisotropic };
    let level =
        |(k, picture): (usize, &Decoded)| lobes(&picture.raster, if k == 0 { &places[..1] } else { &places }, form);
    let levels = pictures.iter().enumerate().map(level).collect::<Vec<_>>();
    let level_0 = material(path, &pictures[0], &levels[0])?;
    Ok(LevelChain { levels, level_0, fold: None, container: None })
}

/// The six values of a lobe.
fn texel(raster: &Raster, channels: [usize; 6], x: usize, y: usize) -> [f32; 6] {
    channels.map(|channel| raster.at(x, y, channel))
}

fn every(raster: &Raster, channels: [usize; 6], f: impl Fn([f32; 6]) -> bool) -> bool {
    let Size { width, height } = raster.size();
    (0..height).all(|y| (0..width).all(|x| f(texel(raster, channels, x, y))))
}

/// Whether every texel is a lobe, or several whose weights are shares.
fn sound(path: &Path, raster: &Raster, places: &[Places], level: usize) -> Result<()> {
    let Size { width, height } = raster.size();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let wrong = |found: String, expected: &str| {
            Err(Error::invalid(path, format!("{found} at column {x}, row {y} of level {level}"), expected))
        };
        for place in places {
            let values = texel(raster, place.lobe, x, y);
            let [nx, ny, nz, ax, ay, _] = values;
            let directed = nz > 0.0 && Vec3::new(nx, ny, nz).length() > SHORTEST_NORMAL;
            let width = 0.0..=1.0;
            if !(values.iter().all(|v| v.is_finite()) && directed && width.contains(&ax) && width.contains(&ay)) {
                return wrong(format!("{values:?}"), "a finite normal with z above 0 and widths from 0 to 1");
            }
        }
        let weights = || places.iter().map(|place| place.weight.map_or(1.0, |channel| raster.at(x, y, channel)));
        if !are_shares(weights()) {
            let found = format!("weights {:?}", weights().collect::<Vec<_>>());
            return wrong(found, "weights from 0 up that sum to 1");
        }
        if level == 0 && weights().skip(1).any(|weight| weight > 0.0) {
            return wrong("several lobes".into(), super::ONE_LOBE_AT_LEVEL_0);
        }
    }
    Ok(())
}

fn lobes(raster: &Raster, places: &[Places], form: Form) -> Lobes {
    Lobes::mixed_from_fn(form, places.len(), raster.size(), |j, x, y| {
        let [nx, ny, nz, ax, ay, angle] = texel(raster, places[j].lobe, x, y);
        let axes = Axes { alpha_x: Alpha(ax), alpha_y: Alpha(ay), angle: if ax == ay { 0.0 } else { angle } };
        let normal = Vec3::new(nx, ny, nz);
        // As written, where that is a unit vector already.
        let normal = if (normal.length_squared() - 1.0).abs() < 1e-6 { normal } else { normal.normalize() };
        let weight = places[j].weight.map_or(1.0, |channel| raster.at(x, y, channel));
        (Lobe { normal, roughness: RoughnessTensor::from_axes(axes) }, weight)
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
