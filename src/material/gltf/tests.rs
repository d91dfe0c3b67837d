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
            { "extensions": { "EXT_texture_webp": { "source": 1 } } },
            { "source": 3 },
        ],
        "images": [
            { "uri": "maps/brick%20normal.png" },
            { "uri": "data:image/png;base64,iVBORw==", "name": "a/b:c" },
            { "uri": "../secret.png" },
            { "uri": "data:image/png;base64,iVBORg==", "name": "a/b:c" },
        ],
        "samplers": [{ "wrapS": 33648, "wrapT": 33071 }],
    })
}

fn read(material: Value) -> Result<Surface> {
    let bytes = serde_json::to_vec(&document(material)).unwrap();
    let model = Model { path: "models/wall.gltf".into(), bytes };
    model.surfaces([0]).unwrap().remove(0)
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
    let width = "models/wall.gltf/image 1/a_b_c.png";
    assert_eq!(inputs.roughness, RoughnessInput::Roughness(ChannelRef { path: width.into(), channel: Some(GREEN) }));
    assert!(inputs.roughness_factor == Some(0.5) && inputs.warnings[0].contains("KHR_materials_anisotropy"));
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
    refused(normal(4), "image 9 of 4");
    refused(normal(8), "texture 8 of 7");
    refused(json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {} } }), "SpecularGlossiness");
    refused(json!({ "pbrMetallicRoughness": { "roughnessFactor": 2 } }), "roughnessFactor 2");
    refused(json!({ "normalTexture": { "index": 0, "extensions": { "KHR_texture_transform": {} } } }), "transform");
    refused(json!({ "normalTexture": { "index": 0, "scale": -1 } }), "scale -1");
    let model = |text: &str| Model { path: "wall.gltf".into(), bytes: text.into() };
    assert!(model("{").surfaces([]).is_err());
    let error = model(r#"{"asset": {"version": "2.0"}}"#).surfaces([4]).unwrap().remove(0).unwrap_err();
    assert!(error.to_string().contains("material 4 of 0"), "{error}");
}

/// Names of pictures say nothing: equal ones are told apart, and one picture in two textures is one.
#[test]
fn pictures_are_known_by_their_number() {
    let surface = read(json!({
        "normalTexture": { "index": 1 },
        "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 6 } },
    }))
    .unwrap();
    let RoughnessInput::Roughness(width) = &surface.inputs.roughness else { panic!("{:?}", surface.inputs) };
    assert_ne!(surface.inputs.normal.as_deref(), Some(width.path.as_path()));
    let mut value = document(json!({ "normalTexture": { "index": 1 } }));
    let materials = [1, 5, 6].map(|i| json!({ "name": format!("m{i}"), "normalTexture": { "index": i } }));
    value["materials"] = materials.to_vec().into();
    // The samplers of texture 1 and 5 differ.
    value["textures"][5]["sampler"] = 0.into();
    let model = Model { path: "wall.glb".into(), bytes: serde_json::to_vec(&value).unwrap() };
    let surfaces: Vec<_> = model.surfaces([0, 1, 2]).unwrap().into_iter().map(Result::unwrap).collect();
    assert_eq!(surfaces.iter().map(|s| s.materials.clone()).collect::<Vec<_>>(), [vec![0, 1], vec![2]]);
    // A flat normal map needs no picture.
    let flat = read(json!({ "normalTexture": { "index": 3, "scale": 0 } })).unwrap();
    assert!(flat.inputs.normal.is_none() && flat.uv_set.is_none());
}
