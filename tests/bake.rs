//! `mipfold bake-curvature`: on a cylinder whose answer is known, on real meshes and glTF models, and on bad input.

mod common;

use std::path::Path;

use common::desk::Desk;
use common::mesh::{glb, obj, sheared};
use common::{bump, channel, encode8, entry, exr_levels, levels, manifest, mipfold, names, plane, png8, strings};
use glam::DVec3;
use mipfold::curvature::{LoadOptions, load, vertex_curvature};
use mipfold::kernels::twins::footprint::carried_kernel;
use mipfold::kernels::twins::geometric_aa::{add_kernel_projected, add_kernel_projected_mean};
use mipfold::kernels::twins::moments::decode_tensor_root;
use mipfold::material::read_lobes;
use mipfold::ndf::{Lobe, Lobes};

/// What texels that each see `1 / width` of the way around a cylinder add around it: normals evenly over an arc.
fn around(width: usize) -> f64 {
    let angle = std::f64::consts::TAU / width as f64;
    1.0 - angle.sin() / angle
}

/// `mipfold bake-curvature ARGS`, which must end well; what it says on stderr.
fn bake(desk: &Desk, args: &str) -> String {
    let (code, stderr) = desk.run(&format!("bake-curvature {args}"));
    assert_eq!(code, Some(0), "{args}: {stderr}");
    assert!(stderr.lines().all(|line| line.starts_with("warning: ")), "{args}: {stderr}");
    stderr
}

/// It must refuse, on one line that holds this, and leave the desk as it was.
fn refuses(desk: &Desk, args: &str, culprit: &str) {
    let before = desk.tree();
    let (code, stderr) = desk.run(&format!("bake-curvature {args}"));
    assert_eq!(code, Some(2), "{args}: {stderr}");
    assert!(stderr.lines().count() == 1 && stderr.starts_with("error: "), "{args}: {stderr}");
    assert!(stderr.contains(culprit), "{args}: {stderr} does not say {culprit}");
    assert_eq!(desk.tree(), before, "{args}: files changed");
}

fn lobes(file: &Path) -> Vec<Lobes> {
    read_lobes(file).unwrap_or_else(|e| panic!("{e}")).levels
}

/// Every lobe of levels that have the same sizes.
fn pairs<'a>(a: &'a Lobes, b: &'a Lobes) -> impl Iterator<Item = (Lobe, Lobe)> + 'a {
    let size = a.size();
    assert_eq!(size, b.size());
    (0..size.texels()).map(move |i| (i % size.width, i / size.width)).map(|(x, y)| (a.at(x, y), b.at(x, y)))
}

#[test]
fn a_cylinder_without_maps_widens_around_itself() {
    let desk = Desk::empty();
    obj(&desk.at("pipe.obj"), true, true);
    let said = bake(&desk, "@pipe.obj -o @out --size 128x32 --roughness 0.2 --lobes aniso --format png,exr --float");
    assert_eq!(said, "");
    let out = desk.at("out");
    let manifest = manifest(&out);
    let roughness = levels(&out, &entry(&manifest, "roughness", "png")["files"]);
    let [png, exr] = ["png", "exr"].map(|c| levels(&out, &entry(&manifest, "curvature", c)["files"]));
    for (k, lobes) in lobes(&out.join("pipe_lobes.exr")).iter().enumerate() {
        let width = lobes.size().width;
        // All the way around there is no direction that normals spread along.
        if width == 1 {
            continue;
        }
        let (base, added) = (0.04f64 * 0.04, around(width));
        let wide = if k == 0 { base } else { add_kernel_projected_mean(base, added) };
        let root = |r: &mipfold::image::Raster| [0, 1, 2].map(|c| f64::from(plane(r, c)[0]));
        let tensor = decode_tensor_root(DVec3::from_array(root(&png[k])));
        assert!((tensor.x.sqrt() - added.sqrt()).abs() < 0.004 && tensor.z.abs() < 1e-4, "level {k}: {tensor}");
        for i in 0..lobes.size().texels() {
            let axes = lobes.at(i % width, i / width).axes();
            assert!((f64::from(axes.alpha_x.squared()) / wide - 1.0).abs() < 1e-3, "level {k}: {axes:?}, {wide}");
            assert!((axes.alpha_y.0 - 0.04).abs() < 1e-4, "level {k}: {axes:?}");
            assert!(k == 0 || axes.angle.abs() < 1e-3, "level {k}: {axes:?}");
            // The smaller width is what a renderer of glTF reads as the roughness.
            assert!((plane(&roughness[k], 0)[i] - 0.2).abs() < 0.003);
            let [xx, yy] = ["k.xx", "k.yy"].map(|name| f64::from(channel(&exr[k], name)[i]));
            assert!((xx / added - 1.0).abs() < 1e-3 && yy.abs() < 1e-6, "level {k}: {xx} {yy}");
        }
    }
    // The judge knows only the texture, and says so.
    let judged = mipfold().args(desk.args("compare @out --texels 1 --directions 4 --levels 2")).output().unwrap();
    let [said, warned] = [judged.stdout, judged.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(
        said.contains("Nothing can be said: the curvature of") && warned.contains("pipe.obj is in this chain"),
        "{said}{warned}"
    );
    // One width takes the mean of both axes, and is the roughness.
    bake(&desk, "@pipe.obj -o @round --size 128x32 --roughness 0.2");
    let manifest = common::manifest(&desk.at("round"));
    let roughness = levels(&desk.at("round"), &entry(&manifest, "roughness", "png")["files"]);
    for (k, level) in roughness.iter().enumerate().filter(|(_, level)| level.size().width > 1) {
        let added = if k == 0 { 0.0 } else { 0.5 * around(level.size().width) };
        let expected = add_kernel_projected_mean(0.04 * 0.04, added).powf(0.25);
        let found = plane(level, 0);
        assert!(found.iter().all(|r| (f64::from(*r) - expected).abs() < 0.004), "level {k}: {} {expected}", found[0]);
    }
}

/// A glb with both: each folded lobe of its maps, widened by the cylinder's arc as the shader's formulas have it.
#[test]
fn maps_of_a_glb_are_folded_together_with_its_mesh() {
    let desk = Desk::empty();
    let size = (64, 16);
    let normal = std::fs::read(common::bumps(&desk.at("normal.png"), size)).unwrap();
    let rough = |x: usize, y: usize| vec![255, 60 + (x * 7 + y * 3) as u8 % 100, 0];
    let width = std::fs::read(png8(&desk.at("orm.png"), size, rough)).unwrap();
    let material = serde_json::json!([{
        "name": "pipe",
        "normalTexture": { "index": 0, "scale": 0.7 },
        "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 } },
    }]);
    glb(&desk.at("pipe.glb"), material, &[normal, width]);
    for form in ["iso", "aniso"] {
        let format = format!("--lobes {form} --format exr --float");
        let plain =
            desk.build("plain", &format!("--normal @normal.png --normal-scale 0.7 --orm @orm.png --name p {format}"));
        assert_eq!(bake(&desk, &format!("@pipe.glb -o @out {format} --name p")), "");
        let out = desk.at("out");
        assert!(names(&out).contains(&"p_curvature.exr".to_owned()), "{:?}", names(&out));
        let [before, after] = [&plain, &out].map(|folder| lobes(&folder.join("p_lobes.exr")));
        for (k, (before, after)) in before.iter().zip(&after).enumerate().filter(|(_, (l, _))| l.size().width > 1) {
            for (old, new) in pairs(before, after) {
                assert!((old.normal - new.normal).length() < 1e-5, "level {k}");
                let n = old.normal.as_dvec3();
                let added = if k == 0 { 0.0 } else { around(before.size().width) };
                let mesh = carried_kernel(n, DVec3::new(added, 0.0, 0.0));
                let [r, found] = [old, new].map(|lobe| {
                    let r = lobe.roughness;
                    DVec3::new(r.xx.into(), r.xy.into(), r.yy.into())
                });
                if form == "aniso" {
                    let expected = add_kernel_projected(r, mesh);
                    assert!((found - expected).abs().max_element() < 1e-4, "level {k}: {found} {expected}");
                } else {
                    let expected = add_kernel_projected_mean(r.x, 0.5 * (mesh.x + mesh.z));
                    assert!((found.x - expected).abs() < 1e-4, "level {k}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn factors_groups_and_parts_of_a_glb() {
    let desk = Desk::empty();
    let size = (32, 8);
    let normal = std::fs::read(png8(&desk.at("n.png"), size, |x, y| bump(x, y, 8).map(encode8).to_vec())).unwrap();
    let width = std::fs::read(png8(&desk.at("w.png"), size, |x, _| vec![9, 200 + x as u8, 0])).unwrap();
    let maps =
        |factor: f32| serde_json::json!({ "metallicRoughnessTexture": { "index": 1 }, "roughnessFactor": factor });
    let materials = serde_json::json!([
        { "name": "a", "normalTexture": { "index": 0 }, "pbrMetallicRoughness": maps(1.0) },
        { "name": "b", "normalTexture": { "index": 0 }, "pbrMetallicRoughness": maps(1.0) },
        { "name": "half", "normalTexture": { "index": 0 }, "pbrMetallicRoughness": maps(0.5) },
        { "name": "plain", "pbrMetallicRoughness": { "roughnessFactor": 0.25 } },
        { "name": "moved", "normalTexture": { "index": 0, "extensions": { "KHR_texture_transform": {} } } },
        { "name": "split", "normalTexture": { "index": 0, "texCoord": 1 }, "pbrMetallicRoughness": maps(1.0) },
    ]);
    glb(&desk.at("m.glb"), materials, &[normal, width]);
    // What cannot be read is said, and does not hide the others.
    let (code, stderr) = desk.run("bake-curvature @m.glb -o @out --size 16");
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("\"moved\"") && stderr.contains("KHR_texture_transform"), "{stderr}");
    assert!(stderr.contains("\"split\"") && stderr.contains("TEXCOORD_1"), "{stderr}");
    assert_eq!(names(&desk.at("out")), ["a", "half", "plain"]);
    // One chain for materials that share maps, whose surfaces lie on each other here.
    let shared = manifest(&desk.at("out/a"));
    assert!(strings(&shared["notes"]).iter().any(|note| note.contains("material b")), "{}", shared["notes"]);
    let green = |folder: &str, role: &str| {
        let folder = desk.at(folder);
        let manifest = manifest(&folder);
        let level = levels(&folder, &entry(&manifest, role, "png")["files"]).remove(0);
        plane(&level, if level.channels.len() > 1 { 1 } else { 0 })
    };
    let [whole, half] = ["out/a", "out/half"].map(|folder| green(folder, "roughness"));
    assert!(whole.iter().zip(&half).all(|(a, b)| (0.5 * a - b).abs() < 0.003));
    assert!(strings(&manifest(&desk.at("out/half"))["notes"]).iter().any(|n| n.contains("roughness factor 0.5")));
    assert!(green("out/plain", "roughness").iter().all(|r| (r - 0.25).abs() < 0.003));
    // One part by name goes to the folder itself; a width that is given stands for the file's.
    bake(&desk, "@m.glb -o @one --size 16 --part plain --roughness 0.75");
    assert!(green("one", "roughness").iter().all(|r| (r - 0.75).abs() < 0.003));
    refuses(&desk, "@m.glb -o @no --part plain --part half --name x", "2 materials");
    refuses(&desk, "@m.glb -o @no --part nobody", "one of a, b, half, moved, plain, split");
    refuses(&desk, "@m.glb -o @no --part plain --part half --normal @n.png", "name it with --part");
    refuses(&desk, "@m.glb -o @no --part plain --normal-y directx", "a model says how its own maps are read");
    // Maps that are given stand for those of the file, also where these cannot be followed.
    bake(&desk, "@m.glb -o @given --part moved --normal @n.png --roughness 0.5");
    assert!(green("given", "roughness").iter().all(|r| (r - 0.5).abs() < 0.003));
    // Of two materials one cannot be read: the other has a folder of its own all the same.
    let (code, _) = desk.run("bake-curvature @m.glb -o @two --part moved --part plain --size 16");
    assert_eq!((code, names(&desk.at("two"))), (Some(2), vec!["plain".to_owned()]));
}

/// A texture that climbs around the cylinder: what is added points around, in the texture's own frame.
#[test]
fn directions_follow_the_texture() {
    let desk = Desk::empty();
    let shear = 4.0f64;
    sheared(&desk.at("screw.obj"), true, true, shear as f32);
    bake(&desk, "@screw.obj -o @out --size 64x16 --roughness 0.2 --lobes aniso --format exr --float");
    let (cos, sin) = (
        std::f64::consts::TAU.hypot(shear).recip() * std::f64::consts::TAU,
        -shear / std::f64::consts::TAU.hypot(shear),
    );
    let file = exr_levels(&desk.at("out/screw_curvature.exr"));
    for (k, level) in file.iter().enumerate().filter(|(_, level)| level.size().width > 8) {
        let added = around(level.size().width);
        let found = ["k.xx", "k.xy", "k.yy"].map(|name| f64::from(channel(level, name)[1]));
        for (found, expected) in found.into_iter().zip([cos * cos, cos * sin, sin * sin]) {
            assert!((found - added * expected).abs() < 1e-2 * added, "level {k}: {found} {}", added * expected);
        }
    }
    for lobes in &lobes(&desk.at("out/screw_lobes.exr"))[1..3] {
        let angle = f64::from(lobes.at(3, 0).axes().angle);
        assert!((angle - sin.atan2(cos)).abs() < 0.01, "{angle}");
    }
}

/// Texture coordinates are those that a material's maps ask for, and parts are found again in each set of them.
#[test]
fn materials_take_their_own_texture_coordinates() {
    let desk = Desk::empty();
    let width = std::fs::read(png8(&desk.at("w.png"), (16, 8), |_, _| vec![100])).unwrap();
    let maps = |set: usize| serde_json::json!({ "metallicRoughnessTexture": { "index": 0, "texCoord": set } });
    let materials = serde_json::json!([
        { "name": "both", "sets": [["TEXCOORD_0"], [], ["TEXCOORD_0", "TEXCOORD_1"]] },
        { "name": "second", "sets": [["TEXCOORD_1"]], "pbrMetallicRoughness": maps(1) },
        { "name": "none", "sets": [[]], "pbrMetallicRoughness": { "roughnessFactor": 0.5 } },
    ]);
    glb(&desk.at("m.glb"), materials, &[width]);
    bake(&desk, "@m.glb -o @out --size 16");
    assert_eq!(names(&desk.at("out")), ["both", "both_vertices", "none", "second"]);
    let second = manifest(&desk.at("out/second"));
    assert_eq!((&second["mesh"]["uv_set"], &second["mesh"]["triangles"]), (&1.into(), &1024.into()));
    assert_eq!(manifest(&desk.at("out/both"))["mesh"]["triangles"], 2048);
    // A gray map is green, as in glTF.
    let map = levels(&desk.at("out/second"), &entry(&second, "roughness", "png")["files"]);
    assert!(map[0].channels.len() == 3 && (plane(&map[0], 1)[0] - 100.0 / 255.0).abs() < 1e-6);
}

/// Files of an earlier bake go when they are not renewed; inputs and strangers' files stay.
#[test]
fn a_bake_after_another_leaves_no_orphans() {
    let desk = Desk::empty();
    std::fs::create_dir(desk.at("out")).unwrap();
    obj(&desk.at("pipe.obj"), true, true);
    bake(&desk, "@pipe.obj -o @out --size 16 --roughness 0.3");
    assert!(names(&desk.at("out")).contains(&"roughness_mip3.png".to_owned()));
    obj(&desk.at("pipe.obj"), false, true);
    bake(&desk, "@pipe.obj -o @out");
    assert_eq!(names(&desk.at("out")), ["manifest.json", "pipe_curvature.ply"]);
    bake(&desk, "@pipe.obj -o @named --name hose");
    assert_eq!(names(&desk.at("named")), ["hose_curvature.ply", "manifest.json"]);
    refuses(&desk, "@pipe.obj -o @out --name hose", "another material, 'pipe'");
    // A level of an earlier build that is a map of this model.
    let material = |factor: f32| {
        let texture = serde_json::json!({ "index": 0 });
        serde_json::json!([{ "pbrMetallicRoughness": { "metallicRoughnessTexture": texture, "roughnessFactor": factor } }])
    };
    let width = std::fs::read(png8(&desk.at("w.png"), (8, 8), |_, _| vec![9, 100, 0])).unwrap();
    glb(&desk.at("model.glb"), material(0.5), &[width]);
    bake(&desk, "@model.glb -o @out2 --name m");
    let inputs = &manifest(&desk.at("out2"))["inputs"];
    assert!(inputs[0]["path"].as_str().unwrap().ends_with("model.glb/image 0/metallic_roughness.png"), "{inputs}");
}

#[test]
fn a_mesh_without_texture_coordinates_is_baked_at_its_vertices() {
    let desk = Desk::empty();
    obj(&desk.at("bare.obj"), false, true);
    bake(&desk, "@bare.obj -o @out");
    assert_eq!(names(&desk.at("out")), ["bare_curvature.ply", "manifest.json"]);
    let options = LoadOptions::default();
    let [mesh, written] = ["bare.obj", "out/bare_curvature.ply"].map(|file| load(&desk.at(file), &options).unwrap());
    assert_eq!((&mesh.positions, &mesh.triangles), (&written.positions, &written.triangles));
    assert_eq!(mesh.normals, written.normals);
    let bytes = std::fs::read(desk.at("out/bare_curvature.ply")).unwrap();
    let start = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    for (i, expected) in vertex_curvature(&mesh).iter().enumerate() {
        let at = |k: usize| {
            let place = start + 4 * (12 * i + 6 + k);
            f64::from(f32::from_le_bytes(bytes[place..place + 4].try_into().unwrap()))
        };
        assert!((0..6).all(|k| (at(k) - expected.form[k]).abs() < 1e-6), "vertex {i}");
        // A cylinder of radius 1: one curvature of 1, one of 0.
        assert!((expected.mean_square() - 0.5).abs() < 1e-2, "vertex {i}: {expected:?}");
    }
    // Ours, so that it is written again; a stranger's file is not.
    bake(&desk, "@bare.obj -o @out");
    std::fs::create_dir(desk.at("other")).unwrap();
    desk.file("other/bare_curvature.ply", b"mine");
    refuses(&desk, "@bare.obj -o @other", "a file that mipfold did not write");
}

#[test]
fn what_is_missing_is_said() {
    let desk = Desk::empty();
    obj(&desk.at("bare.obj"), true, false);
    let said = bake(&desk, "@bare.obj -o @out --size 16 --crease 90");
    assert!(said.lines().count() == 1 && said.contains("lacks normals") && said.contains("--crease"), "{said}");
    refuses(&desk, "@bare.obj -o @no --normal-scale 2", "and no map");
    let said = strings(&manifest(&desk.at("out"))["notes"]);
    assert!(said.iter().any(|note| note.contains("--roughness")), "no roughness was given: {said:?}");
    let before = desk.tree();
    bake(&desk, "@bare.obj -o @dry --size 16 --dry-run");
    assert_eq!(desk.tree(), before);
    refuses(&desk, "@nowhere.obj -o @no", "nowhere.obj");
    desk.file("cut.glb", b"glTF\x02\0\0\0");
    refuses(&desk, "@cut.glb -o @no", "cut.glb");
    desk.file("words.obj", b"nothing here");
    refuses(&desk, "@words.obj -o @no", "words.obj");
    for (size, expected) in [("0", "1 to"), ("16x", "1 to"), ("99999", "1 to")] {
        let (code, stderr) = desk.run(&format!("bake-curvature @bare.obj -o @no --size {size}"));
        assert!(code == Some(2) && stderr.contains(expected), "{size}: {stderr}");
    }
    let json = mipfold().args(desk.args("bake-curvature @bare.obj -o @json --size 16 --json")).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((&json["materials"][0]["name"], &json["materials"][0]["levels"]), (&"bare".into(), &5.into()));
}

/// Real models that have both: at every texel and level at least as wide as their maps alone.
#[test]
fn real_models_are_baked_with_their_maps() {
    let Some(textures) = common::textures() else { return };
    let desk = Desk::empty();
    let model = textures.join("gltf_tea_set_01/tea_set_01_1k.gltf");
    let format = "--fold projected --format exr --float --name tea";
    bake(&desk, &format!("{} -o @out {format}", model.display()));
    let maps = textures.join("gltf_tea_set_01/textures");
    let maps = ["tea_set_01_nor_gl_1k.jpg", "tea_set_01_arm_1k.jpg"].map(|name| maps.join(name).display().to_string());
    let plain = desk.build("plain", &format!("--normal {} --orm {} {format}", maps[0], maps[1]));
    let [before, after] = [&plain, &desk.at("out")].map(|folder| lobes(&folder.join("tea_lobes.exr")));
    let mut wider = 0;
    for (k, (before, after)) in before.iter().zip(&after).enumerate() {
        for (old, new) in pairs(before, after) {
            let (old, new) = (old.roughness.mean(), new.roughness.mean());
            assert!(new >= old - 1e-6, "level {k}: {new} below {old}");
            wider += usize::from(k == 3 && new > 1.1 * old);
        }
    }
    assert!(wider > 1000, "{wider} of the texels of level 3 are wider");
    // A helmet whose hose and wood share maps; a flashlight with pictures of every kind inside.
    let helmet = textures.join("gltf_flight_helmet/FlightHelmet.gltf");
    let run = mipfold().arg("bake-curvature").arg(helmet).args(desk.args("-o @dry --dry-run --json")).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let built = json["materials"].as_array().unwrap();
    let found: Vec<_> = built.iter().map(|built| built["name"].as_str().unwrap()).collect();
    assert_eq!(found, ["HoseMat", "GlassPlasticMat", "MetalPartsMat", "LeatherPartsMat", "LensesMat"]);
    let flashlight = textures.join("glb_old_flashlight/old_flashlight.glb");
    bake(&desk, &format!("{} -o @light --fold projected --quiet", flashlight.display()));
    assert_eq!(names(&desk.at("light")), ["bulb1", "glass", "lambert1"]);
}

#[test]
fn real_meshes_are_baked() {
    let Some(meshes) = common::meshes() else { return };
    let desk = Desk::empty();
    for (file, found) in [
        ("spot/spot.obj", vec!["manifest.json"]),
        ("usd_shader_ball/shaderball.glb", vec!["manifest.json"]),
        ("cycloidal/cycloidal.ply", vec!["cycloidal_curvature.ply", "manifest.json"]),
        ("shader_ball/shader_ball.gltf", vec!["Base", "Inside", "Outside"]),
    ] {
        let out = desk.at(&format!("out/{}", file.split('/').next().unwrap()));
        let mesh = meshes.join(file);
        bake(&desk, &format!("{} -o {} --size 128 --roughness 0.3 --format exr", mesh.display(), out.display()));
        let there = names(&out);
        assert!(found.iter().all(|name| there.iter().any(|n| n == name)), "{file}: {there:?}");
        if file.starts_with("spot") {
            let level = &exr_levels(&out.join("roughness.exr"))[3];
            let widest = plane(level, 0).into_iter().fold(0.0, f32::max);
            assert!(widest > 0.4, "{file}: {widest}");
        }
    }
}
