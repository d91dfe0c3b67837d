//! A surface of its own, from no file at all: ripples on a smooth metal, folded by every method.
//!
//! `cargo run --example own_texels`
//!
//! And what light finds on a map's own texels, from close up to far away, as a picture:
//!
//! `cargo run --example own_texels -- wall_normal.png wall_close_to_far.png`, or `scratched-metal` for a file (any sample's
//! name), and `y-down` at the end for a normal map made for DirectX.
#![allow(clippy::print_stdout)]

use glam::{DMat2, DVec2, DVec3};
use mipfold::codec::{read, write_png};
use mipfold::fold::{FOLDS, Options, chain};
use mipfold::glint::texels::{AlphaSource, TexelGlints, TexelWidth, Transition};
use mipfold::image::{Raster, Samples, Size};
use mipfold::material::Texels;
use mipfold::roughness::Alpha;
use ndarray::Array3;
use rayon::prelude::*;

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

fn main() -> mipfold::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (map, out, down) = match &arguments[..] {
        [] => {
            ripples();
            return Ok(());
        }
        [map, out] => (map, out, false),
        [map, out, down] if down == "y-down" => (map, out, true),
        _ => {
            println!("usage: own_texels [NORMAL OUT.png [y-down]]");
            return Ok(());
        }
    };
    let raster = match mipfold::sample::by_name(map) {
        Some(sample) => (sample.make)(1024, 1).normal,
        None => read(map.as_ref())?.raster,
    };
    if raster.channels.len() < 3 {
        let found = format!("channels {}", raster.channels.join(", "));
        return Err(mipfold::Error::invalid(map.as_ref(), found, "a normal map: red, green and blue"));
    }
    let Size { width, height } = raster.size();
    let normals = Array3::from_shape_fn((height, width, 3), |(y, x, c)| {
        // 8 bit: 128 is flat, not 127.5.
        let v = if c < 2 && raster.bits() == 8 {
            (raster.at(x, y, c) * 255.0 - 128.0) / 127.0
        } else {
            2.0 * raster.at(x, y, c) - 1.0
        };
        if c == 1 && down { -v } else { v }
    });
    let glints =
        TexelGlints::new(&normals, AlphaSource::Constant(Alpha(ALPHA as f32))).expect("a map of three channels");
    let picture = close_to_far(&glints);
    let file = std::fs::File::create(out).map_err(|error| mipfold::Error::io(out.as_ref(), error))?;
    write_png(file, &Raster::new(Samples::U8(picture))).map_err(|error| mipfold::Error::io(out.as_ref(), error))
}

const ALPHA: f64 = 0.05;
const WIDE: usize = 720;
const HIGH: usize = 110;
/// Rows between strips.
const GAP: usize = 6;
/// Texels under a pixel at the left, and how many times as many at the right.
const NEAREST: f64 = 0.25;
const OCTAVES: f64 = 8.0;

/// GGX of slopes about a mean, wider by twice a covariance (LEAN).
fn folded(mean: DVec2, [xx, xy, yy]: [f64; 3], h: DVec3) -> f64 {
    let a = [ALPHA * ALPHA + 2.0 * xx, 2.0 * xy, ALPHA * ALPHA + 2.0 * yy];
    let (d, det) = (-h.truncate() / h.z - mean, a[0] * a[2] - a[1] * a[1]);
    let d2 = (a[2] * d.x * d.x - 2.0 * a[1] * d.x * d.y + a[0] * d.y * d.y) / det;
    1.0 / (std::f64::consts::PI * det.sqrt() * (1.0 + d2).powi(2) * h.z.powi(4))
}

/// Three strips, each column further away than the one on its left: shaded by the normal in the middle of a pixel, by all
/// normals under it, and by the folded lobe. The light's mirror image lies along the middle of each.
fn close_to_far(glints: &TexelGlints) -> Array3<u8> {
    let top = glints.pyramid().levels().last().expect("a level").blocks()[0];
    let (mean, cov) = (top.mean.as_dvec2(), top.cov.map(f64::from));
    let far = |h: DVec3| folded(mean, cov, h);
    let transition = Transition { from: TexelWidth(8.0), to: TexelWidth(32.0) };
    let (columns, rows) = glints.slopes().size();
    let size = DVec2::new(columns as f64, rows as f64);
    let reach = 2.5 * (ALPHA * ALPHA + cov[0] + cov[2]).sqrt();
    let column = |x: usize| -> Vec<[f64; 3]> {
        let at = |x: f64| NEAREST * (OCTAVES * x / WIDE as f64).exp2();
        // Columns follow each other without gaps: the sum of the widths before.
        let before = (at(x as f64) - NEAREST) / (OCTAVES / WIDE as f64 * std::f64::consts::LN_2);
        let width = at(x as f64);
        let one = |y: usize| {
            let t = (y as f64 + 0.5) / HIGH as f64 - 0.5;
            let texel = DVec2::new(before, t * HIGH as f64 * width) + 0.5 * size;
            let (uv, jacobian) = (texel / size, DMat2::from_diagonal(width / size));
            let slope = mean + DVec2::new(0.0, 2.0 * reach * t);
            let h = DVec3::new(-slope.x, -slope.y, 1.0).normalize();
            let middle = glints.slopes().at(DVec2::new(texel.x, size.y - texel.y) - 0.5).0;
            [folded(middle, [0.0; 3], h), glints.blended((uv, jacobian), h, transition, far), far(h)]
        };
        (0..HIGH).map(one).collect()
    };
    let columns: Vec<_> = (0..WIDE).into_par_iter().map(column).collect();
    let exposure = 1.5 / far(DVec3::new(-mean.x, -mean.y, 1.0).normalize());
    Array3::from_shape_fn((3 * HIGH + 2 * GAP, WIDE, 3), |(y, x, c)| {
        let (strip, y) = (y / (HIGH + GAP), y % (HIGH + GAP));
        let tint = [1.0, 0.9, 0.76][c];
        let light = if y < HIGH { 1.0 - (-columns[x][y][strip] * exposure * tint).exp() } else { 1.0 };
        (255.0 * light.powf(1.0 / 2.2)).round() as u8
    })
}

fn ripples() {
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
