//! The README says what is so: its tables, commands, files, manifest fields, snippet and links are checked.
//!
//! `BLESS=1 cargo test --test readme` writes the tables of folds, checks and presets again.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use mipfold::audit::CHECKS;
use mipfold::codec::write_png;
use mipfold::fold::FOLDS;
use mipfold::image::{Raster, Samples};
use mipfold::material::{Extra, NormalY};
use mipfold::output::Format;
use mipfold::output::preset::{Compress, PRESETS, Preset};
use ndarray::Array3;

#[path = "common/mesh.rs"]
mod mesh;

const README: &str = include_str!("../README.md");
const FOLDS_BEGIN: &str = "<!-- folds: written by `BLESS=1 cargo test --test readme` -->\n";
const FOLDS_END: &str = "<!-- /folds -->\n";
const CHECKS_BEGIN: &str = "<!-- checks: written by `BLESS=1 cargo test --test readme` -->\n";
const CHECKS_END: &str = "<!-- /checks -->\n";
const PRESETS_BEGIN: &str = "<!-- presets: written by `BLESS=1 cargo test --test readme` -->\n";
const PRESETS_END: &str = "<!-- /presets -->\n";

fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The text between two others.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(begin).unwrap_or_else(|| panic!("no {begin:?} in the README"));
    rest.split_once(end).unwrap_or_else(|| panic!("no {end:?} after {begin:?} in the README")).0
}

/// The cells of a Markdown table, without its two head lines.
fn rows(table: &str) -> Vec<Vec<&str>> {
    let lines = table.lines().filter(|line| line.starts_with('|')).skip(2);
    lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// What stands in backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The code blocks of a language.
fn blocks(language: &str) -> impl Iterator<Item = &'static str> {
    let opening = format!("```{language}\n");
    README.split("\n\n").filter_map(move |part| Some(part.strip_prefix(&opening)?.trim_end())).map(|block| {
        assert!(block.ends_with("```"), "blocks of commands hold no empty line: {block}");
        block.trim_end_matches("```")
    })
}

/// The commands of the README, without comments.
fn commands() -> Vec<&'static str> {
    let lines = blocks("sh").flat_map(str::lines);
    lines.map(|line| line.split(" #").next().unwrap_or_default().trim()).filter(|line| !line.is_empty()).collect()
}

/// A table of the README holds these rows; `BLESS` writes them into `readme`, which is returned.
fn table(readme: &str, [begin, end, head]: [&str; 3], expected: &[Vec<String>]) -> String {
    if std::env::var_os("BLESS").is_none() {
        let found = rows(between(readme, begin, end));
        assert_eq!(found, expected, "BLESS=1 cargo test --test readme writes the table again");
        return readme.to_owned();
    }
    let lines: String = expected.iter().map(|row| format!("| {} |\n", row.join(" | "))).collect();
    let (before, rest) = readme.split_once(begin).unwrap();
    let (_, after) = rest.split_once(end).unwrap();
    [before, begin, head, &lines, end, after].concat()
}

#[test]
fn tables_are_the_lists_of_folds_checks_and_presets() {
    let widths = |two: bool| if two { "one or two" } else { "one" };
    let folds: Vec<Vec<String>> = FOLDS
        .iter()
        .map(|f| vec![format!("`{}`", f.name), f.about.into(), widths(f.has_two_widths()).into(), f.cite.into()])
        .collect();
    let checks: Vec<Vec<String>> =
        CHECKS.iter().map(|check| vec![format!("`{}`", check.name), check.about.into()]).collect();
    let head = "| fold | what it does | widths | from |\n|---|---|---|---|\n";
    let readme = table(README, [FOLDS_BEGIN, FOLDS_END, head], &folds);
    let head = "| check | what it looks for |\n|---|---|\n";
    let readme = table(&readme, [CHECKS_BEGIN, CHECKS_END, head], &checks);
    let head = "| preset | engine | container | normals | packed map |\n|---|---|---|---|---|\n";
    let presets: Vec<Vec<String>> = PRESETS.iter().map(preset).collect();
    let readme = table(&readme, [PRESETS_BEGIN, PRESETS_END, head], &presets);
    if readme != README {
        fs::write(root("README.md"), readme).unwrap();
    }
}

fn preset(preset: &Preset) -> Vec<String> {
    let texels = match preset.compress {
        Compress::None => "uncompressed",
        Compress::Bc => "BC7 and BC5",
        Compress::Uastc => "UASTC",
    };
    let container = match preset.format {
        Format::Png => "PNG, a file a level".into(),
        Format::Exr => "EXR, mip-mapped".into(),
        Format::Ktx2 => format!("KTX 2, {texels}"),
        Format::Dds => format!("DDS, {texels}"),
    };
    let green = if preset.normal_y == NormalY::OpenGl { "green up" } else { "green down" };
    let normals = if preset.normal_z { format!("xyz, {green}") } else { format!("xy, {green}") };
    let letters = preset.letters();
    let packed =
        if letters.is_empty() { "as it came".into() } else { format!("{letters}, `{}`", preset.packed_suffix) };
    vec![format!("`{}`", preset.name), preset.engine.into(), container, normals, packed]
}

/// Makes the chains that `compare` shall read: the folder `out`, and a picture a level where a path has `%d`.
fn chains(arguments: &[&str], folder: &Path) {
    if arguments.contains(&"out") {
        run(&["build", "textures/wall", "-o", "out"], folder);
    }
    for path in arguments.iter().flat_map(|argument| argument.split([',', '='])).filter(|part| part.contains("%d")) {
        let path = path.split(':').next().unwrap();
        (0..5).for_each(|k| sized_picture(&folder.join(path.replace("%d", &k.to_string())), 16 >> k));
    }
}

/// A picture of one texel colour in 16 x 16: flat normals, or mid roughness with as many channels as a map may need.
fn picture(path: &Path) {
    sized_picture(path, 16);
}

fn sized_picture(path: &Path, side: usize) {
    let normal = path.to_string_lossy().contains("normal");
    let texel: &[u8] = if normal { &[128, 128, 255] } else { &[255, 128, 0, 128] };
    let samples = Array3::from_shape_fn((side, side, texel.len()), |(_, _, c)| texel[c]);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    write_png(fs::File::create(path).unwrap(), &Raster::new(Samples::U8(samples))).unwrap();
}

/// Runs `mipfold` with these arguments, after the inputs that they name were made.
fn run(arguments: &[&str], folder: &Path) {
    if arguments.first() == Some(&"compare") {
        chains(arguments, folder);
    }
    let command = |a: &&str| !["build", "compare", "bake-curvature", "glint", "audit"].contains(a);
    let mut values = arguments.iter().copied().skip_while(command).skip(1).peekable();
    while let Some(argument) = values.next() {
        match argument {
            "-o" => drop(values.next()),
            _ if argument.contains('=') => {}
            _ if argument.ends_with(".obj") => drop(mesh::obj(&folder.join(argument), true, true)),
            _ if argument.ends_with(".glb") => {
                let materials = serde_json::json!([{ "name": "hull" }, { "name": "deck" }]);
                mesh::glb(&folder.join(argument), materials, &[]);
            }
            _ if argument.ends_with(".gltf") => {
                picture(&folder.join("normal.png"));
                let json = serde_json::json!({
                    "asset": { "version": "2.0" },
                    "images": [{ "uri": "normal.png" }],
                    "textures": [{ "source": 0 }],
                    "materials": [{ "normalTexture": { "index": 0 } }],
                });
                fs::write(folder.join(argument), json.to_string()).unwrap();
            }
            _ if argument.contains(".png") => picture(&folder.join(argument.split(':').next().unwrap())),
            _ if argument.contains('/') => {
                picture(&folder.join(argument).join("wall_normal.png"));
                picture(&folder.join(argument).join("wall_orm.png"));
            }
            _ => {}
        }
    }
    let quick: &[&str] = match arguments[0] {
        "demo" => &["--size", "16", "--dry-run"],
        "glint" => &["--pixels", "32", "--frames", "2"],
        _ => &[],
    };
    let mipfold = Path::new(env!("CARGO_BIN_EXE_mipfold"));
    Command::new(mipfold).args(arguments).args(quick).current_dir(folder).assert().success();
}

#[test]
fn commands_work() {
    let commands = commands();
    let mut builds = 0;
    for command in &commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        match words[..] {
            ["cargo", "run", "--", ref arguments @ ..] => {
                run(arguments, tempfile::tempdir().unwrap().path());
            }
            ["mipfold", ref arguments @ ..] | ["/usr/bin/time", "-v", "target/release/mipfold", ref arguments @ ..] => {
                run(arguments, tempfile::tempdir().unwrap().path());
                builds += 1;
            }
            ["cargo", "run", "--example", example, ..] => {
                assert!(root(&format!("examples/{example}.rs")).is_file(), "{command}");
            }
            ["cargo", "test"] | ["cargo", "bench"] | ["cargo", "build", "--release"] => {}
            ["cargo", "install", "--path", "."] => {}
            _ => panic!("a command that this test does not know: {command}"),
        }
    }
    assert!(commands.starts_with(&["cargo run -- demo", "cargo test"]), "{commands:?}");
    assert!(builds > 10, "{commands:?}");
}

/// `demo --list` and the like in running text.
#[test]
fn options_in_the_text_exist() {
    let help: String = [
        ["build", "--help"],
        ["compare", "--help"],
        ["demo", "--help"],
        ["kernels", "--help"],
        ["bake-curvature", "--help"],
        ["glint", "--help"],
        ["audit", "--help"],
        ["presets", "--help"],
    ]
    .map(|arguments| {
        let output = Command::new(env!("CARGO_BIN_EXE_mipfold")).args(arguments).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    })
    .concat();
    let text: String = README.split("```").step_by(2).collect();
    for code in quoted(&text).filter(|code| !["cargo", "maketx", "ktx", "BLESS"].iter().any(|p| code.starts_with(p))) {
        for option in code.split_whitespace().filter(|word| word.starts_with("--")) {
            assert!(help.contains(option), "`{code}`: {option} is not in the help");
        }
    }
}

#[test]
fn files_and_manifest_fields_are_as_listed() {
    let folder = tempfile::tempdir().unwrap();
    let line = "build --normal wall_normal.png --roughness 0.3 --name wall --lobes aniso --format png,exr,ktx2,dds --moments --extra axes,burley,tensor,energy,diffuse -o out";
    run(&line.split(' ').collect::<Vec<_>>(), folder.path());
    let out = folder.path().join("out");

    let files = rows(between(README, "\n## What comes out\n", "\nNo file appears"));
    let any_level = |name: &str| name.replace(|c: char| c.is_ascii_digit(), "N");
    let patterns: Vec<String> = files.iter().flat_map(|row| quoted(row[0])).map(any_level).collect();
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(&out).unwrap() {
        let name = any_level(entry.unwrap().file_name().to_str().unwrap());
        let is = |pattern: &&String| {
            ["wall_normal", "anisotropy", "roughness"].iter().any(|stem| pattern.replace("FILE", stem) == name)
                || pattern.replace("NAME", "wall") == name
                || Extra::ALL.iter().any(|e| pattern.replace("NAME", "wall").replace("EXTRA", e.name()) == name)
        };
        found.extend(patterns.iter().filter(is));
        assert!(patterns.iter().any(|p| is(&p)), "{name} is written but not listed");
    }
    // Normals derived from heights, the curvature of a mesh and what presets want do not appear in this build.
    let apart = |p: &&String| ["_normal_", "_curvature", "*", "README"].iter().any(|part| p.contains(part));
    let missing: Vec<_> = patterns.iter().filter(|p| !found.contains(p) && !apart(p)).collect();
    assert!(missing.is_empty(), "{missing:?} are listed but not written");

    let manifest: serde_json::Value = serde_json::from_slice(&fs::read(out.join("manifest.json")).unwrap()).unwrap();
    let fields: BTreeSet<&str> = manifest.as_object().unwrap().keys().map(String::as_str).collect();
    let table = rows(between(README, "**`manifest.json`** holds\n", "\nWith a preset"));
    let listed: BTreeSet<&str> = table.iter().flat_map(|row| quoted(row[0])).collect();
    assert_eq!(fields, listed);
}

#[test]
fn report_fields_are_as_listed() {
    let folder = tempfile::tempdir().unwrap();
    let line = "compare out -o report --texels 2 --directions 4 --levels 1 --no-motion --no-plain";
    run(&line.split(' ').collect::<Vec<_>>(), folder.path());
    let read = |name: &str| fs::read_to_string(folder.path().join("report").join(name)).unwrap();
    let report: serde_json::Value = serde_json::from_str(&read("report.json")).unwrap();
    let chain = &report["chains"][0];
    let tables = [
        (&report, "**`report.json`** holds\n", "\nEach of its chains holds\n"),
        (chain, "\nEach of its chains holds\n", "\nand each level of a chain\n"),
        (&chain["levels"][0], "\nand each level of a chain\n", "\n**`report.csv`**"),
    ];
    for (value, begin, end) in tables {
        let fields: BTreeSet<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
        let table = rows(between(README, begin, end));
        let listed: BTreeSet<&str> = table.iter().flat_map(|row| quoted(row[0])).collect();
        assert_eq!(fields, listed);
        // Fields of fields, where a row names them.
        for row in table.iter().filter(|row| ["`base`", "`settings`", "`verdict`", "`energy`"].contains(&row[0])) {
            let inner = &value[row[0].trim_matches('`')];
            for field in inner.as_object().unwrap().keys() {
                assert!(quoted(row[1]).any(|name| name == field), "{field} of {}", row[0]);
            }
        }
    }
    let text = between(README, "**`report.csv`** has the columns", "Columns are added");
    let names: Vec<&str> = quoted(text).filter(|name| !["true", "false"].contains(name)).collect();
    let (endings, plain): (Vec<&str>, Vec<&str>) = names.into_iter().partition(|name| name.starts_with('_'));
    let levels = rows(between(README, "\nand each level of a chain\n", "\n**`report.csv`**"));
    let figures = quoted(levels[1][0]).flat_map(|figure| endings.iter().map(move |ending| format!("{figure}{ending}")));
    let mut expected: Vec<String> = plain[..8].iter().map(|name| (*name).to_owned()).collect();
    expected.extend(figures.collect::<Vec<_>>());
    expected.extend(plain[8..].iter().map(|name| (*name).to_owned()));
    assert_eq!(read("report.csv").lines().next().unwrap().split(',').collect::<Vec<_>>(), expected);
}

#[test]
fn snippet_is_that_of_the_crate_documentation() {
    let snippet = between(README, "```rust,no_run\n", "```");
    let documentation: String = include_str!("../src/lib.rs")
        .lines()
        .filter_map(|line| line.strip_prefix("//!"))
        .map(|line| line.strip_prefix(' ').unwrap_or(line))
        .filter(|line| !line.starts_with("# "))
        .flat_map(|line| [line, "\n"])
        .collect();
    assert!(documentation.contains(snippet), "the crate documentation has another one:\n{documentation}");
}

#[test]
fn links_lead_somewhere() {
    let headings: Vec<String> = README
        .lines()
        .filter_map(|line| line.strip_prefix("## "))
        .map(|heading| heading.to_lowercase().replace(' ', "-").replace([',', ':', '?', '.'], ""))
        .collect();
    let targets = README.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    for target in targets.filter(|target| !target.starts_with("http")) {
        match target.strip_prefix('#') {
            Some(anchor) => assert!(headings.iter().any(|heading| heading == anchor), "{target}"),
            None => assert!(root(target).exists(), "{target}"),
        }
    }
}
