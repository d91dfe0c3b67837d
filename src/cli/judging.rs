//! The way from chains to findings, for `compare` and `demo`.

use std::io::Write;
use std::path::Path;

use super::report::Report;
use crate::compare::{Candidate, ChainScore, Judgement, Limit, Settings, judge};
use crate::error::Result;
use crate::material::{GENERATOR, Material};
use crate::output::{Stage, may_write};
use crate::report::{self, CSV_MARK, ChainAbout, HTML_MARK, Motion, Subject};

/// The files of a report; the first is written last.
pub const REPORT_FILES: [&str; 3] = ["report.json", "report.csv", "report.html"];

/// Whether a report may be written into a folder: over earlier reports of ours, but over no other file without `force`.
///
/// # Errors
/// As [`may_write`].
pub fn may_report(folder: &Path, force: bool) -> Result<()> {
    let strange = REPORT_FILES.into_iter().filter(|name| !is_ours(&folder.join(name)));
    may_write(folder, strange, force)
}

/// Whether a file is part of a report of ours.
fn is_ours(file: &Path) -> bool {
    let text = std::fs::read(file).unwrap_or_default();
    match file.extension().and_then(|e| e.to_str()) {
        Some("json") => {
            serde_json::from_slice::<serde_json::Value>(&text).is_ok_and(|report| report["generator"] == GENERATOR)
        }
        Some("csv") => text.starts_with(CSV_MARK.as_bytes()),
        _ => text.windows(HTML_MARK.len()).any(|part| part == HTML_MARK.as_bytes()),
    }
}

/// What is to be judged.
pub struct Judging<'a> {
    pub material: &'a Material,
    pub candidates: &'a [Candidate],
    /// One for each candidate.
    pub about: &'a [ChainAbout],
    pub plain: Option<usize>,
    pub settings: &'a Settings,
    pub limits: &'a [Limit],
    pub motion: bool,
}

/// What the judge found.
pub struct Findings {
    judgement: Judgement,
    motion: Vec<Motion>,
    command: String,
}

impl Judging<'_> {
    /// What a dry run says.
    pub fn announce(&self, output: Option<&Path>, report: &mut Report) {
        let names: Vec<_> = self.candidates.iter().map(|chain| chain.name.as_str()).collect();
        report.say(&format!("would judge {}", names.join(", ")));
        let files: Vec<String> =
            output.map_or_else(Vec::new, |folder| REPORT_FILES.map(|f| folder.join(f).display().to_string()).to_vec());
        files.iter().for_each(|file| report.say(&format!("would write {file}")));
        let about = |(chain, about): (&Candidate, &ChainAbout)| {
            serde_json::json!({
                "name": chain.name, "fold": chain.fold, "levels": chain.levels.len(), "source": about.source,
                "container": about.container, "notes": about.notes, "warnings": about.warnings,
            })
        };
        let chains: Vec<_> = self.candidates.iter().zip(self.about).map(about).collect();
        let object = serde_json::json!({
            "schema": 1, "dry_run": true, "material": self.material.name, "size": self.material.size,
            "settings": self.settings, "chains": chains, "files": files,
        });
        report.document(serde_json::to_string_pretty(&object).expect("plain data"));
    }

    /// Judges, and draws what moves.
    pub fn run(&self, report: &Report) -> Result<Findings> {
        report.progress.set_message(format!("judging {}", self.material.name));
        let bar = report.portion();
        let judgement = judge(self.material, self.candidates, self.settings, &|share| bar.show(share))?;
        let mut motion = Vec::new();
        if self.motion {
            report.progress.set_message(format!("drawing {} in motion", self.material.name));
            let bar = report.portion();
            motion = report::motion(self.material, self.candidates, &|share| bar.show(share));
        }
        Ok(Findings { judgement, motion, command: command() })
    }

    /// What the reports tell of.
    pub fn subject<'a>(&'a self, findings: &'a Findings) -> Subject<'a> {
        Subject {
            material: self.material,
            chains: self.candidates,
            about: self.about,
            judgement: &findings.judgement,
            plain: self.plain,
            limits: self.limits,
            settings: self.settings,
            command: &findings.command,
            motion: &findings.motion,
        }
    }
}

/// The texts of [`REPORT_FILES`]. They are made before anything is written, so that who interrupts leaves no trace.
pub fn texts(subject: &Subject, told: &Report) -> Result<[String; 3]> {
    told.progress.set_message(format!("drawing the report of {}", subject.material.name));
    let bar = told.portion();
    Ok([report::json(subject), report::csv(subject), report::page(subject, &|share| bar.show(share))?])
}

/// Writes them.
pub fn write(texts: &[String; 3], stage: &Stage) -> Result<()> {
    REPORT_FILES.iter().zip(texts).try_for_each(|(name, text)| stage.write(name, |out| out.write_all(text.as_bytes())))
}

/// One line for each chain past a limit, but for plain mips.
pub fn failures(subject: &Subject) -> Vec<String> {
    let held = subject.judgement.chains.iter().enumerate().filter(|(i, _)| Some(*i) != subject.plain);
    let line = |(_, chain): (usize, &ChainScore)| {
        let breaches = chain.breaches(subject.limits);
        let worst = breaches.first()?;
        let mut others: Vec<usize> = breaches.iter().map(|b| b.level).filter(|k| *k != worst.level).collect();
        others.sort_unstable();
        others.dedup();
        Some(match others.len() {
            0 => worst.to_string(),
            1 => format!("{worst}; 1 more level fails"),
            n => format!("{worst}; {n} more levels fail"),
        })
    };
    held.filter_map(line).collect()
}

/// The command line, to be pasted.
fn command() -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:@+%".contains(c);
    let quoted = |word: String| {
        if !word.is_empty() && word.chars().all(plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let words = std::env::args_os().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    std::iter::once("mipfold".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
