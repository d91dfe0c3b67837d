//! What people and programs are told.

use std::cell::Cell;
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::args::Global;
use crate::error::Error;

/// One material that was built, or would be.
#[derive(Serialize)]
pub struct Built {
    pub name: String,
    pub folder: String,
    pub width: usize,
    pub height: usize,
    pub levels: usize,
    pub fold: &'static str,
    pub files: Vec<String>,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
}

#[derive(Serialize)]
struct Json<'a> {
    schema: u32,
    dry_run: bool,
    materials: &'a [Built],
    errors: &'a [String],
}

/// Collects results; prints text as it comes, or JSON at the end.
pub struct Report {
    json: bool,
    quiet: bool,
    dry_run: bool,
    built: Vec<Built>,
    errors: Vec<String>,
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
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} {elapsed}").expect("a fixed template");
        progress.set_style(style);
        Self {
            json: global.json,
            quiet: global.quiet,
            dry_run: global.dry_run,
            built: vec![],
            errors: vec![],
            unsaid: Cell::new(false),
            progress,
        }
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
        self.say(&format!(
            "{}: {}x{}, {} levels, fold {}: {verb} {} files to {}",
            built.name,
            built.width,
            built.height,
            built.levels,
            built.fold,
            built.files.len(),
            built.folder
        ));
        built.notes.iter().for_each(|note| self.say(&format!("  {note}")));
        if self.dry_run {
            built.files.iter().for_each(|file| self.say(&format!("  {file}")));
        }
        if !self.json {
            for warning in &built.warnings {
                let name = if warning.starts_with(&built.name) { String::new() } else { format!("{}: ", built.name) };
                self.complain(&format!("warning: {name}{warning}"));
            }
        }
        self.built.push(built);
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
            let Report { built, errors, dry_run, .. } = &self;
            let json = Json { schema: 1, dry_run: *dry_run, materials: built, errors };
            self.out(&serde_json::to_string_pretty(&json).expect("plain data"));
        }
        if self.unsaid.get() {
            self.complain("error: standard output cannot be written");
        }
        if self.errors.is_empty() && !self.unsaid.get() { ExitCode::SUCCESS } else { ExitCode::from(2) }
    }
}
