use serde_json::{Value, json};

use super::*;

/// A document with one material and all that it may point to.
fn document(material: Value) -> Value {
    json!({
        "asset": { "version": "2.0" },
        "materials": [material],
        "textures": [
            { "source": 0 },
            { "source": 1, "sampler": 0 },
            { "source": 2 },
            { "extensions": { "KHR_texture_basisu": { "source": 0 } } },
            { "source": 9 },
        ],
        "images": [
            { "uri": "maps/brick%20normal.png" },
            { "uri": "data:image/png;base64,iVBORw==", "name": "a/b:c" },
            { "uri": "../secret.png" },
        ],
        "samplers": [{ "wrapS": 33648, "wrapT": 33071 }],
    })
}

fn read(material: Value) -> Result<Surface> {
    let bytes = serde_json::to_vec(&document(material)).unwrap();
    let model = Model { path: "models/wall.gltf".into(), bytes };
    model.surfaces(&[0]).unwrap().remove(0)
}

fn refused(material: Value, found: &str) {
    let error = read(material).unwrap_err().to_string();
    assert!(error.contains("wall.gltf") && error.contains(found), "{error} does not say {found}");
}

#[test]
fn maps_factors_and_samplers_are_read() {
    let surface = read(json!({
        "name": "brick",
        "normalTexture": { "index": 0, "scale": 0.5 },
        "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 }, "roughnessFactor": 0.5 },
        "extensions": { "KHR_materials_anisotropy": {} },
    }))
    .unwrap();
    let inputs = &surface.inputs;
    assert_eq!((inputs.name.as_str(), inputs.normal_scale, surface.uv_set), ("brick", Some(0.5), Some(0)));
    assert_eq!(inputs.normal.as_deref(), Some(Path::new("models/maps/brick normal.png")));
    let width = "models/wall.gltf/roughnessFactor 0.5/a_b_c.png";
    assert_eq!(inputs.roughness, RoughnessInput::Roughness(ChannelRef { path: width.into(), channel: Some(GREEN) }));
    assert!(inputs.notes[0].contains("set it to 1") && inputs.warnings[0].contains("KHR_materials_anisotropy"));
    // The sampler of the normals counts.
    assert_eq!(inputs.wrap, Wrap::Repeat);
    let error = surface.read(Path::new(width)).unwrap_err().to_string();
    assert!(error.contains("a_b_c.png"), "{error}");
    let mirrored = read(json!({ "normalTexture": { "index": 1, "texCoord": 3 } })).unwrap();
    assert_eq!((mirrored.inputs.wrap, mirrored.uv_set), (Wrap::Mirror, Some(3)));
    assert!(mirrored.inputs.warnings[0].contains("sampler 0"), "{:?}", mirrored.inputs.warnings);
    assert_eq!(mirrored.inputs.name, "material 0");
    let plain = read(json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.25 } })).unwrap();
    assert_eq!(plain.inputs.roughness, RoughnessInput::Constant(PerceptualRoughness(0.25)));
    assert!(plain.uv_set.is_none() && plain.inputs.normal.is_none());
    // glTF's default is rough.
    assert_eq!(read(json!({})).unwrap().inputs.roughness, RoughnessInput::Constant(PerceptualRoughness(1.0)));
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let normal = |index: usize| json!({ "normalTexture": { "index": index } });
    refused(normal(2), "../secret.png");
    refused(normal(3), "KHR_texture_basisu");
    refused(normal(4), "image 9 of 3");
    refused(normal(7), "texture 7 of 5");
    refused(json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {} } }), "SpecularGlossiness");
    refused(json!({ "pbrMetallicRoughness": { "roughnessFactor": 2 } }), "roughnessFactor 2");
    refused(json!({ "normalTexture": { "index": 0, "extensions": { "KHR_texture_transform": {} } } }), "transform");
    let model = |text: &str| Model { path: "wall.gltf".into(), bytes: text.into() };
    assert!(model("{").surfaces(&[]).is_err());
    let error = model(r#"{"asset": {"version": "2.0"}}"#).surfaces(&[4]).unwrap().remove(0).unwrap_err();
    assert!(error.to_string().contains("material 4 of 0"), "{error}");
}

#[test]
fn a_factor_scales_the_roughness_alone() {
    let of = |samples: Samples| scaled(Raster::new(samples), 0.5).samples;
    let three = ndarray::array![[[200u8, 100, 50]]];
    assert_eq!(of(Samples::U8(three)), Samples::U8(ndarray::array![[[200, 50, 50]]]));
    assert_eq!(of(Samples::U16(ndarray::array![[[1001u16]]])), Samples::U16(ndarray::array![[[501]]]));
    assert_eq!(of(Samples::F32(ndarray::array![[[0.5f32]]])), Samples::F32(ndarray::array![[[0.25]]]));
}
