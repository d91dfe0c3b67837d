//! What integration tests share: where the real textures and OpenImageIO are, the binary, and small pictures.
//!
//! | variable | what |
//! |---|---|
//! | `MIPFOLD_TEXTURES` | folder of real textures; default `../shared/textures` beside the package |
//! | `MIPFOLD_MESHES` | folder of real meshes; default `../shared/meshes` |
//! | `MIPFOLD_PYTHON` | a Python that imports OpenImageIO, numpy and flip_evaluator; default `python3` |
//! | `MIPFOLD_CHROMIUM` | a Chromium or Chrome; default `chromium` |
//! | `MIPFOLD_THREE` | the folder of the npm package three, playcanvas beside it; no default |
//! | `MIPFOLD_VALIDATOR` | the folder of the npm package gltf-validator; default beside three |
//! | `MIPFOLD_NO_SKIP` | if set, a test fails where it lacks one of these, and is not skipped |
#![allow(dead_code, clippy::print_stderr)]

pub mod browser;
pub mod desk;
pub mod mesh;
pub mod model;

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use mipfold::codec::{self, Channel, Depth};
use mipfold::image::{Raster, Samples, Size, Wrap};
use mipfold::material::{Inputs, Material, RoughnessInput, load_with};
use mipfold::roughness::Alpha;
use mipfold::sample::Sample;
use ndarray::Array3;
use serde_json::Value;

pub fn skip<T>(why: &str) -> Option<T> {
    assert!(std::env::var_os("MIPFOLD_NO_SKIP").is_none(), "MIPFOLD_NO_SKIP is set, but {why}");
    eprintln!("SKIPPED: {why}");
    None
}

/// What is there; without it a test is skipped.
pub fn or_skip<T>(found: Result<T, String>) -> Option<T> {
    found.map_or_else(|why| skip(&why), Some)
}

/// The folder of real textures.
pub fn textures() -> Option<PathBuf> {
    shared("textures", "MIPFOLD_TEXTURES")
}

/// The folder of real meshes.
pub fn meshes() -> Option<PathBuf> {
    shared("meshes", "MIPFOLD_MESHES")
}

fn shared(what: &str, variable: &str) -> Option<PathBuf> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(what);
    let folder = std::env::var_os(variable).map_or_else(default, PathBuf::from);
    if folder.join("MANIFEST.md").is_file() {
        Some(folder)
    } else {
        skip(&format!("no {what} at {} ({variable})", folder.display()))
    }
}

/// A Python that imports OpenImageIO.
pub fn python() -> Option<PathBuf> {
    python_with(&["OpenImageIO", "numpy"])
}

/// A Python that imports these packages.
pub fn python_with(packages: &[&str]) -> Option<PathBuf> {
    let python = PathBuf::from(std::env::var_os("MIPFOLD_PYTHON").unwrap_or_else(|| "python3".into()));
    let check = std::process::Command::new(&python).args(["-c", &format!("import {}", packages.join(", "))]).output();
    if check.is_ok_and(|check| check.status.success()) {
        Some(python)
    } else {
        skip(&format!("{} does not import {} (MIPFOLD_PYTHON)", python.display(), packages.join(" and ")))
    }
}

/// Runs a script of `tests/interop` and returns the JSON that it prints.
pub fn script(python: &Path, name: &str, args: &[&Path]) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop").join(name);
    let run = std::process::Command::new(python).arg(script).args(args).output().unwrap();
    assert!(run.status.success(), "{name}: {}", String::from_utf8_lossy(&run.stderr));
    serde_json::from_slice(&run.stdout).unwrap()
}

pub fn mipfold() -> Command {
    let mut command = Command::cargo_bin("mipfold").unwrap();
    command.env("RUST_BACKTRACE", "0");
    command
}

/// `mipfold build ARGS -o FOLDER`, which must end with exit code 0 and print nothing to stderr but warnings.
pub fn build<A: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = A>, folder: &Path) -> Output {
    let run = mipfold().arg("build").args(args).arg("-o").arg(folder).output().unwrap();
    let stderr = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(0), "{stderr}");
    assert!(stderr.lines().all(|line| line.starts_with("warning: ")), "{stderr}");
    run
}

pub fn manifest(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap()
}

/// Strings of a JSON list.
pub fn strings(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|v| v.as_str().unwrap().to_owned()).collect()
}

/// Names in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

pub fn read(path: &Path) -> Raster {
    codec::read(path).unwrap_or_else(|e| panic!("{e}")).raster
}

/// All levels of a map that was written as one PNG a level.
pub fn png_levels(folder: &Path, stem: &str) -> Vec<Raster> {
    let path = |k: usize| folder.join(format!("{stem}_mip{k}.png"));
    let levels: Vec<_> = (0..).map(path).take_while(|path| path.exists()).map(|path| read(&path)).collect();
    assert!(!levels.is_empty(), "no {stem}_mip0.png in {}", folder.display());
    levels
}

pub fn exr_levels(path: &Path) -> Vec<Raster> {
    codec::read_exr_levels(path).unwrap_or_else(|e| panic!("{e}"))
}

/// A channel of a mip-mapped EXR by its name.
pub fn channel(raster: &Raster, name: &str) -> Vec<f32> {
    let c = raster.channels.iter().position(|n| n == name).unwrap_or_else(|| panic!("{:?}", raster.channels));
    plane(raster, c)
}

/// A channel: integers scaled to 0..1, floats as they are.
pub fn plane(raster: &Raster, channel: usize) -> Vec<f32> {
    let Size { width, height } = raster.size();
    let mut out = vec![0.0; width * height];
    out.chunks_exact_mut(width).enumerate().for_each(|(y, row)| raster.read(channel, y, 0, row));
    out
}

/// Samples of an integer raster, texel by texel, and the largest one possible.
pub fn integers(raster: &Raster) -> (Vec<i64>, i64) {
    match &raster.samples {
        Samples::U8(s) => (s.iter().map(|v| i64::from(*v)).collect(), 255),
        Samples::U16(s) => (s.iter().map(|v| i64::from(*v)).collect(), 65535),
        Samples::F32(_) => panic!("a float raster"),
    }
}

/// Averages over the exact footprints of a smaller level: each texel by the area that it shares.
pub fn shrink(values: &[f32], from: Size, to: Size) -> Vec<f64> {
    let across = |i: usize, n: usize, m: usize| -> Vec<(usize, f64)> {
        let (low, high) = (i as f64 * n as f64 / m as f64, (i + 1) as f64 * n as f64 / m as f64);
        let share = |j: usize| high.min((j + 1) as f64) - low.max(j as f64);
        (low as usize..(high.ceil() as usize).min(n)).map(|j| (j, share(j) / (high - low))).collect()
    };
    let columns: Vec<_> = (0..to.width).map(|x| across(x, from.width, to.width)).collect();
    let narrow: Vec<Vec<f64>> = values
        .chunks_exact(from.width)
        .map(|row| columns.iter().map(|taps| taps.iter().map(|(j, w)| w * f64::from(row[*j])).sum()).collect())
        .collect();
    let mut out = Vec::with_capacity(to.texels());
    for y in 0..to.height {
        let taps = across(y, from.height, to.height);
        out.extend((0..to.width).map(|x| taps.iter().map(|(j, w)| w * narrow[*j][x]).sum::<f64>()));
    }
    out
}

/// Writes an 8-bit PNG of 1 to 4 channels.
pub fn png8(path: &Path, (width, height): (usize, usize), texel: impl Fn(usize, usize) -> Vec<u8>) -> PathBuf {
    let samples: Vec<u8> = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
    let channels = samples.len() / (width * height);
    write_png(path, Samples::U8(Array3::from_shape_vec((height, width, channels), samples).unwrap()))
}

/// Writes a 16-bit PNG of 1 to 4 channels.
pub fn png16(path: &Path, (width, height): (usize, usize), texel: impl Fn(usize, usize) -> Vec<u16>) -> PathBuf {
    let samples: Vec<u16> = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
    let channels = samples.len() / (width * height);
    write_png(path, Samples::U16(Array3::from_shape_vec((height, width, channels), samples).unwrap()))
}

fn write_png(path: &Path, samples: Samples) -> PathBuf {
    let mut bytes = Vec::new();
    codec::write_png(&mut bytes, &Raster::new(samples)).unwrap();
    std::fs::write(path, bytes).unwrap();
    path.to_owned()
}

/// Writes a 32-bit EXR whose levels all sample `texel(x, y, channel)`.
pub fn exr32(
    path: &Path,
    (width, height): (usize, usize),
    channels: &[&str],
    texel: impl Fn(usize, usize, usize) -> f32 + Sync,
) -> PathBuf {
    let channels: Vec<_> =
        channels.iter().map(|name| Channel { name: (*name).to_owned(), depth: Depth::Float }).collect();
    let file = std::fs::File::create(path).unwrap();
    codec::write_exr(file, &channels, Size::new(width, height), Wrap::Repeat, &|_, c, y, x, out| {
        out.iter_mut().enumerate().for_each(|(i, out)| *out = texel(x + i, y, c));
    })
    .unwrap();
    path.to_owned()
}

/// A bumpy unit normal, z above 0.7, that repeats after `period` texels.
pub fn bump(x: usize, y: usize, period: usize) -> [f32; 3] {
    let phase = |i: usize, k: f32| (i % period) as f32 / period as f32 * k * std::f32::consts::TAU;
    let (nx, ny) = (0.4 * phase(x, 1.0).sin() + 0.1 * phase(y, 3.0).cos(), 0.3 * (phase(y, 2.0) + phase(x, 1.0)).sin());
    [nx, ny, (1.0 - nx * nx - ny * ny).sqrt()]
}

/// A component of a normal as 8 bits hold it.
pub fn encode8(v: f32) -> u8 {
    ((0.5 + 0.5 * v) * 255.0).round() as u8
}

/// A normal map of bumps.
pub fn bumps(path: &Path, size: (usize, usize)) -> PathBuf {
    png8(path, size, |x, y| bump(x, y, size.0.max(size.1)).map(encode8).to_vec())
}

/// The bumps of a sample, of one width everywhere, under the renderer's normal scale.
pub fn sample_of_width(sample: &Sample, side: usize, alpha: Alpha, normal_scale: f32) -> Material {
    let maps = (sample.make)(side, 1);
    let inputs = Inputs {
        name: sample.name.into(),
        normal: Some("normal.png".into()),
        roughness: RoughnessInput::Constant(alpha.perceptual()),
        normal_scale: Some(normal_scale),
        ..Inputs::default()
    };
    load_with(&inputs, &|path| {
        let mut bytes = Vec::new();
        codec::write_png(&mut bytes, &maps.normal).unwrap();
        codec::decode(path, bytes)
    })
    .unwrap()
}

/// A map of a manifest.
pub fn entry<'a>(manifest: &'a Value, role: &str, container: &str) -> &'a Value {
    let maps = manifest["maps"].as_array().unwrap();
    maps.iter().find(|map| map["role"] == role && map["container"] == container).unwrap()
}

/// The levels of the files of a map.
pub fn levels(folder: &Path, files: &Value) -> Vec<Raster> {
    let files = strings(files);
    if let [file] = &files[..] {
        return exr_levels(&folder.join(file));
    }
    let stem = files[0].strip_suffix("_mip0.png").unwrap();
    png_levels(folder, stem)
}
