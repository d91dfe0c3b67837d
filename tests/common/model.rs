//! Small models for tests, and what is in a file that was written.

use std::path::Path;

use assert_cmd::Command;
use serde_json::{Value, json};

/// A model of one square for each material. Images come first in the buffer, so that everything moves when they go.
pub struct Scene {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Scene {
    /// `more` is merged into the root: textures, samplers, extensions. Texture `i` is image `i` where it says nothing.
    pub fn new(materials: Value, images: &[(&str, Vec<u8>)], more: Value) -> Self {
        let mut binary: Vec<u8> = Vec::new();
        let mut views: Vec<Value> = Vec::new();
        let mut view = |bytes: &[u8], target: Option<u32>| {
            binary.resize(binary.len().next_multiple_of(4), 0);
            let mut view = json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() });
            if let Some(target) = target {
                view["target"] = target.into();
            }
            views.push(view);
            binary.extend(bytes);
            views.len() - 1
        };
        let images: Vec<_> = images
            .iter()
            .map(|(name, bytes)| json!({ "name": name, "mimeType": "image/png", "bufferView": view(bytes, None) }))
            .collect();
        let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0f32]];
        let positions: Vec<f32> = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect();
        let uvs: Vec<f32> = corners.iter().flat_map(|[x, y]| [*x, 1.0 - *y]).collect();
        let list = [
            (view(&floats(&positions), Some(34962)), 5126, 4, "VEC3"),
            (view(&floats(&[0.0, 0.0, 1.0].repeat(4)), Some(34962)), 5126, 4, "VEC3"),
            (view(&floats(&[1.0, 0.0, 0.0, 1.0].repeat(4)), Some(34962)), 5126, 4, "VEC4"),
            (view(&floats(&uvs), Some(34962)), 5126, 4, "VEC2"),
            (view(&[0, 0, 1, 0, 2, 0, 0, 0, 2, 0, 3, 0], Some(34963)), 5123, 6, "SCALAR"),
        ];
        let accessors: Vec<_> = list
            .into_iter()
            .map(|(view, kind, count, shape)| {
                json!({ "bufferView": view, "componentType": kind, "count": count, "type": shape })
            })
            .collect();
        let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3, "TEXCOORD_1": 3 });
        let primitive = |material| json!({ "attributes": attributes, "indices": 4, "material": material });
        let count = materials.as_array().unwrap().len();
        let mut json = json!({
            "asset": { "version": "2.0" },
            "accessors": accessors,
            "images": images,
            "textures": (0..images.len()).map(|i| json!({ "source": i })).collect::<Vec<_>>(),
            "materials": materials,
            "meshes": [{ "primitives": (0..count).map(primitive).collect::<Vec<_>>() }],
            "nodes": [{ "mesh": 0 }],
            "scenes": [{ "nodes": [0] }],
            "scene": 0,
        });
        json["accessors"][0]["min"] = json!([0, 0, 0]);
        json["accessors"][0]["max"] = json!([1, 1, 0]);
        json["buffers"] = json!([{ "byteLength": binary.len() }]);
        json["bufferViews"] = views.into();
        for (key, value) in more.as_object().unwrap() {
            json[key] = value.clone();
        }
        Self { json, binary }
    }

    /// The bytes of an image.
    pub fn image(&self, index: usize) -> &[u8] {
        let view = &self.json["bufferViews"][self.json["images"][index]["bufferView"].as_u64().unwrap() as usize];
        let number = |key: &str| view[key].as_u64().unwrap() as usize;
        &self.binary[number("byteOffset")..][..number("byteLength")]
    }

    /// As .glb, with a chunk that nobody knows at the end.
    pub fn glb(&self) -> Vec<u8> {
        glb(&serde_json::to_string(&self.json).unwrap(), &self.binary)
    }
}

/// A .glb of this text.
pub fn glb(text: &str, binary: &[u8]) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, chunk, fill) in [(b"JSON", text.as_bytes(), b' '), (b"BIN\0", binary, 0), (b"LOCO", b"12345678", 0)] {
        file.extend((chunk.len().next_multiple_of(4) as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
        file.resize(file.len().next_multiple_of(4), fill);
    }
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file
}

/// A file that was written: its text, its binary chunk, and what other chunks there are.
pub struct Written {
    pub text: String,
    pub json: Value,
    pub binary: Vec<u8>,
    pub others: Vec<Vec<u8>>,
}

impl Written {
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let (mut text, mut binary, mut others) = (None, Vec::new(), Vec::new());
        if bytes.starts_with(b"glTF") {
            let mut at = 12;
            while at < bytes.len() {
                let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
                let chunk = bytes[at + 8..at + 8 + length].to_vec();
                match &bytes[at + 4..at + 8] {
                    b"JSON" => text = Some(String::from_utf8(chunk).unwrap()),
                    b"BIN\0" => binary = chunk,
                    _ => others.push(chunk),
                }
                at += 8 + length;
            }
        } else {
            text = Some(String::from_utf8(bytes).unwrap());
        }
        let text = text.unwrap();
        Self { json: serde_json::from_str(&text).unwrap(), text, binary, others }
    }

    /// The bytes of a view of the binary chunk.
    pub fn view(&self, index: usize) -> &[u8] {
        let view = &self.json["bufferViews"][index];
        let number = |key: &str| view[key].as_u64().unwrap_or(0) as usize;
        assert_eq!(number("buffer"), 0);
        &self.binary[number("byteOffset")..][..number("byteLength")]
    }

    /// The bytes of an image in the binary chunk.
    pub fn image(&self, index: usize) -> &[u8] {
        self.view(self.json["images"][index]["bufferView"].as_u64().unwrap() as usize)
    }

    /// The image that a texture shows through `KHR_texture_basisu`.
    pub fn basisu(&self, texture: &Value) -> usize {
        let texture = &self.json["textures"][texture.as_u64().unwrap() as usize];
        texture["extensions"]["KHR_texture_basisu"]["source"].as_u64().unwrap_or_else(|| panic!("{texture}")) as usize
    }
}

/// The folder of the npm package gltf-validator, which `node` runs: `MIPFOLD_VALIDATOR`, or beside `MIPFOLD_THREE`.
pub fn validator() -> Option<std::path::PathBuf> {
    let beside = || Some(Path::new(&std::env::var_os("MIPFOLD_THREE")?).parent()?.join("gltf-validator"));
    let folder = std::env::var_os("MIPFOLD_VALIDATOR").map(Into::into).or_else(beside);
    match folder.filter(|folder| folder.join("package.json").is_file()) {
        Some(folder) if Command::new("node").arg("--version").output().is_ok_and(|run| run.status.success()) => {
            Some(folder)
        }
        _ => super::skip("node or gltf-validator is missing (MIPFOLD_VALIDATOR)"),
    }
}

/// What the validator says of a model: errors and warnings, each as one text. Version 2.0.0-dev.3.10 knows no KTX 2, and
/// warns of each such image twice, whoever made it: that is left out.
pub fn complaints(validator: &Path, model: &Path) -> Vec<String> {
    let report = super::script(Path::new("node"), "gltf_validate.mjs", &[validator, model]);
    let json = Written::read(model).json;
    let ktx2 = |image: &str| json["images"][image.parse::<usize>().unwrap()]["mimeType"] == "image/ktx2";
    let unknown = |one: &&Value| {
        let (code, pointer) = (one["code"].as_str().unwrap(), one["pointer"].as_str().unwrap_or_default());
        let image = pointer.strip_prefix("/images/");
        match code {
            "VALUE_NOT_IN_LIST" => image.and_then(|rest| rest.strip_suffix("/mimeType")).is_some_and(ktx2),
            "IMAGE_UNRECOGNIZED_FORMAT" => image.is_some_and(ktx2),
            _ => false,
        }
    };
    let told = report["told"].as_array().unwrap().iter().filter(|one| !unknown(one));
    told.map(|one| format!("{} {} {}", one["code"], one["pointer"], one["message"])).collect()
}
