//! What is refused, and what is left alone with a word about it.

use serde_json::{Value, json};

use crate::common::desk::Desk;
use crate::common::model::{Scene, Written, glb};
use crate::common::{bump, encode8, mipfold, strings};
use crate::{built, bumpy, colours, normals, pictures, png, reason, sidecar};

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
    for option in [
        "--format png",
        "--config @a.toml",
        "--dds9",
        "--occlusion 0.5",
        "--metal @m.png",
        "--normal-y opengl",
        "--wrap clamp",
    ] {
        let name = option.split(' ').next().unwrap();
        let told = format!("{name}: found a model; expected the options of models: --output, --fold, ");
        desk.refuses(&format!("@in.glb -o @out.glb {option}"), &told);
    }
    for length in [11, 40, whole.len() / 2, whole.len() - 5] {
        desk.file("cut.glb", &whole[..length]);
        desk.refuses("@cut.glb -o @out.glb", "@cut.glb");
    }
    let mut long = whole.clone();
    long[8..12].copy_from_slice(&(whole.len() as u32 + 4).to_le_bytes());
    desk.file("long.glb", &long);
    let lengths = format!("tells of {} bytes, in a file of {}", whole.len() + 4, whole.len());
    desk.refuses("@long.glb -o @out.glb", &lengths);
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
    for form in ["EXT_texture_avif", "MSFT_texture_dds", "EXT_texture_webp", "KHR_texture_basisu"] {
        let change = |json: &mut Value| json["textures"][2]["extensions"] = json!({ form: { "source": 7 } });
        broken(&change, "image 7 of 3 in texture 2; expected an image that exists");
    }
    broken(&|json| json["materials"][0]["normalTexture"]["index"] = 50.into(), "50");
    let unnamed = json!(["wall", {}, { "index": 0 }, null, {}]);
    broken(&|json| json["materials"][0] = unnamed.clone(), "materials/0 is a list; expected an object");
    broken(
        &|json| json["materials"][0]["extensions"] = json!({ "KHR_materials_anisotropy": [0.5, 0] }),
        "is a list; expected an object",
    );
    let moved = json!({ "KHR_texture_transform": [[0, 0], 0, [1, 1], null] });
    broken(
        &|json| json["materials"][0]["normalTexture"]["extensions"] = moved.clone(),
        "is a list; expected an object",
    );
    broken(&|json| json["materials"] = "many".into(), "\"many\"");
    broken(&|json| json["extensionsUsed"] = json!({}), "members of other kinds");
    // Views of whatever it is that nothing here reads.
    broken(&|json| json["bufferViews"][4]["byteOffset"] = u64::MAX.into(), "buffer view 4: 48 bytes from byte 184467");
    broken(&|json| json["bufferViews"][5]["byteLength"] = 1_000_000.into(), "buffer view 5: 1000000 bytes");
    broken(&|json| json["bufferViews"][2]["byteOffset"] = 1_000_000.into(), "buffer view 2");
    broken(&|json| json["bufferViews"][7]["buffer"] = 3.into(), "buffer 3 of 1");
    let packed =
        |offset: Value| json!({ "EXT_meshopt_compression": { "buffer": 0, "byteOffset": offset, "byteLength": 8 } });
    let beyond = "EXT_meshopt_compression of buffer view 4";
    broken(&|json| json["bufferViews"][4]["extensions"] = packed(u64::MAX.into()), beyond);
    broken(&|json| json["bufferViews"][4]["extensions"] = packed("far".into()), beyond);
    broken(
        &|json| json["materials"][0]["extensions"] = Value::Null,
        "materials/0/extensions is null; expected an object",
    );
    let anisotropy = json!({ "KHR_materials_anisotropy": { "anisotropyStrength": "much" } });
    broken(
        &|json| json["materials"][0]["extensions"] = anisotropy.clone(),
        "anisotropyStrength is \"much\"; expected a number",
    );
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
    let run = mipfold().args(desk.args("build @in.glb -o @dry.glb --dry-run --json")).output().unwrap();
    let said: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!((&said["dry_run"], &said["materials"][0]["folded"]), (&true.into(), &true.into()));
    assert_eq!(strings(&said["files"]), ["dry.glb", "dry.mipfold.json"]);
    assert!(!desk.at("dry.glb").exists());
}

#[test]
fn a_picture_that_cannot_be_read_leaves_its_material_alone() {
    let desk = Desk::empty();
    let material = |name: &str, normal: usize| json!({ "name": name, "normalTexture": { "index": normal } });
    let materials = json!([material("good", 0), material("cut", 1), material("lost", 2), material("base", 3)]);
    let scene = Scene::new(materials.clone(), &[("n", normals()), ("half", normals()[..99].to_vec())], json!({}));
    let mut json = scene.json.clone();
    json["buffers"][0]["uri"] = "in.bin".into();
    let images = json["images"].as_array_mut().unwrap();
    images.extend([json!({ "uri": "nowhere.png" }), json!({ "uri": "data:image/png;base64,!!" })]);
    json["textures"] = (0..4).map(|i| json!({ "source": i })).collect();
    desk.file("in.gltf", json.to_string().as_bytes());
    desk.file("in.bin", &scene.binary);
    for out in ["a.gltf", "b.glb", "new/c.gltf"] {
        let (code, stderr) = desk.run(&format!("build @in.gltf -o @{out}"));
        assert_eq!(code, Some(0), "{stderr}");
        for words in
            [["cut: left as it is", "image 1/half.png"], ["lost: left", "nowhere.png"], ["base: left", "image 3"]]
        {
            assert!(stderr.lines().any(|line| words.iter().all(|word| line.contains(word))), "{words:?}: {stderr}");
        }
        let after = Written::read(&desk.at(out));
        assert_eq!(after.json["materials"].as_array().unwrap()[1..], materials.as_array().unwrap()[1..]);
        assert_eq!(after.json["images"].as_array().unwrap()[2..4], json["images"].as_array().unwrap()[2..]);
        assert!(after.text.contains("KHR_texture_basisu"), "{}", after.text);
    }
    let said: Value = serde_json::from_slice(&std::fs::read(desk.at("b.mipfold.json")).unwrap()).unwrap();
    let states: Vec<_> = said["images"].as_array().unwrap().iter().map(|image| image["state"].clone()).collect();
    assert_eq!(states, ["folded", "kept", "unread", "unread", "added"]);
    assert!(said["warnings"][0].as_str().unwrap().contains("nowhere.png"), "{said}");
}

#[test]
fn a_place_that_is_taken_is_told_before_the_work() {
    let desk = Desk::empty();
    // What cannot be compressed is found when it is read.
    let odd = png(30, |x, y| bump(x, y, 15).map(encode8));
    let mut scene = Scene::new(json!([bumpy()]), &[("n", odd.clone()), ("orm", odd), ("colour", colours())], json!({}));
    desk.file("n.png", scene.image(0));
    scene.json["images"][0] = json!({ "uri": "n.png" });
    desk.file("in.glb", &scene.glb());
    desk.file("out_wall_normal.ktx2", b"mine");
    desk.refuses("@in.glb -o @out.glb", "@out_wall_normal.ktx2: found a file that mipfold did not write; expected a free name where a new one may be written");
    desk.refuses("@in.glb -o @other.glb", "--resize 4");
}

/// Headers tell of sides, when nothing is decoded yet.
#[test]
fn odd_sides_are_told_and_no_bar_to_what_stays() {
    let desk = Desk::empty();
    let odd = png(30, |x, y| bump(x, y, 15).map(encode8));
    let materials = json!([bumpy(), { "name": "odd", "normalTexture": { "index": 3 } }]);
    let write = |picture: &[u8]| {
        let images: Vec<_> = pictures().into_iter().chain([("odd", picture.to_vec())]).collect();
        desk.file("in.glb", &Scene::new(materials.clone(), &images, json!({})).glb());
    };
    write(&odd);
    desk.refuses(
        "@in.glb -o @out.glb",
        "odd.png: a texture of 30x30 texels is not supported; supported: sides that are multiples of 4",
    );
    // What would be left as it is anyhow may have any sides.
    write(&odd[..40]);
    for more in ["", " --resize 4"] {
        desk.warns(&format!("@in.glb -o @out.glb{more}"), &["odd: left as it is"]);
    }
}

#[test]
fn what_files_say_is_shown_in_letters() {
    let desk = Desk::empty();
    let form = "A\u{1b}[31m\nerror: fake";
    let textures =
        json!([{ "source": 0 }, { "source": 1 }, { "source": 2 }, { "extensions": { form: { "source": 0 } } }]);
    let mut nameless = bumpy();
    nameless["name"] = "".into();
    let materials = json!([nameless, { "name": "\u{7}\n", "normalTexture": { "index": 3 } }]);
    desk.file("in.glb", &Scene::new(materials, &pictures(), json!({ "textures": textures })).glb());
    let told = "material 1: left as it is: its normal texture is in the form of \"A\\u{1b}[31m\\nerror: fake\"";
    let loaders = "no part of glTF";
    desk.warns("@in.glb -o @out.glb", &[told]);
    desk.warns("@in.glb -o @out.glb --compress bc", &[told, loaders]);
    let said = sidecar(&desk);
    assert_eq!(said["materials"][0]["name"], "material 0");
    assert!(said["warnings"][0].as_str().unwrap().contains(loaders), "{said}");
}

#[test]
fn names_that_differ_in_their_ending_alone_are_refused() {
    let desk = Desk::empty();
    built(&desk, &Scene::new(json!([bumpy()]), &pictures(), json!({})), "");
    desk.refuses("@in.glb -o @out.gltf", "@out.mipfold.json: found what goes with out.glb");
    let (code, stderr) = desk.run("build @in.glb -o @out.gltf --force");
    assert_eq!(code, Some(0), "{stderr}");
    desk.refuses("@in.glb -o @out.glb", "out.gltf");
}

#[test]
fn anisotropy_is_not_folded_with_one_width() {
    let desk = Desk::empty();
    let mut brushed = bumpy();
    brushed["extensions"] = json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.5 } });
    let round = json!({ "name": "round", "normalTexture": { "index": 0 } });
    let scene = Scene::new(
        json!([brushed.clone(), round]),
        &pictures(),
        json!({ "extensionsUsed": ["KHR_materials_anisotropy"] }),
    );
    desk.file("in.glb", &scene.glb());
    for (args, word) in [("--lobes iso", "(iso)"), ("--fold toksvig", "toksvig")] {
        let (code, stderr) = desk.run(&format!("build @in.glb -o @out.glb {args}"));
        assert!(code == Some(0) && stderr.lines().count() == 1, "{stderr}");
        assert!(stderr.starts_with("warning: wall: left as it is: ") && stderr.contains(word), "{stderr}");
        let after = Written::read(&desk.at("out.glb"));
        assert_eq!(after.json["materials"][0], brushed);
        assert!(after.json["materials"][1]["pbrMetallicRoughness"].is_object());
    }
}
