//! A normal map on a curved mesh: what the mip chain holds and what the mesh adds.

use glam::{DVec3, Vec2};
use mipfold::fold::{FOLDS, Options, chain};
use mipfold::kernels::twins::footprint::{
    Footprint, bent_components, carried_derivative, footprint_half_vectors, footprint_normals,
};
use mipfold::kernels::twins::geometric_aa::*;
use mipfold::material::base_lobes;
use mipfold::ndf::{Form, Lobe};
use mipfold::render::{LobeMap, SurfacePoint};
use mipfold::roughness::Alpha;
use mipfold::sample::by_name;

use super::methods::{Known, roughness};
use super::shapes::Object;
use crate::common::sample_of_width;

/// Maps of one material, and how often they repeat over the mesh's texture coordinates.
pub struct Bumps {
    pub plain: LobeMap,
    pub folded: LobeMap,
    pub repeats: Vec2,
}

/// Probes of a look-up.
const TAPS: usize = 16;

impl Bumps {
    /// A sample's normals, `side` texels wide, over metal of one width.
    pub fn new(sample: &str, side: usize, alpha: f64, repeats: Vec2, scale: f32) -> Self {
        let material = sample_of_width(by_name(sample).unwrap(), side, Alpha(alpha as f32), scale);
        let levels = |fold: &str| {
            let fold = FOLDS.iter().find(|f| f.name == fold).unwrap();
            let options = Options { fold, ..Options::default() };
            LobeMap::new(&chain(&material, &options).into_lobes(base_lobes(&material, Form::Isotropic)))
        };
        Self { plain: levels("average"), folded: levels(Options::default().fold.name), repeats }
    }

    /// The truth's: level 0.
    pub fn base(&self, p: &SurfacePoint) -> Lobe {
        self.plain.base(p.uv * self.repeats)
    }
}

/// What a shader knows of the bumps at a pixel.
pub struct Bumpy<'a> {
    known: Known<'a>,
    bumps: &'a Bumps,
}

/// A lobe from a tensor in f64.
fn lobe(normal: DVec3, tensor: DVec3) -> Lobe {
    Lobe { normal: normal.as_vec3(), roughness: roughness(tensor) }
}

impl<'a> Bumpy<'a> {
    pub fn new(known: Known<'a>, bumps: &'a Bumps) -> Self {
        Self { known, bumps }
    }

    fn steps(&self) -> [Vec2; 2] {
        [self.known.fragment.right.uv, self.known.fragment.up.uv].map(|step| step * self.bumps.repeats)
    }

    fn looked_up(&self, map: &LobeMap) -> Lobe {
        map.anisotropic(self.known.fragment.point.uv * self.bumps.repeats, self.steps(), TAPS)
    }

    /// Derivatives of the lobe's normal, over a pixel.
    fn dm(&self, map: &LobeMap) -> [DVec3; 2] {
        let (uv, steps) = (self.known.fragment.point.uv * self.bumps.repeats, self.steps());
        let at = |uv: Vec2| map.anisotropic(uv, steps, TAPS).normal.as_dvec3();
        let quad = |step: Vec2| at(uv + 0.5 * step) - at(uv - 0.5 * step);
        steps.map(quad)
    }

    /// Of the mesh's normal or the half vector, in the tangent frame.
    fn local(&self, d: [DVec3; 2]) -> [DVec3; 2] {
        d.map(|d| DVec3::from_array(self.known.axes.map(|axis| d.dot(axis))))
    }

    fn footprint(&self, map: &LobeMap, dn: [DVec3; 2], dm: [DVec3; 2], sigma2: f64) -> Footprint {
        let Lobe { normal, roughness: r } = self.looked_up(map);
        Footprint {
            normal: normal.as_dvec3(),
            tensor: DVec3::new(r.xx.into(), r.xy.into(), r.yy.into()),
            base: self.known.round(),
            dndx: dn[0],
            dndy: dn[1],
            dmdx: dm[0],
            dmdy: dm[1],
            sigma2,
            most: MOST_ADDED,
            texel: 1.0,
        }
    }

    fn with_normals(&self, map: &LobeMap, dm: [DVec3; 2], sigma2: f64) -> Lobe {
        let found = footprint_normals(self.footprint(map, self.local(self.known.dn), dm, sigma2));
        lobe(found.normal, found.tensor)
    }

    /// A tensor of the mesh's tangent plane added to a lobe that the bumps have bent.
    fn with_mesh(&self, map: &LobeMap, k: DVec3) -> Lobe {
        let Lobe { normal, roughness: r } = self.looked_up(map);
        let n = normal.as_dvec3();
        let carried = |axis: DVec3| bent_components(n, carried_derivative(n, axis));
        let turn = glam::DMat2::from_cols(carried(DVec3::X), carried(DVec3::Y));
        let k = tensor(turn * matrix(k) * turn.transpose());
        lobe(n, add_kernel_projected(DVec3::new(r.xx.into(), r.xy.into(), r.yy.into()), k))
    }
}

/// A way to shade bumps on a curved mesh.
pub struct Way {
    pub name: &'static str,
    pub lobe: fn(&Bumpy) -> Lobe,
}

const NONE: [DVec3; 2] = [DVec3::ZERO; 2];

pub const WAYS: &[Way] = &[
    Way { name: "plain mips", lobe: |b| b.looked_up(&b.bumps.plain) },
    Way { name: "folded", lobe: |b| b.looked_up(&b.bumps.folded) },
    Way { name: "plain + curvature", lobe: |b| b.with_normals(&b.bumps.plain, NONE, SIGMA2_PEAK) },
    Way { name: "folded + curvature", lobe: |b| b.with_normals(&b.bumps.folded, NONE, SIGMA2_PEAK) },
    Way { name: "folded + curvature, box", lobe: |b| b.with_normals(&b.bumps.folded, NONE, SIGMA2_BOX) },
    Way {
        name: "folded + curvature, dm",
        lobe: |b| b.with_normals(&b.bumps.folded, b.dm(&b.bumps.folded), SIGMA2_PEAK),
    },
    Way {
        name: "folded + half vectors",
        lobe: |b| {
            let dh = b.known.half_vectors_in_space();
            let found = footprint_half_vectors(b.footprint(&b.bumps.folded, dh, NONE, SIGMA2_PEAK));
            lobe(found.normal, found.tensor)
        },
    },
    Way { name: "folded + baked", lobe: |b| b.with_mesh(&b.bumps.folded, b.known.baked(false)) },
    Way { name: "folded + vertex curvature", lobe: |b| b.with_mesh(&b.bumps.folded, b.known.vertices()) },
];

/// Share of the sample's own height: as much spread as the mesh's curvature has, so that both matter.
pub const SCALE: f32 = 0.2;

/// Sample, and repeats over the object's texture coordinates that put 5 to 15 texels under a pixel.
pub fn on(object: &Object) -> Option<(&'static str, Vec2)> {
    match object.name {
        "sphere" => Some(("hammered-metal", Vec2::new(8.0, 4.0))),
        "cylinder" => Some(("woven-cloth", Vec2::new(5.0, 6.0))),
        "torus" => Some(("hammered-metal", Vec2::new(18.0, 6.0))),
        "spot" => Some(("hammered-metal", Vec2::splat(6.0))),
        _ => None,
    }
}
