//! Is geometric filtering right? Curved metal with one sample a pixel, filtered, beside 1024 samples a pixel.
//!
//! `cargo test --test geometry -- --ignored --nocapture` prints the tables; real meshes are those of `MIPFOLD_MESHES`.

mod common;
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
use peaks::{Highlight, highlights};
use sequence::{Sequence, steps};
use shapes::Object;
use textured::{Bumps, Bumpy, WAYS, Way};

const ALPHAS: [f64; 3] = [0.05, 0.1, 0.2];

/// By alpha, then by method; nothing for a method that the object lacks maps for.
fn measured(object: &Object, frames: usize, alphas: &[f64]) -> Vec<Vec<Option<Figures>>> {
    let sequence = Sequence::metal(object, &steps(frames), alphas);
    let by_alpha = |(alpha, truth): (&f64, &Vec<_>)| {
        let exposure = exposure(truth);
        let row = |method: &Method| {
            if method.needs_uvs && !object.is_baked() {
                return None;
            }
            let frames = sequence.draw(&|f, light| lobe((method.tensor)(&Known::new(object, f, light, *alpha))));
            Some(figures(&frames, truth, &sequence.mask, exposure))
        };
        METHODS.iter().map(row).collect()
    };
    alphas.iter().zip(&sequence.truth).map(by_alpha).collect()
}

/// By way; nothing for an object that has no bumps.
fn measured_bumps(object: &Object, frames: usize, alpha: f64) -> Option<Vec<Figures>> {
    let (sample, repeats) = textured::on(object)?;
    let bumps = Bumps::new(sample, 128, alpha, repeats, textured::SCALE);
    let sequence = Sequence::new(object, &steps(frames), &[&|p| bumps.base(p)]);
    let truth = &sequence.truth[0];
    let exposure = exposure(truth);
    let row = |way: &Way| {
        let frames = sequence.draw(&|f, light| (way.lobe)(&Bumpy::new(Known::new(object, f, light, alpha), &bumps)));
        figures(&frames, truth, &sequence.mask, exposure)
    };
    Some(WAYS.iter().map(row).collect())
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    sum / f64::from(count)
}

fn method(name: &str) -> usize {
    METHODS.iter().position(|method| method.name == name).unwrap()
}

fn way(name: &str) -> usize {
    WAYS.iter().position(|way| way.name == name).unwrap()
}

/// Methods that the shader helpers' table recommends, and how large error and flicker may be as shares of the unfiltered
/// picture's, on every shape: one width cannot follow a cylinder.
const RECOMMENDED: [(&str, f64, f64); 6] = [
    ("baked", 0.8, 0.7),
    ("2021, normals, one width", 0.65, 0.45),
    ("2021, normals, two widths", 0.5, 0.4),
    ("2021, half vectors", 0.5, 0.4),
    ("box, half vectors", 0.55, 0.6),
    ("vertex curvature", 0.6, 0.65),
];

#[test]
fn filters_come_closer_to_the_truth_and_flicker_less() {
    for object in shapes::solids().iter().chain(&shapes::meshes(&["spot"])) {
        for (alpha, row) in ALPHAS.iter().zip(measured(object, 4, &ALPHAS[..2])) {
            let none = row[0].unwrap();
            for (name, error, flicker) in RECOMMENDED {
                let Some(found) = row[method(name)] else {
                    assert!(name == "baked" && !object.is_baked(), "{name}");
                    continue;
                };
                let told = format!("{}, alpha {alpha}, {name}: {found:?} beside {none:?}", object.name);
                assert!(found.error < error * none.error, "{told}");
                assert!(found.flicker < flicker * none.flicker && found.flicker < 1.0, "{told}");
                assert!((found.energy - 1.0).abs() < 0.07, "{told}");
            }
            // A box adds no more haze than it takes off sparkle, even where highlights are wider than pixels.
            let (found, haze) = (row[method("box, half vectors")].unwrap(), row[method("2016, slopes")].unwrap());
            assert!(found.shown < none.shown && found.shown_flicker < none.shown_flicker, "{found:?} {none:?}");
            assert!(haze.shown > 1.2 * none.shown, "slopes widen what lights from the side show: {haze:?} {none:?}");
        }
    }
}

#[test]
fn highlights_keep_their_peaks_and_widths() {
    let sphere = &shapes::solids()[0];
    for light in &sphere.lights[..4] {
        let found = highlights(sphere, *light, ALPHAS[0]);
        let at = |name: &str| found[method(name)];
        let within = |h: Highlight, peaks: [f64; 2], most: f64| {
            assert!(h.peak > peaks[0] && h.peak < peaks[1] && h.width > 0.98 && h.width < most, "{h:?}");
            assert!(h.unsteady < 0.85 * found[0].unsteady, "{h:?} {:?}", found[0]);
        };
        assert!(found[0].peak > 1.2 && found[0].width < 0.96 && found[0].unsteady > 1.8 * found[0].truth_unsteady);
        within(at("2021, normals, one width"), [0.88, 1.0], 1.2);
        within(at("2021, normals, two widths"), [0.88, 1.0], 1.2);
        within(at("2021, half vectors"), [0.85, 0.95], 1.2);
        within(at("box, half vectors"), [0.98, 1.06], 1.1);
        within(at("baked"), [0.93, 1.1], 1.15);
        within(at("vertex curvature"), [1.0, 1.1], 1.1);
        // Published with twice the variance or more.
        assert!(at("2019, normals, one width").peak < 0.7 && at("2017, half vectors, axes").peak < 0.8);
    }
}

#[test]
fn folds_and_curvature_are_best_together() {
    for object in shapes::solids().iter().chain(&shapes::meshes(&["spot"])) {
        let found = measured_bumps(object, 4, ALPHAS[0]).unwrap();
        let at = |name: &str| found[way(name)];
        let (plain, folded, curved) = (at("plain mips"), at("folded"), at("plain + curvature"));
        for name in ["folded + curvature", "folded + half vectors", "folded + vertex curvature", "folded + baked"] {
            let both = at(name);
            let told = format!("{}, {name}: {both:?}, folded {folded:?}, curvature {curved:?}", object.name);
            assert!(both.error < 0.95 * folded.error && both.error < 0.75 * curved.error, "{told}");
            assert!(both.flicker < 0.95 * folded.flicker && both.flicker < 0.85 * curved.flicker, "{told}");
            assert!(both.error < 0.4 * plain.error && both.flicker < 0.4 * plain.flicker, "{told}");
        }
    }
}

/// A line for each method: means over alpha and objects.
#[test]
#[ignore = "prints"]
#[expect(clippy::print_stdout)]
fn table_of_methods() {
    let groups = [shapes::solids(), shapes::meshes(&[])];
    let found =
        groups.each_ref().map(|objects| objects.iter().map(|object| measured(object, 8, &ALPHAS)).collect::<Vec<_>>());
    for (object, rows) in groups.iter().flatten().zip(found.iter().flatten()) {
        println!("{}, {} pixels", object.name, object.pixels);
        for (alpha, row) in ALPHAS.iter().zip(rows) {
            for (method, figures) in METHODS.iter().zip(row) {
                let Some(f) = figures else { continue };
                println!("  {alpha:5} {:28} {f:.3?}", method.name);
            }
        }
    }
    let sphere = &groups[0][0];
    let peaks: Vec<_> = sphere.lights.iter().map(|light| highlights(sphere, *light, ALPHAS[0])).collect();
    println!("| method | error | on meshes | shown | flicker | peak | width | unsteady |");
    for (i, method) in METHODS.iter().enumerate() {
        let over = |groups: &[usize], figure: fn(&Figures) -> f64| {
            let rows = groups.iter().flat_map(|group| &found[*group]).flatten();
            mean(rows.filter_map(|row| row[i].as_ref()).map(figure))
        };
        let peak = |figure: fn(&Highlight) -> f64| mean(peaks.iter().map(|row| figure(&row[i])));
        println!(
            "| {} | {:.3} | {:.3} | {:.4} | {:.2} | {:.2} | {:.2} | {:.2} |",
            method.name,
            over(&[0], |f| f.error),
            over(&[1], |f| f.error),
            over(&[0, 1], |f| f.shown),
            over(&[0, 1], |f| f.flicker),
            peak(|h| h.peak),
            peak(|h| h.width),
            peak(|h| h.unsteady / h.truth_unsteady),
        );
    }
}

#[test]
#[ignore = "prints"]
#[expect(clippy::print_stdout)]
fn table_of_bumps() {
    let mut all = vec![Vec::new(); WAYS.len()];
    for object in shapes::solids().into_iter().chain(shapes::meshes(&["spot"])) {
        for alpha in ALPHAS {
            println!("{}, alpha {alpha}", object.name);
            for ((way, f), all) in WAYS.iter().zip(measured_bumps(&object, 8, alpha).unwrap()).zip(&mut all) {
                println!("  {:28} {f:.3?}", way.name);
                all.push(f);
            }
        }
    }
    println!("| bumps on a curved mesh | error | shown | flicker | energy |");
    for (way, figures) in WAYS.iter().zip(all) {
        let over = |figure: fn(&Figures) -> f64| mean(figures.iter().map(figure));
        println!(
            "| {} | {:.3} | {:.4} | {:.2} | {:.2} |",
            way.name,
            over(|f| f.error),
            over(|f| f.shown),
            over(|f| f.flicker),
            over(|f| f.energy)
        );
    }
}
