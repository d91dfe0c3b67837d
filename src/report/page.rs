//! The findings for people.

use askama::Template;

use super::disks;
use super::figures::{self, ChartView, Numbers, Status, SummaryRow};
use super::histogram::{self, Spread};
use super::mips;
use super::pictures::{data, heat_scale};
use super::strip::{self, HOTTEST, Look, distance_name};
use super::verdict::short;
use super::{ChainAbout, Matters, Subject, verdict};
use crate::compare::Candidate;
use crate::error::{Error, Result};
use crate::material::{Origin, surface_lobes};
use crate::reference::Interpolation;
use crate::render::DISTANCES;

/// A picture in a table.
struct Cell {
    id: String,
    src: String,
    alt: String,
    under: String,
}

struct Row {
    name: String,
    cells: Vec<Cell>,
}

struct MapView {
    name: String,
    format: String,
    size: String,
    roles: String,
    sha256: String,
    short: String,
}

/// Where a chain comes from.
struct ChainOrigin {
    name: String,
    source: String,
    notes: Vec<String>,
    warnings: Vec<String>,
}

struct MotionView {
    name: &'static str,
    src: String,
    width: usize,
    height: usize,
    alt: String,
    rows: Vec<MotionRow>,
}

struct MotionRow {
    name: String,
    mean: String,
    p95: String,
    flicker: String,
}

struct Roughness {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

type Fact = (&'static str, String);

#[derive(Template)]
#[template(path = "report/page.html")]
struct Page<'a> {
    css: &'static str,
    js: &'static str,
    version: &'static str,
    material: &'a str,
    size: String,
    chain_count: String,
    tone: &'static str,
    answer: &'static str,
    verdict: String,
    status: Status,
    summary: Vec<SummaryRow>,
    /// Whether the table shows level 0.
    first_shown: bool,
    distances: Vec<String>,
    cell_side: usize,
    strip: Vec<Row>,
    errors: Vec<Row>,
    heat_scale: String,
    hottest: String,
    compare_left: usize,
    compare_right: usize,
    charts: Vec<ChartView>,
    columns: Vec<&'static str>,
    numbers: Vec<Numbers>,
    mips: String,
    ridges: Vec<histogram::Panel>,
    ridges_lead: &'static str,
    roughness: Roughness,
    disks: Vec<disks::Panel>,
    motions: Vec<MotionView>,
    origins: Vec<ChainOrigin>,
    maps: Vec<MapView>,
    conventions: Vec<Fact>,
    notes: &'a [String],
    warnings: &'a [String],
    command: &'a str,
    settings: Vec<Fact>,
}

/// By which a page of ours is known.
pub const HTML_MARK: &str = "<meta name=\"generator\" content=\"mipfold ";

/// One HTML page that holds everything in itself: pictures, style and script. It loads nothing, and can be read
/// without scripts. `done` is called with the share of the work that is done, 0 to 1.
///
/// # Errors
/// None that depend on the subject; a picture that cannot be encoded.
pub fn page(subject: &Subject, done: &(dyn Fn(f64) + Sync)) -> Result<String> {
    page_with(subject, Look::of(subject.chains.len()), done)
}

pub(super) fn page_with(subject: &Subject, look: Look, done: &(dyn Fn(f64) + Sync)) -> Result<String> {
    let Subject { material, chains, .. } = subject;
    done(0.0);
    let base = surface_lobes(*material);
    // The strip is by far the longest part.
    let columns = strip::columns(&base, chains, look, &|share| done(0.8 * share))?;
    let spreads: Vec<Vec<Spread>> = chains.iter().map(|c| c.levels.iter().map(Spread::of).collect()).collect();
    let disks = disks::panels(subject, &base, look.disk)?;
    done(0.9);
    let names: Vec<&str> = chains.iter().map(|chain| chain.name.as_str()).collect();
    let verdict = verdict(subject);
    let best = subject.judgement.chains.iter().find(|chain| Some(&chain.name) == verdict.chain.as_ref());
    let folded = best.is_some_and(|chain| chain.fold.is_some());
    let (strip, errors) = rows(&names, columns);
    let page = Page {
        css: include_str!("../../templates/report/page.css"),
        js: include_str!("../../templates/report/page.js"),
        version: env!("CARGO_PKG_VERSION"),
        material: &material.name,
        size: material.size.to_string(),
        chain_count: format!("{} {}", chains.len(), if chains.len() == 1 { "chain" } else { "chains" }),
        tone: match verdict.matters {
            Matters::Yes => "yes",
            Matters::Little => "little",
            Matters::NotNeeded => "not-needed",
            Matters::NoHelp => "no-help",
            Matters::Unknown => "unknown",
        },
        answer: match verdict.matters {
            Matters::Yes if folded => "Fold it",
            Matters::Yes => "Closer",
            Matters::Little => "Little gain",
            Matters::NotNeeded => "Leave it",
            Matters::NoHelp => "No gain",
            Matters::Unknown => "Open",
        },
        verdict: verdict.text,
        status: figures::status(subject),
        summary: figures::summary(subject),
        first_shown: figures::any_first(subject),
        distances: DISTANCES.iter().map(|d| distance_name(*d)).collect(),
        cell_side: look.cell,
        // Plain mips, or else the first chain, against the truth.
        compare_left: subject.plain.unwrap_or(0),
        compare_right: strip.len() - 1,
        strip,
        errors,
        heat_scale: heat_scale()?,
        hottest: short(HOTTEST.into()),
        charts: figures::charts(subject),
        columns: figures::COLUMNS.iter().map(|c| c.0).collect(),
        numbers: figures::numbers(subject),
        mips: mips::strip(chains)?,
        ridges: histogram::panels(&names, &spreads, subject.plain),
        ridges_lead: match subject.plain {
            Some(_) if chains.len() > 1 => {
                "How rough the texels of every level are: filled as the chain has them, outlined as plain mips have them."
            }
            _ => "How rough the texels of every level are.",
        },
        roughness: roughness(&names, &spreads),
        disks,
        motions: motions(subject),
        origins: origins(subject),
        maps: maps(subject),
        conventions: conventions(subject),
        notes: &material.notes,
        warnings: &material.warnings,
        command: subject.command,
        settings: settings(subject),
    };
    let html = page.render().map_err(|error| Error::invalid_option("report", error.to_string(), "a page"))?;
    done(1.0);
    Ok(html)
}

/// Pictures by chain and the truth, and error maps by chain.
fn rows(names: &[&str], columns: Vec<strip::Column>) -> (Vec<Row>, Vec<Row>) {
    let row = |name: &str| Row { name: name.to_owned(), cells: Vec::new() };
    let mut pictures: Vec<Row> = names.iter().copied().chain(["truth"]).map(row).collect();
    let mut errors: Vec<Row> = names.iter().copied().map(row).collect();
    for (k, column) in columns.into_iter().enumerate() {
        let far = distance_name(column.distance);
        for (i, (picture, error, mean)) in column.chains.into_iter().enumerate() {
            let under = format!("{mean:.3}");
            let alt = format!("{} at {far}", names[i]);
            pictures[i].cells.push(Cell { id: format!("p-{i}-{k}"), src: picture, alt, under: String::new() });
            let alt = format!("Error map of {} at {far}, mean {under}", names[i]);
            errors[i].cells.push(Cell { id: format!("e-{i}-{k}"), src: error, alt, under });
        }
        let id = format!("p-{}-{k}", names.len());
        let cell = Cell { id, src: column.truth, alt: format!("truth at {far}"), under: String::new() };
        pictures[names.len()].cells.push(cell);
    }
    (pictures, errors)
}

fn roughness(names: &[&str], spreads: &[Vec<Spread>]) -> Roughness {
    let count = spreads.iter().map(Vec::len).max().unwrap_or(0);
    let cell = |spread: Option<&Spread>| {
        spread.map_or("none".into(), |s| format!("{:.3} ({:.2} to {:.2})", s.mean, s.p5, s.p95))
    };
    let rows = (0..count).map(|k| spreads.iter().map(|levels| cell(levels.get(k))).collect());
    Roughness { names: names.iter().map(|name| (*name).to_owned()).collect(), rows: rows.collect() }
}

fn motions(subject: &Subject) -> Vec<MotionView> {
    let view = |motion: &super::Motion| MotionView {
        name: motion.name,
        src: data("image/apng", &motion.apng),
        width: motion.size.0,
        height: motion.size.1,
        alt: motion.shown.iter().map(String::as_str).chain(["truth"]).collect::<Vec<_>>().join(", "),
        rows: motion
            .scores
            .iter()
            .map(|score| MotionRow {
                name: score.chain.clone(),
                mean: thousandths(score.flip_mean),
                p95: thousandths(score.flip_p95),
                flicker: thousandths(score.flicker),
            })
            .collect(),
    };
    subject.motion.iter().map(view).collect()
}

/// All with three decimals, so that columns line up.
fn thousandths(v: f64) -> String {
    if v.is_nan() { "n/a".into() } else { format!("{v:.3}") }
}

/// What was said of the surface is not said again.
fn origins(subject: &Subject) -> Vec<ChainOrigin> {
    let new = |texts: &[String], said: &[String]| texts.iter().filter(|t| !said.contains(t)).cloned().collect();
    let origin = |(chain, about): (&Candidate, &ChainAbout)| ChainOrigin {
        name: chain.name.clone(),
        source: match about.container {
            Some(container) => format!("{} ({container})", about.source),
            None => about.source.clone(),
        },
        notes: new(&about.notes, &subject.material.notes),
        warnings: new(&about.warnings, &subject.material.warnings),
    };
    subject.chains.iter().zip(subject.about).map(origin).collect()
}

fn maps(subject: &Subject) -> Vec<MapView> {
    /// Digits that tell files apart for people; the whole digest is at hand.
    const SHORT: usize = 12;
    let maps = subject.material.maps.iter().map(|map| {
        let roles = map.roles.iter().map(super::data::role).collect::<Vec<_>>().join(", ");
        let (name, format, size, sha256) = match &map.origin {
            Origin::File { path, sha256, size, format, .. } => {
                (path.display().to_string(), (*format).to_owned(), size.to_string(), sha256.clone())
            }
            Origin::Generated(what) => (what.clone(), "generated".into(), map.raster.size().to_string(), String::new()),
        };
        MapView { name, format, size, roles, short: sha256.chars().take(SHORT).collect(), sha256 }
    });
    maps.collect()
}

fn conventions(subject: &Subject) -> Vec<Fact> {
    let material = subject.material;
    vec![
        ("Green of normals", material.normal_y.describe().to_owned()),
        ("Strength of normals", material.normal_scale.to_string()),
        ("Beyond the border", format!("{:?}", material.wrap).to_lowercase()),
    ]
}

fn settings(subject: &Subject) -> Vec<Fact> {
    let s = subject.settings;
    let between = match s.reading.interpolation {
        Interpolation::Constant => "nothing: texels are squares".to_owned(),
        Interpolation::Bilinear { per_side, .. } => format!("interpolated at {per_side} x {per_side} places"),
    };
    let levels: Vec<_> = s.levels.iter().map(usize::to_string).collect();
    vec![
        ("Version", format!("mipfold {}", env!("CARGO_PKG_VERSION"))),
        ("Seed", s.seed.to_string()),
        ("Texels judged in a level", s.texels.map_or("all".into(), |n| format!("{n} at most"))),
        ("Directions from a footprint", s.directions.to_string()),
        ("Between the texels", between),
        ("Texels of a footprint", s.reading.most_texels.map_or("all".into(), |n| format!("{n} at most"))),
        ("Levels", if levels.is_empty() { "all".into() } else { levels.join(", ") }),
    ]
}
