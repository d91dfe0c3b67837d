//! `mipfold glint`.

use super::args::Global;
use super::compare::levels;
use super::glint_args::{GlintArgs, PreviewArgs};
use super::inputs::{nearest, read_as, single};
use super::job::Job;
use super::report::Report;
use crate::codec::{self, write_apng, write_png};
use crate::error::{Error, Result};
use crate::fold::Chain;
use crate::glint::SolidAngle;
use crate::image::Raster;
use crate::material::{Extra, Inputs, Material, MaterialFlakes, PICTURES};
use crate::ndf::{Form, Lobes};
use crate::output::Request;
use crate::render::{
    Glints, Image, Motion, Pairs, Sampling, Scene, glinting_sequence, grid, render, render_glints, side_by_side,
    tonemap,
};

/// The animations, as [`PICTURES`] has them after the still picture.
const MOVING: [Moving; 3] = [Moving::Texture(Motion::Zoom), Moving::Texture(Motion::Pan), Moving::Light];
/// Texels of level 0 along a pixel in the columns of the still picture.
const DISTANCES: [(f32, &str); 3] =
    [(0.25, "4 pixels a texel"), (2.0, "2 texels a pixel"), (16.0, "16 texels a pixel")];
/// And where the light turns.
const LIT_TEXELS: f32 = 1.0;
/// By which angle it turns, radians.
const TURN: f32 = 0.3;
const MILLISECONDS: u16 = 90;

/// What is drawn.
const SHAPES: [&str; 2] = ["sphere", "panel"];

/// What moves.
#[derive(Clone, Copy)]
enum Moving {
    Texture(Motion),
    Light,
}

pub fn run(args: &GlintArgs, global: &Global, report: &mut Report) -> Result<()> {
    let inputs = read_as(one(args)?, &args.maps, &args.reading)?;
    let options = args.folding.options(false)?;
    // Flakes follow both widths, and want them in a map that hardware may filter.
    let both = options.fold.has_two_widths().then_some(Form::Anisotropic);
    let form = args.folding.form().or(both);
    let mut extras = args.extra.clone();
    if form == Some(Form::Anisotropic) && options.lobes == 1 && !extras.contains(&Extra::Tensor) {
        extras.push(Extra::Tensor);
    }
    let pictures = if args.preview.no_pictures { Vec::new() } else { PICTURES.map(String::from).to_vec() };
    let request = Request { extras, pictures, ..args.containers.request(&args.output, global.force) };
    let draw = |material: &Material, chain: &Chain| draw(material, chain, &args.preview, report);
    let job = Job {
        inputs: &inputs,
        read: &codec::read,
        under: None,
        flakes: Some(&args.flakes),
        draw: (!args.preview.no_pictures).then_some(&draw),
        options: &options,
        form,
        request: &request,
        skip_if_below: None,
    };
    let built = job.run(global.dry_run, &report.progress)?.built;
    report.built(built);
    Ok(())
}

/// The material that is asked for.
fn one(args: &GlintArgs) -> Result<Inputs> {
    let Some(input) = &args.input else { return single(&args.maps, &args.reading, "glint") };
    let mut sets = nearest(input, &args.maps, &args.reading)?;
    if sets.len() > 1 {
        let names: Vec<_> = sets.iter().flatten().map(|set| set.name.as_str()).collect();
        let found = format!("{} materials ({})", sets.len(), names.join(", "));
        return Err(Error::invalid(input, found, "one: name its maps with --normal and --roughness"));
    }
    sets.swap_remove(0)
}

fn glints(flakes: &MaterialFlakes, preview: &PreviewArgs) -> Glints {
    Glints {
        flakes: flakes.about.flakes(),
        evaluator: preview.evaluator,
        light: SolidAngle::of_cone(preview.lamp.to_radians()),
        places: (!flakes.levels.is_empty()).then(|| Pairs::new(&flakes.levels)),
    }
}

/// The files of [`PICTURES`].
fn draw(material: &Material, chain: &Chain, preview: &PreviewArgs, report: &Report) -> Vec<Vec<u8>> {
    report.progress.set_message(format!("drawing {}", material.name));
    let form = chain.levels.first().map_or(Form::Isotropic, |level| level.lobes.form());
    let levels = &levels(material, chain.clone(), form);
    let glints = &glints(material.flakes.as_ref().expect("a material with flakes"), preview);
    let (pixels, frames) = (usize::from(preview.pixels), usize::from(preview.frames));
    let portion = report.portion();
    let scenes = [Scene::lamps(), Scene::lamps_panel()];
    let all = (MOVING.len() * scenes.len()) as f64 + 1.0;
    let mut still_png = Vec::new();
    write_png(&mut still_png, &still(&scenes, levels, glints, pixels)).expect("8-bit colours, in memory");
    portion.show(1.0 / all);
    let mut files = vec![still_png];
    for (k, moving) in MOVING.into_iter().enumerate() {
        let mut panes = Vec::new();
        for (i, scene) in scenes.iter().enumerate() {
            panes.push(sequence(scene, levels, glints, moving, frames, pixels));
            portion.show((1 + k * scenes.len() + i + 1) as f64 / all);
        }
        let sheet = |frame: usize| {
            let panes = panes.iter().zip(&scenes).zip(SHAPES);
            let shown: Vec<_> = panes.map(|((p, s), name)| (name, tonemap(&p[frame], s.exposure))).collect();
            side_by_side(&shown.iter().map(|(name, raster)| (*name, raster)).collect::<Vec<_>>(), 1)
        };
        let mut apng = Vec::new();
        let sheets: Vec<Raster> = (0..frames).map(sheet).collect();
        write_apng(&mut apng, &sheets, MILLISECONDS, 0).expect("frames of one size, in memory");
        files.push(apng);
    }
    files
}

/// Rows: the sphere and the panel. Columns: the smooth material, and its flakes from near to far.
fn still(scenes: &[Scene], levels: &[Lobes], glints: &Glints, pixels: usize) -> Raster {
    let size = levels[0].size();
    let row = |scene: &Scene| {
        let smooth = scene.at_texels(size, DISTANCES[1].0, pixels);
        let smooth = render(&smooth, levels, pixels, Sampling::mips(2));
        let flaky = DISTANCES.map(|(texels, _)| {
            let scene = scene.at_texels(size, texels, pixels);
            render_glints(&scene, levels, pixels, Sampling::mips(2), glints)
        });
        [smooth].iter().chain(&flaky).map(|image| tonemap(image, scene.exposure)).collect()
    };
    let columns: Vec<_> = ["without flakes"].into_iter().chain(DISTANCES.map(|(_, label)| label)).collect();
    grid(&columns, &SHAPES.iter().zip(scenes).map(|(name, scene)| (*name, row(scene))).collect::<Vec<_>>())
}

fn sequence(
    scene: &Scene,
    levels: &[Lobes],
    glints: &Glints,
    moving: Moving,
    frames: usize,
    pixels: usize,
) -> Vec<Image> {
    match moving {
        Moving::Texture(motion) => glinting_sequence(scene, levels, motion, frames, pixels, glints, &|| ()),
        Moving::Light => {
            let scene = scene.at_texels(levels[0].size(), LIT_TEXELS, pixels);
            let turn = |frame: usize| TURN * (frame as f32 / (frames - 1) as f32 - 0.5);
            let draw = |frame| {
                render_glints(&scene.with_lights_turned(turn(frame)), levels, pixels, Sampling::mips(1), glints)
            };
            (0..frames).map(draw).collect()
        }
    }
}
