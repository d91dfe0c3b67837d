//! NDFs all over the hemisphere, for tests: how far two of them are apart.

use glam::DVec3;

use super::{Lobe, Ndf};

/// Places a side; all stand for the same projected solid angle.
const SIDE: usize = 48;

/// The NDF of a mixture of lobes, in projected area, at places of equal projected solid angle.
pub fn ndf(lobes: impl Iterator<Item = (Lobe, f32)>) -> Vec<f64> {
    let (mut sum, mut all) = (vec![0.0; SIDE * SIDE], 0.0);
    for (lobe, weight) in lobes {
        all += f64::from(weight);
        for (i, sum) in sum.iter_mut().enumerate() {
            let part = |i: usize| (i as f64 + 0.5) / SIDE as f64;
            let (r2, (sin, cos)) = (part(i / SIDE), (std::f64::consts::TAU * part(i % SIDE)).sin_cos());
            let m = DVec3::new(r2.sqrt() * cos, r2.sqrt() * sin, (1.0 - r2).sqrt());
            *sum += f64::from(weight) * lobe.d(m) * m.dot(lobe.normal.as_dvec3()) / m.z;
        }
    }
    sum.iter_mut().for_each(|v| *v /= all);
    sum
}

/// Total variation distance of two NDFs, 0 to 1.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    let pairs = || a.iter().zip(b);
    pairs().map(|(p, q)| (p - q).abs()).sum::<f64>() / pairs().map(|(p, q)| p + q).sum::<f64>()
}
