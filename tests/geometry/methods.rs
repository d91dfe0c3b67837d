//! Geometric filters, as the shader helpers' twins have them, over fragments.

use glam::{DVec2, DVec3, Vec3};
use mipfold::kernels::twins::geometric_aa::*;
use mipfold::ndf::{Lobe, RoughnessTensor};
use mipfold::render::{Fragment, Light};

use super::shapes::Object;

/// What a shader knows of a pixel and a light, in f64.
pub struct Known<'a> {
    pub alpha2: f64,
    /// Tangent, bitangent and normal.
    pub axes: [DVec3; 3],
    /// Of the normal, over a pixel to the right and up.
    pub dn: [DVec3; 2],
    /// Half vector.
    pub h: DVec3,
    /// And its derivatives.
    pub dh: [DVec3; 2],
    pub fragment: &'a Fragment,
    pub object: &'a Object,
}

impl<'a> Known<'a> {
    pub fn new(object: &'a Object, fragment: &'a Fragment, light: &Light, alpha: f64) -> Self {
        let Light::Directional { direction, .. } = light else { panic!("lights are far away: {light:?}") };
        let (l, p, steps) = (direction.as_dvec3(), &fragment.point, [&fragment.right, &fragment.up]);
        let v = p.view.as_dvec3();
        Self {
            alpha2: alpha * alpha,
            axes: [p.frame.tangent, p.frame.bitangent, p.normal].map(Vec3::as_dvec3),
            dn: steps.map(|step| step.normal.as_dvec3()),
            h: (v + l).normalize_or_zero(),
            dh: steps.map(|step| half_vector_derivative(v, l, step.view.as_dvec3(), DVec3::ZERO)),
            fragment,
            object,
        }
    }

    /// The lobe's own tensor.
    pub fn round(&self) -> DVec3 {
        self.alpha2 * DVec3::new(1.0, 0.0, 1.0)
    }

    /// Of the half vector's components in the tangent frame, per pixel.
    pub fn half_vectors(&self) -> [DVec2; 2] {
        let [t, b, n] = self.axes;
        [0, 1].map(|i| projected_derivative(self.h, self.dh[i], n, self.dn[i], t, b))
    }

    /// The same with the component along the normal.
    pub fn half_vectors_in_space(&self) -> [DVec3; 2] {
        let (n, moved) = (self.axes[2], self.half_vectors());
        [0, 1].map(|i| moved[i].extend(self.dh[i].dot(n) + self.h.dot(self.dn[i])))
    }

    /// Of its slopes.
    fn slopes(&self) -> [DVec2; 2] {
        let h = DVec3::from_array(self.axes.map(|axis| self.h.dot(axis)));
        self.half_vectors_in_space().map(|moved| slope_derivative(h, moved))
    }

    /// Of the normal along the tangent and the bitangent.
    pub fn normals(&self) -> [DVec2; 2] {
        self.dn.map(|dn| DVec2::new(dn.dot(self.axes[0]), dn.dot(self.axes[1])))
    }

    /// What the baked map has for the pixel: one trilinear probe, or up to 16 along the footprint.
    pub fn baked(&self, probes: bool) -> DVec3 {
        let (p, steps) = (&self.fragment.point, [self.fragment.right.uv, self.fragment.up.uv]);
        let map = self.object.baked(p.triangle);
        let found = if probes { map.anisotropic(p.uv, steps, 16) } else { map.trilinear(p.uv, steps) };
        let r = found.roughness;
        DVec3::new(r.xx.into(), r.xy.into(), r.yy.into())
    }

    /// The kernel of `dn = W dp`, W between the vertices, dp the pixel's own.
    pub fn vertices(&self) -> DVec3 {
        let p = &self.fragment.point;
        let corners = self.object.mesh.triangles[p.triangle];
        let form: [f64; 6] = std::array::from_fn(|k| {
            let at = |(i, w): (u32, f32)| f64::from(w) * self.object.curvature[i as usize].form[k];
            corners.into_iter().zip(p.weights).map(at).sum()
        });
        let [xx, xy, xz, yy, yz, zz] = form;
        let w = glam::DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let turn = |step: Vec3| {
            let dn = w * step.as_dvec3();
            DVec2::new(dn.dot(self.axes[0]), dn.dot(self.axes[1]))
        };
        kernel(turn(self.fragment.right.position), turn(self.fragment.up.position), SIGMA2_BOX)
    }
}

/// A filter: the tensor to shade with, in the tangent frame.
pub struct Method {
    pub name: &'static str,
    pub tensor: fn(&Known) -> DVec3,
    /// Whether it needs baked maps.
    pub needs_uvs: bool,
}

fn isotropic(alpha2: f64) -> DVec3 {
    alpha2 * DVec3::new(1.0, 0.0, 1.0)
}

const fn method(name: &'static str, tensor: fn(&Known) -> DVec3) -> Method {
    Method { name, tensor, needs_uvs: false }
}

/// All of them; the first does nothing.
pub const METHODS: &[Method] = &[
    method("no filter", |k| k.round()),
    method("2016, slopes", |k| {
        let [a, b] = k.slopes();
        aa_2016(k.round(), a, b, EXTENT_2016)
    }),
    method("2017, half vectors, axes", |k| {
        let [a, b] = k.half_vectors();
        aa_2019_axes(k.round(), a, b, SIGMA2_HALF, MOST_ADDED)
    }),
    method("2019, normals, one width", |k| {
        isotropic(aa_2019_normals(k.alpha2, k.dn[0], k.dn[1], SIGMA2_HALF, MOST_ADDED))
    }),
    method("2019, half vectors", |k| {
        let [a, b] = k.half_vectors();
        aa_2019(k.round(), a, b, SIGMA2_HALF)
    }),
    method("2021, normals, one width", |k| {
        isotropic(aa_2021_normals(k.alpha2, k.dn[0], k.dn[1], SIGMA2_PEAK, MOST_ADDED))
    }),
    method("2021, normals, two widths", |k| {
        let [a, b] = k.normals();
        add_kernel_projected(k.round(), kernel(a, b, SIGMA2_PEAK))
    }),
    method("2021, half vectors", |k| {
        let [a, b] = k.half_vectors();
        aa_2021(k.round(), a, b, SIGMA2_PEAK)
    }),
    method("box, normals, one width", |k| {
        isotropic(aa_2021_normals(k.alpha2, k.dn[0], k.dn[1], SIGMA2_BOX, MOST_ADDED))
    }),
    method("box, half vectors", |k| {
        let [a, b] = k.half_vectors();
        aa_2021(k.round(), a, b, SIGMA2_BOX)
    }),
    Method { name: "baked", tensor: |k| add_kernel_projected(k.round(), k.baked(false)), needs_uvs: true },
    Method {
        name: "baked, anisotropic look-ups",
        tensor: |k| add_kernel_projected(k.round(), k.baked(true)),
        needs_uvs: true,
    },
    method("vertex curvature", |k| add_kernel_projected(k.round(), k.vertices())),
];

/// A lobe about the mesh's normal.
pub fn lobe(tensor: DVec3) -> Lobe {
    Lobe { normal: Vec3::Z, roughness: roughness(tensor) }
}

pub fn roughness(t: DVec3) -> RoughnessTensor {
    RoughnessTensor { xx: t.x as f32, xy: t.y as f32, yy: t.z as f32 }
}
