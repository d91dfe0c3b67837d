//! The reports, on real chains and on scores made up for the purpose.

use serde_json::Value;

use super::page::page_with;
use super::strip::Look;
use super::*;
use crate::codec::{decode, write_png};
use crate::compare::{ChainScore, Energy, LevelScore, Place, Summary, WorstTexel};
use crate::fold::{FOLDS, Fold, Options, chain};
use crate::image::Size;
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
            let levels = folded.levels.into_iter().map(|level| level.lobes);
            Candidate {
                name: (*name).into(),
                fold: Some((*fold).into()),
                levels: std::iter::once(base.clone()).chain(levels).collect(),
            }
        };
        let candidates: Vec<_> = chains.iter().map(candidate).collect();
        let scores = chains.iter().map(|(name, fold, most)| scores(name, fold, *most)).collect();
        Self {
            judgement: Judgement { size: material.size, chains: scores },
            chains: candidates,
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

#[test]
fn verdict_that_folding_matters() {
    let found = usual().verdict();
    assert_eq!((found.matters, found.level), (Matters::Yes, Some(4)));
    assert_eq!(
        found.text,
        "Folding matters here: at level 4 plain mips are 4.1 x further from the truth than 'mine' (lobe error 0.62 \
         against 0.15)."
    );
}

#[test]
fn verdict_that_nothing_is_needed() {
    let found = Stage::new(&[("plain", "average", 0.0312), ("mine", "projected", 0.001)]).verdict();
    assert_eq!(found.matters, Matters::NotNeeded);
    let text = "This material needs nothing: plain mips stay within 0.032 of the truth at every level.";
    assert_eq!(found.text, text);
}

#[test]
fn verdict_counts_standard_errors() {
    let with = |mine: f64, stderr: f64| {
        let mut stage = Stage::new(&[("plain", "average", 0.3), ("mine", "projected", mine)]);
        stage.judgement.chains.iter_mut().for_each(|c| c.levels[4].lobe_error.stderr = stderr);
        stage.verdict()
    };
    // Two combined errors are 2 sqrt(2) 0.02 = 0.057.
    assert_eq!(with(0.24, 0.02).matters, Matters::Yes);
    let same = with(0.25, 0.02);
    assert_eq!(same.matters, Matters::NoHelp);
    assert!(
        same.text.starts_with("Folding does not help here: ") && same.text.contains("equally far"),
        "{}",
        same.text
    );
    let worse = with(0.5, 0.02);
    assert_eq!(worse.matters, Matters::NoHelp);
    assert!(worse.text.contains("further from the truth than plain mips (0.5 against 0.3)"), "{}", worse.text);
    // An error that is not known proves nothing.
    assert_eq!(with(0.1, f64::NAN).matters, Matters::NoHelp);
}

#[test]
fn verdict_without_what_it_needs() {
    let alone = Stage::new(&[("mine", "projected", 0.12)]).verdict();
    assert_eq!((alone.matters, alone.level), (Matters::Unknown, Some(4)));
    assert!(alone.text.starts_with("'mine' stays within 0.12 of the truth, worst at level 4"), "{}", alone.text);
    let two = Stage::new(&[("a", "lean", 0.2), ("b", "projected", 0.1)]).verdict();
    assert!(two.text.starts_with("The closest chain, 'b', stays within 0.1 "), "{}", two.text);
    let plain = Stage::new(&[("plain", "average", 0.4)]).verdict();
    assert!(plain.text.contains("0.4 from the truth at level 4; no other chain"), "{}", plain.text);
    // Level 0 alone decides nothing, and an error that is not a number is not a small one.
    let mut stage = usual();
    stage.judgement.chains.iter_mut().for_each(|c| c.levels.truncate(1));
    assert!(stage.verdict().text.contains("no level below the first"));
    let mut stage = usual();
    stage.judgement.chains[0].levels[2].lobe_error.mean = f64::NAN;
    assert_eq!((stage.verdict().matters, stage.verdict().level), (Matters::Unknown, Some(2)));
    let mut stage = usual();
    stage.judgement.chains[1].levels[4].lobe_error.mean = f64::NAN;
    assert!(stage.verdict().text.contains("'theirs'"));
}

/// The derivation of [`UNSEEN`]: lobe error d for alphas that differ by d.
#[test]
fn unseen_is_a_small_change_of_roughness() {
    let share = |r: f64, alpha: f64| r * r / (r * r + alpha * alpha);
    let differ = (1..4000).map(|i| 0.001 * f64::from(i)).map(|r| share(r, 0.25) - share(r, 0.25 * (1.0 + UNSEEN)));
    let lobe_error = 2.0 * differ.fold(0.0, f64::max);
    assert!((lobe_error / UNSEEN - 1.0).abs() < 0.05, "{lobe_error}");
    let steps = 255.0 * 0.5 * ((1.0 + UNSEEN).sqrt() - 1.0);
    assert!((steps - 3.0).abs() < 0.3, "{steps}");
}

/// Every id that something points to is there, once; tags are closed; nothing comes from outside.
fn is_sound(html: &str) {
    let values = |attribute: &str| -> Vec<String> {
        let start = format!(" {attribute}=\"");
        html.split(&start).skip(1).map(|rest| rest.split('"').next().unwrap().to_owned()).collect()
    };
    let mut ids = values("id");
    ids.sort();
    let count = ids.len();
    ids.dedup();
    assert_eq!(ids.len(), count, "an id is there twice");
    for attribute in ["for", "aria-labelledby", "aria-describedby", "aria-controls"] {
        for id in values(attribute).iter().flat_map(|list| list.split(' ')) {
            assert!(ids.iter().any(|i| i == id), "{attribute} points to {id}");
        }
    }
    for link in values("href") {
        let inside = link.strip_prefix('#').is_some_and(|id| ids.iter().any(|i| i == id));
        assert!(inside || link.starts_with("data:image/"), "link to {:.40}", link);
    }
    assert!(values("src").iter().all(|src| src.starts_with("data:image/") && src.len() > 60));
    assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("url("));
    assert!(!html.contains("NaN") && !html.contains(">inf"));
    let images = html.matches("<img ").count();
    assert_eq!(
        images,
        html.split("<img ").skip(1).filter(|tag| tag.split('>').next().unwrap().contains("alt=\"")).count()
    );

    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').expect("tags end");
        let (tag, after) = rest.split_at(end);
        let name = tag.trim_start_matches('/').split(|c: char| c.is_whitespace()).next().unwrap();
        assert!(!tag.contains('<'), "<{tag:.60}");
        rest = after;
        if tag.starts_with('!') || ["meta", "img", "input", "br"].contains(&name) {
        } else if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closed out of turn");
        } else {
            open.push(name);
            if ["style", "script"].contains(&name) {
                rest = &rest[rest.find(&format!("</{name}")).expect("closed")..];
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn page_is_sound_and_says_what_was_found() {
    let mut stage = usual();
    let apng =
        vec![137, 80, 78, 71, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24];
    let score = |chain: &str| MotionScore {
        motion: "zoom",
        chain: chain.into(),
        flip_mean: 0.061,
        flip_p95: 0.22,
        flicker: 0.83,
    };
    let scores = ["plain", "mine", "theirs"].map(score).to_vec();
    stage.motion = vec![Motion { name: "zoom", apng: apng.repeat(3), size: (200, 60), scores }];
    let html = stage.page();
    is_sound(&html);
    for text in [
        "Folding matters here: at level 4",
        "Fail: 1 of 2 chains past the limits",
        "theirs: level 4: lobe-error 0.300",
        "limit 0.2",
        "0.830",
        "mipfold compare tiles --limit 0.2",
        "perceptual roughness",
        "OpenGL (green up, +Y)",
    ] {
        assert!(html.contains(text), "{text}");
    }
    // A picture, an error map and a mip strip for each chain; plain mips have no panel of their own.
    assert_eq!(html.matches("id=\"p-").count(), 4 * 5);
    assert_eq!(html.matches("id=\"e-").count(), 3 * 5);
    assert_eq!(html.matches("id=\"ridges-").count() / 3, 2);
    assert!(html.contains(&stage.material.notes.first().map_or(String::new(), |n| n.chars().take(12).collect())));
}

#[test]
fn page_is_sensible_without_figures() {
    let mut stage = usual();
    stage.judgement.chains.iter_mut().for_each(|c| c.levels.clear());
    stage.limits.clear();
    let html = stage.page();
    is_sound(&html);
    assert!(html.contains("no level below the first was judged") && html.contains("not judged"));
    assert!(!html.contains("id=\"curves\"") && html.contains("id=\"distance\""));
    let mut alone = Stage::new(&[("mine", "projected", 0.1)]);
    alone.chains[0].levels.truncate(3);
    alone.judgement.chains[0].levels.truncate(3);
    is_sound(&alone.page());
}

#[test]
fn names_and_notes_cannot_become_markup() {
    let mut stage = usual();
    let nasty = "<script>alert(1)</script>\" onload=\"x'&";
    stage.material.name = nasty.into();
    stage.material.notes.push(nasty.into());
    stage.material.warnings.push(nasty.into());
    stage.chains[1].name = nasty.into();
    stage.judgement.chains[1].name = nasty.into();
    stage.judgement.chains[1].fold = Some(nasty.into());
    let html = page_with(&Subject { command: nasty, ..stage.subject() }, QUICK, &|_| {}).unwrap();
    assert!(!html.contains("<script>alert") && !html.contains("onload=\""));
    assert_eq!(html.matches("<script").count(), 1);
    is_sound(&html);
}

#[test]
fn progress_rises_to_one() {
    let seen = std::sync::Mutex::new(Vec::new());
    page_with(&usual().subject(), QUICK, &|share| seen.lock().unwrap().push(share)).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.is_sorted() && seen[0] == 0.0 && seen[seen.len() - 1] == 1.0, "{seen:?}");
}

#[test]
fn many_chains_and_odd_sizes_are_drawn() {
    let chains: Vec<_> = FOLDS.iter().map(|fold| (fold.name, fold.name, 0.3)).collect();
    is_sound(&Stage::new(&chains).page());
    let mut stage = usual();
    let size = Size::new(48, 20);
    let cut = |k: usize, lobes: &crate::ndf::Lobes| {
        crate::ndf::Lobes::from_fn(lobes.form(), size.level(k), |x, y| stage.chains[0].levels[0].at(x, y))
    };
    let chains: Vec<_> = stage
        .chains
        .iter()
        .map(|c| Candidate { levels: (0..size.level_count()).map(|k| cut(k, &c.levels[k])).collect(), ..c.clone() })
        .collect();
    stage.chains = chains;
    is_sound(&stage.page());
}
