//! Based on: the lobe error of [`crate::compare`], searched by J. A. Nelder, R. Mead, 1965.

use glam::Vec3;

use super::fit::lobe_error::{Candidate, LobeError};
use super::fit::simplex::{Stop, minimise};
use super::fit::{Atom, Chunk, Fitted, LANES, Shape, scatter};
use super::{Fold, Method};
use crate::ndf::{Form, Frame, RoughnessTensor};

/// The GGX lobe of least lobe error: that of `ggx`, moved until it looks most like the footprint.
pub const FOLD: Fold = Fold {
    name: "ggx-lobe",
    cite: "Nelder & Mead 1965",
    about: "the GGX lobe that looks most alike: `ggx`, then a search",
    method: Method::Lobes { most: MOST, mixtures: false, fit },
};

/// Lobes of a summary: twice as many a side as for `ggx`.
const MOST: usize = 64;

/// Steps of the fit that the search starts from.
const STEPS: usize = 3;

/// Lobe error below which nothing is searched: rounding alone may leave as much.
const NOTHING: f32 = 2e-3;

/// Share of the lobe error by which a search must lessen it, so that what rounding brings moves no lobe.
const NOTICEABLE: f32 = 5e-3;

/// The first corners of a search lie this far from its start, in widths of the lobe and in logarithms of them.
const REACH: f32 = 0.2;

/// Search ends where corners differ by this share of the error.
const SPREAD: f32 = 2e-3;

/// Least squared width of a search, as that of the smoothest texels.
const LEAST: f32 = 1e-12;

/// Least z of a normal.
const LOWEST: f32 = 1e-3;

fn fit(chunk: &Chunk, shape: Shape, out: &mut [Fitted]) {
    let mut estimate = scatter::start(&chunk.atoms);
    for _ in 0..STEPS {
        scatter::step(&chunk.atoms, shape.form, &mut estimate);
    }
    // One lobe; mixtures would be refined here, from the lobes of a start of their own.
    out[0] = scatter::read_out(chunk, &estimate);
    for i in 0..LANES {
        // At borders a footprint is repeated to fill the lanes.
        let from = if i > 0 && chunk.atoms.iter().all(|atom| same(atom, i)) { i - 1 } else { i };
        let found = if from == i { refine(&chunk.atoms, i, shape.form, lane(&out[0], i)) } else { lane(&out[0], from) };
        put(&mut out[0], i, found);
    }
}

/// Whether footprint `i` has the lobe of the one before.
fn same(atom: &Atom, i: usize) -> bool {
    [&atom.w, &atom.x, &atom.y, &atom.l11, &atom.l21, &atom.l22].iter().all(|lanes| lanes[i] == lanes[i - 1])
}

fn lane(fitted: &Fitted, i: usize) -> Candidate {
    let [xx, xy, yy] = fitted.tensor.map(|v| v[i]);
    (Vec3::from(fitted.normal.map(|v| v[i])), RoughnessTensor { xx, xy, yy })
}

fn put(fitted: &mut Fitted, i: usize, (n, r): Candidate) {
    (fitted.normal[0][i], fitted.normal[1][i], fitted.normal[2][i]) = (n.x, n.y, n.z);
    (fitted.tensor[0][i], fitted.tensor[1][i], fitted.tensor[2][i]) = (r.xx, r.xy, r.yy);
}

/// The lobe near `start` that looks most like a footprint; `start` where there is none that is noticeably better.
fn refine(atoms: &[Atom], i: usize, form: Form, start: Candidate) -> Candidate {
    let (normal, tensor) = start;
    let tensor = match form {
        Form::Isotropic => RoughnessTensor { xx: tensor.mean(), xy: 0.0, yy: tensor.mean() },
        Form::Anisotropic => tensor,
    };
    let guess = (normal, tensor.clamped(LEAST, 1.0));
    let error = LobeError::new(atoms, i, guess);
    let first = error.of(guess);
    if first.is_nan() || first <= NOTHING {
        return start;
    }
    let found = match form {
        Form::Isotropic => search(&error, first, |&[x, y, width]: &[f32; 3]| moved(guess, x, y, [width, 0.0, width])),
        Form::Anisotropic => {
            search(&error, first, |&[x, y, along, skew, across]: &[f32; 5]| moved(guess, x, y, [along, skew, across]))
        }
    };
    found.unwrap_or(start)
}

/// A noticeably better lobe, of those that `lobe` makes of moves.
fn search<const N: usize>(error: &LobeError, first: f32, lobe: impl Fn(&[f32; N]) -> Candidate) -> Option<Candidate> {
    let stop = Stop { spread: SPREAD * first, steps: 60 * N };
    let (best, value) = minimise(first, REACH, stop, |x| error.of(lobe(x)));
    let (n, r) = lobe(&best);
    let usable = n.is_finite() && r.xx.is_finite() && r.xy.is_finite() && r.yy.is_finite();
    (value < (1.0 - NOTICEABLE) * first && usable).then_some((n, r))
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
