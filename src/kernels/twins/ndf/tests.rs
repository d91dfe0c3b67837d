//! Laws of the twins: what the distributions and Smith's functions must integrate to.

use super::super::moments::erfc;
use super::*;

/// Slopes that cover the plane: a grid of `n^2` points (u, angle) of the round GGX lobe of unit width, stretched by a
/// tensor and about a centre, and the area of each. u is bent towards the far end, for heavier tails.
fn plane(n: usize, centre: DVec2, r: DVec3) -> impl Iterator<Item = (DVec2, f64)> {
    let l11 = r.x.sqrt();
    let (l21, det) = (r.y / l11, (r.x * r.z - r.y * r.y).sqrt());
    (0..n * n).map(move |i| {
        let w = ((i / n) as f64 + 0.5) / n as f64;
        let rest = (1.0 - w).powi(4);
        let (u, du) = (1.0 - rest, 4.0 * (1.0 - w).powi(3) / n as f64);
        let (sin, cos) = (TAU * ((i % n) as f64 + 0.5) / n as f64).sin_cos();
        let radius = (u / rest).sqrt();
        let s = DVec2::new(l11 * radius * cos, l21 * radius * cos + det / l11 * radius * sin);
        // r^2 = u / (1 - u), and r dr = du / (2 (1 - u)^2).
        (centre + s, det * 0.5 * du / (rest * rest) * TAU / n as f64)
    })
}

/// The normal with this slope, and how much the area of slopes is in steradians of it.
fn normal(s: DVec2) -> (DVec3, f64) {
    let m = (-s).extend(1.0).normalize();
    (m, m.z.powi(3))
}

/// Widths from 0.02 to 0.9, ratios to 1 in 10, any angle; tilts to 55 degrees; two directions.
struct Draw(u64);

impl Draw {
    /// Lehmer's generator of Park & Miller 1988: enough to pick examples.
    fn unit(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        self.0 as f64 / 2_147_483_647.0
    }

    fn tensor(&mut self) -> DVec3 {
        let a = 0.02 + 0.88 * self.unit();
        let (x2, y2) = (a * a, (a * (0.1 + 0.9 * self.unit())).powi(2));
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        DVec3::new(x2 * cos * cos + y2 * sin * sin, (x2 - y2) * sin * cos, x2 * sin * sin + y2 * cos * cos)
    }

    fn direction(&mut self, steepest: f64) -> DVec3 {
        let (z, (sin, cos)) = (1.0 - (1.0 - steepest) * self.unit(), (TAU * self.unit()).sin_cos());
        let p = (1.0 - z * z).sqrt();
        DVec3::new(p * cos, p * sin, z)
    }
}

#[test]
fn densities_integrate_to_one() {
    let mut draw = Draw(1);
    for _ in 0..12 {
        let r = draw.tensor();
        let sums = plane(240, DVec2::ZERO, r).fold([0.0; 8], |mut sums, (s, area)| {
            let (m, steradians) = normal(s);
            let densities = [
                p22_ggx(s, r),
                p22_beckmann(s, r),
                p22_student(s, r, 1.5),
                p22_student(s, r, 4.0),
                d_ggx_tensor(m, r) * m.z * steradians,
                d_beckmann(m, r) * m.z * steradians,
                d_student(m, r, 1.6) * m.z * steradians,
                d_student(m, r, 8.0) * m.z * steradians,
            ];
            for (sum, density) in sums.iter_mut().zip(densities) {
                *sum += density * area;
            }
            sums
        });
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-4), "{r:?} {sums:?}");
    }
}

#[test]
fn forms_of_ggx_agree() {
    let mut draw = Draw(2);
    for _ in 0..300 {
        let (n, m, alpha) = (draw.direction(0.0), draw.direction(0.0), 0.001 + draw.unit());
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        let d = d_ggx_tangent(m, alpha);
        close(d_ggx(m.z, alpha), d);
        close(d_ggx_tensor(m, DVec3::new(alpha * alpha, 0.0, alpha * alpha)), d);
        close(d_ggx_cross(DVec3::Z, m, alpha), d);
        if n.dot(m) > 0.0 {
            close(d_ggx_cross(n, m, alpha), d_ggx(n.dot(m), alpha));
        }
        // As written by Walter et al. 2007.
        let (cos2, tan2) = (m.z * m.z, 1.0 / (m.z * m.z) - 1.0);
        close(d, alpha * alpha / (PI * cos2 * cos2 * (alpha * alpha + tan2).powi(2)));
        let (ax, ay) = (alpha, 0.3 * alpha);
        close(d_ggx_aniso(m, ax, ay), d_ggx_tensor(m, DVec3::new(ax * ax, 0.0, ay * ay)));
        let (s, r) = (DVec2::new(m.x, m.y) / m.z, draw.tensor());
        close(p22_student(s, r, 2.0), p22_ggx(s, r));
        assert!((p22_student(s, r, 1e7) - p22_beckmann(s, r)).abs() < 1e-5 * p22_beckmann(DVec2::ZERO, r));
    }
}

#[test]
fn cosines_forget_small_angles() {
    assert_eq!(2e-4f64.cos() as f32, 1.0);
    let change = |alpha: f64| {
        let angles = (1..400).map(|i| 0.01 * f64::from(i) * alpha);
        let of =
            |t: f64| d_ggx(f64::from(t.cos() as f32), alpha) / d_ggx_tangent(DVec3::new(t.sin(), 0.0, t.cos()), alpha);
        angles.map(|t| (of(t) - 1.0).abs()).fold(0.0, f64::max)
    };
    assert!(change(0.01) < 0.0013 && change(0.001) > 0.05);
}

#[test]
fn a_slope_lobe_is_the_tilted_lobe() {
    let mut draw = Draw(3);
    for i in 0..2000 {
        let (n, m, mut r) = (draw.direction(0.15), draw.direction(0.0), draw.tensor());
        if i % 4 == 0 {
            r = DVec3::new(r.x, 0.0, r.x);
            assert!((slope_lobe_round(n, r.x.sqrt()).centre - slope_lobe(n, r).centre).length() < 1e-14);
        }
        if n.dot(m) <= 0.0 {
            continue;
        }
        let (t, b) = bent(n);
        let own = d_ggx_tensor(DVec3::new(m.dot(t), m.dot(b), m.dot(n)), r);
        let tilted = d_slope_lobe(m, slope_lobe(n, r)) * ellipsoid(n, r).z_axis.z.sqrt();
        assert!((tilted / own - 1.0).abs() < 1e-9, "{n:?} {r:?} {tilted} {own}");
    }
}

#[test]
fn round_lobes_come_back() {
    let mut draw = Draw(4);
    for _ in 0..500 {
        let (normal, alpha) = (draw.direction(0.05), 0.002 + 0.95 * draw.unit());
        let back = round_lobe(slope_lobe_round(normal, alpha));
        assert!((back.normal - normal).length() < 1e-8 && (back.alpha - alpha).abs() < 1e-9, "{normal:?} {back:?}");
    }
    // Of two widths, along and across the tilt: the normal, and the geometric mean.
    let n = DVec3::new(0.6, 0.0, 0.8);
    let back = round_lobe(slope_lobe(n, DVec3::new(0.09, 0.0, 0.01)));
    assert!((back.normal - n).length() < 1e-12 && (back.alpha - 0.03f64.sqrt()).abs() < 1e-12);
}

/// `integral D max(0, v . m) = v.z / G1` (Heitz 2014), which Smith's functions follow from; for tilted lobes about the
/// mean plane.
#[test]
fn visible_areas() {
    let mut draw = Draw(5);
    for _ in 0..10 {
        let (v, r, n) = (draw.direction(0.02), draw.tensor(), draw.direction(0.5));
        let lobe = slope_lobe(n, r);
        let seen = |s: DVec2| (v.z - s.dot(v.truncate())).max(0.0);
        let ggx: f64 = plane(250, DVec2::ZERO, r).map(|(s, area)| p22_ggx(s, r) * seen(s) * area).sum();
        let beckmann: f64 = plane(250, DVec2::ZERO, r).map(|(s, area)| p22_beckmann(s, r) * seen(s) * area).sum();
        let tilted: f64 =
            plane(250, lobe.centre, lobe.scatter).map(|(s, area)| p22_slope_lobe(s, lobe) * seen(s) * area).sum();
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-3, "{a} {b} {v:?} {r:?}");
        close(ggx, v.z / g1(lambda_ggx(v, r)));
        close(beckmann, v.z / g1(lambda_beckmann(v, r)));
        close(tilted, sigma_slope_lobe(v, lobe));
        let c = mean_cosine(v, lobe);
        if c > 0.0 {
            close(g1_slope_lobe(v, lobe), c / tilted);
        }
    }
}

/// The weak white furnace (Heitz 2014, sec. 5.5): without shadowing, all light comes back,
/// `integral D G1 / (4 n.v) dl = 1` over the sphere of l. About the mean plane for tilted lobes.
#[test]
fn weak_white_furnace() {
    let mut draw = Draw(6);
    for _ in 0..6 {
        let (v, r, n) = (draw.direction(0.1), draw.tensor(), draw.direction(0.9));
        let lobe = slope_lobe(n, r);
        // dl = 4 (v . m) dm.
        let sum = |centre: DVec2, scatter: DVec3, reflected: &dyn Fn(DVec3) -> f64| -> f64 {
            let light = |(s, area): (DVec2, f64)| {
                let (m, steradians) = normal(s);
                reflected(m) * 4.0 * v.dot(m).max(0.0) * steradians * area
            };
            plane(250, centre, scatter).map(light).sum()
        };
        let upright = sum(DVec2::ZERO, r, &|m| d_ggx_tensor(m, r) * g1(lambda_ggx(v, r)) / (4.0 * v.z));
        assert!((upright - 1.0).abs() < 1e-3, "{upright}");
        let beckmann = sum(DVec2::ZERO, r, &|m| d_beckmann(m, r) * g1(lambda_beckmann(v, r)) / (4.0 * v.z));
        assert!((beckmann - 1.0).abs() < 1e-3, "{beckmann}");
        let c = mean_cosine(v, lobe);
        if c > 0.05 {
            let tilted =
                sum(lobe.centre, lobe.scatter, &|m| d_slope_lobe(m, lobe) * g1_slope_lobe(v, lobe) / (4.0 * c));
            assert!((tilted - 1.0).abs() < 1e-3, "{tilted}");
        }
    }
}

#[test]
fn masking_is_a_share_and_symmetric() {
    let mut draw = Draw(7);
    let mut above_one = 0;
    for _ in 0..2000 {
        let (l, v, r) = (draw.direction(0.001), draw.direction(0.001), draw.tensor());
        let g = g2(lambda_ggx(v, r), lambda_ggx(l, r));
        let one = g1(lambda_ggx(v, r)).min(g1(lambda_ggx(l, r)));
        assert!(g > 0.0 && g <= one && one <= 1.0);
        let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * a, "{a} {b}");
        same(v_smith_ggx_tensor(l, v, r), v_smith_ggx_tensor(v, l, r));
        same(v_smith_ggx_tensor(l, v, r) * 4.0 * l.z * v.z, g);
        let lobe = slope_lobe(draw.direction(0.5), r);
        same(v_smith_slope_lobe(l, v, lobe), v_smith_slope_lobe(v, l, lobe));
        let (cl, cv) = (mean_cosine(l, lobe), mean_cosine(v, lobe));
        if cl > 0.0 && cv > 0.0 {
            let g = v_smith_slope_lobe(l, v, lobe) * 4.0 * cl * cv;
            assert!((0.0..=1.0 + 1e-12).contains(&g) && g1_slope_lobe(v, lobe) <= 1.0);
            above_one += usize::from(v.z / sigma_slope_lobe(v, lobe) > 1.0);
        }
    }
    assert!(above_one > 100, "v.z / sigma is no share: {above_one}");
}

#[test]
fn fits_are_as_good_as_stated() {
    let fitted = |x: f64| {
        let t = 1.0 / (1.0 + 0.55 * x);
        let high = 0.13861866 + t * (0.17717712 + t * (-0.30184911 + t * 0.098847289));
        t * (0.31030417 + t * (0.31018776 + t * (0.26671837 + t * high)))
    };
    for i in 0..4000 {
        let a = 1e-4 * 1.004f64.powi(i);
        assert!((fitted(a) / erfc_scaled(a) - 1.0).abs() < 5e-6, "{a}");
        let exact = 0.5 * (-a * a).exp() * (1.0 / (a * PI.sqrt()) - erfc_scaled(a));
        let lambda = (-a * a).exp() * (0.28209479 / a - 0.5 * fitted(a));
        assert!((lambda - exact).abs() < 3e-6 * (1.0 + exact), "{a} {lambda} {exact}");
        let walter = if a < 1.6 { (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) } else { 0.0 };
        assert!((g1(walter) / g1(exact) - 1.0).abs() < 0.004);
        let x = 0.5 * a.min(1.0);
        let y = x / (2.0 + x);
        let series = 2.0 * y * (1.0 + y.powi(2) / 3.0 + y.powi(4) / 5.0 + y.powi(6) / 7.0 + y.powi(8) / 9.0);
        assert!((series / x.ln_1p() - 1.0).abs() < 1e-8);
    }
    assert!((erfc_scaled(2.6) / (2.6f64.powi(2).exp() * erfc(2.6)) - 1.0).abs() < 1e-12);
}

/// Whether counts of samples in cells of slopes fit the integral of the density: Pearson's test at a significance of 1e-4,
/// with a fixed seed. Cells are in the angle, and in `w = 1 - (1 + r^2)^(-1/2)` of the radius r of the slopes, stretched back.
fn chi_squared(r: [f64; 2], sample: impl Fn(DVec2) -> DVec3, pdf: impl Fn(DVec3) -> f64) -> bool {
    const CELLS: usize = 8;
    const FINE: usize = 24;
    const SAMPLES: usize = 300_000;
    let mut draw = Draw(8);
    let mut counts = vec![0.0; CELLS * CELLS];
    for _ in 0..SAMPLES {
        let m = sample(DVec2::new(draw.unit(), draw.unit()));
        assert!((m.length() - 1.0).abs() < 1e-12 && m.z >= 0.0);
        let s = DVec2::new(m.x / r[0], m.y / r[1]) / m.z.max(1e-300);
        let w = 1.0 - 1.0 / (1.0 + s.length_squared()).sqrt();
        let turns = (s.y.atan2(s.x) / TAU).rem_euclid(1.0);
        let cell = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
        counts[cell(w) * CELLS + cell(turns)] += 1.0;
    }
    let n = CELLS * FINE;
    let mut expected = vec![0.0; CELLS * CELLS];
    for i in 0..n * n {
        let (rest, turns) = (1.0 - ((i / n) as f64 + 0.5) / n as f64, ((i % n) as f64 + 0.5) / n as f64);
        let (sin, cos) = (TAU * turns).sin_cos();
        let s = -DVec2::new(r[0] * cos, r[1] * sin) * ((1.0 - rest * rest) / (rest * rest)).sqrt();
        let (m, steradians) = normal(s);
        // r dr = dw / (1 - w)^3.
        let area = r[0] * r[1] * TAU / rest.powi(3) / (n * n) as f64;
        expected[(i / n / FINE) * CELLS + i % n / FINE] += pdf(m) * steradians * area * SAMPLES as f64;
    }
    assert!((expected.iter().sum::<f64>() / SAMPLES as f64 - 1.0).abs() < 1e-3);
    // Cells that hold too few are taken together.
    let (mut rest, mut statistic, mut degrees) = ([0.0; 2], 0.0, 0.0);
    for (count, expected) in counts.into_iter().zip(expected) {
        if expected < 20.0 {
            rest = [rest[0] + count, rest[1] + expected];
        } else {
            statistic += (count - expected).powi(2) / expected;
            degrees += 1.0;
        }
    }
    if rest[1] > 5.0 {
        statistic += (rest[0] - rest[1]).powi(2) / rest[1];
    } else {
        degrees -= 1.0;
    }
    // Wilson & Hilferty 1931, at 3.719 standard deviations.
    let k = 2.0 / (9.0 * degrees);
    statistic < degrees * (1.0 - k + 3.719 * f64::sqrt(k)).powi(3)
}

#[test]
fn samples_follow_their_densities() {
    for [ax, ay] in [[0.5, 0.5], [0.02, 0.3], [1.0, 0.4]] {
        assert!(chi_squared([ax, ay], |u| sample_ggx(u, ax, ay), |m| pdf_ggx(m, ax, ay)));
        for (x, y) in [(0.0, 0.0), (0.5, -0.4), (0.7, 0.713), (-1.0, 0.0)] {
            let v = DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()).normalize();
            let sample = |u| sample_ggx_visible(u, v, ax, ay);
            assert!(chi_squared([ax, ay], sample, |m| pdf_ggx_visible(m, v, ax, ay)), "{v} {ax} {ay}");
        }
    }
    // One that is off by 5 percent in one width is found out.
    assert!(!chi_squared([0.5, 0.5], |u| sample_ggx(u, 0.525, 0.5), |m| pdf_ggx(m, 0.5, 0.5)));
}

#[test]
fn the_visible_density_is_heitzs() {
    let mut draw = Draw(9);
    for _ in 0..300 {
        let (v, m) = (draw.direction(0.001), draw.direction(0.0));
        let (ax, ay) = (0.01 + draw.unit(), 0.01 + draw.unit());
        let expected = g1(lambda_ggx_aniso(v, ax, ay)) * v.dot(m).max(0.0) * d_ggx_aniso(m, ax, ay) / v.z;
        assert!((pdf_ggx_visible(m, v, ax, ay) - expected).abs() <= 1e-12 * expected);
    }
}
