//! `mipfold demo`.

use std::path::Path;

use super::args::{DemoArgs, Global};
use super::job::{self, Done};
use super::report::Report;
use crate::codec::write_png;
use crate::error::{Error, Result};
use crate::fold::{Fold, Options, base_lobes, chain};
use crate::image::Raster;
use crate::material::{ChannelRef, Inputs, Material, RoughnessInput};
use crate::ndf::Lobes;
use crate::output::{Format, Request, Stage};
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
        let unknown = || Error::invalid_option("SAMPLE", format!("'{}'", args.sample), names.join(", "));
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
    let maps = (sample.make)(usize::from(args.size), args.seed);
    write_pictures(&folder, &[("normal.png", &maps.normal), ("orm.png", &maps.orm)])?;
    let inputs = Inputs {
        name: sample.name.into(),
        normal: Some(folder.join("normal.png")),
        roughness: RoughnessInput::Roughness(ChannelRef { path: folder.join("orm.png"), channel: Some(1) }),
        ..Inputs::default()
    };
    let request = Request {
        folder: folder.join("mips"),
        formats: vec![Format::Png],
        depth: crate::codec::Depth::Half,
        moments: false,
        force: global.force,
    };
    let Done { material, chain: folded, built } =
        job::build(&inputs, options, &request, global.dry_run, &report.progress)?;
    report.built(built);
    if let Some(folded) = folded {
        report.progress.set_message("drawing near to far");
        let average = Options { fold: Fold::by_name("average")?, ..*options };
        let plain = levels(&material, chain(&material, &average), options);
        let folded = levels(&material, folded, options);
        let strip = distance_strip(&Scene::studio(), &[("plain mips", &plain), ("folded", &folded)], CELL, &DISTANCES);
        write_pictures(&folder, &[("distance.png", &strip)])?;
        report.say(&format!(
            "  from near to far, plain mips, folded and truth: {}",
            folder.join("distance.png").display()
        ));
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
    stage.commit("")
}
