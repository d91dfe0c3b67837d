//! Of `kernels/wgsl/footprint.wgsl`.

use super::geometric_aa::{ROUNDING, TENSOR, derivatives, tensor, v2, v3, with_tensor_at};
use crate::case::{Bound, Case, Sweep};
use crate::twins::footprint as twins;
use crate::twins::geometric_aa::{MOST_ADDED, SIGMA2_BOX, SIGMA2_HALF, SIGMA2_PEAK};
use crate::twins::moments::{Lobe, bent};

const FILTERS: [f64; 3] = [SIGMA2_PEAK, SIGMA2_HALF, SIGMA2_BOX];

fn footprint(a: &[f64]) -> twins::Footprint {
    let [normal, tensor, base, dndx, dndy, dmdx, dmdy] = std::array::from_fn(|i| v3(a, 3 * i));
    twins::Footprint { normal, tensor, base, dndx, dndy, dmdx, dmdy, sigma2: a[21], most: a[22], texel: a[23] }
}

fn lobe(l: Lobe) -> Vec<f64> {
    [l.normal.to_array(), l.tensor.to_array()].concat()
}

/// Normals, a tensor, a share of it as the base, derivatives of both sources, filter, clamp and texel; then further ones.
fn inputs(count: usize) -> Vec<Vec<f64>> {
    let sweep = tensor(Sweep::new(count).hemisphere()).linear(0.0, 1.0);
    let sweep =
        derivatives(derivatives(sweep, 3), 3).one_of(&FILTERS).one_of(&[MOST_ADDED, 1.0]).one_of(&[1.0, 0.0, 0.6]);
    let with_base = |a: Vec<f64>| {
        let base = [a[3] * a[6], a[4] * a[6], a[5] * a[6]];
        [&a[..6], &base, &a[7..]].concat()
    };
    with_tensor_at(sweep.inputs(), 3).into_iter().map(with_base).collect()
}

/// Calls with no derivatives: the lobe comes back bit by bit.
fn still(count: usize) -> Vec<Vec<f64>> {
    let stopped = |mut a: Vec<f64>| {
        a[9..21].fill(0.0);
        a
    };
    inputs(count).into_iter().map(stopped).collect()
}

/// A lobe of widths from 0.02, and a light that its normal, or a facet near it, mirrors to the view; f0, glint ratio and scale.
fn mirrored(count: usize) -> Vec<Vec<f64>> {
    let sweep = Sweep::new(count).hemisphere().log(0.02, 1.0).log(0.02, 1.0).linear(-3.2, 3.2).hemisphere();
    let sweep = sweep.signed_log(1e-3, 0.5).signed_log(1e-3, 0.5);
    let sweep = sweep.linear(0.0, 1.0).linear(0.0, 1.0).linear(0.0, 1.0).linear(0.0, 3.0).linear(0.0, 1.0);
    let light = |a: Vec<f64>| {
        let (n, v) = (v3(&a, 0), v3(&a, 6));
        let (t, b) = bent(n);
        let m = (n + a[9] * t + a[10] * b).normalize();
        let l = 2.0 * m.dot(v) * m - v;
        [&a[..9], l.as_ref(), &a[11..]].concat()
    };
    // Where they are all but opposite, the half vector is a difference of little left.
    let apart = |a: &Vec<f64>| (v3(a, 6) + v3(a, 9)).length() > 0.1;
    with_tensor_at(sweep.inputs(), 3).into_iter().map(light).filter(apart).collect()
}

/// Nothing but the same bits.
const SAME: Bound = Bound { absolute: 0.0, relative: 0.0 };

fn unchanged(a: &[f64]) -> Vec<f64> {
    a[..6].to_vec()
}

/// All functions.
pub fn cases() -> Vec<Case> {
    vec![
        Case {
            name: "mf_bent_components",
            inputs: Sweep::new(1000).hemisphere().edges(&[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]).sphere().inputs(),
            bound: Bound { absolute: 4e-7, relative: 5e-7 },
            twin: |a| twins::bent_components(v3(a, 0), v3(a, 3)).to_array().into(),
        },
        Case {
            name: "mf_carried_derivative",
            inputs: derivatives(Sweep::new(500).hemisphere(), 3).inputs().iter().map(|a| a[..6].to_vec()).collect(),
            twin: |a| twins::carried_derivative(v3(a, 0), v3(a, 3)).to_array().into(),
            bound: Bound { absolute: 3e-8, ..ROUNDING },
        },
        Case {
            name: "mf_carried_kernel",
            inputs: with_tensor_at(tensor(Sweep::new(2000).hemisphere()).inputs(), 3),
            twin: |a| twins::carried_kernel(v3(a, 0), v3(a, 3)).to_array().into(),
            bound: Bound { absolute: 2e-7, ..ROUNDING },
        },
        Case {
            name: "mf_folded_share",
            inputs: Sweep::new(300).linear(0.0, 0.5).one_of(&[0.0, 0.3, 1.0, 2.0]).inputs(),
            twin: |a| vec![twins::folded_share(a[0], a[1])],
            bound: ROUNDING,
        },
        Case {
            name: "mf_residual_kernel",
            inputs: with_tensor_at(with_tensor_at(tensor(tensor(Sweep::new(2000))).linear(0.0, 1.0).inputs(), 0), 3),
            twin: |a| twins::residual_kernel(v3(a, 0), v3(a, 3), a[6]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_footprint_lobe",
            inputs: derivatives(Sweep::new(2000), 2)
                .inputs()
                .into_iter()
                .zip(inputs(2000))
                .map(|(more, a)| [a, more].concat())
                .collect(),
            twin: |a| lobe(twins::footprint_lobe(footprint(a), v2(a, 24), v2(a, 26))),
            bound: TENSOR,
        },
        Case {
            name: "mf_footprint_normals",
            inputs: inputs(2000),
            twin: |a| lobe(twins::footprint_normals(footprint(a))),
            bound: TENSOR,
        },
        Case { name: "mf_footprint_normals", inputs: still(500), twin: unchanged, bound: SAME },
        Case {
            name: "mf_footprint_half_vectors",
            inputs: inputs(2000),
            twin: |a| lobe(twins::footprint_half_vectors(footprint(a))),
            bound: TENSOR,
        },
        Case { name: "mf_footprint_half_vectors", inputs: still(500), twin: unchanged, bound: SAME },
        Case {
            name: "mf_diffuse_cosine",
            inputs: Sweep::new(1000).linear(0.0, 1.0).edges(&[0.999]).linear(-1.0, 1.0).edges(&[0.0]).inputs(),
            twin: |a| vec![twins::diffuse_cosine(a[0], a[1])],
            bound: Bound { absolute: 2e-7, relative: 2e-6 },
        },
        Case {
            name: "mf_footprint_shade",
            inputs: mirrored(2000),
            twin: |a| {
                let lobe = Lobe { normal: v3(a, 0), tensor: v3(a, 3) };
                let r = twins::footprint_shade(lobe, v3(a, 6), v3(a, 9), v3(a, 12), a[15], a[16]);
                [r.specular.to_array().as_slice(), &[r.diffuse]].concat()
            },
            // On the flank of a width of 0.02, the half vector's roundings move D by 2e-5; beside a width of 1 the determinant
            // has lost a further digit or two. Straight above and below, the softened cosine has the root of a rounding.
            bound: Bound { absolute: 3e-5, relative: 2e-4 },
        },
    ]
}
