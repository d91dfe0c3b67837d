//! Level-0 inputs from flags and folders.

use std::path::Path;

use super::args::{MapArgs, ReadingArgs};
use crate::error::{Error, Result};
use crate::material::{ChannelRef, Inputs, RoughnessInput, detect};
use crate::roughness::PerceptualRoughness;

/// The options that hold for all materials.
pub fn read_as(set: Inputs, maps: &MapArgs, reading: &ReadingArgs) -> Result<Inputs> {
    let given = given_width(maps)?;
    Ok(Inputs {
        name: maps.name.clone().unwrap_or(set.name),
        roughness: if given == RoughnessInput::Missing { set.roughness } else { given },
        normal_z: reading.normal_z,
        normal_range: reading.normal_range,
        normal_scale: Some(reading.normal_scale),
        height_scale: reading.height_scale,
        wrap: reading.wrap.into(),
        ..set
    })
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
    let first = maps.normal.as_deref().or(maps.height.as_deref()).or(match &roughness {
        RoughnessInput::Roughness(c) | RoughnessInput::Smoothness(c) => Some(c.path.as_path()),
        _ => None,
    });
    let Some(first) = first else {
        return Err(Error::invalid_option(command, "no maps", "a folder, or --normal, --height or --roughness FILE"));
    };
    Ok(Inputs {
        name: first.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
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

/// The materials of a folder.
pub fn folder(input: &Path, maps: &MapArgs, reading: &ReadingArgs) -> Result<Vec<Result<Inputs>>> {
    let extension = input.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if input.is_file() {
        let hint = if extension == "glb" || extension == "gltf" {
            "a folder of texture files; for models see mipfold bake-curvature"
        } else {
            "a folder; single maps are given with --normal and --roughness"
        };
        return Err(Error::unsupported(input, "a single file", hint));
    }
    let width_given = maps.roughness.is_some() || maps.gloss.is_some();
    detect::folder(input, reading.normal_y, width_given)
}
