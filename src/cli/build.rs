//! `mipfold build`.

use std::collections::HashSet;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::ArgMatches;
use indicatif::ProgressBar;

use super::args::{BuildArgs, Global};
use super::config::{self, Config, Settings};
use super::inputs::{given, look, read_as, single};
use super::job::Job;
use super::model;
use super::report::{Built, MapSaid, Passed, Report, Tiles, Unchanged};
use super::vocabulary::Vocabulary;
use crate::codec;
use crate::error::{Error, Result};
use crate::material::detect::{self, NamedMap, PassedOver, TextureSet, named_maps};
use crate::material::{Earlier, Inputs, colour};
use crate::output::{Request, file_digest, fresh, key, safe_name};

/// What became of a material.
enum Outcome {
    Built(Built),
    Unchanged(Unchanged),
}

/// A material with the options that hold for it.
struct Material {
    args: BuildArgs,
    inputs: Inputs,
    maps: Vec<NamedMap>,
    /// Absent if options name the maps.
    set: Option<TextureSet>,
}

pub fn run(args: &BuildArgs, said: &ArgMatches, global: &Global, report: &mut Report) -> Result<()> {
    if args.inputs.iter().any(|input| model::is_model(input)) {
        return model::run(args, said, global, report);
    }
    // What is wrong by itself is said once, before anything is looked at.
    args.folding.options(args.moments)?;
    let vocabulary = Vocabulary::new(said);
    let named = args.config.as_deref().map(|file| Config::read(file, None, &vocabulary)).transpose()?;
    let mut found: Vec<Result<Material>> = Vec::new();
    let mut passed = Vec::new();
    if args.inputs.is_empty() {
        found.extend(of_options(args, &vocabulary, named.as_ref(), &mut passed)?.map(Ok));
    }
    let mut taken = HashSet::new();
    for input in &args.inputs {
        match of_folder(input, args, &vocabulary, named.as_ref(), &mut taken, report) {
            Ok((materials, others)) => {
                found.extend(materials);
                passed.extend(others);
            }
            Err(Refused::Input(error)) => found.push(Err(error)),
            Err(Refused::All(error)) => return Err(error),
        }
    }
    let unmatched = named.iter().flat_map(Config::unmatched);
    unmatched.for_each(|warning| report.warn(warning));
    let alone = found.len() == 1;
    if args.maps.name.is_some() && !alone {
        let expected = "one material; several are named after their files";
        return Err(Error::invalid_option("--name", format!("{} materials", found.len()), expected));
    }
    let mut materials = Vec::new();
    for material in found {
        match material {
            Ok(material) => materials.push(material),
            Err(error) => report.error(&error),
        }
    }
    tiles(&materials).into_iter().for_each(|tiles| report.tiles(tiles));
    let folders = if alone {
        vec![args.output.clone()]
    } else {
        apart(&args.output, materials.iter().map(Material::place).collect())
    };
    let jobs: Vec<_> = materials.iter().zip(folders).collect();
    // All of the bar is there from the start, so that it can tell how long the rest will take.
    report.progress.inc_length(jobs.len() as u64 * Job::STEPS);
    let results = side_by_side(&jobs, |(material, folder)| {
        let bar = &report.progress;
        bar.dec_length(Job::STEPS);
        material.build(folder, global, bar)
    });
    for result in results {
        match result {
            Ok(Outcome::Built(built)) => report.built(built),
            Ok(Outcome::Unchanged(unchanged)) => report.unchanged(unchanged),
            Err(error) => report.error(&error),
        }
    }
    for PassedOver { path, why } in passed {
        report.passed_over(Passed { path: path.display().to_string(), why });
    }
    Ok(())
}

/// Works on the jobs in as many threads as there are, each on one at a time. These are not the pool's: a thread of the pool
/// that waits for parts of one material would begin another, and memory would be that of many.
pub fn side_by_side<T: Sync, R: Send>(jobs: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let mut done: Vec<(usize, R)> = std::thread::scope(|scope| {
        let worker = || {
            let jobs = std::iter::from_fn(|| {
                let i = next.fetch_add(1, Ordering::Relaxed);
                jobs.get(i).map(|job| (i, work(job)))
            });
            jobs.collect::<Vec<_>>()
        };
        let workers: Vec<_> = (0..rayon::current_num_threads().min(jobs.len())).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    });
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}

impl Material {
    fn new(settings: Settings, inputs: Inputs, set: Option<TextureSet>) -> Result<Self> {
        let Settings { args, notes, .. } = settings;
        let mut inputs = read_as(inputs, &args.maps, &args.reading)?;
        inputs.notes.extend(notes);
        let maps = set.as_ref().map_or_else(|| named_maps(&inputs), |set| set.maps(&inputs));
        Ok(Self { args, inputs, maps, set })
    }

    /// Its folder below that of the outputs, where there are several.
    fn place(&self) -> PathBuf {
        match &self.set {
            Some(set) if self.args.maps.name.is_none() => safe(&set.place()),
            Some(set) => safe(&set.below).join(safe_name(&self.inputs.name)),
            None => safe_name(&self.inputs.name).into(),
        }
    }

    fn build(&self, folder: &Path, global: &Global, bar: &ProgressBar) -> Result<Outcome> {
        let (inputs, args) = (&self.inputs, &self.args);
        let options = args.folding.options(args.moments).map_err(|error| about(&inputs.name, error))?;
        let (mut request, form) = (request(args, folder, global), args.folding.form());
        let digests = key(&request.inputs(inputs), &options, form, &request, file_digest);
        // Files that cannot be read are told of when they are.
        request.key = digests.ok();
        if let Some(key) = request.key.as_ref().filter(|_| !global.force)
            && let Some(Earlier { warnings, .. }) = fresh(folder, key)
        {
            let folder = folder.to_string_lossy().into_owned();
            return Ok(Outcome::Unchanged(Unchanged { name: inputs.name.clone(), folder, warnings }));
        }
        let job = Job {
            inputs,
            read: &codec::read,
            under: None,
            flakes: None,
            draw: None,
            options: &options,
            form,
            request: &request,
            skip_if_below: args.skip_if_below,
        };
        let mut built = job.run(global.dry_run, bar)?.built;
        built.maps = self.maps.iter().map(map_said).collect();
        Ok(Outcome::Built(built))
    }
}

/// An error about options, which may hold for one material only.
fn about(material: &str, error: Error) -> Error {
    match error {
        Error::Invalid { subject, found, expected } => {
            Error::invalid_option(format!("{material}: {subject}"), found, expected)
        }
        other => other,
    }
}

/// What to write of a material.
fn request(args: &BuildArgs, folder: &Path, global: &Global) -> Request {
    let containers = args.containers.request(folder, global.force);
    Request { moments: args.moments, extras: args.extra.clone(), ..containers }
}

fn map_said(map: &NamedMap) -> MapSaid {
    MapSaid {
        role: map.role,
        file: map.path.display().to_string(),
        channel: map.channel.map(colour),
        why: map.word.as_ref().map_or_else(|| "given".into(), |word| format!("'{word}' in its name")),
    }
}

/// The material whose maps are given, unless a file of options leaves it out.
fn of_options(
    args: &BuildArgs,
    vocabulary: &Vocabulary,
    named: Option<&Config>,
    passed: &mut Vec<PassedOver>,
) -> Result<Option<Material>> {
    let name = single(&args.maps, &args.reading, "build")?.name;
    let name = args.maps.name.clone().unwrap_or(name);
    let configs: Vec<&Config> = named.into_iter().collect();
    let mut settings = config::settings(vocabulary, &configs, &name, None)?;
    if let Some(why) = settings.skipped.take() {
        passed.push(PassedOver { path: name.into(), why });
        return Ok(None);
    }
    let inputs = single(&settings.args.maps, &settings.args.reading, "build")?;
    Material::new(settings, inputs, None).map(Some)
}

/// Why a folder gives no materials.
enum Refused {
    /// It cannot be read, or has none; others may.
    Input(Error),
    /// Options that were meant for materials cannot be read: nothing is built with others.
    All(Error),
}

type Materials = (Vec<Result<Material>>, Vec<PassedOver>);

/// The materials of a folder and of all below it, and what plays no part.
fn of_folder(
    input: &Path,
    args: &BuildArgs,
    vocabulary: &Vocabulary,
    named: Option<&Config>,
    taken: &mut HashSet<PathBuf>,
    report: &mut Report,
) -> std::result::Result<Materials, Refused> {
    let found = look(input, Some(&args.output)).map_err(Refused::Input)?;
    let mut passed = found.passed_over;
    let configs =
        if named.is_some() { Vec::new() } else { configs(input, &found.sets, vocabulary).map_err(Refused::All)? };
    let mut sets: Vec<(TextureSet, Result<Inputs>, Settings)> = Vec::new();
    let mut skips = false;
    let place = |set: &TextureSet| set.folder.canonicalize().unwrap_or_else(|_| set.folder.clone());
    let (again, new): (Vec<_>, Vec<_>) = found.sets.into_iter().partition(|set| taken.contains(&place(set)));
    taken.extend(new.iter().map(place));
    for set in again {
        passed.push(PassedOver {
            path: set.folder.join(&set.name),
            why: "taken already, from another folder given".into(),
        });
        skips = true;
    }
    for set in new {
        let above = configs.iter().filter(|(below, _)| set.below.starts_with(below)).map(|(_, config)| config);
        let above: Vec<&Config> = above.chain(named).collect();
        let mut settings = config::settings(vocabulary, &above, &set.name, Some(&set)).map_err(Refused::All)?;
        if let Some(why) = settings.skipped.take() {
            passed.push(PassedOver { path: input.join(set.place()), why });
            skips = true;
            continue;
        }
        match set.inputs(&given(&settings.args.maps, &settings.args.reading)).transpose() {
            Some(inputs) => sets.push((set, inputs, settings)),
            None => passed.extend(set.passed_over(None)),
        }
    }
    for (_, config) in &configs {
        config.unmatched().into_iter().for_each(|warning| report.warn(warning));
    }
    let mut alone = detect::widths_alone(&sets.iter().map(|(set, inputs, _)| (set, inputs)).collect::<Vec<_>>());
    // What options name is wanted.
    alone.iter_mut().zip(&sets).for_each(|(alone, (.., settings))| {
        *alone &= settings.args.maps.normal.is_none() && settings.args.maps.height.is_none();
    });
    let (lone, sets): (Vec<_>, Vec<_>) = sets.into_iter().zip(alone).partition(|(_, alone)| *alone);
    let mut materials: Vec<Result<Material>> = Vec::new();
    for ((set, inputs, settings), _) in sets {
        let mut lone =
            lone.iter().filter(|((other, ..), _)| other.folder == set.folder).map(|((other, ..), _)| &other.name);
        let first = !materials.iter().flatten().any(|m| m.set.as_ref().is_some_and(|other| other.folder == set.folder));
        let names =
            if first { lone.by_ref().map(String::as_str).collect::<Vec<_>>().join(", ") } else { String::new() };
        let material = inputs.and_then(|mut inputs| {
            if !names.is_empty() {
                inputs.warnings.push(format!(
                    "passed over, roughness without a normal map of its name: {names}. If they belong together, name them \
                     with --normal and --roughness"
                ));
            }
            Material::new(settings, inputs, Some(set))
        });
        if let Ok(Material { inputs, set: Some(set), .. }) = &material {
            passed.extend(set.passed_over(Some(inputs)));
        }
        materials.push(material);
    }
    passed.extend(lone.iter().flat_map(|((set, ..), _)| set.passed_over(None)));
    materials.extend(found.errors.into_iter().map(Err));
    if materials.is_empty() && !skips {
        return Err(Refused::Input(detect::nothing(input)));
    }
    Ok((materials, passed))
}

/// The files of options in the folders that have sets and in those above them, with the path of each below `input`; farther
/// ones first.
fn configs(input: &Path, sets: &[TextureSet], vocabulary: &Vocabulary) -> Result<Vec<(PathBuf, Config)>> {
    let mut folders: Vec<&Path> = sets.iter().flat_map(|set| set.below.ancestors()).collect();
    folders.sort();
    folders.dedup();
    let mut configs = Vec::new();
    for below in folders {
        let file = input.join(below).join(config::NAME);
        if file.exists() {
            configs.push((below.to_owned(), Config::read(&file, Some(below.to_owned()), vocabulary)?));
        }
    }
    Ok(configs)
}

/// The textures that are cut into tiles.
fn tiles(materials: &[Material]) -> Vec<Tiles> {
    let mut found: Vec<(PathBuf, Tiles)> = Vec::new();
    for set in materials.iter().filter_map(|material| material.set.as_ref()) {
        let Some(tile) = &set.tile else { continue };
        let same = |(folder, tiles): &&mut (PathBuf, Tiles)| *folder == set.folder && tiles.name == set.base;
        match found.iter_mut().find(same) {
            Some((_, tiles)) => tiles.tiles.push(tile.text.clone()),
            None => {
                let tiles = Tiles { name: set.base.clone(), tiles: vec![tile.text.clone()] };
                found.push((set.folder.clone(), tiles));
            }
        }
    }
    found.into_iter().map(|(_, tiles)| tiles).collect()
}

/// A path that every file system takes, and that leads nowhere else.
fn safe(place: &Path) -> PathBuf {
    place.iter().map(|part| safe_name(&part.to_string_lossy())).collect()
}

/// A folder for each material, named apart.
pub fn output_folders(output: &Path, names: &[&str]) -> Vec<PathBuf> {
    apart(output, names.iter().map(|name| safe_name(name).into()).collect())
}

fn apart(output: &Path, places: Vec<PathBuf>) -> Vec<PathBuf> {
    let mut taken: Vec<PathBuf> = Vec::new();
    // File systems that ignore case exist.
    let lower = |path: &Path| path.to_string_lossy().to_lowercase();
    let mut lowered = HashSet::new();
    for base in places {
        let mut place = base.clone();
        let mut n = 2;
        while !lowered.insert(lower(&place)) {
            let mut name = base.file_name().unwrap_or_default().to_owned();
            name.push(format!("_{n}"));
            place = base.with_file_name(name);
            n += 1;
        }
        taken.push(place);
    }
    taken.into_iter().map(|place| output.join(place)).collect()
}
