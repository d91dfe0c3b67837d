//! Several lobes a texel, through files and back.

use super::*;
use crate::ndf::{Axes, Lobe, RoughnessTensor};
use crate::roughness::Alpha;

/// Lobes without any symmetry, that move with the texel. With weights of the first to the third in turn that leave the
/// rounding something to do; some are 0.
fn lobe(form: Form, shared: bool, j: usize, k: usize, x: usize, y: usize) -> (Lobe, f32) {
    let t = (x + 3 * y + 5 * k) as f32;
    let n = if shared { 0.0 } else { j as f32 };
    let normal = glam::Vec3::new(0.3 * (t + 2.0 * n).sin(), 0.3 * (0.7 * t - n).cos(), 1.0).normalize();
    let alpha = 0.1 + 0.2 * j as f32 + 0.1 * (0.3 * t).sin().abs();
    let ratio = if form == Form::Anisotropic { 0.5 } else { 1.0 };
    // Angles about one axis: files keep to the side of the main one.
    let axes =
        Axes { alpha_x: Alpha(alpha), alpha_y: Alpha(ratio * alpha), angle: 0.4 + 0.2 * j as f32 + 0.1 * t.sin() };
    let parts = [2.0 + t.sin(), 1.0 + t.cos(), 1.5 + (2.0 * t).sin()].map(|v| if v < 0.1 { 0.0 } else { v });
    (Lobe { normal, roughness: RoughnessTensor::from_axes(axes) }, parts[j])
}

fn mixture(form: Form, count: usize, shared: bool, k: usize, size: Size) -> Lobes {
    Lobes::mixed_from_fn(form, count, size, |j, x, y| {
        let sum: f32 = (0..count).map(|j| lobe(form, shared, j, k, x, y).1).sum();
        let (lobe, part) = lobe(form, shared, j, k, x, y);
        (lobe, part / sum)
    })
}

fn mixed(change: impl FnOnce(&mut Inputs), form: Form, count: usize, shared_normal: bool) -> Build {
    let options = Options { form, lobes: count, shared_normal, ..Options::default() };
    build_with(change, options, |k, lobes| *lobes = mixture(form, count, shared_normal, k, lobes.size()))
}

/// The largest differences of a normal's component, of a perceptual width and of a weight, lobe by lobe.
fn differences(a: &[Lobes], b: &[Lobes]) -> [f32; 3] {
    assert_eq!(a.len(), b.len());
    let mut most = [0.0f32; 3];
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!((a.size(), a.count()), (b.size(), b.count()), "level {k}");
        let Size { width, height } = a.size();
        for (x, y, j) in (0..width * height * a.count()).map(|i| (i % width, i / width % height, i / width / height)) {
            let ((p, v), (q, w)) = (a.slot(j, x, y), b.slot(j, x, y));
            let (s, t) = (p.axes(), q.axes());
            let width = |s: Alpha, t: Alpha| (s.perceptual().0 - t.perceptual().0).abs();
            let width = width(s.alpha_x, t.alpha_x).max(width(s.alpha_y, t.alpha_y));
            for (most, off) in most.iter_mut().zip([(p.normal - q.normal).abs().max_element(), width, (v - w).abs()]) {
                *most = most.max(off);
            }
        }
    }
    most
}

fn files(build: &Build) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(build.out()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn manifest(build: &Build) -> serde_json::Value {
    serde_json::from_slice(&fs::read(build.out().join(MANIFEST)).unwrap()).unwrap()
}

#[test]
fn every_container_gives_the_mixture_back() {
    let conventions: [&dyn Fn(&mut Inputs); 3] =
        [&|_| {}, &|inputs| (inputs.normal_y, inputs.normal_scale) = (NormalY::DirectX, Some(0.7)), &|inputs| {
            let RoughnessInput::Roughness(file) = inputs.roughness.clone() else { unreachable!() };
            (inputs.roughness, inputs.normal_z) = (RoughnessInput::Smoothness(file), NormalZ::Rebuild);
        }];
    for (i, change) in conventions.iter().enumerate() {
        for count in [2, 3] {
            let build = mixed(change, Form::Isotropic, count, false);
            // Half a step of normals of -1..1, scaled and normalised; half a step of a width; and of a weight of the first
            // lobe half a step for each of the others, which may be rounded down instead of up.
            let steps = [
                (Container::Png, [2.5 / 255.0, 0.51 / 255.0, 1.51 / 255.0]),
                (Container::Exr, [2.0 / 1024.0, 1.0 / 2048.0, 1.0 / 1024.0]),
                (Container::Lobes, [1e-6; 3]),
            ];
            for (container, most) in steps {
                let chain = build.read(container);
                assert_eq!(chain.fold, Some(format!("ggx, {count} lobes")));
                let off = differences(&chain.levels, &build.levels);
                assert!(off.iter().zip(most).all(|(off, most)| *off <= most), "{i} {count} {container:?}: {off:?}");
                assert!(chain.levels[1..].iter().all(|level| level.form() == Form::Isotropic));
                if container != Container::Exr {
                    assert_eq!(chain.levels[0], build.levels[0], "{i} {container:?}: level 0 is the input's own");
                }
            }
            let own = read_lobes(&build.out().join("wall_lobes.exr")).unwrap();
            assert_eq!(own.levels, build.read(Container::Lobes).levels);
        }
    }
}

#[test]
fn lobes_of_two_widths_come_back_with_their_directions() {
    let build = mixed(|_| {}, Form::Anisotropic, 2, false);
    let steps = [
        (Container::Png, [2.0 / 255.0, 0.01, 0.51 / 255.0]),
        (Container::Exr, [1e-3, 1e-3, 5e-4]),
        (Container::Lobes, [1e-6, 1e-5, 1e-6]),
    ];
    for (container, most) in steps {
        let chain = build.read(container);
        assert_eq!(chain.fold.as_deref(), Some("ggx, 2 lobes, two widths"));
        let off = differences(&chain.levels, &build.levels);
        assert!(off.iter().zip(most).all(|(off, most)| *off <= most), "{container:?}: {off:?}");
        for j in 0..2 {
            let (read, wrote) = (chain.levels[3].slot(j, 1, 0).0.axes(), build.levels[3].slot(j, 1, 0).0.axes());
            let turned = (read.angle - wrote.angle).sin().abs();
            assert!(turned < 0.02, "{container:?}: lobe {j} turned by {turned}");
        }
    }
    let names = files(&build);
    assert!(["wall_lobe2_mip4.png", "wall_lobe2_anisotropy_mip0.png"].iter().all(|n| names.iter().any(|m| m == n)));
}

#[test]
fn haze_has_one_normal() {
    let build = mixed(|_| {}, Form::Isotropic, 2, true);
    for (container, most) in [
        (Container::Png, [2.0 / 255.0, 0.51 / 255.0, 0.51 / 255.0]),
        (Container::Exr, [1e-3, 5e-4, 5e-4]),
        (Container::Lobes, [1e-6; 3]),
    ] {
        let chain = build.read(container);
        assert_eq!(chain.fold.as_deref(), Some("ggx, 2 lobes sharing a normal"));
        let off = differences(&chain.levels, &build.levels);
        assert!(off.iter().zip(most).all(|(off, most)| *off <= most), "{container:?}: {off:?}");
        let [first, second] = [0, 1].map(|j| chain.levels[1].slot(j, 2, 3).0.normal);
        assert!(first.distance(second) < 1e-6);
    }
    let names = files(&build);
    assert!(names.iter().any(|name| name == "wall_haze_mip1.png"));
    assert!(!names.iter().any(|name| name.contains("lobe2")), "{names:?}");
}

/// Texel by texel, as the manifest says that a shader reads it.
#[test]
fn maps_are_what_the_manifest_says() {
    let build = mixed(|inputs| inputs.normal_y = NormalY::DirectX, Form::Isotropic, 3, false);
    let manifest = manifest(&build);
    assert_eq!((&manifest["count"], &manifest["shared_normal"]), (&3.into(), &false.into()));
    let maps = manifest["maps"].as_array().unwrap();
    let map = maps.iter().find(|map| map["role"] == "lobe" && map["container"] == "png").unwrap();
    let names: Vec<_> = (0..5).map(|k| format!("wall_lobe2_mip{k}.png")).collect();
    assert_eq!(map["files"], serde_json::json!(names));
    assert_eq!((&map["encoding"], &map["level_0"]), (&"unorm8".into(), &"the first lobe, of weight 0".into()));
    let roles = ["normal.x", "normal.y", "weight", "perceptual-roughness"].map(|role| format!("lobe2.{role}"));
    let found: Vec<_> = map["channels"].as_array().unwrap().iter().map(|c| c["role"].as_str().unwrap()).collect();
    assert_eq!(found, roles);
    assert!(map["decode"].as_str().unwrap().contains("weight = b"));
    let lobes = maps.iter().find(|map| map["role"] == "lobes").unwrap();
    assert_eq!(lobes["channels"].as_array().unwrap().len(), 21);
    assert_eq!(lobes["channels"][20]["name"], "weight3");
    let picture = |name: &str| codec::read(&build.out().join(name)).unwrap().raster;
    let [second, third] = ["wall_lobe2_mip2.png", "wall_lobe3_mip2.png"].map(picture);
    for (x, y) in [(0, 0), (3, 1), (5, 0)] {
        let (lobe, weight) = build.levels[2].slot(1, x, y);
        let [r, g, b, a] = [0, 1, 2, 3].map(|c| second.at(x, y, c));
        let normal = [2.0 * r - 1.0, -(2.0 * g - 1.0)];
        assert!((normal[0] - lobe.normal.x).abs() < 1.0 / 255.0 && (normal[1] - lobe.normal.y).abs() < 1.0 / 255.0);
        assert!((b - weight).abs() < 1.0 / 255.0 && (a - lobe.axes().alpha_x.perceptual().0).abs() < 0.51 / 255.0);
        // Weights never leave the first lobe less than nothing.
        assert!(b + third.at(x, y, 2) <= 1.0);
    }
    // At level 0 the first lobe again, of weight 0.
    let (base, ordinary) = (picture("wall_lobe2_mip0.png"), picture("n_mip0.png"));
    let off = |c| (base.at(7, 4, c) - ordinary.at(7, 4, c)).abs();
    assert!(base.at(7, 4, 2) == 0.0 && off(0) < 1.5 / 255.0 && off(1) < 1.5 / 255.0);
    assert!((base.at(7, 4, 3) - picture("orm_mip0.png").at(7, 4, 1)).abs() < 1e-6);
}

/// A fold that gives fewer lobes than were asked for has the others with weight 0.
#[test]
fn lobes_that_are_not_there_weigh_nothing() {
    let alone = |_, lobes: &mut Lobes| {
        let lobe = |j: usize, x, y| (lobes.at(x, y), if j == 0 { 1.0 } else { 0.0 });
        *lobes = Lobes::mixed_from_fn(lobes.form(), 2, lobes.size(), lobe);
    };
    let build = build_with(|_| {}, Options { lobes: 2, ..Options::default() }, alone);
    let chain = build.read(Container::Png);
    assert_eq!((chain.levels[2].count(), chain.levels[2].slot(1, 0, 0).1), (2, 0.0));
    assert_eq!(chain.levels[2].mixture(0, 0).count(), 1);
    assert!(difference(&chain.levels, &build.levels).1 < 0.51 / 255.0);
}

#[test]
fn files_of_a_mixture_that_do_not_fit_are_refused() {
    let build = mixed(|_| {}, Form::Isotropic, 2, false);
    let out = build.out();
    let read = || read_folder(&out, Some(Container::Png));
    let text = fs::read_to_string(out.join(MANIFEST)).unwrap();
    let edit = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        fs::write(out.join(MANIFEST), text.replace(from, to)).unwrap();
    };
    edit("\"lobe2.weight\"", "\"other\"");
    refused(read(), &["manifest.json", "no channel lobe2.weight in its png maps"]);
    edit("\"lobe2.normal.x\"", "\"other\"");
    refused(read(), &["no channel lobe2.normal.x"]);
    edit("\"count\": 2", "\"count\": 3");
    refused(read(), &["no channel lobe3.perceptual-roughness", "3 lobes"]);
    edit("\"count\": 2", "\"count\": 9");
    refused(read(), &["9 lobes", "1 to 4"]);
    // An earlier version's manifest has no count: its first lobe is all there is.
    edit("\"count\": 2,", "");
    assert_eq!(read().unwrap().levels[1].count(), 1);
    fs::write(out.join(MANIFEST), &text).unwrap();
    png(&out.join("wall_lobe2_mip0.png"), SIZE, |_, _| vec![128, 128, 9, 100]);
    refused(read(), &["wall_lobe2_mip0.png", "weight 0.035", "column 0, row 0 of level 0", "one lobe at level 0"]);
    fs::remove_file(out.join("wall_lobe2_mip0.png")).unwrap();
    refused(read(), &["wall_lobe2_mip0.png is not there"]);
}

#[test]
fn lobes_files_of_mixtures_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x_lobes.exr");
    let write = |names: &[String], values: &(dyn Fn(usize, usize) -> f32 + Sync)| {
        let channels: Vec<_> = names.iter().map(|name| Channel { name: name.clone(), depth: Depth::Float }).collect();
        let file = fs::File::create(&path).unwrap();
        write_exr(file, &channels, Size::new(2, 2), Wrap::Repeat, &|level, c, _, _, out| out.fill(values(level, c)))
            .unwrap();
        read_lobes(&path)
    };
    let names = lobe_channels(2);
    assert_eq!(names[5..], ["angle", "weight", "n2.x", "n2.y", "n2.z", "alpha2.x", "alpha2.y", "angle2", "weight2"]);
    assert_eq!(lobe_channels(1), LOBE_CHANNELS);
    let good = |level: usize, c: usize| {
        let weights = if level == 0 { [1.0, 0.0] } else { [0.25, 0.75] };
        let lobe = [0.0, 0.0, 1.0, 0.5, 0.25, 0.0, weights[c / 7]];
        lobe[c % 7]
    };
    let chain = write(&names, &good).unwrap();
    assert_eq!((chain.levels[0].count(), chain.levels[1].count(), chain.levels[1].slot(1, 0, 0).1), (1, 2, 0.75));
    for missing in ["weight", "weight2", "n2.y", "angle2"] {
        let names: Vec<_> = names.iter().map(|n| if n == missing { "other".into() } else { n.clone() }).collect();
        refused(write(&names, &good), &["x_lobes.exr", &format!("a channel {missing}")]);
    }
    let changed = |level: usize, channel: usize, value: f32| {
        write(&names, &|l, c| if (l, c) == (level, channel) { value } else { good(l, c) })
    };
    refused(changed(1, 13, 0.5), &["weights [0.25, 0.5]", "column 0, row 0 of level 1", "sum to 1"]);
    refused(changed(1, 6, f32::NAN), &["weights", "of level 1"]);
    refused(changed(1, 9, -1.0), &["of level 1", "a finite normal"]);
    let several = write(&names, &|l, c| good(l.max(1), c));
    refused(several, &["several lobes at column 0, row 0 of level 0", "one lobe at level 0"]);
}
