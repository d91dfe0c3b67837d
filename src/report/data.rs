//! The findings for programs.

use std::fmt::Write;

use serde::Serialize;

use super::{Subject, Verdict, verdict};
use crate::compare::{LevelScore, Limit, MotionScore, Settings, Summary};
use crate::image::{Size, Wrap};
use crate::material::{GENERATOR, MapFile, NormalY, Origin, Role};
use crate::ndf::Form;

/// Version of the JSON's form; fields are added, never renamed.
pub const SCHEMA: u32 = 1;

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    generator: &'static str,
    version: &'static str,
    material: &'a str,
    base: Base<'a>,
    settings: &'a Settings,
    limits: Vec<LimitEntry>,
    plain: Option<&'a str>,
    chains: Vec<Chain<'a>>,
    pass: bool,
    verdict: Verdict,
    command: &'a str,
}

#[derive(Serialize)]
struct Base<'a> {
    size: Size,
    normal_y: NormalY,
    normal_scale: f32,
    wrap: Wrap,
    maps: Vec<Map<'a>>,
    notes: &'a [String],
    warnings: &'a [String],
}

#[derive(Serialize)]
struct Map<'a> {
    path: Option<String>,
    generated: Option<&'a str>,
    sha256: Option<&'a str>,
    format: Option<&'static str>,
    size: Size,
    roles: Vec<String>,
}

#[derive(Serialize)]
struct LimitEntry {
    metric: &'static str,
    first: Option<usize>,
    last: Option<usize>,
    most: f64,
}

#[derive(Serialize)]
struct Chain<'a> {
    name: &'a str,
    fold: Option<&'a str>,
    lobes: Form,
    count: usize,
    source: Option<&'a str>,
    container: Option<&'static str>,
    notes: &'a [String],
    warnings: &'a [String],
    levels: &'a [LevelScore],
    motion: Vec<&'a MotionScore>,
    pass: bool,
    breaches: Vec<BreachEntry>,
}

#[derive(Serialize)]
struct BreachEntry {
    level: usize,
    metric: &'static str,
    mean: f64,
    stderr: f64,
    most: f64,
    text: String,
}

impl LimitEntry {
    /// `last` is `None` where there is no last level.
    fn new(limit: &Limit) -> Self {
        let levels = limit.levels.as_ref();
        let last = levels.map(|l| *l.end()).filter(|&last| last != usize::MAX);
        Self { metric: limit.metric.name, first: levels.map(|l| *l.start()), last, most: limit.most }
    }
}

/// In words, as the JSON and the page have it: "normal-x", "roughness", ..., "other".
pub(super) fn role(role: &Role) -> String {
    match serde_json::to_value(role) {
        Ok(serde_json::Value::String(name)) => name,
        _ => "other".into(),
    }
}

fn map(map: &MapFile) -> Map<'_> {
    let roles = map.roles.iter().map(role).collect();
    match &map.origin {
        Origin::File { path, sha256, size, format, .. } => Map {
            path: Some(path.to_string_lossy().into_owned()),
            generated: None,
            sha256: Some(sha256),
            format: Some(format),
            size: *size,
            roles,
        },
        Origin::Generated(what) => {
            Map { path: None, generated: Some(what), sha256: None, format: None, size: map.raster.size(), roles }
        }
    }
}

/// Everything as JSON, without times or facts of the machine. Numbers that are none (NaN) are `null`.
///
/// ```json
/// {
///   "schema": 1, "generator": "mipfold", "version": "0.1.0",
///   "material": "wall",
///   "base": {
///     "size": {"width": 512, "height": 512},
///     "normal_y": "opengl", "normal_scale": 1.0, "wrap": "repeat",
///     "maps": [{"path": "wall_n.png", "generated": null, "sha256": "..", "format": "PNG",
///               "size": {"width": 512, "height": 512}, "roles": ["normal-x", "normal-y", "normal-z"]}],
///     "notes": [], "warnings": []
///   },
///   "settings": {"texels": 64, "directions": 80, "reading": {}, "levels": [], "seed": 1},
///   "limits": [{"metric": "lobe-error", "first": null, "last": null, "most": 0.15}],
///   "plain": "plain mips",
///   "chains": [{
///     "name": "mine", "fold": "projected", "lobes": "isotropic", "count": 1,
///     "source": "out", "container": "png", "notes": [], "warnings": [],
///     "levels": [{"level": 1, "width": 256, "height": 256, "samples": 64,
///                 "lobe_error": {"mean": 0.1, "median": 0.1, "p95": 0.2, "stderr": 0.01}}],
///     "motion": [{"motion": "zoom", "chain": "mine", "flip_mean": 0.1, "flip_p95": 0.3, "flicker": 0.2}],
///     "pass": true,
///     "breaches": [{"level": 5, "metric": "lobe-error", "mean": 0.2, "stderr": 0.01, "most": 0.15, "text": ".."}]
///   }],
///   "pass": true,
///   "verdict": {"matters": "yes", "text": "..", "level": 5, "chain": "mine", "ratio": 4.1},
///   "command": "mipfold compare .."
/// }
/// ```
///
/// - `count` of a chain is the number of lobes of a texel, the most of any level.
/// - `levels` of a chain hold every field of [`LevelScore`]; `motion` those of [`MotionScore`].
/// - `source`, `container`, `notes` and `warnings` of a chain are [`ChainAbout`](super::ChainAbout)'s.
/// - `path` or `generated` is `null`. `size` of a map is that of the file, before any resampling.
/// - `first` and `last` of a limit are `null` where it has no such end.
/// - `plain` names the chain of plain mips that was made for comparison; the top `pass` leaves it out.
/// - `matters` is one of "yes", "little", "not-needed", "no-help" and "unknown" ([`Matters`](super::Matters)).
pub fn json(subject: &Subject) -> String {
    let Subject { material, judgement, .. } = subject;
    let chains = judgement.chains.iter().enumerate().map(|(i, chain)| {
        let breaches: Vec<_> = chain
            .breaches(subject.limits)
            .into_iter()
            .map(|b| BreachEntry {
                level: b.level,
                metric: b.limit.metric.name,
                mean: b.mean,
                stderr: b.stderr,
                most: b.limit.most,
                text: b.to_string(),
            })
            .collect();
        let about = subject.about.get(i);
        Chain {
            name: &chain.name,
            fold: chain.fold.as_deref(),
            lobes: chain.lobes,
            count: chain.count,
            source: about.map(|about| about.source.as_str()),
            container: about.and_then(|about| about.container),
            notes: about.map_or(&[], |about| &about.notes),
            warnings: about.map_or(&[], |about| &about.warnings),
            levels: &chain.levels,
            motion: subject.motion.iter().filter_map(|motion| motion.scores.get(i)).collect(),
            pass: breaches.is_empty(),
            breaches,
        }
    });
    let document = Document {
        schema: SCHEMA,
        generator: GENERATOR,
        version: env!("CARGO_PKG_VERSION"),
        material: &material.name,
        base: Base {
            size: material.size,
            normal_y: material.normal_y,
            normal_scale: material.normal_scale,
            wrap: material.wrap,
            maps: material.maps.iter().map(map).collect(),
            notes: &material.notes,
            warnings: &material.warnings,
        },
        settings: subject.settings,
        limits: subject.limits.iter().map(LimitEntry::new).collect(),
        plain: subject.plain.and_then(|i| judgement.chains.get(i)).map(|chain| chain.name.as_str()),
        chains: chains.collect(),
        pass: passes(subject),
        verdict: verdict(subject),
        command: subject.command,
    };
    let mut text = serde_json::to_string_pretty(&document).expect("strings and numbers");
    text.push('\n');
    text
}

/// Whether every chain but plain mips keeps all limits.
pub fn passes(subject: &Subject) -> bool {
    let chains = subject.judgement.chains.iter().enumerate();
    chains.filter(|(i, _)| Some(*i) != subject.plain).all(|(_, chain)| chain.breaches(subject.limits).is_empty())
}

type Column = (&'static str, fn(&LevelScore) -> Summary);

const SUMMARIES: [Column; 6] = [
    ("lobe_error", |l| l.lobe_error),
    ("lobe_error_light", |l| l.lobe_error_light),
    ("ndf_tv", |l| l.ndf_tv),
    ("ndf_hellinger", |l| l.ndf_hellinger),
    ("ndf_kl", |l| l.ndf_kl),
    ("diffuse_error", |l| l.diffuse_error),
];

/// What every CSV of ours begins with.
pub const CSV_MARK: &str = "material,chain,fold,lobes,level,width,height,samples";

/// One line for each level of each chain under one line of names, as RFC 4180 has it: lines end with CR LF. Every
/// summary takes four columns (`_mean`, `_median`, `_p95`, `_stderr`); `within_limits` tells whether the level keeps
/// all limits, and `count` the lobes of a texel. New columns are added at the end.
pub fn csv(subject: &Subject) -> String {
    let mut out = String::from(CSV_MARK);
    for (name, _) in SUMMARIES {
        write!(out, ",{name}_mean,{name}_median,{name}_p95,{name}_stderr").expect("strings grow");
    }
    out.push_str(",energy_mean,energy_stderr,energy_compensated,within_limits,count\r\n");
    for chain in &subject.judgement.chains {
        let form = if chain.lobes == Form::Isotropic { "isotropic" } else { "anisotropic" };
        let breaches = chain.breaches(subject.limits);
        for level in &chain.levels {
            let fold = chain.fold.as_deref().unwrap_or_default();
            let mut fields = vec![field(&subject.material.name), field(&chain.name), field(fold), form.into()];
            fields.extend([level.level, level.width, level.height, level.samples].map(|n| n.to_string()));
            for (_, read) in SUMMARIES {
                let s = read(level);
                fields.extend([s.mean, s.median, s.p95, s.stderr].map(|v| v.to_string()));
            }
            fields.extend([level.energy.mean, level.energy.stderr, level.energy.compensated].map(|v| v.to_string()));
            fields.push((!breaches.iter().any(|b| b.level == level.level)).to_string());
            fields.push(chain.count.to_string());
            out.push_str(&fields.join(","));
            out.push_str("\r\n");
        }
    }
    out
}

/// Quoted where it must be.
fn field(text: &str) -> String {
    if text.contains(['"', ',', '\r', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}
