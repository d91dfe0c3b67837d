//! Draws a metal sphere that moves away from the camera, textured with what `mipfold build` wrote, in four panes side by
//! side: plain mips, folded mips, folded mips with curvature filtering, and the truth. Figures are printed for each
//! distance.
//!
//! ```text
//! mipfold build textures/wall -o wall
//! cargo run --release --manifest-path tests/gpu/Cargo.toml --example zooming_sphere -- wall -o zoom.png
//! ```
//!
//! - *Plain mips* are means of level 0, as engines make them.
//! - *Curvature* adds the curvature of the mesh under a pixel to the roughness: `footprint` of the shader helpers, as in the
//!   README.
//! - *The truth* is the mean of many rays a pixel, at level 0 without mips. They lie equally close on the sphere at all
//!   distances.
//!
//! Where the grain of a normal map is a texel or two, the GPU's interpolation at level 0 smooths the truth; `--nearest` takes
//! texels as a fold takes them. Normals see curvature at the rim that no light does, and it glows a little; `--half-vectors`
//! costs more and does not.
//!
//! The sphere fills its pane at every distance: far ones are drawn with few pixels and enlarged, so that these can be seen.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use mipfold_gpu_tests::gpu::gpu;

mod folder;
#[path = "../../../../src/render/font.rs"]
mod font;
mod maps;
mod measure;
mod renderer;
mod scene;
mod sequence;
mod show;
#[cfg(test)]
mod tests;

use renderer::{Curvature, Lookup, Renderer};
use scene::Scene;
use sequence::Sequence;

const USAGE: &str = "\
Usage: zooming_sphere [OPTIONS] FOLDER

FOLDER is what `mipfold build -o FOLDER` wrote, or `mips` of a demo

  -o FILE          where the animated PNG goes [default: zooming-sphere.png]
  --frames N       frames at each distance, 2 to 100 [default: 10]
  --turn DEGREES   turn of the sphere from frame to frame [default: 1.5]
  --rays N         rays of the truth along a side of a pixel, nearest sphere, 1 to 64 [default: 16]
  --repeats N      repeats of the texture around the sphere, 1 to 100 [default: 3]
  --anisotropic N  probes of anisotropic filtering, 1 to 16; 1 is trilinear [default: 1]
  --half-vectors   curvature as half vectors see it, for each light, in place of normals
  --nearest        the truth sees single texels, and not what is interpolated between them
  --stills         write the first frame of each distance beside FILE as well
";

/// What the command line says.
struct Arguments {
    folder: PathBuf,
    out: PathBuf,
    stills: bool,
    repeats: u32,
    lookup: Lookup,
    sequence: Sequence,
}

/// Nothing where help was asked for.
fn arguments() -> Result<Option<Arguments>, Box<dyn Error>> {
    let (mut folder, mut out) = (None, PathBuf::from("zooming-sphere.png"));
    let (mut stills, mut repeats, mut sequence) = (false, 3, Sequence::default());
    let mut lookup = Lookup { anisotropic: 1, nearest: false };
    let mut given = std::env::args_os().skip(1);
    while let Some(argument) = given.next() {
        let name = argument.to_string_lossy().into_owned();
        let mut value = || given.next().ok_or_else(|| format!("{name}: no value"));
        let number = |value: std::ffi::OsString, low: f32, high: f32| -> Result<f32, String> {
            let number = value.to_str().and_then(|v| v.parse().ok()).filter(|v| (low..=high).contains(v));
            number.ok_or_else(|| format!("{name}: {} is no number from {low} to {high}", value.display()))
        };
        match name.as_str() {
            "-h" | "--help" => return Ok(None),
            "-o" | "--output" => out = value()?.into(),
            "--frames" => sequence.frames = number(value()?, 2.0, 100.0)? as usize,
            "--turn" => sequence.turn = number(value()?, 0.0, 360.0)?,
            "--rays" => sequence.rays = number(value()?, 1.0, 64.0)? as u32,
            "--repeats" => repeats = number(value()?, 1.0, 100.0)? as u32,
            "--anisotropic" => lookup.anisotropic = number(value()?, 1.0, 16.0)? as u16,
            "--half-vectors" => sequence.curvature = Curvature::HalfVectors,
            "--nearest" => lookup.nearest = true,
            "--stills" => stills = true,
            _ if name.starts_with('-') => return Err(format!("unknown option {name}\n\n{USAGE}").into()),
            _ if folder.is_some() => return Err("more than one folder".into()),
            _ => folder = Some(argument.into()),
        }
    }
    let folder = folder.ok_or_else(|| format!("no folder\n\n{USAGE}"))?;
    Ok(Some(Arguments { folder, out, stills, repeats, lookup, sequence }))
}

fn run() -> Result<(), Box<dyn Error>> {
    let Some(arguments) = arguments()? else {
        say(USAGE);
        return Ok(());
    };
    // Drawing takes minutes: better to complain before.
    if let Some(parent) = arguments.out.parent().filter(|p| !p.as_os_str().is_empty() && !p.is_dir()) {
        return Err(format!("{}: no such folder", parent.display()).into());
    }
    let (name, folded) = folder::read(&arguments.folder)?;
    let gpu = gpu().ok_or("no Vulkan device: install its driver, or Mesa's software one (mesa-vulkan-drivers)")?;
    // A mirrored texture repeats every second time.
    let repeats = if folded.mirrored { arguments.repeats.next_multiple_of(2) } else { arguments.repeats };
    let renderer = Renderer::new(gpu, Scene::new(repeats))?;
    let plain = renderer.upload(&folded.with_plain_mips(), arguments.lookup)?;
    let folded = renderer.upload(&folded, arguments.lookup)?;
    say(&format!("{name}, on {}\n\n{}", gpu.name, sequence::HEADING));

    let (mut frames, mut exposure) = (Vec::new(), None);
    for &shrunk in sequence::SHRUNK {
        let drawn = arguments.sequence.at(&renderer, &plain, &folded, shrunk)?;
        say(&drawn.row());
        let exposure = *exposure.get_or_insert_with(|| drawn.exposure());
        frames.extend(drawn.frames(exposure));
    }
    say(sequence::FOOTNOTE);
    show::write(&arguments.out, &frames, 120)?;
    if arguments.stills {
        for (frame, shrunk) in frames.iter().step_by(arguments.sequence.frames).zip(sequence::SHRUNK) {
            let name = arguments.out.file_stem().unwrap_or_default().to_string_lossy();
            let path = arguments.out.with_file_name(format!("{name}_{shrunk}.png"));
            show::write(&path, std::slice::from_ref(frame), 0)?;
        }
    }
    say(&format!("\nFrom left to right: {}.\n{}\n", sequence::CAPTIONS.join(", "), arguments.out.display()));
    Ok(())
}

/// Prints, line by line as they come.
fn say(text: &str) {
    use std::io::Write;
    let mut out = std::io::stdout();
    // Whoever closes the pipe has read enough.
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            use std::io::Write;
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(2)
        }
    }
}
