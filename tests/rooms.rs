//! The rooms of the library and their order: a room imports only rooms above it, and only `cli` prints.

use std::path::{Path, PathBuf};

/// From top to bottom.
///
/// The judge, `reference` and `compare`, stands above `fold`: it cannot know what it judges.
const ROOMS: [&str; 22] = [
    "error",
    "roughness",
    "random",
    "image",
    "codec",
    "ndf",
    "glint",
    "gltf",
    "curvature",
    "material",
    "audit",
    "reference",
    "compare",
    "moments",
    "summary",
    "fold",
    "output",
    "sample",
    "render",
    "report",
    "kernels",
    "cli",
];

fn place(room: &str) -> Option<usize> {
    ROOMS.iter().position(|r| *r == room)
}

/// Every Rust file below `src`, relative to it.
fn files() -> Vec<PathBuf> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    walk(&src, &mut found);
    found.sort();
    found.into_iter().map(|path| path.strip_prefix(&src).unwrap().to_owned()).collect()
}

/// Words of a path without the extension: `fold/chain.rs` is `fold`, `chain`.
fn words(file: &Path) -> Vec<String> {
    file.with_extension("").iter().map(|word| word.to_str().unwrap().to_owned()).collect()
}

/// The code of a file without comments, and without the tests that end it; nothing if all of it is tests.
fn code(file: &Path, text: &str) -> String {
    if words(file).iter().any(|word| word == "tests") {
        return String::new();
    }
    let mut lines: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let tests = lines.windows(2).position(|pair| pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod tests {"));
    lines.truncate(tests.unwrap_or(lines.len()));
    lines.join("\n")
}

/// How many times `super::` leads from a file to the root of the crate.
fn depth(file: &Path) -> usize {
    let words = words(file);
    words.len() - usize::from(words.last().is_some_and(|word| word == "mod"))
}

/// The names at the head of a path or of a group of paths: `a::b`, or `{a::b, c::{d, e}}`.
fn heads(after: &str) -> Vec<String> {
    let name = |text: &str| text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let Some(group) = after.strip_prefix('{') else { return vec![name(after)] };
    let (mut heads, mut level, mut start) = (Vec::new(), 0, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => level += 1,
            '}' if level == 0 => {
                heads.push(name(&group[start..at]));
                break;
            }
            '}' => level -= 1,
            ',' if level == 0 => {
                heads.push(name(&group[start..at]));
                start = at + 1;
            }
            _ => {}
        }
    }
    heads.retain(|head: &String| !head.is_empty());
    heads
}

/// The rooms that code names, by `crate::` or by as many `super::` as lead to the root.
fn named_rooms(code: &str, depth: usize) -> Vec<String> {
    let mut rooms = Vec::new();
    for root in ["crate::".to_owned(), "super::".repeat(depth)] {
        for (at, _) in code.match_indices(&root) {
            let boundary = !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            if boundary {
                rooms.extend(heads(&code[at + root.len()..]));
            }
        }
    }
    // The two names that the root itself gives away.
    rooms.iter().map(|room| if room == "Error" || room == "Result" { "error".into() } else { room.clone() }).collect()
}

/// What is wrong with a file.
fn faults(file: &Path, text: &str) -> Vec<String> {
    let (code, depth) = (code(file, text), depth(file));
    let own = words(file).swap_remove(0);
    let mut faults = Vec::new();
    for room in named_rooms(&code, depth) {
        match (place(&room), place(&own)) {
            (None, _) => faults.push(format!("{}: '{room}' is not a room", file.display())),
            (_, None) => faults.push(format!("{}: '{own}' is not a room", file.display())),
            (Some(there), Some(here)) if there > here => {
                faults.push(format!("{}: {own} imports {room}, which is below it", file.display()));
            }
            _ => {}
        }
    }
    for word in ["println!", "eprintln!", "print!", "eprint!", "dbg!"] {
        let called = |(at, _): (usize, &str)| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if own != "cli" && code.match_indices(word).any(called) {
            faults.push(format!("{}: {word} outside cli", file.display()));
        }
    }
    faults
}

#[test]
fn rooms_import_only_rooms_above_them_and_only_cli_prints() {
    let mut faults_found = Vec::new();
    let mut imports = 0;
    for file in files() {
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(&file)).unwrap();
        if !["lib.rs", "main.rs"].contains(&file.to_str().unwrap()) {
            imports += named_rooms(&code(&file, &text), depth(&file)).len();
            faults_found.extend(faults(&file, &text));
        }
    }
    assert!(faults_found.is_empty(), "\n{}", faults_found.join("\n"));
    assert!(imports > 50, "only {imports} imports were found");
}

#[test]
fn every_room_is_in_the_list_and_the_other_way_round() {
    let mut rooms: Vec<_> = files().iter().map(|file| words(file).swap_remove(0)).collect();
    rooms.retain(|room| room != "lib" && room != "main");
    rooms.dedup();
    let mut listed = ROOMS.map(String::from).to_vec();
    listed.sort();
    rooms.sort();
    assert_eq!(rooms, listed);
}

#[test]
fn the_reader_of_imports_finds_what_it_must() {
    let found = |file: &str, text: &str| faults(Path::new(file), text);
    assert_eq!(found("fold/lean.rs", "use crate::moments::Moments;\nuse super::Fold;\nuse crate::Result;"), [""; 0]);
    let wrong = [
        ("fold/lean.rs", "use crate::output::Plan;"),
        ("fold/mod.rs", "use super::cli::run;"),
        ("fold/lean.rs", "use super::super::render;"),
        ("image/span.rs", "use crate::{error::Error, codec::{read, write}};"),
        ("image.rs", "fn f() -> crate::codec::Depth {}"),
        ("moments/mod.rs", "pub(crate) use crate::{\n    image::Size,\n    fold,\n};"),
        ("output/write.rs", "eprintln!(\"\");"),
        ("codec/new.rs", "use crate::shaders::TEXT;"),
        ("fold/a.rs", "use crate::cli;\n#[cfg(test)]\nmod tests {\n}"),
    ];
    for (file, text) in wrong {
        assert_eq!(found(file, text).len(), 1, "{file}: {text}");
    }
    let right = [
        ("cli/report.rs", "println!(\"\");"),
        ("fold/tests.rs", "use crate::cli::run;"),
        ("fold/a.rs", "#[cfg(test)]\nmod tests {\n    use crate::cli;\n}"),
        ("fold/a.rs", "/// As [`crate::cli`] says.\nuse std::fmt;"),
        ("image/mod.rs", "fn f(fingerprint: u8) { imprint!(3) }"),
    ];
    for (file, text) in right {
        assert_eq!(found(file, text), [""; 0], "{file}: {text}");
    }
}
