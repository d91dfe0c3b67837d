//! Based on: the lobe error of [`crate::compare`], searched by J. A. Nelder, R. Mead, 1965.

use glam::Vec3;

use super::fit::lobe_error::{Candidate, LobeError, Others};
use super::fit::simplex::{Stop, minimise};
use super::fit::{Chunk, Fitted, Shape};
use super::{Fold, Method, ggx};
use crate::ndf::{Form, Frame, RoughnessTensor};
use crate::summary::Entry;

/// The GGX lobe, or few lobes, of least lobe error: those of `ggx`, moved until they look most like the footprint.
pub const FOLD: Fold = Fold {
    name: "ggx-lobe",
    cite: "Nelder & Mead 1965",
    about: "the GGX lobes that look most alike: `ggx`, then a search",
    method: Method::Lobes { most: MOST, mixtures: true, slow: true, fit },
};

/// Lobes of a summary: twice as many a side as for `ggx`.
const MOST: usize = 64;

/// Lobe error below which nothing is searched: rounding alone may leave as much.
const NOTHING: f32 = 2e-3;

/// Share of the lobe error by which a search must lessen it, so that what rounding brings moves no lobe.
const NOTICEABLE: f32 = 5e-3;

/// Lobe error from which a search begins again from the footprint's own lobes.
const UNLIKE: f32 = 0.5;

/// The first corners of a search lie this far from its start, in widths of the lobe, in logarithms of them, and of the odds
/// of its share.
const REACH: f32 = 0.2;

/// Search ends where corners differ by this share of the error.
const SPREAD: f32 = 2e-3;

/// Least squared width of a search, as that of the smoothest texels.
const LEAST: f32 = 1e-12;

/// Least z of a normal.
const LOWEST: f32 = 1e-3;

/// Rounds through the lobes of a mixture.
const ROUNDS: usize = 2;

/// Share below which a lobe of a mixture stays as it is.
const LEAST_SHARE: f32 = 1e-3;

fn fit(chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    ggx::fit(chunk, shape, out);
    for i in 0..chunk.count {
        if let [out] = out {
            let start = lane(out, i);
            put(out, i, refine(chunk.footprint(i), shape.form, start));
        } else {
            let mut lobes: Vec<_> = out.iter().map(|out| (out.weight[i], lane(out, i))).collect();
            refine_several(chunk.footprint(i), shape, &mut lobes);
            for (out, (share, lobe)) in out.iter_mut().zip(lobes) {
                out.weight[i] = share;
                put(out, i, lobe);
            }
        }
    }
}

fn lane(fitted: &Fitted, i: usize) -> Candidate {
    let [xx, xy, yy] = fitted.tensor.at(i);
    (Vec3::from(fitted.normal.at(i)), RoughnessTensor { xx, xy, yy })
}

fn put(fitted: &mut Fitted, i: usize, (n, r): Candidate) {
    fitted.normal.set(i, n.to_array());
    fitted.tensor.set(i, [r.xx, r.xy, r.yy]);
}

/// The lobe that looks most like a footprint, searched from `start`; that one where none is noticeably better.
fn refine(footprint: impl Iterator<Item = Entry> + Clone, form: Form, start: Candidate) -> Candidate {
    let mut lobes = footprint.clone().filter(|e| e.weight > 0.0).map(|e| e.lobe);
    let one = lobes.next();
    if lobes.all(|other| Some(other) == one) {
        return start;
    }
    let guess = (start.0, in_form(form, start.1));
    let error = LobeError::new(footprint.clone(), &[(1.0, guess)]);
    let first = error.of(guess);
    if first.is_nan() || first <= NOTHING {
        return start;
    }
    let found = search(&error, first, form, guess);
    if found.map_or(first, |(_, value)| value) > UNLIKE {
        // Parts that no lobe covers together: the best one may lie about one of them.
        let own = error.lobes().map(|(n, r)| (n, in_form(form, r)));
        if let Some(guess) = own.min_by(|a, b| error.of(*a).total_cmp(&error.of(*b))) {
            // By half vectors that fall there.
            let near = LobeError::new(footprint.clone(), &[(1.0, guess)]);
            let first = near.of(guess);
            let (other, value) = search(&near, first, form, guess).unwrap_or((guess, first));
            let so_far = found.map_or(start, |(lobe, _)| lobe);
            return if value < (1.0 - NOTICEABLE) * near.of((so_far.0, in_form(form, so_far.1))) {
                other
            } else {
                so_far
            };
        }
    }
    found.map_or(start, |(lobe, _)| lobe)
}

/// Moves the lobes of a mixture in turn, each with its share, while the others stay as they are.
fn refine_several(footprint: impl Iterator<Item = Entry>, shape: Shape, lobes: &mut [(f32, Candidate)]) {
    let mut now: Vec<_> = lobes.iter().map(|&(share, (n, r))| (share, (n, in_form(shape.form, r)))).collect();
    let error = LobeError::new(footprint, &now);
    let count = lobes.len();
    for j in (0..ROUNDS).flat_map(|_| 0..count) {
        let (share, from) = now[j];
        // One without a share is not there, and beside one with all of it there is none.
        if !(LEAST_SHARE..1.0 - LEAST_SHARE).contains(&share) {
            continue;
        }
        let beside: Vec<_> = (0..count).filter(|other| *other != j).map(|other| now[other]).collect();
        let others = error.others(&beside);
        let first = error.of_share(share, from, &others);
        if first.is_nan() || first <= NOTHING {
            return;
        }
        let Some((more, lobe)) = search_share(&error, &others, first, shape, share, from) else { continue };
        for other in [&mut now[..], lobes] {
            other.iter_mut().for_each(|(other, _)| *other *= (1.0 - more) / (1.0 - share));
            other[j] = (more, lobe);
        }
    }
}

/// A noticeably better lobe with its share, where the error of the mixture is `first`.
fn search_share(
    error: &LobeError,
    others: &Others,
    first: f32,
    shape: Shape,
    share: f32,
    from: Candidate,
) -> Option<(f32, Candidate)> {
    let odds = share / (1.0 - share);
    let at = |x: f32, y: f32, widths: [f32; 3], more: f32| {
        let (odds, (n, r)) = (odds * more.exp(), moved(from, x, y, widths));
        // Lobes that share a normal keep it.
        (odds / (1.0 + odds), (if shape.shared_normal { from.0 } else { n }, r))
    };
    let value = |(share, lobe): (f32, Candidate)| error.of_share(share, lobe, others);
    let ((share, lobe), least) = match (shape.form, shape.shared_normal) {
        (Form::Isotropic, false) => least(first, |&[x, y, w, more]: &[f32; 4]| at(x, y, [w, 0.0, w], more), value),
        (Form::Isotropic, true) => least(first, |&[w, more]: &[f32; 2]| at(0.0, 0.0, [w, 0.0, w], more), value),
        (Form::Anisotropic, false) => {
            least(first, |&[x, y, a, b, c, more]: &[f32; 6]| at(x, y, [a, b, c], more), value)
        }
        (Form::Anisotropic, true) => least(first, |&[a, b, c, more]: &[f32; 4]| at(0.0, 0.0, [a, b, c], more), value),
    };
    let better = least < (1.0 - NOTICEABLE) * first && share.is_finite();
    (better && is_usable(lobe)).then_some((share, lobe))
}

/// What `at` makes of the numbers with the least value near 0, where it is `first`; and that value.
fn least<const N: usize, T>(first: f32, at: impl Fn(&[f32; N]) -> T, value: impl Fn(T) -> f32) -> (T, f32) {
    let (best, least) = minimise(first, REACH, Stop { spread: SPREAD * first, steps: 60 * N }, |x| value(at(x)));
    (at(&best), least)
}

/// A tensor as a search takes it.
fn in_form(form: Form, tensor: RoughnessTensor) -> RoughnessTensor {
    let mean = RoughnessTensor { xx: tensor.mean(), xy: 0.0, yy: tensor.mean() };
    let tensor = if form == Form::Isotropic { mean } else { tensor };
    tensor.clamped(LEAST, 1.0)
}

/// A noticeably better lobe near one whose error is `first`, and its error.
fn search(error: &LobeError, first: f32, form: Form, from: Candidate) -> Option<(Candidate, f32)> {
    let of = |lobe| error.of(lobe);
    let (lobe, value) = match form {
        Form::Isotropic => least(first, |&[x, y, w]: &[f32; 3]| moved(from, x, y, [w, 0.0, w]), of),
        Form::Anisotropic => least(first, |&[x, y, a, b, c]: &[f32; 5]| moved(from, x, y, [a, b, c]), of),
    };
    (value < (1.0 - NOTICEABLE) * first && is_usable(lobe)).then_some((lobe, value))
}

fn is_usable((n, r): Candidate) -> bool {
    n.is_finite() && r.xx.is_finite() && r.xy.is_finite() && r.yy.is_finite()
}

/// A lobe moved by `x` and `y` of its widths, its factor L multiplied by one with the logarithms of widths on its diagonal.
fn moved((n, r): Candidate, x: f32, y: f32, [along, skew, across]: [f32; 3]) -> Candidate {
    let Frame { tangent: t, bitangent: b } = Frame::transported(n);
    let l11 = r.xx.sqrt();
    let l21 = r.xy / l11;
    let l22 = (r.yy - l21 * l21).max(1e-6 * r.yy).sqrt();
    let to = n + t * (l11 * x) + b * (l21 * x + l22 * y);
    let to = Vec3::new(to.x, to.y, to.z.max(LOWEST)).normalize();
    let (l11, l21, l22) = (l11 * along.exp(), l21 * along.exp() + l22 * skew, l22 * across.exp());
    let tensor = RoughnessTensor { xx: l11 * l11, xy: l11 * l21, yy: l21 * l21 + l22 * l22 };
    (to, tensor.clamped(LEAST, 1.0))
}

#[cfg(test)]
mod tests {
    use glam::Mat3;
    use proptest::prelude::*;

    use super::*;
    use crate::ndf::{Lobe, SlopeLobe};
    use crate::roughness::Alpha;

    /// Slopes and alphas as a footprint.
    fn footprint(texels: &[(f32, f32, f32)], turn: Mat3) -> Vec<(Lobe, f32)> {
        let lobe = |&(x, y, alpha): &(f32, f32, f32)| {
            (Lobe::isotropic(turn * Vec3::new(-x, -y, 1.0).normalize(), Alpha(alpha)), 1.0)
        };
        texels.iter().map(lobe).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// The views do not turn, and a search ends where the figure is flat: to a part of the width only. Of texels that
        /// overlap: of parts that lie apart and count alike, either is as good.
        #[test]
        fn turning_copies_and_order_change_little(
            texels in prop::collection::vec((-0.12f32..0.12, -0.12f32..0.12, 0.25f32..0.5), 2..40), angle in -3.0f32..3.0
        ) {
            let turn = Mat3::from_rotation_z(angle);
            let mut twice = texels.clone();
            twice.extend(texels.iter().rev());
            for form in [Form::Isotropic, Form::Anisotropic] {
                let lobe = |texels, turn| FOLD.lobe(&footprint(texels, turn), form);
                let a = lobe(&texels, Mat3::IDENTITY);
                for (b, turn) in [(lobe(&texels, turn), turn), (lobe(&twice, Mat3::IDENTITY), Mat3::IDENTITY)] {
                    let width = a.roughness.mean().sqrt();
                    let off = (turn * a.normal - b.normal).length() / width;
                    let wider = (b.roughness.mean() / a.roughness.mean()).ln().abs();
                    prop_assert!(off < 0.25 && wider < 0.25, "{form:?}: {off} {wider}");
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn a_flat_footprint_stays_itself(x in -1.0f32..1.0, y in -1.0f32..1.0, alpha in 0.01f32..0.6, count in 1usize..30) {
            let texels = vec![(x, y, alpha); count];
            for form in [Form::Isotropic, Form::Anisotropic] {
                let (found, own) = (FOLD.lobe(&footprint(&texels, Mat3::IDENTITY), form), footprint(&texels, Mat3::IDENTITY)[0].0);
                prop_assert!((found.normal - own.normal).length() < 2e-4, "{form:?} {found:?}");
                prop_assert!((found.roughness.mean() / own.roughness.mean() - 1.0).abs() < 1e-3, "{form:?} {found:?}");
            }
        }

        /// Down to the horizon, opposed pairs, mirrors.
        #[test]
        fn hostile_texels_stay_finite_and_bounded(
            texels in prop::collection::vec((-1e3f32..1e3, -10.0f32..10.0, 0.0f32..1.0), 1..20)
        ) {
            let texels: Vec<_> = texels.into_iter().map(|(x, y, a)| (x, y, if a < 0.3 { 1e-6 } else { a })).collect();
            for form in [Form::Isotropic, Form::Anisotropic] {
                let lobe = FOLD.lobe(&footprint(&texels, Mat3::IDENTITY), form);
                let axes = lobe.axes();
                prop_assert!((lobe.normal.length() - 1.0).abs() < 1e-5 && lobe.normal.z > 0.0, "{form:?} {lobe:?}");
                prop_assert!(axes.alpha_y.0 >= 0.0 && axes.alpha_x.0.is_finite() && axes.angle.is_finite(), "{form:?} {axes:?}");
            }
        }
    }

    fn mixture(texels: &[(f32, f32, f32)], shape: Shape, count: usize, fit: crate::fold::fit::Fit) -> Vec<(Lobe, f32)> {
        let entry = |&(lobe, weight): &(Lobe, f32)| Entry { weight, lobe: SlopeLobe::new(&lobe) };
        let entries: Vec<Entry> = footprint(texels, Mat3::IDENTITY).iter().map(entry).collect();
        crate::fold::fit::one(fit, shape, count, &entries, Vec3::Z)
    }

    /// The error of a mixture against its footprint, by the half vectors of neither.
    fn error_of(texels: &[(f32, f32, f32)], lobes: &[(Lobe, f32)]) -> f64 {
        use crate::reference::Footprint;
        let weighed = |lobes: &[(Lobe, f32)]| lobes.iter().map(|&(lobe, w)| (lobe, f64::from(w))).collect::<Vec<_>>();
        let (truth, own) = (weighed(&footprint(texels, Mat3::IDENTITY)), weighed(lobes));
        super::super::fit::lobe_error::exact(&Footprint::of_lobes(&truth), &Footprint::of_lobes(&own))
    }

    const SHAPES: [Shape; 4] = [
        Shape { form: Form::Isotropic, shared_normal: false },
        Shape { form: Form::Isotropic, shared_normal: true },
        Shape { form: Form::Anisotropic, shared_normal: false },
        Shape { form: Form::Anisotropic, shared_normal: true },
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        /// Down to the horizon, opposed pairs, mirrors.
        #[test]
        fn mixtures_of_hostile_texels_are_lobes_and_shares(
            texels in prop::collection::vec((-1e3f32..1e3, -10.0f32..10.0, 0.0f32..1.0), 1..12), count in 2usize..=4
        ) {
            let texels: Vec<_> = texels.into_iter().map(|(x, y, a)| (x, y, if a < 0.3 { 1e-6 } else { a })).collect();
            for shape in SHAPES {
                let lobes = mixture(&texels, shape, count, fit);
                prop_assert!(crate::ndf::are_shares(lobes.iter().map(|lobe| lobe.1)), "{shape:?} {lobes:?}");
                for (lobe, _) in &lobes {
                    let axes = lobe.axes();
                    prop_assert!((lobe.normal.length() - 1.0).abs() < 1e-5 && lobe.normal.z > 0.0, "{shape:?} {lobe:?}");
                    prop_assert!(axes.alpha_y.0 >= 0.0 && axes.alpha_x.0.is_finite(), "{shape:?} {axes:?}");
                    let apart = lobe.normal.distance(lobes[0].0.normal);
                    prop_assert!(!shape.shared_normal || apart < 1e-6, "{shape:?} {lobes:?}");
                }
            }
        }

        #[test]
        fn searched_mixtures_are_closer(
            texels in prop::collection::vec((-0.5f32..0.5, -0.5f32..0.5, 0.05f32..0.5), 5..12), count in 2usize..=3
        ) {
            for shape in SHAPES {
                let [found, start] = [fit, ggx::fit].map(|fit| error_of(&texels, &mixture(&texels, shape, count, fit)));
                // By other half vectors than those of the search.
                prop_assert!(found < 1.02 * start + 0.01, "{shape:?}, {count} lobes: {found} {start}");
            }
        }
    }

    #[test]
    fn a_footprint_of_two_mirrors_becomes_one_of_them() {
        let texels = [(0.5, 0.0, 0.02), (0.5, 0.0, 0.02), (-0.5, 0.2, 0.02)];
        let lobe = FOLD.lobe(&footprint(&texels, Mat3::IDENTITY), Form::Isotropic);
        let expected = Vec3::new(-0.5, 0.0, 1.0).normalize();
        assert!(
            (lobe.normal - expected).length() < 0.01 && (lobe.axes().alpha_x.0 / 0.02 - 1.0).abs() < 0.3,
            "{lobe:?}"
        );
    }
}
