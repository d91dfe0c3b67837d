//! OpenImageIO reads our EXR files exactly as we do, and its own bumpslopes are our raw moments.

#![allow(clippy::print_stderr)]

mod common;

use std::path::{Path, PathBuf};

use common::{build, channel, exr_levels, manifest, plane, script, strings};
use mipfold::image::Size;
use serde_json::Value;

/// A level as OpenImageIO sees it: the planes of its channels.
type Planes = Vec<Vec<f32>>;

/// A whole EXR file by way of OpenImageIO: channel names, sizes and planes of the levels, and the rest that it says.
struct Foreign {
    channels: Vec<String>,
    sizes: Vec<Size>,
    levels: Vec<Planes>,
    about: Value,
}

impl Foreign {
    fn read(python: &Path, file: &Path) -> Self {
        let dump = tempfile::NamedTempFile::new().unwrap();
        let about = script(python, "exr_dump.py", &[file, dump.path()]);
        let channels = strings(&about["channels"]);
        let side = |v: &Value| v.as_u64().unwrap() as usize;
        let sizes: Vec<Size> =
            about["levels"].as_array().unwrap().iter().map(|s| Size::new(side(&s[0]), side(&s[1]))).collect();
        let bytes = std::fs::read(dump.path()).unwrap();
        let mut floats = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        let mut levels = Vec::new();
        for size in &sizes {
            let mut planes = vec![Vec::with_capacity(size.texels()); channels.len()];
            for _ in 0..size.texels() {
                planes.iter_mut().for_each(|plane| plane.push(floats.next().unwrap()));
            }
            levels.push(planes);
        }
        assert_eq!(floats.next(), None);
        Self { channels, sizes, levels, about }
    }

    fn plane(&self, level: usize, name: &str) -> &[f32] {
        let c = self.channels.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name}: {:?}", self.channels));
        &self.levels[level][c]
    }
}

/// Builds, and holds every EXR file against OpenImageIO's reading of it, texel by texel.
fn hold(python: &Path, args: &[&std::ffi::OsStr], size: Size, files: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    build(["--format", "exr", "--moments"].map(AsRef::as_ref).iter().chain(args), folder.path());
    let manifest = manifest(folder.path());
    let maps = manifest["maps"].as_array().unwrap();
    let mut written: Vec<_> = maps.iter().flat_map(|map| strings(&map["files"])).collect();
    written.sort();
    assert_eq!(written, files);
    for map in maps {
        let name = map["files"][0].as_str().unwrap();
        let path = folder.path().join(name);
        let (ours, foreign) = (exr_levels(&path), Foreign::read(python, &path));
        let halvings: Vec<_> = (0..size.level_count()).map(|k| size.level(k)).collect();
        assert_eq!(foreign.sizes, halvings, "{name}");
        assert_eq!(foreign.about["tiled"], true, "{name}");
        let mode = match manifest["wrap"].as_str() {
            Some("repeat") => "periodic",
            other => other.unwrap(),
        };
        assert_eq!(foreign.about["wrapmodes"], format!("{mode},{mode}"), "{name}");
        let encoding = if map["encoding"] == "float16" { "half" } else { "float" };
        assert!(strings(&foreign.about["types"]).iter().all(|t| t == encoding), "{name}: {}", foreign.about["types"]);

        let mut said: Vec<_> =
            map["channels"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap().to_owned()).collect();
        let mut found = foreign.channels.clone();
        said.sort();
        found.sort();
        assert_eq!(said, found, "{name}");
        for (k, ours) in ours.iter().enumerate() {
            assert_eq!(ours.size(), foreign.sizes[k], "{name}");
            for c in &said {
                let same = channel(ours, c).iter().zip(foreign.plane(k, c)).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "{name} level {k} channel {c}");
            }
        }
        match map["role"].as_str().unwrap() {
            "lobes" => lobes_are_lobes(&foreign),
            "normal" => assert!(foreign.plane(0, "R").iter().any(|v| *v < 0.0), "{name}: normals are signed"),
            _ => {}
        }
    }
}

/// Unit normals that point up, widths in order and in range.
fn lobes_are_lobes(file: &Foreign) {
    for k in 0..file.levels.len() {
        let [x, y, z, wide, narrow, angle] =
            ["n.x", "n.y", "n.z", "alpha.x", "alpha.y", "angle"].map(|c| file.plane(k, c));
        for i in 0..x.len() {
            let length = (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt();
            assert!((length - 1.0).abs() < 1e-5 && z[i] > 0.0, "level {k}: length {length}, z {}", z[i]);
            assert!(1.0 >= wide[i] && wide[i] >= narrow[i] && narrow[i] >= 0.0, "level {k}: {} {}", wide[i], narrow[i]);
            assert!(angle[i].abs() <= std::f32::consts::PI, "level {k}: {}", angle[i]);
        }
    }
}

fn flags<'a>(pairs: &'a [(&'a str, PathBuf)]) -> Vec<&'a std::ffi::OsStr> {
    pairs.iter().flat_map(|(flag, path)| [flag.as_ref(), path.as_os_str()]).collect()
}

#[test]
fn openimageio_reads_a_pair_texel_for_texel() {
    let (Some(textures), Some(python)) = (common::textures(), common::python()) else { return };
    let folder = textures.join("metal027");
    let args = [("--normal", folder.join("normal.jpg")), ("--roughness", folder.join("roughness.jpg"))];
    let files = ["normal.exr", "normal_lobes.exr", "normal_moments.exr", "roughness.exr"];
    hold(&python, &flags(&args), Size::new(1024, 1024), &files);
}

#[test]
fn openimageio_reads_odd_sizes_and_two_widths_texel_for_texel() {
    let (Some(textures), Some(python)) = (common::textures(), common::python()) else { return };
    let folder = textures.join("paper001");
    let mut args = ["--lobes", "aniso", "--float", "--wrap", "clamp"].map(AsRef::as_ref).to_vec();
    let pairs = [("--normal", folder.join("normal.jpg")), ("--roughness", folder.join("roughness.jpg"))];
    args.extend(flags(&pairs));
    let files = ["anisotropy.exr", "normal.exr", "normal_lobes.exr", "normal_moments.exr", "roughness.exr"];
    hold(&python, &args, Size::new(1024, 600), &files);
}

#[test]
fn openimageio_reads_a_packed_set_texel_for_texel() {
    let (Some(textures), Some(python)) = (common::textures(), common::python()) else { return };
    let folder = textures.join("fabric_pattern_07");
    let args = [("--normal", folder.join("normal.jpg")), ("--orm", folder.join("arm.jpg"))];
    let files = ["arm.exr", "normal.exr", "normal_lobes.exr", "normal_moments.exr"];
    hold(&python, &flags(&args), Size::new(1024, 1024), &files);
}

/// The largest difference of each moment over all levels below `levels`, in parts of the moment's range at level 0.
fn differences(ours: &Foreign, theirs: &Foreign, levels: usize) -> Vec<f32> {
    let range = |plane: &[f32]| {
        let (low, high) = plane.iter().fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
        // The height is -1 everywhere.
        if high > low { high - low } else { 1.0 }
    };
    let difference = |name: &String| {
        let range = range(theirs.plane(0, name));
        let per_level = (0..levels).map(|k| {
            let pairs = ours.plane(k, name).iter().zip(theirs.plane(k, name));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / range
        });
        per_level.fold(0.0, f32::max)
    };
    theirs.channels.iter().map(difference).collect()
}

/// OpenImageIO's moments and ours of one picture, under both Y conventions.
fn moments(python: &Path, normal: &Path) -> (Foreign, [Foreign; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let (decoded, slopes) = (folder.path().join("map.png"), folder.path().join("slopes.exr"));
    script(python, "bumpslopes.py", &[normal, &decoded, &slopes]);
    let ours = ["opengl", "directx"].map(|y| {
        let out = folder.path().join(y);
        build(
            ["--normal".as_ref(), decoded.as_os_str(), "--moments".as_ref(), "--normal-y".as_ref(), y.as_ref()],
            &out,
        );
        Foreign::read(python, &out.join("map_moments.exr"))
    });
    (Foreign::read(python, &slopes), ours)
}

/// No convention differs: `-n.xy / n.z` of the normal as stored (dh/dt follows the green channel, up the picture for
/// OpenGL maps and down for DirectX maps; neither tool flips it), height -1, the same channel names in the same order,
/// and on powers of two the 2x2 box at every level. OpenImageIO neither normalises nor clamps, so the maps here have
/// no z below our clamp of 0.2.
#[test]
fn raw_moments_are_those_of_openimageio() {
    let (Some(textures), Some(python)) = (common::textures(), common::python()) else { return };
    // Faint; steep, far from unit length, in an RGBA file; DirectX, with sharp edges.
    for name in ["metal027/normal.jpg", "carpaint_flakes/normal.png", "chainmail004/normal.jpg"] {
        let (theirs, ours) = moments(&python, &textures.join(name));
        for ours in &ours {
            assert_eq!(ours.channels, theirs.channels, "{name}");
            assert_eq!(ours.sizes, theirs.sizes, "{name}");
            assert!(theirs.plane(0, "b3_dhds2").iter().any(|v| *v > 1e-3), "{name}: OpenImageIO wrote nothing");
            let differences = differences(ours, &theirs, ours.sizes.len());
            eprintln!("{name}: {differences:?}");
            assert!(differences.iter().all(|d| *d < 1e-4), "{name}: {:?} {differences:?}", ours.channels);
        }
    }
}

/// At sizes that do not halve, OpenImageIO makes each level from the one before it, whose texels cover unequal areas;
/// ours are the exact footprints of level 0. Where the sides do halve both agree, and our last texel is the mean.
#[test]
fn odd_sizes_agree_as_far_as_the_sides_halve() {
    let (Some(textures), Some(python)) = (common::textures(), common::python()) else { return };
    let (theirs, [ours, _]) = moments(&python, &textures.join("cheese_bumps/normal.png"));
    assert_eq!(ours.sizes[..3], [Size::new(490, 490), Size::new(245, 245), Size::new(122, 122)]);
    let differences = differences(&ours, &theirs, 2);
    assert!(differences.iter().all(|d| *d < 1e-4), "{differences:?}");
    for c in &ours.channels {
        let mean = |plane: &[f32]| plane.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.len() as f64;
        let last = f64::from(ours.plane(8, c)[0]);
        assert!((last - mean(ours.plane(0, c))).abs() < 1e-6, "{c}: {last}");
    }
}

/// The float normals of OpenImageIO's own test suite.
#[test]
fn a_half_float_normal_map_gives_the_same_moments() {
    let (Some(textures), Some(python)) = (common::textures(), common::python()) else { return };
    let normal = textures.join("float_noise_exr/normal.exr");
    let folder = tempfile::tempdir().unwrap();
    let (decoded, slopes) = (folder.path().join("map.exr"), folder.path().join("slopes.exr"));
    script(&python, "bumpslopes.py", &[&normal, &decoded, &slopes]);
    build(["--normal".as_ref(), normal.as_os_str(), "--moments".as_ref()], &folder.path().join("out"));
    let ours = Foreign::read(&python, &folder.path().join("out/normal_moments.exr"));
    let theirs = Foreign::read(&python, &slopes);
    let differences = differences(&ours, &theirs, 8);
    assert!(differences.iter().all(|d| *d < 1e-4), "{differences:?}");
    // (Decoded planes are compared above; this holds the picture that both started from.)
    assert_eq!(plane(&common::read(&decoded), 0), plane(&common::read(&normal), 0));
}
