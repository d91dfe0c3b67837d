//! The lobe error of one footprint, made ready for a search: few lights, and what the footprint reflects of them.
//!
//! It is the judge's figure ([`crate::compare`]): over lights above the surface and the judge's views, the integral of
//! `|f - f_ref|` over half of that of `f + f_ref`. f is the specular BRDF of a lobe times the cosine, GGX with
//! height-correlated Smith and F = 1, and f_ref its mean over the footprint. The integral is a mean over half vectors at
//! fixed places of low discrepancy: half of them drawn from the footprint, half from a first guess, weighted together by how
//! densely both fall (Veach & Guibas 1995, balance heuristic).

use std::cmp::Ordering;
use std::f32::consts::PI;
use std::sync::LazyLock;

use glam::Vec3;

use crate::compare::VIEWS;
use crate::ndf::{Frame, RoughnessTensor};
use crate::random::{Random, Spread};
use crate::summary::Entry;

/// Half vectors for each view, a multiple of what fills vector registers.
const HALVES: usize = 192;

/// Of those, how many come from the footprint.
const SHARED: usize = HALVES / 2;

/// Least squared width: that of the smoothest texels.
const NARROWEST: f32 = 1e-12;

/// A number for each half vector of a view.
type Row = [f32; HALVES];

/// A lobe as a search moves it: normal and tensor in the transported frame, squared widths above 0.
pub type Candidate = (Vec3, RoughnessTensor);

/// Where a half vector is drawn: which lobe, as a share of all weights, and where in it, in slopes of a round lobe of width 1.
#[derive(Clone, Copy)]
struct Place {
    lobe: f32,
    x: f32,
    y: f32,
}

/// The same for every footprint.
static PLACES: LazyLock<[[Place; HALVES]; VIEWS.len()]> = LazyLock::new(|| {
    std::array::from_fn(|view| {
        let mut spreads = [0, 1].map(|stream| Spread::new(&mut Random::new(view as u64, stream)));
        std::array::from_fn(|i| {
            let [lobe, u, v, _] = spreads[usize::from(i >= SHARED)].point();
            let radius = (u / (1.0 - u)).sqrt();
            let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
            Place { lobe: lobe as f32, x: (radius * cos) as f32, y: (radius * sin) as f32 }
        })
    })
});

/// A lobe ready to be evaluated, by the factor L of its tensor in its tangent frame: `m^T S^-1 m` is the squared length of
/// `(L^-1 T^t m, n . m)` and `l^T S l` that of `(L^T T^t l, n . l)`. As sums of squares they keep their digits in f32.
#[derive(Clone, Copy)]
struct Shaded {
    normal: Vec3,
    /// Rows of `L^-1 T^t`.
    narrow: [Vec3; 2],
    /// Rows of `L^T T^t`.
    wide: [Vec3; 2],
    /// Columns of `T L`: a normal of the lobe is `n - x wide_x - y wide_y`.
    columns: [Vec3; 2],
    /// `1 / (pi sqrt(det R))`.
    scale: f32,
}

impl Shaded {
    fn new((normal, r): Candidate) -> Self {
        let Frame { tangent: t, bitangent: b } = Frame::transported(normal);
        let l11 = r.xx.sqrt();
        let l21 = r.xy / l11;
        let l22 = (r.yy - l21 * l21).max(1e-6 * r.yy).sqrt();
        let narrow = t / l11;
        Self {
            normal,
            narrow: [narrow, (b - l21 * narrow) / l22],
            wide: [l11 * t + l21 * b, l22 * b],
            columns: [l11 * t + l21 * b, l22 * b],
            scale: 1.0 / (PI * l11 * l22),
        }
    }

    fn draw(&self, place: Place) -> Vec3 {
        (self.normal - place.x * self.columns[0] - place.y * self.columns[1]).normalize()
    }
}

/// What is seen from one view.
struct Seen {
    view: Vec3,
    half: [Row; 3],
    light: [Row; 3],
    /// What each half vector stands for: `4 (v . h) / density`, 0 for lights below the surface.
    share: Row,
    /// f_ref times that.
    reference: Row,
}

/// A footprint's lobe error, to be evaluated for many lobes.
pub struct LobeError {
    /// Those of the footprint, with their shares.
    lobes: Vec<(f32, Candidate)>,
    seen: Vec<Seen>,
    /// Sum of f_ref.
    reflected: f32,
}

impl LobeError {
    /// Of a footprint; `guess` is a lobe near the ones that will be asked for.
    pub fn new(footprint: impl Iterator<Item = Entry>, guess: Candidate) -> Self {
        // In an order of their own, so that neither theirs nor copies change what is drawn.
        let mut entries: Vec<Entry> = footprint.filter(|e| e.weight > 0.0).collect();
        let places = |Entry { lobe, .. }: &Entry| [lobe.centre.x, lobe.centre.y, lobe.scatter.xx];
        entries
            .sort_by(|a, b| places(a).iter().zip(places(b)).fold(Ordering::Equal, |o, (a, b)| o.then(a.total_cmp(&b))));
        let mut lobes: Vec<(f32, Candidate)> = Vec::with_capacity(entries.len());
        let mut total = 0.0;
        for Entry { weight, lobe } in entries {
            // Of steep and smooth texels, rounding may leave nothing, or less.
            let (normal, tensor) = lobe.transported();
            lobes.push((weight, (normal, tensor.clamped(NARROWEST, 1.0))));
            total += weight;
        }
        let mut upto = 0.0;
        let ends: Vec<f32> = lobes
            .iter_mut()
            .map(|(weight, _)| {
                *weight /= total;
                upto += *weight;
                upto
            })
            .collect();
        let shaded: Vec<(f32, Shaded)> = lobes.iter().map(|&(weight, lobe)| (weight, Shaded::new(lobe))).collect();
        let guess = Shaded::new(guess);
        let seen: Vec<Seen> = (0..VIEWS.len())
            .map(|view| {
                let half: [Vec3; HALVES] = std::array::from_fn(|i| {
                    let place = PLACES[view][i];
                    let chosen = ends.partition_point(|end| *end <= place.lobe).min(shaded.len().max(1) - 1);
                    let from = if i < SHARED { shaded.get(chosen).map_or(&guess, |(_, lobe)| lobe) } else { &guess };
                    from.draw(place)
                });
                Seen::new(direction(VIEWS[view]), &half, &shaded, &guess)
            })
            .collect();
        let reflected = seen.iter().map(|seen| seen.reference.iter().sum::<f32>()).sum();
        Self { lobes, seen, reflected }
    }

    /// The footprint's own lobes.
    pub fn lobes(&self) -> impl Iterator<Item = Candidate> {
        self.lobes.iter().map(|(_, lobe)| *lobe)
    }

    /// The lobe error of a lobe, 0 to 2.
    pub fn of(&self, lobe: Candidate) -> f32 {
        pulp::Arch::new().dispatch(Apart { from: self, lobe: Shaded::new(lobe) })
    }
}

/// [`LobeError::of`] for the processor's vector registers. A type, and no closure: calls of closures are not inlined there.
struct Apart<'a> {
    from: &'a LobeError,
    lobe: Shaded,
}

impl pulp::WithSimd for Apart<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f32 {
        let (mut apart, mut own) = (0.0, 0.0);
        for seen in &self.from.seen {
            let (mut f, mut off) = ([0.0; HALVES], [0.0; HALVES]);
            seen.reflect(&self.lobe, &mut f, None);
            for j in 0..HALVES {
                f[j] *= seen.share[j];
                off[j] = (f[j] - seen.reference[j]).abs();
            }
            apart += sum(&off);
            own += sum(&f);
        }
        apart / (0.5 * (own + self.from.reflected))
    }
}

/// What the footprint reflects, put into [`Seen`].
struct Reference<'a> {
    seen: &'a mut Seen,
    lobes: &'a [(f32, Shaded)],
    guess: &'a Shaded,
}

impl pulp::WithSimd for Reference<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { seen, lobes, guess } = self;
        let (mut f, mut pdf) = ([0.0; HALVES], [0.0; HALVES]);
        let (mut mean, mut density) = ([0.0; HALVES], [0.0; HALVES]);
        seen.reflect(guess, &mut f, Some(&mut density));
        for (weight, lobe) in lobes {
            seen.reflect(lobe, &mut f, Some(&mut pdf));
            for j in 0..HALVES {
                mean[j] += weight * f[j];
                density[j] += weight * pdf[j];
            }
        }
        for j in 0..HALVES {
            let cos = seen.view.x * seen.half[0][j] + seen.view.y * seen.half[1][j] + seen.view.z * seen.half[2][j];
            let above = if seen.light[2][j] > 0.0 { 1.0 } else { 0.0 };
            // Both halves of the draws.
            let share = above * 4.0 * cos.max(0.0) / (0.5 * density[j]).max(f32::MIN_POSITIVE);
            (seen.share[j], seen.reference[j]) = (share, share * mean[j]);
        }
    }
}

/// Unit vector of a view of the judge's.
fn direction((slant, around): (f64, f64)) -> Vec3 {
    let ((sin, cos), (y, x)) = (slant.to_radians().sin_cos(), around.to_radians().sin_cos());
    glam::DVec3::new(sin * x, sin * y, cos).as_vec3()
}

/// In an order that fills vector registers.
#[inline(always)]
fn sum(row: &Row) -> f32 {
    let mut sums = [0.0; 16];
    for part in row.chunks_exact(16) {
        (0..16).for_each(|i| sums[i] += part[i]);
    }
    sums.iter().sum()
}

impl Seen {
    fn new(view: Vec3, half: &[Vec3; HALVES], lobes: &[(f32, Shaded)], guess: &Shaded) -> Self {
        let light = half.map(|m| 2.0 * view.dot(m) * m - view);
        let planes = |v: &[Vec3; HALVES]| [0, 1, 2].map(|i| v.map(|v| v[i]));
        let zero = [0.0; HALVES];
        let mut seen = Self { view, half: planes(half), light: planes(&light), share: zero, reference: zero };
        pulp::Arch::new().dispatch(Reference { seen: &mut seen, lobes, guess });
        seen
    }

    /// What a lobe reflects, before it is known whether the light is above the surface, and the density `D(m) (m . n)`.
    #[inline(always)]
    fn reflect(&self, lobe: &Shaded, f: &mut Row, mut pdf: Option<&mut Row>) {
        let Shaded { normal: n, narrow: [a, b], wide: [c, d], scale, .. } = *lobe;
        let [mx, my, mz] = &self.half;
        let [lx, ly, lz] = &self.light;
        let cos_view = n.dot(self.view);
        let [c_view, d_view] = [c.dot(self.view), d.dot(self.view)];
        let stretch_view = (cos_view * cos_view + c_view * c_view + d_view * d_view).sqrt();
        // A facet that faces away shows nothing.
        let (visible, cos_view) = if cos_view > 0.0 { (1.0, cos_view) } else { (0.0, 1.0) };
        for j in 0..HALVES {
            let on_half = |v: Vec3| v.x * mx[j] + v.y * my[j] + v.z * mz[j];
            let on_light = |v: Vec3| v.x * lx[j] + v.y * ly[j] + v.z * lz[j];
            let (cos, along, across) = (on_half(n), on_half(a), on_half(b));
            let t = cos * cos + along * along + across * across;
            let (up, p, q) = (on_light(n), on_light(c), on_light(d));
            let stretch = (up * up + p * p + q * q).sqrt();
            let cos_light = up.max(0.0);
            // D G2 / (4 n.v) = D n.l / (2 (s_v n.l + s_l n.v)), with one division for both.
            let below = 2.0 * (stretch_view * cos_light + stretch * cos_view);
            let both = if cos > 0.0 { scale / (t * t * below) } else { 0.0 };
            f[j] = both * cos_light * visible;
            if let Some(pdf) = &mut pdf {
                pdf[j] = both * below * cos;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::{Lobe, SlopeLobe};
    use crate::reference::{Diffuse, Footprint, Queries};
    use crate::roughness::Alpha;

    /// A lobe, by slopes and widths.
    fn lobe(x: f32, y: f32, [xx, xy, yy]: [f32; 3]) -> Candidate {
        (Vec3::new(-x, -y, 1.0).normalize(), RoughnessTensor { xx, xy, yy })
    }

    fn bent((normal, tensor): Candidate) -> Lobe {
        Lobe { normal, roughness: tensor.to_bent(normal) }
    }

    /// The judge's integrals by many half vectors, in f64.
    fn exact(footprint: &[Lobe], other: Lobe) -> f64 {
        let truth = Footprint::of_lobes(&footprint.iter().map(|lobe| (*lobe, 1.0)).collect::<Vec<_>>());
        let other = Footprint::of_lobes(&[(other, 1.0)]);
        let (mut queries, mut spread) = (Queries::default(), Spread::new(&mut Random::new(7, 0)));
        for view in VIEWS {
            queries.start_view(direction(view).as_dvec3().normalize());
            for i in 0..40_000 {
                queries.push_half(if i % 2 == 0 { &truth } else { &other }.draw(spread.point()));
            }
        }
        let [a, b] = [&truth, &other].map(|f| f.means(&queries, &Diffuse::default()).swap_remove(0));
        let (mut apart, mut both) = (0.0, 0.0);
        for (view, range) in queries.views().zip(queries.ranges()) {
            for j in range {
                let share = view.dot(queries.half(j)).max(0.0) / (a.pdf[j] + b.pdf[j]);
                apart += share * (a.specular[j] - b.specular[j]).abs();
                both += share * 0.5 * (a.specular[j] + b.specular[j]);
            }
        }
        apart / both
    }

    #[test]
    fn few_half_vectors_tell_what_many_in_f64_do() {
        let footprint = [
            lobe(0.3, -0.1, [0.02, 0.005, 0.01]),
            lobe(-0.2, 0.2, [0.04, 0.0, 0.04]),
            lobe(0.1, 0.6, [0.01, 0.0, 0.01]),
        ];
        let entries = footprint.map(|lobe| Entry { weight: 1.0, lobe: SlopeLobe::new(&bent(lobe)) });
        let guess = lobe(0.05, 0.2, [0.08, 0.0, 0.12]);
        let error = LobeError::new(entries.into_iter(), guess);
        for other in [guess, lobe(0.1, 0.1, [0.05, 0.02, 0.2]), lobe(0.3, -0.1, [0.02, 0.005, 0.01])] {
            let (found, expected) = (error.of(other), exact(&footprint.map(bent), bent(other)));
            assert!((f64::from(found) / expected - 1.0).abs() < 0.05, "{found} {expected}");
        }
    }

    #[test]
    fn steep_mirrors_have_one() {
        for z in [1e-2f32, 1e-3, 1e-4] {
            let steep = |x: f32, y: f32| {
                let lobe = Lobe::isotropic(Vec3::new(x, y, z).normalize(), Alpha(1e-6));
                Entry { weight: 1.0, lobe: SlopeLobe::new(&lobe) }
            };
            let footprint = [steep(1.0, 1.0), steep(-0.3, 1.0), steep(1.0, -0.9)];
            let guess = lobe(0.1, 0.2, [0.5, 0.0, 0.5]);
            let error = LobeError::new(footprint.into_iter(), guess).of(guess);
            assert!((0.0..=2.0).contains(&error), "{z}: {error}");
        }
    }

    #[test]
    fn a_single_lobe_has_no_error() {
        // Down to widths at which a light is mirrored to a point.
        for alpha in [0.9f32, 0.1, 0.01, 0.001] {
            let own = lobe(0.4, -0.3, [alpha * alpha, 0.0, 0.25 * alpha * alpha]);
            let entry = Entry { weight: 3.0, lobe: SlopeLobe::new(&bent(own)) };
            let error = LobeError::new(std::iter::once(entry), own).of(own);
            assert!(error < 2e-3, "{alpha}: {error}");
        }
    }
}
