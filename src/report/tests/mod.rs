//! The reports, on real chains and on scores made up for the purpose.

mod pages;
mod verdicts;

use serde_json::Value;

use super::page::page_with;
use super::strip::Look;
use super::*;
use crate::codec::{decode, write_png};
use crate::compare::{ChainScore, Energy, LevelScore, Place, Summary, WorstTexel};
use crate::fold::{Fold, Options, chain};
use crate::material::{ChannelRef, Inputs, RoughnessInput, base_lobes, load_with};
use crate::ndf::Form;
use crate::sample::by_name;

const SIDE: usize = 64;
const LEVELS: usize = 7;

const QUICK: Look = Look { cell: 24, chain_rays: 1, truth_rays: 2, disk: 12 };

/// Everything that a subject borrows.
struct Stage {
    material: Material,
    chains: Vec<Candidate>,
    judgement: Judgement,
    about: Vec<ChainAbout>,
    plain: Option<usize>,
    limits: Vec<Limit>,
    settings: Settings,
    motion: Vec<Motion>,
}

impl Stage {
    /// Chains by name, fold, and the largest lobe error, which falls to both sides of level 4.
    fn new(chains: &[(&str, &str, f64)]) -> Self {
        let maps = (by_name("tiles").unwrap().make)(SIDE, 1);
        let inputs = Inputs {
            name: "tiles".into(),
            normal: Some("tiles_normal.png".into()),
            roughness: RoughnessInput::Roughness(ChannelRef::parse("tiles_orm.png:g")),
            ..Inputs::default()
        };
        let material = load_with(&inputs, &|path| {
            let mut bytes = Vec::new();
            write_png(&mut bytes, if path.ends_with("tiles_normal.png") { &maps.normal } else { &maps.orm }).unwrap();
            decode(path, bytes)
        })
        .unwrap();
        let base = base_lobes(&material, Form::Isotropic);
        let candidate = |(name, fold, _): &(&str, &str, f64)| {
            let folded = chain(&material, &Options { fold: Fold::by_name(fold).unwrap(), ..Options::default() });
            Candidate { name: (*name).into(), fold: Some((*fold).into()), levels: folded.into_lobes(base.clone()) }
        };
        let candidates: Vec<_> = chains.iter().map(candidate).collect();
        let scores = chains.iter().map(|(name, fold, most)| scores(name, fold, *most)).collect();
        Self {
            judgement: Judgement { size: material.size, chains: scores },
            chains: candidates,
            about: Vec::new(),
            plain: chains.iter().position(|(name, ..)| *name == "plain"),
            limits: vec!["0.2".parse().unwrap(), "ndf-tv@2-=0.5".parse().unwrap()],
            settings: Settings::default(),
            motion: Vec::new(),
            material,
        }
    }

    fn subject(&self) -> Subject<'_> {
        Subject {
            material: &self.material,
            chains: &self.chains,
            about: &self.about,
            judgement: &self.judgement,
            plain: self.plain,
            limits: &self.limits,
            settings: &self.settings,
            command: "mipfold compare tiles --limit 0.2",
            motion: &self.motion,
        }
    }

    fn verdict(&self) -> Verdict {
        verdict(&self.subject())
    }

    fn page(&self) -> String {
        page_with(&self.subject(), QUICK, &|_| {}).unwrap()
    }
}

fn usual() -> Stage {
    Stage::new(&[("plain", "average", 0.62), ("mine", "projected", 0.15), ("theirs", "toksvig", 0.3)])
}

fn scores(name: &str, fold: &str, most: f64) -> ChainScore {
    let summary = |mean: f64| Summary { mean, median: 0.9 * mean, p95: 1.7 * mean, stderr: 0.03 * mean };
    let level = |k: usize| {
        let e = most * if k == 0 { 0.0 } else { 1.0 - 0.2 * (k as f64 - 4.0).abs() };
        let side = SIDE >> k;
        LevelScore {
            level: k,
            width: side,
            height: side,
            samples: 64.min(side * side),
            lobe_error: summary(e),
            lobe_error_light: summary(0.7 * e),
            ndf_tv: summary(0.6 * e),
            ndf_hellinger: summary(0.5 * e),
            ndf_kl: summary(0.4 * e),
            energy: Energy { mean: 1.0 - 0.2 * e, stderr: 0.01, compensated: 1.0 - 0.1 * e, views: vec![1.0; 5] },
            diffuse_error: summary(0.1 * e),
            worst: vec![WorstTexel { x: side / 2, y: 0, lobe_error: 2.0 * e }],
            median_texel: Place { x: 0, y: side / 2 },
        }
    };
    ChainScore {
        name: name.into(),
        fold: Some(fold.into()),
        lobes: Form::Isotropic,
        count: 1,
        levels: (0..LEVELS).map(level).collect(),
    }
}

#[test]
fn json_has_its_fields() {
    let stage = usual();
    let json: Value = serde_json::from_str(&json(&stage.subject())).unwrap();
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>().join(" ");
    let mut top: Vec<_> = keys(&json).split(' ').map(str::to_owned).collect();
    top.sort();
    assert_eq!(
        top.join(" "),
        "base chains command generator limits material pass plain schema settings verdict version"
    );
    assert_eq!((&json["schema"], &json["generator"], &json["plain"]), (&1.into(), &"mipfold".into(), &"plain".into()));
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["base"]["size"]["width"], SIDE);
    let map = &json["base"]["maps"][0];
    assert_eq!(map["path"], "tiles_normal.png");
    assert_eq!(map["roles"], serde_json::json!(["normal-x", "normal-y", "normal-z"]));
    assert_eq!(map["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(json["base"]["maps"][1]["roles"], serde_json::json!(["other", "roughness", "other"]));
    assert_eq!(
        json["limits"][0],
        serde_json::json!({"metric": "lobe-error", "first": null, "last": null, "most": 0.2})
    );
    assert_eq!(json["limits"][1], serde_json::json!({"metric": "ndf-tv", "first": 2, "last": null, "most": 0.5}));
    assert_eq!(json["settings"]["seed"], 1);
    let chain = &json["chains"][2];
    assert_eq!(
        (&chain["name"], &chain["fold"], &chain["lobes"]),
        (&"theirs".into(), &"toksvig".into(), &"isotropic".into())
    );
    assert_eq!(chain["count"], 1);
    assert_eq!(chain["levels"].as_array().unwrap().len(), LEVELS);
    assert_eq!(chain["levels"][4]["lobe_error"]["mean"], 0.3);
    assert_eq!(chain["levels"][4]["worst"][0]["x"], 2);
    assert_eq!(
        (&chain["pass"], &json["chains"][1]["pass"], &json["pass"]),
        (&false.into(), &true.into(), &false.into())
    );
    let breach = &chain["breaches"][0];
    assert_eq!((&breach["level"], &breach["metric"], &breach["most"]), (&4.into(), &"lobe-error".into(), &0.2.into()));
    assert!(breach["text"].as_str().unwrap().starts_with("theirs: level 4: lobe-error 0.300"));
    assert_eq!((&json["verdict"]["matters"], &json["verdict"]["level"]), (&"yes".into(), &4.into()));
    assert!((json["verdict"]["ratio"].as_f64().unwrap() - 0.62 / 0.15).abs() < 1e-9);
}

#[test]
fn plain_mips_do_not_fail_the_whole() {
    let mut stage = usual();
    stage.limits = vec!["0.5".parse().unwrap()];
    assert!(passes(&stage.subject()));
    let text = json(&stage.subject());
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["pass"], &json["chains"][0]["pass"]), (&true.into(), &false.into()));
}

/// Splits what `csv` wrote, by the rules of RFC 4180.
fn records(text: &str) -> Vec<Vec<String>> {
    let (mut records, mut record, mut field, mut quoted) = (vec![], vec![], String::new(), false);
    let mut letters = text.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '"' if quoted && letters.peek() == Some(&'"') => field.push(letters.next().unwrap()),
            '"' => quoted = !quoted,
            ',' if !quoted => record.push(std::mem::take(&mut field)),
            '\r' if !quoted => {
                assert_eq!(letters.next(), Some('\n'));
                record.push(std::mem::take(&mut field));
                records.push(std::mem::take(&mut record));
            }
            c => field.push(c),
        }
    }
    assert!(!quoted && field.is_empty() && record.is_empty());
    records
}

#[test]
fn csv_has_a_line_for_each_level_and_names_survive() {
    let mut stage = usual();
    stage.judgement.chains[1].name = "mine, \"best\"\r\nof all".into();
    stage.judgement.chains[0].fold = None;
    let records = records(&csv(&stage.subject()));
    assert_eq!(records.len(), 1 + 3 * LEVELS);
    assert!(records.iter().all(|record| record.len() == records[0].len()));
    let column = |name: &str| records[0].iter().position(|n| n == name).unwrap();
    let at = |line: usize, name: &str| records[line][column(name)].as_str();
    let line = 1 + LEVELS + 4;
    assert_eq!(at(line, "chain"), "mine, \"best\"\r\nof all");
    assert_eq!((at(line, "level"), at(line, "lobe_error_mean"), at(line, "within_limits")), ("4", "0.15", "true"));
    assert_eq!((at(1, "fold"), at(5, "within_limits"), at(1, "within_limits")), ("", "false", "true"));
}
