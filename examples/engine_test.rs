//! What an engine's test would write: do the mips that our importer makes still look like the texture?
//!
//! `cargo run --example engine_test`
#![allow(clippy::print_stdout)]

use glam::Vec3;
use mipfold::compare::{Candidate, Limit, Settings, judge};
use mipfold::image::Size;
use mipfold::material::{Texels, base_lobes};
use mipfold::ndf::{Form, Lobe, Lobes};
use mipfold::roughness::{Alpha, PerceptualRoughness};

const SIDE: usize = 64;
const ROUGHNESS: f32 = 0.35;

/// The engine's texture: dimples in a hammered plate.
struct Plate;

fn normal(x: usize, y: usize) -> Vec3 {
    let slope = |i: usize| 0.35 * (i as f32 * 0.8).sin();
    Vec3::new(-slope(x), -slope(y), 1.0).normalize()
}

impl Texels for Plate {
    fn size(&self) -> Size {
        Size::new(SIDE, SIDE)
    }

    fn normals(&self, y: usize, x: usize, [nx, ny, nz]: [&mut [f32]; 3], usable: &mut [f32]) {
        for i in 0..usable.len() {
            [nx[i], ny[i], nz[i]] = normal(x + i, y).to_array();
            usable[i] = 1.0;
        }
    }

    fn perceptual(&self, _y: usize, _x: usize, out: &mut [f32]) {
        out.fill(ROUGHNESS);
    }
}

/// The engine's importer: 2x2 boxes of normals, and of variance added to alpha^2 if it is told to.
fn import(keep_variance: bool) -> Vec<Lobes> {
    let mut levels = vec![base_lobes(&Plate, Form::Isotropic)];
    // Mean normals, not made unit again: their length tells how far they spread.
    let mut means: Vec<Vec3> = (0..SIDE * SIDE).map(|i| normal(i % SIDE, i / SIDE)).collect();
    let mut side = SIDE;
    while side > 1 {
        let half = side / 2;
        let corner = |i: usize| i / half * 2 * side + i % half * 2;
        let box_of = |c: usize| 0.25 * (means[c] + means[c + 1] + means[c + side] + means[c + side + 1]);
        means = (0..half * half).map(|i| box_of(corner(i))).collect();
        side = half;
        levels.push(Lobes::from_fn(Form::Isotropic, Size::new(side, side), |x, y| {
            let mean = means[y * side + x];
            let spread = if keep_variance { 2.0 * (1.0 - mean.length()) / mean.length() } else { 0.0 };
            let alpha = PerceptualRoughness(ROUGHNESS).alpha();
            Lobe::isotropic(mean.normalize(), Alpha::from_squared((alpha.squared() + spread).min(1.0)))
        }));
    }
    levels
}

fn main() -> mipfold::Result<()> {
    let chains = [Candidate::new("importer", import(true)), Candidate::new("without variance", import(false))];
    let judgement = judge(&Plate, &chains, &Settings::default(), &|_| ())?;
    // In a test these would be `unwrap` and `unwrap_err`.
    for chain in &judgement.chains {
        match chain.keeps(&[Limit::lobe_error(0.6)]) {
            Ok(()) => println!("{}: within 0.6 lobe error at every level", chain.name),
            Err(breach) => println!("{breach}"),
        }
    }
    Ok(())
}
