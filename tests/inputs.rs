//! Every way to give a material: packings, depths, containers, sizes, and the flags that say what is what.

mod common;
#[path = "inputs/config.rs"]
mod config;
#[path = "inputs/folders.rs"]
mod folders;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use common::desk::Desk;
use common::{bump, bumps, channel, encode8, exr_levels, exr32, integers, manifest, plane, png_levels, png8, png16};
use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
use mipfold::image::{Raster, Size};

fn grain(x: usize, y: usize) -> u8 {
    (40 + (x * 13 + y * 29) % 90) as u8
}

fn rough(path: &Path, size: (usize, usize)) -> PathBuf {
    png8(path, size, |x, y| vec![grain(x, y)])
}

fn all_samples(levels: &[Raster]) -> Vec<Vec<i64>> {
    levels.iter().map(|level| integers(level).0).collect()
}

fn only(levels: &[Raster], channel: usize) -> Vec<Vec<f32>> {
    levels.iter().map(|level| plane(level, channel)).collect()
}

#[test]
fn a_channel_of_a_packed_map() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (32, 32));
    rough(&desk.at("r.png"), (32, 32));
    png8(&desk.at("orm.png"), (32, 32), |x, y| vec![(x * 8) as u8, grain(x, y), if y < 16 { 255 } else { 0 }]);
    let alone = png_levels(&desk.build("alone", "--normal @n.png --roughness @r.png"), "r");
    for (out, flag) in
        [("channel", "--roughness @orm.png:g"), ("orm", "--orm @orm.png"), ("number", "--roughness @orm.png:1")]
    {
        let packed = png_levels(&desk.build(out, &format!("--normal @n.png {flag}")), "orm");
        assert_eq!(only(&packed, 1), only(&alone, 0), "{flag}");
        // Columns of 0, 8, 16, ... average to 4, 20, ...; the metal half stays as sharp as the texels allow.
        let (ao, metal) = (plane(&packed[1], 0), plane(&packed[1], 2));
        assert!((0..16).all(|x| (ao[x] * 255.0).round() as usize == 16 * x + 4), "{ao:?}");
        assert!((0..256).all(|i| metal[i] == if i < 128 { 1.0 } else { 0.0 }));
    }
}

#[test]
fn gloss_is_the_complement() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (32, 32));
    rough(&desk.at("r.png"), (32, 32));
    png8(&desk.at("g.png"), (32, 32), |x, y| vec![255 - grain(x, y)]);
    let rough = png_levels(&desk.build("r", "--normal @n.png --roughness @r.png"), "r");
    for flag in ["--gloss", "--smoothness"] {
        let out = desk.build(flag, &format!("--normal @n.png {flag} @g.png"));
        let smooth = png_levels(&out, "g");
        for (k, (r, g)) in all_samples(&rough).iter().zip(all_samples(&smooth)).enumerate() {
            assert!(r.iter().zip(&g).all(|(r, g)| (255 - r - g).abs() <= i64::from(k > 0)), "level {k}");
        }
        assert_eq!(manifest(&out)["maps"][1]["role"], "smoothness");
    }
}

#[test]
fn one_number_or_none() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (16, 16));
    for (out, flag, stored) in [("given", " --roughness 0.2", 51), ("none", "", 128)] {
        let folder = desk.build(out, &format!("--normal @n.png{flag}"));
        let levels = png_levels(&folder, "roughness");
        let samples = all_samples(&levels);
        assert!(samples[0].iter().all(|v| *v == stored), "{flag}");
        assert!(samples[1..].iter().flatten().all(|v| *v > stored), "{flag}: bumps make it rougher");
        let notes = common::strings(&manifest(&folder)["notes"]).join("\n");
        assert_eq!(
            notes.contains("no roughness given: perceptual roughness 0.5 everywhere"),
            flag.is_empty(),
            "{notes}"
        );
    }
    // Without bumps nothing is added.
    png8(&desk.at("flat.png"), (16, 16), |_, _| vec![128, 128, 255]);
    let flat = png_levels(&desk.build("flat", "--normal @flat.png --roughness 0.2"), "roughness");
    assert!(all_samples(&flat).iter().flatten().all(|v| *v == 51));
}

#[test]
fn normals_and_roughness_in_one_file() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (32, 16));
    rough(&desk.at("r.png"), (32, 16));
    png8(&desk.at("p.png"), (32, 16), |x, y| {
        let n = bump(x, y, 32).map(encode8);
        vec![n[0], n[1], n[2], grain(x, y)]
    });
    let apart = desk.build("apart", "--normal @n.png --roughness @r.png");
    let together = png_levels(&desk.build("together", "--normal @p.png --roughness @p.png:a"), "p");
    for c in 0..3 {
        assert_eq!(only(&together, c), only(&png_levels(&apart, "n"), c));
    }
    assert_eq!(only(&together, 3), only(&png_levels(&apart, "r"), 0));
}

#[test]
fn two_channels_are_x_and_y() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (32, 32));
    png8(&desk.at("xy.png"), (32, 32), |x, y| bump(x, y, 32).map(encode8)[..2].to_vec());
    let two = desk.build("two", "--normal @xy.png --roughness 0.3");
    let three = desk.build("three", "--normal @n.png --roughness 0.3 --normal-z rebuild");
    let (xy, xyz) = (png_levels(&two, "xy"), png_levels(&three, "n"));
    assert_eq!(xy[0].channels.len(), 2);
    assert_eq!([only(&xy, 0), only(&xy, 1)], [only(&xyz, 0), only(&xyz, 1)]);
    let roughness = [&two, &three].map(|out| all_samples(&png_levels(out, "roughness")));
    assert_eq!(roughness[0], roughness[1]);
    assert!(roughness[0][5][0] > roughness[0][0][0]);
}

#[test]
fn sizes_from_one_texel_up() {
    let desk = Desk::empty();
    for (width, height) in [(1, 1), (1, 9), (7, 1), (5, 3), (33, 20), (2, 64)] {
        let name = format!("{width}x{height}");
        bumps(&desk.at("n.png"), (width, height));
        rough(&desk.at("r.png"), (width, height));
        let out = desk.build(&name, "--normal @n.png --roughness @r.png --format png,exr --moments");
        let (normal, size) = (png_levels(&out, "n"), Size::new(width, height));
        assert_eq!(normal.len(), size.level_count(), "{name}");
        for file in ["n.exr", "r.exr", "n_lobes.exr", "n_moments.exr"] {
            let sizes: Vec<_> = exr_levels(&out.join(file)).iter().map(Raster::size).collect();
            assert_eq!(sizes, normal.iter().map(Raster::size).collect::<Vec<_>>(), "{name} {file}");
        }
        // Raw moments are plain means, so every level follows from level 0.
        let moments = exr_levels(&out.join("n_moments.exr"));
        for c in &moments[0].channels {
            for level in &moments {
                let mean = common::shrink(&channel(&moments[0], c), size, level.size());
                let close = channel(level, c).iter().zip(&mean).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-5);
                assert!(close, "{name} {c} at {}", level.size());
            }
        }
    }
}

#[test]
fn maps_of_different_sizes_meet_at_the_largest() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (16, 16));
    png8(&desk.at("r.png"), (4, 8), |x, _| vec![if x < 2 { 51 } else { 102 }]);
    let out = desk.build("out", "--normal @n.png --roughness @r.png");
    let (normal, rough) = (png_levels(&out, "n"), png_levels(&out, "r"));
    assert_eq!((normal[0].size(), rough[0].size()), (Size::new(16, 16), Size::new(16, 16)));
    assert_eq!((normal[0].bits(), rough[0].bits()), (8, 8));
    let row = &plane(&rough[0], 0)[..16];
    // Constant away from the two edges (the texture repeats), in the file's own 8 bits.
    assert!(row[4] == 0.2 && row[12] == 0.4, "{row:?}");
    assert!((row.iter().sum::<f32>() / 16.0 - 0.3).abs() < 0.002 && row[7] > 0.2 && row[7] < row[8], "{row:?}");
    let notes = common::strings(&manifest(&out)["notes"]).join("\n");
    assert!(notes.contains("r enlarged from 4x8 to 16x16"), "{notes}");
}

#[test]
fn sixteen_bits_stay_sixteen() {
    let desk = Desk::empty();
    let encode = |v: f32| ((0.5 + 0.5 * v) * 65535.0).round() as u16;
    png16(&desk.at("n.png"), (16, 16), |x, y| bump(x, y, 16).map(encode).to_vec());
    let out = desk.build("out", "--normal @n.png --roughness 0.3");
    let levels = png_levels(&out, "n");
    assert_eq!(levels[0].samples, common::read(&desk.at("n.png")).samples);
    assert!(levels.iter().chain(&png_levels(&out, "roughness")).all(|level| level.bits() == 16));
    let length = |k: usize| {
        let [x, y, z] = [0, 1, 2].map(|c| 2.0 * plane(&levels[k], c)[0] - 1.0);
        (x * x + y * y + z * z).sqrt()
    };
    assert!((1..levels.len()).all(|k| (length(k) - 1.0).abs() < 3e-5));
}

/// A PNG of another colour type, by the png crate itself.
fn odd_png(path: &Path, color: png::ColorType, depth: png::BitDepth, palette: &[u8], rows: &[u8]) {
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), 8, 8);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if !palette.is_empty() {
        encoder.set_palette(palette.to_vec());
    }
    encoder.write_header().unwrap().write_image_data(rows).unwrap();
}

#[test]
fn palettes_and_single_bits_are_expanded() {
    let desk = Desk::empty();
    bumps(&desk.at("n.png"), (8, 8));
    odd_png(&desk.at("bit.png"), png::ColorType::Grayscale, png::BitDepth::One, &[], &[0b0101_0101; 8]);
    let bits = png_levels(&desk.build("bit", "--normal @n.png --roughness @bit.png --at-least-average"), "bit");
    assert_eq!(integers(&bits[0]).0[..4], [0, 255, 0, 255]);
    assert!(integers(&bits[1]).0.iter().all(|v| *v > 127));

    // Gray as colour: all three channels are the roughness.
    let palette = [20, 20, 20, 90, 90, 90];
    odd_png(&desk.at("pal.png"), png::ColorType::Indexed, png::BitDepth::One, &palette, &[0b0011_0011; 8]);
    let levels = png_levels(&desk.build("pal", "--normal @n.png --roughness @pal.png"), "pal");
    assert_eq!(integers(&levels[0]).0[..9], [20, 20, 20, 20, 20, 20, 90, 90, 90]);
    assert!(levels.iter().all(|level| integers(level).0.chunks(3).all(|t| t[0] == t[1] && t[1] == t[2])));

    // A normal map of four directions.
    let palette = [128, 128, 255, 160, 128, 250, 96, 128, 250, 128, 160, 250];
    odd_png(&desk.at("dir.png"), png::ColorType::Indexed, png::BitDepth::Two, &palette, &[0b0001_1011; 16]);
    let levels = png_levels(&desk.build("dir", "--normal @dir.png --roughness 0.1"), "dir");
    assert_eq!(integers(&levels[0]).0[3..12], [160, 128, 250, 96, 128, 250, 128, 160, 250]);
}

/// The same pixels in any lossless container give the same files.
#[test]
fn containers_of_the_same_pixels_agree() {
    let desk = Desk::empty();
    let (width, height) = (24, 16);
    bumps(&desk.at("n.png"), (width, height));
    rough(&desk.at("r.png"), (width, height));
    let normal = RgbImage::from_fn(24, 16, |x, y| image::Rgb(bump(x as usize, y as usize, 24).map(encode8)));
    let gray = GrayImage::from_fn(24, 16, |x, y| image::Luma([grain(x as usize, y as usize)]));
    let want = desk.build("png", "--normal @n.png --roughness @r.png");
    let want = ["n", "r"].map(|stem| all_samples(&png_levels(&want, stem)));
    let hold = |kind: &str, format: &str| {
        let out = desk.build(kind, &format!("--normal @n.{kind} --roughness @r.{kind}"));
        let mut got = ["n", "r"].map(|stem| png_levels(&out, stem));
        // Some containers have no gray.
        let gray: Vec<_> =
            only(&got[1], 0).iter().map(|p| p.iter().map(|v| (v * 255.0).round() as i64).collect()).collect();
        assert_eq!((all_samples(&std::mem::take(&mut got[0])), gray), (want[0].clone(), want[1].clone()), "{kind}");
        assert_eq!(manifest(&out)["inputs"][0]["format"], format);
    };
    for (kind, image_format, name) in
        [("tga", ImageFormat::Tga, "TGA"), ("bmp", ImageFormat::Bmp, "BMP"), ("webp", ImageFormat::WebP, "WebP")]
    {
        normal.save_with_format(desk.at(&format!("n.{kind}")), image_format).unwrap();
        let rough = DynamicImage::from(gray.clone()).to_rgb8();
        rough.save_with_format(desk.at(&format!("r.{kind}")), image_format).unwrap();
        hold(kind, name);
    }
    let file = |name: &str| tiff::encoder::TiffEncoder::new(std::fs::File::create(desk.at(name)).unwrap()).unwrap();
    file("n.tif").write_image::<tiff::encoder::colortype::RGB8>(24, 16, normal.as_raw()).unwrap();
    file("r.tif").write_image::<tiff::encoder::colortype::Gray8>(24, 16, gray.as_raw()).unwrap();
    hold("tif", "TIFF");
}

#[test]
fn float_containers() {
    let desk = Desk::empty();
    let unsigned = |x, y, c: usize| 0.5 + 0.5 * bump(x, y, 32)[c];
    exr32(&desk.at("unsigned.exr"), (32, 32), &["R", "G", "B"], unsigned);
    exr32(&desk.at("signed.exr"), (32, 32), &["R", "G", "B"], |x, y, c| bump(x, y, 32)[c]);
    exr32(&desk.at("named.exr"), (32, 32), &["X", "Y", "Z"], |x, y, c| bump(x, y, 32)[c]);
    exr32(&desk.at("r.exr"), (32, 32), &["Y"], |x, y, _| f32::from(grain(x, y)) / 255.0);
    let pixels: Vec<_> = (0..1024).map(|i| image::Rgb([0, 1, 2].map(|c| unsigned(i % 32, i / 32, c)))).collect();
    let hdr = std::fs::File::create(desk.at("n.hdr")).unwrap();
    image::codecs::hdr::HdrEncoder::new(hdr).encode(&pixels, 32, 32).unwrap();

    let alpha = |file: &str| {
        let out = desk.build(
            &format!("out of {file}"),
            &format!("--normal @{file} --roughness @r.exr --format png,exr --name m"),
        );
        let stem = file.split_once('.').unwrap().0;
        assert!(png_levels(&out, stem).iter().all(|level| level.bits() == 16), "{file}");
        exr_levels(&out.join("m_lobes.exr")).iter().flat_map(|level| channel(level, "alpha.x")).collect::<Vec<_>>()
    };
    let want = alpha("signed.exr");
    assert_eq!(want, alpha("named.exr"));
    // Radiance keeps 8 bits of the largest component.
    for (file, bound) in [("unsigned.exr", 1e-5), ("n.hdr", 0.01)] {
        let off = want.iter().zip(alpha(file)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < bound, "{file}: {off}");
    }
}

/// Grain along u spreads light along v: the anisotropy map says so, and gives back the widths that were folded.
#[test]
fn brushed_metal_is_anisotropic_across_its_grain() {
    let Some(textures) = common::textures() else { return };
    let desk = Desk::empty();
    let set = textures.join("brushed_metal009");
    let mut args: Vec<&OsStr> =
        ["--lobes", "aniso", "--format", "png,exr", "--roughness", "0.2"].map(OsStr::new).to_vec();
    let normal = set.join("normal.jpg");
    args.extend(["--normal".as_ref(), normal.as_os_str(), "--normal-y".as_ref(), "directx".as_ref()]);
    common::build(args, &desk.at("out"));
    let [anisotropy, roughness] = ["anisotropy", "roughness"].map(|stem| png_levels(&desk.at("out"), stem));
    let lobes = exr_levels(&desk.at("out/normal_lobes.exr"));
    // Of no strength, in the direction of the levels that it is mixed with.
    let base = integers(&anisotropy[0]).0;
    assert!(base.chunks(3).all(|t| t == [base[0], base[1], 0]), "level 0 is isotropic");
    let one_side = |k: usize| {
        let [x, y, _] = [0, 1, 2].map(|c| plane(&anisotropy[k], c));
        let main = [base[0], base[1]].map(|v| v as f32 - 127.5);
        x.iter().zip(&y).all(|(x, y)| main[0] * (*x * 255.0 - 127.5) + main[1] * (*y * 255.0 - 127.5) > -130.0)
    };
    assert!((1..12).all(one_side), "no direction points away from the main one");
    for k in [6, 9, 11] {
        let [x, y, strength] = [0, 1, 2].map(|c| plane(&anisotropy[k], c));
        let r = plane(&roughness[k], 0);
        let [wide, narrow] = ["alpha.x", "alpha.y"].map(|c| channel(&lobes[k], c));
        for i in 0..r.len() {
            // glTF: alpha_t = mix(alpha, 1, strength^2) along the direction, alpha_b = alpha.
            let across = r[i] * r[i];
            let along = across + (1.0 - across) * strength[i] * strength[i];
            assert!((across - narrow[i]).abs() < 0.003 && (along - wide[i]).abs() < 0.006, "level {k} texel {i}");
            assert!(along > 1.3 * across, "level {k} texel {i}: {along} along, {across} across");
            let (cos, sin) = (2.0 * x[i] - 1.0, 2.0 * y[i] - 1.0);
            assert!(sin.abs() > 0.97 && cos.abs() < 0.25, "level {k} texel {i}: direction {cos} {sin}");
        }
    }
}

#[test]
fn sixteen_bit_heights_become_sixteen_bit_normals() {
    let Some(textures) = common::textures() else { return };
    let desk = Desk::empty();
    let height = textures.join("ground080_height16/height.png");
    common::build(
        ["--height".as_ref(), height.as_os_str(), "--height-scale".as_ref(), "0.1".as_ref()],
        &desk.at("out"),
    );
    let levels = png_levels(&desk.at("out"), "height_normal");
    assert_eq!((levels[0].bits(), levels[0].size()), (16, Size::new(1024, 1024)));
    // Central differences of the heights themselves, here and there; rows run down, v runs up.
    let heights = plane(&common::read(&height), 0);
    let at = |x: usize, y: usize| heights[(y % 1024) * 1024 + x % 1024] * 0.1 * 1024.0;
    let [nx, ny, nz] = [0, 1, 2].map(|c| plane(&levels[0], c));
    let mut steepest = 0f32;
    for i in (0..1024 * 1024).step_by(997) {
        let (x, y) = (i % 1024, i / 1024);
        let (dx, dy) = ((at(x + 1, y) - at(x + 1023, y)) / 2.0, (at(x, y + 1023) - at(x, y + 1)) / 2.0);
        let [x, y, z] = [nx[i], ny[i], nz[i]].map(|v| 2.0 * v - 1.0);
        assert!(
            (-x / z - dx).abs() < 2e-3 && (-y / z - dy).abs() < 2e-3,
            "texel {i}: {} {dx}, {} {dy}",
            -x / z,
            -y / z
        );
        steepest = steepest.max(dx.abs());
    }
    assert!(steepest > 0.2, "{steepest}");
    let rough = integers(&png_levels(&desk.at("out"), "roughness")[10]).0[0];
    assert!(rough > 32768, "{rough}");
}

/// The usual names come first, in their usual order, whatever else a file has.
#[test]
fn further_exr_channels_do_not_reorder_the_usual_ones() {
    let desk = Desk::empty();
    let texel = |x, y, c: usize| bump(x, y, 16).get(c).copied().unwrap_or(0.25);
    exr32(&desk.at("three.exr"), (16, 16), &["R", "G", "B"], texel);
    exr32(&desk.at("four.exr"), (16, 16), &["R", "G", "B", "mask"], texel);
    let lobes = ["three", "four"].map(|file| {
        let out = desk.build(file, &format!("--normal @{file}.exr --format exr --name m"));
        exr_levels(&out.join("m_lobes.exr"))
    });
    assert_eq!(lobes[0], lobes[1]);
}

/// A colour picture with height in alpha is not a height map, and a colour map is nobody's roughness.
#[test]
fn a_packed_colour_map_is_not_a_height_map() {
    let desk = Desk::empty();
    std::fs::create_dir(desk.at("set")).unwrap();
    png8(&desk.at("set/albedo_height.png"), (8, 8), |x, _| vec![90, 80, 70, x as u8]);
    bumps(&desk.at("set/normal.png"), (8, 8));
    let out = desk.build("out", "@set");
    assert_eq!(manifest(&out)["material"], "set");
}

/// By the command line as in a folder.
#[test]
fn a_material_is_named_without_the_word_of_its_map() {
    let desk = Desk::empty();
    for (file, name) in [("wall_normal.png", "wall"), ("Old-Oak_nor_dx_2k.png", "Old-Oak_2k"), ("normal.png", "normal")]
    {
        bumps(&desk.at(file), (8, 8));
        let out = desk.build(&format!("out-{name}"), &format!("--normal @{file} --roughness 0.4"));
        assert_eq!(manifest(&out)["material"], name);
    }
}
