//! Where files may be written, and what happens to those that are there.

mod common;

use std::process::{Command, Stdio};

use common::desk::Desk;
use common::{bump, bumps, exr32, mipfold, names, png_levels};
use mipfold::output::preset::PRESETS;

#[test]
fn places_that_cannot_be_written_are_refused() {
    let desk = Desk::new();
    desk.file("file", b"x");
    desk.refuses("--normal @n.png -o @file/below", "@file");
    desk.refuses("--normal @n.png -o @file", "@file");
    // The very file that is read, forced or not.
    exr32(&desk.at("w.exr"), (8, 8), &["R", "G", "B"], |x, y, c| bump(x, y, 8)[c]);
    for force in ["", " --force"] {
        let message = desk.refuses(&format!("--normal @w.exr --format exr -o @{force}"), "@w.exr");
        assert!(message.contains("also an input"), "{message}");
    }
}

#[test]
fn a_strangers_files_are_not_replaced_unless_forced() {
    let desk = Desk::new();
    std::fs::create_dir(desk.at("out")).unwrap();
    desk.file("out/n_mip2.png", b"mine");
    let message = desk.refuses("--normal @n.png -o @out", "@out/n_mip2.png");
    assert!(message.contains("--force"), "{message}");
    assert_eq!(std::fs::read(desk.at("out/n_mip2.png")).unwrap(), b"mine");
    desk.warns("--normal @n.png -o @out --force", &[]);
    assert_eq!(png_levels(&desk.at("out"), "n").len(), 7);
    // Now they are ours.
    desk.warns("--normal @n.png -o @out --fold lean", &[]);
}

#[test]
fn a_strangers_manifest_does_not_open_the_folder() {
    let desk = Desk::new();
    std::fs::create_dir(desk.at("web")).unwrap();
    desk.file("web/manifest.json", b"{\"name\": \"an app\", \"icons\": []}");
    desk.refuses("--normal @n.png -o @web", "@web/manifest.json");
}

#[test]
fn a_dry_run_writes_nothing() {
    let desk = Desk::new();
    let before = desk.tree();
    desk.warns("--normal @n.png --roughness @r.png --dry-run -o @out", &[]);
    assert_eq!(desk.tree(), before);
}

/// Five channels fit an EXR file, but no PNG.
#[test]
fn what_the_container_cannot_hold_is_refused() {
    let desk = Desk::new();
    let texel = |x, y, c: usize| bump(x, y, 8).get(c).copied().unwrap_or(0.25);
    exr32(&desk.at("five.exr"), (8, 8), &["X", "Y", "Z", "s", "t"], texel);
    desk.refuses("--normal @five.exr -o @out", "five");
    desk.warns("--normal @five.exr --format exr -o @out", &[]);
}

/// Renaming is the last step: if one file cannot have its name, none may have got its own.
#[test]
fn a_folder_in_the_way_leaves_nothing_half_done() {
    let desk = Desk::new();
    for (out, name) in [("a", "n_mip3.png"), ("b", "manifest.json")] {
        std::fs::create_dir_all(desk.at(out).join(name)).unwrap();
        desk.refuses(&format!("--normal @n.png --force -o @{out}"), &format!("@{out}/{name}"));
    }
}

/// A map whose outputs would carry the same name as the lobes.
#[test]
fn no_two_outputs_share_a_name() {
    let desk = Desk::new();
    std::fs::rename(desk.at("r.png"), desk.at("n_lobes.png")).unwrap();
    let out = desk.build("out", "--normal @n.png --roughness @n_lobes.png --format exr");
    // Two maps, the lobes, the manifest.
    assert_eq!(names(&out).len(), 4, "{:?}", names(&out));
}

/// What an earlier build left and this one does not renew goes; what others put there stays.
#[test]
fn a_rebuild_leaves_no_stale_levels_and_no_strangers_harmed() {
    let desk = Desk::empty();
    bumps(&desk.at("wall.png"), (64, 64));
    let out = desk.build("out", "--normal @wall.png");
    desk.file("out/stone_mip0.png", b"mine");
    bumps(&desk.at("wall.png"), (16, 16));
    desk.build("out", "--normal @wall.png");
    let of = |map: &str| names(&out).iter().filter(|name| name.starts_with(map)).count();
    assert_eq!((of("wall"), of("roughness"), of("stone")), (5, 5, 1), "{:?}", names(&out));
    desk.build("out", "--normal @wall.png --format exr");
    assert_eq!((of("wall"), of("roughness"), of("stone")), (2, 1, 1), "{:?}", names(&out));
    bumps(&desk.at("stone.png"), (16, 16));
    desk.refuses("--normal @stone.png --name wall -o @out", "@out/stone_mip0.png");
    assert_eq!(std::fs::read(desk.at("out/stone_mip0.png")).unwrap(), b"mine");
}

/// A folder belongs to one material.
#[test]
fn another_materials_folder_is_refused() {
    let desk = Desk::new();
    desk.build("out", "--normal @n.png --name one");
    let before = desk.tree();
    assert!(desk.refuses("--normal @n.png --name two -o @out", "@out").contains("'one'"));
    assert_eq!(desk.tree(), before);
}

/// A flag settles what names leave open; two resolutions are two materials.
#[test]
fn flags_and_resolutions_settle_folders() {
    let desk = Desk::empty();
    std::fs::create_dir(desk.at("two")).unwrap();
    ["x_normal", "x_rough", "x_roughness"]
        .iter()
        .for_each(|map| drop(bumps(&desk.at(&format!("two/{map}.png")), (8, 8))));
    assert!(desk.refuses("@two -o @out", "@two").contains("--roughness FILE"));
    desk.build("out", "@two --roughness 0.3");
    std::fs::create_dir(desk.at("sizes")).unwrap();
    ["1k", "4k"].iter().for_each(|size| drop(bumps(&desk.at(&format!("sizes/wall_{size}_normal.png")), (8, 8))));
    desk.build("sizes-out", "@sizes");
    assert!(desk.at("sizes-out/wall_1k/manifest.json").exists() && desk.at("sizes-out/wall_4k/manifest.json").exists());
}

/// Links that lead back are followed once, and names that are no Unicode are no panic.
#[cfg(target_os = "linux")]
#[test]
fn odd_folders_and_names_are_no_trap() {
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::empty();
    std::fs::create_dir_all(desk.at("sets/a")).unwrap();
    bumps(&desk.at("sets/a/normal.png"), (8, 8));
    std::os::unix::fs::symlink(desk.at("sets"), desk.at("sets/back")).unwrap();
    let (code, stderr) = desk.run("build @sets -o @out");
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert!(desk.at("out/manifest.json").exists());
    std::fs::create_dir(desk.at("odd")).unwrap();
    let odd = desk.at("odd").join(std::ffi::OsStr::from_bytes(b"\xff\xfe_normal.png"));
    bumps(&odd, (8, 8));
    assert_eq!(desk.run("build @odd -o @odd-out --json"), (Some(0), String::new()));
}

/// Outputs beside the inputs are not taken for inputs by the next build.
#[test]
fn building_a_folder_into_itself_twice_changes_nothing() {
    let desk = Desk::empty();
    std::fs::create_dir(desk.at("set")).unwrap();
    bumps(&desk.at("set/wall_normal.png"), (16, 16));
    desk.build("set", "@set");
    let first = desk.tree();
    desk.build("set", "@set");
    assert_eq!(desk.tree(), first);
}

/// The demo writes by the same rules as the build.
#[test]
fn the_demo_minds_dry_runs_and_strangers_files() {
    let desk = Desk::empty();
    assert_eq!(desk.run("demo --size 16 --dry-run -o @demo").0, Some(0));
    assert_eq!(desk.tree(), []);
    std::fs::create_dir_all(desk.at("demo/woven-cloth")).unwrap();
    desk.file("demo/woven-cloth/normal.png", b"mine");
    assert_eq!(desk.run("demo --size 16 -o @demo").0, Some(2));
    assert_eq!(std::fs::read(desk.at("demo/woven-cloth/normal.png")).unwrap(), b"mine");
}

/// Two candidates for one role are an error of that set alone.
#[test]
fn one_ambiguous_set_does_not_stop_the_others() {
    let desk = Desk::empty();
    ["sets/a", "sets/b"].iter().for_each(|folder| std::fs::create_dir_all(desk.at(folder)).unwrap());
    for map in ["a/normal", "b/x_normal", "b/x_nrm"] {
        bumps(&desk.at(&format!("sets/{map}.png")), (8, 8));
    }
    let (code, stderr) = desk.run("build @sets -o @out");
    assert!(code == Some(2) && stderr.lines().count() == 1 && stderr.contains("x_nrm.png"), "{stderr}");
    assert!(desk.at("out/a/manifest.json").exists() || desk.at("out/manifest.json").exists());
}

/// `--name` means one material.
#[test]
fn a_name_for_several_materials_is_refused() {
    let desk = Desk::empty();
    std::fs::create_dir(desk.at("sets")).unwrap();
    ["a", "b"].iter().for_each(|name| drop(bumps(&desk.at(&format!("sets/{name}_normal.png")), (8, 8))));
    desk.refuses("@sets --name one -o @out", "--name");
}

/// A reader that has gone (`mipfold ... | head -1`) and a full disk behind `>` are no reason to panic.
#[cfg(target_os = "linux")]
#[test]
fn a_standard_output_that_fails_is_no_panic() {
    let desk = Desk::new();
    for args in ["demo --list", "build --normal @n.png -o @out", "build --normal @n.png -o @out --json"] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(mipfold().get_program());
        let run = command.args(desk.args(args)).stdout(Stdio::from(full)).output().unwrap();
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert!(!stderr.contains("panicked"), "{args}: {stderr}");
        assert!(matches!(run.status.code(), Some(0 | 2)), "{args}: {:?}", run.status);
    }
}

/// The list names every preset; a page tells its facts with their sources, and what was not verified.
#[test]
fn presets_are_listed_and_told() {
    let printed = |args: &[&str]| {
        let run = mipfold().arg("presets").args(args).output().unwrap();
        assert!(run.status.success(), "{args:?}: {}", String::from_utf8_lossy(&run.stderr));
        String::from_utf8(run.stdout).unwrap()
    };
    let json = |args: &[&str]| serde_json::from_str::<serde_json::Value>(&printed(args)).unwrap();
    let (list, all) = (printed(&[]), json(&["--json"]));
    assert!(list.lines().all(|line| line.chars().count() <= 80), "{list}");
    for (preset, listed) in PRESETS.iter().zip(all["presets"].as_array().unwrap()) {
        let line = list.lines().find(|line| line.split_whitespace().next() == Some(preset.name));
        let line = line.unwrap_or_else(|| panic!("{} is not in the list", preset.name));
        assert!(line.contains(preset.format.extension()) && line.contains(&preset.letters()), "{line}");
        assert_eq!(listed["name"], preset.name);
        let (page, whole) = (printed(&[preset.name]), json(&[preset.name, "--json"]));
        let words = page.split_whitespace().collect::<Vec<_>>().join(" ");
        let facts = whole["facts"].as_array().unwrap();
        assert_eq!(facts.len(), preset.facts.len());
        for (fact, told) in preset.facts.iter().zip(facts) {
            let mark = if fact.checked { "" } else { " (Not verified.)" };
            assert!(words.contains(&format!("{}{mark} [{}]", fact.text, fact.source)), "{}: {page}", fact.text);
            assert_eq!(told["checked"], fact.checked);
        }
        // File names and addresses do not break.
        let wide = |line: &&str| line.chars().count() > 80 && line.trim().contains(' ');
        assert_eq!(page.lines().find(wide), None, "{}", preset.name);
    }
    let run = mipfold().args(["presets", "quake"]).output().unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(2));
    assert!(said.contains("'quake'") && PRESETS.iter().all(|preset| said.contains(preset.name)), "{said}");
}
