//! Meshes for tests: a cylinder, as OBJ and as GLB with maps in it.

use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Around the cylinder; its texels see many.
const SIDES: usize = 512;

/// Position, normal and texture coordinates of each vertex of an open cylinder of radius 1 and height 1: u once around, v
/// up; the seam has two columns.
fn columns() -> impl Iterator<Item = ([f32; 3], [f32; 3], [f32; 2])> {
    (0..=SIDES).flat_map(|i| {
        let u = i as f32 / SIDES as f32;
        let (sin, cos) = (u * TAU).sin_cos();
        [0.0, 1.0].map(|v| ([cos, sin, v], [cos, sin, 0.0], [u, v]))
    })
}

fn triangles() -> impl Iterator<Item = [u32; 3]> {
    (0..SIDES as u32).flat_map(|i| {
        let [a, b, c, d] = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3];
        [[a, c, b], [b, c, d]]
    })
}

/// The cylinder as text, with or without texture coordinates and normals.
pub fn obj(path: &Path, uvs: bool, normals: bool) -> PathBuf {
    sheared(path, uvs, normals, 0.0)
}

/// The same with a texture that climbs: its u axis rises by `shear` on the way once around.
pub fn sheared(path: &Path, uvs: bool, normals: bool, shear: f32) -> PathBuf {
    let mut text = String::new();
    for (mut p, n, uv) in columns() {
        p[2] += shear * uv[0];
        writeln!(text, "v {} {} {}", p[0], p[1], p[2]).unwrap();
        if normals {
            writeln!(text, "vn {} {} {}", n[0], n[1], n[2]).unwrap();
        }
        if uvs {
            writeln!(text, "vt {} {}", uv[0], uv[1]).unwrap();
        }
    }
    for triangle in triangles() {
        let corner = |i: u32| match (uvs, normals) {
            (true, true) => format!("{0}/{0}/{0}", i + 1),
            (true, false) => format!("{0}/{0}", i + 1),
            (false, true) => format!("{0}//{0}", i + 1),
            (false, false) => format!("{}", i + 1),
        };
        let [a, b, c] = triangle.map(corner);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    std::fs::write(path, text).unwrap();
    path.to_owned()
}

/// The cylinder as GLB. `materials` is glTF's list; the mesh has a primitive for each. Image `i` of the file holds the
/// bytes of `pictures[i]`, and texture `i` is that.
pub fn glb(path: &Path, materials: serde_json::Value, pictures: &[Vec<u8>]) -> PathBuf {
    let mut bin: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: Vec<u8>| {
        views.push(serde_json::json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
        bin.extend(bytes);
        bin.resize(bin.len().next_multiple_of(4), 0);
        views.len() - 1
    };
    let floats = |values: Vec<f32>| values.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    let count = columns().count();
    let accessors = [
        (view(floats(columns().flat_map(|v| v.0).collect())), 5126, count, "VEC3"),
        (view(floats(columns().flat_map(|v| v.1).collect())), 5126, count, "VEC3"),
        // glTF's v points down.
        (view(floats(columns().flat_map(|(.., [u, v])| [u, 1.0 - v]).collect())), 5126, count, "VEC2"),
        (view(triangles().flatten().flat_map(u32::to_le_bytes).collect()), 5125, 3 * triangles().count(), "SCALAR"),
    ];
    let images: Vec<_> = pictures
        .iter()
        .map(|bytes| serde_json::json!({ "bufferView": view(bytes.clone()), "mimeType": "image/png" }))
        .collect();
    let accessors: Vec<_> = accessors
        .into_iter()
        .map(|(view, kind, count, shape)| {
            serde_json::json!({ "bufferView": view, "componentType": kind, "count": count, "type": shape })
        })
        .collect();
    // A material's `sets` are those of its primitives' texture coordinates; by default one primitive with the first.
    let mut primitives = Vec::new();
    for (i, material) in materials.as_array().unwrap().iter().enumerate() {
        let sets = material["sets"].as_array().cloned().unwrap_or_else(|| vec![serde_json::json!(["TEXCOORD_0"])]);
        for set in sets {
            let mut attributes = serde_json::json!({ "POSITION": 0, "NORMAL": 1 });
            set.as_array().unwrap().iter().for_each(|name| attributes[name.as_str().unwrap()] = 2.into());
            primitives.push(serde_json::json!({ "attributes": attributes, "indices": 3, "material": i }));
        }
    }
    let textures: Vec<_> = (0..images.len()).map(|i| serde_json::json!({ "source": i })).collect();
    let document = serde_json::json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": bin.len() }],
        "bufferViews": views,
        "accessors": accessors,
        "images": images,
        "textures": textures,
        "materials": materials,
        "meshes": [{ "primitives": primitives }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
    });
    let mut json = serde_json::to_vec(&document).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    for word in [2, 12 + 8 + json.len() as u32 + 8 + bin.len() as u32, json.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((bin.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bin);
    std::fs::write(path, file).unwrap();
    path.to_owned()
}
