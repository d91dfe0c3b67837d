//! The judge's findings as texts and files.

use serde_json::{Value, json};

use super::report::Report;
use crate::error::Result;
use crate::material::GENERATOR;
use crate::report::{Motion, Subject};

// Until the report room writes them: the same functions over the same subject, with less in them.

/// One sentence.
pub struct Verdict {
    pub text: String,
}

pub fn verdict(subject: &Subject) -> Verdict {
    let worst = |chain: &crate::compare::ChainScore| chain.worst_level().map(|level| level.lobe_error.mean);
    let judged = subject.judgement.chains.iter().filter_map(|chain| Some((chain, worst(chain)?)));
    let best = judged.min_by(|a, b| a.1.total_cmp(&b.1));
    let text = best.map_or_else(
        || "No level was judged.".into(),
        |(chain, error)| format!("{} is closest to the truth: lobe error {error:.3} in its worst level.", chain.name),
    );
    Verdict { text }
}

pub fn json(subject: &Subject) -> String {
    let chains = serde_json::to_value(&subject.judgement.chains).expect("plain data");
    let object: Value = json!({
        "schema": 1,
        "generator": GENERATOR,
        "version": env!("CARGO_PKG_VERSION"),
        "material": subject.material.name,
        "size": subject.judgement.size,
        "settings": subject.settings,
        "limits": subject.limits,
        "plain": subject.plain,
        "verdict": verdict(subject).text,
        "command": subject.command,
        "chains": chains,
    });
    serde_json::to_string_pretty(&object).expect("plain data") + "\n"
}

pub fn csv(subject: &Subject) -> String {
    let mut text = "chain,level,lobe_error\n".to_owned();
    for chain in &subject.judgement.chains {
        for level in &chain.levels {
            text += &format!("{},{},{}\n", chain.name, level.level, level.lobe_error.mean);
        }
    }
    text
}

pub fn page(subject: &Subject, done: &(dyn Fn(f64) + Sync)) -> Result<String> {
    done(1.0);
    Ok(format!("<!doctype html>\n<title>{}</title>\n<p>{}</p>\n", subject.material.name, verdict(subject).text))
}

// To here.

/// The moving pictures of a report.
pub fn motion(_subject: &Subject, _report: &Report) -> Result<Vec<Motion>> {
    Ok(Vec::new())
}
