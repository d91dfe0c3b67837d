use glam::DMat2;

use super::super::draw;
use super::super::geometric_aa::{MOST_ADDED, SIGMA2_BOX, SIGMA2_HALF, SIGMA2_PEAK, matrix, tensor};
use super::super::moments::{gaussian_cdf, gaussian_pdf};
use super::*;

struct Random(u64);

impl Random {
    /// -1 to 1.
    fn next(&mut self) -> f64 {
        draw(&mut self.0)
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    fn normal(&mut self) -> DVec3 {
        (self.vector() + 1.5 * DVec3::Z).normalize()
    }

    fn tensor(&mut self) -> DVec3 {
        let turn = DMat2::from_angle(3.0 * self.next());
        let a2 = DVec2::new(0.5 + 0.499 * self.next(), 0.5 + 0.499 * self.next());
        tensor(turn * DMat2::from_diagonal(a2 * a2) * turn.transpose())
    }

    fn footprint(&mut self) -> Footprint {
        let (normal, tensor) = (self.normal(), self.tensor());
        let [dndx, dndy, dmdx, dmdy] = [(); 4].map(|()| 0.3 * self.vector());
        let base = 0.5 * (1.0 + self.next()) * tensor;
        Footprint { normal, tensor, base, dndx, dndy, dmdx, dmdy, sigma2: SIGMA2_PEAK, most: MOST_ADDED, texel: 1.0 }
    }
}

fn least(t: DVec3) -> f64 {
    0.5 * (t.x + t.z) - (0.5 * (t.x - t.z)).hypot(t.y)
}

#[test]
fn zero_derivatives_give_back_the_chains_lobe() {
    let mut random = Random(1);
    for _ in 0..200 {
        let zero = DVec3::ZERO;
        let f = Footprint { dndx: zero, dndy: zero, dmdx: zero, dmdy: zero, ..random.footprint() };
        for lobe in [footprint_normals(f), footprint_half_vectors(f)] {
            assert!(lobe.normal == f.normal && (lobe.tensor - f.tensor).length() < 1e-12);
        }
    }
}

/// Never less than the part from texel to texel, nor in the mean more than the whole; both estimates are kept.
#[test]
fn what_is_added_lies_between() {
    let mut random = Random(2);
    for _ in 0..500 {
        let (k, folded, share) = (0.2 * random.tensor(), 0.2 * random.tensor(), 0.5 + 0.5 * random.next());
        let added = residual_kernel(k, folded, share);
        assert!(least(added - (1.0 - share) * k) > -1e-12 && added.x + added.z <= k.x + k.z + 1e-12);
        assert!(least(folded + added - k) > -1e-12, "no less than the derivatives tell");
        assert!((residual_kernel(k, DVec3::ZERO, share) - k).length() < 1e-14);
        assert!((residual_kernel(k, share * k, share) - (1.0 - share) * k).length() < 1e-12);
        assert!((residual_kernel(k, 10.0 * DVec3::new(1.0, 0.0, 1.0), share) - (1.0 - share) * k).length() < 1e-12);
        // A fold that came out smoother than its base holds nothing.
        assert!((residual_kernel(k, -folded, share) - k).length() < 1e-14);
    }
}

#[test]
fn turning_the_tangent_frame_turns_the_lobe() {
    let mut random = Random(3);
    for _ in 0..200 {
        let (f, angle) = (random.footprint(), 3.0 * random.next());
        let turn = glam::DMat3::from_rotation_z(angle);
        // The bent frame does not turn along: from the one to the other.
        let (t, b) = bent(f.normal);
        let (t1, b1) = bent(turn * f.normal);
        let change = DMat2::from_cols(
            DVec2::new((turn * t).dot(t1), (turn * t).dot(b1)),
            DVec2::new((turn * b).dot(t1), (turn * b).dot(b1)),
        );
        let moved = |r: DVec3| tensor(change * matrix(r) * change.transpose());
        let g = Footprint {
            normal: turn * f.normal,
            tensor: moved(f.tensor),
            base: moved(f.base),
            dndx: turn * f.dndx,
            dndy: turn * f.dndy,
            dmdx: turn * f.dmdx,
            dmdy: turn * f.dmdy,
            ..f
        };
        for shade in [footprint_normals, footprint_half_vectors] {
            assert!((moved(shade(f).tensor) - shade(g).tensor).length() < 1e-11);
        }
    }
}

/// Turning the mesh normal turns the lobe's normal as the smallest rotation does.
#[test]
fn lobes_are_carried_along() {
    let mut random = Random(4);
    for _ in 0..100 {
        let (n, dn) = (random.normal(), random.vector());
        let dn = DVec3::new(dn.x, dn.y, 0.0);
        let e = 1e-6;
        let turned = |e: f64| glam::DQuat::from_rotation_arc(DVec3::Z, (DVec3::Z + e * dn).normalize()) * n;
        assert!((carried_derivative(n, dn) - (turned(e) - turned(-e)) / (2.0 * e)).length() < 1e-8);
        let moved = bent_components(n, carried_derivative(n, dn));
        let kernel = |d: DVec2| DVec3::new(d.x * d.x, d.x * d.y, d.y * d.y);
        assert!((carried_kernel(n, kernel(dn.truncate())) - kernel(moved)).length() < 1e-12);
    }
}

/// Steady change: a ramp of slopes whose texels have folded `w^2 / 12`. In all, alpha^2 grows by 2 sigma2 times the square of
/// the change, whatever the texels' width and the filter, and by no more where the chain holds other bumps besides.
#[test]
fn a_ramp_counts_once() {
    for (sigma2, texel) in
        [(SIGMA2_BOX, 1.0), (SIGMA2_PEAK, 1.0), (SIGMA2_HALF, 1.0), (SIGMA2_HALF, 0.5), (SIGMA2_HALF, 0.0)]
    {
        let (a, b) = (DVec2::new(0.1, 0.02), DVec2::new(-0.03, 0.07));
        let whole = kernel(a, b, sigma2);
        let within = kernel(a, b, texel * texel / 12.0);
        let added = residual_kernel(whole, within, folded_share(sigma2, texel));
        assert!((within + added - whole).length() < 1e-15);
        let more = residual_kernel(whole, within + DVec3::new(0.01, 0.0, 0.01), folded_share(sigma2, texel));
        assert!((within + more - whole).length() < 1e-15);
    }
}

/// A random normal map in one dimension, 16 texels a pixel, folded over a pixel by a box, and looked up bilinearly between
/// pixels: variance of the full-size slopes under the pixel's Gaussian, beside what the chain alone holds, chain and
/// derivatives in full, and the rule. Two digits of each are what the shader's text states. From steady change (correlated over 16 pixels) to noise, as shares of the truth.
#[test]
fn noise_of_any_length_counts_about_once() {
    const FINE: usize = 16;
    const PIXELS: usize = 4000;
    for (correlation, stated) in [(16.0, [0.53, 1.48, 1.03]), (2.0, [0.57, 1.30, 0.98]), (0.25, [0.80, 0.98, 0.89])] {
        let mut random = Random(5);
        // Twice integrated noise, smooth at the length of correlation (pixels), of either sign.
        let keep = (-1.0 / (correlation * FINE as f64)).exp();
        let (mut first, mut second) = (0.0, 0.0);
        let slopes: Vec<f64> = (0..FINE * PIXELS)
            .map(|_| {
                first = keep * first + (1.0 - keep) * random.next();
                second = keep * second + (1.0 - keep) * first;
                second
            })
            .collect();
        let folded: Vec<(f64, f64)> = slopes
            .chunks(FINE)
            .map(|texel| {
                let mean = texel.iter().sum::<f64>() / FINE as f64;
                (mean, texel.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / FINE as f64)
            })
            .collect();
        let weights: Vec<f64> =
            (-32..=32).map(|i| (-0.5 * (f64::from(i) / FINE as f64).powi(2) / SIGMA2_PEAK).exp()).collect();
        let total: f64 = weights.iter().sum();
        let (mut truth, mut chain, mut whole, mut rule) = (0.0, 0.0, 0.0, 0.0);
        for pixel in 8..PIXELS - 8 {
            // Pixels lie anywhere between the texels' centres.
            let at = pixel as f64 + 0.5 * random.next();
            let looked_up = |at: f64| {
                let (i, f) = (at.floor() as usize, at.fract());
                let ((m0, v0), (m1, v1)) = (folded[i], folded[i + 1]);
                (m0 + f * (m1 - m0), v0 + f * (v1 - v0))
            };
            let centre = (FINE as f64 * (at + 0.5)).round() as usize;
            let around = &slopes[centre - 32..=centre + 32];
            let mean = around.iter().zip(&weights).map(|(s, w)| s * w).sum::<f64>() / total;
            truth += 2.0 * around.iter().zip(&weights).map(|(s, w)| (s - mean).powi(2) * w).sum::<f64>() / total;
            let ((m, v), (next, _)) = (looked_up(at), looked_up(at + 1.0));
            let one = |v: f64| DVec3::new(v, 0.0, 0.0);
            let k = kernel(DVec2::new(next - m, 0.0), DVec2::ZERO, SIGMA2_PEAK);
            chain += 2.0 * v;
            whole += 2.0 * v + k.x;
            rule += 2.0 * v + residual_kernel(k, one(2.0 * v), folded_share(SIGMA2_PEAK, 1.0)).x;
        }
        for (found, stated) in [chain, whole, rule].iter().zip(stated) {
            assert!((found / truth - stated).abs() < 0.005, "{correlation}: {} is not {stated}", found / truth);
        }
    }
}

/// At full length it is max(0, cosine); at length 0 half of the bumps' light is left at the terminator.
#[test]
fn the_diffuse_cosine_meets_its_limits() {
    for cosine in [-1.0f64, -0.3, 0.0, 0.4, 1.0] {
        assert!((diffuse_cosine(1.0, cosine) - cosine.max(0.0)).abs() < 1e-6);
        assert!(diffuse_cosine(0.8, cosine) >= 0.8 * cosine.max(0.0));
    }
    // Against the mean of max(0, n . l) over normals spread as a Gaussian of slopes, sigma 0.3, light 85 degrees away.
    let (sigma, steps) = (0.3, 400);
    let (mut z, mut light, mut weight) = (0.0, 0.0, 0.0);
    for i in 0..steps * steps {
        let at = |i: i32| 10.0 * (f64::from(i) + 0.5) / f64::from(steps) - 5.0;
        let s = DVec2::new(at(i % steps), at(i / steps));
        let n = (-sigma * s).extend(1.0).normalize();
        let w = (-0.5 * s.length_squared()).exp() / n.z;
        let l = DVec3::new(85f64.to_radians().sin(), 0.0, 85f64.to_radians().cos());
        (z, light, weight) = (z + w * n.z, light + w * n.dot(l).max(0.0), weight + w);
    }
    let (length, truth) = (z / weight, light / weight);
    let own = diffuse_cosine(length, 85f64.to_radians().cos());
    assert!((truth - 0.1549).abs() < 1e-4 && (own - truth).abs() < 0.002, "{own} {truth}");
    assert!(truth > 1.7 * 85f64.to_radians().cos(), "a hard terminator takes off almost half");
}

/// In deviations: the same as over a Gaussian at 0, within 0.012 elsewhere.
#[test]
fn the_soft_plus_stands_for_a_gaussian() {
    let deviation = |scale: f64, cosine: f64| (0.5 * (1.0 - scale * scale) * (1.0 - cosine * cosine)).sqrt();
    assert!((diffuse_cosine(0.6, 0.0) / deviation(0.6, 0.0) * std::f64::consts::TAU.sqrt() - 1.0).abs() < 1e-4);
    let mut worst = 0.0f64;
    for i in -1000..=1000 {
        for scale in [0.3, 0.6, 0.9, 0.99] {
            let cosine = 0.999 * f64::from(i) / 1000.0;
            let (mean, tau) = (scale * cosine, deviation(scale, cosine));
            let truth = mean * gaussian_cdf(mean / tau) + tau * gaussian_pdf(mean / tau);
            worst = worst.max((diffuse_cosine(scale, cosine) - truth).abs() / tau);
        }
    }
    assert!(worst > 0.01 && worst < 0.012, "{worst}");
}

/// A glint ratio scales what is specular and leaves the rest; light and view may be exchanged; nothing comes from below.
#[test]
fn a_lobe_is_shaded_reciprocally() {
    let mut random = Random(6);
    for _ in 0..200 {
        let (normal, v, l, f0) = (random.normal(), random.normal(), random.normal(), DVec3::new(0.04, 0.5, 1.0));
        let lobe = Lobe { normal, tensor: random.tensor() };
        let (one, other) = (footprint_shade(lobe, v, l, f0, 1.0, 0.9), footprint_shade(lobe, l, v, f0, 1.0, 0.9));
        let (back, forth) = (one.specular * normal.dot(v).max(0.0), other.specular * normal.dot(l).max(0.0));
        assert!((back - forth).length() <= 1e-12 * one.specular.length().max(1.0));
        let glint = footprint_shade(lobe, v, l, f0, 2.5, 0.9);
        assert!((glint.specular - 2.5 * one.specular).length() <= 1e-12 * glint.specular.length());
        assert_eq!(glint.diffuse, one.diffuse);
        assert_eq!(footprint_shade(lobe, v, -normal, f0, 1.0, 1.0).specular, DVec3::ZERO);
    }
}
