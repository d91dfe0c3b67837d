//! Many lights on one lobe, in f32 lanes.

use std::array::from_fn;
use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::Light;
use crate::ndf::{Frame, Lobe};
use crate::roughness::Alpha;

/// Lights that are evaluated side by side.
const LANES: usize = 8;
type Lanes = [f32; LANES];

/// Lights by component, `LANES` at a time, the last group filled up with darkness.
struct Group {
    direction: [Lanes; 3],
    irradiance: [Lanes; 3],
}

/// All lights of a scene and the metal that they fall on.
pub(super) struct Lighting {
    groups: Vec<Group>,
    f0: Vec3,
}

impl Lighting {
    pub fn new(lights: &[Light], f0: Vec3) -> Self {
        let groups = lights.chunks(LANES).map(|lights| {
            let lane = |pick: fn(&Light) -> Vec3, c: usize| from_fn(|i| lights.get(i).map_or(0.0, |l| pick(l)[c]));
            Group {
                direction: from_fn(|c| lane(|l| l.direction, c)),
                irradiance: from_fn(|c| lane(|l| l.irradiance, c)),
            }
        });
        Self { groups: groups.collect(), f0 }
    }

    /// Radiance towards `view` from a lobe on a surface with this normal and frame: the sum over lights of
    /// irradiance times `F D G2 / (4 n.v)`, as [`Lobe::specular`] has it, with Schlick's F.
    ///
    /// In the lobe's frame, with the half vector h = v + l left unnormalised and `s(w) = sqrt(w_z^2 + w_p^T R w_p)`
    /// for a direction w, `D G2 / (4 n.v) = (h.h)^2 l_z / (2 pi sqrt(det R) (h_p^T R^-1 h_p + h_z^2)^2
    /// (l_z s(v) + v_z s(l)))`: Heitz 2014, eq. 84 and 99, freed of all quotients that overflow near the horizon.
    pub fn radiance(&self, lobe: &Lobe, normal: Vec3, frame: Frame, view: Vec3) -> Vec3 {
        let world = |v: Vec3| frame.tangent * v.x + frame.bitangent * v.y + normal * v.z;
        let bent = Frame::bent(lobe.normal);
        let axes = [world(bent.tangent), world(bent.bitangent), world(lobe.normal)];
        let v = axes.map(|axis| axis.dot(view));
        if v[2] <= 0.0 {
            return Vec3::ZERO;
        }
        let r = lobe.roughness.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
        let det = r.determinant();
        let inverse = [r.yy / det, -2.0 * r.xy / det, r.xx / det];
        let stretch = |x: f32, y: f32, z: f32| (z * z + r.xx * x * x + 2.0 * r.xy * x * y + r.yy * y * y).sqrt();
        let sv = stretch(v[0], v[1], v[2]);
        let scale = 0.5 * FRAC_1_PI / det.sqrt();

        // Schlick's F is f0 + (1 - f0) w: two sums per colour.
        let mut facing = [[0.0; LANES]; 3];
        let mut grazing = [[0.0; LANES]; 3];
        for Group { direction: d, irradiance } in &self.groups {
            for i in 0..LANES {
                let dot = |axis: Vec3| axis.x * d[0][i] + axis.y * d[1][i] + axis.z * d[2][i];
                let (lx, ly, lz) = (dot(axes[0]), dot(axes[1]), dot(axes[2]));
                let (hx, hy, hz) = (lx + v[0], ly + v[1], lz + v[2]);
                let h2 = hx * hx + hy * hy + hz * hz;
                let q = inverse[0] * hx * hx + inverse[1] * hx * hy + inverse[2] * hy * hy + hz * hz;
                let below = q * q * (lz * sv + v[2] * stretch(lx, ly, lz));
                let specular = if lz > 0.0 { scale * h2 * h2 * lz / below } else { 0.0 };
                let w = 1.0 - 0.5 * h2.sqrt();
                let w = w * w * (w * w) * w;
                for c in 0..3 {
                    let lit = specular * irradiance[c][i];
                    facing[c][i] += lit * (1.0 - w);
                    grazing[c][i] += lit * w;
                }
            }
        }
        let sum = |lanes: [Lanes; 3]| Vec3::from_array(lanes.map(|lanes| lanes.iter().sum()));
        self.f0 * sum(facing) + sum(grazing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::{Axes, RoughnessTensor};
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        /// Within 2e-3 of f64 from perceptual roughness 0.1 up: what f32 half vectors allow near a narrow peak.
        #[test]
        fn agrees_with_the_lobe_in_f64(
            angle in -1.5f32..1.5, alpha_x in 0.01f32..1.0, ratio in 0.3f32..1.0,
            sx in -0.8f32..0.8, sy in -0.8f32..0.8, tilt in -1.0f32..1.0,
            vx in -0.9f32..0.9, vy in -0.4f32..0.4, lx in -0.9f32..0.9, ly in -0.4f32..0.4,
        ) {
            let up = |x: f32, y: f32| Vec3::new(x, y, (1.0 - x * x - y * y).sqrt());
            let axes = Axes { alpha_x: Alpha(alpha_x), alpha_y: Alpha(alpha_x * ratio), angle };
            let lobe = Lobe { normal: Vec3::new(-sx, -sy, 1.0).normalize(), roughness: RoughnessTensor::from_axes(axes) };
            // A surface of its own, so that view and light have to be turned into tangent space.
            let normal = up(0.5 * tilt, 0.3);
            let frame = Frame::transported(normal);
            let world = |v: Vec3| (frame.tangent * v.x + frame.bitangent * v.y + normal * v.z).normalize();
            let tangent_space = |w: Vec3| DVec3::new(
                w.as_dvec3().dot(frame.tangent.as_dvec3()),
                w.as_dvec3().dot(frame.bitangent.as_dvec3()),
                w.as_dvec3().dot(normal.as_dvec3()),
            );
            let (view, light) = (world(up(vx, vy)), world(up(lx, ly)));
            let (v, l) = (tangent_space(view), tangent_space(light));
            // At the horizon itself, where f32 decides between 0 and little, there is no relative bound.
            prop_assume!(v.dot(lobe.normal.as_dvec3()).abs() > 1e-3 && l.dot(lobe.normal.as_dvec3()).abs() > 1e-3);
            let lighting = Lighting::new(&[Light { direction: light, irradiance: Vec3::ONE }], Vec3::splat(0.25));
            let found = f64::from(lighting.radiance(&lobe, normal, frame, view).x);
            let fresnel = 0.25 + 0.75 * (1.0 - v.dot((v + l).normalize())).powi(5);
            let expected = fresnel * lobe.specular(v, l);
            prop_assert!((found - expected).abs() <= 2e-3 * expected, "{found} {expected}");
        }
    }
}
