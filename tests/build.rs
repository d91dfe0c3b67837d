//! Builds of real materials, and what must be true of every file that they write.

mod common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use common::{build, integers, manifest, mipfold, names, plane, png_levels, shrink, strings};
use mipfold::codec;
use mipfold::image::{Raster, Size};
use rayon::prelude::*;
use serde_json::Value;
use sha2::{Digest, Sha256};

fn size_of(value: &Value) -> Size {
    let side = |key: &str| value[key].as_u64().unwrap() as usize;
    Size::new(side("width"), side("height"))
}

/// One map of a built material: its manifest entry and its levels.
struct Map<'a> {
    name: String,
    entry: &'a Value,
    levels: Vec<Raster>,
    /// What it was made from, unless it was made up.
    input: Option<Raster>,
}

impl Map<'_> {
    fn role(&self, channel: usize) -> &str {
        self.entry["channels"][channel]["role"].as_str().unwrap()
    }

    fn channels(&self) -> usize {
        self.levels[0].channels.len()
    }

    fn channel(&self, role: &str) -> Option<usize> {
        (0..self.channels()).find(|c| self.role(*c) == role)
    }

    fn size(&self) -> Size {
        self.levels[0].size()
    }

    /// The largest error of rounding a value to an integer of this depth, in 0..1.
    fn rounding(&self) -> f64 {
        0.5 / if self.levels[0].bits() == 8 { 255.0 } else { 65535.0 } + 1e-6
    }

    /// Sizes halve, rounded down, to 1x1.
    fn levels_halve(&self) {
        let mut size = self.size();
        let said: Vec<_> = self.entry["levels"].as_array().unwrap().iter().map(size_of).collect();
        for (k, level) in self.levels.iter().enumerate() {
            assert_eq!((level.size(), said[k]), (size, size), "{} level {k}", self.name);
            assert_eq!(level.bits(), self.levels[0].bits(), "{}", self.name);
            size = Size::new((size.width / 2).max(1), (size.height / 2).max(1));
        }
        assert_eq!(self.levels.last().unwrap().size(), Size::new(1, 1), "{}", self.name);
    }

    /// Level 0 is the input: the same samples, or for a float input the nearest 16-bit ones.
    fn level_0_is_the_input(&self) {
        let Some(input) = &self.input else { return };
        if input.bits() == 32 {
            assert_eq!(self.levels[0].bits(), 16);
            for c in 0..self.channels() {
                let pairs = plane(input, c).into_iter().zip(plane(&self.levels[0], c));
                assert!(pairs.into_iter().all(|(a, b)| f64::from((a - b).abs()) <= self.rounding()), "{}", self.name);
            }
        } else {
            assert_eq!(input.samples, self.levels[0].samples, "{}", self.name);
        }
    }

    /// Channels that are not ours are the plain mean of level 0 at every level.
    fn other_channels_are_plain_means(&self) -> usize {
        let others: Vec<_> =
            (0..self.channels()).filter(|c| ["other", "occlusion", "metalness"].contains(&self.role(*c))).collect();
        for c in &others {
            let base = plane(&self.levels[0], *c);
            for (k, level) in self.levels.iter().enumerate().skip(1) {
                let mean = shrink(&base, self.size(), level.size());
                for (got, mean) in plane(level, *c).iter().zip(&mean) {
                    let error = (f64::from(*got) - mean).abs();
                    assert!(error <= self.rounding(), "{} level {k} channel {c}: {got} for {mean}", self.name);
                }
            }
        }
        others.len()
    }

    /// Written normals are unit vectors within rounding, and no pair is outside the unit disk, not even by a rounding.
    fn normals_are_unit(&self) {
        let Some(x) = self.channel("normal.x") else { return };
        let [y, z] = ["normal.y", "normal.z"].map(|role| self.channel(role));
        let y = y.unwrap();
        for (k, level) in self.levels.iter().enumerate().skip(1) {
            let (samples, max) = integers(level);
            for texel in samples.chunks_exact(self.channels()) {
                let side = |c: usize| 2 * texel[c] - max;
                let xy2 = side(x) * side(x) + side(y) * side(y);
                assert!(xy2 <= max * max, "{} level {k}: {texel:?}", self.name);
                if let Some(z) = z {
                    let length = ((xy2 + side(z) * side(z)) as f64).sqrt() / max as f64;
                    // Three components, each off by half of a step of 2 / max; near the rim one is a whole step shorter.
                    let rim = xy2 > max * max * 9 / 10;
                    let (bound, step) = (3f64.sqrt() / max as f64 + 1e-6, 2.0 / max as f64);
                    let low = 1.0 - bound - if rim { step } else { 0.0 };
                    assert!(low < length && length < 1.0 + bound, "{} level {k}: {texel:?}: {length}", self.name);
                }
            }
        }
    }

    /// No level is smoother than the smoothest texel of its footprint, or, if that was asked for, than the plain average.
    /// `true` if some level is clearly rougher than the plain average.
    fn never_too_smooth(&self, at_least_average: bool) -> bool {
        let roughness = |level: &Raster| {
            let rough = self.channel("perceptual-roughness").map(|c| plane(level, c));
            let smooth = || plane(level, self.channel("smoothness").unwrap()).into_iter().map(|v| 1.0 - v).collect();
            rough.unwrap_or_else(smooth)
        };
        if self.channel("perceptual-roughness").or(self.channel("smoothness")).is_none() {
            return false;
        }
        let mut most = 0.0;
        // Level 0 of a made-up map is rounded too.
        let rounding = self.rounding() * if self.input.is_some() { 1.0 } else { 2.0 };
        let base = roughness(&self.levels[0]);
        for (k, level) in self.levels.iter().enumerate().skip(1) {
            let average = shrink(&base, self.size(), level.size());
            let smoothest = least(&base, self.size(), level.size());
            for (i, got) in roughness(level).iter().map(|got| f64::from(*got)).enumerate() {
                let least = if at_least_average { average[i] } else { f64::from(smoothest[i]) } - rounding;
                assert!(got >= least, "{} level {k} texel {i}: {got} for {least}", self.name);
                most = f64::max(most, got - average[i]);
            }
        }
        most > 0.05
    }
}

/// The least value in the footprint of each texel of a smaller level.
fn least(values: &[f32], from: Size, to: Size) -> Vec<f32> {
    let span = |i: usize, n: usize, m: usize| i * n / m..((i + 1) * n).div_ceil(m);
    let texel = |i: usize| {
        let rows = span(i / to.width, from.height, to.height);
        let columns = span(i % to.width, from.width, to.width);
        rows.flat_map(|y| &values[y * from.width..][columns.clone()]).copied().fold(f32::INFINITY, f32::min)
    };
    (0..to.texels()).into_par_iter().map(texel).collect()
}

/// Everything that holds for any material. Whether it has channels that are not ours, and whether it got rougher.
fn hold(built: &Value) -> (bool, bool) {
    let name = built["name"].as_str().unwrap();
    let folder = PathBuf::from(built["folder"].as_str().unwrap());
    let mut files = strings(&built["files"]);
    files.sort();
    assert_eq!(names(&folder), files, "{name}: files on disk and in the report");

    let manifest = manifest(&folder);
    assert_eq!((&manifest["schema"], &manifest["generator"]), (&1.into(), &"mipfold".into()), "{name}");
    assert_eq!(manifest["material"], name);
    let mut listed: Vec<_> = manifest["maps"].as_array().unwrap().iter().flat_map(|m| strings(&m["files"])).collect();
    listed.push("manifest.json".into());
    listed.sort();
    assert_eq!(listed, files, "{name}: files in the manifest");

    let size = size_of(&manifest["size"]);
    assert_eq!(size, size_of(built), "{name}");
    let mut inputs = BTreeMap::new();
    for input in manifest["inputs"].as_array().unwrap() {
        let path = PathBuf::from(input["path"].as_str().unwrap());
        let digest = Sha256::digest(std::fs::read(&path).unwrap());
        let digest: String = digest.iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(input["sha256"], digest, "{name}: {}", path.display());
        let decoded = codec::read(&path).unwrap();
        assert_eq!(size_of(&input["size"]), decoded.raster.size(), "{name}");
        assert_eq!(input["format"], decoded.format, "{name}");
        // An enlarged map is not its input any more.
        if decoded.raster.size() == size {
            inputs.insert(path.file_stem().unwrap().to_str().unwrap().to_owned(), decoded.raster);
        }
    }
    let complete = strings(&manifest["warnings"]).iter().all(|w| !w.contains("the fold ignores them"));
    let (mut others, mut rougher) = (0, false);
    for entry in manifest["maps"].as_array().unwrap() {
        let files = strings(&entry["files"]);
        let stem = files[0].strip_suffix("_mip0.png").unwrap();
        let map = Map {
            name: format!("{name}/{stem}"),
            entry,
            levels: png_levels(&folder, stem),
            input: inputs.remove(stem),
        };
        assert_eq!((map.levels.len(), map.size()), (files.len(), size), "{}", map.name);
        map.levels_halve();
        map.level_0_is_the_input();
        others += map.other_channels_are_plain_means();
        map.normals_are_unit();
        // Texels without a normal do not count in the fold, but do in a plain average.
        if complete {
            rougher |= map.never_too_smooth(manifest["at_least_average"] == true);
        }
    }
    // Heights become normals under another name.
    inputs.retain(|stem, _| !files.contains(&format!("{stem}_normal_mip0.png")));
    assert!(inputs.is_empty(), "{name}: no output for {:?}", inputs.keys());
    (others > 0, rougher)
}

#[test]
fn every_material_of_the_textures_builds() {
    let Some(textures) = common::textures() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = mipfold().args(["build", "--json"]).arg(&textures).arg("-o").arg(&out).output().unwrap();
    assert_eq!(run.status.code(), Some(0));
    assert!(run.stderr.is_empty(), "{}", String::from_utf8_lossy(&run.stderr));
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(report["errors"], Value::Array(vec![]));
    let materials = report["materials"].as_array().unwrap();
    let warnings = |name: &str| {
        let material = materials.iter().find(|m| m["name"] == name).unwrap_or_else(|| panic!("no {name}"));
        strings(&material["warnings"])
    };
    let srgb = warnings("defense_wall_srgb");
    assert!(srgb.len() == 1 && srgb[0].contains("looks sRGB-encoded"), "{srgb:?}");
    let directionless = warnings("copper_tiles_01");
    let count = "803 of 4194304 normals (0.019 %) have no direction";
    assert!(directionless.len() == 1 && directionless[0].contains(count), "{directionless:?}");
    let warned = materials.iter().filter(|m| m["warnings"].as_array().is_some_and(|w| !w.is_empty())).count();
    assert_eq!(warned, 2);

    // Folders of one set are named after the folder.
    let subs = names(&textures).into_iter().map(|name| textures.join(name));
    for sub in subs.filter(|sub| sub.is_dir()) {
        let maps = names(&sub).iter().any(|f| f.starts_with("normal.") || f.starts_with("normal_roughness."));
        let name = sub.file_name().unwrap().to_str().unwrap().to_owned();
        assert!(!maps || materials.iter().any(|m| m["name"] == name.as_str()), "{name} was not found");
    }
    let held: Vec<_> = materials.par_iter().map(hold).collect();
    // Five packed maps of the helmet, the woven fabric, and two normal maps with alpha.
    assert!(held.iter().filter(|(others, _)| *others).count() >= 8);
    let rougher = held.iter().filter(|(_, rougher)| *rougher).count();
    assert!(rougher >= 15, "{rougher} of {} got rougher", held.len());
}

#[test]
fn real_materials_can_be_kept_at_least_as_rough_as_their_average() {
    let Some(textures) = common::textures() else { return };
    let build = |set: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (set, out) = (textures.join(set), folder.path().join("out"));
        let run =
            mipfold().args(["build", "--json", "--at-least-average"]).arg(set).arg("-o").arg(&out).output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
        let report: Value = serde_json::from_slice(&run.stdout).unwrap();
        let (_, rougher) = hold(&report["materials"][0]);
        rougher
    };
    let rougher = ["rock058", "tiles107", "metal027"].map(build);
    assert!(rougher.contains(&true), "{rougher:?}");
}

fn digests(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let digest = |name: String| {
        let digest = Sha256::digest(std::fs::read(folder.join(&name)).unwrap()).to_vec();
        (name, digest)
    };
    names(folder).into_iter().map(digest).collect()
}

#[test]
fn the_bytes_do_not_depend_on_threads_or_runs() {
    let Some(textures) = common::textures() else { return };
    let helmet = |map: &str| format!("gltf_flight_helmet/FlightHelmet_Materials_LeatherPartsMat_{map}.png");
    let sets = [
        ("paper001/normal.jpg".to_owned(), "--roughness", "paper001/roughness.jpg".to_owned(), "aniso"),
        (helmet("Normal"), "--orm", helmet("OcclusionRoughMetal"), "iso"),
    ];
    for (normal, flag, rough, lobes) in sets {
        let folder = tempfile::tempdir().unwrap();
        let [normal, rough] = [normal, rough].map(|file| textures.join(file));
        let all = ["1", "4", "4"].map(|threads| {
            let out = folder.path().join("out");
            let maps = [("--normal", normal.as_os_str()), (flag, rough.as_os_str())];
            let rest = [("--lobes", lobes), ("--threads", threads), ("--format", "png,exr"), ("--name", "set")];
            let rest = rest.map(|(flag, value)| (flag, value.as_ref()));
            let flags = maps.into_iter().chain(rest).flat_map(|(flag, value)| [flag.as_ref(), value]);
            build(flags.chain(["--moments".as_ref()]), &out);
            let digests = digests(&out);
            std::fs::remove_dir_all(&out).unwrap();
            digests
        });
        assert!(all[0].len() > 20 && all[0].contains_key("set_lobes.exr"), "{:?}", all[0].keys());
        assert_eq!(all[0], all[1], "{}: one thread and four", normal.display());
        assert_eq!(all[1], all[2], "{}: two runs", normal.display());
    }
}

/// One surface was baked in both conventions: the same roughness, and green mirrored, but for what JPEG does to each.
#[test]
fn both_y_conventions_of_one_surface_agree() {
    let Some(textures) = common::textures() else { return };
    for set in ["paper001", "metal027"] {
        let set = textures.join(set);
        let folder = tempfile::tempdir().unwrap();
        let levels = |file: &str, y: &str| {
            let (normal, roughness) = (set.join(file), set.join("roughness.jpg"));
            let out = folder.path().join(y);
            let flags = ["--normal", "--roughness", "--normal-y"].map(AsRef::<std::ffi::OsStr>::as_ref);
            let values = [normal.as_ref(), roughness.as_ref(), y.as_ref()];
            build(flags.into_iter().zip(values).flat_map(|(flag, value)| [flag, value]), &out);
            (png_levels(&out, normal.file_stem().unwrap().to_str().unwrap()), png_levels(&out, "roughness"))
        };
        let (gl, dx) = (levels("normal.jpg", "opengl"), levels("normal_dx.jpg", "directx"));
        let mut lean = 0;
        for k in 1..gl.0.len() {
            // Noise of single texels averages away.
            let (normal, rough) = [(12, 3), (6, 2), (4, 1)].get(k - 1).copied().unwrap_or((2, 1));
            let (a, b) = (integers(&gl.0[k]).0, integers(&dx.0[k]).0);
            for (a, b) in a.chunks_exact(3).zip(b.chunks_exact(3)) {
                let off = [a[0] - b[0], a[1] - (255 - b[1]), a[2] - b[2]];
                assert!(off.iter().all(|d| d.abs() <= normal), "{} level {k}: {a:?} {b:?}", set.display());
                lean = lean.max((a[1] - b[1]).abs());
            }
            let off = integers(&gl.1[k]).0.iter().zip(integers(&dx.1[k]).0).map(|(a, b)| (a - b).abs()).max();
            assert!(off.unwrap() <= rough, "{} level {k}: roughness differs by {off:?}", set.display());
        }
        assert!(lean > 10, "the surface has no slope to mirror");
    }
}
