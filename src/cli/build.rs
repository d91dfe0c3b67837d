//! `mipfold build`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::args::{BuildArgs, Global};
use super::inputs::{folder, read_as, single};
use super::job::Job;
use super::model;
use super::report::{Built, Report, Unchanged};
use crate::codec;
use crate::error::{Error, Result};
use crate::material::Inputs;
use crate::output::{Request, file_digest, is_fresh, key, safe_name};

/// What became of a material.
enum Outcome {
    Built(Built),
    Unchanged(Unchanged),
}

pub fn run(args: &BuildArgs, global: &Global, report: &mut Report) -> Result<()> {
    if args.inputs.iter().any(|input| model::is_model(input)) {
        return model::run(args, global, report);
    }
    let options = args.folding.options(args.moments)?;
    let (maps, reading) = (&args.maps, &args.reading);
    let found: Vec<Result<Inputs>> = if args.inputs.is_empty() {
        vec![single(maps, reading, "build")]
    } else {
        let sets = args.inputs.iter().map(|input| folder(input, maps, reading));
        sets.flat_map(|sets| sets.unwrap_or_else(|error| vec![Err(error)])).collect()
    };
    let alone = found.len() == 1;
    if args.maps.name.is_some() && !alone {
        let expected = "one material; several are named after their files";
        return Err(Error::invalid_option("--name", format!("{} materials", found.len()), expected));
    }
    let mut sets = Vec::new();
    for set in found {
        match set {
            Ok(set) => sets.push(read_as(set, maps, reading)?),
            Err(error) => report.error(&error),
        }
    }
    let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
    let folders = if alone { vec![args.output.clone()] } else { output_folders(&args.output, &names) };
    let jobs: Vec<_> = sets.iter().zip(folders).collect();
    let results: Vec<_> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(inputs, folder)| {
            let request = Request {
                moments: args.moments,
                extras: args.extra.clone(),
                ..args.containers.request(folder, global.force)
            };
            let (read, form) = (&codec::read, args.folding.form());
            let key = key(&request.inputs(inputs), &options, form, &request, |path| file_digest(path));
            let request = Request { key: key.ok(), ..request };
            if let Some(key) = request.key.as_ref().filter(|_| !global.force && !global.dry_run)
                && is_fresh(folder, key)
            {
                return Ok(Outcome::Unchanged(Unchanged {
                    name: inputs.name.clone(),
                    folder: folder.to_string_lossy().into_owned(),
                }));
            }
            let job = Job {
                inputs,
                read,
                under: None,
                flakes: None,
                draw: None,
                options: &options,
                form,
                request: &request,
                skip_if_below: args.skip_if_below,
            };
            job.run(global.dry_run, &report.progress).map(|done| Outcome::Built(done.built))
        })
        .collect();
    for result in results {
        match result {
            Ok(Outcome::Built(built)) => report.built(built),
            Ok(Outcome::Unchanged(unchanged)) => report.unchanged(unchanged),
            Err(error) => report.error(&error),
        }
    }
    Ok(())
}

/// A folder for each material, named apart.
pub fn output_folders(output: &Path, names: &[&str]) -> Vec<PathBuf> {
    let mut taken: Vec<String> = Vec::new();
    for name in names {
        let base = safe_name(name);
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
