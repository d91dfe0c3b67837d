//! What the channels of new textures hold.

use mipfold::codec::{self, read_levels};
use mipfold::fold::{Options, chain};
use mipfold::image::Raster;
use mipfold::material::{ChannelRef, Encoding, Inputs, LevelView, RoughnessInput, load};
use serde_json::{Value, json};

use crate::common::desk::Desk;
use crate::common::model::{Scene, complaints, validator};
use crate::{SIDE, built, bumpy, normals, orm, pictures, png, sidecar};

/// Every level of both textures beside the chain that the library folds of the same maps.
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

/// A form that no texture has any more is not asked of readers: their new pictures are made for all.
#[test]
fn fallbacks_that_are_new_need_no_other_form() {
    let desk = Desk::empty();
    let images = pictures();
    let required = json!(["EXT_texture_webp"]);
    let webp = json!({ "extensions": { "EXT_texture_webp": { "source": 1 } } });
    let textures = json!([{ "source": 0 }, webp, { "source": 2 }]);
    let more = json!({ "textures": textures, "extensionsUsed": required, "extensionsRequired": required });
    for (factor, kept) in [(0.25, false), (1.0, true)] {
        let mut material = bumpy();
        material["pbrMetallicRoughness"]["roughnessFactor"] = factor.into();
        let after = built(&desk, &Scene::new(json!([material]), &images, more.clone()), "--fallback").json;
        for list in ["extensionsUsed", "extensionsRequired"] {
            let names = after[list].as_array().map_or(&[][..], Vec::as_slice);
            assert_eq!(names.contains(&"EXT_texture_webp".into()), kept, "{list} of factor {factor}: {names:?}");
        }
    }
}

/// Readers without KTX 2 see level 0: the old picture where it fits the factors of the new material, else a new one.
#[test]
fn fallbacks_fit_the_factors_and_missing_ones_are_made() {
    let desk = Desk::empty();
    let rough = |value: u8| png(SIDE, move |_, _| [9, value, 8]);
    let brushed = |strength: f64, texture: Value| {
        let mut material = bumpy();
        material["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 2.into();
        material["extensions"] = json!({ "KHR_materials_anisotropy": { "anisotropyStrength": strength } });
        if !texture.is_null() {
            material["extensions"]["KHR_materials_anisotropy"]["anisotropyTexture"] = texture;
        }
        material
    };
    let mut smooth = bumpy();
    smooth["pbrMetallicRoughness"]["roughnessFactor"] = 0.25.into();
    let mut bare = json!({ "name": "bare", "normalTexture": { "index": 0 } });
    bare["pbrMetallicRoughness"] = json!({ "roughnessFactor": 0.25, "metallicFactor": 0.5 });
    let even = png(SIDE, |_, _| [255, 128, 255]);
    let images = vec![("n", normals()), ("smooth", rough(100)), ("rough", rough(90)), ("even", even)];
    let materials = json!([smooth, bare, brushed(0.5, Value::Null), brushed(0.25, json!({ "index": 3 })), bumpy()]);
    let forms = json!({ "EXT_texture_webp": { "source": 1 } });
    let textures = json!([{ "source": 0 }, { "source": 1, "extensions": forms }, { "source": 2 }, { "source": 3 }]);
    let used = json!(["KHR_materials_anisotropy", "EXT_texture_webp"]);
    let scene = Scene::new(materials, &images, json!({ "textures": textures, "extensionsUsed": used }));
    let after = built(&desk, &scene, "--fallback");
    let texture = |i: usize, path: &str| {
        let index = after.json["materials"][i].pointer(path).unwrap()["index"].as_u64().unwrap() as usize;
        &after.json["textures"][index]
    };
    let shown = |texture: &Value| {
        let image = texture["source"].as_u64().unwrap() as usize;
        let raster = codec::read(&desk.file("x.png", after.image(image))).unwrap().raster;
        [0, 1, 2].map(|c| (255.0 * raster.at(9, 9, c)).round() as u8)
    };
    let metallic = "/pbrMetallicRoughness/metallicRoughnessTexture";
    for (i, texel) in [(0, [9, 25, 8]), (1, [255, 64, 255])] {
        assert_eq!(after.json["materials"][i]["pbrMetallicRoughness"]["roughnessFactor"], 1.0);
        let texture = texture(i, metallic);
        assert_eq!((shown(texture), texture["extensions"].get("EXT_texture_webp")), (texel, None), "material {i}");
    }
    let anisotropy = "/extensions/KHR_materials_anisotropy";
    for (i, texel) in [(2, [255, 128, 128]), (3, [255, 128, 64])] {
        assert_eq!(after.json["materials"][i].pointer(anisotropy).unwrap()["anisotropyStrength"], 1.0);
        assert_eq!(shown(texture(i, &format!("{anisotropy}/anisotropyTexture"))), texel, "material {i}");
        assert_eq!(texture(i, metallic)["source"], 2, "material {i}");
    }
    assert_eq!(
        (&texture(4, metallic)["source"], &texture(4, metallic)["extensions"]["EXT_texture_webp"]),
        (&1.into(), &forms["EXT_texture_webp"])
    );
    assert_eq!((0..4).map(|i| after.image(i)).collect::<Vec<_>>(), images.iter().map(|i| &i.1[..]).collect::<Vec<_>>());
    // All of it is known beside the model.
    let said = sidecar(&desk);
    let textures = said["materials"].as_array().unwrap().iter().flat_map(|m| m["textures"].as_array().unwrap());
    let pictures: Vec<_> = textures.filter_map(|texture| texture["picture"].as_u64()).collect();
    assert_eq!(pictures.len(), 4);
    for picture in pictures {
        let digest = &said["images"][picture as usize];
        assert!(digest["image"] == picture && digest["state"] == "added" && digest["after"].is_string(), "{digest}");
    }
    if let Some(validator) = validator() {
        // The pictures are PNGs, whatever texture names them.
        let told = |model: &str| {
            let all = complaints(&validator, &desk.at(model)).into_iter();
            all.filter(|text| !text.contains("EXT_texture_webp/source")).collect::<Vec<_>>()
        };
        assert_eq!(told("out.glb"), told("in.glb"));
    }
    // As files of their own, too.
    let mut json = scene.json.clone();
    json["buffers"][0]["uri"] = "in.bin".into();
    desk.file("in.bin", &scene.binary);
    for (i, (name, bytes)) in images.iter().enumerate() {
        json["images"][i] = json!({ "uri": format!("{name}.png") });
        desk.file(&format!("{name}.png"), bytes);
    }
    desk.file("in.gltf", json.to_string().as_bytes());
    let (code, stderr) = desk.run("build @in.gltf -o @new/a.gltf --fallback");
    assert_eq!(code, Some(0), "{stderr}");
    let bare = codec::read(&desk.at("new/a_bare_roughness.png")).unwrap().raster;
    assert_eq!((255.0 * bare.at(0, 0, 1)).round(), 64.0);
}
