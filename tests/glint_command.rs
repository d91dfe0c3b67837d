//! `mipfold glint`: maps of flakes whose mips count flakes, pictures, and bad input.

mod common;

use std::path::Path;

use common::desk::Desk;
use common::{bumps, channel, exr_levels, manifest, mipfold, names, plane, png_levels, png8, read, shrink, textures};
use mipfold::image::Raster;

/// It must end well; what it says on stderr.
fn glint(desk: &Desk, args: &str) {
    let (code, stderr) = desk.run(&format!("glint {args}"));
    assert_eq!(code, Some(0), "{args}: {stderr}");
    assert!(stderr.lines().all(|line| line.starts_with("warning: ")), "{args}: {stderr}");
}

/// It must refuse, on one line that holds this, and leave the desk as it was.
fn refuses(desk: &Desk, args: &str, culprit: &str) {
    let before = desk.tree();
    let (code, stderr) = desk.run(&format!("glint {args}"));
    assert_eq!(code, Some(2), "{args}: {stderr}");
    assert!(stderr.contains(culprit), "{args}: {stderr} does not say {culprit}");
    assert_eq!(desk.tree(), before, "{args}: files changed");
}

/// Frames and size of an animated PNG.
fn animation(path: &Path) -> (u32, u32, u32) {
    let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
    let info = reader.info();
    (info.animation_control.map_or(0, |control| control.num_frames), info.width, info.height)
}

/// Flakes on a checkerboard of 4 x 4 texels, densest on the right.
fn masked(desk: &Desk) {
    bumps(&desk.at("n.png"), (32, 24));
    png8(&desk.at("mask.png"), (32, 24), |x, y| vec![if (x / 4 + y / 4) % 2 == 0 { 255 } else { 0 }]);
    png8(&desk.at("density.png"), (32, 24), |x, _| vec![0, (x * 8) as u8, 0]);
}

/// Every level of both containers is the mean of mask, and of mask times density, over its footprint: what hardware makes
/// of the mips counts the flakes of a pixel.
#[test]
fn mips_of_flake_maps_count_flakes() {
    let desk = Desk::empty();
    masked(&desk);
    glint(
        &desk,
        "--normal @n.png --roughness 0.3 --flake-mask @mask.png --flake-density @density.png:g --flakes 123456789 \
         --streak 12 --streak-angle 30 --seed 9 --size-variation 0.3 --no-pictures --format png,exr --float -o @out",
    );
    let out = desk.at("out");
    let (mask, density) = (plane(&read(&desk.at("mask.png")), 0), plane(&read(&desk.at("density.png")), 1));
    let both: Vec<f32> = mask.iter().zip(&density).map(|(m, d)| m * d).collect();
    let size = read(&desk.at("n.png")).size();
    let (pngs, exrs) = (png_levels(&out, "n_flakes"), exr_levels(&out.join("n_flakes.exr")));
    assert_eq!((pngs.len(), exrs.len()), (6, 6));
    let near = |found: &[f32], expected: &[f64], limit: f64| {
        assert!(found.iter().zip(expected).all(|(f, e)| (f64::from(*f) - e).abs() <= limit), "{found:?} {expected:?}");
    };
    for (png, exr) in pngs.iter().zip(&exrs) {
        for (index, name, map) in [(0, "density", &both), (1, "mask", &mask)] {
            let expected = shrink(map, size, png.size());
            near(&plane(png, index), &expected, 0.5 / 255.0 + 1e-6);
            near(&channel(exr, name), &expected, 1e-6);
        }
    }
    let manifest = manifest(&out);
    let flakes = &manifest["flakes"];
    assert_eq!((flakes["density"].as_f64(), flakes["seed"].as_u64()), (Some(123_456_789.0), Some(9)));
    assert_eq!((flakes["size_variation"].as_f64(), &flakes["files"][0]["channel"]), (Some(0.3), &"g".into()));
    assert_eq!((flakes["streak"].as_f64(), flakes["streak_angle"].as_f64()), (Some(12.0), Some(30.0)));
    assert_eq!(flakes["files"].as_array().unwrap().len(), 2);
    let map = manifest["maps"].as_array().unwrap().iter().find(|map| map["role"] == "flakes").unwrap();
    assert_eq!(map["level_0"], "maps of the flakes");
    assert!(map["decode"].as_str().unwrap().contains("1 + g*"), "{map}");
}

/// Without maps of flakes there are none to write, the chain is that of a build with both widths, and pictures are as large as asked.
#[test]
fn pictures_stand_beside_the_chain() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (32, 32));
    glint(&desk, "--normal @n.png --roughness 0.3 --pixels 48 --frames 3 --flakes 20000 -o @out");
    let (code, _) = desk.run("build --normal @n.png --roughness 0.3 --lobes aniso --extra tensor -o @built");
    assert_eq!(code, Some(0));
    let (out, built) = (desk.at("out"), desk.at("built"));
    let pictures = ["glints.png", "glints_light.png", "glints_pan.png", "glints_zoom.png"];
    let (mut all, chain) = (names(&out), names(&built));
    all.retain(|name| !pictures.contains(&name.as_str()));
    assert_eq!(all, chain);
    for name in chain.iter().filter(|name| name.ends_with(".png")) {
        assert_eq!(std::fs::read(out.join(name)).unwrap(), std::fs::read(built.join(name)).unwrap(), "{name}");
    }
    for name in &pictures[1..] {
        // Names of panes are wider than 48 pixels: "sphere" has 6 letters of 12.
        assert_eq!(animation(&out.join(name)), (3, 14 + 72 + 6 + 60 + 14, 14 + 14 + 7 + 48 + 14), "{name}");
    }
    let bright = |raster: &Raster| plane(raster, 0).iter().filter(|v| **v > 0.9).count();
    assert!(bright(&read(&out.join("glints.png"))) > 20);
    // Again over its own, and the same bytes for any number of threads; not over a stranger's.
    let before = std::fs::read(out.join("glints_zoom.png")).unwrap();
    glint(&desk, "--normal @n.png --roughness 0.3 --pixels 48 --frames 3 --flakes 20000 --threads 1 -o @out");
    assert_eq!(std::fs::read(out.join("glints_zoom.png")).unwrap(), before);
    // A picture of earlier flakes does not stay beside a chain of others.
    glint(&desk, "--normal @n.png --roughness 0.3 --no-pictures -o @out");
    assert_eq!(names(&out), chain);
    // One that somebody put beside a chain of ours is not replaced.
    desk.file("built/glints.png", b"mine");
    refuses(&desk, "--normal @n.png --roughness 0.3 -o @built", "glints.png");
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let desk = Desk::empty();
    masked(&desk);
    png8(&desk.at("black.png"), (8, 8), |_, _| vec![0]);
    let with = |more: &str| format!("--normal @n.png --roughness 0.3 -o @out {more}");
    refuses(&desk, &with("--flake-mask @black.png"), "without any flake");
    refuses(&desk, &with("--flake-mask @gone.png"), "gone.png");
    refuses(&desk, &with("--flake-mask @mask.png:b"), "1 channel");
    refuses(&desk, &with("--flakes 0.5"), "1 to 1e12");
    refuses(&desk, &with("--flake-roughness 0"), "0.01 to 1");
    refuses(&desk, &with("--evaluator smooth"), "field, binomial, reference");
    refuses(&desk, &with("--streak-angle 4"), "--streak");
    refuses(&desk, &with("--streak 4 --streak-angle nan"), "-360 to 360");
    refuses(&desk, "-o @out", "no maps");
    std::fs::copy(desk.at("mask.png"), desk.at("n_flakes_mip1.png")).unwrap();
    refuses(&desk, "--normal @n.png --roughness 0.3 --flake-mask @n_flakes_mip1.png -o @", "also an input");
    std::fs::copy(desk.at("mask.png"), desk.at("glints_pan.png")).unwrap();
    refuses(&desk, "--normal @n.png --roughness 0.3 --flake-mask @glints_pan.png -o @ -f", "also an input");
    // A dry run says what it would write, and does not.
    let before = desk.tree();
    let run = mipfold().arg("glint").args(desk.args(&with("--flake-mask @mask.png --dry-run"))).output().unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(said.contains("n_flakes_mip0.png") && said.contains("glints_zoom.png"), "{said}");
    assert_eq!(desk.tree(), before);
}

/// A folder of a real set.
#[test]
fn a_real_material_glints() {
    let Some(textures) = textures() else { return };
    let desk = Desk::empty();
    let set = textures.join("carpaint_flakes");
    assert!(set.is_dir(), "{}", set.display());
    let out = desk.at("out");
    let run =
        mipfold().arg("glint").arg(&set).args(["--pixels", "64", "--frames", "2", "-o"]).arg(&out).output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(animation(&out.join("glints_zoom.png")).0, 2);
}
