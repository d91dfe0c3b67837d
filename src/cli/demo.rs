//! `mipfold demo`.

use std::path::Path;

use super::args::{DemoArgs, Global};
use super::compare::{PLAIN_SOURCE, levels, plain_mips};
use super::job::{Done, Job};
use super::judging::{self, Judging, REPORT_FILES, may_report};
use super::report::Report;
use crate::codec::{decode, write_png};
use crate::compare::{Candidate, Settings};
use crate::error::{Error, Result};
use crate::fold::Options;
use crate::image::Raster;
use crate::material::{ChannelRef, Earlier, Inputs, RoughnessInput};
use crate::ndf::{Form, lobes_in_words};
use crate::output::{Request, Stage, may_write};
use crate::reference::Reading;
use crate::render::{DISTANCES, Scene, distance_strip};
use crate::report::{ChainAbout, verdict};
use crate::sample::{SAMPLES, Sample, by_name};

/// Pixels along each side of a cell of the picture.
const CELL: usize = 160;

/// How closely the sample is judged: a look of seconds, not a measurement. `mipfold compare` takes its time.
fn quick() -> Settings {
    let reading = Reading { most_texels: Some(1024), ..Reading::default() };
    Settings { texels: Some(12), directions: 32, reading, ..Settings::default() }
}

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
    may_report(&folder, global.force)?;
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
    let request = Request { force: global.force, ..Request::new(folder.join("mips")) };
    let form = args.folding.form();
    let job = Job {
        inputs: &inputs,
        read: &read,
        under: None,
        flakes: None,
        draw: None,
        options,
        form,
        request: &request,
        skip_if_below: None,
    };
    let Done { material, options, chain: folded, built } = job.run(global.dry_run, &report.progress)?;
    report.built(built);
    if let Some(folded) = folded {
        let words = lobes_in_words(Form::Isotropic, options.lobes, options.shared_normal);
        let fold = Some(options.fold.name.to_owned() + &words);
        let folded = Candidate { name: "folded".into(), fold, levels: levels(&material, folded, options.form) };
        let candidates = [folded, plain_mips(&material)?];
        report.progress.set_message("drawing near to far");
        let rows = [("plain mips", &candidates[1].levels[..]), ("folded", &candidates[0].levels[..])];
        let strip = distance_strip(&Scene::studio(), &rows, CELL, &DISTANCES);
        let chain = |source: &str| ChainAbout { source: source.into(), ..ChainAbout::default() };
        let about = [chain("folded from the surface, as mips holds it"), chain(PLAIN_SOURCE)];
        let judging = Judging {
            material: &material,
            candidates: &candidates,
            about: &about,
            plain: Some(1),
            settings: &quick(),
            limits: &[],
            motion: false,
        };
        let findings = judging.run(report)?;
        let subject = judging.subject(&findings);
        let texts = judging::texts(&subject, report)?;
        let stage = Stage::new(&folder)?;
        stage.write("distance.png", |out| write_png(out, &strip))?;
        judging::write(&texts, &stage)?;
        stage.commit(REPORT_FILES[0], &[])?;
        let path = |name: &str| folder.join(name).display().to_string();
        report.say(&format!("  from near to far, plain mips, folded and truth: {}", path("distance.png")));
        report.say(&format!("  judged quickly: {}", path("report.html")));
        report.say(&format!("  {}", verdict(&subject).text));
    }
    Ok(())
}

fn write_pictures(folder: &Path, pictures: &[(&str, &Raster)]) -> Result<()> {
    let stage = Stage::new(folder)?;
    for (name, raster) in pictures {
        stage.write(name, |out| write_png(out, raster))?;
    }
    stage.commit("", &[])
}
