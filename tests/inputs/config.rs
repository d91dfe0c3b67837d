//! `mipfold.toml`.

use std::path::Path;

use crate::common::desk::Desk;
use crate::common::{integers, manifest, png_levels};
use crate::folders::{pictures, said};

fn field(folder: &Path, key: &str) -> String {
    manifest(folder)[key].to_string()
}

#[test]
fn options_of_a_file_hold_for_the_materials_that_match() {
    let desk = Desk::empty();
    pictures(
        &desk,
        &["tex/wall_normal.png", "tex/wall_orm.png", "tex/floor/oak_normal.png", "tex/floor/mask_of_oak.png"],
    );
    pictures(&desk, &["tex/floor/elm_normal.png", "tex/floor/old/ash_normal.png", "tex/test/test_normal.png"]);
    let text = r#"
        fold = "toksvig"            # for all
        at-least-average = true
        format = ["png", "exr"]
        [[material]]
        match = "floor/*"
        strength = 0.5
        normal-y = "directx"
        max-alpha = 1
        [[material]]
        match = ["OAK", "nothing"]
        roughness = "floor/mask_of_oak.png:a"
        at-least-average = false
        [[material]]
        match = "**/ash"
        normal = "../spare.png"
        gloss = 0.25
        strength = 2
        [[material]]
        match = "test"
        skip = true
    "#;
    desk.file("tex/mipfold.toml", text.as_bytes());
    desk.file("tex/floor/old/mipfold.toml", b"strength = 3\nmin-alpha = 0.01\n");
    pictures(&desk, &["spare_normal.png"]);
    std::fs::rename(desk.at("spare_normal.png"), desk.at("spare.png")).unwrap();
    desk.warns("@tex -o @out --max-alpha 0.9", &["mipfold.toml:10: match = \"nothing\" matches no material"]);
    let (wall, oak, elm, ash) = ("out/wall", "out/floor/oak", "out/floor/elm", "out/floor/old/ash");
    assert!(!desk.at("out/test").exists());
    for (folder, fold, strength, y, least) in [
        (wall, "toksvig", "1.0", "opengl", "true"),
        (oak, "toksvig", "0.5", "directx", "false"),
        (elm, "toksvig", "0.5", "directx", "true"),
        // The nearer file goes before a section of the farther one.
        (ash, "toksvig", "3.0", "opengl", "true"),
    ] {
        let of = |key: &str| field(&desk.at(folder), key).trim_matches('"').to_owned();
        let found = [of("fold"), of("strength"), of("normal_y"), of("at_least_average")];
        assert_eq!(found, [fold, strength, y, least], "{folder}");
        // The command line goes before all.
        assert_eq!(of("max_alpha"), "0.9", "{folder}");
        assert!(desk.at(folder).join("manifest.json").is_file());
    }
    assert!(desk.at("out/wall/wall_normal.exr").is_file());
    let alpha = png_levels(&desk.at(oak), "mask_of_oak");
    let last = |level: usize| integers(&alpha[level]).0[3];
    assert_eq!((last(0), last(3) > 90), (90, true), "smoothness was not asked for: {}", last(3));
    assert_eq!(png_levels(&desk.at(ash), "spare").len(), 4);
    assert_eq!((field(&desk.at(ash), "min_alpha"), field(&desk.at(wall), "min_alpha")), ("0.01".into(), "0.0".into()));
    let notes = field(&desk.at(ash), "notes");
    for part in
        ["options of mipfold.toml: ", "normal = ../spare.png", "options of floor/old/mipfold.toml: ", "strength = 3"]
    {
        assert!(notes.contains(part), "{part}: {notes}");
    }
    assert!(!notes.contains("strength = 2"), "{notes}");

    // Options that say the same, or cannot stand together, are replaced together.
    let json = said(&desk, "@tex/floor -o @more --roughness 0.3 --fold lean --dry-run");
    assert_eq!(json["materials"].as_array().unwrap().len(), 3);
    let json = said(&desk, "@tex -o @more --roughness 0.3 --strength 1 --format png --dry-run");
    let text = json.to_string();
    assert!(!text.contains(".exr") && !text.contains("strength = ") && !text.contains("mask_of_oak_mip"), "{text}");
    assert!(json["warnings"][0].as_str().unwrap().contains("\"nothing\" matches no material"), "{text}");
    let skipped = json["passed_over"].as_array().unwrap().iter().find(|p| p["why"] == "skip in mipfold.toml:19");
    assert!(skipped.is_some(), "{text}");
}

#[test]
fn a_file_of_options_may_be_named() {
    let desk = Desk::new();
    pictures(&desk, &["tex/a/a_normal.png", "tex/b_normal.png"]);
    desk.file("tex/mipfold.toml", b"strength = 7");
    desk.file("my.toml", b"[[material]]\nmatch = \"tex/a*\"\nstrength = 0.25\n[[material]]\nmatch = 'n'\nstrength = 4");
    desk.warns("@tex -o @out --config @my.toml", &["my.toml:4: match = \"n\""]);
    assert_eq!(field(&desk.at("out/a"), "strength"), "0.25");
    assert_eq!(field(&desk.at("out/b"), "strength"), "1.0");
    // Of the maps that options name, it tells by the material's name.
    desk.warns("--normal @n.png -o @one --config @my.toml", &["my.toml:1: match = \"tex/a*\""]);
    assert_eq!(field(&desk.at("one"), "strength"), "4.0");
}

#[test]
fn what_is_wrong_in_a_file_of_options_is_said_with_its_line() {
    let desk = Desk::empty();
    pictures(&desk, &["tex/a/a_normal.png"]);
    let file = "@tex/mipfold.toml";
    let many = "x".repeat((1 << 20) + 1);
    let deep = format!("fold = {}1{}", "[".repeat(5000), "]".repeat(5000));
    let nested = "[a.".to_owned() + &"b.".repeat(500_000) + "c]\nd = 1";
    let rows: [(&[u8], &str, &str); 21] = [
        (b"\nflod = 'lean'", ":2: flod", "an unknown key"),
        (b"output = 'x'", ":1: output", "an unknown key"),
        (b"json = true", ":1: json", "an unknown key"),
        (b"strength = true", ":1: strength", "a string or a number"),
        (b"strength = -1", ":1: strength", "a number from 0 up"),
        (b"strength = nan", ":1: strength", "a number from 0 up"),
        (b"strength = [1, 2]", ":1: strength", "one value"),
        (b"moments = 'yes'", ":1: moments", "true or false"),
        (b"fold = 'nice'", ":1: fold", "one of average, toksvig"),
        (b"normal-y = 'up'", ":1: normal-y", "one of opengl, directx"),
        (b"extra = ['axes', { x = 1 }]", ":1: extra", "found a table"),
        (b"normal = 'n.png'", ":1: normal", "in a [[material]]"),
        (b"roughness = 0.1\ngloss = 0.2", "roughness", "one of them"),
        (b"material = 3", ":1: material", "[[material]]"),
        (b"[[material]]\nstrength = 1", ":1: [[material]]", "match ="),
        (b"a = 1\na = 2", ":2", "TOML"),
        (b"fold = \n", ":1", "TOML"),
        (b"fold = '\xff'", "mipfold.toml", "no UTF-8, from byte 8"),
        (many.as_bytes(), "mipfold.toml", "bytes"),
        (deep.as_bytes(), "mipfold.toml", "TOML"),
        (nested.as_bytes(), "mipfold.toml", "TOML"),
    ];
    for (bytes, place, expected) in rows {
        desk.file("tex/mipfold.toml", bytes);
        let message = desk.refuses("@tex -o @out", file);
        assert!(message.contains(place) && message.contains(expected) && message.len() < 2000, "{message}");
    }
    std::fs::remove_file(desk.at("tex/mipfold.toml")).unwrap();
    desk.refuses("@tex -o @out --config @none.toml", "@none.toml");
    // In a folder below, too: nothing is built with other options than were meant.
    pictures(&desk, &["tex/b/b_normal.png"]);
    desk.file("tex/b/mipfold.toml", b"x = 1");
    desk.refuses("@tex -o @out", "@tex/b/mipfold.toml:1: x");
    // A name leads nowhere else.
    desk.file("tex/b/mipfold.toml", b"[[material]]\nmatch = 'b'\nname = '../../up'");
    desk.build("out", "@tex");
    assert!(desk.at("out/b/.._.._up/manifest.json").is_file());
}

/// The file that the README shows does what it says.
#[test]
fn the_file_in_the_readme_works() {
    let readme = include_str!("../../README.md");
    let text = readme.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let desk = Desk::empty();
    pictures(&desk, &["t/floor/oak_normal.png", "t/wall_normal.png", "t/door_normal.png", "t/masks/wall_mask.png"]);
    pictures(&desk, &["t/test_normal.png", "t/floor/pine/normal.png"]);
    desk.file("t/mipfold.toml", text.as_bytes());
    desk.warns("@t -o @out", &[]);
    let of = |folder: &str, key: &str| field(&desk.at("out").join(folder), key).trim_matches('"').to_owned();
    for (folder, strength, y) in
        [("floor/oak", "0.5", "directx"), ("floor/pine", "0.5", "directx"), ("wall", "1.0", "opengl")]
    {
        assert_eq!([of(folder, "fold"), of(folder, "strength"), of(folder, "normal_y")], ["toksvig", strength, y]);
    }
    assert!(desk.at("out/door/wall_mask.exr").is_file() && !desk.at("out/test").exists());
}
