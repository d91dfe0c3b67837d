//! `mipfold audit`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::args::{EXIT_CODES, MapArgs, ReadingArgs, entry};
use super::inputs::{folder, read_as, single};
use super::report::Report;
use crate::audit::{Audit, CHECKS, Finding, Severity, audit};
use crate::codec;
use crate::error::{Error, Result};
use crate::material::{Inputs, Model, Surface, height_beside};

#[derive(Args)]
#[command(after_help = check_list())]
pub struct AuditArgs {
    /// Folders of texture sets, found by file name, or glTF models (.glb, .gltf)
    #[arg(value_name = "INPUT", conflicts_with_all = ["normal", "orm", "height", "anisotropy"])]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub maps: MapArgs,
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// Names of checks, for the help.
fn check_list() -> String {
    let lines: Vec<_> = CHECKS.iter().map(|check| entry(check.name, check.about)).collect();
    format!("Checks:\n{}\n\nAn error among the findings is a check that failed. {EXIT_CODES}", lines.join("\n"))
}

#[derive(Serialize)]
struct Json<'a> {
    schema: u32,
    materials: &'a [Audit],
}

/// A material to look at.
enum Set {
    Files(Inputs),
    Model(Surface),
    /// One without maps, by its name.
    Bare(String),
    /// One that cannot be told apart or read, and its name.
    Broken(String, Error),
}

pub fn run(args: &AuditArgs, report: &mut Report) -> Result<()> {
    let sets = sets(args)?;
    if args.maps.name.is_some() && sets.len() > 1 {
        let expected = "one material; several are named after their files";
        return Err(Error::invalid_option("--name", format!("{} materials", sets.len()), expected));
    }
    let mut audits = Vec::new();
    for set in sets {
        let audit = match set {
            Set::Files(inputs) => audit(&inputs, &codec::read),
            Set::Model(surface) => audit(&surface.inputs, &|path| surface.read(path)),
            Set::Bare(name) => Audit { name, size: None, findings: Vec::new() },
            Set::Broken(name, error) => Audit::unloadable(name, &error),
        };
        report.say(&text(&audit));
        audits.push(audit);
    }
    let json = Json { schema: 1, materials: &audits };
    report.document(serde_json::to_string_pretty(&json).expect("plain data"));
    for audit in audits.iter().filter(|audit| audit.count(Severity::Error) > 0) {
        report.failure(&format!("{}: {}", audit.name, counted(audit.count(Severity::Error), "error")));
    }
    Ok(())
}

fn sets(args: &AuditArgs) -> Result<Vec<Set>> {
    let (maps, reading) = (&args.maps, &args.reading);
    if args.inputs.is_empty() {
        return Ok(vec![Set::Files(read_as(single(maps, reading, "audit")?, maps, reading)?)]);
    }
    let mut sets = Vec::new();
    for input in &args.inputs {
        if let Some(model) = model(input)? {
            sets.extend(surfaces(&model, input)?);
            continue;
        }
        for set in folder(input, maps, reading)? {
            sets.push(match set {
                Ok(set) => {
                    let mut inputs = read_as(set, maps, reading)?;
                    if let Some(normal) = &inputs.normal {
                        // A build has no use for it beside a normal map; an audit has.
                        inputs.height = height_beside(normal);
                    }
                    Set::Files(inputs)
                }
                Err(error) => Set::Broken(name_of(input), error),
            });
        }
    }
    Ok(sets)
}

fn name_of(input: &Path) -> String {
    let place = input.canonicalize().unwrap_or_else(|_| input.to_owned());
    place.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn model(input: &Path) -> Result<Option<Model>> {
    let extension = input.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if input.is_file() && ["glb", "gltf"].contains(&extension.as_str()) { Model::read(input) } else { Ok(None) }
}

/// The materials of a model, one for those that share their maps.
fn surfaces(model: &Model, input: &Path) -> Result<Vec<Set>> {
    let surfaces = model.surfaces(0..model.materials()?)?;
    if surfaces.is_empty() {
        return Err(Error::invalid(input, "no material", "a model with materials"));
    }
    Ok(surfaces
        .into_iter()
        .map(|surface| match surface {
            Ok(surface) if surface.uv_set.is_none() => Set::Bare(surface.inputs.name),
            Ok(surface) => Set::Model(surface),
            Err(error) => Set::Broken(name_of(input), error),
        })
        .collect())
}

/// Letters of a line.
const LINE: usize = 100;

/// A material's findings for people.
fn text(audit: &Audit) -> String {
    let size = audit.size.map(|size| format!(" ({size})")).unwrap_or_default();
    if audit.findings.is_empty() {
        let nothing = if audit.size.is_some() { "nothing found" } else { "no maps" };
        return format!("{}{size}: {nothing}", audit.name);
    }
    let counts: Vec<_> = [Severity::Error, Severity::Warning, Severity::Note]
        .into_iter()
        .filter(|severity| audit.count(*severity) > 0)
        .map(|severity| counted(audit.count(severity), severity.name()))
        .collect();
    let mut lines = vec![format!("{}{size}: {}", audit.name, counts.join(", "))];
    for Finding { check, severity, map, channel, evidence, confidence, fix } in &audit.findings {
        let place = channel.map_or_else(|| map.clone(), |channel| format!("{map}, {channel}"));
        lines.push(format!("  {} {check} ({place}), confidence {confidence:.2}", severity.name()));
        lines.extend(wrapped(evidence, "    "));
        lines.extend(wrapped(&format!("fix: {fix}"), "    "));
    }
    lines.join("\n")
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Lines of a paragraph, indented.
fn wrapped(text: &str, indent: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= LINE) {
            Some(line) => *line = format!("{line} {word}"),
            None => lines.push(format!("{indent}{word}")),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;

    #[test]
    fn a_block_a_material_with_the_fix_last() {
        let finding = Finding {
            check: "lean",
            severity: Severity::Note,
            map: "n.png".into(),
            channel: Some("red green"),
            evidence: "word ".repeat(30),
            confidence: 0.5,
            fix: "level it".into(),
        };
        let worse = Finding { check: "green", severity: Severity::Error, channel: None, ..finding.clone() };
        let mut audit =
            Audit { name: "wall".into(), size: Some(Size::new(8, 4)), findings: vec![worse, finding.clone(), finding] };
        let lines: Vec<String> = text(&audit).lines().map(str::to_owned).collect();
        assert_eq!(lines[0], "wall (8x4): 1 error, 2 notes");
        assert_eq!(lines[1], "  error green (n.png), confidence 0.50");
        assert_eq!(lines[5], "  note lean (n.png, red green), confidence 0.50");
        assert_eq!(lines[4], "    fix: level it");
        assert!(lines.iter().all(|line| line.len() <= LINE), "{lines:?}");
        audit.findings.clear();
        assert_eq!(text(&audit), "wall (8x4): nothing found");
        audit.size = None;
        assert_eq!(text(&audit), "wall: no maps");
    }
}
