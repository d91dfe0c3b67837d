//! From slopes back to lobes: [`SlopeLobe`](crate::ndf::SlopeLobe)'s own read-out, for footprints side by side.

use pulp::Simd;

use super::chunk::Fitted;
use super::estimate::Estimate;
use super::lanes::{Lanes, Which, scaled};
use crate::ndf::Form;
use crate::ndf::slopes::{EIGEN_STEPS, LEAST_Z, SINGULAR, WIDEST};

type Vector<S> = [Lanes<S>; 3];

/// Reads an estimate out as the lobes of the footprints from `first` on, given unit normals near theirs.
///
/// The wider a lobe, the less its slopes say of its normal, and the more its shading depends on that: by alpha^3 it is taken
/// from the given one. Where steep and rough texels meet that lies closer in lobe error.
#[inline(always)]
pub fn read_out<S: Simd>(
    e: &Estimate<S>,
    form: Form,
    near: &Vector<S>,
    weight: Lanes<S>,
    first: usize,
    out: &mut Fitted,
) {
    let (n, [xx, xy, yy]) = lobe_near(e, near);
    let mean = 0.5 * (xx + yy);
    let alpha2 = mean.max(0.0).min(1.0);
    let n = unit(mixed(n, near, alpha2 * alpha2.sqrt()));
    // That of a lobe of one width is round but for rounding.
    let tensor = if form == Form::Isotropic { [mean, mean.like(0.0), mean] } else { [xx, xy, yy] };
    out.normal.store(Which::From(first), n);
    out.tensor.store(Which::From(first), tensor);
    weight.store(&mut out.weight[first..]);
}

/// Normal, and tensor in its transported frame, of the eigenvector of `S = P + u' u'^T`, `u' = (-u, 1)`, that lies near a unit
/// vector with z above 0.
#[inline(always)]
fn lobe_near<S: Simd>(e: &Estimate<S>, n0: &Vector<S>) -> (Vector<S>, [Lanes<S>; 3]) {
    let [t, b] = transported(n0);
    let (tn, bn, nn) = (quadratic(e, &t, n0), quadratic(e, &b, n0), quadratic(e, n0, n0));
    // Wider than nearly 1, the tensor would leave the normal to rounding, or to a direction near the horizon.
    let [tt, tb, bb] = no_wider([quadratic(e, &t, &t), quadratic(e, &t, &b), quadratic(e, &b, &b)], WIDEST * nn);
    // The eigenvector (x, y, 1) by Rayleigh quotient iteration, `(lambda - S_pp) x = S_pn`.
    let (mut x, mut y, mut lambda) = (nn.like(0.0), nn.like(0.0), nn);
    for _ in 0..EIGEN_STEPS {
        let (a, d) = (lambda - tt, lambda - bb);
        let (det, least) = (a * d - tb * tb, SINGULAR * lambda * lambda);
        let scale = det.above(least, det, least).inverse();
        (x, y) = ((d * tn + tb * bn) * scale, (tb * tn + a * bn) * scale);
        let form = nn + 2.0 * (tn * x + bn * y) + tt * x * x + 2.0 * tb * x * y + bb * y * y;
        lambda = form * (x * x + y * y + 1.0).inverse();
    }
    let z = (t[2] * x + b[2] * y + n0[2]).max(LEAST_Z);
    let n = unit([t[0] * x + b[0] * y + n0[0], t[1] * x + b[1] * y + n0[1], z]);
    let [t, b] = transported(&n);
    let scale = quadratic(e, &n, &n).inverse();
    (n, scaled([quadratic(e, &t, &t), quadratic(e, &t, &b), quadratic(e, &b, &b)], scale))
}

/// `a^T S c`.
#[inline(always)]
fn quadratic<S: Simd>(e: &Estimate<S>, a: &Vector<S>, c: &Vector<S>) -> Lanes<S> {
    let (up_a, up_c) = (a[2] - e.x * a[0] - e.y * a[1], c[2] - e.x * c[0] - e.y * c[1]);
    e.xx * a[0] * c[0] + e.xy * (a[0] * c[1] + a[1] * c[0]) + e.yy * a[1] * c[1] + up_a * up_c
}

/// Tangent and bitangent, see [`crate::ndf::Frame::transported`].
#[inline(always)]
fn transported<S: Simd>([x, y, z]: &Vector<S>) -> [Vector<S>; 2] {
    let a = (*z + 1.0).inverse();
    let mixed = -(*x * *y * a);
    let one = a.like(1.0);
    [[one - *x * *x * a, mixed, -*x], [mixed, one - *y * *y * a, -*y]]
}

/// A tensor with eigenvalues of at most `high`, and at least 0.
#[inline(always)]
pub(super) fn no_wider<S: Simd>([xx, xy, yy]: [Lanes<S>; 3], high: Lanes<S>) -> [Lanes<S>; 3] {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let spread = (half * half + xy * xy).sqrt();
    let (long, short) = ((mean + spread).max(0.0), (mean - spread).max(0.0));
    let (long, short) = (high.above(long, long, high), high.above(short, short, high));
    let scale = 0.5 * (long - short) * spread.max(f32::MIN_POSITIVE).inverse();
    let (middle, half) = (0.5 * (long + short), half * scale);
    [middle + half, xy * scale, middle - half]
}

/// From one to the other by a share.
#[inline(always)]
fn mixed<S: Simd>(a: Vector<S>, b: &Vector<S>, by: Lanes<S>) -> Vector<S> {
    [a[0] + by * (b[0] - a[0]), a[1] + by * (b[1] - a[1]), a[2] + by * (b[2] - a[2])]
}

#[inline(always)]
fn unit<S: Simd>(v: Vector<S>) -> Vector<S> {
    scaled(v, (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().inverse())
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    use super::*;
    use crate::ndf::{Axes, Lobe, RoughnessTensor, SlopeLobe};
    use crate::roughness::Alpha;

    /// A lobe of the slope plane in every lane, and a normal near its own.
    struct Near(SlopeLobe, Vec3);

    impl pulp::WithSimd for Near {
        type Output = (Vec3, RoughnessTensor);

        fn with_simd<S: Simd>(self, simd: S) -> (Vec3, RoughnessTensor) {
            let SlopeLobe { centre, scatter: p } = self.0;
            let e = Estimate::new([centre.x, centre.y, p.xx, p.xy, p.yy].map(|v| Lanes::all(simd, v)));
            let (n, r) = lobe_near(&e, &self.1.to_array().map(|v| Lanes::all(simd, v)));
            let [xx, xy, yy] = r.map(|v| v.row()[0]);
            (Vec3::from(n.map(|v| v.row()[0])), RoughnessTensor { xx, xy, yy })
        }
    }

    /// All of the read-out.
    struct Whole(Near, Form);

    impl pulp::WithSimd for Whole {
        type Output = (Vec3, [f32; 3]);

        fn with_simd<S: Simd>(self, simd: S) -> (Vec3, [f32; 3]) {
            let Self(Near(SlopeLobe { centre, scatter: p }, near), form) = self;
            let e = Estimate::new([centre.x, centre.y, p.xx, p.xy, p.yy].map(|v| Lanes::all(simd, v)));
            let near = near.to_array().map(|v| Lanes::all(simd, v));
            let mut out = Fitted::default();
            read_out(&e, form, &near, Lanes::all(simd, 1.0), 8, &mut out);
            (Vec3::from(out.normal.at(8)), out.tensor.at(8))
        }
    }

    proptest! {
        #[test]
        fn side_by_side_as_one_by_one(
            x in -3.0f32..3.0, y in -3.0f32..3.0, alpha in 0.001f32..1.0, ratio in 0.05f32..1.0, angle in -1.5f32..1.5,
            off in -0.2f32..0.2,
        ) {
            let normal = Vec3::new(-x, -y, 1.0).normalize();
            let axes = Axes { alpha_x: Alpha(alpha), alpha_y: Alpha(alpha * ratio), angle };
            let lobe = SlopeLobe::new(&Lobe { normal, roughness: RoughnessTensor::from_axes(axes) });
            let near = (normal + Vec3::new(off, -off, 0.0)).normalize();
            let ((n, r), (m, s)) = (pulp::Arch::new().dispatch(Near(lobe, near)), lobe.near(near));
            prop_assert!((n - m).length() < 1e-5, "{n} {m}");
            let close = |a: f32, b: f32| (a - b).abs() <= 1e-4 * s.mean();
            prop_assert!(close(r.xx, s.xx) && close(r.xy, s.xy) && close(r.yy, s.yy), "{r:?} {s:?}");
        }

        /// Any centre and scatter, wider than a lobe can be, and normals that have nothing to do with it.
        #[test]
        fn read_out_is_finite(
            x in -5e5f32..5e5, y in -1e3f32..1e3, xx in 0.0f32..1e11, yy in 0.0f32..1e4, skew in -0.999f32..0.999,
            nx in -3.0f32..3.0, ny in -3.0f32..3.0,
        ) {
            let scatter = RoughnessTensor { xx, xy: skew * (xx * yy).sqrt(), yy };
            let near = Vec3::new(nx, ny, 1.0).normalize();
            for form in [Form::Isotropic, Form::Anisotropic] {
                let whole = Whole(Near(SlopeLobe { centre: Vec2::new(x, y), scatter }, near), form);
                let (n, [xx, xy, yy]) = pulp::Arch::new().dispatch(whole);
                prop_assert!(n.is_finite() && (n.length() - 1.0).abs() < 1e-5 && n.z > 0.0, "{n}");
                prop_assert!(xx.is_finite() && xy.is_finite() && yy.is_finite(), "{xx} {xy} {yy}");
                prop_assert!(form == Form::Anisotropic || (xx == yy && xy == 0.0));
            }
        }

        /// The wider, the nearer: by alpha^3.
        #[test]
        fn the_normal_of_a_wide_lobe_is_the_given_one(alpha in 0.05f32..0.9, x in -0.5f32..0.5) {
            let own = Vec3::new(-x, 0.1, 1.0).normalize();
            let near = Vec3::new(-x + 0.1, 0.1, 1.0).normalize();
            let lobe = SlopeLobe::new(&Lobe::isotropic(own, Alpha(alpha)));
            let (n, [xx, ..]) = pulp::Arch::new().dispatch(Whole(Near(lobe, near), Form::Isotropic));
            let expected = own + alpha.powi(3) * (near - own);
            prop_assert!((n - expected.normalize()).length() < 1e-4, "{n}");
            prop_assert!((xx.sqrt() / alpha - 1.0).abs() < 1e-3, "{xx}");
        }
    }
}
