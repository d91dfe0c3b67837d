//! Many lights on one lobe, in f32 lanes.

use std::array::from_fn;
use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::environment::Points;
use super::glint::Spot;
use super::{Environment, Light};
use crate::ndf::{Frame, Lobe};
use crate::roughness::Alpha;

/// Lights that are evaluated side by side.
pub(super) const LANES: usize = 8;
pub(super) type Lanes = [f32; LANES];

/// Lights by component, `LANES` at a time, the last group filled up with darkness.
struct Group {
    direction: [Lanes; 3],
    irradiance: [Lanes; 3],
}

/// A light that is near: how it shines depends on where the surface is.
struct Near {
    position: Vec3,
    /// Straight ahead, for those that have a side.
    intensity: Vec3,
    /// Unit, where it shines to; `None` if it shines everywhere.
    ahead: Option<Vec3>,
}

impl Near {
    /// The points that stand for a light; none for a light far away.
    fn of(light: &Light) -> Vec<Self> {
        match *light {
            Light::Directional { .. } => Vec::new(),
            Light::Point { position, intensity } => vec![Self { position, intensity, ahead: None }],
            Light::Rectangle { middle, right, up, radiance, columns, rows } => {
                let normal = right.cross(up);
                let count = columns * rows;
                let place = |k: usize, n: usize| (2 * k + 1) as f32 / n as f32 - 1.0;
                let point = |i: usize| Self {
                    position: middle + place(i % columns, columns) * right + place(i / columns, rows) * up,
                    intensity: radiance * (4.0 * normal.length() / count as f32),
                    ahead: Some(normal.normalize()),
                };
                (0..count).map(point).collect()
            }
        }
    }

    /// Direction towards the light and irradiance on a surface at `position` that faces it.
    fn at(&self, position: Vec3) -> (Vec3, Vec3) {
        let way = self.position - position;
        let direction = way.normalize_or(Vec3::Z);
        let share = self.ahead.map_or(1.0, |ahead| (-ahead.dot(direction)).max(0.0));
        (direction, self.intensity * (share / way.length_squared().max(f32::MIN_POSITIVE)))
    }
}

impl Group {
    /// Up to `LANES` directions and irradiances.
    fn new(lights: &[(Vec3, Vec3)]) -> Self {
        let lane = |pick: fn(&(Vec3, Vec3)) -> Vec3, c: usize| from_fn(|i| lights.get(i).map_or(0.0, |l| pick(l)[c]));
        Self { direction: from_fn(|c| lane(|l| l.0, c)), irradiance: from_fn(|c| lane(|l| l.1, c)) }
    }

    /// Each light times what `ratio` makes of its direction.
    fn glinting(&self, ratio: impl Fn(Vec3) -> f32) -> Self {
        let Self { direction, mut irradiance } = *self;
        for i in 0..LANES {
            if irradiance.iter().any(|lanes| lanes[i] > 0.0) {
                let ratio = ratio(Vec3::from_array(direction.map(|lanes| lanes[i])));
                irradiance.iter_mut().for_each(|lanes| lanes[i] *= ratio);
            }
        }
        Self { direction, irradiance }
    }
}

/// All lights of a scene and the metal that they fall on.
pub(super) struct Lighting {
    groups: Vec<Group>,
    near: Vec<Near>,
    environment: Option<Environment>,
    /// Of the environment's quadrature.
    pub(super) points: Points,
    f0: Vec3,
}

/// The lobe in its own frame, as all lights see it.
struct Prepared {
    /// Of the lobe, in the world.
    axes: [Vec3; 3],
    /// Towards the camera, along `axes`.
    v: [f32; 3],
    /// The tensor, xx, xy, yy, and its determinant.
    r: [f32; 3],
    det: f32,
    /// `s(v)`.
    sv: f32,
}

/// Schlick's F is f0 + (1 - f0) w: two sums per colour.
struct Sums {
    facing: [Lanes; 3],
    grazing: [Lanes; 3],
}

/// `s(w) = sqrt(w_z^2 + w_p^T R w_p)`, in the lobe's frame.
#[inline(always)]
fn stretch([xx, xy, yy]: [f32; 3], x: f32, y: f32, z: f32) -> f32 {
    (z * z + xx * x * x + 2.0 * xy * x * y + yy * y * y).sqrt()
}

impl Sums {
    /// `lit` is light times the lobe without F, `cos` that of the angle between view and half vector.
    #[inline(always)]
    fn add(&mut self, i: usize, cos: f32, lit: [f32; 3]) {
        let w = 1.0 - cos;
        let w = w * w * (w * w) * w;
        for c in 0..3 {
            self.facing[c][i] += lit[c] * (1.0 - w);
            self.grazing[c][i] += lit[c] * w;
        }
    }
}

impl Prepared {
    /// With the half vector h = v + l left unnormalised,
    /// `D G2 / (4 n.v) = (h.h)^2 l_z / (2 pi sqrt(det R) (h_p^T R^-1 h_p + h_z^2)^2 (l_z s(v) + v_z s(l)))`: Heitz
    /// 2014, eq. 84 and 99, freed of all quotients that overflow near the horizon.
    #[inline(always)]
    fn light(&self, Group { direction: d, irradiance }: &Group, sums: &mut Sums) {
        let Self { axes, v, r, det, sv } = self;
        let inverse = [r[2] / det, -2.0 * r[1] / det, r[0] / det];
        let scale = 0.5 * FRAC_1_PI / det.sqrt();
        for i in 0..LANES {
            let dot = |axis: Vec3| axis.x * d[0][i] + axis.y * d[1][i] + axis.z * d[2][i];
            let (lx, ly, lz) = (dot(axes[0]), dot(axes[1]), dot(axes[2]));
            let (hx, hy, hz) = (lx + v[0], ly + v[1], lz + v[2]);
            let h2 = hx * hx + hy * hy + hz * hz;
            let q = inverse[0] * hx * hx + inverse[1] * hx * hy + inverse[2] * hy * hy + hz * hz;
            let below = q * q * (lz * sv + v[2] * stretch(*r, lx, ly, lz));
            let specular = if lz > 0.0 { scale * h2 * h2 * lz / below } else { 0.0 };
            let lit = [specular * irradiance[0][i], specular * irradiance[1][i], specular * irradiance[2][i]];
            sums.add(i, 0.5 * h2.sqrt(), lit);
        }
    }

    /// A few points of the environment's quadrature: visible normals m, by Dupuy and Benyoub 2023 in the frame where
    /// the lobe is a half ball (`M = sqrt(R)` stretches it back), each reflecting the environment with
    /// `F G2 / G1 = F l_z (v_z + s(v)) / (l_z s(v) + v_z s(l))` (Heitz 2018, eq. 19).
    #[inline(always)]
    fn reflect(&self, environment: &Environment, [height, cos, sin]: &[Lanes; 3], share: f32, sums: &mut Sums) {
        let Self { axes, v, r, det, sv } = self;
        // Root of a 2x2 matrix, by Cayley and Hamilton.
        let root = det.sqrt();
        let below = (r[0] + r[2] + 2.0 * root).sqrt();
        let m = [(r[0] + root) / below, r[1] / below, (r[2] + root) / below];
        let ball = [(m[0] * v[0] + m[1] * v[1]) / sv, (m[1] * v[0] + m[2] * v[1]) / sv, v[2] / sv];
        let mut l = [[0.0; LANES]; 3];
        let mut vm = [0.0; LANES];
        for i in 0..LANES {
            // On the cap from 1 down to -ball_z.
            let z = 1.0 - height[i] * (1.0 + ball[2]);
            let flat = (1.0 - z * z).max(0.0).sqrt();
            let (hx, hy, hz) = (flat * cos[i] + ball[0], flat * sin[i] + ball[1], z + ball[2]);
            let (nx, ny) = (m[0] * hx + m[1] * hy, m[1] * hx + m[2] * hy);
            let inverse = 1.0 / (nx * nx + ny * ny + hz * hz).max(f32::MIN_POSITIVE);
            let dot = nx * v[0] + ny * v[1] + hz * v[2];
            let twice = 2.0 * dot * inverse;
            vm[i] = dot * inverse.sqrt();
            (l[0][i], l[1][i], l[2][i]) = (twice * nx - v[0], twice * ny - v[1], twice * hz - v[2]);
        }
        let mut world = [[0.0; LANES]; 3];
        for c in 0..3 {
            for i in 0..LANES {
                world[c][i] = l[0][i] * axes[0][c] + l[1][i] * axes[1][c] + l[2][i] * axes[2][c];
            }
        }
        let radiance = environment.lanes(world);
        for i in 0..LANES {
            let (lx, ly, lz) = (l[0][i], l[1][i], l[2][i]);
            let weight = share * lz * (v[2] + sv) / (lz * sv + v[2] * stretch(*r, lx, ly, lz));
            let weight = if lz > 0.0 { weight } else { 0.0 };
            sums.add(i, vm[i], [weight * radiance[0][i], weight * radiance[1][i], weight * radiance[2][i]]);
        }
    }
}

impl Lighting {
    pub fn new(lights: &[Light], environment: Option<Environment>, f0: Vec3) -> Self {
        let far = |light: &Light| match *light {
            Light::Directional { direction, irradiance } => Some((direction, irradiance)),
            _ => None,
        };
        let far: Vec<_> = lights.iter().filter_map(far).collect();
        let groups = far.chunks(LANES).map(Group::new).collect();
        let near = lights.iter().flat_map(Near::of).collect();
        Self { groups, near, environment, points: Points::new(), f0 }
    }

    /// Radiance towards `view` from a lobe on a surface at this place with this normal and frame: the sum over lights
    /// of irradiance times `F D G2 / (4 n.v)`, as [`ShapeInvariant::specular`] has it, with Schlick's F, and the environment's
    /// reflection.
    pub fn radiance(&self, lobe: &Lobe, position: Vec3, normal: Vec3, frame: Frame, view: Vec3) -> Vec3 {
        self.glinting(lobe, position, normal, frame, view, None)
    }

    /// The same of a lobe of flakes, if there are any under the ray: D of each light times their ratio.
    pub fn glinting(
        &self,
        lobe: &Lobe,
        position: Vec3,
        normal: Vec3,
        frame: Frame,
        view: Vec3,
        flakes: Option<&Spot>,
    ) -> Vec3 {
        let world = |v: Vec3| frame.tangent * v.x + frame.bitangent * v.y + normal * v.z;
        let bent = Frame::bent(lobe.normal);
        let axes = [world(bent.tangent), world(bent.bitangent), world(lobe.normal)];
        let v = axes.map(|axis| axis.dot(view));
        if v[2] <= 0.0 {
            return Vec3::ZERO;
        }
        let tensor = lobe.roughness.clamped(Alpha::SMOOTHEST.squared(), f32::MAX);
        let (det, r) = (tensor.determinant(), [tensor.xx, tensor.xy, tensor.yy]);
        let lobe = Prepared { axes, v, r, det, sv: stretch(r, v[0], v[1], v[2]) };

        let mut sums = Sums { facing: [[0.0; LANES]; 3], grazing: [[0.0; LANES]; 3] };
        for group in &self.groups {
            match flakes {
                None => lobe.light(group, &mut sums),
                Some(spot) => {
                    lobe.light(&group.glinting(|direction| spot.ratio(axes, tensor, &|_| direction)), &mut sums)
                }
            }
        }
        for near in self.near.chunks(LANES) {
            let mut group = Group { direction: [[0.0; LANES]; 3], irradiance: [[0.0; LANES]; 3] };
            for (i, near) in near.iter().enumerate() {
                let (direction, mut irradiance) = near.at(position);
                if let Some(spot) = flakes.filter(|_| direction.dot(axes[2]) > 0.0) {
                    irradiance *= spot.ratio(axes, tensor, &|position| near.at(position).0);
                }
                for c in 0..3 {
                    group.direction[c][i] = direction[c];
                    group.irradiance[c][i] = irradiance[c];
                }
            }
            lobe.light(&group, &mut sums);
        }
        if let Some(environment) = &self.environment {
            let share = 1.0 / (LANES * self.points.0.len()) as f32;
            self.points.0.iter().for_each(|points| lobe.reflect(environment, points, share, &mut sums));
        }
        let sum = |lanes: [Lanes; 3]| Vec3::from_array(lanes.map(|lanes| lanes.iter().sum()));
        self.f0 * sum(sums.facing) + sum(sums.grazing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ndf::{Axes, RoughnessTensor, ShapeInvariant};
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
            let lighting = Lighting::new(
                &[Light::Directional { direction: light, irradiance: Vec3::ONE }], None, Vec3::splat(0.25),
            );
            let found = f64::from(lighting.radiance(&lobe, Vec3::ZERO, normal, frame, view).x);
            let fresnel = 0.25 + 0.75 * (1.0 - v.dot((v + l).normalize())).powi(5);
            let expected = fresnel * lobe.specular(v, l);
            prop_assert!((found - expected).abs() <= 2e-3 * expected, "{found} {expected}");
        }
    }

    /// What one light gives a flat rough lobe at `position`, seen from straight ahead.
    fn lit(light: Light, position: Vec3) -> f32 {
        let lobe = Lobe::isotropic(Vec3::Z, Alpha(1.0));
        let frame = Frame { tangent: Vec3::X, bitangent: Vec3::Y };
        Lighting::new(&[light], None, Vec3::ONE).radiance(&lobe, position, Vec3::Z, frame, Vec3::Z).x
    }

    /// A point light is the directional light of intensity / distance^2.
    #[test]
    fn point_lights_fall_off_with_the_square() {
        let way = Vec3::new(0.6, 0.0, 0.8);
        let far = |irradiance| Light::Directional { direction: way, irradiance: Vec3::splat(irradiance) };
        let place = Vec3::new(0.3, -0.2, 0.1);
        for distance in [0.5, 1.0, 3.0] {
            let point = Light::Point { position: place + distance * way, intensity: Vec3::splat(2.0) };
            let expected = lit(far(2.0 / (distance * distance)), place);
            assert!((lit(point, place) - expected).abs() < 1e-5 * expected, "{distance}");
        }
    }

    /// From far away a rectangle is a point of intensity radiance x area x cosine; from behind it is dark; and nearby
    /// few points agree with many.
    #[test]
    fn rectangles_are_sums_of_lambertian_points() {
        let (right, up) = (Vec3::new(0.0, 0.4, 0.0), Vec3::new(0.25, 0.0, 0.0));
        let light = |middle: Vec3, right: Vec3, n: usize| Light::Rectangle {
            middle,
            right,
            up,
            radiance: Vec3::splat(3.0),
            columns: n,
            rows: n,
        };
        // right x up is -z: it shines down. Seen under 60 degrees from 40 away.
        let middle = 40.0 * Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
        let point = Light::Point { position: middle, intensity: Vec3::splat(3.0 * 0.4 * 0.5) };
        assert!((lit(light(middle, right, 5), Vec3::ZERO) / lit(point, Vec3::ZERO) - 1.0).abs() < 0.01);
        assert_eq!(lit(light(middle, -right, 5), Vec3::ZERO), 0.0);
        let near = Vec3::new(0.2, 0.1, 0.8);
        let (coarse, fine) = (lit(light(near, right, 6), Vec3::ZERO), lit(light(near, right, 60), Vec3::ZERO));
        assert!((coarse / fine - 1.0).abs() < 5e-3, "{coarse} {fine}");
    }
}
