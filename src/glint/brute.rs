//! Truths to test evaluators against: the net's flakes one by one, and independent flakes.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::chart::Macro;
use super::field::{SMOOTH, best_level, sum_at_level};
use super::gather::gather;
use super::hash::{pcg4d, unit};
use super::probe::Probe;

/// Flakes that are enumerated; more are found by the net's lookups, which agree to rounding.
const MOST_ENUMERATED: usize = 1 << 22;

/// The evaluator "reference": every flake under the pixel. 1 from [`SMOOTH`] effective flakes, as all evaluators.
pub(super) fn ratio(p: &Probe) -> f64 {
    if p.n_eff() >= SMOOTH {
        return 1.0;
    }
    match gather(p, MOST_ENUMERATED) {
        Some(gathered) => gathered.ratio(p.y, p.area),
        None => sum_at_level(p, best_level(p.kernel, p.radius())),
    }
}

/// Independent flakes on the unit square, which closes like a torus: places uniform, normals drawn from a lobe (Jakob et
/// al. 2014, Atanasov & Koylazov 2016). They know nothing of nets and charts of directions; for statistics.
pub struct Scatter {
    /// Ends of each bin's flakes; bins of equal size, row by row.
    ends: Vec<usize>,
    flakes: Vec<(DVec2, DVec3)>,
    side: usize,
}

/// A pixel: a parallelogram of these two edges about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    /// Centre.
    pub centre: DVec2,
    /// Edges; shorter than half the square.
    pub edges: [DVec2; 2],
}

/// Half vectors within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit.
    pub axis: DVec3,
    /// Radians.
    pub half_angle: f64,
}

impl Scatter {
    /// `count` flakes of a GGX or Beckmann lobe; normals by inverting the lobe's radial distribution.
    pub fn new(count: usize, lobe: &Macro, seed: u32) -> Option<Self> {
        let chart = lobe.chart()?;
        let side = ((count as f64 / 8.0).sqrt() as usize).max(1);
        let mut flakes: Vec<_> = (0..count as u32)
            .map(|n| {
                let h = pcg4d([n, seed, 0x7A51, 1]);
                (DVec2::new(unit(h[0]), unit(h[1])), chart.normal(DVec2::new(unit(h[2]), unit(h[3]))))
            })
            .collect();
        let bin = |x: DVec2| (x.y * side as f64) as usize * side + (x.x * side as f64) as usize;
        flakes.sort_by_key(|(x, _)| bin(*x));
        let mut ends = vec![0; side * side];
        flakes.iter().for_each(|(x, _)| ends[bin(*x)] += 1);
        let mut end = 0;
        for count in &mut ends {
            end += *count;
            *count = end;
        }
        Some(Self { ends, flakes, side })
    }

    /// Flakes within the pixel that have their normals in the cone.
    pub fn count(&self, pixel: Parallelogram, cone: Cone) -> usize {
        let [a, b] = pixel.edges;
        let (reach, det) = ((a.abs() + b.abs()) * 0.5, a.perp_dot(b));
        let least = cone.half_angle.cos();
        let bins = |centre: f64, reach: f64| {
            let side = self.side as f64;
            (((centre - reach) * side).floor() as i64, ((centre + reach) * side).floor() as i64)
        };
        let ((i0, i1), (j0, j1)) = (bins(pixel.centre.x, reach.x), bins(pixel.centre.y, reach.y));
        let mut found = 0;
        for j in j0..=j1 {
            for i in i0..=i1 {
                let wrap = |v: i64| v.rem_euclid(self.side as i64) as usize;
                let bin = wrap(j) * self.side + wrap(i);
                let start = if bin == 0 { 0 } else { self.ends[bin - 1] };
                for (x, normal) in &self.flakes[start..self.ends[bin]] {
                    let d = *x - pixel.centre;
                    let d = d - d.round();
                    let (s, t) = (d.perp_dot(b) / det, a.perp_dot(d) / det);
                    found += usize::from(s.abs() <= 0.5 && t.abs() <= 0.5 && normal.dot(cone.axis) >= least);
                }
            }
        }
        found
    }
}

/// Chance that a flake's normal is in the cone: `integral D(m) cos(m) dm` by quadrature, 4096 points. For cones of some
/// degrees D in the middle times the solid angle would be up to 11 percent off.
pub fn probability(lobe: &Macro, cone: Cone) -> Option<f64> {
    let chart = lobe.chart()?;
    let (tangent, bitangent) = cone.axis.any_orthonormal_pair();
    let n = 64;
    let mut sum = 0.0;
    for i in 0..n {
        // Equal steps of the cosine, equal solid angles.
        let cap = 1.0 - cone.half_angle.cos();
        let z = 1.0 - cap * (f64::from(i) + 0.5) / f64::from(n);
        let r = (1.0 - z * z).sqrt();
        for j in 0..n {
            let (sin, cos) = (TAU * (f64::from(j) + 0.5) / f64::from(n)).sin_cos();
            let m = cone.axis * z + tangent * (r * cos) + bitangent * (r * sin);
            if m.z > 0.0 {
                sum += chart.density(m) * TAU * cap / f64::from(n * n);
            }
        }
    }
    Some(sum)
}

/// Ratio of a pixel with flakes that are independent in every respect, drawn anew for each number n: the truth that
/// statistics of evaluators are compared with (a compound Poisson distribution).
pub fn independent_ratio(n_eff: f64, n: u32, seed: u32) -> f64 {
    // Flakes in the support of both kernels, with heights 3 / area.
    let support = n_eff * (9.0 / 5.0) * (9.0 / 5.0);
    let (mut sum, mut index) = (0.0, 0);
    let mut wait = 0.0;
    // Arrivals of a Poisson process of rate 1 until time `support`.
    loop {
        let h = pcg4d([n, seed, index, 0x3D0E]);
        index += 1;
        wait -= unit(h[0]).ln();
        if wait > support {
            return sum * 9.0 / support;
        }
        // Squared distances are uniform in round supports.
        let rest = unit(h[1]) * unit(h[2]);
        sum += rest * rest;
    }
}

/// Solid angle of a cone.
pub fn solid_angle(cone: Cone) -> f64 {
    let s = (0.5 * cone.half_angle).sin();
    4.0 * PI * s * s
}
