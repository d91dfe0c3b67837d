//! Bad input and bad usage: exit code 2, one clear line that names what is at fault, and no file left behind. And
//! what is repaired instead: exit code 0 and a count.

mod common;

use std::path::Path;

use common::desk::Desk;
use common::{bump, bumps, channel, encode8, exr_levels, exr32, mipfold, names, png8};
use mipfold::fold::FOLDS;

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0u32, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}

/// A PNG of about 1 KB whose header claims a size.
fn png_claiming(width: u32, height: u32) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let body = [kind.as_slice(), data].concat();
        [&(data.len() as u32).to_be_bytes(), body.as_slice(), &crc32(&body).to_be_bytes()].concat()
    };
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 2, 0, 0, 0]].concat();
    let data = miniz_oxide::deflate::compress_to_vec_zlib(&[0; 500_000], 9);
    [&b"\x89PNG\r\n\x1a\n"[..], &chunk(b"IHDR", &header), &chunk(b"IDAT", &data), &chunk(b"IEND", &[])].concat()
}

fn tga_claiming(width: u16, height: u16) -> Vec<u8> {
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend([width.to_le_bytes(), height.to_le_bytes()].concat());
    bytes.extend([24, 0]);
    bytes.resize(1024, 7);
    bytes
}

/// A real EXR with its windows overwritten.
fn exr_claiming(path: &Path, width: i32, height: i32) -> Vec<u8> {
    exr32(path, (4, 4), &["R", "G", "B"], |_, _, _| 0.5);
    let mut bytes = std::fs::read(path).unwrap();
    for window in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(window.len()).position(|w| w == window).unwrap() + window.len() + 12;
        bytes[at..at + 4].copy_from_slice(&(width - 1).to_le_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&(height - 1).to_le_bytes());
    }
    bytes
}

#[test]
fn what_is_no_picture_is_refused_by_name() {
    let desk = Desk::new();
    let mut jpeg = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(64, 64).write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
    let exr = exr32(&desk.at("whole.exr"), (64, 64), &["R", "G", "B"], |x, y, c| (x + y + c) as f32);
    let (png, exr) = (std::fs::read(desk.at("n.png")).unwrap(), std::fs::read(exr).unwrap());
    // Level 0 of an EXR comes first, and is all that is read.
    let cut = |bytes: &[u8]| bytes[..bytes.len() / 3].to_vec();
    for (name, bytes, found) in [
        ("cut.png", cut(&png), "PNG data that cannot be decoded"),
        ("cut.jpg", cut(jpeg.get_ref()), "JPEG data that cannot be decoded"),
        ("cut.exr", cut(&exr), "OpenEXR data that cannot be decoded"),
        ("text.png", b"normal: flat\n".to_vec(), "a text file"),
        ("empty.png", vec![], "an empty file"),
        ("zero.png", png_claiming(0, 7), "PNG"),
    ] {
        desk.file(name, &bytes);
        for args in ["--normal @FILE -o @out", "--normal @n.png --roughness @FILE -o @out", "--height @FILE -o @out"] {
            let message = desk.refuses(&args.replace("FILE", name), &format!("@{name}"));
            assert!(message.contains(found), "{message}");
        }
    }
    std::fs::create_dir(desk.at("folder.png")).unwrap();
    assert!(desk.refuses("--normal @folder.png -o @out", "@folder.png").contains("a folder"));
    desk.refuses("--normal @none.png -o @out", "@none.png");
    desk.refuses("@none -o @out", "@none");
    assert!(desk.refuses("@folder.png -o @out", "@folder.png").contains("no texture set"));
    desk.refuses("@n.png -o @out", "@n.png");
}

/// Cut short at many places: some decoder gives up each time, in words and not in a panic.
#[test]
fn no_cut_makes_a_decoder_panic() {
    let desk = Desk::new();
    let picture = image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([(x * 20) as u8, (y * 30) as u8, 200]));
    for (kind, format) in [
        ("jpg", image::ImageFormat::Jpeg),
        ("tga", image::ImageFormat::Tga),
        ("bmp", image::ImageFormat::Bmp),
        ("webp", image::ImageFormat::WebP),
    ] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        let bytes = bytes.into_inner();
        for k in 1..8 {
            let name = format!("cut{k}.{kind}");
            desk.file(&name, &bytes[..bytes.len() * k / 8]);
            desk.refuses(&format!("--normal @{name} -o @out"), &format!("@{name}"));
        }
    }
}

/// 60000 x 60000 texels are 10 GB of samples; the process is held to 1 GB of address space and must refuse in words.
#[cfg(unix)]
#[test]
fn a_header_that_claims_60000_texels_a_side_costs_nothing() {
    let desk = Desk::new();
    let exr = exr_claiming(&desk.at("made.exr"), 60_000, 60_000);
    for (name, bytes) in
        [("huge.png", png_claiming(60_000, 60_000)), ("huge.tga", tga_claiming(60_000, 60_000)), ("huge.exr", exr)]
    {
        assert!(bytes.len() < 2000, "{name}");
        desk.file(name, &bytes);
        let binary = mipfold();
        let limited = std::process::Command::new("sh")
            .args(["-c", "ulimit -v 1000000; exec \"$0\" \"$@\""])
            .arg(binary.get_program())
            .args(desk.args(&format!("build --threads 2 --normal @{name} -o @out")))
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&limited.stderr);
        assert_eq!(limited.status.code(), Some(2), "{name}: {stderr}");
        assert!(stderr.lines().count() == 1 && stderr.contains(name), "{stderr}");
        assert!(!desk.at("out").exists());
    }
    // Below the limit on texels, but far beyond what the file can hold.
    desk.file("large.png", &png_claiming(30_000, 30_000));
    desk.refuses("--normal @large.png -o @out", "@large.png");
}

#[test]
fn normals_without_any_direction_are_refused() {
    let desk = Desk::new();
    for (name, texel) in [("zero", [0, 0, 0]), ("gray", [128, 128, 128]), ("down", [128, 128, 0])] {
        png8(&desk.at(name), (8, 8), |_, _| texel.to_vec());
        let message = desk.refuses(&format!("--normal @{name} -o @out"), &format!("@{name}"));
        assert!(message.contains("expected a tangent-space normal map"), "{message}");
    }
    assert!(desk.refuses("--normal @r.png -o @out", "@r.png").contains("gray picture as normal map"));
    desk.refuses("--normal @n.png --roughness @n.png -o @out", "@n.png");
    desk.refuses("--normal @n.png --roughness @r.png:b -o @out", "@r.png");
}

/// A texel of nonsense is left out and counted; its neighbours and all coarser levels stay sane.
#[test]
fn what_is_not_a_number_is_repaired_and_counted() {
    let desk = Desk::new();
    let at = |x, y| x == 3 && y == 5;
    let normal = |x, y, c: usize| if at(x, y) { f32::NAN } else { bump(x, y, 16)[c] };
    exr32(&desk.at("n.exr"), (16, 16), &["R", "G", "B"], normal);
    exr32(
        &desk.at("i.exr"),
        (16, 16),
        &["R", "G", "B"],
        |x, y, c| if at(x, y) { f32::INFINITY } else { bump(x, y, 16)[c] },
    );
    exr32(&desk.at("r.exr"), (16, 16), &["Y"], |x, y, _| if at(x, y) { f32::INFINITY } else { 0.3 });
    exr32(&desk.at("s.exr"), (16, 16), &["Y"], |x, y, _| if at(x, y) { -2.0 } else { 0.3 });
    let none = "1 of 256 normals (0.391 %) have no direction";
    let nan = "1 of 256 roughness values (0.391 %) are not a number";
    let outside = "1 of 256 roughness values (0.391 %) lie outside 0..1";
    for (n, r, warnings) in
        [("n", "r", vec![none, nan]), ("i", "s", vec![none, outside]), ("n", "s", vec![none, outside])]
    {
        let out = format!("out-{n}{r}");
        let args = format!("--normal @{n}.exr --roughness @{r}.exr --format png,exr --moments --name m -o @{out}");
        desk.warns(&args, &warnings);
        for name in names(&desk.at(&out)).into_iter().filter(|name| name.ends_with(".exr")) {
            for (k, level) in exr_levels(&desk.at(&out).join(&name)).iter().enumerate() {
                for c in &level.channels {
                    assert!(channel(level, c).iter().all(|v| v.is_finite()), "{name} level {k} {c}");
                }
            }
        }
        // One of 256 texels: the last level hardly moves.
        let last = |file: &str| channel(exr_levels(&desk.at(file)).last().unwrap(), "alpha.x")[0];
        exr32(&desk.at("good.exr"), (16, 16), &["R", "G", "B"], |x, y, c| bump(x, y, 16)[c]);
        desk.warns("--normal @good.exr --roughness 0.3 --format exr --name m -o @good", &[]);
        let (bad, good) = (last(&format!("{out}/m_lobes.exr")), last("good/m_lobes.exr"));
        assert!((bad / good - 1.0).abs() < 0.02, "{bad} {good}");
    }
}

/// A packed map's other channels are averaged plainly; what is not a number there must not spread.
#[test]
fn not_a_number_in_another_channel_stays_where_it_is() {
    let desk = Desk::new();
    let texel = |x: usize, _: usize, c: usize| if (x, c) == (0, 0) { f32::NAN } else { 0.5 };
    exr32(&desk.at("orm.exr"), (16, 16), &["R", "G", "B"], texel);
    let (code, stderr) = desk.run("build --normal @n.png --orm @orm.exr --format exr -o @out");
    assert_eq!(code, Some(0), "{stderr}");
    for level in exr_levels(&desk.at("out/orm.exr")) {
        assert!(level.channels.iter().all(|c| channel(&level, c).iter().all(|v| v.is_finite())), "{}", level.size());
    }
}

/// One texel on its side (z one step above nothing) in a smooth map hardly changes the coarsest level.
#[test]
fn one_hostile_texel_does_not_poison_coarse_levels() {
    let desk = Desk::new();
    let gentle = |x: usize, y: usize| {
        let [x, y, _] = bump(x, y, 256).map(|v| 0.2 * v);
        [x, y, (1.0 - x * x - y * y).sqrt()].map(encode8).to_vec()
    };
    png8(&desk.at("good.png"), (256, 256), gentle);
    png8(&desk.at("bad.png"), (256, 256), |x, y| if (x, y) == (77, 91) { vec![255, 128, 128] } else { gentle(x, y) });
    for fold in FOLDS.iter().filter(|fold| !fold.is_slow()) {
        let alpha = |file: &str| {
            let name = fold.name;
            let out = format!("{name}-{file}");
            desk.warns(&format!("--normal @{file}.png --fold {name} --format exr --name m -o @{out}"), &[]);
            let lobes = exr_levels(&desk.at(&out).join("m_lobes.exr"));
            channel(lobes.last().unwrap(), "alpha.x")[0]
        };
        let (good, bad) = (alpha("good"), alpha("bad"));
        assert!((bad / good - 1.0).abs() < 0.01, "{}: alpha {good} becomes {bad}", fold.name);
    }
}

#[test]
fn errors_are_in_the_json_report() {
    let desk = Desk::new();
    let run = mipfold().args(desk.args("build --normal @none.png -o @out --json")).output().unwrap();
    assert_eq!((run.status.code(), run.stderr.len()), (Some(2), 0));
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(report["errors"][0].as_str().unwrap().contains("none.png"), "{report}");
}

/// In a folder of sets, a broken one is named and the others are built.
#[test]
fn one_broken_set_does_not_stop_the_others() {
    let desk = Desk::new();
    std::fs::create_dir(desk.at("sets")).unwrap();
    bumps(&desk.at("sets/a_normal.png"), (8, 8));
    desk.file("sets/b_normal.png", b"no picture");
    let (code, stderr) = desk.run("build @sets -o @out");
    assert!(code == Some(2) && stderr.lines().count() == 1 && stderr.contains("b_normal.png"), "{stderr}");
    assert_eq!(names(&desk.at("out")), ["a"]);
}

#[test]
fn bad_words_and_numbers_are_refused() {
    let desk = Desk::new();
    for (args, word) in [
        ("--fold best", "best"),
        ("--strength much", "--strength"),
        ("--strength=-1", "--strength"),
        ("--strength NaN", "--strength"),
        ("--strength inf", "--strength"),
        ("--min-alpha 2", "--min-alpha"),
        ("--min-alpha 0.5 --max-alpha 0.1", "--min-alpha"),
        ("--normal-scale 0", "--normal-scale"),
        ("--threads 0", "--threads"),
        ("--format jpg", "jpg"),
        ("--wrap around", "around"),
        ("--normal-y up", "up"),
        ("--roughness 1.5", "--roughness"),
        ("--roughness -0.5", "-0"),
        ("--roughness @r.png --gloss @r.png", "--gloss"),
        ("--roughness @r.png --orm @r.png", "--orm"),
        ("--fold clean --lobes aniso", "--lobes aniso"),
        ("--fold toksvig --lobes 2", "--lobes 2: found fold 'toksvig', which has one lobe only"),
        ("--fold toksvig --lobes haze", "one lobe only"),
        ("--fold toksvig --lobes 3-aniso", "one lobe only"),
        ("--lobes 5", "--lobes"),
        ("@ --roughness 0.5", "FOLDER"),
        ("--colour red", "--colour"),
    ] {
        let (code, stderr) = desk.run(&format!("build --normal @n.png -o @out {args}"));
        let first = stderr.lines().next().unwrap_or_default();
        assert_eq!(code, Some(2), "{args}: {stderr}");
        assert!(first.starts_with("error: ") && first.contains(word), "{args}: {first}");
        assert!(!desk.at("out").exists(), "{args}");
    }
    for args in ["build --normal @n.png", "build -o @out", "", "fold"] {
        assert_eq!(desk.run(args).0, Some(2), "{args}");
    }
}
