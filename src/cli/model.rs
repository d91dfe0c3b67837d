//! `mipfold build` of a model.

use std::path::Path;

use clap::{ArgMatches, Args};
use serde::Serialize;

use super::args::{BuildArgs, Global};
use super::build::side_by_side;
use super::report::{Portion, Report};
use super::vocabulary::Vocabulary;
use crate::error::{Error, Result};
use crate::material::{Fate, Foldable, Model};
use crate::output::model::{
    FoldedMaterial, Group, ImageAbout, ImageDigest, Left, ModelOptions, Proof, Rewritten, Slot, check_early, digests,
    fold_material, rewrite,
};
use crate::output::preset::Compress;
use crate::output::{Gain, SCHEMA};

/// The options that hold for a model, which says itself how its textures are read, and whose new ones are KTX 2; all others
/// are refused.
const OPTIONS: [&str; 12] = [
    "output",
    "fold",
    "lobes",
    "strength",
    "at_least_average",
    "min_alpha",
    "max_alpha",
    "compress",
    "effort",
    "resize",
    "fallback",
    "skip_if_below",
];

#[derive(Args)]
#[command(next_help_heading = "Models")]
pub struct ModelArgs {
    /// Keep a model's old images beside the new textures, for viewers that read no KTX 2
    #[arg(long)]
    pub fallback: bool,
}

/// What became of one material, or of several that use the same textures in the same way.
#[derive(Serialize)]
struct About<'a> {
    name: &'a str,
    /// Numbers in the file.
    materials: Vec<usize>,
    folded: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'a str>,
    /// Whether that is nothing to wonder about.
    #[serde(skip)]
    plain: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gain: Option<Gain>,
    textures: Vec<TextureAbout<'a>>,
    notes: &'a [String],
    warnings: &'a [String],
}

#[derive(Serialize)]
struct TextureAbout<'a> {
    slot: Slot,
    /// Of the image in the file that was read.
    from: usize,
    /// In the file that was written.
    image: usize,
    /// The picture there that readers without KTX 2 show, if it is new.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    format: Option<&'static str>,
    /// Level 0 before and after, before it is compressed.
    level_0: &'a [Proof],
}

/// What was done: beside the model, and for `--json`.
#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    generator: &'static str,
    version: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    dry_run: Option<bool>,
    input: String,
    output: String,
    fold: &'static str,
    compress: Compress,
    files: &'a [String],
    materials: &'a [About<'a>],
    images: &'a [ImageDigest],
    warnings: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<[(); 0]>,
}

/// Whether a path is that of a model.
pub fn is_model(path: &Path) -> bool {
    is_named_as_model(path) && !path.is_dir()
}

/// A group and what was folded of it, or why it stays.
struct Done<'a> {
    foldable: &'a Foldable,
    result: std::result::Result<FoldedMaterial, Left>,
}

pub fn run(args: &BuildArgs, said: &ArgMatches, global: &Global, report: &mut Report) -> Result<()> {
    let options = options(args, said)?;
    let (input, output) = (&args.inputs[0], &args.output);
    report.progress.set_message(format!("reading {}", input.display()));
    let Some(model) = Model::read(input)? else {
        return Err(Error::invalid(input, "a file that is no glTF", "a .glb or .gltf of glTF 2.0"));
    };
    let fates = model.fates()?;
    let foldables: Vec<&Foldable> =
        fates.iter().filter_map(|fate| if let Fate::Fold(f) = fate { Some(&**f) } else { None }).collect();
    let (stem, to_binary) = (stem(output), ending(output) == "glb");
    // A place that is taken is told before anything is folded, those of files too that are made only if folding gains
    // enough.
    let planned: Vec<_> =
        foldables.iter().filter_map(|f| Some((*f, FoldedMaterial::planned(f, &options).ok()?))).collect();
    let planned: Vec<Group> = planned.iter().map(|(foldable, folded)| Group { foldable, folded }).collect();
    rewrite(&model, &planned, &options, to_binary, &stem)?.files.check(input, output, global.force)?;
    planned.iter().try_for_each(|group| check_early(group.foldable, &options))?;
    let work = |foldable: &&Foldable| {
        let portion = Portion::on(&report.progress);
        let result = fold_material(foldable, &options, global.dry_run, &|share| portion.show(share))?;
        portion.show(1.0);
        Ok(result)
    };
    let results = side_by_side(&foldables, work).into_iter().collect::<Result<Vec<_>>>()?;
    let done: Vec<Done> = foldables.iter().zip(results).map(|(foldable, result)| Done { foldable, result }).collect();
    let groups: Vec<Group> = done
        .iter()
        .filter_map(|done| Some(Group { foldable: done.foldable, folded: done.result.as_ref().ok()? }))
        .collect();
    report.progress.set_message(format!("writing {}", output.display()));
    let rewritten = rewrite(&model, &groups, &options, to_binary, &stem)?;
    let digests = digests(&model, &rewritten, &groups)?;
    let Rewritten { files, images, warnings, .. } = &rewritten;
    files.check(input, output, global.force)?;
    let names = files.names(output);
    let materials = about(&fates, &done, images);
    let document = |dry_run: Option<bool>| Document {
        schema: SCHEMA,
        generator: crate::material::GENERATOR,
        version: env!("CARGO_PKG_VERSION"),
        dry_run,
        input: input.to_string_lossy().into_owned(),
        output: output.to_string_lossy().into_owned(),
        fold: options.fold.fold.name,
        compress: options.compress,
        files: &names,
        materials: &materials,
        images: &digests,
        warnings,
        errors: dry_run.map(|_| []),
    };
    let json = |document: &Document| serde_json::to_string_pretty(document).expect("plain data") + "\n";
    if !global.dry_run {
        files.write(input, output, &json(&document(None)), global.force)?;
    }
    tell(report, global, output, &materials, &names, files.main.len());
    warnings.iter().for_each(|warning| report.warning(warning));
    report.document(json(&document(Some(global.dry_run))));
    Ok(())
}

fn is_named_as_model(path: &Path) -> bool {
    ["glb", "gltf"].contains(&ending(path).as_str())
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// The beginning of the names of files beside the model.
fn stem(output: &Path) -> String {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect()
}

/// The options, none of which may be another one than [`OPTIONS`].
fn options(args: &BuildArgs, said: &ArgMatches) -> Result<ModelOptions> {
    let refuse = |option: &str, found: &str, expected: &str| Err(Error::invalid_option(option, found, expected));
    if args.inputs.len() > 1 {
        return refuse("build", &format!("{} inputs, models among them", args.inputs.len()), "one model at a time");
    }
    if !is_named_as_model(&args.output) {
        let found = args.output.display().to_string();
        return refuse("-o", &found, "the name of the new model, ending in .glb or .gltf");
    }
    let option = |id: &str| format!("--{}", id.replace('_', "-"));
    let given = Vocabulary::new(said).given;
    if let Some(other) = given.iter().find(|word| !OPTIONS.contains(&word.id.as_str())) {
        let expected = format!("the options of models: {}", OPTIONS.map(option).join(", "));
        return refuse(&option(&other.id), "a model", &expected);
    }
    let containers = &args.containers;
    let fold = args.folding.options(false)?;
    if fold.lobes > 1 {
        return refuse("--lobes", &format!("{} lobes", fold.lobes), "iso or aniso: a glTF material has one lobe");
    }
    if args.model.fallback && containers.compress.is_some_and(|compress| compress != Compress::Uastc) {
        let expected = "uastc: only KHR_texture_basisu has a place for another picture beside it";
        return refuse("--fallback", "another --compress than uastc", expected);
    }
    let request = containers.request(Path::new(""), false);
    Ok(ModelOptions {
        fold,
        form: args.folding.form(),
        compress: containers.compress.unwrap_or(Compress::Uastc),
        effort: request.effort,
        sides: request.resize,
        skip_if_below: args.skip_if_below,
        fallback: args.model.fallback,
    })
}

fn about<'a>(fates: &'a [Fate], done: &'a [Done], images: &'a [ImageAbout]) -> Vec<About<'a>> {
    let (mut results, mut folded) = (done.iter(), 0);
    let of = |fate: &'a Fate| match fate {
        Fate::Leave { material, name, reason, plain } => About::left(name, vec![*material], reason, *plain),
        Fate::Fold(foldable) => {
            let (name, materials) = (&foldable.inputs.name, foldable.materials.clone());
            match &results.next().expect("one for each").result {
                Err(Left { reason, plain }) => About::left(name, materials, reason, *plain),
                Ok(material) => {
                    folded += 1;
                    About::folded(name, materials, material, images.iter().filter(|image| image.group == folded - 1))
                }
            }
        }
    };
    fates.iter().map(of).collect()
}

impl<'a> About<'a> {
    /// One that stays as it is.
    fn left(name: &'a str, materials: Vec<usize>, reason: &'a str, plain: bool) -> Self {
        Self {
            name,
            materials,
            folded: false,
            reason: Some(reason),
            plain,
            width: None,
            height: None,
            gain: None,
            textures: Vec::new(),
            notes: &[],
            warnings: &[],
        }
    }

    /// One that was folded, with its images.
    fn folded(
        name: &'a str,
        materials: Vec<usize>,
        material: &'a FoldedMaterial,
        images: impl Iterator<Item = &'a ImageAbout>,
    ) -> Self {
        let texture = |image: &'a ImageAbout| {
            let texture = material.textures.iter().find(|texture| texture.slot == image.slot);
            TextureAbout {
                slot: image.slot,
                from: image.from,
                image: image.image,
                picture: image.picture,
                format: texture.map(|texture| texture.format.name()),
                level_0: texture.map_or(&[], |texture| &texture.level_0),
            }
        };
        Self {
            folded: true,
            reason: None,
            width: material.size.map(|size| size.width),
            height: material.size.map(|size| size.height),
            gain: material.gain,
            textures: images.map(texture).collect(),
            notes: &material.notes,
            warnings: &material.warnings,
            ..Self::left(name, materials, "", false)
        }
    }
}

/// For people.
fn tell(report: &Report, global: &Global, output: &Path, materials: &[About], names: &[String], bytes: usize) {
    for about in materials {
        match (about.reason, about.width.zip(about.height)) {
            (None, Some((width, height))) => {
                let slots: Vec<_> = about.textures.iter().map(|texture| texture.slot.name()).collect();
                report.say(&format!("{}: {width}x{height}, folded: {}", about.name, slots.join(", ")));
                about.gain.iter().for_each(|gain| report.say(&format!("  {}", gain.describe())));
            }
            (reason, _) => {
                let text = format!("{}: left as it is: {}", about.name, reason.unwrap_or_default());
                if about.plain { report.say(&text) } else { report.warning(&text) }
            }
        }
        about.notes.iter().for_each(|note| report.say(&format!("  {note}")));
        about.warnings.iter().for_each(|warning| report.warning(&format!("{}: {warning}", about.name)));
    }
    if materials.is_empty() {
        report.say("no materials");
    }
    let (verb, size) = match global.dry_run {
        true => ("would write", String::new()),
        false => ("wrote", format!(" of {bytes} bytes")),
    };
    let beside = if names.len() == 2 { "1 file".to_owned() } else { format!("{} files", names.len() - 1) };
    report.say(&format!("{verb} {}{size}, and {beside} beside it", output.display()));
    if global.dry_run {
        names.iter().for_each(|name| report.say(&format!("  {name}")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::vocabulary::id;

    #[test]
    fn options_of_models_are_options() {
        let command = BuildArgs::augment_args(clap::Command::new("build"));
        for option in OPTIONS {
            let arg = command.get_arguments().find(|arg| id(arg) == option);
            assert!(arg.and_then(clap::Arg::get_long).is_some_and(|long| long == option.replace('_', "-")), "{option}");
        }
    }
}
