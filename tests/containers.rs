//! Other programs read our textures: OpenImageIO our DDS files, three.js with ktx-parse our KTX 2 files, Basis Universal's
//! transcoder those of UASTC.
//!
//! `MIPFOLD_THREE` is the folder of the npm package `three`; `node` runs it.

mod common;
#[path = "containers/hints.rs"]
mod hints;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::strings;
use mipfold::codec::texture::{Effort, TexelFormat, Texture, decode, write_dds, write_ktx2};
use mipfold::image::{Raster, Samples, Size};
use ndarray::Array3;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

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
        // (No DDS has blocks that stick out of level 0.)
        let blocks = texture.format.block_side() > 1;
        if blocks && !texture.size.width.is_multiple_of(4) {
            continue;
        }
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
    assert_eq!(count, 7);
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
        // three.js r187 has no texture of 16 bit with one or two channels. (UASTC has a test of its own.)
        if matches!(texture.format, TexelFormat::R16 | TexelFormat::Rg16 | TexelFormat::Uastc) {
            continue;
        }
        for zstd in [None, Some(Effort::Fast), Some(Effort::Slow)] {
            write_ktx2(std::fs::File::create(&path).unwrap(), &texture, zstd).unwrap();
            let about = common::script(Path::new("node"), "ktx2_dump.mjs", &[&three, &path, &dump]);
            assert_eq!(std::fs::read(&dump).unwrap(), texture.levels.concat(), "{:?}", texture.format);
            assert_eq!(about["levels"], sizes(&texture));
            assert_eq!(about["vkFormat"], json!(texture.format.vk_format()));
            assert_eq!([&about["pixelWidth"], &about["pixelHeight"]], [texture.size.width, texture.size.height]);
            assert_eq!(about["supercompressionScheme"], if zstd.is_some() { 2 } else { 0 });
            // No primaries, linear.
            assert_eq!([&about["primaries"], &about["transfer"]], [0, 1]);
            assert_eq!(about["colorSpace"], "");
            let writer = concat!("mipfold ", env!("CARGO_PKG_VERSION"));
            assert_eq!(about["keyValue"], json!({ "KTXorientation": "rd", "KTXwriter": writer }));
            count += 1;
        }
    }
    assert_eq!(count, 60);
}

/// Of every mode: code, its bits, and the place and the number of its patterns.
#[rustfmt::skip]
const MODES: [(u128, u32, u32, u128); 19] = [
    (0x1, 4, 0, 1), (0x35, 6, 0, 1), (0x1d, 5, 20, 30), (0x3, 5, 20, 11), (0x13, 5, 20, 30), (0xb, 5, 0, 1),
    (0x1b, 5, 0, 1), (0x7, 5, 20, 19), (0x17, 5, 0, 1), (0xf, 5, 28, 30), (0x2, 3, 0, 1), (0x0, 2, 0, 1),
    (0x6, 3, 0, 1), (0x1f, 5, 0, 1), (0xd, 5, 0, 1), (0x5, 7, 0, 1), (0x15, 6, 29, 30), (0x25, 6, 0, 1), (0x9, 4, 0, 1),
];

/// Blocks of every mode whose other bits look random.
fn random_blocks(count: usize) -> Vec<u8> {
    let mut state = 1u64;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        u128::from(state >> 32)
    };
    let block = |i: usize| {
        let (code, bits, at, patterns) = MODES[i % 19];
        let mut block = (0..4).fold(0, |block, _| block << 32 | number());
        if patterns > 1 {
            let most = if patterns == 11 { 15 } else { 31 };
            block = block & !(most << at) | (((i / 19) as u128 % patterns) << at);
        }
        (block >> bits << bits | code).to_le_bytes()
    };
    (0..count).flat_map(block).collect()
}

/// The texels that Basis Universal decodes from these blocks, too, as the next test holds where its transcoder is at hand.
#[test]
fn blocks_of_every_mode_are_decoded_as_ever() {
    let size = Size::new(4 * 38, 4 * 30);
    let Samples::U8(texels) = decode(&random_blocks(38 * 30), size, TexelFormat::Uastc).samples else {
        unreachable!("8 bit")
    };
    let digest = Sha256::digest(texels.as_slice().unwrap());
    assert_eq!(format!("{digest:x}"), "56323d403e7509e7269c87a95876541ce83077c7e8e66637b64e3db52a14ecc1");
}

#[test]
fn basis_universal_decodes_our_uastc_bit_for_bit() {
    let Some(three) = three() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (path, dump) = (folder.path().join("a.ktx2"), folder.path().join("a.bin"));
    let size = Size::new(4 * 38, 4 * 30);
    let random = Texture { size, format: TexelFormat::Uastc, levels: vec![random_blocks(38 * 30)] };
    let encoded =
        [(100, 36, 3, Effort::Fast), (100, 36, 4, Effort::Slow), (5, 3, 4, Effort::Fast), (64, 64, 3, Effort::Slow)];
    let encoded = encoded.map(|(width, height, channels, effort)| {
        let size = Size::new(width, height);
        let levels: Vec<_> = (0..size.level_count()).map(|k| raster(size.level(k), channels)).collect();
        (Texture::encode(&levels, TexelFormat::Uastc, effort), channels == 4)
    });
    for (texture, alpha) in encoded.into_iter().chain([(random, true)]) {
        for zstd in [None, Some(Effort::Fast), Some(Effort::Slow)] {
            write_ktx2(std::fs::File::create(&path).unwrap(), &texture, zstd).unwrap();
            let about = common::script(Path::new("node"), "basis_dump.mjs", &[&three, &path, &dump]);
            let levels = texture.levels.iter().enumerate();
            let ours: Vec<u8> = levels
                .flat_map(|(k, level)| match decode(level, texture.size.level(k), texture.format).samples {
                    Samples::U8(samples) => samples.into_raw_vec_and_offset().0,
                    _ => unreachable!("8 bit"),
                })
                .collect();
            let theirs = std::fs::read(&dump).unwrap();
            let wrong = ours.iter().zip(&theirs).position(|(a, b)| a != b);
            assert!(wrong.is_none() && ours.len() == theirs.len(), "{}: value {wrong:?}", texture.size);
            assert_eq!(about["size"], json!([texture.size.width, texture.size.height]));
            assert_eq!(about["levels"], texture.levels.len());
            assert_eq!([&about["uastc"], &about["alpha"]], [true, alpha]);
            // Blocks of 16 bytes as ours, or of half of it.
            let bytes = texture.levels.concat().len();
            for (format, half) in [("ETC1", 2), ("BC1", 2), ("BC4", 2), ("EAC_R11", 2)] {
                assert_eq!(about["bytes"][format], bytes / half, "{} to {format}", texture.size);
            }
            for format in ["ETC2", "BC3", "BC5", "BC7", "ASTC", "EAC_RG11"] {
                assert_eq!(about["bytes"][format], bytes, "{} to {format}", texture.size);
            }
        }
    }
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
    write_ktx2(file("n.ktx2"), &texture("n", TexelFormat::Bc5), Some(Effort::Fast)).unwrap();
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
