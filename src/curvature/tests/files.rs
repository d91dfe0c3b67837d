//! Files: read rightly, or refused with one clear error.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Vec2, Vec3};
use serde_json::{Value, json};

use super::super::mesh::parse;
use super::super::{LoadOptions, Mesh, load};
use crate::error::Result;

fn read(name: &str, bytes: &[u8]) -> Result<Mesh> {
    parse(Path::new(name), bytes, &LoadOptions::default())
}

fn message(name: &str, bytes: &[u8]) -> String {
    read(name, bytes).unwrap_err().to_string()
}

/// Two triangles of a square: 4 positions, normals, texture coordinates as normalised u16, indices as u16.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let corners = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    corners.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
    (0..4).flat_map(|_| [0f32, 0.0, 1.0]).for_each(|v| bytes.extend(v.to_le_bytes()));
    let uvs = [[0u16, 65535], [65535, 65535], [65535, 0], [0, 0]];
    uvs.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes
}

/// The square in a scene: moved, and once more mirrored in x and scaled by the node that holds it.
fn document(uri: Option<String>) -> Value {
    let view = |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let mut document = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": buffer().len()}],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 16), view(112, 12)],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "materials": [{"name": "metal"}, {}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]},
            {"primitives": [
                {"attributes": {"POSITION": 0}, "indices": 3, "material": 1},
                {"attributes": {"POSITION": 0}, "mode": 0},
            ]},
        ],
        "nodes": [
            {"mesh": 0, "translation": [10, 0, 0], "children": [1]},
            {"mesh": 1, "scale": [-2, 1, 1], "rotation": [0, 0, 0, 1]},
        ],
        "scenes": [{"nodes": [0]}],
    });
    if let Some(uri) = uri {
        document["buffers"][0]["uri"] = uri.into();
    }
    document
}

fn embedded() -> Value {
    document(Some(format!("data:application/octet-stream;base64,{}", STANDARD.encode(buffer()))))
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + text.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, data) in [(b"JSON", &text[..]), (b"BIN\0", binary)] {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
    }
    bytes
}

const OBJ: &str = "# a square\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl red paint\nf 1/1 2/2 3/3\nusemtl blue\nf -4/-4 -2/-2 -1/-1\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment hello\nelement vertex 4\nproperty float x\nproperty float y\n\
    property double z\nproperty float s\nproperty float t\nelement other 1\nproperty int a\nelement face 1\n\
    property list uchar int vertex_index\nend_header\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n7\n4 0 1 2 3";

#[test]
fn a_scene_of_gltf_is_placed_and_its_v_turned_up() {
    let json = embedded();
    let mesh = read("a.gltf", json.to_string().as_bytes()).unwrap();
    assert_eq!(mesh, read("a.glb", &glb(&document(None), &buffer())).unwrap());
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.parts.len()), (8, 4, 2));
    let names: Vec<_> = mesh.parts.iter().map(|part| (part.material.as_deref().unwrap(), part.has_uvs)).collect();
    assert_eq!(names, [("metal", true), ("material 1", false)]);
    assert_eq!(mesh.positions[2], Vec3::new(11.0, 1.0, 0.0));
    assert_eq!(mesh.uvs.as_ref().unwrap()[..4], [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    // The mirrored one is turned over, so that its computed normals stay outside.
    assert_eq!(mesh.positions[6], Vec3::new(8.0, 1.0, 0.0));
    assert!(mesh.normals_computed && mesh.normals.iter().all(|n| *n == Vec3::Z));
    let part = mesh.select(&[1]);
    assert_eq!((part.positions.len(), part.uvs, part.parts[0].triangles.clone()), (4, None, 0..2));
}

#[test]
fn buffers_beside_the_file_are_found() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my buffer.bin"), buffer()).unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document(Some("my%20buffer.bin".into())).to_string()).unwrap();
    assert_eq!(load(&path, &LoadOptions::default()).unwrap().triangles.len(), 4);
    std::fs::write(&path, document(Some("none.bin".into())).to_string()).unwrap();
    let error = load(&path, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("none.bin"), "{error}");
    let error = load(folder.path(), &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("found a folder"), "{error}");
}

#[test]
fn buffers_that_no_triangle_needs_are_not_loaded() {
    let mut json = embedded();
    for uri in ["none.bin", "https://a.example/b", "data:,"] {
        json["buffers"].as_array_mut().unwrap().push(json!({"byteLength": 1u64 << 50, "uri": uri}));
    }
    json["bufferViews"].as_array_mut().unwrap().push(json!({"buffer": 1, "byteLength": 12}));
    let unused = json!({"bufferView": 4, "componentType": 5126, "count": 1, "type": "VEC3"});
    json["accessors"].as_array_mut().unwrap().push(unused);
    assert_eq!(read("a.gltf", json.to_string().as_bytes()).unwrap().triangles.len(), 4);
    json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(4);
    assert!(message("a.gltf", json.to_string().as_bytes()).contains("none.bin"));
}

#[test]
fn a_scene_shows_a_limited_number_of_primitives() {
    // 1025 nodes that show a mesh of 1024 primitives, empty ones, so that nothing else is in the way.
    let mut json = embedded();
    json["accessors"][3]["count"] = json!(0);
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 3});
    json["meshes"] = json!([{"primitives": vec![primitive; 1024]}]);
    json["nodes"] = json!(vec![json!({"mesh": 0}); 1025]);
    json["scenes"] = json!([]);
    let found = message("a.gltf", json.to_string().as_bytes());
    assert!(found.contains("a scene of 1049600 primitives") && found.contains("up to 1048576"), "{found}");
    json["nodes"].as_array_mut().unwrap().pop();
    assert!(message("a.gltf", json.to_string().as_bytes()).contains("no triangles"));
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let (json, lists) = (embedded().to_string(), OBJ.replacen("# a square\n", "", 1));
    for (name, text) in [("a.gltf", json.as_str()), ("a.obj", lists.as_str()), ("a.ply", PLY)] {
        let marked = format!("\u{feff}{text}");
        assert_eq!(read(name, marked.as_bytes()).unwrap(), read(name, text.as_bytes()).unwrap(), "{name}");
    }
}

#[test]
fn faces_of_obj_go_by_material_however_long_its_name() {
    // Were the name copied for every face, this would copy 16 GB.
    let name = "n".repeat(1 << 20);
    let face = "f 1/1 2/2 3/3\n";
    let text = format!("{OBJ}usemtl {name}\n{}usemtl blue\n{face}usemtl\n{face}", face.repeat(1 << 14));
    let mesh = read("a.obj", text.as_bytes()).unwrap();
    let parts: Vec<_> = mesh.parts.iter().map(|part| (part.material.as_deref(), part.triangles.len())).collect();
    assert_eq!(parts, [(Some("red paint"), 1), (Some("blue"), 2), (Some(&*name), 1 << 14), (None, 1)]);
}

#[test]
fn faults_of_gltf_are_named() {
    let changed = |pointer: &str, value: Value| {
        let mut json = embedded();
        let (parent, name) = pointer.rsplit_once('/').unwrap();
        json.pointer_mut(parent).unwrap()[name] = value;
        message("a.gltf", json.to_string().as_bytes())
    };
    let cases = [
        ("/asset/version", json!("1.0"), "glTF version \"1.0\""),
        ("/accessors/0/count", json!(1_000_000_000_000u64), "accessor 0: 1000000000000 elements of 12 bytes, 12 apart"),
        ("/accessors/0/count", json!(u64::MAX), "elements of 12 bytes"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessor 0"),
        ("/accessors/0/type", json!("VEC4"), "accessor 0 of type VEC4"),
        ("/accessors/0/componentType", json!(7), "component type 7"),
        ("/accessors/0/sparse", json!({"count": 1}), "sparse accessor 0"),
        ("/accessors/0/bufferView", json!(9), "buffer view 9 of 4"),
        ("/accessors/3/componentType", json!(5122), "signed or float indices"),
        ("/accessors/2/count", json!(3), "3 texture coordinates for 4 vertices"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "buffer view 0"),
        ("/bufferViews/0/byteStride", json!(4), "4 apart"),
        ("/buffers/0/byteLength", json!(1u64 << 50), "124 bytes in buffer 0"),
        ("/buffers/0/uri", json!("data:x;base64,%%"), "base64 in buffer 0"),
        ("/buffers/0/uri", json!("https://a.example/b"), "relative to this one"),
        ("/buffers/0/uri", json!("/dev/zero"), "relative to this one"),
        ("/buffers/0/uri", json!("../a.bin"), "in its folder or below"),
        ("/buffers/0/uri", json!("a/%2e%2e/../b.bin"), "in its folder or below"),
        ("/accessors/1/count", json!(3), "3 normals for 4 vertices"),
        ("/nodes/1/children", json!([0]), "node 0 held twice"),
        ("/nodes/1/children", json!([5]), "node 5 of 2"),
        ("/nodes/1/matrix", json!([1, 2]), "a matrix of 2 numbers in node 1"),
        ("/nodes/1/scale", json!([1e300, 1, 1]), "vertex 1 at"),
        ("/nodes/0/mesh", json!(3), "mesh 3 of 2"),
        ("/scene", json!(4), "scene 4 of 1"),
        ("/scenes/0/nodes", json!([]), "no triangles"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "compression"),
        ("/meshes", json!(3), "JSON whose meshes is 3; expected a list"),
    ];
    for (pointer, value, expected) in cases {
        let found = changed(pointer, value.clone());
        assert!(found.starts_with("a.gltf: ") && found.contains(expected), "{pointer} = {value}: {found}");
    }
    let whole = glb(&document(None), &buffer());
    for (length, expected) in [(10, "header"), (14, "a chunk at byte 12"), (200, "chunks inside the file")] {
        let mut cut = whole[..length].to_vec();
        if length > 12 {
            let found = message("a.glb", &cut);
            assert!(found.contains(&format!("tells of {} bytes, in a file of {length}", whole.len())), "{found}");
            cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        }
        let found = message("a.glb", &cut);
        assert!(found.contains(expected), "{length}: {found}");
    }
    assert!(message("a.glb", b"glTF\x01\0\0\0\0\0\0\0").contains("GLB version 1"));
    assert!(message("a.glb", b"glTF\x02\0\0\0\0\0\0\0").contains("tells of 0 bytes, in a file of 12"));
    assert_eq!(read("a.glb", &[&whole, &b"more"[..]].concat()).unwrap(), read("a.glb", &whole).unwrap());
    let deep = "[".repeat(100_000);
    assert!(message("a.gltf", format!("{{\"asset\":{deep}").as_bytes()).contains("JSON"));
}

#[test]
fn obj_and_ply_say_the_same_square() {
    let obj = read("a.obj", OBJ.as_bytes()).unwrap();
    let names: Vec<_> = obj.parts.iter().map(|part| part.material.as_deref()).collect();
    assert_eq!(names, [Some("red paint"), Some("blue")]);
    assert_eq!((obj.positions.len(), obj.triangles.len()), (6, 2));
    let ply = read("a.ply", PLY.as_bytes()).unwrap();
    assert_eq!((ply.positions.len(), ply.triangles.as_slice()), (4, &[[0, 1, 2], [0, 2, 3]][..]));
    // A face without coordinates is a part of its own.
    let mixed = read("a.obj", OBJ.replace("2/2 3/3", "2/2 3").as_bytes()).unwrap();
    assert_eq!(mixed.parts.iter().map(|part| part.has_uvs).collect::<Vec<_>>(), [false, true]);
    for mesh in [&obj, &ply] {
        assert!(mesh.normals.iter().all(|n| *n == Vec3::Z));
        for (p, t) in mesh.positions.iter().zip(mesh.uvs.as_ref().unwrap()) {
            assert_eq!(p.truncate(), *t);
        }
    }
}

#[test]
fn binary_ply_with_coordinates_at_corners_splits_vertices() {
    for big in [false, true] {
        let order = if big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 2\nproperty list uchar uint vertex_indices\nproperty list uchar float texcoord\nend_header\n"
        )
        .into_bytes();
        let ordered = |mut v: [u8; 4]| {
            if big {
                v.reverse();
            }
            v
        };
        [0f32, 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.].iter().for_each(|v| bytes.extend(ordered(v.to_le_bytes())));
        for (corners, uvs) in [([0u32, 1, 2], [0f32, 0., 1., 0., 1., 1.]), ([0, 2, 3], [0.5, 0., 1., 1., 0., 1.])] {
            bytes.push(3);
            corners.iter().for_each(|v| bytes.extend(ordered(v.to_le_bytes())));
            bytes.push(6);
            uvs.iter().for_each(|v| bytes.extend(ordered(v.to_le_bytes())));
        }
        let mesh = read("a.ply", &bytes).unwrap();
        // Vertex 0 has two coordinates, vertex 2 one.
        assert_eq!(mesh.triangles, [[0, 1, 2], [4, 2, 3]]);
        assert_eq!(mesh.uvs.unwrap()[4], Vec2::new(0.5, 0.0));
    }
}

#[test]
fn faults_of_obj_and_ply_are_named() {
    let ply = |from: &str, to: &str| message("a.ply", PLY.replacen(from, to, 1).as_bytes());
    assert!(ply("vertex 4", "vertex 99999999999").contains("99999999999 rows of 'vertex'"));
    assert!(ply("vertex 4", "vertex 40").contains("a.ply: found"));
    assert!(ply("property int a\n", "").contains("1 rows of 'other'"));
    assert!(ply("4 0 1 2 3", "4 0 1 2 9").contains("vertex 9 in face 0"));
    assert!(ply("4 0 1 2 3", "-4 0 1 2 3").contains("a PLY file"));
    assert!(ply("4 0 1 2 3", "4 0 1 2").contains("a PLY file"));
    assert!(ply("1 1 0 1 1", "1 nan 0 1 1").contains("vertex 2 at"));
    assert!(ply("1 1 0 1 1", "1 1 0 inf 1").contains("texture coordinates 2 of"));
    assert!(ply("element face", "element strip").contains("without faces"));
    let obj = |from: &str, to: &str| message("a.obj", OBJ.replacen(from, to, 1).as_bytes());
    let place = "expected corners at vertices listed before";
    for corner in ["9/1", "0/1", "-5/1", "1/5", "1/-5", "x", "1/1/1", "9999999999999999999/1", "/1"] {
        let found = obj("f 1/1", &format!("f {corner}"));
        assert!(found.contains("in line 12") && found.contains(place), "{corner}: {found}");
    }
    assert!(obj("2/2 3/3", "2/2").contains("expected three corners or more"));
    assert_eq!(obj("v 1 0 0", "v 1 0"), "a.obj: found \"v 1 0\" in line 4; expected three coordinates");
    assert!(obj("v 1 0 0", "v 1 1e30 0").contains("vertex 1 at"));
    assert_eq!(message("a.obj", b""), "a.obj: found no triangles; expected a mesh of triangles");
    assert!(message("a.stl", b"solid").contains("starts with \"solid\" is not supported"));
    let options = LoadOptions { crease_degrees: f64::NAN, ..LoadOptions::default() };
    assert!(parse(Path::new("a.obj"), OBJ.as_bytes(), &options).is_err());
}

/// Damages a file in ways that a seed picks: cut, bytes changed, pieces repeated.
fn damaged(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below.max(1) as u64) as usize
    };
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + next(4) {
        let at = next(bytes.len());
        match next(4) {
            0 => bytes.truncate(at),
            1 => bytes.iter_mut().skip(at).take(1).for_each(|b| *b = next(256) as u8),
            2 => bytes.iter_mut().skip(at).take(1).for_each(|b| *b = b"0123456789-/.e \n"[next(16)]),
            _ => {
                let piece = bytes[at..(at + next(20)).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
    bytes
}

#[test]
fn damaged_files_never_panic() {
    let files = [
        ("a.gltf", embedded().to_string().into_bytes()),
        ("a.glb", glb(&document(None), &buffer())),
        ("a.obj", OBJ.as_bytes().to_vec()),
        ("a.ply", PLY.as_bytes().to_vec()),
    ];
    let mut good = 0;
    for (name, bytes) in &files {
        for seed in 1..3000 {
            good += usize::from(read(name, &damaged(bytes, seed)).is_ok());
        }
    }
    assert!(good > 100, "{good}");
}
