//! A material: its maps, and its texels as a fold sees them.

use std::f32::consts::PI;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::{MaterialFlakes, NormalY, NormalZ, Role, Texels};
use crate::curvature;
use crate::image::{Raster, Size, Wrap};
use crate::ndf::Gltf;
use crate::roughness::PerceptualRoughness;

/// Where a map came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A file as given, its digest and the size it had.
    File {
        /// As given on the command line.
        path: PathBuf,
        /// SHA-256 of the file, hexadecimal.
        sha256: String,
        /// Before any resampling.
        size: Size,
        /// "PNG", "JPEG", ...
        format: &'static str,
        /// The file itself, if it can stand for level 0 byte for byte.
        plain_png: Option<Arc<[u8]>>,
        /// Whether the map is another picture, made from the file: normals from heights.
        derived: bool,
        /// Whether a factor was multiplied into it.
        scaled: bool,
    },
    /// Made from something else, which is said.
    Generated(String),
}

/// One map: a picture whose channels have roles. Comes back in the same packing.
#[derive(Clone, Debug)]
pub struct MapFile {
    /// Base name of the outputs, without extension.
    pub stem: String,
    /// Where it came from.
    pub origin: Origin,
    /// Level 0, at the material's size.
    pub raster: Raster,
    /// Bits a sample on the way out: 8, 16 or 32 (float).
    pub bits: u8,
    /// One role a channel.
    pub roles: Vec<Role>,
    /// Whether normals are stored as -1..1 (float files) and not as 0..1.
    pub signed: bool,
}

impl MapFile {
    /// The channel with this role.
    pub fn channel(&self, role: Role) -> Option<usize> {
        self.roles.iter().position(|r| *r == role)
    }
}

/// Normals: a map and how to read it.
#[derive(Clone, Debug)]
pub(super) struct NormalSource {
    pub map: usize,
    pub channels: [Option<usize>; 3],
}

/// A mesh under a texture, and what it adds.
#[derive(Clone, Debug)]
pub struct MeshUnder {
    /// Which, and how it was baked.
    pub about: MeshAbout,
    /// By level, level 0 first; none where it is only known that a chain was baked with it.
    pub added: Vec<curvature::Level>,
}

/// A mesh that was baked, as manifests name it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshAbout {
    /// As given on the command line; what is not Unicode in it is replaced.
    pub path: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Set of texture coordinates.
    pub uv_set: usize,
    /// Texels beside the surface that were filled.
    pub padding: usize,
    /// Triangles that were baked.
    pub triangles: usize,
}

/// Maps of one surface, all of one size, linear.
#[derive(Clone, Debug)]
pub struct Material {
    /// For messages and output names.
    pub name: String,
    /// Of level 0 of every map.
    pub size: Size,
    /// Every map that comes back.
    pub maps: Vec<MapFile>,
    /// Convention of the normal map.
    pub normal_y: NormalY,
    /// Strength that the renderer multiplies x and y of the normal with (glTF's `normalTexture.scale`).
    pub normal_scale: f32,
    /// What lies beyond the border.
    pub wrap: Wrap,
    /// What was understood, ignored or assumed.
    pub notes: Vec<String>,
    /// What is probably wrong with the input.
    pub warnings: Vec<String>,
    /// The mesh under the texture, if its curvature was baked.
    pub mesh: Option<MeshUnder>,
    /// Flakes on the surface, if it has any.
    pub flakes: Option<MaterialFlakes>,
    /// Map and channel of the normals; flat without.
    pub(super) normal: Option<NormalSource>,
    /// Map and channel of the roughness or smoothness; constant without.
    pub(super) width: Option<(usize, usize)>,
    /// Perceptual roughness where no map gives one.
    pub constant: PerceptualRoughness,
    /// Map and channels of direction x, y and strength.
    pub(super) anisotropy: Option<(usize, [usize; 3])>,
    /// Mean direction of the input's anisotropy, weighted by its strength.
    pub(super) anisotropy_lean: Vec2,
    /// Map and channel of the ambient occlusion, if it is known.
    pub occlusion: Option<(usize, usize)>,
    /// Map and channel of the metalness, if it is known.
    pub metal: Option<(usize, usize)>,
    /// Map and channel of each plainly averaged channel.
    pub(super) others: Vec<(usize, usize)>,
}

/// z of a two-channel normal whose x and y leave nothing for it.
pub(super) const LEAST_REBUILT_Z: f32 = 1e-3;

/// Normals shorter than this have no direction: near mid-gray, rounding and compression decide where they point.
pub(super) const SHORTEST_NORMAL: f32 = 0.1;

impl Material {
    /// Where z of the normals comes from: stored or rebuilt; auto without a normal map.
    pub fn normal_z(&self) -> NormalZ {
        match &self.normal {
            None => NormalZ::Auto,
            Some(NormalSource { channels: [_, _, None], .. }) => NormalZ::Rebuild,
            Some(_) => NormalZ::Stored,
        }
    }

    /// Radians: of the two directions of an axis, the one on the side of the input's own anisotropy.
    pub fn sided(&self, axis: f32) -> f32 {
        if self.anisotropy_lean.dot(Vec2::from_angle(axis)) < 0.0 { axis + PI } else { axis }
    }
}

impl Texels for Material {
    fn size(&self) -> Size {
        self.size
    }

    fn normals(&self, y: usize, x: usize, out: [&mut [f32]; 3], coverage: &mut [f32]) {
        let [nx, ny, nz] = out;
        let Some(source) = &self.normal else {
            nx.fill(0.0);
            ny.fill(0.0);
            nz.fill(1.0);
            coverage.fill(1.0);
            return;
        };
        let map = &self.maps[source.map];
        for (channel, row) in source.channels.into_iter().zip([&mut *nx, &mut *ny, &mut *nz]) {
            if let Some(channel) = channel {
                map.raster.read(channel, y, x, row);
            }
        }
        let (scale, offset) = if map.signed { (1.0, 0.0) } else { (2.0, -1.0) };
        let (strength, sign) = (self.normal_scale, self.normal_y.sign());
        let n = coverage.len();
        let (nx, ny, nz) = (&mut nx[..n], &mut ny[..n], &mut nz[..n]);
        if source.channels[2].is_none() {
            for i in 0..n {
                let (vx, vy) = (scale * nx[i] + offset, scale * ny[i] + offset);
                let z = (1.0 - vx * vx - vy * vy).max(LEAST_REBUILT_Z * LEAST_REBUILT_Z).sqrt();
                nz[i] = (z - offset) / scale;
            }
        }
        for i in 0..n {
            let (vx, vy, vz) = (scale * nx[i] + offset, sign * (scale * ny[i] + offset), scale * nz[i] + offset);
            let length2 = vx * vx + vy * vy + vz * vz;
            // Comparisons with NaN are false, so this also refuses what is not a number.
            let usable = (vz > 0.0) & (length2 > SHORTEST_NORMAL * SHORTEST_NORMAL) & (length2 < f32::MAX);
            let (sx, sy) = (strength * vx, strength * vy);
            let inverse = 1.0 / (sx * sx + sy * sy + vz * vz).sqrt();
            nx[i] = if usable { sx * inverse } else { 0.0 };
            ny[i] = if usable { sy * inverse } else { 0.0 };
            nz[i] = if usable { vz * inverse } else { 1.0 };
            coverage[i] = if usable { 1.0 } else { 0.0 };
        }
    }

    fn perceptual(&self, y: usize, x: usize, out: &mut [f32]) {
        let Some((map, channel)) = self.width else {
            out.fill(self.constant.0);
            return;
        };
        let map = &self.maps[map];
        map.raster.read(channel, y, x, out);
        let smoothness = map.roles[channel] == Role::Smoothness;
        for v in out {
            let r = if smoothness { 1.0 - *v } else { *v };
            // What is not a number becomes rough: it cannot sparkle.
            *v = if r.is_finite() { r.clamp(0.0, 1.0) } else { 1.0 };
        }
    }

    fn is_anisotropic(&self) -> bool {
        self.anisotropy.is_some()
    }

    fn tensors(&self, y: usize, x: usize, perceptual: &[f32], [xx, xy, yy]: [&mut [f32]; 3]) {
        let (map, channels) = self.anisotropy.expect("asked only where there is anisotropy");
        for (channel, row) in channels.into_iter().zip([&mut *xx, &mut *xy, &mut *yy]) {
            self.maps[map].raster.read(channel, y, x, row);
        }
        for (i, r) in perceptual.iter().enumerate() {
            let (dx, dy, strength) = (2.0 * xx[i] - 1.0, 2.0 * xy[i] - 1.0, yy[i].clamp(0.0, 1.0));
            let length = (dx * dx + dy * dy).sqrt();
            // A round lobe is not turned: that would only round it.
            let directed = length > SHORTEST_NORMAL && strength > 0.0;
            let (cos, sin) = if directed { (dx / length, dy / length) } else { (1.0, 0.0) };
            let alpha = PerceptualRoughness(*r).alpha();
            let tensor = Gltf { alpha, strength, direction: Vec2::new(cos, sin) }.tensor();
            (xx[i], xy[i], yy[i]) = (tensor.xx, tensor.xy, tensor.yy);
        }
    }

    fn curvature(&self) -> Option<&[curvature::Level]> {
        self.mesh.as_ref().map(|mesh| mesh.added.as_slice())
    }

    fn extras(&self) -> usize {
        self.others.len()
    }

    fn extra(&self, index: usize, y: usize, x: usize, out: &mut [f32]) {
        let (map, channel) = self.others[index];
        self.maps[map].raster.read(channel, y, x, out);
        // What is not a number must not spread to coarser levels.
        out.iter_mut().for_each(|v| *v = if v.is_finite() { *v } else { 0.0 });
    }
}
