//! `mipfold build` of glTF models: what changes in them, and above all what does not.

#[path = "models/broken.rs"]
mod broken;
#[path = "models/channels.rs"]
mod channels;
mod common;
#[path = "models/containers.rs"]
mod containers;

use common::desk::Desk;
use common::model::{Scene, Written, glb};
use common::{bump, encode8};
use mipfold::codec;
use mipfold::image::{Raster, Samples};
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

/// What is written beside `@out.glb`.
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

/// A PNG beside WebP or KTX 2 in a texture that changes: nothing shows it any more.
#[test]
fn other_forms_of_a_texture_go_with_it() {
    let desk = Desk::empty();
    let images =
        vec![("n", normals()), ("orm", orm(0)), ("colour", colours()), ("n.png", orm(7)), ("orm.ktx2", orm(9))];
    let forms = |name: &str, image: usize| json!({ name: { "source": image } });
    let more = json!({
        "textures": [
            { "source": 3, "extensions": forms("EXT_texture_webp", 0) },
            { "source": 1, "extensions": forms("KHR_texture_basisu", 4) },
            { "source": 2 },
        ],
        "extensionsUsed": ["EXT_texture_webp", "KHR_texture_basisu"],
        "extensionsRequired": ["EXT_texture_webp"],
    });
    let scene = Scene::new(json!([bumpy()]), &images, more);
    let after = built(&desk, &scene, "");
    let pngs = after.binary.windows(4).filter(|four| four == b"\x89PNG").count();
    assert_eq!((pngs, after.json["images"].as_array().unwrap().len()), (1, 5));
    assert_eq!((after.image(3), after.image(4)), (after.image(0), after.image(1)));
    assert_eq!(after.json["images"][3]["mimeType"], "image/ktx2");
    let views = after.json["bufferViews"].as_array().unwrap().len();
    assert!((0..views).all(|view| !after.view(view).is_empty()));
    for view in 5..10 {
        let before = scene.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(after.view(view), &scene.binary[before..][..after.view(view).len()], "view {view}");
    }
    let said = sidecar(&desk);
    let states: Vec<_> = said["images"].as_array().unwrap().iter().map(|i| i["state"].clone()).collect();
    assert_eq!(states, ["folded", "folded", "kept", "gone", "gone"]);
    assert_eq!(said["images"][3]["after"], said["images"][0]["after"]);
    // With a fallback they stay, as all old images do.
    let kept = built(&desk, &scene, "--fallback");
    assert_eq!((kept.image(3), kept.image(4)), (&orm(7)[..], &orm(9)[..]));
    // Lists of extensions have one item at least.
    let plain = built(&desk, &scene, "--compress bc");
    assert_eq!((plain.json.get("extensionsUsed"), plain.json.get("extensionsRequired")), (None, None));
}
