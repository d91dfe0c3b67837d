//! How the ratio changes under small and large movements of pixel and light.

use glam::DVec2;

use rayon::prelude::*;

use super::{Case, correlation, quantile, sample};
use crate::glint::field::{even_variance, layer};
use crate::glint::{Probe, evaluator, pcg4d, unit};

/// A direction of one's own for each sample.
fn direction(n: u32) -> DVec2 {
    DVec2::from_angle(std::f64::consts::TAU * unit(pcg4d([n, 4, 4, 4])[0]))
}

/// By this many pixels. The kernel of a pixel is `sqrt(2)` pixels wide along each axis of its footprint.
fn pan(p: &mut Probe, pixels: f64, n: u32) {
    let (xx, xy, yy) = (p.kernel.xx, p.kernel.xy, p.kernel.yy);
    let (x, d) = (xx.sqrt(), direction(n) * pixels / 2f64.sqrt());
    p.at += DVec2::new(x * d.x, xy / x * d.x + (yy - xy * xy / xx).max(0.0).sqrt() * d.y);
}

/// By this much of the chart.
fn turn(p: &mut Probe, step: f64, n: u32) {
    p.y = (p.y + direction(n) * step).fract_gl();
    p.widths += direction(n) * step / p.area.sqrt();
}

/// Changes in standard deviations of g: the 99.99th percentile and the largest.
fn changes(
    name: &str,
    case: impl Fn(u32) -> Case + Sync,
    count: u32,
    step: impl Fn(&mut Probe, u32) + Sync,
) -> (f64, f64) {
    let ratio = evaluator(name).unwrap().ratio;
    let mut changes = sample(count, |n| {
        let case = case(n);
        let mut p = case.probe(n, 41);
        let before = ratio(&p);
        step(&mut p, n);
        (ratio(&p) - before).abs() * case.n_eff.sqrt()
    });
    (quantile(&mut changes, 0.9999), quantile(&mut changes, 1.0))
}

/// Numbers of flakes from 0.1 to 100, anisotropies to 16.
fn any(n: u32) -> Case {
    let h = pcg4d([n, 6, 6, 6]);
    let n_eff = 0.1 * 1000f64.powf(unit(h[0]));
    Case { n_eff, area: 0.004, anisotropy: 16f64.powf(unit(h[1]) * f64::from(n % 2)), angle: 7.0 * unit(h[2]) }
}

fn small_steps(count: u32) {
    // One flake of few is 10 deviations bright and more. Counts are rougher: as a grid of cells fades out its flakes do too,
    // within the 256 steps of an octave, and those of the next are fewer and brighter meanwhile.
    let field = [("pan", 0.045, 0.08), ("zoom", 0.05, 0.08), ("turn", 0.075, 0.13)];
    let binomial = [("pan", 0.05, 0.09), ("zoom", 0.115, 0.16), ("turn", 0.06, 0.085)];
    for (name, limits) in [("field", field), ("binomial", binomial)] {
        let pan = changes(name, any, count, |p, n| pan(p, 1.0 / 256.0, n));
        let zoom = changes(name, any, count, |p, _| p.kernel = p.kernel.scaled(2f64.powf(1.0 / 256.0)));
        let turn = changes(name, any, count, |p, n| turn(p, 1.0 / 4096.0, n));
        for ((most, largest), (what, limit, bound)) in [pan, zoom, turn].into_iter().zip(limits) {
            eprintln!("{name}, {what}: P99.99 {most:.3} sigma, largest {largest:.3}");
            // Of few samples the percentile is the largest.
            assert!(most < if count < 100_000 { bound } else { limit }, "{name}, {what}: {most}");
            assert!(largest < bound, "{name}, {what}: largest {largest}");
        }
    }
}

#[test]
fn small_steps_change_little() {
    small_steps(10_000);
}

#[test]
#[ignore = "samples of 200000"]
fn small_steps_change_little_at_length() {
    small_steps(200_000);
}

/// Across the numbers at which the field begins to sum sparser nets, changes them, or stops.
#[test]
fn no_seams_between_numbers_of_flakes() {
    let ratio = evaluator("field").unwrap().ratio;
    for seam in [1.5, 6.0, 24.0, 96.0, 1e4] {
        for n in 0..300 {
            let value = |n_eff: f64| ratio(&Case::round(n_eff, 0.004).probe(n, 2));
            let change = (value(seam * (1.0 + 1e-9)) - value(seam * (1.0 - 1e-9))).abs() * f64::sqrt(seam);
            assert!(change < 1e-6, "N_eff {seam}: jump {change} sigma");
        }
    }
}

/// Twice as far away, the same flakes: `1 - correlation` is below 0.4.
#[test]
fn flakes_stay_when_zooming() {
    for (name, limit) in [("field", 0.4), ("binomial", 0.9)] {
        let ratio = evaluator(name).unwrap().ratio;
        for n_eff in [0.1, 0.3] {
            let pairs: Vec<_> = (0..12_000)
                .map(|n| {
                    let mut p = Case::round(n_eff, 0.004).probe(n, 51);
                    let near = ratio(&p);
                    p.kernel = p.kernel.scaled(2.0);
                    (near, ratio(&p))
                })
                .collect();
            let lost = 1.0 - correlation(&pairs);
            eprintln!("{name}, N_eff {n_eff} to {}: 1 - correlation {lost:.3}", 4.0 * n_eff);
            assert!(lost < limit, "{name}: {lost}");
        }
    }
}

/// Autocorrelation of the biweight of radius 1 at this distance, by midpoints.
fn autocorrelation(distance: f64) -> f64 {
    let w = |d: DVec2| (1.0 - d.length_squared()).max(0.0).powi(2);
    let (mut cross, mut own) = (0.0, 0.0);
    for i in -200..200 {
        for j in -200..200 {
            let d = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / 200.0;
            cross += w(d) * w(d - DVec2::new(distance, 0.0));
            own += w(d) * w(d);
        }
    }
    cross / own
}

/// Pixels that far apart are as alike as their kernels are, for few flakes, within 0.05 and 4 standard errors; counts by up to
/// 0.27 more, for their cells reach beyond the pixel.
fn structure(count: u32) {
    for (name, n_eff, limit) in [("field", 0.1, 0.05), ("field", 1.0, 0.08), ("binomial", 0.1, 0.27)] {
        let ratio = evaluator(name).unwrap().ratio;
        for pixels in [0.125, 0.25, 0.5, 1.0, 2.0] {
            let pairs: Vec<_> = (0..count)
                .map(|n| {
                    let mut p = Case::round(n_eff, 0.01).probe(n, 61);
                    let here = ratio(&p);
                    pan(&mut p, pixels, n);
                    (here, ratio(&p))
                })
                .collect();
            let (found, expected) = (correlation(&pairs), autocorrelation(pixels / 2f64.sqrt()));
            eprintln!("{name}, N_eff {n_eff}, {pixels} px: correlation {found:.3}, of kernels {expected:.3}");
            let error = 4.0 * (1.0 - expected * expected) * (1.0 + 1.0 / n_eff.sqrt()) / f64::from(count).sqrt();
            assert!((found - expected).abs() < limit + error, "{name}, {pixels}: {found} for {expected}");
        }
    }
}

#[test]
fn pixels_are_as_alike_as_their_kernels() {
    structure(6_000);
}

#[test]
#[ignore = "samples of 100000"]
fn pixels_are_as_alike_as_their_kernels_at_length() {
    structure(100_000);
}

/// What even filling and varied weights make of the correlation of the field, for as many flakes as are summed one by one: of
/// the even part, its share of the variance `even_variance`, pixels are less alike than their kernels are, for a flake here
/// leaves none of its direction for the cells around; of the weights' part as much.
#[test]
fn evenly_filled_pixels_are_less_alike() {
    let pairs = |pixels: f64, weights: f64| {
        let pairs: Vec<_> = (0..20_000)
            .into_par_iter()
            .map(|n| {
                let mut p = Case::round(1.0, 0.01).probe(n, 61);
                let here = layer(&p, 0, weights);
                pan(&mut p, pixels, n);
                (here, layer(&p, 0, weights))
            })
            .collect();
        correlation(&pairs)
    };
    for pixels in [0.5, 1.0, 1.5] {
        let even = even_variance(1.0, 1.0);
        let (whole, of_even) = (pairs(pixels, 1.0 - even), pairs(pixels, 0.0));
        let kernels = autocorrelation(pixels / 2f64.sqrt());
        let expected = even * of_even + (1.0 - even) * kernels;
        eprintln!("{pixels} px: {whole:.3}, even {of_even:.3}, kernels {kernels:.3}, both {expected:.3}");
        assert!((whole - expected).abs() < 0.02, "{pixels}: {whole} for {expected}");
        assert!(of_even < kernels - 0.03, "{pixels}: {of_even} for {kernels}");
    }
}

#[test]
fn panning_over_a_period_changes_nothing() {
    // Of the field; cells of counts have other sizes than 1.
    let ratio = evaluator("field").unwrap().ratio;
    for n in 0..20 {
        let mut p = Case::round(0.8, 0.01).probe(n, 3);
        p.at = DVec2::new(-Probe::PERIOD / 2.0, 17.25 + f64::from(n));
        let here = ratio(&p);
        p.at.x += Probe::PERIOD;
        assert!((ratio(&p) - here).abs() < 1e-9);
    }
}
