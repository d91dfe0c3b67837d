//! What people and programs are told.

use std::cell::Cell;
use std::fmt::{Display, Formatter};
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::args::Global;
use crate::error::Error;
use crate::output::Gain;

/// One material that was built, or would be.
#[derive(Serialize)]
pub struct Built {
    pub name: String,
    pub folder: String,
    #[serde(flatten)]
    pub extent: Extent,
    pub files: Vec<String>,
    /// What it is made from, where names were looked at.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub maps: Vec<MapSaid>,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
    /// How far it is from plain mips, if it was folded.
    pub gain: Option<Gain>,
    /// Whether nothing was written, for that is too little.
    pub skipped: bool,
}

/// A material that was built before, of the same inputs, options and version.
#[derive(Serialize)]
pub struct Unchanged {
    pub name: String,
    pub folder: String,
    /// Of the build.
    pub warnings: Vec<String>,
}

/// A map of a material, and why it is one.
#[derive(Clone, Serialize)]
pub struct MapSaid {
    pub role: &'static str,
    pub file: String,
    /// Of a packed map.
    pub channel: Option<&'static str>,
    pub why: String,
}

impl Display for MapSaid {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        let channel = self.channel.map(|channel| format!(", {channel}")).unwrap_or_default();
        write!(f, "{}: {}{channel} ({})", self.role, self.file, self.why)
    }
}

/// A file or folder that plays no part.
#[derive(Serialize)]
pub struct Passed {
    pub path: String,
    pub why: String,
}

/// A texture of several tiles, each of which is a material.
#[derive(Serialize)]
pub struct Tiles {
    pub name: String,
    pub tiles: Vec<String>,
}

/// What was built.
#[derive(Serialize)]
#[serde(untagged)]
pub enum Extent {
    /// A mip chain.
    Texture { width: usize, height: usize, levels: usize, fold: &'static str },
    /// Attributes of vertices.
    Vertices { vertices: usize, triangles: usize },
}

impl Display for Extent {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        match self {
            Self::Texture { width, height, levels, fold } => {
                write!(f, "{width}x{height}, {levels} levels, fold {fold}")
            }
            Self::Vertices { vertices, triangles } => write!(f, "{vertices} vertices, {triangles} triangles"),
        }
    }
}

#[derive(Serialize)]
struct Json<'a> {
    schema: u32,
    dry_run: bool,
    materials: &'a [Built],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    unchanged: &'a [Unchanged],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    udim: &'a [Tiles],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    passed_over: &'a [Passed],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    warnings: &'a [String],
    errors: &'a [String],
}

/// Collects results; prints text as it comes, or JSON at the end.
pub struct Report {
    json: bool,
    quiet: bool,
    dry_run: bool,
    built: Vec<Built>,
    unchanged: Vec<Unchanged>,
    udim: Vec<Tiles>,
    passed_over: Vec<Passed>,
    /// Of no material.
    warnings: Vec<String>,
    errors: Vec<String>,
    /// Whether a check failed.
    failed: bool,
    /// What `--json` prints where it is not the list of materials.
    document: Option<String>,
    /// Whether standard output failed.
    unsaid: Cell<bool>,
    /// Hidden unless standard error is a terminal.
    pub progress: ProgressBar,
}

impl Report {
    pub fn new(global: &Global) -> Self {
        let shown = !global.json && !global.quiet && std::io::stderr().is_terminal();
        let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let progress = ProgressBar::with_draw_target(Some(0), target);
        let style = ProgressStyle::with_template("{bar:30} {percent:>3}% {msg} {elapsed}, {eta} left")
            .expect("a fixed template");
        progress.set_style(style);
        Self {
            json: global.json,
            quiet: global.quiet,
            dry_run: global.dry_run,
            built: vec![],
            unchanged: vec![],
            udim: vec![],
            passed_over: vec![],
            warnings: vec![],
            errors: vec![],
            failed: false,
            document: None,
            unsaid: Cell::new(false),
            progress,
        }
    }

    /// Room on the bar for one more piece of work, of which only the share that is done is known.
    pub fn portion(&self) -> Portion {
        Portion::on(&self.progress)
    }

    /// A line for people.
    pub fn say(&self, text: &str) {
        if !self.json && !self.quiet {
            self.out(text);
        }
    }

    /// Standard output may be a closed pipe or a full disk: the first is nobody's fault, the second is remembered.
    fn out(&self, text: &str) {
        let written = self.progress.suspend(|| writeln!(std::io::stdout(), "{text}"));
        if written.is_err_and(|e| e.kind() != ErrorKind::BrokenPipe) {
            self.unsaid.set(true);
        }
    }

    fn complain(&self, text: &str) {
        self.progress.suspend(|| writeln!(std::io::stderr(), "{text}").ok());
    }

    pub fn built(&mut self, built: Built) {
        let verb = if self.dry_run { "would write" } else { "wrote" };
        let done = match built.skipped {
            true => "skipped, nothing written".to_owned(),
            false => format!("{verb} {} files to {}", built.files.len(), built.folder),
        };
        self.say(&format!("{}: {}: {done}", built.name, built.extent));
        built.gain.iter().for_each(|gain| self.say(&format!("  {}", gain.describe())));
        if self.dry_run {
            built.maps.iter().for_each(|map| self.say(&format!("  {map}")));
        }
        built.notes.iter().for_each(|note| self.say(&format!("  {note}")));
        if self.dry_run {
            built.files.iter().for_each(|file| self.say(&format!("  {file}")));
        }
        self.warnings_of(&built.name, &built.warnings);
        self.built.push(built);
    }

    fn warnings_of(&self, name: &str, warnings: &[String]) {
        for warning in warnings {
            let name = if warning.starts_with(name) { String::new() } else { format!("{name}: ") };
            self.warning(&format!("{name}{warning}"));
        }
    }

    pub fn unchanged(&mut self, unchanged: Unchanged) {
        self.say(&format!("{}: unchanged in {}; --force builds it again", unchanged.name, unchanged.folder));
        self.warnings_of(&unchanged.name, &unchanged.warnings);
        self.unchanged.push(unchanged);
    }

    pub fn tiles(&mut self, tiles: Tiles) {
        let (first, last) = (tiles.tiles.first().expect("one at least"), tiles.tiles.last().expect("one at least"));
        let count = tiles.tiles.len();
        let said = if count == 1 { format!("1 tile], {first}") } else { format!("{count} tiles], {first} to {last}") };
        self.say(&format!("{}: [UDIM: {said}", tiles.name));
        self.udim.push(tiles);
    }

    /// People see it in a dry run, programs always.
    pub fn passed_over(&mut self, passed: Passed) {
        if self.dry_run {
            self.say(&format!("passed over: {}: {}", passed.path, passed.why));
        }
        self.passed_over.push(passed);
    }

    /// A warning about no material alone.
    pub fn warn(&mut self, text: String) {
        self.warning(&text);
        self.warnings.push(text);
    }

    pub fn warning(&self, text: &str) {
        if !self.json {
            self.complain(&format!("warning: {text}"));
        }
    }

    /// A check that failed, in one line.
    pub fn failure(&mut self, text: &str) {
        self.complain(&format!("failed: {text}"));
        self.failed = true;
    }

    /// What `--json` prints if there are no errors.
    pub fn document(&mut self, json: String) {
        self.document = Some(json);
    }

    pub fn error(&mut self, error: &Error) {
        let text = error.to_string();
        if !self.json {
            self.complain(&format!("error: {text}"));
        }
        self.errors.push(text);
    }

    pub fn finish(self) -> ExitCode {
        self.progress.finish_and_clear();
        if self.json {
            let Report { built, unchanged, udim, passed_over, warnings, errors, dry_run, .. } = &self;
            let (materials, dry_run) = (built.as_slice(), *dry_run);
            let json = Json { schema: 1, dry_run, materials, unchanged, udim, passed_over, warnings, errors };
            let list = || serde_json::to_string_pretty(&json).expect("plain data");
            let document = self.document.as_ref().filter(|_| errors.is_empty());
            self.out(document.map_or_else(list, |text| text.trim_end().to_owned()).as_str());
        }
        if self.unsaid.get() {
            self.complain("error: standard output cannot be written");
        }
        if !self.errors.is_empty() || self.unsaid.get() {
            ExitCode::from(2)
        } else if self.failed {
            ExitCode::from(1)
        } else {
            ExitCode::SUCCESS
        }
    }
}

/// A piece of work on the bar; others may move it at the same time.
pub struct Portion {
    bar: ProgressBar,
    shown: AtomicU64,
}

impl Portion {
    /// As fine as a bar of 30 characters can show.
    pub const STEPS: u64 = 100;

    /// Room on a bar.
    pub fn on(bar: &ProgressBar) -> Self {
        bar.inc_length(Self::STEPS);
        Self { bar: bar.clone(), shown: AtomicU64::new(0) }
    }

    /// Shows the share that is done, 0 to 1.
    pub fn show(&self, share: f64) {
        let steps = (share.clamp(0.0, 1.0) * Self::STEPS as f64) as u64;
        let before = self.shown.fetch_max(steps, Ordering::Relaxed);
        if steps > before {
            self.bar.inc(steps - before);
        }
    }
}
