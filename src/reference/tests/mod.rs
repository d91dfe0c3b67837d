//! The reference is right on its own: closed forms, normalisation, its sampler, and agreement of its ways of asking.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

mod reading;

use super::*;
use crate::image::{Size, Wrap};
use crate::material::Texels;
use crate::ndf::{Axes, Lobe, Ndf, RoughnessTensor, ShapeInvariant};
use crate::random::Random;
use crate::roughness::Alpha;

/// Texels of one width, given by their normals row by row.
pub(crate) struct Field {
    pub size: Size,
    pub normals: Vec<Vec3>,
    pub perceptual: Vec<f32>,
}

impl Texels for Field {
    fn size(&self) -> Size {
        self.size
    }

    fn normals(&self, y: usize, x: usize, [nx, ny, nz]: [&mut [f32]; 3], coverage: &mut [f32]) {
        for i in 0..coverage.len() {
            let n = self.normals[y * self.size.width + x + i];
            let usable = n.z > 0.0;
            let n = if usable { n } else { Vec3::Z };
            (nx[i], ny[i], nz[i], coverage[i]) = (n.x, n.y, n.z, if usable { 1.0 } else { 0.0 });
        }
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        out.copy_from_slice(&self.perceptual[y * self.size.width + x..][..out.len()]);
    }
}

pub(crate) fn tilted(x: f32, y: f32) -> Vec3 {
    Vec3::new(x, y, 1.0).normalize()
}

/// Bumps without any symmetry.
pub(crate) fn field(width: usize, height: usize) -> Field {
    let normal = |i: usize| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        tilted(0.4 * (1.3 * x + 0.4 * y).sin(), 0.3 * (0.9 * y - 0.2 * x).cos())
    };
    Field {
        size: Size::new(width, height),
        normals: (0..width * height).map(normal).collect(),
        perceptual: (0..width * height).map(|i| 0.4 + 0.3 * (i as f32 * 0.7).sin()).collect(),
    }
}

fn lobes() -> Vec<Lobe> {
    let axes = |x, y, angle| RoughnessTensor::from_axes(Axes { alpha_x: Alpha(x), alpha_y: Alpha(y), angle });
    vec![
        Lobe::isotropic(Vec3::Z, Alpha(0.5)),
        Lobe::isotropic(tilted(0.3, -0.4), Alpha(0.1)),
        Lobe { normal: tilted(-0.5, 0.2), roughness: axes(0.6, 0.2, 0.5) },
        Lobe { normal: tilted(0.1, 0.1), roughness: axes(0.05, 0.02, -1.2) },
    ]
}

fn directions() -> Vec<DVec3> {
    let direction = |i: usize| {
        let (sin, cos) = (i as f64 * 2.4).sin_cos();
        let z: f64 = 1.0 - (i as f64 + 0.5) / 40.0;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    };
    (0..40).map(direction).collect()
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1e-12)
}

#[test]
fn one_texel_is_its_lobe() {
    for lobe in lobes() {
        let footprint = Footprint::of_lobes(&[(lobe, 0.3)]);
        let mut queries = Queries::default();
        let view = DVec3::new(0.5, -0.3, 0.6).normalize();
        queries.start_view(view);
        directions().iter().for_each(|l| queries.push_light(*l));
        let lights = Diffuse::new(&directions());
        let means = footprint.means(&queries, &lights).swap_remove(0);
        let n = lobe.normal.as_dvec3().normalize();
        for (j, l) in directions().into_iter().enumerate() {
            let h = (view + l).normalize();
            // The lobe's own frame is in f32.
            assert!(close(means.d[j], lobe.d(h) / n.z, 1e-3), "{lobe:?} {} {}", means.d[j], lobe.d(h) / n.z);
            assert!(close(means.pdf[j], lobe.pdf(h), 1e-3));
            assert!(close(means.specular[j], lobe.specular(view, l), 1e-3), "{lobe:?} {l}");
            assert!(close(means.diffuse[j], n.dot(l).max(0.0), 1e-9));
            assert!(close(footprint.d(h), means.d[j], 1e-12));
            assert!(close(footprint.pdf(h), means.pdf[j], 1e-12));
        }
    }
}

/// A lobe in closed form, apart from all code here: `D = alpha^2 / (pi ((n.m)^2 (alpha^2 - 1) + 1)^2)`.
#[test]
fn two_facets_in_closed_form() {
    let (a, b) = (tilted(0.36, 0.0), tilted(-0.36, 0.1));
    let footprint =
        Footprint::of_lobes(&[(Lobe::isotropic(a, Alpha(0.2)), 3.0), (Lobe::isotropic(b, Alpha(0.4)), 1.0)]);
    let ggx = |n: Vec3, alpha: f64, m: DVec3| {
        let c = n.as_dvec3().normalize().dot(m);
        alpha * alpha / (PI * (c * c * (alpha * alpha - 1.0) + 1.0).powi(2))
    };
    for m in directions().into_iter().filter(|m| m.z > 0.5) {
        let (a_z, b_z) = (f64::from(a.z), f64::from(b.z));
        let expected = 0.75 * ggx(a, 0.2, m) / a_z + 0.25 * ggx(b, 0.4, m) / b_z;
        assert!(close(footprint.d(m), expected, 1e-5), "{} {expected}", footprint.d(m));
    }
}

/// Gaussian slopes and facets that are nearly mirrors: a Beckmann surface, `D = exp(-tan^2 / a^2) / (pi a^2 cos^4)`
/// with `a^2 = 2 sigma^2`. The slopes are quantiles of the radius, turned by the golden angle.
#[test]
fn gaussian_slopes_make_a_beckmann_surface() {
    const N: usize = 1 << 16;
    let sigma = 0.2f64;
    let lobe = |i: usize| {
        let (u, phi) = ((i as f64 + 0.5) / N as f64, 2.399_963_229_728_653 * i as f64);
        let radius = sigma * (-2.0 * (1.0 - u).ln()).sqrt();
        let normal = tilted((radius * phi.cos()) as f32, (radius * phi.sin()) as f32);
        (Lobe::isotropic(normal, Alpha(0.01)), 1.0)
    };
    let footprint = Footprint::of_lobes(&(0..N).map(lobe).collect::<Vec<_>>());
    for tan in [0.0f64, 0.1, 0.2, 0.35] {
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        let m = DVec3::new(0.6 * tan * cos, 0.8 * tan * cos, cos);
        let a2 = 2.0 * sigma * sigma;
        let expected = (-tan * tan / a2).exp() / (PI * a2 * cos.powi(4));
        assert!(close(footprint.d(m), expected, 0.02), "tan {tan}: {} {expected}", footprint.d(m));
    }
}

/// `integral of D (m.z) dm` over the lobe's own hemisphere, by the trapezium rule over its azimuth and the midpoint
/// rule over the share of facets; the mean of a footprint is linear in its lobes.
#[test]
fn normalised_within_a_millionth() {
    const RINGS: usize = 4000;
    const SPOKES: usize = 48;
    for lobe in lobes() {
        let footprint = Footprint::of_lobes(&[(lobe, 1.0)]);
        let n = lobe.normal.as_dvec3().normalize();
        let t = (DVec3::X - n * n.x).normalize();
        let b = n.cross(t);
        let [alpha_x, alpha_y] = [lobe.axes().alpha_x, lobe.axes().alpha_y].map(|a| f64::from(a.0));
        let (sin, cos) = f64::from(lobe.axes().angle).sin_cos();
        let mut normals = Vec::new();
        let mut areas = Vec::new();
        for i in 0..RINGS * SPOKES {
            // Slopes (radius tan) in the lobe's axes, u = r^2 / (1 + r^2): du = 2 r dr / (1 + r^2)^2.
            let (u, phi) = (((i % RINGS) as f64 + 0.5) / RINGS as f64, TAU * (i / RINGS) as f64 / SPOKES as f64);
            let r = (u / (1.0 - u)).sqrt();
            let (x, y) = (alpha_x * r * phi.cos(), alpha_y * r * phi.sin());
            let (sx, sy) = (cos * x - sin * y, sin * x + cos * y);
            let m = (n - sx * t - sy * b).normalize();
            // dm = cos^3 ds.
            let slope_area = alpha_x * alpha_y * (1.0 + r * r).powi(2) / 2.0 * TAU / (RINGS * SPOKES) as f64;
            areas.push(slope_area * m.dot(n).powi(3) * m.z);
            normals.push(m);
        }
        let total: f64 = footprint.density(&normals).iter().zip(&areas).map(|(d, area)| d * area).sum();
        assert!((total - 1.0).abs() < 1e-6, "{lobe:?}: {total}");
    }
    let all: Vec<_> = lobes().into_iter().zip([0.1, 0.2, 0.3, 0.4]).collect();
    let mixed = Footprint::of_lobes(&all).density(&directions());
    for (j, mixed) in mixed.into_iter().enumerate() {
        let sum: f64 = all.iter().map(|lobe| lobe.1 * Footprint::of_lobes(&[(lobe.0, 1.0)]).d(directions()[j])).sum();
        assert!(close(mixed, sum, 1e-12));
    }
}

#[test]
fn footprints_hold_the_texels_below_with_their_areas() {
    // 5 x 3 texels at level 1: 2 x 1, each 2.5 x 3 texels.
    let field = field(5, 3);
    let lobe = |x: usize, y: usize| {
        let i = y * 5 + x;
        Lobe::isotropic(field.normals[i], Alpha(field.perceptual[i] * field.perceptual[i]))
    };
    let expected: Vec<_> = (0..3).flat_map(|y| [(lobe(2, y), 0.5), (lobe(3, y), 1.0), (lobe(4, y), 1.0)]).collect();
    let texel = Footprint::of_texel(&field, Reading::default(), 1, 1, (1, 0));
    let list = Footprint::of_lobes(&expected);
    assert_eq!((texel.lobes(), list.lobes()), (9, 9));
    for m in directions() {
        assert!(close(texel.d(m), list.d(m), 1e-6));
    }
    assert!(texel.mean_normal().distance(list.mean_normal()) < 1e-6);
}

#[test]
fn unusable_normals_count_only_where_there_is_no_other() {
    let mut field = field(2, 2);
    field.normals[1] = Vec3::NEG_Z;
    let usable = [0, 2, 3].map(|i| (Lobe::isotropic(field.normals[i], Alpha(field.perceptual[i].powi(2))), 1.0));
    let texel = Footprint::of_texel(&field, Reading::default(), 1, 1, (0, 0));
    assert!(close(texel.d(DVec3::Z), Footprint::of_lobes(&usable).d(DVec3::Z), 1e-6));
    let drawn = (0..500).map(|i| texel.draw([(i as f64 + 0.5) / 500.0, 0.2, 1e-9, 0.0]));
    assert!(drawn.into_iter().all(|m| m.distance(DVec3::Z) > 1e-3), "the unusable normal was drawn");
    field.normals.fill(Vec3::NEG_Z);
    let flat = Footprint::of_texel(&field, Reading::default(), 1, 1, (0, 0));
    assert!(flat.mean_normal().distance(DVec3::Z) < 1e-9);
}

/// Pearson's chi-square of `draw` against `pdf` on cells of the projected disk, one percent point by Wilson-Hilferty.
#[test]
fn samples_follow_the_density() {
    const SIDE: usize = 16;
    const FINE: usize = 80;
    const DRAWS: usize = 40_000;
    let field = field(7, 5);
    let texel = Footprint::of_texel(&field, Reading::default(), 1, 1, (1, 1));
    let mut holed = self::field(6, 2);
    holed.normals[1..5].fill(Vec3::NEG_Z);
    holed.normals[7..9].fill(Vec3::NEG_Z);
    let holes = Footprint::of_texel(&holed, Reading::default(), 1, 2, (0, 0));
    let bilinear = Interpolation::Bilinear { per_side: 2, wrap: Wrap::Clamp };
    let filtered = Footprint::of_texel(&holed, Reading { interpolation: bilinear, ..Reading::default() }, 1, 2, (0, 0));
    let mixed: Vec<_> = lobes().into_iter().zip([0.1, 0.2, 0.3, 0.4]).collect();
    let list = Footprint::of_lobes(&mixed[..3]);
    for footprint in [&texel, &list, &holes, &filtered] {
        // Strips of x and of y, both hemispheres together: facets may lean beyond the horizon.
        let cell_of = |m: DVec3| {
            let place = |v: f64| ((v.clamp(-1.0, 1.0).asin() / PI + 0.5) * SIDE as f64).min(SIDE as f64 - 1.0) as usize;
            place(m.x) * SIDE + place(m.y)
        };
        let mut queries = Queries::default();
        queries.start_view(DVec3::Z);
        let mut areas = Vec::new();
        let n = SIDE * FINE;
        for i in 0..n * n {
            // Equal areas of the sphere: z and azimuth.
            let (z, phi) = (2.0 * ((i % n) as f64 + 0.5) / n as f64 - 1.0, TAU * ((i / n) as f64 + 0.5) / n as f64);
            let r = (1.0 - z * z).sqrt();
            queries.push_half(DVec3::new(r * phi.cos(), r * phi.sin(), z));
            areas.push(2.0 * TAU / (n * n) as f64);
        }
        let means = footprint.means(&queries, &Diffuse::default()).swap_remove(0);
        let mut expected = vec![0.0; SIDE * SIDE];
        for (j, area) in areas.iter().enumerate() {
            expected[cell_of(queries.half(j))] += means.pdf[j] * area * DRAWS as f64;
        }
        let mut observed = vec![0.0; SIDE * SIDE];
        let mut random = Random::new(3, 1);
        for _ in 0..DRAWS {
            let u = std::array::from_fn(|_| random.uniform());
            observed[cell_of(footprint.draw(u))] += 1.0;
        }
        let (mut chi2, mut cells, mut rest) = (0.0, 0.0, (0.0, 0.0));
        for (e, o) in expected.iter().zip(&observed) {
            if *e >= 8.0 {
                chi2 += (o - e).powi(2) / e;
                cells += 1.0;
            } else {
                rest = (rest.0 + e, rest.1 + o);
            }
        }
        chi2 += (rest.1 - rest.0).powi(2) / rest.0.max(1.0);
        let k: f64 = cells;
        let limit = k * (1.0 - 2.0 / (9.0 * k) + 2.33 * (2.0 / (9.0 * k)).sqrt()).powi(3);
        assert!(k > 30.0 && chi2 < limit, "chi-square {chi2} over {limit} with {k} degrees of freedom");
    }
}

#[test]
fn grid_draws_and_direct_evaluation_agree() {
    let field = field(8, 8);
    let footprint = Footprint::of_texel(&field, Reading::default(), 1, 2, (1, 0));
    // The mean of (m.x)^2 over the facets, seen from above.
    const N: usize = 600;
    let disk = footprint.disk((0.0, 0.0), 1.0, N);
    let cell = (2.0 / N as f64).powi(2);
    let x = |i: usize| (2 * i + 1) as f64 / N as f64 - 1.0;
    let total: f64 = disk.iter().sum::<f64>() * cell;
    let by_grid: f64 = disk.indexed_iter().map(|((_, i), d)| d * x(i).powi(2)).sum::<f64>() * cell;
    // The rest leans beyond the horizon.
    assert!((total - 1.0).abs() < 0.02, "{total}");
    let (row, column) = (N / 4, N / 3);
    let (mx, my) = (x(column), -x(row));
    assert_eq!(disk[(row, column)], footprint.d(DVec3::new(mx, my, (1.0 - mx * mx - my * my).sqrt())));
    // A window is a part of the whole.
    let window = footprint.disk((x(column), -x(row)), 1.0 / N as f64, 1);
    assert!(close(window[(0, 0)], disk[(row, column)], 1e-9));

    let mut random = Random::new(7, 7);
    let mut queries = Queries::default();
    queries.start_view(DVec3::Z);
    (0..40_000).for_each(|_| queries.push_half(footprint.draw(std::array::from_fn(|_| random.uniform()))));
    let means = footprint.means(&queries, &Diffuse::default()).swap_remove(0);
    let weight = |j: usize| means.d[j] * queries.half(j).z.max(0.0) / means.pdf[j];
    let by_draws: f64 =
        (0..queries.len()).map(|j| weight(j) * queries.half(j).x.powi(2)).sum::<f64>() / queries.len() as f64;
    assert!(close(by_draws, by_grid, 0.02), "{by_draws} {by_grid}");
}

/// Under a white sky every lobe reflects its albedo; a footprint the mean of its texels', light from below left out.
#[test]
fn white_furnace_gives_the_mean_albedo() {
    const N: usize = 700;
    let view = DVec3::new(0.4, 0.2, 0.9).normalize();
    let mut queries = Queries::default();
    queries.start_view(view);
    for i in 0..N * N {
        let (z, phi) = (((i % N) as f64 + 0.5) / N as f64, TAU * ((i / N) as f64 + 0.5) / N as f64);
        let r = (1.0 - z * z).sqrt();
        queries.push_light(DVec3::new(r * phi.cos(), r * phi.sin(), z));
    }
    let lobe = |x, y, a| Lobe::isotropic(tilted(x, y), Alpha(a));
    let lobes = [(lobe(0.0, 0.0, 0.3), 1.0), (lobe(0.1, -0.05, 0.6), 2.0), (lobe(-0.1, 0.1, 0.2), 1.0)];
    let means = Footprint::of_lobes(&lobes).means(&queries, &Diffuse::default()).swap_remove(0);
    let area = TAU / (N * N) as f64;
    let found = means.specular.iter().sum::<f64>() * area;
    let albedo = |lobe: &Lobe| {
        let cos = lobe.normal.as_dvec3().dot(view);
        directional_albedo(cos, lobe.axes().alpha_x)
    };
    let expected: f64 = lobes.iter().map(|(lobe, w)| 0.25 * w * albedo(lobe)).sum();
    assert!((found - expected).abs() < 0.01 && found <= expected + 1e-3, "{found} {expected}");
    // Compensated, everything comes back but what goes below.
    let compensated = means.compensated.iter().sum::<f64>() * area;
    assert!(compensated > 0.98 && compensated < 1.01, "{compensated}");
}
