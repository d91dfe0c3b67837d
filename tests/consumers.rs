//! What loads our files in earnest: three.js and PlayCanvas, in a browser with software WebGL.
//!
//! Babylon.js is not run: its decoder of KTX 2 is in no npm package (9.35.0 loads it from its own servers), and of plain DDS
//! files it makes the levels anew.
//!
//! `MIPFOLD_THREE` is the folder of the npm package `three`, with `playcanvas` beside it, `MIPFOLD_CHROMIUM` the Chromium or Chrome to use, by default
//! `chromium`.

#![allow(clippy::print_stderr)]

mod common;

use std::collections::BTreeMap;
use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine};
use common::browser::{Seen, Site, below, beside_three, chromium, three};
use common::desk::Desk;
use common::model::Scene;
use common::{bump, encode8, manifest, or_skip, png8, strings};
use mipfold::codec::{read_levels, write_png};
use mipfold::image::Raster;
use mipfold::sample::by_name;
use serde_json::json;

/// Runs a module of `tests/consumers` with words for it, while `/files/` is the desk. Nothing if there is no browser or
/// an engine is missing.
fn open(module: &str, words: &[&str], desk: &Desk) -> Option<Seen> {
    let (three, playcanvas) = (or_skip(three())?, or_skip(beside_three("playcanvas"))?);
    let chromium = or_skip(chromium())?;
    let files = desk.at("");
    let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/consumers");
    let folders = [("/three/", three), ("/playcanvas/", playcanvas), ("/files/", files), ("/", pages)];
    let site = Site::new(move |path| folders.iter().find_map(|(prefix, folder)| below(folder, prefix, path)));
    Some(site.open(&chromium, &format!("page.html?{},{}", module, words.join(","))))
}

/// Normals, roughness, occlusion and metal, each of its own values.
fn set(desk: &Desk, size: (usize, usize)) -> String {
    let level = |x: usize, y: usize, k: usize| (40 + (x * 7 + y * 3 + 60 * k) % 130) as u8;
    png8(&desk.at("n.png"), size, |x, y| bump(x, y, size.0).map(encode8).to_vec());
    for (k, name) in ["r", "ao", "m"].into_iter().enumerate() {
        png8(&desk.at(&format!("{name}.png")), size, |x, y| vec![level(x, y, k)]);
    }
    "--normal @n.png --roughness @r.png --occlusion @ao.png --metal @m.png".into()
}

/// The files of a build that hold all levels, below the desk.
fn files(folder: &Path, name: &str) -> Vec<String> {
    let maps = manifest(folder)["maps"].as_array().unwrap().clone();
    maps.iter().flat_map(|map| strings(&map["files"])).map(|file| format!("{name}/{file}")).collect()
}

/// How far texels read in a shader, RGBA of 8 bit, are from ours at most. Channels that a file lacks are 0, alpha is 1.
fn farthest(ours: &Raster, texels: &[u8]) -> f32 {
    let (size, channels) = (ours.size(), ours.channels.len());
    assert_eq!(texels.len(), 4 * size.texels());
    let theirs = |i: usize, c: usize| f32::from(texels[4 * i + c]) / 255.0;
    let ours = |i: usize, c: usize| match c {
        c if c < channels => ours.at(i % size.width, i / size.width, c),
        3 => 1.0,
        _ => 0.0,
    };
    (0..size.texels()).flat_map(|i| (0..4).map(move |c| (ours(i, c) - theirs(i, c)).abs())).fold(0.0, f32::max)
}

/// Compares every level that a page found of a file, texel for texel, with what our own decoder makes of it: within
/// `tolerance` of 0 to 1. Returns the format that three.js chose.
fn checked(desk: &Desk, found: &BTreeMap<String, String>, file: &str, tolerance: f32) -> String {
    let said = |what: &str| &found[&format!("{file} {what}")];
    let levels = read_levels(&desk.at(file.trim_start_matches("plain:"))).unwrap();
    let sizes: Vec<_> = levels.iter().map(|level| level.raster.size()).collect();
    let sizes: Vec<_> = sizes.iter().map(|size| format!("{}x{}", size.width, size.height)).collect();
    assert!(sizes.len() > 5 && sizes.last().is_some_and(|size| size == "1x1"));
    assert_eq!(said("sizes"), &sizes.join(" "), "{file}");
    assert_eq!([said("filter"), said("linear")], ["true", "true"], "{file}");
    for (k, level) in levels.iter().enumerate() {
        let far = farthest(&level.raster, &BASE64_STANDARD.decode(said(&k.to_string())).unwrap());
        assert!(far <= tolerance, "{file}, level {k}: {} / 255", 255.0 * far);
    }
    said("format").clone()
}

/// Within a rounding of what a shader reads of 8 bit.
const ROUNDING: f32 = 1.01 / 255.0;
/// Most that UASTC's values change by where they become BC7.
const TRANSCODED: f32 = 8.01 / 255.0;

/// 100 is no power of two, and its third level no multiple of a block.
#[test]
fn three_shows_the_levels_of_our_textures() {
    let desk = Desk::empty();
    let set = set(&desk, (100, 36));
    let build = |name: &str, more: &str| files(&desk.build(name, &format!("{set} {more}")), name);
    let uastc = build("uastc", "--preset three");
    let mut all = Vec::new();
    for (name, more, formats) in [
        ("bc", "--preset three --compress bc", &["RGBA_BPTC_Format"; 2][..]),
        ("apart", "--format ktx2", &["RED_GREEN_RGTC2_Format", "RED_RGTC1_Format"]),
        ("none", "--preset three --compress none", &["RGBAFormat"; 2]),
        ("dds", "--preset three --format dds --dds9", &["RGBAFormat"; 2]),
    ] {
        let files = build(name, more);
        assert!(files.len() >= 2 && uastc.len() == 2, "{files:?}");
        all.extend(files.into_iter().zip(formats).map(|(file, format)| (file, *format, ROUNDING)));
    }
    // UASTC: exact where it is unpacked; where it is transcoded into what the hardware has, that may cost a little.
    all.extend(uastc.iter().map(|file| (format!("plain:{file}"), "RGBAFormat", ROUNDING)));
    all.extend(uastc.into_iter().map(|file| (file, "RGBA_BPTC_Format", TRANSCODED)));
    let names: Vec<_> = all.iter().map(|(file, ..)| file.as_str()).collect();
    let Some(Seen { found, console }) = open("textures", &names, &desk) else {
        return;
    };
    assert!(console.is_empty(), "{console:#?}");
    for (file, format, tolerance) in &all {
        assert_eq!(&checked(&desk, &found, file, *tolerance), format, "{file}");
    }
    // The page is listened to: a file that is not there is heard.
    let Seen { console, .. } = open("textures", &["nothing.ktx2"], &desk).unwrap();
    assert!(console.iter().any(|line| line.contains("404")), "{console:#?}");
}

/// UASTC becomes ASTC there, which holds it as it is.
#[test]
fn playcanvas_shows_the_levels_of_our_textures() {
    let desk = Desk::empty();
    let set = set(&desk, (100, 36));
    let files = files(&desk.build("out", &format!("{set} --preset playcanvas")), "out");
    assert_eq!(files.len(), 2);
    let names: Vec<_> = files.iter().map(String::as_str).collect();
    let Some(Seen { found, console }) = open("playcanvas", &names, &desk) else { return };
    assert!(console.is_empty(), "{console:#?}");
    for file in &files {
        assert_eq!(checked(&desk, &found, file, ROUNDING), "ASTC_4x4", "{file}");
    }
}

/// What `sparkle.js` measures of a chain, against the truth.
#[derive(Debug)]
struct Look {
    /// What changes from frame to frame beyond what changes in truth, as a share of the truth's mean radiance.
    flicker: f64,
    /// What changes from frame to frame, over what changes in truth.
    change: f64,
    /// Radiance of the brightest pixel of a thousand, over the truth's.
    peak: f64,
    /// Root mean square error of radiance, as a share of the mean.
    error: f64,
    /// Radiance over the truth's.
    light: f64,
}

/// A material far away, as three.js draws it with our mips and with plain ones.
#[test]
fn three_draws_less_sparkle_with_our_mips() {
    let desk = Desk::empty();
    let maps = (by_name("hammered-metal").unwrap().make)(256, 1);
    for (name, map) in [("normal.png", &maps.normal), ("orm.png", &maps.orm)] {
        write_png(std::fs::File::create(desk.at(name)).unwrap(), map).unwrap();
    }
    let inputs = "--normal @normal.png --orm @orm.png --preset three --compress none";
    desk.build("mipfold", inputs);
    desk.build("plain", &format!("{inputs} --fold average"));
    let words = ["normal.ktx2", "orm.ktx2", "plain", "mipfold"];
    let Some(Seen { found, console }) = open("sparkle", &words, &desk) else { return };
    assert!(console.is_empty(), "{console:#?}");
    keep("three-sparkle", &found);
    let [plain, ours] = ["plain", "mipfold"].map(|name| {
        let [flicker, change, peak, error, light] = numbers(&found[name]);
        Look { flicker, change, peak, error, light }
    });
    eprintln!("three.js, far away: truth {}\n  plain {plain:?}\n  mipfold {ours:?}", found["truth"]);
    assert!(ours.flicker < 0.6 * plain.flicker && ours.error < 0.5 * plain.error, "{ours:?}, {plain:?}");
    assert!(ours.change < 1.0 && plain.change > 1.5, "{ours:?}, {plain:?}");
    assert!((0.6..1.3).contains(&ours.peak) && plain.peak > 2.0, "{ours:?}, {plain:?}");
    assert!((ours.light - 1.0).abs() < 0.3, "{ours:?}, {plain:?}");
}

fn numbers<const N: usize>(line: &str) -> [f64; N] {
    let numbers: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

/// Builds a model and draws it with three.js before and after: it looks as it did, within `most` of its mean radiance,
/// and what was folded comes compressed, with all its levels.
fn three_loads_a_model(desk: &Desk, model: &str, most: f64) {
    common::build([desk.at(&format!("{model}.glb"))], &desk.at(&format!("{model}-out.glb")));
    let files = [model, &format!("{model}-out")].map(|name| format!("{name}.glb"));
    let Some(Seen { found, console }) = open("models", &files.each_ref().map(String::as_str), desk) else { return };
    assert!(console.is_empty(), "{console:#?}");
    keep(&format!("three-model-{model}"), &found);
    eprintln!("three.js, {model}: {} apart, of {}; {}", found["far"], found["light"], found["textures"]);
    let [far, light] = ["far", "light"].map(|key| found[key].parse::<f64>().unwrap());
    assert!(far < most && light > 0.1, "{model}: {far} of {light}");
    for slot in ["normalMap", "roughnessMap", "metalnessMap"] {
        let mut of_slot = found["textures"].split("; ").filter(|texture| texture.contains(slot)).peekable();
        assert!(of_slot.peek().is_some(), "{model}: no {slot}");
        for texture in of_slot {
            let (rest, side) = texture.rsplit_once(' ').unwrap();
            let all = side.parse::<u32>().unwrap().ilog2() + 1;
            assert!(rest.ends_with(&format!("{slot} compressed {all}")), "{model}: {texture}");
        }
    }
}

/// A square whose texels are larger than pixels.
#[test]
fn three_loads_our_models() {
    let desk = Desk::empty();
    let png =
        |texel: &dyn Fn(usize, usize) -> Vec<u8>| std::fs::read(png8(&desk.at("map.png"), (64, 64), texel)).unwrap();
    let normals = png(&|x, y| bump(x, y, 32).map(encode8).to_vec());
    let orm = png(&|x, y| vec![200 + (x % 7) as u8, 60 + (2 * y) as u8, if x > y { 255 } else { 0 }]);
    let colours = png(&|x, y| vec![4 * x as u8, 4 * y as u8, 77]);
    let material = json!({
        "name": "wall",
        "normalTexture": { "index": 0 },
        "occlusionTexture": { "index": 1 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 2 }, "metallicRoughnessTexture": { "index": 1 } },
    });
    let scene = Scene::new(json!([material]), &[("n", normals), ("orm", orm), ("colour", colours)], json!({}));
    desk.file("wall.glb", &scene.glb());
    three_loads_a_model(&desk, "wall", 0.05);
}

#[test]
#[ignore = "two maps of 2048 x 2048 are compressed, which takes 20 s of one core at opt-level 1"]
fn three_loads_a_real_model() {
    let Some(textures) = common::textures() else { return };
    let desk = Desk::empty();
    std::fs::copy(textures.join("glb_normal_tangent_test/NormalTangentTest.glb"), desk.at("test.glb")).unwrap();
    three_loads_a_model(&desk, "test", 0.12);
}

/// Keeps the picture of a page to look at, below the build folder.
fn keep(name: &str, found: &BTreeMap<String, String>) {
    let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
    std::fs::write(picture, BASE64_STANDARD.decode(&found["picture"]).unwrap()).unwrap();
}

/// A glTF model far away, before and after.
#[test]
fn three_loads_folded_models_and_draws_nearer_to_the_truth() {
    let desk = Desk::empty();
    let maps = (by_name("hammered-metal").unwrap().make)(256, 1);
    let png = |raster: &Raster| {
        let mut bytes = Vec::new();
        write_png(&mut bytes, raster).unwrap();
        bytes
    };
    let material = json!({
        "normalTexture": { "index": 0 },
        "occlusionTexture": { "index": 1 },
        "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 }, "roughnessFactor": 0.6 },
    });
    let images = [("normal", png(&maps.normal)), ("orm", png(&maps.orm))];
    desk.file("plain.glb", &Scene::new(json!([material]), &images, json!({})).glb());
    desk.build("folded.glb", "@plain.glb");
    let Some(Seen { found, console }) = open("far", &["plain.glb", "folded.glb"], &desk) else { return };
    assert!(console.is_empty(), "{console:#?}");
    assert_eq!(found["folded.glb maps"], "compressed 9, compressed 9, compressed 9");
    let [plain, ours] = ["plain.glb", "folded.glb"].map(|name| numbers::<2>(&found[name])[0]);
    eprintln!("root mean square error of radiance, over its mean: {plain} plain, {ours} folded");
    assert!(ours < 0.5 * plain, "{ours} against {plain}");
}
