//! .glb and .gltf, files beside them, and what Khronos's validator says.

use std::path::Path;

use serde_json::{Value, json};

use crate::common::desk::Desk;
use crate::common::model::{Scene, Written, complaints, validator};
use crate::common::{build, names, strings, textures};
use crate::{bumpy, colours, normals, orm, pictures};

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
    assert_eq!(names(&desk.at("a")), ["text.bin", "text.gltf", "text.mipfold.json"]);
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
fn what_a_container_has_no_place_for_is_said() {
    let desk = Desk::empty();
    let mut bytes = Scene::new(json!([bumpy()]), &pictures(), json!({})).glb();
    bytes.extend(b"abc");
    desk.file("in.glb", &bytes);
    let beyond = "3 bytes after the end";
    desk.warns("@in.glb -o @out.glb", &[beyond]);
    let after = Written::read(&desk.at("out.glb"));
    assert_eq!(after.others, [b"12345678"]);
    desk.warns("@in.glb -o @text.gltf", &[beyond, "chunk LOCO of 8 bytes"]);
}

/// Buffers that readers unpack meshes to have no bytes: they are kept, and what refers to them.
#[test]
fn buffers_without_bytes_are_kept() {
    let desk = Desk::empty();
    let scene = Scene::new(json!([bumpy()]), &pictures(), json!({}));
    let mut json = scene.json.clone();
    let fallback = json!({ "byteLength": 48, "extensions": { "EXT_meshopt_compression": { "fallback": true } } });
    json["buffers"] = json!([fallback, { "uri": "in.bin", "byteLength": scene.binary.len() }]);
    for view in json["bufferViews"].as_array_mut().unwrap() {
        view["buffer"] = 1.into();
    }
    let place = json["bufferViews"][4].clone();
    let packed = json!({ "buffer": 1, "byteOffset": place["byteOffset"], "byteLength": 48, "byteStride": 12, "count": 4, "mode": "ATTRIBUTES" });
    json["bufferViews"][4] =
        json!({ "buffer": 0, "byteLength": 48, "byteStride": 12, "extensions": { "EXT_meshopt_compression": packed } });
    json["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    desk.file("in.gltf", json.to_string().as_bytes());
    desk.file("in.bin", &scene.binary);
    desk.warns("@in.gltf -o @out.glb", &[]);
    desk.warns("@in.gltf -o @new/out.gltf", &[]);
    let after = Written::read(&desk.at("out.glb"));
    let buffers = after.json["buffers"].as_array().unwrap();
    assert_eq!((buffers.len(), buffers[0].get("uri"), &buffers[1]), (2, None, &fallback));
    let view = &after.json["bufferViews"][4];
    let packed = &view["extensions"]["EXT_meshopt_compression"];
    assert_eq!((&view["buffer"], &packed["buffer"], &packed["mode"]), (&1.into(), &0.into(), &"ATTRIBUTES".into()));
    let bytes = |binary: &[u8], place: &Value| binary[place["byteOffset"].as_u64().unwrap() as usize..][..48].to_vec();
    assert_eq!(bytes(&after.binary, packed), bytes(&scene.binary, &place));
    let text = Written::read(&desk.at("new/out.gltf"));
    assert_eq!((&text.json["buffers"][0], &text.json["bufferViews"][4]["buffer"]), (&fallback, &0.into()));
}

#[test]
fn the_validator_finds_nothing_new_in_a_helmet() {
    finds_nothing_new("gltf_flight_helmet", 1);
}

#[test]
#[ignore = "two minutes: four models"]
fn the_validator_finds_nothing_new_in_any_model() {
    finds_nothing_new("", 4);
}

/// Builds the models in folders of this beginning, at least as many, and asks Khronos's validator before and after.
fn finds_nothing_new(beginning: &str, least: usize) {
    let (Some(validator), Some(textures)) = (validator(), textures()) else { return };
    let desk = Desk::empty();
    let mut found = Vec::new();
    for folder in names(&textures).into_iter().filter(|name| name.starts_with(beginning)) {
        let Ok(files) = std::fs::read_dir(textures.join(folder)) else { continue };
        found.extend(files.map(|file| file.unwrap().path()).filter(|path| is_model(path)));
    }
    found.sort();
    assert!(found.len() >= least, "{found:?}");
    for (i, model) in found.iter().enumerate() {
        let out = desk.at(&format!("{i}.glb"));
        build([model], &out);
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
