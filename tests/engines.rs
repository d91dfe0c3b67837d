//! What engines load: textures for GPUs, packings, and builds that need not be done again.

mod common;

use std::fs;
use std::path::Path;

use common::desk::Desk;
use common::{bump, encode8, integers, manifest, mipfold, names, plane, png_levels, png8, read, strings, textures};
use mipfold::codec::read_levels;
use mipfold::image::{Raster, Size};
use serde_json::Value;

/// Normals, roughness, occlusion and metal, each of its own values.
fn set(desk: &Desk, side: usize) {
    let level = |x: usize, y: usize, k: usize| (40 + (x * 7 + y * 3 + 60 * k) % 130) as u8;
    png8(&desk.at("n.png"), (side, side), |x, y| bump(x, y, side).map(encode8).to_vec());
    for (k, name) in ["r", "ao", "m"].into_iter().enumerate() {
        png8(&desk.at(&format!("{name}.png")), (side, side), |x, y| vec![level(x, y, k)]);
    }
}

const SET: &str = "--name wall --normal @n.png --roughness @r.png --occlusion @ao.png --metal @m.png";

fn channel(raster: &Raster, c: usize) -> Vec<i64> {
    let (samples, _) = integers(raster);
    let channels = raster.channels.len();
    samples.into_iter().skip(c).step_by(channels).collect()
}

fn levels_of(path: &Path) -> Vec<Raster> {
    read_levels(path).unwrap().into_iter().map(|level| level.raster).collect()
}

fn map<'a>(manifest: &'a Value, role: &str) -> &'a Value {
    manifest["maps"].as_array().unwrap().iter().find(|map| map["role"] == role).unwrap()
}

/// Unreal reads occlusion, roughness and metal of one map, and green down. Level 0 is the inputs' own values; the others
/// are those of a build without a preset.
#[test]
fn unreal_gets_its_packing_and_its_green() {
    let desk = Desk::empty();
    set(&desk, 64);
    let plain = desk.build("plain", SET);
    let out = desk.build("out", &format!("{SET} --preset unreal"));
    let manifest = manifest(&out);
    assert_eq!(manifest["normal_y"], "directx");
    let file = |role: &str| out.join(&strings(&map(&manifest, role)["files"])[0]);
    let (packed, normal) = (levels_of(&file("roughness")), levels_of(&file("normal")));
    let inputs = ["ao", "r", "m"].map(|name| channel(&read(&desk.at(&format!("{name}.png"))), 0));
    for (c, input) in inputs.iter().enumerate() {
        assert_eq!(&channel(&packed[0], c), input, "channel {c}");
    }
    let green: Vec<i64> = channel(&read(&desk.at("n.png")), 1).into_iter().map(|v| 255 - v).collect();
    assert_eq!((packed.len(), normal.len()), (7, 7));
    assert_eq!(channel(&normal[0], 1), green);
    let (rough, normals) = (png_levels(&plain, "r"), png_levels(&plain, "n"));
    for k in 1..7 {
        assert_eq!(channel(&packed[k], 1), channel(&rough[k], 0), "roughness of level {k}");
        let green: Vec<i64> = channel(&normals[k], 1).into_iter().map(|v| 255 - v).collect();
        assert!(channel(&normal[k], 1).iter().zip(&green).all(|(a, b)| (a - b).abs() <= 1), "green of level {k}");
    }
    // The judge reads the conventions out of the manifest, and finds the same surface.
    let errors = [&plain, &out].map(|folder| mean_errors(&folder.display().to_string()));
    assert_eq!(errors[0].len(), 7);
    assert!(errors[0].iter().zip(&errors[1]).all(|(a, b)| (a - b).abs() < 0.01), "{errors:?}");
}

#[test]
fn unity_gets_smoothness_in_alpha() {
    let desk = Desk::empty();
    set(&desk, 32);
    let out = desk.build("out", &format!("{SET} --preset unity-hdrp"));
    let manifest = manifest(&out);
    let packed = map(&manifest, "smoothness");
    let roles: Vec<_> = packed["channels"].as_array().unwrap().iter().map(|c| c["role"].clone()).collect();
    assert_eq!([&roles[0], &roles[1], &roles[3]], ["metalness", "occlusion", "smoothness"]);
    let level_0 = read(&out.join(&strings(&packed["files"])[0]));
    let smooth: Vec<i64> = channel(&read(&desk.at("r.png")), 0).into_iter().map(|v| 255 - v).collect();
    assert_eq!(channel(&level_0, 3), smooth);
    assert_eq!(channel(&level_0, 1), channel(&read(&desk.at("ao.png")), 0));
    let readme = fs::read_to_string(out.join("README.txt")).unwrap();
    assert!(readme.contains("Mask Map") && names(&out).contains(&"MipfoldMips.cs.txt".into()), "{readme}");
}

/// The older header of DDS, which holds 8-bit RGBA in another order.
#[test]
fn old_readers_get_an_old_header() {
    let desk = Desk::empty();
    set(&desk, 30);
    let out = desk.build("out", &format!("{SET} --preset gltf --resize 4 --format dds --dds9"));
    let bytes = fs::read(out.join("n.dds")).unwrap();
    assert_ne!(&bytes[84..88], b"DX10");
    let plain = desk.build("plain", &format!("{SET} --preset gltf --resize 4 --format dds --compress none"));
    let (old, new) = (levels_of(&out.join("n.dds")), levels_of(&plain.join("n.dds")));
    assert_eq!(old.len(), new.len());
    assert!(old.iter().zip(&new).all(|(a, b)| (0..3).all(|c| channel(a, c) == channel(b, c))));
}

/// What the web loads: UASTC, which has no number of Vulkan's, and its model (166) in the descriptor.
#[test]
fn the_web_gets_uastc() {
    let desk = Desk::empty();
    set(&desk, 32);
    let out = desk.build("out", &format!("{SET} --preset three"));
    assert_eq!(map(&manifest(&out), "normal")["encoding"], "uastc");
    let bytes = fs::read(out.join("n.ktx2")).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let descriptor = word(48) as usize;
    assert_eq!((word(12), bytes[descriptor + 12], levels_of(&out.join("n.ktx2")).len()), (0, 166, 6));
}

/// A packed map that is packed as the engine wants it already stays the file that it was.
#[test]
fn what_fits_already_stays() {
    let desk = Desk::empty();
    set(&desk, 32);
    let (ao, r, m) = (read(&desk.at("ao.png")), read(&desk.at("r.png")), read(&desk.at("m.png")));
    let at = |map: &Raster, x, y| (map.at(x, y, 0) * 255.0).round() as u8;
    png8(&desk.at("wall_orm.png"), (32, 32), |x, y| vec![at(&ao, x, y), at(&r, x, y), at(&m, x, y)]);
    let out = desk.build("out", "--normal @n.png --orm @wall_orm.png --preset gltf --format png");
    assert_eq!(fs::read(out.join("wall_orm_mip0.png")).unwrap(), fs::read(desk.at("wall_orm.png")).unwrap());
    assert_eq!(fs::read(out.join("n_mip0.png")).unwrap(), fs::read(desk.at("n.png")).unwrap());
}

/// Textures of a real material as hardware decodes them: compression costs little beside what is folded in, and shows in
/// what the judge says.
#[test]
fn compressed_builds_are_judged() {
    let Some(textures) = textures() else { return };
    let desk = Desk::empty();
    let small = shrunk(&textures.join("rock058"), &desk);
    let mut errors = Vec::new();
    for (name, more) in [("png", ""), ("bc", "--format ktx2,dds"), ("none", "--format ktx2 --compress none")] {
        let out = desk.build(name, &format!("{small} {more}"));
        let containers: &[&str] = if name == "bc" { &[",container=ktx2", ",container=dds"] } else { &[""] };
        for container in containers {
            let levels = mean_errors(&format!("{}{container}", out.display()));
            errors.push(levels.iter().sum::<f64>() / levels.len() as f64);
        }
    }
    let [png, ktx2, dds, none] = errors[..] else { panic!("{errors:?}") };
    assert!((none - png).abs() < 1e-9, "uncompressed texels are those of the PNGs: {errors:?}");
    assert!((ktx2 - dds).abs() < 1e-9, "both containers hold the same blocks: {errors:?}");
    assert!(ktx2 > none && ktx2 < none + 0.05, "{errors:?}");
}

/// The mean lobe error of each level of a chain.
fn mean_errors(chain: &str) -> Vec<f64> {
    let run = mipfold().args(["compare", chain, "--json", "--subset", "64"]).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let levels = report["chains"][0]["levels"].as_array().unwrap();
    levels.iter().map(|level| level["lobe_error"]["mean"].as_f64().unwrap()).collect()
}

/// A quarter of a material's maps, and the options that name them.
fn shrunk(folder: &Path, desk: &Desk) -> String {
    for (name, role) in [("normal", "normal.jpg"), ("roughness", "roughness.jpg")] {
        let map = read(&folder.join(role));
        let channels = map.channels.len();
        let texel = |x: usize, y: usize| (0..channels).map(|c| (map.at(x, y, c) * 255.0).round() as u8).collect();
        png8(&desk.at(&format!("{name}.png")), (128, 128), texel);
    }
    "--normal @normal.png --roughness @roughness.png".into()
}

/// No decoded normal of a two-channel texture leaves the unit disk, however steep the map is.
#[test]
fn two_channel_normals_leave_room_for_z() {
    let desk = Desk::empty();
    // On the rim and beyond, as noise.
    let side = |x: usize, y: usize, k: usize| (((x * 73 + y * 151 + k * 97) * 2_654_435_761) >> 7) as u8;
    png8(&desk.at("n.png"), (64, 64), |x, y| vec![side(x, y, 1), side(x, y, 2), 140]);
    let out = desk.build("out", "--normal @n.png --roughness 0.5 --format dds");
    for level in levels_of(&out.join("n.dds")) {
        assert_eq!(level.channels.len(), 2);
        let (nx, ny) = (plane(&level, 0), plane(&level, 1));
        let longest = nx.iter().zip(&ny).map(|(x, y)| (2.0 * x - 1.0).hypot(2.0 * y - 1.0)).fold(0.0, f32::max);
        assert!(longest < 1.0, "{longest}");
    }
}

#[test]
fn sides_must_suit_the_blocks_or_are_resized() {
    let desk = Desk::empty();
    set(&desk, 30);
    let message = desk.refuses(&format!("{SET} --format ktx2 -o @out"), "@out/n.ktx2");
    assert!(message.contains("30x30") && message.contains("--resize 4") && message.contains("--compress none"));
    desk.build("free", &format!("{SET} --format ktx2 --compress none"));
    let out = desk.build("out", &format!("{SET} --format ktx2 --resize 4"));
    assert_eq!(levels_of(&out.join("n.ktx2"))[0].size(), Size::new(32, 32));
    let message = desk.refuses(&format!("{SET} --format dds --compress uastc --resize 4 -o @web"), "@web/n.dds");
    assert!(message.contains("UASTC"), "{message}");
}

fn text(desk: &Desk, args: &str) -> String {
    let run = mipfold().arg("build").args(desk.args(args)).output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn what_is_unchanged_is_not_built_again() {
    let desk = Desk::empty();
    set(&desk, 32);
    let args = format!("{SET} -o @out");
    assert!(text(&desk, &args).contains("wrote"));
    let before = desk.tree();
    assert!(text(&desk, &args).contains("unchanged"));
    assert_eq!(desk.tree(), before);
    assert!(text(&desk, &format!("{args} --force")).contains("wrote"));
    // Another date is no other content.
    fs::write(desk.at("r.png"), fs::read(desk.at("r.png")).unwrap()).unwrap();
    assert!(text(&desk, &args).contains("unchanged"));
    // A file of another content, a missing one, other inputs, other options.
    let file = desk.at("out/n_mip1.png");
    let whole = fs::read(&file).unwrap();
    fs::write(&file, &whole[..whole.len() - 1]).unwrap();
    assert!(text(&desk, &args).contains("wrote"));
    assert_eq!(fs::read(&file).unwrap(), whole);
    fs::remove_file(&file).unwrap();
    assert!(text(&desk, &args).contains("wrote"));
    png8(&desk.at("r.png"), (32, 32), |_, _| vec![90]);
    assert!(text(&desk, &args).contains("wrote"));
    assert!(text(&desk, &format!("{args} --strength 0.5")).contains("wrote"));
    assert!(text(&desk, &args).contains("wrote"));
    // What looked wrong still does, and a dry run says that there is nothing to do.
    png8(&desk.at("n.png"), (32, 32), |x, _| if x == 0 { vec![128, 128, 60] } else { vec![128, 128, 255] });
    for _ in 0..2 {
        desk.warns(&args, &["do not point out of the surface"]);
    }
    assert!(text(&desk, &format!("{args} --dry-run")).contains("unchanged"));
}

/// A build that was killed while its files got their names: some have them, some not, and the manifest is the old one.
#[test]
fn what_a_killed_build_left_is_replaced() {
    let desk = Desk::empty();
    set(&desk, 32);
    let out = desk.build("out", &format!("{SET} --preset bevy"));
    fs::rename(out.join("manifest.json"), out.join(".mipfold-commit.json")).unwrap();
    fs::remove_file(out.join("n.ktx2")).unwrap();
    desk.build("out", &format!("{SET} --preset bevy --strength 0.5"));
    assert!(!out.join(".mipfold-commit.json").exists() && out.join("n.ktx2").exists());
    // Where nothing of the kind lies there, the same files are a stranger's.
    fs::remove_file(out.join("manifest.json")).unwrap();
    desk.refuses(&format!("{SET} --preset bevy -o @out"), "did not write");
}

/// Another program keeps the folder: the build waits for a while.
#[cfg(unix)]
#[test]
fn a_locked_folder_is_waited_for() {
    let desk = Desk::empty();
    set(&desk, 16);
    desk.build("out", SET);
    let folder = fs::File::open(desk.at("out")).unwrap();
    folder.lock().unwrap();
    std::thread::scope(|scope| {
        let built = scope.spawn(|| text(&desk, &format!("{SET} -o @out --strength 0.5")));
        std::thread::sleep(std::time::Duration::from_millis(300));
        assert!(!built.is_finished());
        drop(folder);
        assert!(built.join().unwrap().contains("wrote"));
    });
}

/// Pictures are often saved with an alpha that says nothing.
#[test]
fn an_alpha_of_ones_is_not_encoded() {
    let desk = Desk::empty();
    let opaque = |n: [u8; 3]| vec![n[0], n[1], n[2], 255];
    png8(&desk.at("n.png"), (32, 32), |x, y| opaque(bump(x, y, 32).map(encode8)));
    png8(&desk.at("r.png"), (32, 32), |x, y| vec![(x * y % 200) as u8, 255]);
    let out = desk.build("out", "--normal @n.png --roughness @r.png --format ktx2");
    let encodings =
        manifest(&out)["maps"].as_array().unwrap().iter().map(|map| map["encoding"].clone()).collect::<Vec<_>>();
    assert_eq!(encodings, ["bc5", "bc4"]);
    desk.warns("--normal @n.png --roughness @r.png --preset gltf -o @gltf", &[]);
}

/// Channels that an engine's packing has no place for are named, and one channel has one meaning.
#[test]
fn nothing_is_lost_without_a_word() {
    let desk = Desk::empty();
    set(&desk, 16);
    png8(&desk.at("orm.png"), (16, 16), |x, y| vec![x as u8, y as u8 * 9, 77]);
    let warning = ["orm: red and blue left out"];
    desk.warns("--normal @n.png --roughness @orm.png:g --preset gltf --format png -o @out", &warning);
    desk.warns("--normal @n.png --orm @orm.png --preset gltf --format png -o @all", &[]);
    desk.refuses("--normal @n.png --roughness @r.png --occlusion @r.png --preset gltf -o @no", "r.png");
}

/// Engines that read three channels get a z that is one, whatever else lies beside x and y.
#[test]
fn two_channel_normals_get_their_z() {
    let desk = Desk::empty();
    png8(&desk.at("nra.png"), (16, 16), |x, y| {
        let n = bump(x, y, 16).map(encode8);
        vec![n[0], n[1], 90, 33]
    });
    let maps = "--normal @nra.png --normal-z rebuild --roughness @nra.png:b --occlusion @nra.png:a";
    let out = desk.build("out", &format!("{maps} --name wall --preset gltf --format png"));
    let (normal, read) = (read(&out.join("wall_normal_mip0.png")), manifest(&out));
    assert_eq!(map(&read, "normal")["channels"][2]["role"], "normal.z");
    for (x, y) in [(0, 0), (3, 9), (12, 5)] {
        let n = [0, 1, 2].map(|c| 2.0 * normal.at(x, y, c) - 1.0);
        assert!((n.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 0.02, "{n:?}");
    }
}

/// Builds of one folder side by side, of different options: whatever comes last, its files are one build's.
#[test]
fn builds_side_by_side_leave_one_whole_build() {
    let desk = Desk::empty();
    set(&desk, 64);
    let start = |fold: &str| {
        let args = desk.args(&format!("build {SET} -o @out --quiet --fold {fold}"));
        std::process::Command::new(assert_cmd::cargo::cargo_bin("mipfold")).args(args).spawn().unwrap()
    };
    let runs = ["ggx", "lean", "average", "toksvig"].map(start);
    for mut run in runs {
        assert!(run.wait().unwrap().success());
    }
    let fold = manifest(&desk.at("out"))["fold"].as_str().unwrap().to_owned();
    assert!(text(&desk, &format!("{SET} -o @out --fold {fold}")).contains("unchanged"));
}

#[test]
fn a_verdict_says_what_folding_gains() {
    let desk = Desk::empty();
    set(&desk, 32);
    assert!(text(&desk, &format!("{SET} -o @bumpy")).contains("folding changes the roughness by up to 0."));
    png8(&desk.at("flat.png"), (32, 32), |_, _| vec![128, 128, 255]);
    let flat = "--normal @flat.png --roughness 0.6";
    let said = text(&desk, &format!("{flat} -o @flat"));
    assert!(said.contains("nothing to gain"), "{said}");
    let said = text(&desk, &format!("{flat} -o @none --skip-if-below 0.01"));
    assert!(said.contains("skipped") && !desk.at("none").exists(), "{said}");
    // Two directions of one roughness: as mixtures hold them, nothing is rougher, and all is gained.
    png8(&desk.at("groove.png"), (32, 32), |x, _| if x % 2 == 0 { vec![64, 128, 238] } else { vec![191, 128, 238] });
    let said = text(&desk, "--normal @groove.png --roughness 0.2 --lobes 2 -o @groove --skip-if-below 0.1");
    assert!(said.contains("wrote"), "{said}");
    let said = text(&desk, &format!("{SET} -o @kept --skip-if-below 0.01 --json"));
    let json: Value = serde_json::from_str(&said).unwrap();
    let gain = json["materials"][0]["gain"]["roughness"].as_f64().unwrap();
    assert!(gain > 0.05 && desk.at("kept/manifest.json").exists(), "{said}");
}
