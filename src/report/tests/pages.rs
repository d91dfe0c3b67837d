//! The page: sound, escaped, and sensible with little to show.

use super::super::page::page_with;
use super::super::{Candidate, ChainAbout, Motion, MotionScore, Subject};
use super::{LEVELS, QUICK, Stage, csv, records, usual};
use crate::fold::FOLDS;
use crate::image::Size;
use crate::ndf::{Form, Lobes};

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
    // Pictures as text may spell anything.
    let text: String =
        html.split(";base64,").map(|part| part.split_once('"').map_or(part, |(_, after)| after)).collect();
    assert!(!text.contains("NaN") && !text.contains(">inf"));
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
    stage.motion =
        vec![Motion { name: "zoom", apng: apng.repeat(3), shown: vec!["one".into()], size: (200, 60), scores }];
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
    let notes = &stage.material.notes;
    assert!(!notes.is_empty() && notes.iter().all(|note| html.contains(note.split('\'').next().unwrap())), "{notes:?}");
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
fn page_names_what_was_judged() {
    let mut stage = usual();
    let shared = stage.material.notes[0].clone();
    stage.about = vec![
        ChainAbout { source: "out".into(), container: Some("exr"), notes: vec![shared.clone()], warnings: Vec::new() },
        ChainAbout {
            source: "normal=<n>_%d.png".into(),
            container: None,
            notes: vec!["sides are as told".into()],
            warnings: vec!["looks odd".into()],
        },
    ];
    let (before, html) = (usual().page(), stage.page());
    is_sound(&html);
    for text in ["out (exr)", "normal=&#60;n&#62;_%d.png", "sides are as told", "Probably wrong in mine", "looks odd"] {
        assert!(html.contains(text) && !before.contains(text), "{text}");
    }
    assert_eq!(html.matches(shared.as_str()).count(), before.matches(shared.as_str()).count());
    stage.settings.texels = None;
    assert!(!html.contains("<dd>all</dd></div>\n    <div><dt>Directions"));
    assert!(stage.page().contains("<dd>all</dd></div>\n    <div><dt>Directions"));
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
    let cut = |k: usize, lobes: &Lobes| {
        Lobes::from_fn(lobes.form(), size.level(k), |x, y| stage.chains[0].levels[0].at(x, y))
    };
    let chains: Vec<_> = stage
        .chains
        .iter()
        .map(|c| Candidate { levels: (0..size.level_count()).map(|k| cut(k, &c.levels[k])).collect(), ..c.clone() })
        .collect();
    stage.chains = chains;
    is_sound(&stage.page());
}

/// Every picture of a chain of several lobes is drawn, and says so.
#[test]
fn mixtures_are_drawn() {
    let mut stage = usual();
    for level in &mut stage.chains[1].levels[1..] {
        let size = level.size();
        *level = Lobes::mixed_from_fn(Form::Isotropic, 2, size, |j, x, y| (level.at(x, y), [0.75, 0.25][j]));
    }
    (stage.judgement.chains[1].count, stage.judgement.chains[1].fold) = (2, None);
    let page = stage.page();
    assert!(page.contains("not known, 2 lobes"));
    assert!(page.contains("(75 %), ") && page.contains("(25 %)"));
    let records = records(&csv(&stage.subject()));
    let column = records[0].iter().position(|name| name == "count").unwrap();
    assert_eq!((records[1][column].as_str(), records[1 + LEVELS][column].as_str()), ("1", "2"));
}
