//! Scores as tables and curves of the page.

use super::plot::{Chart, LimitLine, Line, Style, draw};
use super::verdict::{decisive, short, worst};
use super::{Subject, passes};
use crate::compare::{ChainScore, LevelScore};

/// How the chains stand against the limits.
pub(super) struct Status {
    pub title: String,
    /// The furthest first.
    pub breaches: Vec<String>,
    /// Breaches that are not listed.
    pub more: usize,
}

/// Breaches that are listed on the page; JSON has all of them.
const LISTED: usize = 6;

/// Every chain but plain mips, which is there for comparison.
fn asked<'a>(subject: &'a Subject) -> impl Iterator<Item = &'a ChainScore> {
    let chains = subject.judgement.chains.iter().enumerate();
    chains.filter(|(i, _)| Some(*i) != subject.plain).map(|(_, chain)| chain)
}

pub(super) fn status(subject: &Subject) -> Status {
    let mut breaches: Vec<_> = asked(subject).flat_map(|chain| chain.breaches(subject.limits)).collect();
    breaches.sort_by(|a, b| (b.mean - b.limit.most).total_cmp(&(a.mean - a.limit.most)));
    let count = asked(subject).count();
    let failing = asked(subject).filter(|chain| !chain.breaches(subject.limits).is_empty()).count();
    let title = if subject.limits.is_empty() {
        "No limits were set".into()
    } else if asked(subject).all(|chain| chain.levels.is_empty()) {
        "Limits were set, but nothing was judged".into()
    } else if passes(subject) {
        if count == 1 { "Pass: every limit is kept".into() } else { "Pass: every chain keeps every limit".into() }
    } else if count == 1 {
        "Fail: past the limits".into()
    } else {
        format!("Fail: {failing} of {count} chains past the limits")
    };
    let more = breaches.len().saturating_sub(LISTED);
    Status { title, breaches: breaches.iter().take(LISTED).map(ToString::to_string).collect(), more }
}

/// A line of the table that comes first.
pub(super) struct SummaryRow {
    pub swatch: String,
    pub name: String,
    pub fold: String,
    pub level: String,
    pub error: String,
    /// Of the largest error in the table, percent.
    pub share: f64,
    pub mean: String,
    /// Lobe error of level 0, which should be 0.
    pub first: String,
    pub limits: String,
    /// "pass", "fail" or "none".
    pub mark: &'static str,
}

pub(super) fn summary(subject: &Subject) -> Vec<SummaryRow> {
    let chains = &subject.judgement.chains;
    let most =
        chains.iter().filter_map(|c| Some(worst(c)?.lobe_error.mean)).filter(|e| e.is_finite()).fold(0.0, f64::max);
    let styles = styles(subject);
    let row = |(i, chain): (usize, &ChainScore)| {
        let worst = worst(chain);
        let error = worst.map_or(0.0, |level| level.lobe_error.mean);
        let breaches = chain.breaches(subject.limits).len();
        let errors: Vec<f64> = decisive(chain).map(|level| level.lobe_error.mean).collect();
        let (limits, mark) = if Some(i) == subject.plain {
            ("for comparison".into(), "none")
        } else if subject.limits.is_empty() || chain.levels.is_empty() {
            ("none".into(), "none")
        } else if breaches == 0 {
            ("\u{2713} pass".into(), "pass")
        } else {
            (format!("\u{2717} fail, {breaches} {}", if breaches == 1 { "place" } else { "places" }), "fail")
        };
        SummaryRow {
            swatch: styles[i].swatch(),
            name: chain.name.clone(),
            fold: match (&chain.fold, chain.count) {
                (Some(fold), _) => fold.clone(),
                (None, 1) => "not known".into(),
                (None, count) => format!("not known, {count} lobes"),
            },
            level: worst.map_or("none".into(), |level| level.level.to_string()),
            error: worst.map_or("not judged".into(), |l| with_error(l.lobe_error.mean, l.lobe_error.stderr)),
            share: if error.is_finite() && most > 0.0 { (1000.0 * error / most).round() / 10.0 } else { 0.0 },
            mean: if errors.is_empty() {
                "none".into()
            } else {
                with_error(errors.iter().sum::<f64>() / errors.len() as f64, 0.0)
            },
            first: first(chain).map_or("not judged".into(), |l| with_error(l.lobe_error.mean, l.lobe_error.stderr)),
            limits,
            mark,
        }
    };
    chains.iter().enumerate().map(row).collect()
}

fn first(chain: &ChainScore) -> Option<&LevelScore> {
    chain.levels.iter().find(|level| level.level == 0)
}

/// Whether level 0 of some chain is not the input itself.
pub(super) fn any_first(subject: &Subject) -> bool {
    subject.judgement.chains.iter().filter_map(first).any(|level| level.lobe_error.mean != 0.0)
}

/// "0.62 ± 0.01": with one standard error, as on the command line, which gets the digits it needs.
fn with_error(mean: f64, stderr: f64) -> String {
    let coarse = mean.abs() >= 0.0995 && !(stderr > 0.0 && stderr < 0.005);
    with_decimals(mean, stderr, if coarse { 2 } else { 3 })
}

fn with_decimals(mean: f64, stderr: f64, decimals: usize) -> String {
    if mean.is_nan() {
        "n/a".into()
    } else if stderr > 0.0 && stderr.is_finite() {
        format!("{mean:.decimals$} \u{b1} {stderr:.decimals$}")
    } else {
        format!("{mean:.decimals$}")
    }
}

fn styles(subject: &Subject) -> Vec<Style> {
    let mut next = 0;
    let style = |i| {
        if Some(i) == subject.plain {
            Style::PLAIN
        } else {
            next += 1;
            Style::chain(next - 1)
        }
    };
    (0..subject.judgement.chains.len()).map(style).collect()
}

/// A figure of a level: mean and standard error.
type Read = fn(&LevelScore) -> (f64, f64);

/// Columns of the table of figures.
pub(super) const COLUMNS: &[(&str, Read)] = &[
    ("Lobe error", |l| (l.lobe_error.mean, l.lobe_error.stderr)),
    ("p95", |l| (l.lobe_error.p95, 0.0)),
    ("Light error", |l| (l.lobe_error_light.mean, l.lobe_error_light.stderr)),
    ("NDF distance", |l| (l.ndf_tv.mean, l.ndf_tv.stderr)),
    ("Hellinger", |l| (l.ndf_hellinger.mean, l.ndf_hellinger.stderr)),
    ("KL", |l| (l.ndf_kl.mean, l.ndf_kl.stderr)),
    ("Energy", |l| (l.energy.mean, l.energy.stderr)),
    ("Compensated", |l| (l.energy.compensated, 0.0)),
    ("Diffuse error", |l| (l.diffuse_error.mean, l.diffuse_error.stderr)),
];

/// The table of figures of one chain.
pub(super) struct Numbers {
    pub name: String,
    pub rows: Vec<NumbersRow>,
}

pub(super) struct NumbersRow {
    pub level: usize,
    pub size: String,
    pub samples: usize,
    pub figures: Vec<String>,
}

pub(super) fn numbers(subject: &Subject) -> Vec<Numbers> {
    let row = |level: &LevelScore| NumbersRow {
        level: level.level,
        size: format!("{}x{}", level.width, level.height),
        samples: level.samples,
        figures: COLUMNS
            .iter()
            .map(|(_, read)| read(level))
            .map(|(mean, stderr)| with_decimals(mean, stderr, 3))
            .collect(),
    };
    let chain = |c: &ChainScore| Numbers { name: c.name.clone(), rows: c.levels.iter().map(row).collect() };
    subject.judgement.chains.iter().map(chain).collect()
}

/// A drawn chart.
pub(super) struct ChartView {
    pub title: &'static str,
    pub svg: String,
}

/// What is drawn: id, title, metric (as limits name it), figure, whether 1 is right.
const CHARTS: [(&str, &str, &str, Read, bool); 4] = [
    ("chart-lobe", "Lobe error by level", "lobe-error", |l| (l.lobe_error.mean, l.lobe_error.stderr), false),
    ("chart-ndf", "NDF distance", "ndf-tv", |l| (l.ndf_tv.mean, l.ndf_tv.stderr), false),
    ("chart-energy", "Energy, 1 is right", "energy", |l| (l.energy.mean, l.energy.stderr), true),
    ("chart-diffuse", "Diffuse error", "diffuse-error", |l| (l.diffuse_error.mean, l.diffuse_error.stderr), false),
];

/// The headline first, large; nothing if nothing was judged.
pub(super) fn charts(subject: &Subject) -> Vec<ChartView> {
    let chains = &subject.judgement.chains;
    if chains.iter().all(|chain| chain.levels.is_empty()) {
        return Vec::new();
    }
    let styles = styles(subject);
    let draw_one = |(i, (id, title, metric, read, ratio)): (usize, (&str, &'static str, &str, Read, bool))| {
        let line = |(chain, style): (&ChainScore, &Style)| {
            let point = |level: &LevelScore| {
                let (mean, stderr) = read(level);
                (level.level, mean, stderr)
            };
            Line { name: chain.name.clone(), style: *style, points: chain.levels.iter().map(point).collect() }
        };
        let lines: Vec<Line> = chains.iter().zip(&styles).map(line).collect();
        let limits: Vec<LimitLine> = subject
            .limits
            .iter()
            .filter(|limit| limit.metric.name == metric)
            .flat_map(|limit| {
                let (first, last) = limit.levels.as_ref().map_or((0, usize::MAX), |l| (*l.start(), *l.end()));
                // A limit of the distance from 1 lies on both sides of it.
                let at = if ratio { vec![1.0 - limit.most, 1.0 + limit.most] } else { vec![limit.most] };
                at.into_iter().map(move |at| (first, last, at, limit.most))
            })
            .collect();
        let size = if i == 0 { (1080.0, 380.0) } else { (340.0, 220.0) };
        let description = describe(&lines);
        let chart =
            Chart { id, title, description: &description, lines: &lines, limits: &limits, ratio, size, named: i == 0 };
        ChartView { title, svg: draw(&chart) }
    };
    CHARTS.into_iter().enumerate().map(draw_one).collect()
}

/// The range of every curve, for those who cannot see them.
fn describe(lines: &[Line]) -> String {
    let of = |line: &Line| {
        let figures = || line.points.iter().map(|p| p.1).filter(|v| v.is_finite());
        let (low, high) = (figures().fold(f64::MAX, f64::min), figures().fold(f64::MIN, f64::max));
        if low > high {
            format!("{}: none", line.name)
        } else {
            format!("{}: {} to {}", line.name, short(low), short(high))
        }
    };
    format!(
        "Curves over mip levels. {}. All figures are in the table below.",
        lines.iter().map(of).collect::<Vec<_>>().join("; ")
    )
}
