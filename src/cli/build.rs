//! `mipfold build`.

use std::path::Path;

use rayon::prelude::*;

use super::args::{BuildArgs, Global, MapArgs};
use super::job::Job;
use super::report::Report;
use crate::codec;
use crate::error::{Error, Result};
use crate::material::{ChannelRef, Inputs, NormalY, RoughnessInput, detect};
use crate::output::{Request, safe_name};
use crate::roughness::PerceptualRoughness;

pub fn run(args: &BuildArgs, global: &Global, report: &mut Report) -> Result<()> {
    let options = args.folding.options(args.moments)?;
    let found = if args.inputs.is_empty() { vec![single(&args.maps, args.reading.normal_y)] } else { folders(args) };
    let alone = found.len() == 1;
    if args.maps.name.is_some() && !alone {
        let expected = "one material; several are named after their files";
        return Err(Error::invalid_option("--name", format!("{} materials", found.len()), expected));
    }
    let mut sets = Vec::new();
    for set in found {
        match set {
            Ok(set) => sets.push(read_as(set, args)?),
            Err(error) => report.error(&error),
        }
    }
    let folders = if alone { vec![args.output.clone()] } else { output_folders(&args.output, &sets) };
    let jobs: Vec<_> = sets.iter().zip(folders).collect();
    let results: Vec<_> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(inputs, folder)| {
            let request = Request {
                folder: folder.clone(),
                formats: args.format.clone(),
                depth: args.depth(),
                moments: args.moments,
                force: global.force,
            };
            let job =
                Job { inputs, read: &codec::read, options: &options, form: args.folding.form(), request: &request };
            job.run(global.dry_run, &report.progress).map(|done| done.built)
        })
        .collect();
    for result in results {
        match result {
            Ok(built) => report.built(built),
            Err(error) => report.error(&error),
        }
    }
    Ok(())
}

/// The options that hold for all materials.
fn read_as(set: Inputs, args: &BuildArgs) -> Result<Inputs> {
    let given = given_width(&args.maps)?;
    Ok(Inputs {
        name: args.maps.name.clone().unwrap_or(set.name),
        roughness: if given == RoughnessInput::Missing { set.roughness } else { given },
        normal_z: args.reading.normal_z,
        normal_range: args.reading.normal_range,
        normal_scale: Some(args.reading.normal_scale),
        height_scale: args.reading.height_scale,
        wrap: args.reading.wrap.into(),
        ..set
    })
}

/// The roughness that flags give.
fn given_width(maps: &MapArgs) -> Result<RoughnessInput> {
    let orm = maps.orm.as_ref().map(|path| ChannelRef { path: path.clone(), channel: Some(1) });
    Ok(match (&maps.roughness, &maps.gloss, orm) {
        (Some(text), _, _) => roughness(text)?,
        (_, Some(text), _) => smoothness(text)?,
        (_, _, Some(orm)) => RoughnessInput::Roughness(orm),
        _ => RoughnessInput::Missing,
    })
}

/// A material from flags.
fn single(maps: &MapArgs, normal_y: NormalY) -> Result<Inputs> {
    let roughness = given_width(maps)?;
    let first = maps.normal.as_deref().or(maps.height.as_deref()).or(match &roughness {
        RoughnessInput::Roughness(c) | RoughnessInput::Smoothness(c) => Some(c.path.as_path()),
        _ => None,
    });
    let Some(first) = first else {
        return Err(Error::invalid_option("build", "no maps", "a folder, or --normal, --height or --roughness FILE"));
    };
    Ok(Inputs {
        name: first.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        normal: maps.normal.clone(),
        roughness,
        anisotropy: maps.anisotropy.clone(),
        height: maps.height.clone(),
        normal_y,
        ..Inputs::default()
    })
}

/// A number, or a channel of a file.
fn roughness(text: &str) -> Result<RoughnessInput> {
    match text.parse::<f32>() {
        Ok(r) if (0.0..=1.0).contains(&r) => Ok(RoughnessInput::Constant(PerceptualRoughness(r))),
        Ok(r) => Err(Error::invalid_option("--roughness", r.to_string(), "a number from 0 to 1, or a file")),
        Err(_) => Ok(RoughnessInput::Roughness(ChannelRef::parse(text))),
    }
}

/// The same, for gloss.
fn smoothness(text: &str) -> Result<RoughnessInput> {
    match text.parse::<f32>() {
        Ok(s) if (0.0..=1.0).contains(&s) => Ok(RoughnessInput::Constant(PerceptualRoughness::from_smoothness(s))),
        Ok(s) => Err(Error::invalid_option("--gloss", s.to_string(), "a number from 0 to 1, or a file")),
        Err(_) => Ok(RoughnessInput::Smoothness(ChannelRef::parse(text))),
    }
}

fn folders(args: &BuildArgs) -> Vec<Result<Inputs>> {
    let width_given = args.maps.roughness.is_some() || args.maps.gloss.is_some();
    let mut sets = Vec::new();
    for input in &args.inputs {
        let extension = input.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if input.is_file() {
            let hint = if extension == "glb" || extension == "gltf" {
                "a folder of texture files; glTF is not read yet"
            } else {
                "a folder; single maps are given with --normal and --roughness"
            };
            sets.push(Err(Error::unsupported(input, "a single file", hint)));
            continue;
        }
        match detect::folder(input, args.reading.normal_y, width_given) {
            Ok(found) => sets.extend(found),
            Err(error) => sets.push(Err(error)),
        }
    }
    sets
}

/// A folder for each material, named apart.
fn output_folders(output: &Path, sets: &[Inputs]) -> Vec<std::path::PathBuf> {
    let mut taken: Vec<String> = Vec::new();
    for set in sets {
        let base = safe_name(&set.name);
        let mut name = base.clone();
        let mut n = 2;
        // File systems that ignore case exist.
        while taken.iter().any(|other| other.to_lowercase() == name.to_lowercase()) {
            name = format!("{base}_{n}");
            n += 1;
        }
        taken.push(name);
    }
    taken.into_iter().map(|name| output.join(name)).collect()
}
