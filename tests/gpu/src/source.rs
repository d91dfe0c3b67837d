//! The files of `kernels/wgsl`, each with the files it needs.

use std::fs;
use std::path::{Path, PathBuf};

use crate::translate::{Language, Names, translate};

/// The folder `kernels`.
pub fn kernels() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../kernels")
}

/// Names of the files in `kernels/wgsl`, without extension, sorted.
pub fn subjects() -> Vec<String> {
    let mut all: Vec<String> = fs::read_dir(kernels().join("wgsl"))
        .expect("kernels/wgsl")
        .map(|entry| entry.expect("an entry of kernels/wgsl").path())
        .filter(|path| path.extension().is_some_and(|e| e == "wgsl"))
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    all.sort();
    all
}

/// Whether the file's functions take derivatives, and so run in fragment shaders only.
pub fn is_screen(subject: &str) -> bool {
    subject.ends_with("_screen")
}

/// A file with all that it needs, in one language.
pub struct Bundle {
    /// All files, those needed first.
    pub text: String,
    /// The file's own text, without a heading.
    pub own: String,
    /// Everything declared.
    pub names: Names,
    /// The file's own functions.
    pub functions: Vec<String>,
}

/// The subject in `language`, made from WGSL, or `file:line: what is wrong`.
pub fn bundle(subject: &str, language: Language) -> Result<Bundle, String> {
    let mut order = Vec::new();
    collect(subject, &mut Vec::new(), &mut order)?;
    let (mut names, mut parts, mut before) = (Names::default(), Vec::new(), 0);
    for (name, text) in &order {
        before = names.functions.len();
        let part = translate(text, language, is_screen(name), &mut names);
        parts.push(part.map_err(|wrong| format!("kernels/wgsl/{name}.wgsl:{wrong}"))?);
    }
    let functions = names.functions[before..].iter().map(|f| f.name.clone()).collect();
    let text = parts.join("\n");
    Ok(Bundle { text, own: parts.pop().expect("the file itself"), names, functions })
}

/// The file as it is checked in: with a note where it comes from, and a guard against a second inclusion.
pub fn generated(subject: &str, language: Language) -> Result<String, String> {
    let own = bundle(subject, language)?.own;
    let name = language.name();
    let guard = format!("MF_{}_{}", subject.to_uppercase(), name.to_uppercase());
    // Fragment shaders of GLSL ES have no precision of floats of their own, and 16 bits of integers.
    let precision = "// In GLSL ES, include it after `precision highp float;` and `precision highp int;`.\n";
    let precision = if language == Language::Glsl { precision } else { "" };
    Ok(format!(
        "// Generated from kernels/wgsl/{subject}.wgsl: change that file, not this one.\n{precision}\
         #ifndef {guard}\n#define {guard}\n\n{}\n\n#endif\n",
        own.trim_end()
    ))
}

fn collect(subject: &str, within: &mut Vec<String>, order: &mut Vec<(String, String)>) -> Result<(), String> {
    if order.iter().any(|(name, _)| name == subject) {
        return Ok(());
    }
    if within.iter().any(|name| name == subject) {
        return Err(format!("kernels/wgsl/{subject}.wgsl:1: needs itself"));
    }
    within.push(subject.to_string());
    let path = kernels().join("wgsl").join(format!("{subject}.wgsl"));
    let text = fs::read_to_string(&path).map_err(|e| format!("kernels/wgsl/{subject}.wgsl:1: {e}"))?;
    let line = text.lines().take_while(|l| l.starts_with("//")).find_map(|l| l.strip_prefix("// Needs: "));
    let Some(line) = line else {
        return Err(format!("kernels/wgsl/{subject}.wgsl:1: the comment on top has no line `// Needs: `"));
    };
    for name in line.trim_end_matches('.').split(", ").filter(|&n| n != "nothing") {
        collect(name.trim(), within, order)?;
    }
    within.pop();
    order.push((subject.to_string(), text));
    Ok(())
}
