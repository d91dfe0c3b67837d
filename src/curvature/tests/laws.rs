//! What must not change the result.

use glam::{DVec2, Mat3, Quat, Vec2, Vec3};
use proptest::prelude::*;

use super::super::{BakeOptions, Baked, Mesh, bake};
use super::shapes::{cylinder, grid, joined, sphere, torus, whole};
use crate::Error;
use crate::image::Size;

fn baked(mesh: &Mesh, width: usize, height: usize) -> Baked {
    bake(mesh, Size::new(width, height), &BakeOptions::default(), &|_| ()).unwrap()
}

/// Largest difference of two chains, as a share of the larger trace in the texel (or 1e-6 of a whole).
fn difference(a: &Baked, b: &Baked) -> f32 {
    let texels = |baked: &Baked| -> Vec<_> { baked.levels.iter().flat_map(|level| level.added.clone()).collect() };
    let (a, b) = (texels(a), texels(b));
    assert_eq!(a.len(), b.len());
    let worst = a.iter().zip(&b).map(|(a, b)| {
        let difference = (a.xx - b.xx).abs().max((a.xy - b.xy).abs()).max((a.yy - b.yy).abs());
        difference / (a.mean().max(b.mean()) + 1e-6)
    });
    worst.fold(0.0, f32::max)
}

/// Every triangle as four; normals in between are left as long as interpolation leaves them, or made unit.
fn subdivided(mesh: &Mesh, unit: bool) -> Mesh {
    let mut out = mesh.clone();
    out.triangles.clear();
    let uvs = mesh.uvs.as_ref().unwrap();
    let mut all_uvs = uvs.clone();
    for &[a, b, c] in &mesh.triangles {
        let mut middle = |i: u32, j: u32| {
            let (i, j) = (i as usize, j as usize);
            let n = 0.5 * (mesh.normals[i] + mesh.normals[j]);
            out.positions.push(0.5 * (mesh.positions[i] + mesh.positions[j]));
            out.normals.push(if unit { n.normalize() } else { n });
            all_uvs.push(0.5 * (uvs[i] + uvs[j]));
            (out.positions.len() - 1) as u32
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        out.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    out.uvs = Some(all_uvs);
    out.parts[0].triangles = 0..out.triangles.len();
    out
}

#[test]
fn subdivision_changes_nothing() {
    for shape in [torus, sphere] {
        let mesh = whole(shape, [48, 24]);
        let before = baked(&mesh, 64, 32);
        let after = baked(&subdivided(&mesh, false), 64, 32);
        let worst = difference(&before, &after);
        // Quadrature is exact where normals vary linearly; made unit, over 7 and 15 degrees a triangle, they do not quite.
        assert!(worst < 5e-3, "{worst}");
        // Cut the same way, but for the unit length: lerps of lerps that were made unit turn a little otherwise.
        let worst = difference(&before, &baked(&subdivided(&mesh, true), 64, 32));
        assert!(worst < 2e-2, "{worst}");
    }
}

#[test]
fn turning_moving_and_scaling_the_mesh_changes_nothing() {
    let mesh = whole(torus, [48, 24]);
    let before = baked(&mesh, 50, 30);
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -2.0);
    let mut turned = mesh.clone();
    turned.positions.iter_mut().for_each(|p| *p = 3.0 * (turn * *p) + Vec3::new(5.0, -1.0, 2.0));
    turned.normals.iter_mut().for_each(|n| *n = turn * *n);
    let worst = difference(&before, &baked(&turned, 50, 30));
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn a_mirror_turns_only_the_mixed_term() {
    // A texture at an angle to the axes has a mixed term. The mirrored mesh shows the same texture mirrored.
    let turn = |uv: DVec2| DVec2::new(0.3 + 0.5 * uv.x - 0.25 * uv.y, 0.1 + 0.3 * uv.x + 0.5 * uv.y);
    let mesh = grid(cylinder, [64, 8], DVec2::ZERO, DVec2::new(0.4, 1.0), turn);
    let mut mirrored = mesh.clone();
    let flip = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
    mirrored.positions.iter_mut().for_each(|p| *p = flip * *p);
    mirrored.normals.iter_mut().for_each(|n| *n = flip * *n);
    mirrored.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let (a, b) = (baked(&mesh, 64, 64), baked(&mirrored, 64, 64));
    let worst = difference(&a, &b);
    assert!(worst < 1e-3, "a renderer's frame mirrors with the surface: {worst}");
    let k = a.levels[0].added[[32, 30]];
    assert!(k.xy.abs() > 0.1 * k.xx, "{k:?}");
    // The texture drawn mirrored on the same surface: x of the frame turns around.
    let mut redrawn = mesh.clone();
    redrawn.uvs.as_mut().unwrap().iter_mut().for_each(|t| t.x = 1.0 - t.x);
    let c = baked(&redrawn, 64, 64).levels[0].added[[32, 33]];
    assert!((c.xx - k.xx).abs() < 1e-4 * k.xx && (c.xy + k.xy).abs() < 1e-4 * k.xx, "{c:?} {k:?}");
}

#[test]
fn cuts_of_a_smooth_surface_add_nothing() {
    // A cylinder in one chart, and in four with gaps, one of them upside down in the texture.
    let one = baked(&whole(cylinder, [256, 16]), 64, 64);
    let quarter = |i: usize| {
        let (low, high) = (DVec2::new(0.25 * i as f64, 0.0), DVec2::new(0.25 * (i + 1) as f64, 1.0));
        let place = move |uv: DVec2| {
            let inside = (uv - low) / (high - low);
            let inside = if i == 2 { DVec2::ONE - inside } else { inside };
            (DVec2::new(i as f64, 0.0) + DVec2::new(0.1, 0.2) + inside * DVec2::new(0.8, 0.5)) / DVec2::new(4.0, 1.0)
        };
        grid(cylinder, [64, 16], low, high, place)
    };
    let four = baked(&joined(&[quarter(0), quarter(1), quarter(2), quarter(3)]), 80, 64);
    assert_eq!((four.summary.islands, one.summary.islands), (4, 1));
    assert_eq!((four.summary.overlapped, one.summary.overlapped), (0, 0));
    // A quarter is 16 texels of 80 wide in place of 16 of 64: the same angle a texel, at level 0.
    let k = one.levels[0].added[[10, 10]].xx;
    let first = &four.levels[0];
    for (added, coverage) in first.added.iter().zip(&first.coverage) {
        assert!(added.xx <= 1.001 * k && added.yy < 1e-6, "{added:?}");
        assert!(*coverage < 0.999 || (added.xx / k - 1.0).abs() < 1e-3, "{added:?} {k}");
    }
    // At 1x1 each quarter has its own spread, and the pool no more than that; the whole circle would have 1.
    let last = four.levels.last().unwrap().added[[0, 0]];
    let quarter = 0.25 * std::f32::consts::TAU;
    let mean = (0.5 * quarter).sin() / (0.5 * quarter);
    let want = 1.0 - quarter.sin() / quarter;
    assert!(last.xx <= want + 1e-3 && last.xx >= want - 0.02 && mean < 1.0, "{last:?} {want}");
}

#[test]
fn mirrored_halves_on_one_place_are_averaged_and_counted() {
    let halves = [(0.0, 0.5, false), (0.5, 1.0, true)].map(|(low, high, turned)| {
        let place = move |uv: DVec2| {
            let u = (uv.x - low) / 0.5;
            DVec2::new(if turned { 1.0 - u } else { u }, uv.y)
        };
        grid(sphere, [128, 128], DVec2::new(low, 0.0), DVec2::new(high, 1.0), place)
    });
    let (half, both) = (baked(&halves[0], 64, 64), baked(&joined(&halves), 64, 64));
    assert_eq!((half.summary.overlapped, both.summary.overlapped, both.summary.shared), (0, 4096, 4096));
    assert!((both.summary.cover - 2.0).abs() < 2e-3 && both.summary.islands == 2);
    let worst = difference(&half, &both);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn levels_are_what_a_bake_at_their_size_gives() {
    // One baked at the level's own size is drawn anew; merging has lost nothing. 100 leads over 25 to 12.
    let mesh = whole(torus, [96, 48]);
    let chain = baked(&mesh, 200, 100);
    for k in 1..chain.levels.len() {
        let size = chain.levels[k].size();
        let own = baked(&mesh, size.width, size.height);
        let (a, b) = (&chain.levels[k].added, &own.levels[0].added);
        let close = |(a, b): (&crate::ndf::RoughnessTensor, &crate::ndf::RoughnessTensor)| {
            (a.xx - b.xx).abs().max((a.xy - b.xy).abs()).max((a.yy - b.yy).abs()) < 2e-3 * (a.mean() + 1e-6)
        };
        assert!(a.iter().zip(b).all(close), "level {k}");
    }
}

#[test]
fn coordinates_beyond_the_texture_repeat() {
    let mesh = whole(torus, [48, 24]);
    let before = baked(&mesh, 32, 64);
    let mut moved = mesh.clone();
    moved.uvs.as_mut().unwrap().iter_mut().for_each(|t| *t += Vec2::new(-3.25, 7.5));
    let after = baked(&moved, 32, 64);
    let (a, b) = (&before.levels[0].added, &after.levels[0].added);
    for y in 0..64 {
        for x in 0..32 {
            // u falls by 3.25: 8 columns to the left; v rises by half: 32 rows up.
            let (a, b) = (a[[y, x]], b[[(y + 32) % 64, (x + 24) % 32]]);
            assert!((a.xx - b.xx).abs() + (a.yy - b.yy).abs() < 1e-3 * a.mean(), "{x} {y}: {a:?} {b:?}");
        }
    }
    assert!(after.levels[0].coverage.iter().all(|c| (c - 1.0).abs() < 1e-4));
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_progress_ends_at_one() {
    let mesh = whole(torus, [200, 100]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| baked(&mesh, 300, 256))
    };
    assert_eq!(on(1), on(3));
    let seen = std::sync::Mutex::new(Vec::new());
    bake(&mesh, Size::new(128, 128), &BakeOptions::default(), &|share| seen.lock().unwrap().push(share)).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.len() > 8 && seen.iter().all(|s| (0.0..=1.0).contains(s)) && seen.last() == Some(&1.0));
}

#[test]
fn what_cannot_be_baked_is_said() {
    let mesh = whole(torus, [8, 8]);
    let refused = |mesh: &Mesh, size| match bake(mesh, size, &BakeOptions::default(), &|_| ()) {
        Err(Error::Unsupported { found, .. }) => found,
        other => panic!("{other:?}"),
    };
    let mut bare = mesh.clone();
    bare.uvs = None;
    assert_eq!(refused(&bare, Size::new(8, 8)), "a mesh without texture coordinates");
    assert_eq!(refused(&mesh, Size::new(20000, 8)), "a texture of 20000x8");
    let mut tiled = mesh.clone();
    tiled.uvs.as_mut().unwrap().iter_mut().for_each(|t| *t *= 20.0);
    assert!(refused(&tiled, Size::new(8, 8)).contains("400 times"));
    let mut flat = mesh;
    flat.uvs.as_mut().unwrap().iter_mut().for_each(|t| *t = Vec2::splat(0.5));
    let left = baked(&flat, 8, 8);
    assert_eq!((left.summary.without_texture_area, left.summary.covered), (128, 0));
    assert!((left.summary.left_out - 1.0).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_texel_is_missed_and_no_area_lost(
        corners in proptest::collection::vec((-1.5f32..1.5, -1.5f32..1.5), 3),
        width in 1usize..40,
        height in 1usize..40,
    ) {
        let uvs: Vec<Vec2> = corners.iter().map(|&(u, v)| Vec2::new(u, v)).collect();
        let area = 0.5 * (uvs[1] - uvs[0]).as_dvec2().perp_dot((uvs[2] - uvs[0]).as_dvec2()).abs();
        prop_assume!(area > 1e-3);
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let normals = vec![Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.8)];
        let mesh = Mesh::new(positions, Some(normals), Some(uvs.clone()), vec![[0, 1, 2]], 60.0).unwrap();
        let baked = baked(&mesh, width, height);
        for level in &baked.levels {
            let sum: f64 = level.coverage.iter().map(|&c| f64::from(c)).sum();
            prop_assert!((sum / level.size().texels() as f64 - area).abs() < 1e-5 * (1.0 + area));
            prop_assert!(level.added.iter().all(|k| k.xx.is_finite() && k.yy >= 0.0 && k.xx >= 0.0 && k.mean() <= 1.0));
        }
        // Points of the triangle all lie in texels that are covered.
        for i in 0..200 {
            let (a, b) = ((i as f32 * 0.618_034).fract(), (i as f32 * 0.414_214).fract());
            let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            let uv = uvs[0] + a * (uvs[1] - uvs[0]) + b * (uvs[2] - uvs[0]);
            let x = ((f64::from(uv.x) * width as f64).floor() as i64).rem_euclid(width as i64) as usize;
            let y = (((1.0 - f64::from(uv.y)) * height as f64).floor() as i64).rem_euclid(height as i64) as usize;
            prop_assert!(baked.levels[0].coverage[[y, x]] > 0.0, "{uv}");
        }
    }
}
