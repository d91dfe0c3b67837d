//! Tests of the renderer as a whole, with quick chains of their own.

use std::f32::consts::{LN_2, PI};

use glam::{DVec3, Vec2, Vec3};

use super::geometry::hit;
use super::*;
use crate::image::{Samples, Size};
use crate::ndf::{Axes, Form, Lobe, Lobes, RoughnessTensor, ShapeInvariant};
use crate::roughness::{Alpha, PerceptualRoughness};
use crate::sample::{Maps, by_name};

/// Level 0 of a sample's maps.
fn base(maps: &Maps) -> Lobes {
    Lobes::from_fn(Form::Isotropic, maps.normal.size(), |x, y| {
        let normal = Vec3::from_array([0, 1, 2].map(|c| 2.0 * maps.normal.at(x, y, c) - 1.0));
        Lobe::isotropic(normal.normalize(), PerceptualRoughness(maps.orm.at(x, y, 1)).alpha())
    })
}

/// Means over a footprint: normal, perceptual roughness, alpha^2, slopes, and the slopes' products xx xy yy.
type Means = [f32; 10];

/// Level 0 and its mips, square with sides a power of two: plain (mean perceptual roughness), or folded (alpha^2
/// plus twice the slopes' covariance, as LEAN).
fn chain(base: &Lobes, folded: bool) -> Vec<Lobes> {
    let mut side = base.size().width;
    let mut means: Vec<Means> = (0..side * side)
        .map(|i| {
            let Lobe { normal: n, roughness: r } = base.at(i % side, i / side);
            let (s, t) = (-n.x / n.z, -n.y / n.z);
            [n.x, n.y, n.z, r.xx.powf(0.25), r.xx, s, t, s * s, s * t, t * t]
        })
        .collect();
    let mut levels = vec![base.clone()];
    while side > 1 {
        let half = side / 2;
        means = (0..half * half)
            .map(|i| {
                let corner = i / half * 2 * side + i % half * 2;
                let four = [corner, corner + 1, corner + side, corner + side + 1];
                std::array::from_fn(|k| four.iter().map(|&j| 0.25 * means[j][k]).sum())
            })
            .collect();
        side = half;
        levels.push(Lobes::from_fn(Form::Anisotropic, Size::new(side, side), |x, y| {
            let [nx, ny, nz, perceptual, alpha2, s, t, xx, xy, yy] = means[y * side + x];
            let base = RoughnessTensor::isotropic(Alpha::from_squared(alpha2));
            let covariance = RoughnessTensor { xx: xx - s * s, xy: xy - s * t, yy: yy - t * t };
            let plain = RoughnessTensor::isotropic(PerceptualRoughness(perceptual).alpha());
            let roughness = if folded { (base + covariance * 2.0).clamped(0.0, 1.0) } else { plain };
            Lobe { normal: Vec3::new(nx, ny, nz).normalize(), roughness }
        }));
    }
    levels
}

/// A chain of one lobe.
fn constant(lobe: Lobe) -> Vec<Lobes> {
    (0..5).map(|k| Lobes::from_fn(Form::Anisotropic, Size::new(16, 16).level(k), |_, _| lobe)).collect()
}

#[test]
fn a_constant_material_looks_the_same_by_mips_and_by_supersampling() {
    let roughness = RoughnessTensor::from_axes(Axes { alpha_x: Alpha(0.3), alpha_y: Alpha(0.15), angle: 0.4 });
    let levels = constant(Lobe { normal: Vec3::new(0.1, -0.05, 1.0).normalize(), roughness });
    for scene in [Scene::studio(), Scene::studio_panel()] {
        for pixels in [64, 16, 4, 1] {
            let mips = render(&scene, &levels, pixels, Sampling::mips(4));
            let truth = render(&scene, &levels, pixels, Sampling::Supersampled { per_side: 4 });
            assert!(mips.iter().zip(&truth).all(|(a, b)| (a - b).abs() <= 1e-3 * b.max(1.0)), "{pixels} pixels");
        }
    }
}

#[test]
fn a_known_pixel_worked_with_the_lobe() {
    // One pixel, one ray: the middle of a panel that faces the camera.
    let lobe = Lobe::isotropic(Vec3::new(0.2, 0.1, 1.0).normalize(), Alpha(0.25));
    let direction = Vec3::new(0.5, 0.4, 0.8).normalize();
    let (f0, irradiance) = (Vec3::new(1.0, 0.7, 0.3), Vec3::splat(3.0));
    let scene = Scene {
        shape: Shape::Plane { tilt: 0.0 },
        f0,
        lights: vec![Light::Directional { direction, irradiance }],
        ..Scene::studio()
    };
    let (v, l) = (DVec3::Z, direction.as_dvec3());
    let grazing = (1.0 - v.dot((v + l).normalize())).powi(5) as f32;
    let fresnel = f0 + (1.0 - f0) * grazing;
    let expected = fresnel * irradiance * lobe.specular(v, l) as f32;
    for sampling in [Sampling::mips(1), Sampling::Supersampled { per_side: 1 }] {
        let image = render(&scene, &constant(lobe), 1, sampling);
        let found = Vec3::new(image[(0, 0, 0)], image[(0, 0, 1)], image[(0, 0, 2)]);
        assert!((found - expected).length() < 1e-4 * expected.length(), "{found} {expected}");
    }
}

/// Under a white sky a perfect mirror's radiance is 1; rough metal loses what single scattering forgets, and never
/// gains. Seen from above at alpha 1, D = 1/pi and G2 = 2c / (1 + c) for a light at cosine c, so radiance is
/// `integral of c / (1 + c) dc = 1 - ln 2`.
#[test]
fn white_furnace_loses_a_little_energy() {
    const LIGHTS: usize = 5000;
    let lights = (0..LIGHTS).map(|i| {
        // A Fibonacci spiral.
        let z = 1.0 - (2 * i + 1) as f32 / LIGHTS as f32;
        let (sin, cos) = (i as f32 * 2.399963).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Light::Directional {
            direction: Vec3::new(r * cos, r * sin, z),
            irradiance: Vec3::splat(4.0 * PI / LIGHTS as f32),
        }
    });
    let scene = Scene { f0: Vec3::ONE, lights: lights.collect(), ..Scene::studio() };
    let draw = |alpha, pixels| {
        let levels = constant(Lobe::isotropic(Vec3::Z, Alpha(alpha)));
        render(&scene, &levels, pixels, Sampling::mips(1))
    };
    let middle = draw(1.0, 1)[(0, 0, 0)];
    assert!((middle - (1.0 - LN_2)).abs() < 2e-3, "{middle}");
    for (alpha, low) in [(0.2, 0.87), (0.5, 0.65)] {
        let image = draw(alpha, 16);
        for (y, x) in (0..16).flat_map(|y| (0..16).map(move |x| (y, x))) {
            let place = Vec2::new((2 * x + 1) as f32 / 16.0 - 1.0, 1.0 - (2 * y + 1) as f32 / 16.0);
            // Close to the rim lobes are too narrow for the sky's lights.
            if hit(&scene, place, 16).is_some_and(|hit| hit.normal.dot(hit.view) > 0.3) {
                let radiance = image[(y, x, 0)];
                assert!(radiance < 1.01 && radiance > low, "alpha {alpha}: {radiance}");
            }
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    let levels = chain(&base(&(by_name("scratched-metal").unwrap().make)(64, 3)), true);
    let draw = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&Scene::studio(), &levels, 24, Sampling::Supersampled { per_side: 3 }))
    };
    let one = draw(1);
    assert_eq!(one, draw(2));
    assert_eq!(one, draw(5));
}

/// The claim of the strip, in numbers: far away, folded mips come closer to the truth than plain ones do. Scratches
/// and grout are left to better folds: a variance counts what is rare and steep for too much.
#[test]
fn folded_mips_come_closer_to_the_truth() {
    for name in ["brushed-metal", "hammered-metal", "woven-cloth", "flakes"] {
        let base = base(&(by_name(name).unwrap().make)(256, 1));
        let (plain, folded) = (chain(&base, false), chain(&base, true));
        for scene in [Scene::studio(), Scene::studio_panel()] {
            let truth = render(&scene, &plain, 16, Sampling::Supersampled { per_side: 24 });
            let error = |levels: &[Lobes]| {
                let image = render(&scene, levels, 16, Sampling::mips(4));
                (&image - &truth).iter().map(|e| e.abs()).sum::<f32>() / truth.sum()
            };
            let (plain, folded) = (error(&plain), error(&folded));
            assert!(folded < 0.75 * plain, "{name}, {:?}: plain {plain}, folded {folded}", scene.shape);
        }
    }
}

/// A ball in a white furnace: every pixel of a constant sky is the directional albedo, which f64 integrates from the
/// lobe; a mirror vanishes in it.
#[test]
fn a_ball_in_a_furnace_shows_its_albedo() {
    let furnace = |f0| Scene {
        f0: Vec3::splat(f0),
        lights: vec![],
        environment: Some(Environment::constant(Vec3::splat(0.7))),
        ..Scene::outdoor()
    };
    let draw = |scene, alpha| render(&scene, &constant(Lobe::isotropic(Vec3::Z, Alpha(alpha))), 9, Sampling::mips(1));
    assert!(draw(furnace(1.0), 1e-3).iter().all(|v| (v - 0.7).abs() < 2e-3));
    // Beside the ball the sky itself is seen; in its middle, a lobe that faces the view.
    let rough = draw(furnace(1.0), 1.0);
    assert_eq!(rough[(0, 0, 0)], 0.7);
    assert!((rough[(4, 4, 1)] - 0.7 * (1.0 - LN_2)).abs() < 0.01, "{}", rough[(4, 4, 1)]);
    let gray = draw(furnace(0.5), 1e-3)[(4, 4, 2)];
    assert!((gray - 0.35).abs() < 1e-3, "{gray}");
}

/// On a floor that leans far back, footprints are about three times as long as wide. Ridges along them are as fine as a pixel
/// is wide: trilinear look-ups blur them, probes along the footprint do not. One ray a pixel.
#[test]
fn anisotropic_look_ups_come_closer_where_footprints_are_long() {
    let size = Size::new(256, 256);
    let ridges = Lobes::from_fn(Form::Isotropic, size, |x, _| {
        let slope = 0.25 * (x as f32 / 8.0 * 2.0 * PI).sin();
        Lobe::isotropic(Vec3::new(slope, 0.0, 1.0).normalize(), Alpha(0.3))
    });
    let levels = chain(&ridges, true);
    let scene = Scene { repeats: 0.4, ..Scene::outdoor_panel() };
    let truth = render(&scene, &levels[..1], 48, Sampling::Supersampled { per_side: 12 });
    let error = |filter| {
        let image = render(&scene, &levels, 48, Sampling::Mips { per_side: 1, filter });
        (&image - &truth).iter().map(|e| e.abs()).sum::<f32>() / truth.sum()
    };
    let [trilinear, two, many] =
        [Filter::Trilinear, Filter::Anisotropic { taps: 2 }, Filter::Anisotropic { taps: 16 }].map(error);
    assert!(many < 0.7 * trilinear && many < two, "trilinear {trilinear}, 2 taps {two}, 16 taps {many}");
}

#[test]
fn strip_has_its_rows_and_columns() {
    let levels = constant(Lobe::isotropic(Vec3::Z, Alpha(0.3)));
    let strip = distance_strip(&Scene::studio(), &[("Plain", &levels), ("Folded", &levels)], 32, &[1.0, 0.5, 0.3]);
    let Size { width, height } = strip.size();
    let Samples::U8(pixels) = &strip.samples else { panic!("8-bit") };
    // Two equal chains draw equal rows, and the truth of a constant material is nearly the same again.
    let (left, top, pitch) = (width - 14 - 3 * 38 + 6, height - 14 - 3 * 38 + 6, 38);
    for (y, x) in (0..32).flat_map(|y| (0..3 * pitch - 6).map(move |x| (y, x))) {
        let at = |row: usize| pixels[(top + row * pitch + y, left + x, 0)];
        assert_eq!(at(0), at(1));
        assert!(at(0).abs_diff(at(2)) < 40);
    }
}
