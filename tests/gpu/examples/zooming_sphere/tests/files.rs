//! What is read and written.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::folder;
use crate::maps::{Level, Map};
use crate::renderer::Picture;
use crate::show::{self, Frame, PANE};

fn write_png(path: &Path, (width, height): (u32, u32), color: png::ColorType, depth: png::BitDepth, bytes: &[u8]) {
    let mut encoder = png::Encoder::new(fs::File::create(path).expect("a file"), width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().expect("a header").write_image_data(bytes).expect("the picture");
}

fn channels(roles: &[&str]) -> Value {
    roles.iter().map(|role| json!({ "name": "C", "role": role })).collect()
}

/// A 2 x 1 material with a 16-bit normal map and an 8-bit packed one, and its manifest.
fn write_folder(folder: &Path) -> Value {
    use png::BitDepth::{Eight, Sixteen};
    use png::ColorType::Rgb;
    let wide = |values: &[u16]| values.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<u8>>();
    write_png(&folder.join("n_mip0.png"), (2, 1), Rgb, Sixteen, &wide(&[0, 1000, 65535, 32768, 2, 3]));
    write_png(&folder.join("n_mip1.png"), (1, 1), Rgb, Sixteen, &wide(&[7, 8, 9]));
    write_png(&folder.join("orm_mip0.png"), (2, 1), Rgb, Eight, &[10, 51, 30, 40, 102, 60]);
    write_png(&folder.join("orm_mip1.png"), (1, 1), Rgb, Eight, &[1, 255, 3]);
    let manifest = json!({
        "schema": 1, "material": "wall", "count": 1, "normal_y": "directx", "normal_z": "stored",
        "normal_scale": 0.5, "wrap": "repeat",
        "maps": [
            { "container": "exr", "files": ["n.exr"], "channels": channels(&["normal.x", "normal.y", "normal.z"]) },
            {
                "container": "png", "files": ["n_mip0.png", "n_mip1.png"],
                "channels": channels(&["normal.x", "normal.y", "normal.z"]),
            },
            {
                "container": "png", "files": ["orm_mip0.png", "orm_mip1.png"],
                "channels": channels(&["other", "smoothness", "other"]),
            },
        ],
    });
    fs::write(folder.join("manifest.json"), manifest.to_string()).expect("a manifest");
    manifest
}

#[test]
fn folders_are_read_as_their_manifest_says() {
    let folder = tempfile::tempdir().expect("a folder");
    write_folder(folder.path());
    let (name, material) = folder::read(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(name, "wall");
    assert!(!material.y_up && material.gloss && !material.two_channels && !material.mirrored);
    assert_eq!((material.normal_scale, material.normal.bits, material.roughness.bits), (0.5, 16, 8));
    assert_eq!(material.roughness.levels[0], Level { width: 2, height: 1, values: vec![0.2, 0.4] });
    assert_eq!(material.roughness.levels[1].values, [1.0]);
    // Stored again, nothing has changed.
    assert_eq!(material.roughness.bytes(0), [51, 102]);
    let words = |values: &[u16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    assert_eq!(material.normal.bytes(0), words(&[0, 1000, 65535, 0, 32768, 2, 3, 0]));
}

#[test]
fn folders_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = || folder::read(folder.path()).expect_err("refused").to_string();
    assert!(error().contains("mipfold build"));
    let manifest = write_folder(folder.path());
    let path = folder.path().join("manifest.json");
    let try_with = |pointer: &str, value: Value, expected: &str| {
        let mut changed = manifest.clone();
        *changed.pointer_mut(pointer).expect("a field") = value;
        fs::write(&path, changed.to_string()).expect("a manifest");
        let found = error();
        assert!(found.contains(expected) && found.contains("manifest.json"), "{found}");
    };
    try_with("/schema", json!(2), "schema 2, expected 1");
    try_with("/count", json!(2), "2 lobes");
    try_with("/normal_y", json!("up"), "opengl or directx");
    try_with("/maps/1/container", json!("exr"), "no normal map");
    try_with("/maps/2/channels", channels(&["other", "other", "other"]), "no roughness");
    try_with("/maps/2/channels", channels(&["smoothness"]), "3 channels, expected 1");
    try_with("/maps/2/files", json!(["orm_mip0.png"]), "ends at 2 x 1");
    try_with("/maps/2/files", json!(["orm_mip1.png", "orm_mip0.png"]), "level 1 of the roughness map is 2 x 1");
    try_with("/maps/2/files", json!([]), "no levels");
    try_with("/maps/1/files/1", json!("missing.png"), "missing.png");
    try_with("/maps/1/files/1", json!("/n_mip1.png"), "not in its folder");
    fs::write(&path, "{").expect("a manifest");
    assert!(error().contains("manifest.json"));
    write_folder(folder.path());
    fs::write(folder.path().join("n_mip1.png"), "no picture").expect("a file");
    assert!(error().contains("n_mip1.png"));
}

/// Sides that do not halve evenly: 5 becomes 2, so that the middle column counts half for each.
#[test]
fn plain_mips_are_means() {
    let values = vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
    let map = Map::averaged(1, 8, Level { width: 5, height: 2, values });
    let sizes: Vec<_> = map.levels.iter().map(|level| (level.width, level.height)).collect();
    assert_eq!(sizes, [(5, 2), (2, 1), (1, 1)]);
    let expected = [(0.1 + 0.2 + 0.15 + 0.6 + 0.7 + 0.4) / 5.0, (0.15 + 0.4 + 0.5 + 0.4 + 0.9 + 1.0) / 5.0];
    for (found, expected) in map.levels[1].values.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
    assert!((map.levels[2].values[0] - 0.55).abs() < 1e-6);
    assert!(map.check("test").is_ok());
}

/// Frames are shown as they are, far ones enlarged, and all of them can be read back.
#[test]
fn frames_come_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("zoom.png");
    let frame = |side: usize, value: f32| {
        let mut pixels = vec![[0.0, 0.0, 0.0, 1.0]; side * side];
        pixels[1] = [value, 0.0, 0.0, 1.0];
        let picture = Picture { side, pixels };
        Frame::new(&[("a", &picture), ("b", &picture)], "below", 1.0)
    };
    let frames = [frame(PANE, 1.0), frame(PANE / 8, 1.0), frame(PANE / 8, 0.1)];
    show::write(&path, &frames, 100).unwrap_or_else(|e| panic!("{e}"));
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(&path).expect("the file")));
    let mut reader = decoder.read_info().expect("a PNG");
    assert_eq!(reader.info().animation_control.expect("animated").num_frames, 3);
    for frame in &frames {
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut bytes).expect("a frame");
        assert_eq!(bytes, frame.bytes);
    }
    let red = |frame: &Frame| frame.bytes.chunks_exact(3).filter(|p| p[0] > p[1]).count();
    assert_eq!([red(&frames[0]), red(&frames[1]), red(&frames[2])], [2, 2 * 64, 2 * 64]);
    assert!(show::write(&folder.path().join("no/such.png"), &frames, 100).is_err());
}
