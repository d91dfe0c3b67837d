//! Of `kernels/wgsl/geometric_aa.wgsl` and `geometric_aa_screen.wgsl`.

use glam::{DVec2, DVec3};

use crate::case::{Bound, Case, Sweep};
use crate::twins::geometric_aa as twins;

/// The arguments from `at` on as a vector.
pub(super) fn v2(a: &[f64], at: usize) -> DVec2 {
    DVec2::new(a[at], a[at + 1])
}

/// The same of three.
pub(super) fn v3(a: &[f64], at: usize) -> DVec3 {
    DVec3::new(a[at], a[at + 1], a[at + 2])
}

/// A few roundings of f32.
pub(super) const ROUNDING: Bound = Bound { absolute: 1e-9, relative: 5e-7 };

/// Tensors: entries are sums of terms as large as the largest, and the mixed one may cancel. Beside a width of 1, a width of
/// 0.001 is known to half.
pub(super) const TENSOR: Bound = Bound { absolute: 3e-7, relative: 1e-6 };

/// Sums of terms of either sign, none above 4 or so.
const SUM: Bound = Bound { absolute: 3e-7, relative: 1e-6 };

/// A call's tensor, given as two widths and an angle in its first three arguments, as xx, xy, yy.
pub(super) fn with_tensor(inputs: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    with_tensor_at(inputs, 0)
}

/// The same of the arguments from `at` on.
pub(super) fn with_tensor_at(mut inputs: Vec<Vec<f64>>, at: usize) -> Vec<Vec<f64>> {
    for call in &mut inputs {
        let (sin, cos) = call[at + 2].sin_cos();
        let (x2, y2) = (call[at] * call[at], call[at + 1] * call[at + 1]);
        let entries = [x2 * cos * cos + y2 * sin * sin, (x2 - y2) * sin * cos, x2 * sin * sin + y2 * cos * cos];
        call[at..at + 3].copy_from_slice(&entries);
    }
    inputs
}

/// Two widths and an angle, for [`with_tensor`].
pub(super) fn tensor(sweep: Sweep) -> Sweep {
    sweep.log(0.001, 1.0).log(0.001, 1.0).linear(-3.2, 3.2).edges(&[0.0, std::f64::consts::FRAC_PI_4])
}

/// Derivatives per pixel along both axes of the screen.
pub(super) fn derivatives(sweep: Sweep, components: usize) -> Sweep {
    derivatives_of(sweep, components, 1e-4, 0.7)
}

fn derivatives_of(sweep: Sweep, components: usize, low: f64, high: f64) -> Sweep {
    (0..2 * components).fold(sweep, |sweep, _| sweep.signed_log(low, high))
}

fn filter(sweep: Sweep) -> Sweep {
    sweep.one_of(&[twins::SIGMA2_PEAK, twins::SIGMA2_HALF, twins::SIGMA2_BOX, 0.0])
}

fn with_most(sweep: Sweep) -> Sweep {
    filter(sweep).one_of(&[twins::MOST_ADDED, 0.04, 1.0])
}

/// Derivatives of unit vectors: the arguments from each `at` on lose their part along the vector from `of` on.
fn tangential(mut inputs: Vec<Vec<f64>>, pairs: &[(usize, usize)]) -> Vec<Vec<f64>> {
    for call in &mut inputs {
        for &(of, at) in pairs {
            let (u, d) = (v3(call, of), v3(call, at));
            call[at..at + 3].copy_from_slice(&(d - u * u.dot(d)).to_array());
        }
    }
    inputs
}

fn kernel_of(a: &[f64], at: usize, sigma2: f64) -> DVec3 {
    twins::kernel(v2(a, at), v2(a, at + 2), sigma2)
}

/// Calls whose tensor is followed by derivatives, which become a kernel.
fn with_kernel(sweep: Sweep) -> Vec<Vec<f64>> {
    let kernel = |call: Vec<f64>| {
        let k = kernel_of(&call, 3, twins::SIGMA2_PEAK);
        [&call[..3], k.as_ref()].concat()
    };
    with_tensor(derivatives(tensor(sweep), 2).inputs()).into_iter().map(kernel).collect()
}

/// Of narrow lobes along the axes, for which [`TENSOR`] would be all of alpha^2: relative, but for the mixed entry, which is
/// the kernel's and may cancel.
const NARROW: Bound = Bound { absolute: 1e-12, relative: 1e-6 };

/// Round lobes and lobes of two widths along the axes, and derivatives as small.
fn narrow() -> Sweep {
    derivatives_of(Sweep::new(1500).log(0.001, 0.05).log(0.001, 0.05).one_of(&[0.0]), 2, 1e-6, 1e-3)
}

fn narrow_inputs(sweep: Sweep) -> Vec<Vec<f64>> {
    let mut inputs = sweep.inputs();
    for call in inputs.iter_mut().step_by(3) {
        call[1] = call[0];
    }
    with_tensor(inputs)
}

fn narrow_cases() -> Vec<Case> {
    let case = |name, inputs, twin| Case { name, inputs, twin, bound: NARROW };
    let kernels = || {
        let calls = narrow_inputs(narrow()).into_iter();
        calls.map(|a| [&a[..3], kernel_of(&a, 3, twins::SIGMA2_PEAK).as_ref()].concat()).collect()
    };
    let means = || Sweep::new(300).log(1e-8, 1e-3).log(1e-10, 1e-3).edges(&[0.0]).inputs();
    vec![
        case("mf_add_kernel", kernels(), |a| twins::add_kernel(v3(a, 0), v3(a, 3)).to_array().into()),
        case("mf_add_kernel_projected", kernels(), |a| {
            twins::add_kernel_projected(v3(a, 0), v3(a, 3)).to_array().into()
        }),
        case("mf_add_kernel_mean", means(), |a| vec![twins::add_kernel_mean(a[0], a[1])]),
        case("mf_add_kernel_projected_mean", means(), |a| vec![twins::add_kernel_projected_mean(a[0], a[1])]),
        case("mf_aa_2019", narrow_inputs(filter(narrow())), |a| {
            twins::aa_2019(v3(a, 0), v2(a, 3), v2(a, 5), a[7]).to_array().into()
        }),
        case("mf_aa_2021", narrow_inputs(filter(narrow())), |a| {
            twins::aa_2021(v3(a, 0), v2(a, 3), v2(a, 5), a[7]).to_array().into()
        }),
    ]
}

/// All functions.
pub fn cases() -> Vec<Case> {
    let mut all = wide_cases();
    all.extend(narrow_cases());
    all
}

fn wide_cases() -> Vec<Case> {
    let whole = |components: usize| with_tensor(with_most(derivatives(tensor(Sweep::new(2000)), components)).inputs());
    let unclamped = || with_tensor(filter(derivatives(tensor(Sweep::new(2000)), 2)).inputs());
    let normals = || with_most(derivatives(Sweep::new(1000).log(1e-6, 1.0), 3)).inputs();
    vec![
        Case {
            name: "mf_half_vector_derivative",
            inputs: tangential(derivatives(Sweep::new(1000).hemisphere().hemisphere(), 3).inputs(), &[(0, 6), (3, 9)]),
            // Towards opposite directions the half vector turns ever faster: by 1 / |v + l|.
            bound: Bound { absolute: 3e-7, relative: 1e-5 },
            twin: |a| twins::half_vector_derivative(v3(a, 0), v3(a, 3), v3(a, 6), v3(a, 9)).to_array().into(),
        },
        Case {
            name: "mf_projected_derivative",
            inputs: Sweep::new(1000).hemisphere().sphere().hemisphere().sphere().sphere().sphere().inputs(),
            twin: |a| {
                let [h, dh, n, dn, t, b] = std::array::from_fn(|i| v3(a, 3 * i));
                twins::projected_derivative(h, dh, n, dn, t, b).to_array().into()
            },
            bound: SUM,
        },
        Case {
            name: "mf_slope_derivative",
            inputs: tangential(Sweep::new(1000).hemisphere().disk().linear(-1.0, 1.0).inputs(), &[(0, 3)]),
            // Over the cosine squared, down to 0.02^2: a rounding of the derivative grows by 2500.
            bound: Bound { absolute: 1e-4, relative: 2e-6 },
            twin: |a| twins::slope_derivative(v3(a, 0), v3(a, 3)).to_array().into(),
        },
        Case {
            name: "mf_kernel",
            inputs: filter(derivatives(Sweep::new(1000), 2)).inputs(),
            twin: |a| kernel_of(a, 0, a[4]).to_array().into(),
            bound: Bound { absolute: 3e-8, ..ROUNDING },
        },
        Case {
            name: "mf_kernel_rectangle",
            inputs: filter(derivatives(Sweep::new(1000), 2)).inputs(),
            twin: |a| twins::kernel_rectangle(v2(a, 0), v2(a, 2), a[4]).to_array().into(),
            bound: ROUNDING,
        },
        Case {
            name: "mf_kernel_mean",
            inputs: filter(derivatives(Sweep::new(500), 3)).inputs(),
            twin: |a| vec![twins::kernel_mean(v3(a, 0), v3(a, 3), a[6])],
            bound: ROUNDING,
        },
        Case {
            name: "mf_kernel_bound",
            inputs: filter(derivatives(Sweep::new(500), 3)).inputs(),
            twin: |a| vec![twins::kernel_bound(v3(a, 0), v3(a, 3), a[6])],
            bound: ROUNDING,
        },
        Case {
            name: "mf_kernel_clamp",
            inputs: with_tensor(tensor(Sweep::new(1000)).one_of(&[twins::MOST_ADDED, 0.04, 1.0]).inputs()),
            twin: |a| twins::kernel_clamp(v3(a, 0), a[3]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_add_kernel",
            inputs: with_kernel(Sweep::new(2000)),
            twin: |a| twins::add_kernel(v3(a, 0), v3(a, 3)).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_add_kernel_mean",
            inputs: Sweep::new(300).log(1e-6, 1.0).signed_log(1e-6, 1.0).inputs(),
            twin: |a| vec![twins::add_kernel_mean(a[0], a[1])],
            bound: Bound { absolute: 3e-8, ..ROUNDING },
        },
        Case {
            name: "mf_add_kernel_projected",
            inputs: with_kernel(Sweep::new(2000)),
            twin: |a| twins::add_kernel_projected(v3(a, 0), v3(a, 3)).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_add_kernel_projected_mean",
            inputs: Sweep::new(500).log(1e-6, 1.0).log(1e-8, 100.0).edges(&[0.0]).inputs(),
            twin: |a| vec![twins::add_kernel_projected_mean(a[0], a[1])],
            bound: ROUNDING,
        },
        Case {
            name: "mf_aa_2016",
            inputs: with_tensor(derivatives(tensor(Sweep::new(2000)), 2).one_of(&[0.7, 0.1, 1.0]).inputs()),
            twin: |a| twins::aa_2016(v3(a, 0), v2(a, 3), v2(a, 5), a[7]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_aa_2016_full",
            inputs: unclamped(),
            twin: |a| twins::aa_2016_full(v3(a, 0), v2(a, 3), v2(a, 5), a[7]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_aa_2019_axes",
            inputs: whole(2),
            twin: |a| twins::aa_2019_axes(v3(a, 0), v2(a, 3), v2(a, 5), a[7], a[8]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_aa_2019",
            inputs: unclamped(),
            twin: |a| twins::aa_2019(v3(a, 0), v2(a, 3), v2(a, 5), a[7]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_aa_2019_normals",
            inputs: normals(),
            twin: |a| vec![twins::aa_2019_normals(a[0], v3(a, 1), v3(a, 4), a[7], a[8])],
            bound: ROUNDING,
        },
        Case {
            name: "mf_aa_2021",
            inputs: unclamped(),
            twin: |a| twins::aa_2021(v3(a, 0), v2(a, 3), v2(a, 5), a[7]).to_array().into(),
            bound: TENSOR,
        },
        Case {
            name: "mf_aa_2021_normals",
            inputs: normals(),
            twin: |a| vec![twins::aa_2021_normals(a[0], v3(a, 1), v3(a, 4), a[7], a[8])],
            bound: ROUNDING,
        },
    ]
}

/// Calls for a screen: the tensor and all but the vector stay from pixel to pixel. `first` arguments come before the vector,
/// of which both derivatives follow, and then the rest.
fn on_screen(inputs: Vec<Vec<f64>>, first: usize) -> Vec<Vec<f64>> {
    let spread = |call: Vec<f64>| {
        let still = |n: usize| vec![0.0; n];
        let after = call.len() - first - 9;
        let vector = |k: usize| &call[first + 3 * k..first + 3 * k + 3];
        let at = [&call[..first], vector(0), &call[first + 9..]].concat();
        let along = |k: usize| [still(first), vector(k).to_vec(), still(after)].concat();
        [at, along(1), along(2)].concat()
    };
    inputs.into_iter().map(spread).collect()
}

/// Of a call with n arguments a pixel: the vector's derivatives along x and y, from `at` on.
fn differences(a: &[f64], n: usize, at: usize) -> (DVec3, DVec3) {
    (v3(a, n + at), v3(a, 2 * n + at))
}

/// Differences of neighbours in f32: a vector of length 1 is known to 6e-8, its derivative to 2e-7, and the kernel's share
/// of alpha^2 to 4e-7 times the derivative.
const SCREEN: Bound = Bound { absolute: 3e-7, relative: 1e-6 };

/// All functions of the screen.
pub fn screen_cases() -> Vec<Case> {
    let normals = || on_screen(with_most(derivatives(Sweep::new(500).log(1e-6, 1.0).sphere(), 3)).inputs(), 1);
    let halves = || derivatives(tensor(Sweep::new(1000)).hemisphere(), 3);
    vec![
        Case {
            name: "mf_aa_screen_normal",
            inputs: normals(),
            twin: |a| {
                let (dx, dy) = differences(a, 6, 1);
                vec![twins::aa_screen_normal(a[0], dx, dy, a[4], a[5])]
            },
            bound: SCREEN,
        },
        Case {
            name: "mf_aa_screen_normal_bound",
            inputs: normals(),
            twin: |a| {
                let (dx, dy) = differences(a, 6, 1);
                vec![twins::aa_screen_normal_bound(a[0], dx, dy, a[4], a[5])]
            },
            bound: SCREEN,
        },
        Case {
            name: "mf_aa_screen_half_vector",
            inputs: on_screen(with_tensor(filter(halves()).inputs()), 3),
            twin: |a| {
                let (dx, dy) = differences(a, 7, 3);
                twins::aa_screen_half_vector(v3(a, 0), dx, dy, a[6]).to_array().into()
            },
            bound: SCREEN,
        },
        Case {
            name: "mf_aa_screen_half_vector_axes",
            inputs: on_screen(with_tensor(with_most(halves()).inputs()), 3),
            twin: |a| {
                let (dx, dy) = differences(a, 8, 3);
                twins::aa_screen_half_vector_axes(v3(a, 0), dx, dy, a[6], a[7]).to_array().into()
            },
            bound: SCREEN,
        },
        Case {
            name: "mf_aa_screen_slope",
            inputs: on_screen(with_tensor(halves().one_of(&[0.7, 0.1, 1.0]).inputs()), 3),
            twin: |a| {
                let (dx, dy) = differences(a, 7, 3);
                twins::aa_screen_slope(v3(a, 0), v3(a, 3), dx, dy, a[6]).to_array().into()
            },
            // Slopes up to 50 are known to 4e-6, and so are their differences.
            bound: Bound { absolute: 1e-5, relative: 1e-5 },
        },
    ]
}
