//! Other programs read our textures: OpenImageIO our DDS files, three.js with ktx-parse our KTX 2 files.
//!
//! `MIPFOLD_THREE` is the folder of the npm package `three`; `node` runs it.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::strings;
use mipfold::codec::texture::{Effort, TexelFormat, Texture, decode, write_dds, write_ktx2};
use mipfold::image::{Raster, Samples, Size};
use ndarray::Array3;
use serde_json::{Value, json};

const SIZES: [(usize, usize); 2] = [(100, 36), (5, 3)];

fn raster(size: Size, channels: usize) -> Raster {
    let value = |y: usize, x: usize, c: usize| {
        let (x, y, c) = (x as f32, y as f32, c as f32);
        0.5 + 0.3 * (0.05 * x + 0.11 * y + 1.7 * c).sin() + 0.15 * (0.13 * x - 0.07 * y * (1.0 + 0.2 * c)).cos()
    };
    let samples = Array3::from_shape_fn((size.height, size.width, channels), |(y, x, c)| value(y, x, c));
    Raster::new(Samples::F32(samples))
}

fn textures() -> impl Iterator<Item = Texture> {
    TexelFormat::all().flat_map(|format| {
        SIZES.iter().map(move |(width, height)| {
            let size = Size::new(*width, *height);
            let levels: Vec<_> = (0..size.level_count()).map(|k| raster(size.level(k), format.channels())).collect();
            Texture::encode(&levels, format, Effort::Fast)
        })
    })
}

fn sizes(texture: &Texture) -> Value {
    let size = |k| texture.size.level(k);
    (0..texture.levels.len()).map(|k| json!([size(k).width, size(k).height])).collect()
}

#[test]
fn openimageio_reads_our_dds_files_texel_for_texel() {
    let Some(python) = common::python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (path, dump) = (folder.path().join("a.dds"), folder.path().join("a.bin"));
    // The rest of our formats it does not know (OpenImageIO 3.2), and what it has more than 8 bit of it rounds.
    let known = [TexelFormat::Rgba8, TexelFormat::R16, TexelFormat::Bc4, TexelFormat::Bc5, TexelFormat::Bc7];
    let mut count = 0;
    for texture in textures().filter(|texture| known.contains(&texture.format)) {
        write_dds(std::fs::File::create(&path).unwrap(), &texture).unwrap();
        let about = common::script(&python, "exr_dump.py", &[&path, &dump]);
        assert_eq!(about["levels"], sizes(&texture), "{:?}", texture.format);
        assert_eq!(strings(&about["channels"]).len(), texture.format.channels());
        let bytes = std::fs::read(&dump).unwrap();
        let mut floats = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        let tolerance = match texture.format {
            TexelFormat::Rgba8 | TexelFormat::Bc7 => 1e-6,
            _ => 1.01 / 255.0,
        };
        for (k, level) in texture.levels.iter().enumerate() {
            let size = texture.size.level(k);
            let ours = decode(level, size, texture.format);
            for (y, x) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (y, x))) {
                for c in 0..texture.format.channels() {
                    let (ours, theirs) = (ours.at(x, y, c), floats.next().unwrap());
                    let what = format!("{:?} level {k} texel {x} {y} channel {c}", texture.format);
                    assert!((ours - theirs).abs() < tolerance, "{what}: {ours} {theirs}");
                }
            }
        }
        assert_eq!(floats.next(), None);
        count += 1;
    }
    assert_eq!(count, 10);
}

fn three() -> Option<PathBuf> {
    let runs = Command::new("node").arg("--version").output().is_ok_and(|run| run.status.success());
    match std::env::var_os("MIPFOLD_THREE") {
        Some(_) if !runs => common::skip("node does not run"),
        Some(folder) => Some(folder.into()),
        None => common::skip("MIPFOLD_THREE is not set"),
    }
}

#[test]
fn three_reads_our_ktx_2_files_byte_for_byte() {
    let Some(three) = three() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (path, dump) = (folder.path().join("a.ktx2"), folder.path().join("a.bin"));
    let mut count = 0;
    for texture in textures() {
        // three.js r187 has no texture of 16 bit with one or two channels.
        if matches!(texture.format, TexelFormat::R16 | TexelFormat::Rg16) {
            continue;
        }
        for zstd in [false, true] {
            write_ktx2(std::fs::File::create(&path).unwrap(), &texture, zstd).unwrap();
            let about = common::script(Path::new("node"), "ktx2_dump.mjs", &[&three, &path, &dump]);
            assert_eq!(std::fs::read(&dump).unwrap(), texture.levels.concat(), "{:?}", texture.format);
            assert_eq!(about["levels"], sizes(&texture));
            assert_eq!(about["vkFormat"], texture.format.vk_format());
            assert_eq!([&about["pixelWidth"], &about["pixelHeight"]], [texture.size.width, texture.size.height]);
            assert_eq!(about["supercompressionScheme"], if zstd { 2 } else { 0 });
            // No primaries, linear.
            assert_eq!([&about["primaries"], &about["transfer"]], [0, 1]);
            assert_eq!(about["colorSpace"], "");
            let writer = concat!("mipfold ", env!("CARGO_PKG_VERSION"));
            assert_eq!(about["keyValue"], json!({ "KTXorientation": "rd", "KTXwriter": writer }));
            count += 1;
        }
    }
    assert_eq!(count, 40);
}

/// A chain as an engine would load it, normals in BC5 in a KTX 2, the packed map in BC7 in a DDS, is judged all but like its
/// PNGs.
#[test]
fn compressed_chains_are_judged() {
    let desk = common::desk::Desk::new();
    common::png8(&desk.at("orm.png"), (64, 64), |x, y| vec![255, (60 + x + y) as u8, 0]);
    desk.build("out", "--normal @n.png --orm @orm.png");
    let texture =
        |stem: &str, format| Texture::encode(&common::png_levels(&desk.at("out"), stem), format, Effort::Slow);
    let file = |name: &str| std::fs::File::create(desk.at(name)).unwrap();
    write_ktx2(file("n.ktx2"), &texture("n", TexelFormat::Bc5), true).unwrap();
    write_dds(file("orm.dds"), &texture("orm", TexelFormat::Bc7)).unwrap();
    let args =
        "compare @out normal=@n.ktx2,roughness=@orm.dds:g --texels 16 --directions 16 --no-plain --no-motion --json";
    let run = common::mipfold().args(desk.args(args)).output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let error =
        |chain: usize, level: usize| report["chains"][chain]["levels"][level]["lobe_error"]["mean"].as_f64().unwrap();
    assert_eq!(report["chains"][1]["levels"].as_array().unwrap().len(), 7);
    for level in 1..5 {
        let (png, compressed) = (error(0, level), error(1, level));
        assert!((compressed - png).abs() < 0.1 && compressed != png, "level {level}: {compressed} for {png}");
    }
}
