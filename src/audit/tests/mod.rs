//! A sound material, and faults put into it one at a time.

use std::path::Path;

use ndarray::Array3;

use super::*;
use crate::codec::Decoded;
use crate::error::Result;
use crate::image::{Raster, Samples};
use crate::material::{ChannelRef, RoughnessInput};
use crate::random::Random;
use crate::roughness::PerceptualRoughness;

mod normals;
mod sets;

const SIDE: usize = 256;

/// Waves of a surface that tiles: cycles along u and v, phase, and amplitude in slope.
fn waves() -> Vec<[f64; 4]> {
    let mut random = Random::new(7, 1);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.uniform();
    (0..24)
        .map(|_| [uniform(-30.0, 30.0).round(), uniform(-30.0, 30.0).round(), uniform(0.0, 6.3), uniform(0.02, 0.12)])
        .collect()
}

/// Height, in texels, and slopes along u and v at a texel.
fn surface(x: usize, y: usize) -> [f64; 3] {
    let (u, v) = (x as f64 / SIDE as f64, -(y as f64) / SIDE as f64);
    waves().iter().fold([0.0; 3], |[h, p, q], [ku, kv, phase, slope]| {
        let k = ku.hypot(*kv).max(1.0);
        let (sin, cos) = (std::f64::consts::TAU * (ku * u + kv * v) + phase).sin_cos();
        let amplitude = slope * SIDE as f64 / (std::f64::consts::TAU * k);
        [h + amplitude * sin, p + slope * ku / k * cos, q + slope * kv / k * cos]
    })
}

fn byte(v: f64) -> u8 {
    (255.0 * v).round().clamp(0.0, 255.0) as u8
}

fn stored(p: f64, q: f64) -> [f64; 3] {
    let z = 1.0 / (1.0 + p * p + q * q).sqrt();
    [-p * z, -q * z, z].map(|n| 0.5 + 0.5 * n)
}

fn map8(channels: usize, texel: impl Fn(usize, usize) -> Vec<f64>) -> Raster {
    let mut samples = Array3::zeros((SIDE, SIDE, channels));
    for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
        texel(x, y).iter().enumerate().for_each(|(c, v)| samples[(y, x, c)] = byte(*v));
    }
    Raster::new(Samples::U8(samples))
}

/// The sound normal map, bent by `bend` on the way to its stored form.
fn normals(bend: impl Fn([f64; 2]) -> [f64; 2]) -> Raster {
    map8(3, |x, y| {
        let [_, p, q] = surface(x, y);
        let [p, q] = bend([p, q]);
        stored(p, q).to_vec()
    })
}

fn sound() -> Raster {
    normals(|slopes| slopes)
}

fn rough(x: usize, y: usize) -> f64 {
    0.5 + 0.1 * (surface(x, y)[0] / 4.0).tanh() + 0.2 * ((x / 32 + y / 32) % 2) as f64
}

fn heights() -> Raster {
    map8(1, |x, y| vec![0.5 + surface(x, y)[0] / 30.0])
}

/// Part of a picture, from column and row `x` and `y` on.
fn cut(raster: &Raster, (x0, y0): (usize, usize), (width, height): (usize, usize)) -> Raster {
    let Samples::U8(samples) = &raster.samples else { panic!("8 bit") };
    let part = Array3::from_shape_fn((height, width, samples.dim().2), |(y, x, c)| samples[(y0 + y, x0 + x, c)]);
    Raster::new(Samples::U8(part))
}

/// Maps by file name: the first is the normal map, those whose names hold `height` and `rough` or `gloss` the others.
struct Maps(Vec<(&'static str, Raster)>);

impl Maps {
    fn of(normal: Raster) -> Self {
        Self(vec![("normal.png", normal), ("roughness.png", map8(1, |x, y| vec![rough(x, y)]))])
    }

    fn with(mut self, name: &'static str, map: Raster) -> Self {
        self.0.retain(|(other, _)| !(other.contains("rough") && name.contains("rough")));
        self.0.push((name, map));
        self
    }

    fn inputs(&self) -> Inputs {
        let named = |word: &str| self.0.iter().find(|(name, _)| name.contains(word)).map(|(name, _)| (*name).into());
        Inputs {
            name: "set".into(),
            normal: named("normal"),
            height: named("height"),
            roughness: named("rough")
                .or(named("gloss"))
                .map_or(RoughnessInput::Missing, |path| RoughnessInput::Roughness(ChannelRef { path, channel: None })),
            ..Inputs::default()
        }
    }

    fn read(&self, path: &Path) -> Result<Decoded> {
        let (_, raster) = self.0.iter().find(|(name, _)| Path::new(name) == path).expect("a map of the set");
        Ok(Decoded {
            raster: raster.clone(),
            format: "PNG",
            notes: vec![],
            sha256: String::new(),
            bytes_len: 0,
            plain_png: None,
        })
    }

    fn audit(&self) -> Audit {
        self.audit_as(|inputs| inputs)
    }

    fn audit_as(&self, change: impl Fn(Inputs) -> Inputs) -> Audit {
        let audit = audit(&change(self.inputs()), &|path| self.read(path));
        let known = |name| name == LOAD || CHECKS.iter().any(|check| check.name == name);
        for finding in &audit.findings {
            assert!(known(finding.check), "{finding:?}");
            assert!((0.0..=1.0).contains(&finding.confidence), "{finding:?}");
            assert!(!finding.evidence.is_empty() && !finding.fix.is_empty() && !finding.map.is_empty(), "{finding:?}");
        }
        assert!(audit.findings.is_sorted_by_key(|finding| finding.severity), "{audit:?}");
        audit
    }
}

/// The finding of a check; there must be one.
fn found<'a>(audit: &'a Audit, check: &str) -> &'a Finding {
    audit.findings.iter().find(|f| f.check == check).unwrap_or_else(|| panic!("no {check} in {audit:#?}"))
}

/// There must be exactly these findings.
fn only(audit: &Audit, checks: &[&str]) {
    let names: Vec<_> = audit.findings.iter().map(|finding| finding.check).collect();
    assert_eq!(names, checks, "{audit:#?}");
}

#[test]
fn names_of_checks_differ() {
    for (i, check) in CHECKS.iter().enumerate() {
        assert!(CHECKS[..i].iter().all(|other| other.name != check.name) && check.name != LOAD, "{}", check.name);
        assert!(check.about.len() < 120, "{}", check.about);
    }
}

#[test]
fn nothing_is_found_in_a_sound_set() {
    only(&Maps::of(sound()).audit(), &[]);
    only(&Maps::of(sound()).with("height.png", heights()).audit(), &[]);
}

#[test]
fn what_cannot_be_loaded_is_an_error() {
    let gray = map8(3, |x, y| vec![rough(x, y); 3]);
    let audit = Maps::of(gray).audit();
    only(&audit, &[LOAD]);
    assert_eq!((audit.size, audit.count(Severity::Error)), (None, 1));
    assert!(audit.findings[0].map == "normal.png" && audit.findings[0].evidence.contains("gray"), "{audit:?}");
}

#[test]
fn heights_and_numbers_alone_are_audited_too() {
    let set = Maps(vec![("height.png", heights())]);
    let number = |inputs| Inputs { roughness: RoughnessInput::Constant(PerceptualRoughness(0.4)), ..inputs };
    only(&set.audit_as(number), &[]);
}
