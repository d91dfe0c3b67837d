//! What loads our files in earnest: three.js, in a browser with software WebGL.
//!
//! `MIPFOLD_THREE` is the folder of the npm package `three`, `MIPFOLD_CHROMIUM` the Chromium or Chrome to use, by default
//! `chromium`.

mod common;
#[path = "consumers/site.rs"]
mod site;

use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine};
use common::desk::Desk;
use common::model::Scene;
use common::{bump, encode8, manifest, png8, strings};
use mipfold::codec::{read_levels, write_png};
use mipfold::image::Raster;
use mipfold::sample::by_name;
use site::{Seen, open};

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

/// Loads files of a desk with three.js and compares every level, texel for texel, with what our own decoder makes of
/// it: within `tolerance` of 0 to 1. Returns the formats that three.js chose, each once.
fn three_loads(desk: &Desk, files: &[String], plain: bool, tolerance: f32) -> Option<Vec<String>> {
    let plain = if plain { "plain," } else { "" };
    let Seen { found, console } = open(&format!("textures.html?{plain}{}", files.join(",")), &desk.at(""))?;
    assert!(console.is_empty(), "{console:#?}");
    let mut formats = Vec::new();
    for file in files {
        let said = |what: &str| &found[&format!("{file} {what}")];
        let levels = read_levels(&desk.at(file)).unwrap();
        let sizes: Vec<_> = levels.iter().map(|level| level.raster.size()).collect();
        let sizes: Vec<_> = sizes.iter().map(|size| format!("{}x{}", size.width, size.height)).collect();
        assert!(sizes.len() > 5 && sizes.last().is_some_and(|size| size == "1x1"));
        assert_eq!(said("sizes"), &sizes.join(" "), "{file}");
        assert_eq!([said("filter"), said("linear")], ["true", "true"], "{file}");
        for (k, level) in levels.iter().enumerate() {
            let far = farthest(&level.raster, &BASE64_STANDARD.decode(said(&k.to_string())).unwrap());
            assert!(far <= tolerance, "{file}, level {k}: {} / 255", 255.0 * far);
        }
        formats.push(said("format").clone());
    }
    formats.sort();
    formats.dedup();
    Some(formats)
}

/// Within a rounding of what a shader reads of 8 bit.
const ROUNDING: f32 = 1.01 / 255.0;

/// 100 is no power of two, and its third level no multiple of a block.
#[test]
fn three_shows_the_levels_of_our_ktx_2_files() {
    let desk = Desk::empty();
    let set = set(&desk, (100, 36));
    let mut all = Vec::new();
    for compress in ["bc", "none"] {
        let out = desk.build(compress, &format!("{set} --preset three --compress {compress}"));
        all.extend(files(&out, compress));
    }
    assert_eq!(all.len(), 4);
    let Some(formats) = three_loads(&desk, &all, false, ROUNDING) else { return };
    assert_eq!(formats, ["RGBAFormat", "RGBA_BPTC_Format"]);
    // The page is listened to: a file that is not there is heard.
    let Some(Seen { console, .. }) = open("textures.html?nothing.ktx2", &desk.at("")) else { return };
    assert!(console.iter().any(|line| line.contains("404")), "{console:#?}");
}

/// What `sparkle.html` measures of a chain, against the truth.
#[derive(Debug)]
struct Look {
    /// What changes from frame to frame beyond what changes in truth, as a share of the truth's mean radiance.
    flicker: f64,
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
    for sample in ["brushed-metal", "hammered-metal"] {
        let desk = Desk::empty();
        let maps = (by_name(sample).unwrap().make)(256, 1);
        for (name, map) in [("normal.png", &maps.normal), ("orm.png", &maps.orm)] {
            write_png(std::fs::File::create(desk.at(name)).unwrap(), map).unwrap();
        }
        let inputs = "--normal @normal.png --orm @orm.png --preset three --compress none";
        desk.build("mipfold", inputs);
        desk.build("plain", &format!("{inputs} --fold average"));
        let page = "sparkle.html?normal.ktx2,orm.ktx2,plain,mipfold";
        let Some(Seen { found, console }) = open(page, &desk.at("")) else { return };
        assert!(console.is_empty(), "{console:#?}");
        // To look at.
        let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("three-{sample}.png"));
        std::fs::write(picture, BASE64_STANDARD.decode(&found["picture"]).unwrap()).unwrap();
        let [plain, ours] = ["plain", "mipfold"].map(|name| {
            let [flicker, peak, error, light] = numbers(&found[name]);
            Look { flicker, peak, error, light }
        });
        println!("{sample}: truth {}\nplain {plain:?}\nours {ours:?}", found["truth"]);
    }
}

fn numbers<const N: usize>(line: &str) -> [f64; N] {
    let numbers: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
    numbers.try_into().unwrap()
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
    let material = serde_json::json!({
        "normalTexture": { "index": 0 },
        "occlusionTexture": { "index": 1 },
        "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 }, "roughnessFactor": 0.6 },
    });
    let images = [("normal", png(&maps.normal)), ("orm", png(&maps.orm))];
    desk.file("plain.glb", &Scene::new(serde_json::json!([material]), &images, serde_json::json!({})).glb());
    desk.build("folded.glb", "@plain.glb");
    let Some(Seen { found, console }) = open("model.html?plain.glb,folded.glb", &desk.at("")) else { return };
    assert!(console.is_empty(), "{console:#?}");
    assert_eq!(found["folded.glb maps"], "compressed 9, compressed 9, compressed 9");
    let [plain, ours] = ["plain.glb", "folded.glb"].map(|name| numbers::<2>(&found[name])[0]);
    println!("root mean square error of radiance, over its mean: {plain} plain, {ours} folded");
    assert!(ours < 0.5 * plain, "{ours} against {plain}");
}
