//! What the channels of new textures hold.

use mipfold::codec::read_levels;
use mipfold::fold::{Options, chain};
use mipfold::image::Raster;
use mipfold::material::{ChannelRef, Encoding, Inputs, LevelView, RoughnessInput, load};
use serde_json::{Value, json};

use crate::common::desk::Desk;
use crate::common::model::Scene;
use crate::{SIDE, built, bumpy, normals, orm, pictures, png, sidecar};

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
