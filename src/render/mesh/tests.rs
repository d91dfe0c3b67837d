use glam::{Vec2, Vec3};
use ndarray::Array2;

use super::*;
use crate::curvature::Mesh;
use crate::image::Size;
use crate::ndf::{Form, Lobe, Lobes};
use crate::render::{Image, Light};
use crate::roughness::Alpha;

/// Half the picture is one length wide at distance 1.
const VIEW: MeshView = MeshView { eye: Vec3::new(0.0, 0.0, 4.0), target: Vec3::ZERO, up: Vec3::Y, half_view: 0.25 };

fn scene<'a>(mesh: &'a Mesh, lights: &'a [Light]) -> MeshScene<'a> {
    MeshScene { mesh, view: VIEW, lights, f0: Vec3::splat(0.9) }
}

/// A quad with corners a, b, c, d and the texture's lower left at a, lower right at b; normals as given or its own.
fn quad(corners: [Vec3; 4], normals: Option<[Vec3; 4]>) -> Mesh {
    let uvs = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    Mesh::new(corners.to_vec(), normals.map(Vec::from), Some(uvs), vec![[0, 1, 2], [0, 2, 3]], 60.0).unwrap()
}

fn square(half: f32, z: f32) -> [Vec3; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(half * x, half * y, z))
}

/// Leans back by 60 degrees, and is larger than the picture.
fn floor() -> Mesh {
    quad(square(3.0, 0.0).map(|p| Vec3::new(p.x, 0.5 * p.y, -0.75f32.sqrt() * p.y)), None)
}

const LIGHT: [Light; 1] =
    [Light::Directional { direction: Vec3::new(0.36, 0.48, 0.8), irradiance: Vec3::new(1.0, 0.8, 0.6) }];

/// Where the ray through a place of a picture of so many pixels meets the floor.
fn on_floor(column: f32, row: f32, pixels: f32) -> Vec3 {
    let scale = 0.5 / pixels;
    let ray = Vec3::new(scale * (column + 0.5 - 0.5 * pixels), scale * (0.5 * pixels - row - 0.5), -1.0);
    let n = Vec3::new(0.0, 0.75f32.sqrt(), 0.5);
    VIEW.eye - ray * (VIEW.eye.dot(n) / ray.dot(n))
}

#[test]
fn attributes_are_in_perspective() {
    let mesh = floor();
    let fragments = scene(&mesh, &[]).fragments(10, Vec2::ZERO);
    for ((row, column), fragment) in fragments.indexed_iter() {
        let Fragment { point, right, up } = fragment.expect("the floor fills the picture");
        let at = |x: usize, y: usize| on_floor(x as f32, y as f32, 10.0);
        let expected = at(column, row);
        assert!((point.position - expected).length() < 1e-5, "{} {expected}", point.position);
        let uv = |p: Vec3| Vec2::new(p.x / 6.0 + 0.5, p.y / 3.0 + 0.5);
        assert!((point.uv - uv(expected)).length() < 1e-5);
        assert!((point.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        // Differences within the quad, whichever of its pixels it is.
        let (left, top) = (column & !1, row & !1);
        let (a, b, c, d) = (at(left, row), at(left + 1, row), at(column, top + 1), at(column, top));
        assert!((right.position - (b - a)).length() < 1e-5 && (up.position - (d - c)).length() < 1e-5);
        assert!((right.uv - (uv(b) - uv(a))).length() < 1e-5 && (up.uv - (uv(d) - uv(c))).length() < 1e-5);
        let view = |p: Vec3| (VIEW.eye - p).normalize();
        assert!((point.view - view(expected)).length() < 1e-5);
        assert!((right.view - (view(b) - view(a))).length() < 1e-5);
        assert!(right.normal.length() < 1e-6 && up.normal.length() < 1e-6);
    }
}

/// A triangle that holds the middle of one pixel of its quad alone tells the same as a large one with its attributes.
#[test]
fn quads_go_on_beside_the_triangle() {
    let corners = |scale: f32| {
        let middle = Vec3::new(0.05, 0.05, 0.0);
        let place = |x: f32, y: f32| middle + scale * Vec3::new(x, y, 0.0);
        vec![place(-2.0, -1.5), place(2.0, -1.0), place(0.3, 2.0)]
    };
    let normals = |scale: f32| {
        // Linear over the plane, not unit.
        corners(scale).iter().map(|p| Vec3::new(0.2 * p.x, 0.1 * p.y - 0.1 * p.x, 1.0)).collect::<Vec<_>>()
    };
    let draw = |scale: f32| {
        let uvs = corners(scale).iter().map(|p| p.truncate()).collect();
        let mut mesh = Mesh::new(corners(scale), Some(normals(scale)), Some(uvs), vec![[0, 1, 2]], 60.0).unwrap();
        mesh.normals = normals(scale);
        scene(&mesh, &[]).fragments(20, Vec2::ZERO)
    };
    let (large, small) = (draw(1.0), draw(0.02));
    assert_eq!(small.iter().flatten().count(), 1, "one pixel");
    let (place, small) = small.indexed_iter().find_map(|(place, f)| f.map(|f| (place, f))).unwrap();
    let large = large[place].unwrap();
    for (a, b) in [(small.right, large.right), (small.up, large.up)] {
        assert!(a.normal.length() > 1e-3);
        assert!((a.normal - b.normal).length() < 1e-4 && (a.uv - b.uv).length() < 1e-4, "{a:?} {b:?}");
    }
    assert!((small.point.normal - large.point.normal).length() < 1e-5);
}

/// Edges that run through the middles of samples belong to at least one side, and the nearer of two surfaces is seen,
/// whatever their order.
#[test]
fn no_holes_and_the_nearest_is_seen() {
    // The diagonal and the middles of both sides run through middles of pixels.
    let (near, far) = (quad(square(0.5, 1.0), None), quad(square(3.0, -1.0), None));
    for (first, second) in [(&near, &far), (&far, &near)] {
        let base = first.positions.len() as u32;
        let triangles = first.triangles.iter().copied().chain(second.triangles.iter().map(|t| t.map(|i| base + i)));
        let mesh = Mesh::new(
            [&first.positions[..], &second.positions].concat(),
            Some([&first.normals[..], &second.normals].concat()),
            None,
            triangles.collect(),
            60.0,
        )
        .unwrap();
        for pixels in [9, 16] {
            let fragments = scene(&mesh, &[]).fragments(pixels, Vec2::ZERO);
            for ((row, column), fragment) in fragments.indexed_iter() {
                let z = fragment.expect("no holes").point.position.z;
                // The near square spans 0.5 / 3 of 0.25 on either side.
                let off = |i: usize| ((i as f32 + 0.5) / pixels as f32 - 0.5).abs();
                let seen = if off(row).max(off(column)) < 0.5 * 0.5 / 3.0 / 0.25 { 1.0 } else { -1.0 };
                assert!((z - seen).abs() < 1e-5, "{row} {column}: {z}");
            }
        }
    }
}

#[test]
fn coverage_and_edges_worked_by_hand() {
    // A square that ends in the middle of pixels: from 2.5 pixels to 7.5 of 10.
    let mesh = quad(square(0.5, 0.0), None);
    let view = MeshView { half_view: 0.25, ..VIEW };
    let scene = MeshScene { view, ..scene(&mesh, &[]) };
    let truth = scene.truth(10, Vec2::ZERO, 4, &[]);
    let share = |i: usize| [0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0][i];
    for ((row, column), coverage) in truth.coverage.indexed_iter() {
        assert_eq!(*coverage, share(row) * share(column));
        assert_eq!(truth.whole[(row, column)], *coverage == 1.0);
    }
    // Before a wall all pixels are covered, but those of the square's rim see two surfaces.
    let wall = quad(square(3.0, -1.0), None);
    let mesh = Mesh::new(
        [&mesh.positions[..], &wall.positions].concat(),
        None,
        None,
        vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        60.0,
    )
    .unwrap();
    let truth = MeshScene { mesh: &mesh, ..scene }.truth(10, Vec2::ZERO, 4, &[]);
    assert!(truth.coverage.iter().all(|c| *c == 1.0));
    for ((row, column), whole) in truth.whole.indexed_iter() {
        let beside = |i: usize| share(i) == 0.0;
        assert_eq!(*whole, beside(row) || beside(column) || share(row) * share(column) == 1.0, "{row} {column}");
    }
}

/// With one sample a pixel the truth is the picture of a lobe that no derivative changes; and moving the picture by whole
/// pixels moves its pixels.
#[test]
fn pictures_agree() {
    let normals = square(0.4, 0.0).map(|p| (p + Vec3::Z).normalize());
    let mesh = quad(square(0.8, 0.0), Some(normals));
    let scene = scene(&mesh, &LIGHT);
    let lobe = Lobe::isotropic(Vec3::Z, Alpha(0.2));
    let draw = |offset: Vec2| scene.shade(&scene.fragments(12, offset), &|_, _| lobe);
    let picture = draw(Vec2::ZERO);
    assert!(picture.iter().any(|v| *v > 0.1));
    let same = |a: &Image, b: &Image| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-4 * b.abs().max(1e-3));
    assert!(same(&scene.truth(12, Vec2::ZERO, 1, &[&|_| lobe]).images[0], &picture));
    let moved = draw(Vec2::new(2.0, 1.0));
    let back = Image::from_shape_fn((11, 10, 3), |(y, x, c)| moved[(y, x + 2, c)]);
    let cut = Image::from_shape_fn((11, 10, 3), |(y, x, c)| picture[(y + 1, x, c)]);
    assert!(same(&back, &cut));
    // Means of means: 4 samples a side, from a picture four times as large.
    let fine = scene.shade(&scene.fragments(48, Vec2::new(1.0, 0.0)), &|_, _| lobe);
    let truth = &scene.truth(12, Vec2::new(0.25, 0.0), 4, &[&|_| lobe]).images[0];
    let mean = Image::from_shape_fn((12, 12, 3), |(y, x, c)| {
        (0..16).map(|i| fine[(4 * y + i / 4, 4 * x + i % 4, c)]).sum::<f32>() / 16.0
    });
    assert!(same(truth, &mean));
}

#[test]
fn frames_follow_the_texture() {
    let turned = |uvs: [Vec2; 4]| {
        let mut mesh = quad(square(0.8, 0.0), None);
        mesh.uvs = Some(uvs.to_vec());
        scene(&mesh, &[]).fragments(4, Vec2::ZERO)[(1, 1)].unwrap().point.frame
    };
    let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
    let frame = turned([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    assert!(near(frame.tangent, Vec3::X) && near(frame.bitangent, Vec3::Y));
    // A quarter turn, and a mirror.
    let frame = turned([Vec2::Y, Vec2::ZERO, Vec2::X, Vec2::ONE]);
    assert!(near(frame.tangent, Vec3::Y) && near(frame.bitangent, Vec3::NEG_X));
    let frame = turned([Vec2::X, Vec2::ZERO, Vec2::Y, Vec2::ONE]);
    assert!(near(frame.tangent, Vec3::NEG_X) && near(frame.bitangent, Vec3::Y));
    // Without texture coordinates: of a surface that faces the camera, its axes; else orthonormal.
    let mut mesh = quad(square(0.8, 0.0), None);
    mesh.uvs = None;
    let frame = scene(&mesh, &[]).fragments(4, Vec2::ZERO)[(1, 1)].unwrap().point.frame;
    assert!(near(frame.tangent, Vec3::X) && near(frame.bitangent, Vec3::Y));
    let mesh = Mesh { uvs: None, ..floor() };
    let point = scene(&mesh, &[]).fragments(4, Vec2::ZERO)[(1, 2)].unwrap().point;
    assert!(
        near(point.frame.tangent.cross(point.frame.bitangent), point.normal) && point.frame.tangent.is_normalized()
    );
}

/// Nothing is drawn behind the eye, of no area, or edge-on; and it is no error.
#[test]
fn what_cannot_be_seen_is_not_drawn() {
    let empty = |mesh: &Mesh| scene(mesh, &LIGHT).fragments(8, Vec2::ZERO).iter().all(Option::is_none);
    assert!(empty(&quad(square(1.0, 5.0), None)) && empty(&quad(square(1.0, 4.0), None)));
    assert!(empty(&quad(square(1.0, 0.0).map(|p| Vec3::new(0.0, p.y, p.x)), None)));
    assert!(empty(&quad([Vec3::ZERO; 4], Some([Vec3::Z; 4]))));
    assert!(empty(&quad(square(1.0, 0.0).map(|p| p + 9.0 * Vec3::X), None)));
    let truth = scene(&quad(square(1.0, 5.0), None), &LIGHT).truth(
        4,
        Vec2::ZERO,
        2,
        &[&|_| Lobe::isotropic(Vec3::Z, Alpha(0.5))],
    );
    assert!(truth.images[0].iter().all(|v| *v == 0.0) && truth.coverage == Array2::<f32>::zeros((4, 4)));
}

/// A map's lobes turn with the frame: the highlight of a bent normal is where that of a bent surface is.
#[test]
fn maps_are_read_in_the_frame() {
    let tilt = Vec3::new(0.3, 0.2, 1.0).normalize();
    let level = |side| Lobes::from_fn(Form::Isotropic, Size::new(side, side), |_, _| Lobe::isotropic(tilt, Alpha(0.3)));
    let map = LobeMap::new(&[level(4), level(2), level(1)]);
    let mesh = quad(square(0.8, 0.0), None);
    let bumpy = scene(&mesh, &LIGHT).truth(6, Vec2::ZERO, 2, &[&|p| map.base(p.uv)]);
    let bent = Mesh { normals: vec![tilt; 4], ..mesh.clone() };
    let smooth = scene(&bent, &LIGHT).truth(6, Vec2::ZERO, 2, &[&|_| Lobe::isotropic(Vec3::Z, Alpha(0.3))]);
    assert!(bumpy.images[0].iter().zip(&smooth.images[0]).all(|(a, b)| (a - b).abs() < 1e-3 * b.max(0.1)));
    // Texels of level 1 are half as wide as the map; a pixel of twice a half by a half of that has their area.
    let widths = [0.1, 0.2, 0.4];
    let level = |k: usize| {
        Lobes::from_fn(Form::Isotropic, Size::new(4 >> k, 4 >> k), |_, _| Lobe::isotropic(Vec3::Z, Alpha(widths[k])))
    };
    let map = LobeMap::new(&[level(0), level(1), level(2)]);
    let (uv, steps) = (Vec2::splat(0.3), [Vec2::new(1.0, 0.0), Vec2::new(0.3, 0.25)]);
    let alpha2 = |lobe: Lobe| lobe.roughness.xx;
    assert!((alpha2(map.base(uv)) - 0.01).abs() < 1e-6);
    assert!((alpha2(map.trilinear(uv, steps)) - 0.04).abs() < 1e-6);
    // Probes along the longer axis need a finer level.
    assert!(alpha2(map.anisotropic(uv, steps, 8)) < 0.02);
    assert!((alpha2(map.anisotropic(uv, steps, 1)) - 0.16).abs() < 1e-6);
}
