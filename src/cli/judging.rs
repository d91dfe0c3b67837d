//! The way from chains to findings, for `compare` and `demo`.

use std::path::Path;

use super::report::Report;
use crate::compare::{Candidate, ChainScore, Limit, Settings, judge};
use crate::error::Result;
use crate::material::{GENERATOR, Material};
use crate::output::Stage;
use crate::report::{self, Subject};

/// The files of a report; the first marks a folder as ours.
pub const REPORT_FILES: [&str; 3] = ["report.json", "report.csv", "report.html"];

/// Whether a report of ours lies in a folder.
pub fn is_report(folder: &Path) -> bool {
    let text = std::fs::read(folder.join(REPORT_FILES[0])).unwrap_or_default();
    serde_json::from_slice::<serde_json::Value>(&text).is_ok_and(|report| report["generator"] == GENERATOR)
}

/// What is to be judged.
pub struct Judging<'a> {
    pub material: &'a Material,
    pub candidates: &'a [Candidate],
    pub plain: Option<usize>,
    pub settings: &'a Settings,
    pub limits: &'a [Limit],
    pub motion: bool,
}

impl Judging<'_> {
    /// What a dry run says.
    pub fn announce(&self, output: Option<&Path>, report: &mut Report) {
        let names: Vec<_> = self.candidates.iter().map(|chain| chain.name.as_str()).collect();
        report.say(&format!("would judge {}", names.join(", ")));
        let files: Vec<String> =
            output.map_or_else(Vec::new, |folder| REPORT_FILES.map(|f| folder.join(f).display().to_string()).to_vec());
        files.iter().for_each(|file| report.say(&format!("would write {file}")));
        let about = |chain: &Candidate| serde_json::json!({ "name": chain.name, "fold": chain.fold, "levels": chain.levels.len() });
        let chains: Vec<_> = self.candidates.iter().map(about).collect();
        let object = serde_json::json!({
            "schema": 1, "dry_run": true, "material": self.material.name, "size": self.material.size,
            "settings": self.settings, "chains": chains, "files": files,
        });
        report.document(serde_json::to_string_pretty(&object).expect("plain data"));
    }

    /// Judges, and hands the findings on.
    pub fn run(&self, report: &mut Report, then: impl FnOnce(&Findings, &mut Report) -> Result<()>) -> Result<()> {
        report.progress.set_message(format!("judging {}", self.material.name));
        let judgement = {
            let bar = report.portion();
            judge(self.material, self.candidates, self.settings, &|share| bar.show(share))?
        };
        let command = command();
        let subject = |motion| Subject {
            material: self.material,
            chains: self.candidates,
            judgement: &judgement,
            plain: self.plain,
            limits: self.limits,
            settings: self.settings,
            command: &command,
            motion,
        };
        let moving = if self.motion {
            report.progress.set_message(format!("drawing {} in motion", self.material.name));
            let bar = report.portion();
            report::motion(self.material, self.candidates, &|share| bar.show(share))
        } else {
            Vec::new()
        };
        let findings = Findings { subject: subject(&moving) };
        then(&findings, report)
    }
}

/// What the judge found, ready to be told.
pub struct Findings<'a> {
    pub subject: Subject<'a>,
}

impl Findings<'_> {
    /// The files of the report.
    pub fn write(&self, stage: &Stage, told: &Report) -> Result<()> {
        let subject = &self.subject;
        told.progress.set_message(format!("drawing the report of {}", subject.material.name));
        let bar = told.portion();
        let texts = [report::json(subject), report::csv(subject), report::page(subject, &|share| bar.show(share))?];
        for (name, text) in REPORT_FILES.iter().zip(texts) {
            stage.write(name, |out| std::io::Write::write_all(out, text.as_bytes()))?;
        }
        Ok(())
    }

    /// One line for each chain past a limit, but for plain mips.
    pub fn failures(&self) -> Vec<String> {
        let Subject { judgement, plain, limits, .. } = &self.subject;
        let held = judgement.chains.iter().enumerate().filter(|(i, _)| Some(*i) != *plain);
        let line = |(_, chain): (usize, &ChainScore)| {
            let breaches = chain.breaches(limits);
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
