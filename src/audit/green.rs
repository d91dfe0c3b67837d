//! Whether red and green are the slopes that they are read as.

use super::curl::{Curl, READINGS, Reading};
use super::relief::Relief;
use super::{Check, Finding, Normals, Severity, Subject};
use crate::material::{NormalY, named_normal_y};

/// Conventions.
pub const CHECK: Check = Check {
    name: "green",
    about: "a green channel that points the other way, or red and green swapped: by curl, heights and name",
    run,
};

/// Energy of the curl under another reading, over that as it is, below which the other one is likelier. Of 26 real maps whose
/// convention is known otherwise, none that is read rightly comes below 1.1; turned round, all come below 0.72 but two atlases of
/// mostly flat parts (0.80 and 0.90).
const LIKELIER: f64 = 0.8;

/// Standard errors by which the energies must differ.
const ERRORS: f64 = 4.0;

/// Share of the texels that must change by more than rounding.
const LIVE: f64 = 0.005;

/// Correlation of slopes with the gradient of the heights from which these have a say.
const RELATED: f64 = 0.25;

/// What one witness says, and how surely.
struct Verdict {
    reading: Reading,
    confidence: f64,
    evidence: String,
}

fn run(subject: &Subject) -> Vec<Finding> {
    let Some(normals) = subject.normals() else { return vec![] };
    let relief = subject.height.as_ref().and_then(|height| Relief::of(&normals, height));
    let mut findings = Vec::new();
    let curl = by_curl(&normals);
    let heights = relief.as_ref().and_then(by_heights);
    findings.extend(convention(subject, &normals, curl, heights));
    if let (Some(relief), Some(height)) = (&relief, &subject.height)
        && relief.u < -RELATED
        && relief.v < -RELATED
    {
        findings.push(Finding {
            check: CHECK.name,
            severity: Severity::Note,
            map: height.file.clone(),
            channel: None,
            evidence: format!(
                "slopes go against the heights both ways (correlation {:+.2} along u, {:+.2} along v): white is deep, or \
                 bumps are dents",
                relief.u, relief.v
            ),
            confidence: 0.8,
            fix: "invert the height map where heights are used; if the bumps look pressed in, flip red and green of the \
                  normal map instead"
                .into(),
        });
    }
    findings
}

/// The likeliest reading, if it is much likelier than the other that is asked about: as it is, or green flipped if it is as
/// it is.
fn by_curl(normals: &Normals) -> Option<Verdict> {
    let curl = Curl::of(normals);
    if curl.live < LIVE {
        return None;
    }
    let best = (0..4).min_by(|a, b| curl.energies[*a].total_cmp(&curl.energies[*b])).expect("four");
    // Errors are those of differences from the reading as it is.
    let (other, error) = if best == 0 { (1, curl.errors[1]) } else { (0, curl.errors[best]) };
    let ratio = curl.energies[best] / curl.energies[other].max(f64::MIN_POSITIVE);
    let errors = (curl.energies[other] - curl.energies[best]) / error.max(f64::MIN_POSITIVE);
    let evidence = format!(
        "the curl of the slopes has {:.2} of the energy of their derivatives as read, {:.2} {}",
        curl.energies[0],
        curl.energies[best.max(other)],
        words(READINGS[best.max(other)])
    );
    (ratio < LIKELIER && errors > ERRORS).then(|| Verdict {
        reading: READINGS[best],
        confidence: (1.0 - 0.5 * ratio).clamp(0.5, 0.98),
        evidence,
    })
}

fn by_heights(relief: &Relief) -> Option<Verdict> {
    let straight = relief.u.abs().min(relief.v.abs());
    let crossed = relief.u_with_v.abs().min(relief.v_with_u.abs());
    let swapped = crossed > RELATED && crossed > 2.0 * straight;
    if !swapped && straight < RELATED {
        return None;
    }
    let [u, v] = if swapped { [relief.u_with_v, relief.v_with_u] } else { [relief.u, relief.v] };
    let reading = match (swapped, u * v > 0.0) {
        (false, true) => Reading::AsRead,
        (false, false) => Reading::Flipped,
        (true, true) => Reading::Swapped,
        (true, false) => Reading::Turned,
    };
    let across = if swapped { ", each with the other axis" } else { "" };
    Some(Verdict {
        reading,
        confidence: (0.6 + 0.5 * u.abs().min(v.abs())).min(0.98),
        evidence: format!("slopes go with the heights by {u:+.2} along u and {v:+.2} along v{across}"),
    })
}

fn words(reading: Reading) -> &'static str {
    match reading {
        Reading::AsRead => "as read",
        Reading::Flipped => "with green the other way",
        Reading::Swapped => "with red and green swapped",
        Reading::Turned => "with red and green swapped and one of them turned",
    }
}

fn convention(
    subject: &Subject,
    normals: &Normals,
    curl: Option<Verdict>,
    heights: Option<Verdict>,
) -> Option<Finding> {
    let named = subject.inputs.normal.as_deref().and_then(named_normal_y).filter(|named| *named != normals.y);
    let as_read = |verdict: &Verdict| verdict.reading == Reading::AsRead;
    // A height map beside the normals knows better than their curl.
    let by_heights = heights.as_ref().is_some_and(as_read);
    let confirmed = by_heights || (heights.is_none() && curl.as_ref().is_some_and(as_read));
    // What the curl says against the heights is said too.
    let against = match (&curl, &heights) {
        (Some(curl), Some(heights)) if !as_read(heights) && curl.reading != heights.reading => {
            Some(curl.evidence.clone())
        }
        _ => None,
    };
    let curl = curl.filter(|curl| !by_heights && !as_read(curl) && against.is_none());
    let heights = heights.filter(|heights| !as_read(heights));
    let reading = heights.as_ref().or(curl.as_ref()).map(|v| v.reading).or(named.map(|_| Reading::Flipped))?;
    let agree = [&curl, &heights].iter().filter(|v| v.as_ref().is_some_and(|v| v.reading == reading)).count()
        + usize::from(named.is_some() && reading == Reading::Flipped);
    let doubt = [&curl, &heights].into_iter().flatten().filter(|v| v.reading == reading);
    // Names are wrong at times; the slopes are not.
    let name_doubt = match named {
        Some(_) if confirmed => 0.7,
        Some(_) if reading == Reading::Flipped => 0.2,
        _ => 1.0,
    };
    let doubt = doubt.fold(name_doubt, |doubt, verdict| doubt * (1.0 - verdict.confidence));
    let mut evidence: Vec<String> =
        [&curl, &heights].into_iter().flatten().map(|verdict| verdict.evidence.clone()).collect();
    evidence.extend(against.iter().map(|against| format!("but {against}")));
    evidence.extend(named.map(|named| {
        let but = if confirmed { ", but its slopes agree with how it is read" } else { "" };
        format!("the file's name says {}{but}", named.describe())
    }));
    let other = match normals.y {
        NormalY::OpenGl => NormalY::DirectX,
        NormalY::DirectX => NormalY::OpenGl,
    };
    let fix = match reading {
        Reading::Flipped if confirmed => "look which way it is, and rename the file if the name is wrong".to_owned(),
        Reading::Flipped => {
            let option = if other == NormalY::DirectX { "directx" } else { "opengl" };
            format!("read it with --normal-y {option}, or invert green (or red, if that one is wrong)")
        }
        Reading::Swapped | Reading::Turned => {
            "exchange red and green (and look which way each points), or turn the bake by 90 degrees".to_owned()
        }
        Reading::AsRead => unreachable!("filtered"),
    };
    Some(Finding {
        check: CHECK.name,
        // Two witnesses that do not know of each other.
        severity: if agree >= 2 && against.is_none() { Severity::Error } else { Severity::Warning },
        map: normals.picture.file.clone(),
        channel: Some(if reading == Reading::Flipped { "green" } else { "red green" }),
        evidence: format!("read as {}; {}", normals.y.describe(), evidence.join("; ")),
        confidence: if against.is_some() { 0.5 } else { (1.0 - doubt).min(0.99) },
        fix,
    })
}
