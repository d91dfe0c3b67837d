//! A folder to work in, and how the binary is held to its manners there.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::{bumps, mipfold, names, png8};

/// Inputs of one test, and the folder that it builds into.
pub struct Desk(TempDir);

impl Desk {
    /// Empty.
    pub fn empty() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With `n.png` and `r.png`, a good pair.
    pub fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        bumps(&desk.at("n.png"), (64, 64));
        png8(&desk.at("r.png"), (64, 64), |_, _| vec![77]);
        desk
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn tree(&self) -> Vec<(PathBuf, u64)> {
        tree(self.0.path())
    }

    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        std::fs::write(self.at(name), bytes).unwrap();
        self.at(name)
    }

    /// Arguments are separated by blanks; `@` stands for the desk's folder.
    pub fn args(&self, args: &str) -> Vec<String> {
        let folder = format!("{}/", self.0.path().display());
        args.split_whitespace().map(|arg| arg.replace('@', &folder)).collect()
    }

    pub fn run(&self, args: &str) -> (Option<i32>, String) {
        let run = mipfold().args(self.args(args)).output().unwrap();
        let stderr = String::from_utf8(run.stderr).unwrap();
        assert!(!stderr.contains("panicked"), "{args}: {stderr}");
        (run.status.code(), stderr)
    }

    /// Builds into a folder of this name, without a word on stderr but warnings.
    pub fn build(&self, out: &str, args: &str) -> PathBuf {
        super::build(self.args(args), &self.at(out));
        self.at(out)
    }

    /// The build must refuse, on one line that names `culprit`, and leave the desk as it was.
    pub fn refuses(&self, args: &str, culprit: &str) -> String {
        let before = self.tree();
        let (code, stderr) = self.run(&format!("build {args}"));
        assert_eq!(code, Some(2), "{args}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{args}: {stderr}");
        let culprit = culprit.replace('@', &format!("{}/", self.0.path().display()));
        assert!(stderr.starts_with("error: ") && stderr.contains(&culprit), "{args}: {stderr} does not name {culprit}");
        assert_eq!(self.tree(), before, "{args}: files changed");
        stderr
    }

    /// The build must end well, with these warnings.
    pub fn warns(&self, args: &str, warnings: &[&str]) {
        let (code, stderr) = self.run(&format!("build {args}"));
        assert_eq!(code, Some(0), "{args}: {stderr}");
        assert_eq!(stderr.lines().count(), warnings.len(), "{args}: {stderr}");
        for (line, warning) in stderr.lines().zip(warnings) {
            assert!(line.starts_with("warning: ") && line.contains(warning), "{args}: {line} lacks {warning}");
        }
    }
}

/// Every file and folder below a folder, with the length of its content.
pub fn tree(folder: &Path) -> Vec<(PathBuf, u64)> {
    let mut found = Vec::new();
    for name in names(folder) {
        let path = folder.join(name);
        let about = path.metadata().unwrap();
        found.push((path.clone(), if about.is_dir() { 0 } else { about.len() }));
        if about.is_dir() {
            found.extend(tree(&path));
        }
    }
    found
}
