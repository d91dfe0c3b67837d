//! A surface of its own, from no file at all: ripples on a smooth metal, folded by every method.
//!
//! `cargo run --example own_texels`
#![allow(clippy::print_stdout)]

use mipfold::fold::{FOLDS, Options, chain};
use mipfold::image::Size;
use mipfold::material::Texels;

/// Height `sin(k u) / k * STEEP`: the slope along u is `STEEP cos(k u)`, and its variance half of STEEP squared.
struct Ripples;

const SIDE: usize = 256;
const STEEP: f32 = 0.4;
/// Texels from crest to crest.
const WAVE: f32 = 16.0;

impl Texels for Ripples {
    fn size(&self) -> Size {
        Size::new(SIDE, SIDE)
    }

    fn normals(&self, _y: usize, x: usize, [nx, ny, nz]: [&mut [f32]; 3], usable: &mut [f32]) {
        for i in 0..usable.len() {
            let slope = STEEP * ((x + i) as f32 * std::f32::consts::TAU / WAVE).cos();
            let z = 1.0 / (1.0 + slope * slope).sqrt();
            (nx[i], ny[i], nz[i], usable[i]) = (-slope * z, 0.0, z, 1.0);
        }
    }

    fn perceptual(&self, _y: usize, _x: usize, out: &mut [f32]) {
        out.fill(0.3);
    }
}

fn main() {
    println!("alpha in the middle of each level, from 128x128 to 1x1");
    for fold in FOLDS {
        let folded = chain(&Ripples, &Options { fold, ..Options::default() });
        let middles = folded.levels.iter().map(|level| {
            let size = level.lobes.size();
            let lobe = level.lobes.at(size.width / 2, size.height / 2);
            format!("{:.3}", lobe.axes().alpha_x.0)
        });
        println!("{:<18} {}", fold.name, middles.collect::<Vec<_>>().join("  "));
    }
}
