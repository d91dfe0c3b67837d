use glam::DQuat;

use super::super::draw;
use super::*;

struct Random(u64);

impl Random {
    /// -1 to 1.
    fn next(&mut self) -> f64 {
        draw(&mut self.0)
    }

    /// 0 to 1.
    fn unit(&mut self) -> f64 {
        0.5 + 0.5 * self.next()
    }

    fn normal(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), 1.2 + self.next()).normalize()
    }

    fn tensor(&mut self) -> DVec3 {
        decode_axes_signed(0.01 + self.unit(), 0.01 + self.unit(), 3.0 * self.next())
    }

    fn moments(&mut self) -> Moments {
        Moments { mean: DVec2::new(self.next(), self.next()), covariance: 0.3 * self.tensor() }
    }
}

fn close(a: DVec3, b: DVec3, by: f64) {
    assert!((a - b).length() < by, "{a} {b}");
}

#[test]
fn normals_come_back_from_every_form() {
    let mut random = Random(1);
    for _ in 0..300 {
        let (n, scale) = (random.normal(), 0.3 + random.unit());
        for y_sign in [1.0, -1.0] {
            // As `build` writes: divided by the scale, to unit length, in the map's convention.
            let stored = DVec3::new(n.x / scale, n.y / scale * y_sign, n.z).normalize();
            close(decode_normal_signed(stored, y_sign, scale), n, 1e-14);
            close(decode_normal(0.5 + 0.5 * stored, y_sign, scale), n, 1e-14);
            close(decode_normal_xy(0.5 + 0.5 * stored.truncate(), y_sign, scale), n, 1e-12);
            let texel = DVec4::new(0.5 + 0.5 * stored.x, 0.5 + 0.5 * stored.y, 0.25, 0.5);
            let lobe = decode_lobe(texel, y_sign, scale);
            close(lobe.normal, n, 1e-12);
            assert!(lobe.weight == 0.25 && lobe.tensor == DVec3::new(0.0625, 0.0, 0.0625));
        }
    }
    assert_eq!(decode_normal_signed(DVec3::ZERO, 1.0, 1.0), DVec3::Z);
    assert_eq!(decode_normal(DVec3::splat(0.5), 1.0, 1.0), DVec3::Z);
    assert_eq!(first_weight(DVec3::new(0.5, 0.25, 0.0)), 0.25);
}

/// 128, the mid-gray of 8 bits, is 0.004 off the middle: no direction, whatever the scale. 0.1 is the limit.
#[test]
fn mid_gray_has_no_direction() {
    let gray = 128.0 / 255.0;
    for scale in [0.2, 1.0, 20.0] {
        for y_sign in [1.0, -1.0] {
            assert_eq!(decode_normal(DVec3::splat(gray), y_sign, scale), DVec3::Z);
            assert_eq!(decode_normal_signed(DVec3::new(0.0, 0.099, 0.0), y_sign, scale), DVec3::Z);
            assert_eq!(decode_normal_signed(DVec3::new(0.0, 0.101, 0.0), y_sign, scale), y_sign * DVec3::Y);
        }
    }
    let along_x = decode_anisotropy(DVec3::new(1.0, 0.5, 0.7), 0.5);
    assert_eq!(decode_anisotropy(DVec3::new(gray, gray, 0.7), 0.5), along_x);
    assert_eq!(decode_anisotropy(DVec3::new(0.5, 0.5 + 0.0495, 0.7), 0.5), along_x);
    assert!(decode_anisotropy(DVec3::new(0.5, 0.5 + 0.0505, 0.7), 0.5).z > along_x.z);
    // Means of normals keep their direction however short they are.
    close(lobe_toksvig(DVec3::new(0.03, 0.0, 0.04), 0.3).normal, DVec3::new(0.6, 0.0, 0.8), 1e-14);
}

/// Widths 0.05 to 1 along an angle, encoded by the formulas of the README, decoded by each function.
#[test]
fn tensors_come_back_from_every_form() {
    let mut random = Random(2);
    for _ in 0..300 {
        let (along, angle) = (0.05 + 0.95 * random.unit(), 1.57 * random.next());
        let across = along * (0.1 + 0.9 * random.unit());
        let turn = DMat2::from_angle(angle);
        let diagonal = |x: f64, y: f64| turn * DMat2::from_diagonal(DVec2::new(x, y)) * turn.transpose();
        let truth = tensor(diagonal(along * along, across * across));
        let turns = (angle / TAU).rem_euclid(1.0);
        let d = DVec2::from_angle(angle);
        close(decode_axes_signed(along, across, angle), truth, 1e-14);
        close(decode_axes(DVec3::new(along.sqrt(), across.sqrt(), turns)), truth, 1e-14);
        let burley = DVec3::new((along * across).sqrt().sqrt(), (1.0 - across / along) / 0.9, turns);
        close(decode_burley(burley), truth, 1e-13);
        let s = diagonal(along, across);
        let root = DVec3::new(s.x_axis.x, s.y_axis.y, s.x_axis.y);
        close(decode_tensor_root_signed(root), truth, 1e-14);
        close(decode_tensor_root(DVec3::new(root.x, root.y, (128.0 + 254.0 * root.z) / 255.0)), truth, 1e-14);
        let strength = ((along - across) / (1.0 - across)).max(0.0).sqrt();
        let texel = (0.5 + 0.5 * d).extend(strength);
        close(decode_anisotropy(texel, across.sqrt()), truth, 1e-13);
        close(decode_anisotropy((0.5 - 0.5 * d).extend(strength), across.sqrt()), truth, 1e-13);
    }
    close(decode_gloss(0.75), decode_roughness(0.25), 1e-15);
    close(decode_anisotropy(DVec3::new(0.5, 0.5, 1.0), 0.5), DVec3::new(1.0, 0.0, 0.0625), 1e-15);
    assert_eq!(decode_energy(102.0 / 255.0), 1.0);
}

/// Unit normals leave the base as it is; a mean of length 0.8 adds 2 V with V = 1/4 to alpha^2 / (1 - alpha^2) = 1/9.
#[test]
fn short_normals_widen_the_lobe() {
    let n = DVec3::new(0.0, 0.6, 0.8);
    for lobe in [lobe_toksvig(n, 0.3), lobe_vmf(n, 0.3)] {
        close(lobe.normal, n, 1e-15);
        assert!((lobe.tensor.x - 0.09).abs() < 1e-7 && lobe.tensor.y == 0.0);
    }
    assert!((lobe_toksvig(0.8 * n, 0.1f64.sqrt()).tensor.x - 11.0 / 29.0).abs() < 1e-12);
    assert!((lobe_vmf(0.99 * n, 0.1).tensor.x - 0.03).abs() < 1e-4, "2 / kappa is 2 (1 - r)");
}

#[test]
fn moments_come_back_from_samples() {
    let mut random = Random(3);
    let slopes: Vec<DVec2> = (0..100).map(|_| DVec2::new(0.3 + random.next(), 0.2 * random.next())).collect();
    let mean = |f: &dyn Fn(DVec2) -> f64| slopes.iter().map(|s| f(*s)).sum::<f64>() / slopes.len() as f64;
    let m = DVec2::new(mean(&|s| s.x), mean(&|s| s.y));
    let of = |f: &dyn Fn(DVec2) -> f64| mean(&|s| f(s - m));
    for y_sign in [1.0, -1.0] {
        let raw = DVec3::new(mean(&|s| s.x * s.x), mean(&|s| s.y * s.y), mean(&|s| s.x * s.y * y_sign));
        let found = decode_moments(DVec2::new(m.x, y_sign * m.y), raw, y_sign);
        assert!((found.mean - m).length() < 1e-14);
        close(found.covariance, DVec3::new(of(&|s| s.x * s.x), of(&|s| s.x * s.y), of(&|s| s.y * s.y)), 1e-14);
    }
    // Halves of the samples, blended.
    let part = |range: std::ops::Range<usize>| {
        let count = range.len() as f64;
        let sum = slopes[range.clone()]
            .iter()
            .fold((DVec2::ZERO, DVec3::ZERO), |(m, r), s| (m + *s, r + DVec3::new(s.x * s.x, s.y * s.y, s.x * s.y)));
        decode_moments(sum.0 / count, sum.1 / count, 1.0)
    };
    let blend = moments_blend(part(0..70), part(70..100), 0.3);
    close(blend.covariance, part(0..100).covariance, 1e-14);
    close(tensor_positive(DVec3::new(-1.0, 0.0, 2.0)), DVec3::new(0.0, 0.0, 2.0), 1e-15);
}

/// `J = cos (I - cos^2 / (1 + cos) s s^T)` in the frame carried by the smallest rotation: another way to the same tensor.
#[test]
fn the_lobe_of_moments_is_seen_from_its_own_plane() {
    let mut random = Random(4);
    for _ in 0..300 {
        let (m, base) = (random.moments(), 0.1 * random.tensor());
        let lobe = lobe_from_moments(m, base);
        let (s, cos) = (m.mean, lobe.normal.z);
        let j = cos * (DMat2::IDENTITY - DMat2::from_cols(s * s.x, s * s.y) * (cos * cos / (1.0 + cos)));
        let carried = DQuat::from_rotation_arc(DVec3::Z, lobe.normal);
        let (t, b) = bent(lobe.normal);
        let (t0, b0) = (carried * DVec3::X, carried * DVec3::Y);
        let change = DMat2::from_cols(DVec2::new(t0.dot(t), t0.dot(b)), DVec2::new(b0.dot(t), b0.dot(b)));
        let local = change * j * matrix(m.covariance) * j.transpose() * change.transpose();
        close(lobe.tensor, base + 2.0 * tensor(local), 1e-12);
        // And back, the base in it.
        let back = moments_from_lobe(Lobe { tensor: lobe.tensor - base, ..lobe });
        assert!((back.mean - m.mean).length() < 1e-12);
        close(back.covariance, m.covariance, 1e-11);
    }
    // Slope (1, 0): cos^4 = 1/4 along the tilt, cos^2 = 1/2 across it.
    let tilted = Moments { mean: DVec2::X, covariance: DVec3::new(0.4, 0.0, 0.2) };
    close(lobe_from_moments(tilted, DVec3::ZERO).tensor, DVec3::new(0.2, 0.0, 0.2), 1e-15);
    let flat = Moments { mean: DVec2::ZERO, covariance: DVec3::ZERO };
    let base = decode_roughness(0.3);
    assert_eq!(lobe_from_moments(flat, base), Lobe { normal: DVec3::Z, tensor: base });
}

#[test]
fn turning_the_texture_turns_moments() {
    let mut random = Random(5);
    for _ in 0..100 {
        let (m, angle, v) = (random.moments(), 3.0 * random.next(), random.normal());
        let turn = DMat2::from_angle(angle);
        let rows = turn.transpose();
        let rotate = |m: Moments| moments_transform(m, rows.x_axis, rows.y_axis);
        let turned = rotate(m);
        assert!((turned.mean - turn * m.mean).length() < 1e-14);
        let spun = glam::DMat3::from_rotation_z(angle) * v;
        assert!((slope_cosine(m, v) - slope_cosine(turned, spun)).abs() < 1e-13);
        let (a, b) = (rotate(visible_moments(m, v)), visible_moments(turned, spun));
        assert!((a.mean - b.mean).length() < 1e-12);
        close(a.covariance, b.covariance, 1e-12);
        // Twice the strength is four times the variance.
        let strong = moments_transform(m, 2.0 * DVec2::X, 2.0 * DVec2::Y);
        close(strong.covariance, 4.0 * m.covariance, 1e-14);
        let sum = moments_add(m, turned);
        close(sum.covariance, m.covariance + turned.covariance, 1e-14);
    }
}

#[test]
fn the_normal_distribution_meets_known_values() {
    for (x, stated) in
        [(0.0, 0.5), (1.0, 0.841_344_746_068_542_9), (-2.0, 0.022_750_131_948_179_21), (4.0, 0.999_968_328_758_166_9)]
    {
        assert!((gaussian_cdf(x) / stated - 1.0).abs() < 1e-14);
    }
    assert!((gaussian_cdf(-6.0) / 9.865_876_450_376_98e-10 - 1.0).abs() < 1e-12);
    assert!((erfc(2.5 - 1e-9) / erfc(2.5 + 1e-9) - 1.0).abs() < 2e-8);
    assert!((gaussian_pdf(1.0) - 0.241_970_724_519_143_37).abs() < 1e-15);
}

/// Against quadrature over the slopes: from above, at a slant, and near the horizon of the mean plane.
#[test]
fn visible_moments_are_those_of_the_weighted_slopes() {
    let m = Moments { mean: DVec2::new(0.2, -0.1), covariance: DVec3::new(0.09, 0.02, 0.04) };
    // Cholesky factor of the covariance.
    let (xx, yx) = (0.3, 0.02 / 0.3);
    let yy = (0.04f64 - yx * yx).sqrt();
    for degrees in [0.0, 40.0, 70.0, 85.0f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let v = DVec3::new(-0.8 * sin, 0.6 * sin, cos);
        const STEPS: i32 = 800;
        let (mut area, mut sum, mut mean, mut square) = (0.0, 0.0, DVec2::ZERO, DVec3::ZERO);
        for i in 0..STEPS * STEPS {
            let at = |i: i32| 14.0 * (f64::from(i) + 0.5) / f64::from(STEPS) - 7.0;
            let (p, q) = (at(i % STEPS), at(i / STEPS));
            let s = m.mean + DVec2::new(xx * p, yx * p + yy * q);
            let density = gaussian_pdf(p) * gaussian_pdf(q) * (14.0 / f64::from(STEPS)).powi(2);
            area += density * (v.z - s.dot(v.truncate())).max(0.0);
            let weight = density * visible_weight(m, v, s);
            sum += weight;
            mean += weight * s;
            square += weight * DVec3::new(s.x * s.x, s.x * s.y, s.y * s.y);
        }
        let own = visible_moments(m, v);
        assert!((slope_cosine(m, v) / area - 1.0).abs() < 1e-4 && (sum - 1.0).abs() < 1e-4);
        assert!((own.mean - mean).length() < 1e-4, "{degrees}: {own:?} {mean}");
        close(own.covariance, square - DVec3::new(mean.x * mean.x, mean.x * mean.y, mean.y * mean.y), 1e-4);
    }
}
