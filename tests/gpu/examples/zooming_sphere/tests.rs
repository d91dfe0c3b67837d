//! Materials that are made here, and folders that are written here.

mod files;

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use mipfold_gpu_tests::gpu::{gpu, say, skipped};

use crate::maps::{Level, Map, Material};
use crate::measure::{Figures, figures};
use crate::renderer::{Curvature, Lookup, Picture, Renderer, Way};
use crate::scene::{Pose, Scene};
use crate::sequence::{HEADING, Sequence};

/// Texels along a side of the maps.
const SIDE: usize = 128;
/// Perceptual: lobes as narrow as the curvature under a pixel is wide, and lobes that 8 bits of normals do not show in.
const SMOOTH: f32 = 0.2;
const ROUGH: f32 = 0.5;
const LOOKUP: Lookup = Lookup { anisotropic: 1, nearest: false };

fn renderer() -> Option<Renderer<'static>> {
    let Some(gpu) = gpu() else {
        skipped("no Vulkan adapter");
        return None;
    };
    Some(Renderer::new(gpu, Scene::new(3)).unwrap_or_else(|e| panic!("{e}")))
}

/// Slopes of a sum of waves, 4 to 13 texels long, in all directions.
fn waves(strength: f32) -> Vec<Vec2> {
    let wave = |k: usize, at: Vec2| {
        let angle = 2.4 * k as f32;
        let cycles = (10.0 + 22.0 * (0.618 * k as f32).fract()) * Vec2::from_angle(angle);
        let cycles = cycles.round();
        cycles.normalize() * (TAU * (cycles.dot(at) + 0.37 * k as f32)).cos()
    };
    let slope = |i: usize| {
        let at = Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32;
        (0..12).map(|k| wave(k, at)).sum::<Vec2>() * strength
    };
    (0..SIDE * SIDE).map(slope).collect()
}

/// Maps of slopes (v down, so y of normals is up) and of one roughness. Level k has the mean slope of its texels, and in alpha^2
/// twice the variance of slopes along either axis, on average: LEAN mapping (Olano & Baker 2010) with one width.
fn material(slopes: &[Vec2], roughness: f32, bits: u32) -> Material {
    let alpha2 = roughness.powi(4);
    let (mut normals, mut widths) = (Vec::new(), Vec::new());
    let mut side = SIDE;
    while side > 0 {
        let size = SIDE / side;
        let (mut normal, mut width) = (Vec::new(), Vec::new());
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let under = (0..size * size).map(|i| slopes[(y * size + i / size) * SIDE + x * size + i % size]);
            let count = (size * size) as f32;
            let mean = under.clone().sum::<Vec2>() / count;
            let variance = under.map(|s| s.distance_squared(mean)).sum::<f32>() / count;
            let n = Vec3::new(-mean.x, mean.y, 1.0).normalize();
            normal.extend([0.5 + 0.5 * n.x, 0.5 + 0.5 * n.y, 0.5 + 0.5 * n.z, 0.0]);
            width.push((alpha2 + variance).min(1.0).sqrt().sqrt());
        }
        normals.push(Level { width: side, height: side, values: normal });
        widths.push(Level { width: side, height: side, values: width });
        side /= 2;
    }
    Material {
        normal: Map { channels: 4, bits, levels: normals },
        roughness: Map { channels: 1, bits, levels: widths },
        anisotropy: None,
        y_up: true,
        normal_scale: 1.0,
        two_channels: false,
        gloss: false,
        mirrored: false,
    }
}

/// Folding beats plain mips; curvature beats folding once it is wider than what was folded.
#[test]
fn panes_come_in_their_order() {
    let Some(renderer) = renderer() else { return };
    let folded = material(&waves(0.02), SMOOTH, 8);
    let upload = |material: &Material| renderer.upload(material, LOOKUP).unwrap_or_else(|e| panic!("{e}"));
    let (plain, folded) = (upload(&folded.with_plain_mips()), upload(&folded));
    let sequence = Sequence { frames: 3, rays: 4, ..Sequence::default() };
    say(&format!("\n{HEADING}"));
    let [near, middle, far] = [2, 6, 16].map(|shrunk| {
        let drawn = sequence.at(&renderer, &plain, &folded, shrunk).unwrap_or_else(|e| panic!("{e}"));
        say(&drawn.row());
        drawn.figures()
    });
    for [plain, folded, curved, truth] in [near, middle, far] {
        assert_eq!((truth.error, truth.flicker, truth.brightness), (0.0, 0.0, 1.0));
        for pane in [folded, curved] {
            assert!(pane.error < 0.95 * plain.error && pane.flicker < plain.flicker, "{pane:?} {plain:?}");
        }
    }
    let [plain, folded, ..] = middle;
    assert!(folded.error < 0.7 * plain.error && folded.flicker < 0.9 * plain.flicker);
    let [plain, folded, curved, _] = far;
    assert!(folded.error < 0.7 * plain.error && curved.error < 0.5 * folded.error);
    assert!(folded.flicker < 0.9 * plain.flicker && curved.flicker < folded.flicker);
    // A lobe that is narrower than the change under a pixel is hit by few pixels, and too hard.
    let off = |figures: Figures| (figures.brightness - 1.0).abs();
    assert!(off(curved) < off(folded) && off(folded) < off(plain));
}

fn draw(renderer: &Renderer, material: &Material, side: u32, way: Way) -> Picture {
    let textures = renderer.upload(material, LOOKUP).unwrap_or_else(|e| panic!("{e}"));
    let pose = Pose { shrunk: 4.0, turn: 0.4 };
    renderer.draw(&textures, pose, side, way).unwrap_or_else(|e| panic!("{e}"))
}

/// The first picture beside the second.
fn beside(a: &Picture, b: &Picture) -> Figures {
    figures(std::slice::from_ref(a), std::slice::from_ref(b))
}

/// Without bumps and where the mesh hardly curves under a pixel, one ray does what many do, and all chains are one.
#[test]
fn smooth_spheres_need_no_folding() {
    let Some(renderer) = renderer() else { return };
    let flat = material(&vec![Vec2::ZERO; SIDE * SIDE], ROUGH, 8);
    let truth = draw(&renderer, &flat, 120, Way::Rays(5));
    for curvature in [Curvature::None, Curvature::Normals, Curvature::HalfVectors] {
        let pane = draw(&renderer, &flat, 120, Way::Mips(curvature));
        let Figures { error, brightness, .. } = beside(&pane, &truth);
        assert!(error < 0.01 && (brightness - 1.0).abs() < 0.005, "{curvature:?} {error} {brightness}");
    }
    // A sphere of radius 0.96 in a square of side 2.
    let covered = truth.pixels.iter().map(|p| p[3]).sum::<f32>() / truth.pixels.len() as f32;
    assert!((covered - 0.96f32.powi(2) * TAU / 8.0).abs() < 1e-3, "{covered}");
    assert_eq!(draw(&renderer, &flat.with_plain_mips(), 120, Way::Rays(5)), truth);
}

/// Parts of a picture join, whatever the number of rays: 120 pixels of 9 rays are drawn in 2 x 2 parts, of 8 in one.
#[test]
fn parts_of_a_picture_join() {
    let Some(renderer) = renderer() else { return };
    let bumpy = material(&waves(0.02), ROUGH, 8);
    let (one, four) = (draw(&renderer, &bumpy, 120, Way::Rays(8)), draw(&renderer, &bumpy, 120, Way::Rays(9)));
    let error = beside(&four, &one).error;
    assert!(error > 0.0 && error < 0.05, "{error}");
}

/// The same material in other conventions makes the same pictures.
#[test]
fn conventions_do_not_show() {
    let Some(renderer) = renderer() else { return };
    let gl = material(&waves(0.06), ROUGH, 8);
    let each = |map: &Map, change: fn(&mut [f32])| {
        let mut map = map.clone();
        let channels = map.channels;
        map.levels.iter_mut().for_each(|level| level.values.chunks_exact_mut(channels).for_each(change));
        map
    };
    let dx = Material { normal: each(&gl.normal, |t| t[1] = 1.0 - t[1]), y_up: false, ..gl.clone() };
    let gloss = Material { roughness: each(&gl.roughness, |t| t[0] = 1.0 - t[0]), gloss: true, ..gl.clone() };
    let two_channels = Material { normal: each(&gl.normal, |t| t[2] = 0.0), two_channels: true, ..gl.clone() };
    // Strength 0, but every direction.
    let round = Map { levels: gl.normal.levels.clone(), ..gl.normal.clone() };
    let anisotropy = Some(each(&round, |t| t[2] = 0.0));
    let anisotropic = Material { anisotropy, ..gl.clone() };
    let deep = material(&waves(0.06), ROUGH, 16);
    let has_deep = gpu().is_some_and(|gpu| gpu.device().features().contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM));
    for way in [Way::Mips(Curvature::Normals), Way::Rays(6)] {
        let expected = draw(&renderer, &gl, 60, way);
        let mut others = vec![("DirectX", &dx), ("gloss", &gloss), ("two channels", &two_channels)];
        others.push(("anisotropy 0", &anisotropic));
        if has_deep {
            others.push(("16 bits", &deep));
        }
        for (name, other) in others {
            let error = beside(&draw(&renderer, other, 60, way), &expected).error;
            // Only the rounding of other bits and of rebuilt z shows.
            let bound = if name == "two channels" || name == "16 bits" { 0.1 } else { 0.04 };
            assert!(error < bound, "{name}, {way:?}: {error}");
        }
        // And a convention that is wrong does show.
        let wrong = Material { y_up: false, ..gl.clone() };
        let error = beside(&draw(&renderer, &wrong, 60, way), &expected).error;
        assert!(error > 0.2, "{way:?}: {error}");
    }
}

/// Four pixels, of which the sphere covers three wholly.
#[test]
fn figures_worked_by_hand() {
    let picture = |values: [f32; 4]| Picture {
        side: 2,
        pixels: values.iter().enumerate().map(|(i, &v)| [v, v, v, if i == 3 { 0.5 } else { 1.0 }]).collect(),
    };
    let truth = [picture([1.0, 2.0, 3.0, 9.0]), picture([1.0, 2.0, 3.0, 9.0])];
    let pane = [picture([1.0, 2.0, 6.0, 0.0]), picture([1.0, 3.0, 3.0, 5.0])];
    let found = figures(&pane, &truth);
    let expected = Figures {
        error: (10.0f64 / 6.0).sqrt() / 2.0,
        brightness: (16.0 / 6.0) / 2.0,
        flicker: (4.0 / 3.0) / 2.0,
        change: (4.0 / 3.0) / 2.0,
    };
    let pairs = [
        (found.error, expected.error),
        (found.brightness, expected.brightness),
        (found.flicker, expected.flicker),
        (found.change, expected.change),
    ];
    assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {expected:?}");
    let still = figures(&truth, &truth);
    assert_eq!(still, Figures { brightness: 1.0, ..Figures::default() });
}
