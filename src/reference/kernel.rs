//! Sums over many lobes at many places: the inner loops of the judge.
//!
//! Loops run over the places, whose constants lie in planes, with one lobe's constants in registers, so that they fill
//! vector registers without a sum across lanes. `pulp` picks a clone for AVX2 where there is one; Rust never contracts
//! products and sums, so every clone gives the same bits.

use glam::DVec3;

use super::lobe::{PreparedLobe, products, quadratic};

/// Half vectors, each with the view and the light that it halves, grouped by view.
#[derive(Clone, Debug, Default)]
pub struct Queries {
    /// One view and the end of its group.
    groups: Vec<(DVec3, usize)>,
    /// m.x m.y m.z, then the products of their components.
    half: [Vec<f64>; 9],
    /// l.x l.y l.z, then the products of their components.
    light: [Vec<f64>; 9],
    /// 1 for lights above the surface, else 0.
    above: Vec<f64>,
}

fn push(planes: &mut [Vec<f64>; 9], v: DVec3) {
    let values = v.to_array().into_iter().chain(products(v));
    planes.iter_mut().zip(values).for_each(|(plane, value)| plane.push(value));
}

impl Queries {
    /// Starts the group of a view (unit, above the surface); what is added then belongs to it.
    pub fn start_view(&mut self, view: DVec3) {
        self.groups.push((view, self.len()));
    }

    /// A light given by the half vector (unit) at which a facet mirrors it to the view.
    pub fn push_half(&mut self, m: DVec3) {
        let view = self.groups.last().expect("a view was started").0;
        self.push(m, 2.0 * view.dot(m) * m - view);
    }

    /// A light (unit).
    pub fn push_light(&mut self, l: DVec3) {
        let view = self.groups.last().expect("a view was started").0;
        self.push((view + l).try_normalize().unwrap_or(DVec3::NEG_Z), l);
    }

    fn push(&mut self, m: DVec3, l: DVec3) {
        push(&mut self.half, m);
        push(&mut self.light, l);
        self.above.push(if l.z > 0.0 { 1.0 } else { 0.0 });
        self.groups.last_mut().expect("a view was started").1 = self.above.len();
    }

    /// Number of half vectors.
    pub fn len(&self) -> usize {
        self.above.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.above.is_empty()
    }

    /// Half vector `j`.
    pub fn half(&self, j: usize) -> DVec3 {
        DVec3::new(self.half[0][j], self.half[1][j], self.half[2][j])
    }

    /// The views, in order.
    pub fn views(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.groups.iter().map(|group| group.0)
    }

    /// The part of the half vectors that belongs to each view, in order.
    pub fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let starts = std::iter::once(0).chain(self.groups.iter().map(|group| group.1));
        starts.zip(&self.groups).map(|(start, group)| start..group.1)
    }
}

/// Weighted means over the lobes of a footprint, for each half vector or light that was asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Means {
    /// Sum of the weights of the lobes.
    pub weight: f64,
    /// The footprint NDF, `sum w_i D_i(m) / (n_i . z)`; 1/sr.
    pub d: Vec<f64>,
    /// Density at which [`super::Footprint::draw`] draws m, `sum w_i D_i(m) (m . n_i)`; 1/sr.
    pub pdf: Vec<f64>,
    /// Specular BRDF times cosine, F = 1, 0 for lights below the surface; 1/sr.
    pub specular: Vec<f64>,
    /// The same with every lobe's own multiple-scattering compensation.
    pub compensated: Vec<f64>,
    /// `max(0, n . l)` for each of the lights of a [`Diffuse`] list.
    pub diffuse: Vec<f64>,
}

/// Lights for the diffuse term, unit, in planes.
#[derive(Clone, Debug, Default)]
pub struct Diffuse([Vec<f64>; 3]);

impl Diffuse {
    /// A list of unit directions.
    pub fn new(lights: &[DVec3]) -> Self {
        Self([0, 1, 2].map(|i| lights.iter().map(|l| l[i]).collect()))
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Means {
    pub(super) fn zeros(queries: &Queries, lights: &Diffuse) -> Self {
        let zeros = vec![0.0; queries.len()];
        Self {
            weight: 0.0,
            d: zeros.clone(),
            pdf: zeros.clone(),
            specular: zeros.clone(),
            compensated: zeros,
            diffuse: vec![0.0; lights.len()],
        }
    }

    /// The mean over several footprints, each by its weight. At least one.
    pub fn merged(groups: &[&Means]) -> Means {
        let mut merged = groups[0].clone();
        // Differences from the first, so that equal means stay as they are.
        merged.weight = groups.iter().map(|group| group.weight).sum();
        for group in &groups[1..] {
            let share = group.weight / merged.weight;
            let mut other = (*group).clone();
            for ((mean, other), first) in merged.planes().into_iter().zip(other.planes()).zip(groups[0].all()) {
                mean.iter_mut().zip(other).zip(first).for_each(|((mean, v), first)| *mean += share * (*v - first));
            }
        }
        merged
    }

    fn all(&self) -> [&Vec<f64>; 5] {
        [&self.d, &self.pdf, &self.specular, &self.compensated, &self.diffuse]
    }

    pub(super) fn planes(&mut self) -> [&mut Vec<f64>; 5] {
        [&mut self.d, &mut self.pdf, &mut self.specular, &mut self.compensated, &mut self.diffuse]
    }
}

/// Adds the difference between each lobe and `control` (a lobe's own values) at every half vector and light, times the
/// lobe's weight. Sums of differences are exactly 0 where all lobes are the same.
pub(super) fn accumulate(
    lobes: &[PreparedLobe],
    gain: &dyn Fn(f64, f64) -> f64,
    queries: &Queries,
    lights: &Diffuse,
    control: &Means,
    sums: &mut Means,
) {
    sums.weight += lobes.iter().map(|lobe| lobe.weight).sum::<f64>();
    for (view, range) in queries.views().zip(queries.ranges()) {
        // Of each lobe: cosine and stretch of the view, gain by multiple scattering.
        let seen: Vec<[f64; 3]> = lobes
            .iter()
            .map(|lobe| {
                let cos = lobe.normal.dot(view);
                [cos, quadratic(&lobe.ellipsoid, view).sqrt(), gain(cos.max(0.0), lobe.alpha)]
            })
            .collect();
        let group = Group {
            half: queries.half.each_ref().map(|plane| &plane[range.clone()]),
            light: queries.light.each_ref().map(|plane| &plane[range.clone()]),
            above: &queries.above[range.clone()],
            control: [&control.d, &control.pdf, &control.specular, &control.compensated]
                .map(|plane| &plane[range.clone()]),
        };
        let sums = [&mut sums.d, &mut sums.pdf, &mut sums.specular, &mut sums.compensated]
            .map(|plane| &mut plane[range.clone()]);
        pulp::Arch::new().dispatch(|| group.add(lobes, &seen, sums));
    }
    pulp::Arch::new().dispatch(|| add_diffuse(lobes, lights, &control.diffuse, &mut sums.diffuse));
}

/// The half vectors of one view.
struct Group<'a> {
    half: [&'a [f64]; 9],
    light: [&'a [f64]; 9],
    above: &'a [f64],
    control: [&'a [f64]; 4],
}

impl Group<'_> {
    #[inline(always)]
    fn add(&self, lobes: &[PreparedLobe], seen: &[[f64; 3]], sums: [&mut [f64]; 4]) {
        let n = self.above.len();
        let [mx, my, mz, mxx, myy, mzz, mxy, mxz, myz] = self.half.map(|plane| &plane[..n]);
        let [lx, ly, lz, lxx, lyy, lzz, lxy, lxz, lyz] = self.light.map(|plane| &plane[..n]);
        let above = &self.above[..n];
        let [d0, pdf0, f0, fc0] = self.control.map(|plane| &plane[..n]);
        let [d_sum, pdf_sum, f_sum, fc_sum] = sums.map(|plane| &mut plane[..n]);
        for (lobe, &[cos_view, stretch_view, gain]) in lobes.iter().zip(seen) {
            let (DVec3 { x, y, z }, q, s) = (lobe.normal, lobe.inverse, lobe.ellipsoid);
            let (w, scale, lift) = (lobe.weight, lobe.scale, 1.0 / z);
            // A facet that faces away shows nothing.
            let (visible, cos_view) = if cos_view > 0.0 { (1.0, cos_view) } else { (0.0, 1.0) };
            for j in 0..n {
                let cos = x * mx[j] + y * my[j] + z * mz[j];
                let t = q[0] * mxx[j] + q[1] * myy[j] + q[2] * mzz[j] + q[3] * mxy[j] + q[4] * mxz[j] + q[5] * myz[j];
                let cos_light = (x * lx[j] + y * ly[j] + z * lz[j]).max(0.0);
                let stretch =
                    s[0] * lxx[j] + s[1] * lyy[j] + s[2] * lzz[j] + s[3] * lxy[j] + s[4] * lxz[j] + s[5] * lyz[j];
                // D = scale / t^2 and D G2 / (4 n.v) = D n.l / (2 (s_v n.l + s_l n.v)), with one division for both.
                let below = 2.0 * (stretch_view * cos_light + stretch.max(0.0).sqrt() * cos_view);
                let both = scale / (t * t * below);
                let d = if cos > 0.0 { both * below } else { 0.0 };
                let f = both * cos_light * (visible * above[j]);
                d_sum[j] += w * (d * lift - d0[j]);
                pdf_sum[j] += w * (d * cos - pdf0[j]);
                f_sum[j] += w * (f - f0[j]);
                fc_sum[j] += w * (f * gain - fc0[j]);
            }
        }
    }
}

#[inline(always)]
fn add_diffuse(lobes: &[PreparedLobe], lights: &Diffuse, control: &[f64], sums: &mut [f64]) {
    let n = sums.len();
    let [lx, ly, lz] = lights.0.each_ref().map(|plane| &plane[..n]);
    let control = &control[..n];
    for lobe in lobes {
        let (DVec3 { x, y, z }, w) = (lobe.normal, lobe.weight);
        for j in 0..n {
            sums[j] += w * ((x * lx[j] + y * ly[j] + z * lz[j]).max(0.0) - control[j]);
        }
    }
}

/// Adds `w D(m) / (n . z)` of each lobe at every normal of `at` (planes x y z).
pub(super) fn add_density(lobes: &[PreparedLobe], at: [&[f64]; 3], sums: &mut [f64]) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let n = sums.len();
            let [mx, my, mz] = at.map(|plane| &plane[..n]);
            for lobe in lobes {
                let (DVec3 { x, y, z }, q) = (lobe.normal, lobe.inverse);
                let scale = lobe.weight * lobe.scale / z;
                for j in 0..n {
                    let (a, b, c) = (mx[j], my[j], mz[j]);
                    let t = a * (q[0] * a + q[3] * b + q[4] * c) + b * (q[1] * b + q[5] * c) + q[2] * c * c;
                    let d = scale / (t * t);
                    sums[j] += if x * a + y * b + z * c > 0.0 { d } else { 0.0 };
                }
            }
        },
    );
}
