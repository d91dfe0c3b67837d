//! `mipfold build` of glTF models: what changes in them, and above all what does not.

mod common;

use std::path::Path;

use common::desk::Desk;
use common::model::{Scene, Written, complaints, glb, validator};
use common::{bump, encode8, strings};
use mipfold::codec::{self, read_levels};
use mipfold::fold::{Options, chain};
use mipfold::image::{Raster, Samples};
use mipfold::material::{ChannelRef, Encoding, Inputs, LevelView, RoughnessInput, load};
use ndarray::Array3;
use serde_json::{Value, json};

const SIDE: usize = 32;

fn png(side: usize, texel: impl Fn(usize, usize) -> [u8; 3]) -> Vec<u8> {
    let samples = Array3::from_shape_fn((side, side, 3), |(y, x, c)| texel(x, y)[c]);
    let mut bytes = Vec::new();
    codec::write_png(&mut bytes, &Raster::new(Samples::U8(samples))).unwrap();
    bytes
}

fn normals() -> Vec<u8> {
    png(SIDE, |x, y| bump(x, y, 16).map(encode8))
}

/// Occlusion, roughness, metal.
fn orm(seed: u8) -> Vec<u8> {
    png(SIDE, |x, y| [200 + (x % 7) as u8, 50 + seed + (y % 5) as u8, if x > y { 255 } else { 0 }])
}

fn colours() -> Vec<u8> {
    png(SIDE, |x, y| [8 * x as u8, 8 * y as u8, 77])
}

/// A material of image 0 as normals and image 1 as the rest.
fn bumpy() -> Value {
    json!({
        "name": "wall",
        "normalTexture": { "index": 0, "scale": 0.8 },
        "occlusionTexture": { "index": 1, "strength": 0.5 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 2 }, "metallicRoughnessTexture": { "index": 1 } },
    })
}

fn pictures() -> Vec<(&'static str, Vec<u8>)> {
    vec![("n", normals()), ("orm", orm(0)), ("colour", colours())]
}

/// Builds `@in.glb`; what was written.
fn built(desk: &Desk, scene: &Scene, args: &str) -> Written {
    desk.file("in.glb", &scene.glb());
    let (code, stderr) = desk.run(&format!("build @in.glb -o @out.glb {args}"));
    assert_eq!(code, Some(0), "{stderr}");
    Written::read(&desk.at("out.glb"))
}

/// Materials by name, in what is written beside the model.
fn sidecar(desk: &Desk) -> Value {
    serde_json::from_slice(&std::fs::read(desk.at("out.mipfold.json")).unwrap()).unwrap()
}

/// Why a material of this index was left as it is.
fn reason(sidecar: &Value, material: usize) -> String {
    let all = sidecar["materials"].as_array().unwrap();
    let one = all.iter().find(|one| one["materials"].as_array().unwrap().contains(&material.into())).unwrap();
    assert_eq!(one["folded"], false, "{one}");
    one["reason"].as_str().unwrap().to_owned()
}

#[test]
fn a_material_gets_folded_textures_and_all_else_stays() {
    let desk = Desk::empty();
    let scene = Scene::new(json!([bumpy()]), &pictures(), json!({ "extras": { "note": "kept" } }));
    let text = serde_json::to_string(&scene.json).unwrap().replace("\"scale\":0.8", "\"scale\" :  8.0e-1");
    desk.file("in.glb", &glb(&text, &scene.binary));
    desk.run("build @in.glb -o @out.glb");
    let (before, after) = (Written::read(&desk.at("in.glb")), Written::read(&desk.at("out.glb")));
    // Numbers keep their spelling, unknown chunks stay.
    assert!(after.text.contains("\"scale\" :  8.0e-1") && after.others == before.others, "{}", after.text);
    for key in ["asset", "accessors", "materials", "meshes", "nodes", "scenes", "scene", "extras"] {
        assert_eq!(after.json[key], before.json[key], "{key}");
    }
    assert_eq!(after.json["extensionsUsed"], json!(["KHR_texture_basisu"]));
    assert_eq!(after.json["extensionsRequired"], json!(["KHR_texture_basisu"]));
    // Geometry and colours keep their bytes, wherever these lie now; the old pictures are gone.
    assert_eq!(
        after.json["bufferViews"].as_array().unwrap().len(),
        before.json["bufferViews"].as_array().unwrap().len()
    );
    for view in 2..8 {
        assert_eq!(after.view(view), before.view(view), "view {view}");
        assert_eq!(after.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() % 4, 0);
    }
    let count = |bytes: &[u8]| bytes.windows(4).filter(|four| four == b"\x89PNG").count();
    assert_eq!((count(&before.binary), count(&after.binary)), (3, 1));
    let length = after.json["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
    assert_eq!(length.next_multiple_of(4), after.binary.len());
    for (texture, image) in [(0, 0), (1, 1)] {
        assert_eq!(after.basisu(&texture.into()), image);
        assert_eq!(after.json["textures"][texture].get("source"), None);
        assert_eq!(after.json["images"][image]["name"], before.json["images"][image]["name"]);
        assert!(
            after.json["images"][image]["mimeType"] == "image/ktx2" && after.image(image).starts_with(b"\xabKTX 20")
        );
    }
    // What is written beside it: level 0 was the image, in every channel.
    let said = sidecar(&desk);
    let textures = said["materials"][0]["textures"].as_array().unwrap();
    let channels: Vec<_> = textures.iter().flat_map(|t| t["level_0"].as_array().unwrap()).collect();
    assert!(channels.len() == 6 && channels.iter().all(|c| c["identical"] == true), "{channels:?}");
    let states: Vec<_> = said["images"].as_array().unwrap().iter().map(|i| i["state"].clone()).collect();
    assert_eq!(states, ["folded", "folded", "kept"]);
    assert_eq!(said["images"][2]["before"], said["images"][2]["after"]);
}

/// The chain that is expected, and the levels of the texture that was written.
#[test]
fn textures_hold_the_fold_but_for_their_compression() {
    let desk = Desk::empty();
    let after = built(&desk, &Scene::new(json!([bumpy()]), &pictures(), json!({})), "");
    let inputs = Inputs {
        normal: Some(desk.file("n.png", &normals())),
        roughness: RoughnessInput::Roughness(ChannelRef { path: desk.file("orm.png", &orm(0)), channel: Some(1) }),
        normal_scale: Some(0.8),
        ..Inputs::default()
    };
    let material = load(&inputs).unwrap();
    let chain = chain(&material, &Options::default());
    let read = |name: &str, image: usize| read_levels(&desk.file(name, after.image(image))).unwrap();
    let (normals, rough) = (read("n.ktx2", 0), read("orm.ktx2", 1));
    assert_eq!((normals.len(), rough.len()), (6, 6));
    // Root mean square errors of normals and of the packed map: a tenth or so above what UASTC costs.
    let most = [[0.023, 0.004], [0.023, 0.017], [0.036, 0.024], [0.007, 0.008], [0.0015, 0.01], [0.002, 0.0025]];
    for k in 0..6usize {
        let folded = k.checked_sub(1).map(|i| (&chain.levels[i].lobes, &chain.levels[i].extras));
        let view = LevelView { material: &material, folded, main_axis: 0.0 };
        let size = view.size();
        let row = |map: usize, channel: usize, y: usize| {
            let mut row = vec![0.0; size.width];
            view.row(map, channel, Encoding::Unsigned, y, 0, &mut row);
            row
        };
        let error = |map: usize, channel: usize, raster: &Raster| {
            let all = (0..size.height).flat_map(|y| {
                let expected = row(map, channel, y).into_iter().enumerate();
                expected.map(move |(x, v)| f64::from(v - raster.at(x, y, channel)).powi(2))
            });
            (all.sum::<f64>() / size.texels() as f64).sqrt()
        };
        for channel in 0..3 {
            let (n, r) = (error(0, channel, &normals[k].raster), error(1, channel, &rough[k].raster));
            assert!(n < most[k][0] && r < most[k][1], "level {k}, channel {channel}: {n} {r}");
        }
    }
    // It is rougher far away, which is what all this is about.
    assert!(rough[5].raster.at(0, 0, 1) > rough[0].raster.at(0, 0, 1) + 0.1);
}

#[test]
fn shared_textures_are_folded_apart() {
    let desk = Desk::empty();
    let material = |orm: usize, occlusion: usize| {
        json!({
            "normalTexture": { "index": 0 },
            "occlusionTexture": { "index": occlusion },
            "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": orm } },
        })
    };
    // Two pairs with one normal map; a twin of the first; one without normals that uses the second roughness, and one whose
    // occlusion is somebody else's roughness.
    let plain = json!({ "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 2 } } });
    let materials = json!([material(1, 1), material(2, 1), material(1, 1), plain]);
    let images = vec![("n", normals()), ("a", orm(0)), ("b", orm(60))];
    let scene = Scene::new(
        materials,
        &images,
        json!({ "samplers": [{ "minFilter": 9987 }],
        "textures": [{ "source": 0, "sampler": 0 }, { "source": 1 }, { "source": 2 }] }),
    );
    let after = built(&desk, &scene, "");
    let m = |i: usize| &after.json["materials"][i];
    let rough = |i: usize| &m(i)["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"];
    // The twin is the same; the pairs differ, and keep their samplers.
    assert_eq!(m(0), m(2));
    let shown = [0, 1].map(|i| [after.basisu(&m(i)["normalTexture"]["index"]), after.basisu(rough(i))]);
    assert!(shown[0][0] != shown[1][0] && shown[0][1] != shown[1][1], "{shown:?}");
    for i in 0..2 {
        assert_eq!(after.json["textures"][m(i)["normalTexture"]["index"].as_u64().unwrap() as usize]["sampler"], 0);
    }
    // Occlusion that is the own roughness follows it; other occlusion, and roughness without normals, keep the old image.
    assert_eq!(&m(0)["occlusionTexture"]["index"], rough(0));
    let old = |texture: &Value| after.json["textures"][texture.as_u64().unwrap() as usize]["source"].clone();
    assert_eq!((old(&m(1)["occlusionTexture"]["index"]), old(rough(3))), (1.into(), 2.into()));
    assert_eq!((after.image(1), after.image(2)), (&images[1].1[..], &images[2].1[..]));
    assert!(reason(&sidecar(&desk), 3).contains("no normal map"));
    // The old normal map has no user left: its place is taken.
    assert!(after.image(0).starts_with(b"\xabKTX"));
    let ktx2 = |i: &Value| i["mimeType"] == "image/ktx2";
    assert_eq!(after.json["images"].as_array().unwrap().iter().filter(|i| ktx2(i)).count(), 4);
}

#[test]
fn what_cannot_be_folded_is_said_and_left_alone() {
    let desk = Desk::empty();
    let transform = |x: f64| json!({ "KHR_texture_transform": { "offset": [x, 0.0], "scale": [2, 2] } });
    let pair = |normal: Value, rough: Value| json!({ "normalTexture": normal, "pbrMetallicRoughness": { "metallicRoughnessTexture": rough } });
    let mut glossy = pair(json!({ "index": 0 }), json!({ "index": 1 }));
    glossy["extensions"] = json!({ "KHR_materials_pbrSpecularGlossiness": {} });
    let mut unlit = pair(json!({ "index": 0 }), json!({ "index": 1 }));
    unlit["extensions"] = json!({ "KHR_materials_unlit": {} });
    let materials = json!([
        pair(json!({ "index": 0, "extensions": transform(0.5) }), json!({ "index": 1, "extensions": transform(0.25) })),
        pair(json!({ "index": 0, "texCoord": 1 }), json!({ "index": 1 })),
        glossy,
        unlit,
        { "name": "bare" },
        pair(json!({ "index": 0, "extensions": transform(0.5), "texCoord": 1 }),
             json!({ "index": 1, "texCoord": 1, "extensions": transform(0.5) })),
    ]);
    let used = json!(["KHR_texture_transform", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit"]);
    let after = built(&desk, &Scene::new(materials.clone(), &pictures(), json!({ "extensionsUsed": used })), "");
    let said = sidecar(&desk);
    let words = ["laid out differently", "laid out differently", "SpecularGlossiness", "unlit", "no normal map"];
    for (i, word) in words.into_iter().enumerate() {
        assert!(reason(&said, i).contains(word), "{word}: {said}");
        assert_eq!(after.json["materials"][i], materials[i]);
    }
    // Equal transforms are no hindrance, and stay.
    let folded = &after.json["materials"][5];
    assert_eq!(folded["normalTexture"]["extensions"], materials[5]["normalTexture"]["extensions"]);
    assert_eq!(folded["normalTexture"]["texCoord"], 1);
    assert!(folded["normalTexture"]["index"].as_u64().unwrap() >= 3);
    // Others still need the old images.
    assert_eq!((after.image(0), after.image(1)), (&pictures()[0].1[..], &pictures()[1].1[..]));
}

#[test]
fn factors_stay_where_they_can_and_missing_textures_are_made() {
    let desk = Desk::empty();
    let flat = png(SIDE, |x, _| [128 + (x % 2) as u8, 128, 255]);
    let rough = |value: u8| png(SIDE, move |x, y| [9, if x + y == 0 { 255 } else { value }, 8]);
    let material = |normal: usize, rough: usize, factor: Value| {
        json!({ "normalTexture": { "index": normal, "texCoord": 1 }, "pbrMetallicRoughness":
            { "metallicRoughnessTexture": { "index": rough, "texCoord": 1 }, "roughnessFactor": factor, "metallicFactor": 0.5 } })
    };
    let mut bare = material(0, 2, json!(0.25));
    bare["pbrMetallicRoughness"].as_object_mut().unwrap().remove("metallicRoughnessTexture");
    let materials = json!([material(0, 2, json!(0.25)), material(1, 3, json!(0.75)), bare]);
    let images = vec![("bumps", normals()), ("flat", flat), ("smooth", rough(10)), ("rough", rough(100))];
    let after = built(&desk, &Scene::new(materials, &images, json!({})), "");
    let metallic = |i: usize| &after.json["materials"][i]["pbrMetallicRoughness"];
    let factors: Vec<_> = (0..3).map(|i| metallic(i)["roughnessFactor"].as_f64().unwrap()).collect();
    assert_eq!(factors, [1.0, 0.75, 1.0]);
    assert!((0..3).all(|i| metallic(i)["metallicFactor"] == 0.5));
    let made = &metallic(2)["metallicRoughnessTexture"];
    assert_eq!(made["texCoord"], 1);
    let texel = |i: usize, k: usize| {
        let image = after.basisu(&metallic(i)["metallicRoughnessTexture"]["index"]);
        let levels = read_levels(&desk.file("x.ktx2", after.image(image))).unwrap();
        [0, 1, 2].map(|c| levels[k].raster.at(9, 9, c))
    };
    let close = |a: [f32; 3], b: [f32; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.03), "{a:?} {b:?}");
    // Multiplied in; as it was; made: occlusion and metal are white.
    close(texel(0, 0), [9.0 / 255.0, 0.25 * 10.0 / 255.0, 8.0 / 255.0]);
    close(texel(1, 0), [9.0 / 255.0, 100.0 / 255.0, 8.0 / 255.0]);
    close(texel(2, 0), [1.0, 0.25, 1.0]);
    let said = sidecar(&desk);
    let identical = |group: usize| {
        let level_0 = said["materials"][group]["textures"][1]["level_0"].as_array().unwrap();
        level_0.iter().map(|c| c["identical"].as_bool().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!((identical(0), identical(1)), (vec![true, false, true], vec![true; 3]));
}

#[test]
fn anisotropy_is_folded_with_its_strength_and_its_rotation() {
    let desk = Desk::empty();
    let turn = std::f64::consts::FRAC_PI_2;
    let with = |anisotropy: Value| {
        let mut material = bumpy();
        material["extensions"] = json!({ "KHR_materials_anisotropy": anisotropy });
        material
    };
    let own = json!({ "anisotropyStrength": 0.9, "anisotropyRotation": turn, "anisotropyTexture": { "index": 3 } });
    let even = json!({ "anisotropyStrength": 0.5, "anisotropyRotation": turn });
    let brushed = png(SIDE, |_, y| [255, 128, 200 + (y % 4) as u8]);
    let images: Vec<_> = pictures().into_iter().chain([("brushed", brushed)]).collect();
    let used = json!({ "extensionsUsed": ["KHR_materials_anisotropy"] });
    let after = built(&desk, &Scene::new(json!([with(own), with(even)]), &images, used), "");
    let texel = |i: usize| {
        let anisotropy = &after.json["materials"][i]["extensions"]["KHR_materials_anisotropy"];
        assert!((anisotropy["anisotropyRotation"].as_f64().unwrap() - turn).abs() < 1e-9);
        let image = after.basisu(&anisotropy["anisotropyTexture"]["index"]);
        let levels = read_levels(&desk.file("x.ktx2", after.image(image))).unwrap();
        let strength = anisotropy["anisotropyStrength"].as_f64().unwrap() as f32;
        let of = |k: usize| [0, 1, 2].map(|c| levels[k].raster.at(0, 0, c));
        let [x, y, b] = of(0);
        assert!(levels.len() == 6 && of(5)[2] * strength > 0.02);
        [x, y, b * strength]
    };
    // Directions are those before the rotation, which the renderer adds.
    let close = |a: [f32; 3], b: [f32; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.04), "{a:?} {b:?}");
    close(texel(0), [1.0, 0.5, 0.9 * 200.0 / 255.0]);
    close(texel(1), [1.0, 0.5, 0.5]);
}

#[test]
fn images_that_strangers_may_use_stay() {
    let desk = Desk::empty();
    let used =
        json!({ "extensionsUsed": ["VENDOR_look"], "extensions": { "VENDOR_look": { "thumbnail": 0, "b": [[1]] } } });
    let scene = Scene::new(json!([bumpy()]), &pictures(), used.clone());
    let after = built(&desk, &scene, "");
    assert_eq!((after.image(0), after.image(1)), (&pictures()[0].1[..], &pictures()[1].1[..]));
    assert_eq!(after.json["extensions"], used["extensions"]);
    assert_eq!(after.json["images"].as_array().unwrap().len(), 5);
    assert_eq!(after.json["extensionsUsed"], json!(["VENDOR_look", "KHR_texture_basisu"]));
    // With a fallback nothing goes, and nothing is required.
    let desk = Desk::empty();
    let after = built(&desk, &Scene::new(json!([bumpy()]), &pictures(), json!({})), "--fallback");
    assert_eq!((after.json["textures"][0]["source"].as_u64(), after.basisu(&0.into())), (Some(0), 3));
    assert_eq!((after.image(0), after.json.get("extensionsRequired")), (&pictures()[0].1[..], None));
}

#[test]
fn text_and_binary_become_each_other() {
    let desk = Desk::empty();
    desk.file("in.glb", &Scene::new(json!([bumpy()]), &pictures(), json!({})).glb());
    let run = |args: &str| {
        let (code, stderr) = desk.run(&format!("build {args} -q"));
        assert_eq!(code, Some(0), "{args}: {stderr}");
    };
    run("@in.glb -o @a/text.gltf");
    let text = Written::read(&desk.at("a/text.gltf"));
    assert_eq!(text.json["buffers"][0]["uri"], "text.bin");
    assert_eq!(common::names(&desk.at("a")), ["text.bin", "text.gltf", "text.mipfold.json"]);
    // The colours as a file below, the rest as data in the text.
    let scene = Scene::new(json!([bumpy()]), &pictures(), json!({}));
    let base64 = |bytes: &[u8]| {
        use base64::Engine;
        format!("data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
    };
    std::fs::create_dir_all(desk.at("b/maps")).unwrap();
    desk.file("b/maps/my colour.png", &colours());
    desk.file("b/n.png", &normals());
    let mut json = scene.json.clone();
    json["buffers"][0]["uri"] = base64(&scene.binary).into();
    json["images"] = json!([{ "uri": "n.png" }, { "uri": base64(&orm(0)) }, { "uri": "maps/my%20colour.png" }]);
    desk.file("b/in.gltf", &serde_json::to_vec_pretty(&json).unwrap());
    run("@b/in.gltf -o @c/out.gltf");
    let names = strings(
        &serde_json::from_slice::<Value>(&std::fs::read(desk.at("c/out.mipfold.json")).unwrap()).unwrap()["files"],
    );
    assert_eq!(names, ["out.gltf", "out_wall_normal.ktx2", "maps/my colour.png", "out.mipfold.json"]);
    let after = Written::read(&desk.at("c/out.gltf"));
    assert_eq!(after.json["images"][0]["uri"], "out_wall_normal.ktx2");
    assert!(after.json["images"][1]["uri"].as_str().unwrap().starts_with("data:image/ktx2;base64,"));
    assert_eq!(after.json["buffers"], json["buffers"]);
    assert_eq!(std::fs::read(desk.at("c/maps/my colour.png")).unwrap(), colours());
    // Beside the input nothing is copied; and the second time it is ours to replace.
    run("@b/in.gltf -o @b/out.gltf");
    run("@b/in.gltf -o @b/out.gltf");
    run("@b/in.gltf -o @d.glb");
    let after = Written::read(&desk.at("d.glb"));
    assert_eq!(after.image(2), colours());
    assert!(after.json["buffers"][0].get("uri").is_none() && after.json["images"][2]["mimeType"] == "image/png");
    if let Some(validator) = validator() {
        for model in ["a/text.gltf", "c/out.gltf", "b/out.gltf", "d.glb"] {
            assert_eq!(complaints(&validator, &desk.at(model)), [""; 0], "{model}");
        }
    }
}

#[test]
fn nothing_is_written_over_or_of_broken_models() {
    let desk = Desk::empty();
    let scene = Scene::new(json!([bumpy()]), &pictures(), json!({}));
    let whole = scene.glb();
    desk.file("in.glb", &whole);
    desk.file("taken.glb", b"mine");
    desk.refuses("@in.glb -o @in.glb --force", "also an input");
    desk.refuses("@in.glb -o @taken.glb", "@taken.glb");
    desk.refuses("@in.glb -o @folder", ".glb or .gltf");
    desk.refuses("@in.glb @in.glb -o @out.glb", "one model at a time");
    desk.refuses("@in.glb -o @out.glb --lobes 2 --fold ggx-lobe", "one lobe");
    desk.refuses("@in.glb -o @out.glb --format png", "--format");
    for length in [11, 40, whole.len() / 2, whole.len() - 5] {
        desk.file("cut.glb", &whole[..length]);
        desk.refuses("@cut.glb -o @out.glb", "@cut.glb");
    }
    let broken = |change: &dyn Fn(&mut Value), culprit: &str| {
        let mut json = scene.json.clone();
        change(&mut json);
        desk.file("broken.glb", &glb(&json.to_string(), &scene.binary));
        desk.refuses("@broken.glb -o @out.glb", culprit);
    };
    broken(&|json| json["images"][2] = json!({ "uri": "../../secret.png" }), "secret.png");
    broken(&|json| json["images"][2] = json!({ "uri": "https://example.org/a.png" }), "example.org");
    broken(&|json| json["images"][0] = json!({ "uri": "/etc/passwd" }), "passwd");
    broken(&|json| json["images"][0]["bufferView"] = 99.into(), "99");
    broken(&|json| json["bufferViews"][0]["byteLength"] = 4_000_000_000u32.into(), "buffer view 0");
    broken(&|json| json["bufferViews"][0]["byteOffset"] = u64::MAX.into(), "buffer view 0");
    broken(&|json| json["buffers"][0]["byteLength"] = 9_000_000_000u64.into(), "9000000000");
    broken(&|json| json["textures"][0]["source"] = 1_000_000.into(), "1000000");
    broken(&|json| json["materials"][0]["normalTexture"]["index"] = 50.into(), "50");
    broken(&|json| json["materials"] = "many".into(), "\"many\"");
    broken(&|json| json["extensionsUsed"] = json!({}), "members of other kinds");
    desk.refuses("@in.glb -o @out.glb --fallback --compress bc", "--fallback");
    // Files of a .gltf, its outputs, and both under one name.
    std::fs::create_dir_all(desk.at("set/sub")).unwrap();
    let text = |buffer: &str, image: &str| {
        let mut json = scene.json.clone();
        json["buffers"][0]["uri"] = buffer.into();
        json["images"][2] = json!({ "uri": image });
        desk.file("set/in.gltf", json.to_string().as_bytes());
    };
    let colours = colours();
    for name in ["out.bin", "out.mipfold.json", "colours.png"] {
        desk.file(&format!("set/{name}"), if name.ends_with("bin") { &scene.binary } else { &colours });
    }
    text("out.bin", "colours.png");
    desk.refuses("@set/in.gltf -o @set/out.gltf --force", "also an input");
    text("out.bin", "out.mipfold.json");
    desk.refuses("@set/in.gltf -o @new/out.gltf", "two files of this name");
    // A picture in a folder that is called as the new model.
    std::fs::create_dir_all(desk.at("set/a.gltf")).unwrap();
    desk.file("set/a.gltf/c.png", &colours);
    text("out.bin", "a.gltf/c.png");
    desk.refuses("@set/in.gltf -o @new/a.gltf", "a file and a folder of this name");
    // A buffer that changes gets a name that none of the files that stay has.
    let mut json = scene.json.clone();
    json["buffers"] =
        json!([{ "byteLength": scene.binary.len(), "uri": "first.bin" }, { "byteLength": 4, "uri": "new.bin" }]);
    desk.file("set/in.gltf", json.to_string().as_bytes());
    desk.file("set/first.bin", &scene.binary);
    desk.file("set/new.bin", b"kept");
    let (code, stderr) = desk.run("build @set/in.gltf -o @new/new.gltf");
    assert_eq!(code, Some(0), "{stderr}");
    assert_eq!(std::fs::read(desk.at("new/new.bin")).unwrap(), b"kept");
    let odd: Vec<_> =
        pictures().into_iter().map(|(name, _)| (name, png(30, |x, y| bump(x, y, 15).map(encode8)))).collect();
    desk.file("odd.glb", &Scene::new(json!([bumpy()]), &odd, json!({})).glb());
    desk.refuses("@odd.glb -o @out.glb", "--resize 4");
    let (code, stderr) = desk.run("build @odd.glb -o @out.glb --resize 4");
    assert_eq!(code, Some(0), "{stderr}");
    // A dry run writes nothing, and says so to programs.
    let run = common::mipfold().args(desk.args("build @in.glb -o @dry.glb --dry-run --json")).output().unwrap();
    let said: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!((&said["dry_run"], &said["materials"][0]["folded"]), (&true.into(), &true.into()));
    assert_eq!(strings(&said["files"]), ["dry.glb", "dry.mipfold.json"]);
    assert!(!desk.at("dry.glb").exists());
}

#[test]
fn the_validator_finds_nothing_that_it_did_not_find_before() {
    let (Some(validator), Some(textures)) = (validator(), common::textures()) else { return };
    let desk = Desk::empty();
    let mut found = Vec::new();
    for folder in std::fs::read_dir(&textures).unwrap().map(|entry| entry.unwrap().path()) {
        let Ok(files) = std::fs::read_dir(&folder) else { continue };
        found.extend(files.map(|file| file.unwrap().path()).filter(|path| is_model(path)));
    }
    found.sort();
    assert!(found.len() >= 4, "{found:?}");
    for (i, model) in found.iter().enumerate() {
        let out = desk.at(&format!("{i}.glb"));
        common::build([model], &out);
        let (before, after) = (complaints(&validator, model), complaints(&validator, &out));
        let new: Vec<_> = after.iter().filter(|text| !before.contains(text)).collect();
        assert!(new.is_empty(), "{}: {new:#?}", model.display());
        let after = Written::read(&out);
        assert!(after.text.contains("KHR_texture_basisu"), "{}: nothing was folded", model.display());
    }
}

fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "glb" || ending == "gltf")
}
