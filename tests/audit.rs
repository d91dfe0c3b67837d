//! `mipfold audit`: what it says, in words and as JSON, its exit codes, and what it finds on real maps.

mod common;

use common::desk::Desk;
use common::{bump, encode8, mipfold, names, png8, strings, textures};
use mipfold::audit::CHECKS;
use serde_json::Value;

/// Exit code, standard output and standard error.
fn audit(args: &[String]) -> (Option<i32>, String, String) {
    let run = mipfold().arg("audit").args(args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (run.status.code(), text(run.stdout), text(run.stderr))
}

fn audit_at(desk: &Desk, args: &str) -> (Option<i32>, String, String) {
    let before = desk.tree();
    let result = audit(&desk.args(args));
    assert_eq!(desk.tree(), before, "{args}: files changed");
    result
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// A desk with `wall_normal.png`, whose green is down if `down`, its heights if asked for, and roughness.
fn wall(down: bool, heights: bool) -> Desk {
    let desk = Desk::empty();
    let side = 128;
    let height = |x: usize, y: usize| {
        let wave = |cycles: f64, i: usize| (cycles * i as f64 / side as f64 * std::f64::consts::TAU).sin();
        0.5 + 0.15 * wave(2.0, x + y) + 0.1 * wave(5.0, x + 2 * side - y) + 0.08 * wave(3.0, y)
    };
    png8(&desk.at("wall_normal.png"), (side, side), |x, y| {
        let at = |dx: usize, dy: usize| height((x + dx) % side, (y + dy) % side);
        let (p, q) = (6.0 * (at(1, 0) - at(side - 1, 0)), 6.0 * (at(0, side - 1) - at(0, 1)));
        let z = 1.0 / (1.0 + p * p + q * q).sqrt();
        [-p * z, if down { q * z } else { -q * z }, z].map(|v| encode8(v as f32)).to_vec()
    });
    png8(&desk.at("wall_roughness.png"), (side, side), |x, y| vec![(100 + (x * 13 + y * 29) % 90) as u8]);
    if heights {
        png8(&desk.at("wall_height.png"), (side, side), |x, y| vec![(255.0 * height(x, y)) as u8]);
    }
    desk
}

#[test]
fn a_sound_set_is_one_line() {
    let desk = wall(false, true);
    let said = (Some(0), "wall (128x128): nothing found\n".to_owned(), String::new());
    assert_eq!(audit_at(&desk, "@"), said);
    assert_eq!(audit_at(&desk, "--normal @wall_normal.png --roughness 0.3 --name wall"), said);
    assert_eq!(audit_at(&desk, "@ --quiet"), (Some(0), String::new(), String::new()));
    let (code, out, _) = audit_at(&desk, "@ --json");
    let report = json(&out);
    assert_eq!((code, &report["schema"]), (Some(0), &1.into()));
    assert_eq!(report["materials"][0]["size"]["width"], 128);
    assert_eq!(report["materials"][0]["findings"], Value::Array(vec![]));
}

#[test]
fn warnings_leave_the_exit_code_alone_and_errors_set_it() {
    let (code, out, err) = audit_at(&wall(true, false), "@");
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    assert!(
        out.starts_with("wall (128x128): 1 warning\n  warning green (wall_normal.png, green), confidence 0.9"),
        "{out}"
    );
    assert!(out.lines().last().unwrap().trim_start().starts_with("fix: read it with --normal-y directx"), "{out}");
    // The height map beside it, which a build passes over, makes it certain.
    let desk = wall(true, true);
    let (code, out, err) = audit_at(&desk, "@");
    assert_eq!((code, err.as_str()), (Some(1), "failed: wall: 1 error\n"), "{out}");
    let given = "--normal @wall_normal.png --height @wall_height.png --roughness 0.3";
    assert_eq!(audit_at(&desk, given).0, Some(1));
    assert_eq!(audit_at(&desk, &format!("{given} --normal-y directx")).0, Some(0));
    let (code, out, _) = audit_at(&desk, "@ --json");
    let finding = &json(&out)["materials"][0]["findings"][0];
    assert_eq!(code, Some(1));
    for (field, value) in [("check", "green"), ("severity", "error"), ("map", "wall_normal.png"), ("channel", "green")]
    {
        assert_eq!(finding[field], value, "{finding}");
    }
    assert!(finding["confidence"].as_f64().unwrap() > 0.95 && finding["evidence"].is_string(), "{finding}");
}

#[test]
fn a_set_that_cannot_be_loaded_is_a_finding_and_bad_usage_is_not() {
    let desk = wall(false, false);
    desk.file("door_normal.png", b"\x89PNG\r\n\x1a\n and no more");
    png8(&desk.at("gate_normal.png"), (16, 16), |x, y| bump(x, y, 16).map(encode8).to_vec());
    png8(&desk.at("gate_rough.png"), (16, 16), |x, _| vec![(8 * x) as u8]);
    png8(&desk.at("gate_roughness.png"), (16, 16), |x, _| vec![(8 * x) as u8]);
    let (code, out, err) = audit_at(&desk, "@");
    assert_eq!(code, Some(1), "{out}");
    assert_eq!(out.matches("  error load (").count(), 2, "{out}");
    assert!(
        out.contains("PNG data that cannot be decoded") && out.contains("2 candidates for the roughness map"),
        "{out}"
    );
    assert!(out.contains("wall (128x128): nothing found"), "{out}");
    assert_eq!(err.lines().count(), 2, "{err}");
    for (args, why) in [
        ("@nowhere", "nowhere"),
        ("", "no maps"),
        ("@wall_normal.png", "a single file"),
        ("@ --normal @wall_normal.png", "cannot be used with"),
        ("@ --roughness 2", "a number from 0 to 1"),
    ] {
        let (code, out, err) = audit_at(&desk, args);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{args}");
        assert!(err.contains(why), "{args}: {err}");
    }
}

#[test]
fn models_are_audited_by_their_materials() {
    let desk = wall(true, false);
    let materials = serde_json::json!([
        { "name": "hull", "normalTexture": { "index": 0 } },
        { "name": "bare" },
    ]);
    let picture = std::fs::read(desk.at("wall_normal.png")).unwrap();
    common::mesh::glb(&desk.at("ship.glb"), materials, &[picture]);
    let (code, out, err) = audit_at(&desk, "@ship.glb");
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    assert!(
        out.starts_with("hull (128x128): 1 warning\n  warning green (") && out.ends_with("bare: no maps\n"),
        "{out}"
    );
}

#[test]
fn the_help_lists_every_check() {
    let (_, help, _) = audit(&["--help".into()]);
    for check in CHECKS {
        assert!(help.contains(&format!("\n  {} ", check.name)), "{}: {help}", check.name);
    }
}

/// All errors and warnings on the real maps: material, severity, check, file. Each was looked at.
const FOUND: &[(&str, &str, &str, &str)] = &[
    // Heights and curl agree; MANIFEST.md says DirectX.
    ("brushed_metal009", "error", "green", "normal.jpg"),
    ("chainmail004", "error", "green", "normal.jpg"),
    ("float_noise_exr", "error", "green", "normal.exr"),
    // DirectX by curl alone.
    ("carpaint_flakes", "warning", "green", "normal.png"),
    ("copper_tiles_01", "warning", "green", "normal.png"),
    ("scratched_gold", "warning", "green", "normal.png"),
    // The round knobs have red and green of a dent one way and of a bump the other.
    ("lambert1", "warning", "green", "normal.png"),
    // Mean lengths of 0.77, 0.89 and 0.90.
    ("carpaint_flakes", "warning", "unit-length", "normal.png"),
    ("fabric_knitted_006", "warning", "unit-length", "normal.jpg"),
    ("ground037_packed", "warning", "unit-length", "normal_roughness.png"),
    ("defense_wall_srgb", "error", "srgb-normals", "normal.jpg"),
    // Squares that can be seen.
    ("fabric_knitted_006", "warning", "jpeg", "roughness.jpg"),
    ("fabric_pattern_07", "warning", "jpeg", "arm.jpg"),
    // A 16-bit PNG made from a JPEG.
    ("rosewood_veneer1_16bit", "warning", "jpeg", "normal.png"),
];

#[test]
fn real_maps_have_the_faults_that_a_person_sees() {
    let Some(folder) = textures() else { return };
    let mut inputs: Vec<String> =
        names(&folder).into_iter().map(|name| folder.join(name)).filter(|path| has_sets(path)).map(shown).collect();
    for model in ["glb_normal_tangent_test/NormalTangentTest.glb", "glb_old_flashlight/old_flashlight.glb"] {
        inputs.push(shown(folder.join(model)));
    }
    for model in ["gltf_flight_helmet/FlightHelmet.gltf", "gltf_tea_set_01/tea_set_01_1k.gltf"] {
        inputs.push(shown(folder.join(model)));
    }
    inputs.push("--json".into());
    let (code, out, _) = audit(&inputs);
    assert_eq!(code, Some(1), "there are errors among them");
    let report = json(&out);
    let materials = report["materials"].as_array().unwrap();
    let mut found: Vec<String> = Vec::new();
    for material in materials {
        for finding in material["findings"].as_array().unwrap().iter().filter(|f| f["severity"] != "note") {
            let fields = [&material["name"], &finding["severity"], &finding["check"], &finding["map"]];
            found.push(fields.map(|field| field.as_str().unwrap()).join(" "));
        }
    }
    let mut expected: Vec<String> = FOUND.iter().map(|(a, b, c, d)| [*a, b, c, d].join(" ")).collect();
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
    assert!(materials.len() >= 28, "{}", materials.len());
    let of = |name: &str| materials.iter().find(|m| m["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    let checks = |name: &str| of(name)["findings"].as_array().unwrap().iter().map(|f| f["check"].clone()).collect();
    let notes: Value = checks("rusty_metal053c");
    assert_eq!(strings(&notes), [""; 0], "a sound set");
    assert!(strings(&checks("paper001")).contains(&"size".to_owned()));
    assert!(strings(&checks("cheese_bumps")).contains(&"green".to_owned()), "inverted heights");
    assert!(strings(&checks("bulb1")).contains(&"constant".to_owned()));
}

/// Whether a folder is one of texture sets, not of a model.
fn has_sets(folder: &std::path::Path) -> bool {
    let sets = |name: &String| name.starts_with("normal") || name.starts_with("height");
    folder.is_dir() && names(folder).iter().any(sets)
}

fn shown(path: std::path::PathBuf) -> String {
    path.into_os_string().into_string().unwrap()
}

/// The map of each set in the other convention, read as it was: all that have a convention are found, and none else.
#[test]
fn turned_round_every_real_map_with_a_convention_is_found() {
    let Some(folder) = textures() else { return };
    // Read rightly, and the wrong way.
    for (name, right, wrong) in [
        ("tiles107", "opengl", "directx"),
        ("rock058", "opengl", "directx"),
        ("bark014", "opengl", "directx"),
        ("fabric_pattern_07", "opengl", "directx"),
        ("long_white_tiles", "opengl", "directx"),
        ("surface_imperfections", "opengl", "directx"),
        ("rusty_metal053c", "opengl", "directx"),
        ("rosewood_veneer1_16bit", "opengl", "directx"),
        ("brushed_metal009", "directx", "opengl"),
        ("copper_tiles_01", "directx", "opengl"),
    ] {
        let place = folder.join(name);
        let normal = names(&place).into_iter().find(|n| n == "normal.jpg" || n == "normal.png").unwrap();
        let green = |convention: &str| {
            let normal = place.join(&normal).into_os_string().into_string().unwrap();
            let args = ["--normal", &normal, "--roughness", "0.4", "--normal-y", convention, "--json"];
            let (_, out, _) = audit(&args.map(String::from));
            let findings = &json(&out)["materials"][0]["findings"];
            findings.as_array().unwrap().iter().any(|f| f["check"] == "green" && f["severity"] == "warning")
        };
        assert!(!green(right), "{name} read as {right}");
        assert!(green(wrong), "{name} read as {wrong}");
    }
}
