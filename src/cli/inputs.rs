//! Level-0 inputs from flags and folders.

use std::path::Path;

use super::args::{MapArgs, ReadingArgs};
use super::model::is_model;
use crate::error::{Error, Result};
use crate::image::Wrap;
use crate::material::detect::{self, Found, Given, TextureSet};
use crate::material::{ChannelRef, Inputs, RoughnessInput};
use crate::roughness::PerceptualRoughness;

/// A material as the options want it: the maps that they name go before those that were found.
pub fn read_as(mut set: Inputs, maps: &MapArgs, reading: &ReadingArgs) -> Result<Inputs> {
    let given = given_width(maps)?;
    beside_width(&mut set, maps);
    if set.wrap == Wrap::Clamp && reading.wrap.is_none() {
        set.notes.push("beyond the border lies another tile, so it is clamped; --wrap changes it".into());
    }
    Ok(Inputs {
        name: maps.name.clone().unwrap_or(set.name),
        normal: maps.normal.clone().or(set.normal),
        anisotropy: maps.anisotropy.clone().or(set.anisotropy),
        height: maps.height.clone().or(set.height),
        roughness: if given == RoughnessInput::Missing { set.roughness } else { given },
        normal_z: reading.normal_z,
        normal_range: reading.normal_range,
        normal_scale: Some(reading.normal_scale),
        height_scale: reading.height_scale,
        wrap: reading.wrap.map_or(set.wrap, Into::into),
        ..set
    })
}

/// Occlusion and metal that options name, or that are in `--orm`.
pub fn beside_width(inputs: &mut Inputs, maps: &MapArgs) {
    let orm = |channel| maps.orm.as_ref().map(|path| ChannelRef { path: path.clone(), channel: Some(channel) });
    let named = |option: &Option<String>, channel| option.as_deref().map(ChannelRef::parse).or_else(|| orm(channel));
    inputs.occlusion = named(&maps.occlusion, 0).or(inputs.occlusion.take());
    inputs.metal = named(&maps.metal, 2).or(inputs.metal.take());
}

/// The roughness that flags give.
pub fn given_width(maps: &MapArgs) -> Result<RoughnessInput> {
    let orm = maps.orm.as_ref().map(|path| ChannelRef { path: path.clone(), channel: Some(1) });
    Ok(match (&maps.roughness, &maps.gloss, orm) {
        (Some(text), _, _) => roughness("--roughness", text)?,
        (_, Some(text), _) => smoothness("--gloss", text)?,
        (_, _, Some(orm)) => RoughnessInput::Roughness(orm),
        _ => RoughnessInput::Missing,
    })
}

/// A material from the flags of a command.
pub fn single(maps: &MapArgs, reading: &ReadingArgs, command: &str) -> Result<Inputs> {
    let roughness = given_width(maps)?;
    let first = maps.normal.as_deref().or(maps.height.as_deref()).or(roughness.file());
    let Some(first) = first else {
        return Err(Error::invalid_option(command, "no maps", "a folder, or --normal, --height or --roughness FILE"));
    };
    Ok(Inputs {
        name: detect::named_after(first),
        normal: maps.normal.clone(),
        roughness,
        anisotropy: maps.anisotropy.clone(),
        height: maps.height.clone(),
        normal_y: reading.normal_y,
        ..Inputs::default()
    })
}

/// A number, or a channel of a file; `subject` is what gave it.
pub fn roughness(subject: &str, text: &str) -> Result<RoughnessInput> {
    match text.parse::<f32>() {
        Ok(r) if (0.0..=1.0).contains(&r) => Ok(RoughnessInput::Constant(PerceptualRoughness(r))),
        Ok(r) => Err(Error::invalid_option(subject, r.to_string(), "a number from 0 to 1, or a file")),
        Err(_) => Ok(RoughnessInput::Roughness(ChannelRef::parse(text))),
    }
}

/// The same, for gloss.
pub fn smoothness(subject: &str, text: &str) -> Result<RoughnessInput> {
    match text.parse::<f32>() {
        Ok(s) if (0.0..=1.0).contains(&s) => Ok(RoughnessInput::Constant(PerceptualRoughness::from_smoothness(s))),
        Ok(s) => Err(Error::invalid_option(subject, s.to_string(), "a number from 0 to 1, or a file")),
        Err(_) => Ok(RoughnessInput::Smoothness(ChannelRef::parse(text))),
    }
}

/// What the options say of a material, and names need not.
pub fn given(maps: &MapArgs, reading: &ReadingArgs) -> Given {
    Given {
        normal_y: reading.normal_y,
        normal: maps.normal.is_some(),
        width: maps.roughness.is_some() || maps.gloss.is_some() || maps.orm.is_some(),
        anisotropy: maps.anisotropy.is_some(),
        height: maps.height.is_some(),
    }
}

/// The texture sets of a folder and of all below it, without the folder of the outputs.
pub fn look(input: &Path, outputs: Option<&Path>) -> Result<Found> {
    if input.is_file() {
        let hint = if is_model(input) {
            "a folder of texture files; build, audit and bake-curvature take models"
        } else {
            "a folder; single maps are given with --normal and --roughness"
        };
        return Err(Error::unsupported(input, "a single file", hint));
    }
    detect::folder(input, outputs)
}

/// The materials of a folder and of all below it.
pub fn folder(input: &Path, maps: &MapArgs, reading: &ReadingArgs) -> Result<Vec<Result<Inputs>>> {
    Ok(materials(input, maps, reading)?.into_iter().map(|(_, inputs)| inputs).collect())
}

/// A folder's own materials, or else those below it.
pub fn nearest(input: &Path, maps: &MapArgs, reading: &ReadingArgs) -> Result<Vec<Result<Inputs>>> {
    let (own, below): (Vec<_>, Vec<_>) =
        materials(input, maps, reading)?.into_iter().partition(|(set, _)| set.below.as_os_str().is_empty());
    let found = if own.is_empty() { below } else { own };
    Ok(found.into_iter().map(|(_, inputs)| inputs).collect())
}

fn materials(input: &Path, maps: &MapArgs, reading: &ReadingArgs) -> Result<Vec<(TextureSet, Result<Inputs>)>> {
    let (found, given) = (look(input, None)?, given(maps, reading));
    let mut materials = Vec::new();
    for set in found.sets {
        if let Some(inputs) = set.inputs(&given).transpose() {
            materials.push((set, inputs));
        }
    }
    let mut alone = detect::widths_alone(&materials.iter().map(|(set, inputs)| (set, inputs)).collect::<Vec<_>>());
    materials.retain(|_| !alone.remove(0));
    if materials.is_empty() {
        return Err(found.errors.into_iter().next().unwrap_or_else(|| detect::nothing(input)));
    }
    Ok(materials)
}
