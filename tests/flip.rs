//! Our FLIP is that of its authors.

#![allow(clippy::print_stderr)]

mod common;

use mipfold::compare::flip;
use mipfold::ndf::{Form, Lobe, Lobes};
use mipfold::render::{Sampling, Scene, display, render};
use mipfold::roughness::Alpha;
use mipfold::sample::by_name;
use ndarray::Array3;

fn noise(rows: usize, columns: usize, seed: usize, around: f32, width: f32) -> Array3<f32> {
    Array3::from_shape_fn((rows, columns, 3), |(y, x, c)| {
        let hash = ((seed + 97 * y + 1009 * x + 31 * c) as u32).wrapping_mul(2_654_435_761);
        (around + width * ((hash >> 8) as f32 / (1u32 << 24) as f32 - 0.5)).clamp(0.0, 1.0)
    })
}

/// A rendered ball, its lobes widened by a factor.
fn ball(widened: f32) -> Array3<f32> {
    let maps = (by_name("woven-cloth").unwrap().make)(128, 1);
    let level = Lobes::from_fn(Form::Isotropic, maps.normal.size(), |x, y| {
        let n = [0, 1, 2].map(|c| 2.0 * maps.normal.at(x, y, c) - 1.0);
        Lobe::isotropic(glam::Vec3::from_array(n).normalize(), Alpha(widened * maps.orm.at(x, y, 1).powi(2)))
    });
    let scene = Scene::outdoor();
    display(&render(&scene, &[level], 72, Sampling::Supersampled { per_side: 2 }), scene.exposure)
}

/// Mean and largest difference between the two programs' maps stay below 3e-5 and 2e-4, all in f32 here.
#[test]
fn agrees_with_its_authors_program() {
    let Some(python) = common::python_with(&["flip_evaluator", "numpy"]) else { return };
    let plain = |v: f32| Array3::from_elem((16, 20, 3), v);
    let stripes = |phase: usize| {
        Array3::from_shape_fn((33, 47, 3), |(y, x, c)| if (x + phase + y / 3) % 8 < 4 { 0.9 } else { 0.1 * c as f32 })
    };
    let pairs = [
        ("black and white", plain(0.0), plain(1.0)),
        ("unlike noise", noise(40, 31, 1, 0.5, 1.0), noise(40, 31, 2, 0.5, 1.0)),
        ("faint noise", noise(40, 31, 3, 0.4, 0.1), noise(40, 31, 4, 0.42, 0.1)),
        ("moved stripes", stripes(0), stripes(1)),
        ("two balls", ball(1.0), ball(1.6)),
        ("one ball", ball(1.0), ball(1.0)),
    ];
    for (name, reference, test) in &pairs {
        for pixels_per_degree in [67.0, 30.0] {
            let ours = flip(reference, test, pixels_per_degree);
            let theirs = theirs(&python, reference, test, pixels_per_degree);
            assert_eq!(ours.len(), theirs.len());
            let differences: Vec<f64> = ours.iter().zip(&theirs).map(|(a, b)| f64::from((a - b).abs())).collect();
            let largest = differences.iter().copied().fold(0.0, f64::max);
            let mean = differences.iter().sum::<f64>() / differences.len() as f64;
            let level = theirs.iter().sum::<f32>() / theirs.len() as f32;
            eprintln!(
                "{name}, {pixels_per_degree}: mean FLIP {level:.4}, differences: mean {mean:.1e}, most {largest:.1e}"
            );
            assert!(mean < 3e-5 && largest < 2e-4, "{name}, {pixels_per_degree}: {mean} {largest}");
            assert_eq!(level == 0.0, *name == "one ball");
        }
    }
}

fn theirs(python: &std::path::Path, reference: &Array3<f32>, test: &Array3<f32>, pixels_per_degree: f32) -> Vec<f32> {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let floats = |name: &str, image: &Array3<f32>| {
        let bytes: Vec<u8> = image.iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(at(name), bytes).unwrap();
    };
    floats("reference.f32", reference);
    floats("test.f32", test);
    let (rows, columns, _) = reference.dim();
    std::fs::write(at("shape.json"), format!("[{rows}, {columns}, {pixels_per_degree}]")).unwrap();
    let paths = ["reference.f32", "test.f32", "out.f32", "shape.json"].map(at);
    common::script(python, "flip.py", &paths.each_ref().map(|path| path.as_path()));
    let bytes = std::fs::read(at("out.f32")).unwrap();
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}
