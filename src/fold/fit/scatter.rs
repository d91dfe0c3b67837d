//! The closest GGX lobe, by the fixed point of the Student-t scatter estimate.
//!
//! Based on: J. T. Kent, D. E. Tyler, Y. Vardi, "A Curious Likelihood Identity for the Multivariate t-Distribution", 1994,
//! whose parameter-expanded steps these are; H. Fujisawa, S. Eguchi, "Robust Parameter Estimation with a Small Bias Against
//! Heavy Contamination", 2008, for the weights.
//!
//! In the slope plane a footprint is a mixture of Student-t densities with two degrees of freedom, and a GGX lobe is one
//! of them. The one closest in the sense of Kullback and Leibler has `E[w (s - u)] = 0` and
//! `P = 2 E[w (s - u)(s - u)^T] / E[w]` with `w = 1 / (1 + (s - u)^T P^-1 (s - u))`. Means over a lobe of the footprint
//! are taken at eight nodes: two rings, at the radii of the two Gauss-Legendre points of the radial distribution, of four
//! nodes each. They give a single lobe back exactly, and are exact for lobes that are narrow beside the whole.

use glam::{Vec2, Vec3};

use super::chunk::{Atom, Chunk, Fitted, LANES, Lanes};
use crate::ndf::{Form, RoughnessTensor, SlopeLobe};

/// Squared radii of the rings: `u / (1 - u)` at `u = 1/2 -+ 1/(2 sqrt 3)`, so `2 -+ sqrt 3`.
const RING2: [f32; 2] = [0.267_949_2, 3.732_050_8];

/// Radii of the rings.
const RING: [f32; 2] = [0.517_638_1, 1.931_851_7];

/// Lobes far out count less, by this power of their mean w: the estimate leans from that of Kullback and Leibler, which
/// follows every outlier, towards robust ones, which lie closer in lobe error. On real maps powers from 0.35 to 0.5 did
/// best; this one is a square root. None of them changes a single lobe.
const LEAN: f32 = 0.5;

/// Least determinant of a scatter, over the product of its diagonal: f32 tells no less.
const THINNEST: f32 = 1e-5;

/// Least diagonal of a scatter: that of the smoothest texels. With it no square of a ratio to the steepest slopes
/// leaves the range of f32.
const LEAST: f32 = 1e-12;

/// The estimate so far.
#[derive(Clone, Copy, Default)]
pub struct Estimate {
    /// Centre.
    pub x: Lanes,
    /// Centre.
    pub y: Lanes,
    /// Scatter.
    pub xx: Lanes,
    /// Scatter.
    pub xy: Lanes,
    /// Scatter.
    pub yy: Lanes,
}

/// A start that needs no iteration: the mean slope, and the second moments about it, each weighed by the inverse of its
/// root: those of absolute values, which GGX has, where it has no second moments. A single lobe is its own start.
#[inline(always)]
pub fn start(atoms: &[Atom]) -> Estimate {
    let mut weight = [0.0; LANES];
    let mut e = Estimate::default();
    for a in atoms {
        for i in 0..LANES {
            weight[i] += a.w[i];
            e.x[i] += a.w[i] * a.x[i];
            e.y[i] += a.w[i] * a.y[i];
        }
    }
    for i in 0..LANES {
        weight[i] = 1.0 / weight[i];
        (e.x[i], e.y[i]) = (e.x[i] * weight[i], e.y[i] * weight[i]);
    }
    let mut length = [0.0; LANES];
    for a in atoms {
        for i in 0..LANES {
            let (dx, dy, w) = (a.x[i] - e.x[i], a.y[i] - e.y[i], a.w[i] * weight[i]);
            let (l11, l21, l22) = (a.l11[i], a.l21[i], a.l22[i]);
            let (xx, xy, yy) = (l11 * l11 + dx * dx, l11 * l21 + dx * dy, l21 * l21 + l22 * l22 + dy * dy);
            let root = (0.5 * (xx + yy)).sqrt();
            let share = w / root;
            length[i] += w * root;
            e.xx[i] += share * xx;
            e.xy[i] += share * xy;
            e.yy[i] += share * yy;
        }
    }
    for i in 0..LANES {
        (e.xx[i], e.xy[i], e.yy[i]) = (e.xx[i] * length[i], e.xy[i] * length[i], e.yy[i] * length[i]);
    }
    e
}

/// One step.
#[inline(always)]
pub fn step(atoms: &[Atom], form: Form, e: &mut Estimate) {
    // Inverse of the scatter.
    let (mut mxx, mut mxy, mut myy) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        // Rounding must leave a width across.
        (e.xx[i], e.yy[i]) = (e.xx[i].max(LEAST), e.yy[i].max(LEAST));
        let product = e.xx[i] * e.yy[i];
        e.xy[i] *= ((1.0 - THINNEST) * product / (e.xy[i] * e.xy[i]).max(f32::MIN_POSITIVE)).sqrt().min(1.0);
        let inverse = 1.0 / (product - e.xy[i] * e.xy[i]);
        (mxx[i], mxy[i], myy[i]) = (e.yy[i] * inverse, -e.xy[i] * inverse, e.xx[i] * inverse);
    }
    // Sums of w, w d, w d d^T; the parts of tr(P^-1 w d d^T) that lie between atoms and in all.
    let mut sums = [[0.0; LANES]; 8];
    for a in atoms {
        for i in 0..LANES {
            let (dx, dy) = (a.x[i] - e.x[i], a.y[i] - e.y[i]);
            let (l11, l21, l22) = (a.l11[i], a.l21[i], a.l22[i]);
            let (xx, xy, yy) = (mxx[i], mxy[i], myy[i]);
            let (mx, my) = (xx * dx + xy * dy, xy * dx + yy * dy);
            let far = 1.0 + dx * mx + dy * my;
            // Axes of the atom, v = L q for orthogonal q, of which the first points where w changes most, so that turning
            // the footprint turns the nodes.
            // Their products stay in the range of f32 even for a smooth lobe seen from the horizon.
            let bounded = |b: f32| b.max(-1e18).min(1e18);
            let (b1, b2) = (bounded(l11 * mx + l21 * my), bounded(l22 * my));
            let b = (b1 * b1 + b2 * b2).sqrt();
            let inverse = 1.0 / b.max(f32::MIN_POSITIVE);
            let (cos, sin) = if b > 0.0 { (b1 * inverse, b2 * inverse) } else { (1.0, 0.0) };
            let (ax, ay) = (l11 * cos, l21 * cos + l22 * sin);
            let (bx, by) = (-l11 * sin, l22 * cos - l21 * sin);
            let (ux, uy) = (xx * ax + xy * ay, xy * ax + yy * ay);
            let (q11, q12) = (ax * ux + ay * uy, bx * ux + by * uy);
            let q22 = bx * (xx * bx + xy * by) + by * (xy * bx + yy * by);
            // w at opposite nodes d +- v: their sum and their difference.
            let pair = |q: f32, b: f32| {
                let a = far + q;
                // Rounding must not make the farther one negative.
                let low = (a - 2.0 * b).max(1e-6 * a);
                let inverse = 1.0 / (low * (a + 2.0 * b));
                (2.0 * a * inverse, -4.0 * b * inverse)
            };
            let (r1, half) = (RING[0], 0.5 * RING2[1]);
            let r2 = std::f32::consts::FRAC_1_SQRT_2 * RING[1];
            let (w1, v1) = pair(RING2[0] * q11, r1 * b);
            let w2 = 2.0 / (far + RING2[0] * q22);
            let (w3, v3) = pair(half * (q11 + q22 + 2.0 * q12), r2 * b);
            let (w4, v4) = pair(half * (q11 + q22 - 2.0 * q12), r2 * b);
            let all = (w1 + w2) + (w3 + w4);
            let outer = half * (w3 + w4);
            let (c11, c12, c22) = (RING2[0] * w1 + outer, half * (w3 - w4), RING2[0] * w2 + outer);
            let (e1, e2) = (r1 * v1 + r2 * (v3 + v4), r2 * (v3 - v4));
            let (ex, ey) = (ax * e1 + bx * e2, ay * e1 + by * e2);
            let g = a.w[i] * (0.125 * all).sqrt();
            let sxx = all * dx * dx + 2.0 * dx * ex + c11 * ax * ax + 2.0 * c12 * ax * bx + c22 * bx * bx;
            let sxy = all * dx * dy + dx * ey + dy * ex + c11 * ax * ay + c12 * (ax * by + ay * bx) + c22 * bx * by;
            let syy = all * dy * dy + 2.0 * dy * ey + c11 * ay * ay + 2.0 * c12 * ay * by + c22 * by * by;
            sums[0][i] += g * all;
            sums[1][i] += g * (all * dx + ex);
            sums[2][i] += g * (all * dy + ey);
            sums[3][i] += g * sxx;
            sums[4][i] += g * sxy;
            sums[5][i] += g * syy;
            sums[6][i] += g * all * (far - 1.0);
            sums[7][i] += g * (xx * sxx + 2.0 * xy * sxy + yy * syy);
        }
    }
    for i in 0..LANES {
        let [weight, x, y, xx, xy, yy, between, whole] = sums.map(|s| s[i]);
        let inverse = 1.0 / weight.max(f32::MIN_POSITIVE);
        let (x, y) = (x * inverse, y * inverse);
        // Leaning takes width away. Of narrow atoms that make up the density that should come out, w is uniform in 0..1, so
        // that P = 2 (1 + LEAN) E[w^LEAN w d d^T] / E[w^LEAN w]; for a single atom nothing leans, and for a slight smear
        // as good as nothing.
        let apart = (between / whole.max(f32::MIN_POSITIVE)).min(1.0);
        let scale = 2.0 * (1.0 + LEAN * apart * apart) * inverse;
        let usable = weight > 0.0;
        let scatter = RoughnessTensor {
            xx: scale * xx - scale * weight * x * x,
            xy: scale * xy - scale * weight * x * y,
            yy: scale * yy - scale * weight * y * y,
        };
        e.x[i] += if usable { x } else { 0.0 };
        e.y[i] += if usable { y } else { 0.0 };
        let scatter = match form {
            Form::Anisotropic => scatter,
            Form::Isotropic => round(Vec2::new(e.x[i], e.y[i]), scatter),
        };
        if usable {
            (e.xx[i], e.xy[i], e.yy[i]) = (scatter.xx, scatter.xy, scatter.yy);
        }
    }
}

/// The scatter of a lobe of one width about a centre: the mean of another scatter in its metric.
///
/// Such a lobe has the scatter alpha^2 / S_zz^2 along the tilt and alpha^2 / S_zz across it, `S_zz = alpha^2 +
/// (1 - alpha^2) n_z^2`.
#[inline(always)]
fn round(centre: Vec2, p: RoughnessTensor) -> RoughnessTensor {
    let length2 = centre.x * centre.x + centre.y * centre.y;
    let inverse = 1.0 / length2.max(f32::MIN_POSITIVE);
    let along = (p.xx * centre.x * centre.x + 2.0 * p.xy * centre.x * centre.y + p.yy * centre.y * centre.y) * inverse;
    let along = if length2 > 0.0 { along } else { p.mean() };
    let across = p.xx + p.yy - along;
    // alpha^2 enters S_zz. Begun from that of a round lobe, which is exact for one, a few rounds settle it.
    let mut zz = (across / along.max(f32::MIN_POSITIVE)).clamp(1e-6, 1.0);
    let mut alpha2 = 0.0;
    for _ in 0..3 {
        alpha2 = (0.5 * (along * zz * zz + across * zz)).min(1.0);
        zz = upright(alpha2, length2);
    }
    let (a, c) = (alpha2 / (zz * zz), alpha2 / zz);
    let k = (a - c) * inverse;
    let k = if length2 > 0.0 { k } else { 0.0 };
    RoughnessTensor { xx: c + k * centre.x * centre.x, xy: k * centre.x * centre.y, yy: c + k * centre.y * centre.y }
}

/// S_zz of the lobe of one width whose centre has this squared length: `|u| = (1 - a) t / (1 + a t^2)` for the slope t of
/// its normal.
#[inline(always)]
fn upright(alpha2: f32, length2: f32) -> f32 {
    let rest = 1.0 - alpha2;
    let root = (rest * rest - 4.0 * alpha2 * length2).max(0.0).sqrt();
    let t2 = 4.0 * length2 / ((rest + root) * (rest + root)).max(1e-6);
    (1.0 + alpha2 * t2) / (1.0 + t2)
}

/// Reads an estimate out as lobes near the mean normals.
#[inline(always)]
pub fn read_out(chunk: &Chunk, e: &Estimate) -> Fitted {
    let mut out = Fitted { weight: [1.0; LANES], ..Fitted::default() };
    for i in 0..LANES {
        let scatter = RoughnessTensor { xx: e.xx[i], xy: e.xy[i], yy: e.yy[i] };
        let near = Vec3::new(chunk.normal[0][i], chunk.normal[1][i], chunk.normal[2][i]);
        let (n, r) = SlopeLobe { centre: Vec2::new(e.x[i], e.y[i]), scatter }.near(near);
        (out.normal[0][i], out.normal[1][i], out.normal[2][i]) = (n.x, n.y, n.z);
        (out.tensor[0][i], out.tensor[1][i], out.tensor[2][i]) = (r.xx, r.xy, r.yy);
    }
    out
}
