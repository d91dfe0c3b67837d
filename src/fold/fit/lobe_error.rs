//! The lobe error of one footprint, made ready for a search: few lights, and what the footprint reflects of them.
//!
//! It is the judge's figure ([`crate::compare`]): over lights above the surface and the judge's views, the integral of
//! `|f - f_ref|` over half of that of `f + f_ref`. f is the specular BRDF of a lobe times the cosine, GGX with
//! height-correlated Smith and F = 1, and f_ref its mean over the footprint. The integral is a mean over half vectors at
//! fixed places of low discrepancy: half of them drawn from the footprint, half from a first guess, of one lobe or several,
//! weighted together by how densely both fall (Veach & Guibas 1995, balance heuristic).

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
    /// Of a footprint; `guess` are lobes near the ones that will be asked for, with shares that sum to 1.
    pub fn new(footprint: impl Iterator<Item = Entry>, guess: &[(f32, Candidate)]) -> Self {
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
        lobes.iter_mut().for_each(|(weight, _)| *weight /= total);
        let [own, guess] = [&lobes[..], guess].map(Drawn::new);
        let seen: Vec<Seen> = (0..VIEWS.len())
            .map(|view| {
                let half: [Vec3; HALVES] = std::array::from_fn(|i| {
                    let place = PLACES[view][i];
                    if i < SHARED { own.draw(place) } else { None }.or_else(|| guess.draw(place)).unwrap_or(Vec3::Z)
                });
                Seen::new(direction(VIEWS[view]), &half, &own.lobes, &guess.lobes)
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
        pulp::Arch::new().dispatch(Apart { from: self, lobe: Shaded::new(lobe), beside: None })
    }

    /// That of a lobe with a share, and others.
    pub fn of_share(&self, share: f32, lobe: Candidate, others: &Others) -> f32 {
        pulp::Arch::new().dispatch(Apart { from: self, lobe: Shaded::new(lobe), beside: Some((share, others)) })
    }

    /// Lobes that will stay as they are beside one that moves, with their shares among each other, of any sum.
    pub fn others(&self, lobes: &[(f32, Candidate)]) -> Others {
        let total: f32 = lobes.iter().map(|(share, _)| share).sum();
        let shaded: Vec<_> = lobes.iter().map(|&(share, lobe)| (share / total, Shaded::new(lobe))).collect();
        Others(self.seen.iter().map(|seen| pulp::Arch::new().dispatch(Together { seen, lobes: &shaded })).collect())
    }
}

/// What some lobes reflect together, from each view.
pub struct Others(Vec<Row>);

/// Lobes to draw from.
struct Drawn {
    lobes: Vec<(f32, Shaded)>,
    /// Sums of shares.
    ends: Vec<f32>,
}

impl Drawn {
    fn new(lobes: &[(f32, Candidate)]) -> Self {
        let lobes: Vec<_> = lobes.iter().map(|&(share, lobe)| (share, Shaded::new(lobe))).collect();
        let mut upto = 0.0;
        let mut end = |(share, _): &(f32, Shaded)| {
            upto += share;
            upto
        };
        let ends = lobes.iter().map(&mut end).collect();
        Self { lobes, ends }
    }

    /// Nothing, if there are none.
    fn draw(&self, place: Place) -> Option<Vec3> {
        let chosen = self.ends.partition_point(|end| *end <= place.lobe);
        self.lobes.get(chosen).or(self.lobes.last()).map(|(_, lobe)| lobe.draw(place))
    }
}

/// [`LobeError::others`] for one view.
struct Together<'a> {
    seen: &'a Seen,
    lobes: &'a [(f32, Shaded)],
}

impl pulp::WithSimd for Together<'_> {
    type Output = Row;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Row {
        let (mut f, mut all) = ([0.0; HALVES], [0.0; HALVES]);
        for (share, lobe) in self.lobes {
            self.seen.reflect(lobe, &mut f, None);
            for j in 0..HALVES {
                all[j] += share * f[j] * self.seen.share[j];
            }
        }
        all
    }
}

/// [`LobeError::of`] for the processor's vector registers. A type, and no closure: calls of closures are not inlined there.
struct Apart<'a> {
    from: &'a LobeError,
    lobe: Shaded,
    /// Its share, and the others.
    beside: Option<(f32, &'a Others)>,
}

impl pulp::WithSimd for Apart<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f32 {
        let (mut apart, mut own) = (0.0, 0.0);
        for (view, seen) in self.from.seen.iter().enumerate() {
            let (mut f, mut off) = ([0.0; HALVES], [0.0; HALVES]);
            seen.reflect(&self.lobe, &mut f, None);
            for j in 0..HALVES {
                f[j] *= seen.share[j];
            }
            if let Some((share, Others(rows))) = self.beside {
                for j in 0..HALVES {
                    f[j] = share * f[j] + (1.0 - share) * rows[view][j];
                }
            }
            for j in 0..HALVES {
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
    guess: &'a [(f32, Shaded)],
}

impl pulp::WithSimd for Reference<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { seen, lobes, guess } = self;
        let (mut f, mut pdf) = ([0.0; HALVES], [0.0; HALVES]);
        let (mut mean, mut density) = ([0.0; HALVES], [0.0; HALVES]);
        for (share, lobe) in guess {
            seen.reflect(lobe, &mut f, Some(&mut pdf));
            for j in 0..HALVES {
                density[j] += share * pdf[j];
            }
        }
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
    fn new(view: Vec3, half: &[Vec3; HALVES], lobes: &[(f32, Shaded)], guess: &[(f32, Shaded)]) -> Self {
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
mod tests;
#[cfg(test)]
pub use tests::exact;
