//! The GGX lobe.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::{Axes, Frame, Ndf, RoughnessTensor};
use crate::roughness::Alpha;

/// A texel: a normal and a width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit, z out of the surface.
    pub normal: Vec3,
    /// Width, in the bent frame of the normal ([`Frame::bent`]).
    pub roughness: RoughnessTensor,
}

impl Lobe {
    /// A lobe of one width.
    pub fn isotropic(normal: Vec3, alpha: Alpha) -> Self {
        Self { normal, roughness: RoughnessTensor::isotropic(alpha) }
    }

    /// Widths and direction of the larger one, measured from the bent tangent.
    pub fn axes(&self) -> Axes {
        self.roughness.axes()
    }

    /// `v` in the lobe's own frame: (tangent, bitangent, normal).
    pub fn local(&self, v: DVec3) -> DVec3 {
        let frame = Frame::bent(self.normal);
        DVec3::new(v.dot(frame.tangent.as_dvec3()), v.dot(frame.bitangent.as_dvec3()), v.dot(self.normal.as_dvec3()))
    }

    /// The tensor that is evaluated: no width below [`Alpha::SMOOTHEST`].
    fn evaluated(&self) -> (f64, f64, f64) {
        let r = self.roughness.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
        (f64::from(r.xx), f64::from(r.xy), f64::from(r.yy))
    }

    /// Smith's Lambda for a direction `v` (any length), `(sqrt(1 + v_p^T R v_p / v_z^2) - 1) / 2` in the lobe's
    /// frame (Heitz 2014, eq. 72).
    pub fn lambda(&self, v: DVec3) -> f64 {
        let v = self.local(v);
        let (xx, xy, yy) = self.evaluated();
        let form = xx * v.x * v.x + 2.0 * xy * v.x * v.y + yy * v.y * v.y;
        0.5 * ((1.0 + form / (v.z * v.z)).sqrt() - 1.0)
    }

    /// Specular BRDF times cosine for unit view and light, with F = 1 and height-correlated Smith masking:
    /// `D G2 / (4 n.v)` with `G2 = 1 / (1 + Lambda(v) + Lambda(l))` (Heitz 2014, eq. 99). 0 below the lobe's
    /// horizon.
    pub fn specular(&self, v: DVec3, l: DVec3) -> f64 {
        let n = self.normal.as_dvec3();
        let (nv, nl) = (n.dot(v), n.dot(l));
        if nv <= 0.0 || nl <= 0.0 {
            return 0.0;
        }
        let h = (v + l).normalize();
        self.d(h) / (4.0 * nv * (1.0 + self.lambda(v) + self.lambda(l)))
    }
}

impl Ndf for Lobe {
    fn d(&self, m: DVec3) -> f64 {
        let m = self.local(m);
        if m.z <= 0.0 {
            return 0.0;
        }
        let (xx, xy, yy) = self.evaluated();
        let det = xx * yy - xy * xy;
        let q = (yy * m.x * m.x - 2.0 * xy * m.x * m.y + xx * m.y * m.y) / det + m.z * m.z;
        1.0 / (PI * det.sqrt() * q * q)
    }

    fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        // Slopes of unit-width GGX have radius sqrt(u / (1 - u)); the Cholesky factor of R stretches them.
        let (xx, xy, yy) = self.evaluated();
        let radius = (u / (1.0 - u).max(f64::MIN_POSITIVE)).sqrt();
        let (sin, cos) = (TAU * v).sin_cos();
        let l11 = xx.sqrt();
        let l21 = xy / l11;
        let l22 = (yy - l21 * l21).max(0.0).sqrt();
        let (sx, sy) = (l11 * radius * cos, l21 * radius * cos + l22 * radius * sin);
        let frame = Frame::bent(self.normal);
        let m = self.normal.as_dvec3() - sx * frame.tangent.as_dvec3() - sy * frame.bitangent.as_dvec3();
        m.normalize()
    }

    fn pdf(&self, m: DVec3) -> f64 {
        self.d(m) * m.dot(self.normal.as_dvec3()).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobes() -> Vec<Lobe> {
        let tilted = Vec3::new(0.3, -0.4, 0.8).normalize();
        let axes = |x, y, angle| RoughnessTensor::from_axes(Axes { alpha_x: Alpha(x), alpha_y: Alpha(y), angle });
        vec![
            Lobe::isotropic(Vec3::Z, Alpha(0.5)),
            Lobe::isotropic(tilted, Alpha(0.2)),
            Lobe { normal: Vec3::Z, roughness: axes(0.6, 0.2, 0.5) },
            Lobe { normal: tilted, roughness: axes(0.5, 0.3, -1.2) },
        ]
    }

    /// Midpoint rule over the hemisphere about the lobe's own normal, in (cos theta, phi) cells.
    fn hemisphere(lobe: &Lobe, n: usize, mut f: impl FnMut(DVec3)) -> f64 {
        let frame = Frame::bent(lobe.normal);
        for i in 0..n {
            let z = (i as f64 + 0.5) / n as f64;
            let r = (1.0 - z * z).sqrt();
            for j in 0..n {
                let (s, c) = (TAU * (j as f64 + 0.5) / n as f64).sin_cos();
                f(r * c * frame.tangent.as_dvec3() + r * s * frame.bitangent.as_dvec3() + z * lobe.normal.as_dvec3());
            }
        }
        TAU / (n * n) as f64
    }

    #[test]
    fn projected_area_of_the_facets_is_one() {
        for lobe in lobes() {
            let mut sum = 0.0;
            let cell = hemisphere(&lobe, 800, |m| sum += lobe.pdf(m));
            assert!((sum * cell - 1.0).abs() < 2e-3, "{lobe:?}: {}", sum * cell);
        }
    }

    /// Weak white furnace (Heitz 2014): projected area towards v, divided by G1, is n.v.
    #[test]
    fn smith_conserves_projected_area() {
        for lobe in lobes() {
            for v in [DVec3::Z, DVec3::new(0.6, 0.1, 0.5).normalize()] {
                let mut area = 0.0;
                let cell = hemisphere(&lobe, 800, |m| area += lobe.d(m) * m.dot(v).max(0.0));
                let expected = v.dot(lobe.normal.as_dvec3()) * (1.0 + lobe.lambda(v));
                assert!((area * cell / expected - 1.0).abs() < 3e-3, "{lobe:?} {} {expected}", area * cell);
            }
        }
    }

    /// Pearson's chi-square of `sample` against `pdf` on 12 x 12 cells of equal probability in the quantities
    /// that GGX makes uniform: 143 degrees of freedom, 0.1 percent point 200.
    #[test]
    fn samples_follow_the_pdf() {
        const N: usize = 12;
        const DRAWS: usize = 40_000;
        for lobe in lobes() {
            let mut expected = vec![0.0; N * N];
            let cell_of = |m: DVec3| {
                let m = lobe.local(m);
                let z = ((m.z.clamp(0.0, 1.0) * N as f64) as usize).min(N - 1);
                let phi = (m.y.atan2(m.x) / TAU + 0.5) * N as f64;
                z * N + (phi as usize).min(N - 1)
            };
            let cell = hemisphere(&lobe, 1200, |m| expected[cell_of(m)] += lobe.pdf(m));
            let mut observed = vec![0usize; N * N];
            for i in 0..DRAWS {
                // Roberts' R2 sequence is too regular for chi-square; a 64-bit mix of the index is not.
                let random = |k: u64| {
                    let mut z = (i as u64 * 2 + k).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
                    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
                };
                observed[cell_of(lobe.sample([random(0), random(1)]))] += 1;
            }
            let (mut chi2, mut cells, mut rest) = (0.0, 0.0, (0.0, 0.0));
            for (&e, &o) in expected.iter().zip(&observed) {
                let e = e * cell * DRAWS as f64;
                if e >= 5.0 {
                    chi2 += (o as f64 - e).powi(2) / e;
                    cells += 1.0;
                } else {
                    rest = (rest.0 + e, rest.1 + o as f64);
                }
            }
            if rest.0 >= 5.0 {
                chi2 += (rest.1 - rest.0).powi(2) / rest.0;
                cells += 1.0;
            }
            // Wilson-Hilferty: 0.1 percent point of chi-square with k degrees of freedom (z = 3.09).
            let k: f64 = cells - 1.0;
            let limit = k * (1.0 - 2.0 / (9.0 * k) + 3.09 * (2.0 / (9.0 * k)).sqrt()).powi(3);
            assert!(chi2 < limit, "{lobe:?}: chi-square {chi2} over {limit} with {k} degrees of freedom");
        }
    }
}
