//! Is geometric filtering right? Curved metal with one sample a pixel, filtered, beside 1024 samples a pixel.
//!
//! `cargo test --test geometry -- --ignored --nocapture` prints the tables; real meshes are those of `MIPFOLD_MESHES`.

#[path = "geometry/measure.rs"]
mod measure;
#[path = "geometry/methods.rs"]
mod methods;
#[path = "geometry/peaks.rs"]
mod peaks;
#[path = "geometry/sequence.rs"]
mod sequence;
#[path = "geometry/shapes.rs"]
mod shapes;
#[path = "geometry/textured.rs"]
mod textured;

use measure::{Figures, exposure, figures};
use methods::{Known, METHODS, Method, lobe};
use sequence::{Sequence, steps};
use shapes::Object;
use textured::{Bumps, Bumpy, WAYS, Way};

const ALPHAS: [f64; 3] = [0.05, 0.1, 0.2];

/// By alpha, then by method; nothing for a method that the object lacks maps for.
fn measured(object: &Object, frames: usize, methods: &[Method]) -> Vec<Vec<Option<Figures>>> {
    let sequence = Sequence::metal(object, &steps(frames), &ALPHAS);
    let by_alpha = |(alpha, truth): (f64, &Vec<_>)| {
        let exposure = exposure(truth);
        let row = |method: &Method| {
            if method.needs_uvs && object.baked.is_none() {
                return None;
            }
            let frames = sequence.draw(&|f, light| lobe((method.tensor)(&Known::new(object, f, light, alpha))));
            Some(figures(&frames, truth, &sequence.mask, exposure))
        };
        methods.iter().map(row).collect()
    };
    ALPHAS.into_iter().zip(&sequence.truth).map(by_alpha).collect()
}

#[test]
#[ignore = "prints"]
#[expect(clippy::print_stdout)]
fn table_of_methods() {
    let objects: Vec<_> = shapes::solids().into_iter().chain(shapes::meshes()).collect();
    for object in &objects {
        let start = std::time::Instant::now();
        let found = measured(object, 8, METHODS);
        println!("{} ({} px, {:.1} s)", object.name, object.pixels, start.elapsed().as_secs_f64());
        for (alpha, row) in ALPHAS.iter().zip(&found) {
            for (method, figures) in METHODS.iter().zip(row) {
                let Some(f) = figures else { continue };
                println!(
                    "  {alpha:5} {:28} error {:6.3} shown {:6.4} flicker {:6.3} motion {:6.3} energy {:6.3}",
                    method.name, f.error, f.shown, f.flicker, f.motion, f.energy
                );
            }
        }
    }
}

/// By way; nothing for an object that has no bumps.
fn measured_bumps(object: &Object, frames: usize, alpha: f64, ways: &[Way]) -> Option<Vec<Figures>> {
    let (sample, repeats) = textured::on(object)?;
    let bumps = Bumps::new(sample, 128, alpha, repeats);
    let sequence = Sequence::new(object, &steps(frames), &[&|p| bumps.base(p)]);
    let truth = &sequence.truth[0];
    let exposure = exposure(truth);
    let row = |way: &Way| {
        let frames = sequence.draw(&|f, light| (way.lobe)(&Bumpy::new(Known::new(object, f, light, alpha), &bumps)));
        figures(&frames, truth, &sequence.mask, exposure)
    };
    Some(ways.iter().map(row).collect())
}

#[test]
#[ignore = "prints"]
#[expect(clippy::print_stdout)]
fn table_of_bumps() {
    for object in shapes::solids().into_iter().chain(shapes::meshes()) {
        for alpha in ALPHAS {
            let Some(found) = measured_bumps(&object, 8, alpha, WAYS) else { continue };
            println!("{}, alpha {alpha}", object.name);
            for (way, f) in WAYS.iter().zip(found) {
                println!(
                    "  {:28} error {:6.3} shown {:6.4} flicker {:6.3} motion {:6.3} energy {:6.3}",
                    way.name, f.error, f.shown, f.flicker, f.motion, f.energy
                );
            }
        }
    }
}

#[test]
#[ignore = "prints"]
#[expect(clippy::print_stdout)]
fn table_of_highlights() {
    let sphere = &shapes::solids()[0];
    for alpha in ALPHAS {
        for light in &sphere.lights {
            let found = peaks::highlights(sphere, *light, alpha, METHODS);
            println!("alpha {alpha}, {light:?}");
            for (method, h) in METHODS.iter().zip(found) {
                println!(
                    "  {:28} peak {:6.3} width {:6.3} unsteady {:6.3} ({:.3})",
                    method.name, h.peak, h.width, h.unsteady, h.truth_unsteady
                );
            }
        }
    }
}
