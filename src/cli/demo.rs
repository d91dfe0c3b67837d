//! `mipfold demo`.

use std::path::Path;

use super::args::{DemoArgs, Global};
use super::job::{Done, Job};
use super::report::Report;
use crate::codec::{decode, write_png};
use crate::error::{Error, Result};
use crate::fold::{Fold, Options, chain};
use crate::image::Raster;
use crate::material::{ChannelRef, Earlier, Inputs, Material, RoughnessInput, base_lobes};
use crate::ndf::Lobes;
use crate::output::{Format, Request, Stage, may_write};
use crate::render::{DISTANCES, Scene, distance_strip};
use crate::sample::{SAMPLES, Sample, by_name};

/// Pixels along each side of a cell of the picture.
const CELL: usize = 160;

pub fn run(args: &DemoArgs, global: &Global, report: &mut Report) -> Result<()> {
    if args.list {
        SAMPLES.iter().for_each(|sample| report.say(&format!("{:<16} {}", sample.name, sample.about)));
        return Ok(());
    }
    let samples: Vec<&Sample> = if args.all {
        SAMPLES.iter().collect()
    } else {
        let names: Vec<_> = SAMPLES.iter().map(|s| s.name).collect();
        let unknown = || {
            Error::invalid_option(
                "demo",
                format!("no sample '{}'", args.sample),
                format!("one of {}", names.join(", ")),
            )
        };
        vec![by_name(&args.sample).ok_or_else(unknown)?]
    };
    let options = args.folding.options(false)?;
    for sample in samples {
        one(sample, args, &options, global, report)?;
    }
    Ok(())
}

fn one(sample: &Sample, args: &DemoArgs, options: &Options, global: &Global, report: &mut Report) -> Result<()> {
    report.progress.set_message(format!("making {}", sample.name));
    let folder = args.output.join(sample.name);
    // A folder whose chain is ours is ours.
    let force = global.force || Earlier::read(&folder.join("mips")).is_some();
    may_write(&folder, ["normal.png", "orm.png", "distance.png"], force)?;
    let maps = (sample.make)(usize::from(args.size), args.seed);
    if !global.dry_run {
        write_pictures(&folder, &[("normal.png", &maps.normal), ("orm.png", &maps.orm)])?;
    }
    let inputs = Inputs {
        name: sample.name.into(),
        normal: Some(folder.join("normal.png")),
        roughness: RoughnessInput::Roughness(ChannelRef { path: folder.join("orm.png"), channel: Some(1) }),
        ..Inputs::default()
    };
    // A dry run has written nothing to read.
    let read = |path: &Path| {
        let raster = if path.ends_with("normal.png") { &maps.normal } else { &maps.orm };
        let mut bytes = Vec::new();
        write_png(&mut bytes, raster).map_err(|e| Error::io(path, e))?;
        decode(path, bytes)
    };
    let request = Request {
        folder: folder.join("mips"),
        formats: vec![Format::Png],
        depth: crate::codec::Depth::Half,
        moments: false,
        force: global.force,
    };
    let job = Job { inputs: &inputs, read: &read, options, form: args.folding.form(), request: &request };
    let Done { material, options, chain: folded, built } = job.run(global.dry_run, &report.progress)?;
    report.built(built);
    if let Some(folded) = folded {
        report.progress.set_message("drawing near to far");
        let average = Options { fold: Fold::by_name("average")?, ..options };
        let plain = levels(&material, chain(&material, &average), &options);
        let folded = levels(&material, folded, &options);
        let strip = distance_strip(&Scene::studio(), &[("plain mips", &plain), ("folded", &folded)], CELL, &DISTANCES);
        write_pictures(&folder, &[("distance.png", &strip)])?;
        let path = folder.join("distance.png");
        report.say(&format!("  from near to far, plain mips, folded and truth: {}", path.display()));
    }
    Ok(())
}

/// All levels as lobes, the finest first.
fn levels(material: &Material, chain: crate::fold::Chain, options: &Options) -> Vec<Lobes> {
    let base = base_lobes(material, options.form);
    std::iter::once(base).chain(chain.levels.into_iter().map(|level| level.lobes)).collect()
}

fn write_pictures(folder: &Path, pictures: &[(&str, &Raster)]) -> Result<()> {
    let stage = Stage::new(folder)?;
    for (name, raster) in pictures {
        stage.write(name, |out| write_png(out, raster))?;
    }
    stage.commit("", &[])
}
