//! What names say, and where the materials of a tree go.

use serde_json::Value;

use crate::common::desk::{Desk, tree};
use crate::common::{bumps, manifest, mipfold, names, png8};

/// Normal maps where a name says so, and four channels elsewhere.
pub fn pictures(desk: &Desk, files: &[&str]) {
    for file in files {
        let path = desk.at(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().to_lowercase();
        if name.contains("normal") || name.contains("_n.") {
            bumps(&path, (8, 8));
        } else {
            png8(&path, (8, 8), |x, y| vec![200, (60 + x + y) as u8, 20, 90]);
        }
    }
}

/// What `--json` says of a build, which must do without stderr.
pub fn said(desk: &Desk, args: &str) -> Value {
    let run = mipfold().args(desk.args(&format!("build {args} --json"))).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&run.stderr), "", "{args}");
    serde_json::from_slice(&run.stdout).unwrap()
}

/// `role=file:channel(word)` of every map of the material of a name.
fn maps(json: &Value, material: &str) -> String {
    let materials = json["materials"].as_array().unwrap();
    let material = materials.iter().find(|m| m["name"] == material).unwrap_or_else(|| panic!("no {material}: {json}"));
    let text = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let map = |map: &Value| {
        let file = text(&map["file"]);
        let file = file.rsplit('/').next().unwrap();
        let channel = text(&map["channel"]);
        let channel = if channel.is_empty() { channel } else { format!(":{channel}") };
        format!("{}={file}{channel} {}", text(&map["role"]), text(&map["why"]).replace(" in its name", ""))
    };
    material["maps"].as_array().unwrap().iter().map(map).collect::<Vec<_>>().join("; ")
}

fn passed_over(json: &Value, file: &str) -> String {
    let list = json["passed_over"].as_array().unwrap();
    let entry = list.iter().find(|entry| entry["path"].as_str().unwrap().ends_with(file));
    entry.unwrap_or_else(|| panic!("{file}: {list:?}"))["why"].as_str().unwrap().to_owned()
}

#[test]
fn names_say_what_each_channel_holds() {
    let desk = Desk::empty();
    let files = [
        "a_normal",
        "a_orm",
        "b_normal",
        "b_MRAO",
        "c_normal",
        "c_rmo",
        "d_normal",
        "d_MADS",
        "e_normal",
        "e_metallicRoughness",
        "f_normal",
        "f_roughness",
        "f_orm",
        "f_ao",
        "g_normal",
        "g_mask",
        "h_normal",
        "h_ao",
        "h_mixed_AO",
        "i_normal",
        "i_roughness",
        "i_opacity",
        "i_mask",
        "j_normal",
        "j_MetallicSmoothness",
        "j_metallic",
    ];
    pictures(&desk, &files.map(|file| format!("set/{file}.png")).each_ref().map(String::as_str));
    // A mask that has no alpha channel.
    bumps(&desk.at("set/k_normal.png"), (8, 8));
    png8(&desk.at("set/k_mask.png"), (8, 8), |_, _| vec![255]);
    let json = said(&desk, "@set -o @out --dry-run");
    let of = |material: &str| maps(&json, material);
    let start = |m: &str| format!("normal={m}_normal.png 'normal'; ");
    let packed = |m: &str, file: &str, word: &str, width: &str, ao: &str, metal: &str| {
        let part = |role: &str, channel: &str| format!("{role}={m}_{file}.png:{channel} '{word}'");
        let parts = [("occlusion", ao), ("metal", metal)].into_iter().filter(|(_, channel)| !channel.is_empty());
        let width = width.split_once(' ').unwrap();
        let parts = std::iter::once(part(width.0, width.1)).chain(parts.map(|(role, channel)| part(role, channel)));
        start(m) + &parts.collect::<Vec<_>>().join("; ")
    };
    assert_eq!(of("a"), packed("a", "orm", "orm", "roughness green", "red", "blue"));
    assert_eq!(of("b"), packed("b", "MRAO", "MRAO", "roughness green", "blue", "red"));
    assert_eq!(of("c"), packed("c", "rmo", "rmo", "roughness red", "blue", "green"));
    assert_eq!(of("d"), packed("d", "MADS", "MADS", "smoothness alpha", "green", "red"));
    assert_eq!(of("e"), packed("e", "metallicRoughness", "metallicRoughness", "roughness green", "", "blue"));
    // Files of their own first, the packed map for the rest.
    assert_eq!(
        of("f"),
        start("f") + "roughness=f_roughness.png 'roughness'; occlusion=f_ao.png 'ao'; metal=f_orm.png:blue 'orm'"
    );
    // With an alpha channel, and nothing else that could be the roughness.
    assert_eq!(of("g"), packed("g", "mask", "mask", "smoothness alpha", "green", "red"));
    assert_eq!(of("h"), "normal=h_normal.png 'normal'");
    assert_eq!(of("i"), start("i") + "roughness=i_roughness.png 'roughness'");
    assert_eq!(
        of("j"),
        start("j") + "smoothness=j_MetallicSmoothness.png:alpha 'MetallicSmoothness'; metal=j_metallic.png 'metallic'"
    );
    assert_eq!(of("k"), "normal=k_normal.png 'normal'");
    assert_eq!(passed_over(&json, "i_opacity.png"), "opacity, nothing to fold");
    assert!(passed_over(&json, "k_mask.png").contains("--smoothness FILE:a"));
}

#[test]
fn a_dry_run_tells_what_was_understood_and_why() {
    let desk = Desk::empty();
    pictures(
        &desk,
        &["set/wall_NormalDX.png", "set/wall_arm.png", "set/wall_color.png", "set/wall_height.png", "set/x.png"],
    );
    desk.file("set/wall.psd", b"");
    desk.file("set/SOURCE.txt", b"");
    let run = mipfold().args(desk.args("build @set -o @out --dry-run")).output().unwrap();
    let text =
        String::from_utf8(run.stdout).unwrap().replace(&format!("{}/", desk.at("").display()).replace("//", "/"), "@");
    for line in [
        "wall: 8x8, 4 levels, fold ggx: would write 9 files to @out",
        "  normal: @set/wall_NormalDX.png ('NormalDX' in its name)",
        "  roughness: @set/wall_arm.png, green ('arm' in its name)",
        "  occlusion: @set/wall_arm.png, red ('arm' in its name)",
        "  metal: @set/wall_arm.png, blue ('arm' in its name)",
        "  the normal map's name says DirectX (green down, -Y)",
        "  wall_arm_mip3.png",
        "passed over: @set/wall_color.png: colour, nothing to fold",
        "passed over: @set/wall_height.png: height, not needed beside a normal map",
        "passed over: @set/x.png: no word in its name says what it is",
        "passed over: @set/wall.psd: .psd is not looked for in folders",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}\n{text}");
    }
    assert!(!text.contains("SOURCE.txt"), "{text}");
    // Ambiguity stops a material, and names the flag.
    pictures(&desk, &["set/wall_roughness.png", "set/wall_rough.png"]);
    let message = desk.refuses("@set -o @out --dry-run", "@set");
    assert!(
        message.contains("wall_rough.png, wall_roughness.png") && message.contains("--roughness FILE"),
        "{message}"
    );
}

#[test]
fn tiles_are_materials_of_their_own() {
    let desk = Desk::empty();
    pictures(&desk, &["set/wall_normal.1001.png", "set/wall_orm.1001.png", "set/wall_normal.1002.png"]);
    pictures(&desk, &["set/door_normal_u1_v1.png", "set/door_normal_u2_v1.png", "set/Wood_2048_normal.png"]);
    pictures(&desk, &["set/clay_normal_1024.png"]);
    let run = mipfold().args(desk.args("build @set -o @out")).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&run.stderr), "");
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(text.contains("wall: [UDIM: 2 tiles], 1001 to 1002\n"), "{text}");
    assert!(text.contains("door: [UDIM: 2 tiles], u1_v1 to u2_v1\n"), "{text}");
    let folders = ["Wood_2048", "clay_1024", "door.u1_v1", "door.u2_v1", "wall.1001", "wall.1002"];
    assert_eq!(names(&desk.at("out")), folders);
    for (folder, file, wrap) in [
        ("wall.1001", "wall_normal.1001_mip0.png", "clamp"),
        ("wall.1001", "wall_orm.1001_mip3.png", "clamp"),
        ("door.u2_v1", "door_normal_u2_v1_mip0.png", "clamp"),
        ("clay_1024", "clay_normal_1024_mip0.png", "repeat"),
        ("Wood_2048", "Wood_2048_normal_mip0.png", "repeat"),
    ] {
        let folder = desk.at("out").join(folder);
        assert!(folder.join(file).is_file(), "{:?}", names(&folder));
        let manifest = manifest(&folder);
        assert_eq!(manifest["wrap"], wrap, "{file}");
        assert_eq!(manifest["notes"].to_string().contains("another tile"), wrap == "clamp", "{file}");
    }
    let json = said(&desk, "@set -o @other --wrap repeat --format exr");
    assert_eq!(
        json["udim"].to_string(),
        r#"[{"name":"door","tiles":["u1_v1","u2_v1"]},{"name":"wall","tiles":["1001","1002"]}]"#
    );
    assert_eq!(manifest(&desk.at("other/wall.1001"))["wrap"], "repeat");
    assert!(desk.at("other/wall.1002/wall_normal.1002.exr").is_file());
    // 1024 beside other tiles is one.
    pictures(&desk, &["more/clay_normal_1024.png", "more/clay_normal_1023.png"]);
    desk.build("tiles", "@more");
    assert_eq!(names(&desk.at("tiles")), ["clay.1023", "clay.1024"]);
}

#[test]
fn a_tree_stays_a_tree() {
    let desk = Desk::empty();
    pictures(&desk, &["tex/wall_normal.png", "tex/floor/normal.png", "tex/floor/Oak/Oak_4k_normal.png"]);
    pictures(&desk, &["tex/misc/a_normal.png", "tex/misc/b_normal.png", "tex/misc/a_color.png", "tex/WALL/normal.png"]);
    pictures(&desk, &["tex/.cache/c_normal.png", "tex/__MACOSX/d_normal.png", "tex/empty/readme.png"]);
    let set = |folder: &str| desk.at(folder).join("manifest.json").is_file();
    // The outputs lie below the inputs, twice: the second run finds the same sets.
    for _ in 0..2 {
        desk.build("tex/out", "@tex");
        let folders: Vec<_> = ["wall", "floor", "floor/Oak", "misc/a", "misc/b"].map(|f| format!("tex/out/{f}")).into();
        assert!(folders.iter().all(|folder| set(folder)), "{:?}", tree(&desk.at("tex/out")));
        let count = tree(&desk.at("tex/out")).iter().filter(|(path, _)| path.ends_with("manifest.json")).count();
        assert_eq!(count, 6, "{:?}", tree(&desk.at("tex/out")));
        // A folder that differs from another in case only has a name apart.
        assert!(
            set("tex/out/WALL") || set("tex/out/WALL_2") || set("tex/out/wall_2"),
            "{:?}",
            names(&desk.at("tex/out"))
        );
    }
    let json = said(&desk, "@tex -o @tex/out --dry-run");
    assert_eq!(passed_over(&json, "tex/out"), "the outputs go there");
    // What an earlier build wrote elsewhere is known by its manifest.
    let json = said(&desk, "@tex -o @else --dry-run");
    assert_eq!(json["materials"].as_array().unwrap().len(), 6);
    assert_eq!(passed_over(&json, "out/misc/a"), "9 files in it that an earlier build wrote");
    // Several inputs, a set of one name in each.
    pictures(&desk, &["x/wall_normal.png", "y/wall_normal.png"]);
    desk.build("both", "@x @y");
    assert_eq!(names(&desk.at("both")), ["wall", "wall_2"]);
    // No set is built twice.
    let json = said(&desk, "@tex/floor @tex -o @else --dry-run");
    assert_eq!(json["materials"].as_array().unwrap().len(), 6);
    // One alone, however deep, goes straight to the folder of the outputs.
    desk.build("one", "@tex/floor/Oak");
    assert!(set("one"));
}

#[cfg(target_os = "linux")]
#[test]
fn links_are_followed_once() {
    let desk = Desk::empty();
    pictures(&desk, &["tex/a/x_normal.png", "far/y_normal.png"]);
    std::os::unix::fs::symlink(desk.at("tex"), desk.at("tex/a/back")).unwrap();
    std::os::unix::fs::symlink(desk.at("far"), desk.at("tex/link")).unwrap();
    std::os::unix::fs::symlink(desk.at("nowhere"), desk.at("tex/broken_normal.png")).unwrap();
    desk.build("out", "@tex");
    assert_eq!(names(&desk.at("out")), ["a", "link"]);
    assert!(desk.at("out/link/y/manifest.json").is_file() && desk.at("out/a/x/manifest.json").is_file());
}
