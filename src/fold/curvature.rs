//! The curvature of the mesh under a texture, added to its folded lobes.

use glam::Vec3;
use rayon::prelude::*;

use super::{Level, Options, projected::added, toksvig::widened};
use crate::curvature;
use crate::ndf::{Form, Frame, RoughnessTensor};

/// Adds to each level what the mesh's own normals spread under its texels; `baked` is the whole chain of
/// [`curvature::bake()`], level 0 first. Texture and mesh are taken as independent, so their covariances add: in projected
/// space, where both are (as the fold `projected`), so that no width leaves 0 to 1.
pub(super) fn add(levels: &mut [Level], baked: &[curvature::Level], options: &Options) {
    let (low, high) = (options.min_alpha.squared(), options.max_alpha.squared());
    for (level, baked) in levels.iter_mut().zip(baked.get(1..).unwrap_or_default()) {
        assert_eq!(baked.size(), level.lobes.size(), "baked for a texture of another size");
        let (form, stride, count) = (level.lobes.form(), level.lobes.stride(), level.lobes.count());
        let mut rows: Vec<_> = level.lobes.bands_mut(1).collect();
        rows.par_iter_mut().enumerate().for_each(|(y, planes)| {
            for x in 0..planes.dim().2 {
                let mesh = baked.added[[y, x]];
                if mesh == RoughnessTensor::default() {
                    continue;
                }
                for first in (0..count).map(|j| j * stride) {
                    let place = |plane| (first + plane, 0, x);
                    let [nx, ny, nz] = [0, 1, 2].map(|i| planes[place(i)]);
                    let turned = carried(Vec3::new(nx, ny, nz), mesh);
                    match form {
                        Form::Isotropic => {
                            let wide = &mut planes[place(3)];
                            *wide = widened(*wide, 0.5 * turned.mean()).clamp(low, high);
                        }
                        Form::Anisotropic => {
                            let [xx, xy, yy] = [3, 4, 5].map(|i| planes[place(i)]);
                            let wide = added(RoughnessTensor { xx, xy, yy }, turned * 0.5).clamped(low, high);
                            for (i, value) in [wide.xx, wide.xy, wide.yy].into_iter().enumerate() {
                                planes[place(3 + i)] = value;
                            }
                        }
                    }
                }
            }
        });
    }
}

/// What a mesh's `K`, in the surface's tangent frame, is in the bent frame of a lobe's normal `n`: where the surface's
/// normal turns by d, along the tangent plane, n turns with it by `d n.z - z (d . n)`.
fn carried(n: Vec3, k: RoughnessTensor) -> RoughnessTensor {
    let frame = Frame::bent(n);
    // How far a turn along x, and one along y, goes along an axis of the lobe's frame.
    let row = |axis: Vec3| (n.z * axis.x - n.x * axis.z, n.z * axis.y - n.y * axis.z);
    let ((a, b), (c, d)) = (row(frame.tangent), row(frame.bitangent));
    RoughnessTensor {
        xx: a * a * k.xx + 2.0 * a * b * k.xy + b * b * k.yy,
        xy: a * c * k.xx + (a * d + b * c) * k.xy + b * d * k.yy,
        yy: c * c * k.xx + 2.0 * c * d * k.xy + d * d * k.yy,
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_flat_lobe_takes_the_tensor_as_it_is() {
        let k = RoughnessTensor { xx: 0.1, xy: 0.02, yy: 0.05 };
        assert_eq!(carried(Vec3::Z, k), k);
        // A lobe that leans along x by 60 degrees: a turn about x moves it by half as much; one about y by all of it.
        let n = Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
        let turned = carried(n, k);
        assert!((turned.xx - 0.1).abs() < 1e-6 && (turned.xy - 0.01).abs() < 1e-6, "{turned:?}");
        assert!((turned.yy - 0.0125).abs() < 1e-6, "{turned:?}");
    }

    proptest! {
        /// Against small turns of the whole surface, and for any lobe.
        #[test]
        fn lobes_turn_with_the_surface(
            x in -0.7f32..0.7, y in -0.7f32..0.7, dx in -1f32..1.0, dy in -1f32..1.0,
        ) {
            let n = Vec3::new(x, y, (1.0 - x * x - y * y).max(0.02).sqrt()).normalize();
            let small = 1e-3;
            let axis = Vec3::Z.cross(Vec3::new(dx, dy, 0.0));
            prop_assume!(axis.length() > 0.1);
            let moved = Quat::from_axis_angle(axis.normalize(), small * axis.length()) * n;
            let frame = Frame::bent(n);
            let (u, v) = ((moved - n).dot(frame.tangent) / small, (moved - n).dot(frame.bitangent) / small);
            let k = carried(n, RoughnessTensor { xx: dx * dx, xy: dx * dy, yy: dy * dy });
            for (got, wanted) in [(k.xx, u * u), (k.xy, u * v), (k.yy, v * v)] {
                prop_assert!((got - wanted).abs() < 5e-3, "{got} {wanted}");
            }
        }
    }
}
