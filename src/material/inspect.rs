//! What is wrong with the texels of a material, counted.

use std::path::Path;

use ndarray::Array3;
use rayon::prelude::*;

use super::Material;
use super::source::{LEAST_REBUILT_Z, SHORTEST_NORMAL};
use crate::error::{Error, Result};
use crate::image::Samples;

/// Counts over level 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Findings {
    /// Texels.
    pub texels: usize,
    /// Normals that point into the surface or along it (z <= 0).
    pub behind: usize,
    /// Normals that are not a number, or too short to have a direction.
    pub directionless: usize,
    /// Roughness that is not a number.
    pub roughness_not_finite: usize,
    /// Roughness outside 0..1.
    pub roughness_outside: usize,
    /// Samples of plain channels that are not a number.
    pub others_not_finite: usize,
    /// Mean length of the stored normals.
    pub mean_length: f64,
    /// Mean of the stored x and y, -1..1.
    pub mean_xy: [f64; 2],
}

impl Findings {
    /// Normals that the fold ignores.
    pub fn unusable(&self) -> usize {
        self.behind + self.directionless
    }

    /// Whether the normals look sRGB-encoded: flat is stored as 188,188,255, so x and y lean by 0.47 alike and
    /// normals are far longer than 1. Real surfaces do not lean to +x +y by 25 degrees in the mean.
    pub fn looks_srgb(&self) -> bool {
        self.mean_xy.iter().all(|m| m.abs() > 0.35 && m.abs() < 0.6)
            && (self.mean_xy[0].abs() - self.mean_xy[1].abs()).abs() < 0.1
            && self.mean_length > 1.1
    }

    fn add(mut self, o: &Findings) -> Self {
        self.texels += o.texels;
        self.behind += o.behind;
        self.directionless += o.directionless;
        self.roughness_not_finite += o.roughness_not_finite;
        self.roughness_outside += o.roughness_outside;
        self.others_not_finite += o.others_not_finite;
        self.mean_length += o.mean_length;
        (0..2).for_each(|i| self.mean_xy[i] += o.mean_xy[i]);
        self
    }
}

/// Where nothing can be wrong with the single texels, statistics are taken from one row in this many. Not a power of two,
/// with which weaves would agree.
const SAMPLED_ROWS: usize = 17;

fn all_above<T: Copy + PartialOrd + Sync>(samples: &Array3<T>, channel: usize, least: T) -> bool {
    let (_, width, channels) = samples.dim();
    let samples = samples.as_slice().expect("standard layout");
    samples.par_chunks(width * channels).all(|row| row.chunks_exact(channels).all(|texel| texel[channel] >= least))
}

impl Material {
    /// Counts what is wrong with the texels, row by row in parallel. Counts are exact; the means of the normals come
    /// from one row in 17 where no texel can be wrong.
    pub fn inspect(&self) -> Findings {
        let step = if self.texels_are_sound() { SAMPLED_ROWS } else { 1 };
        let rows = (0..self.size.height)
            .into_par_iter()
            .step_by(step)
            .map_init(|| vec![0.0; 4 * self.size.width], |buffer, y| self.inspect_row(y, buffer));
        // Collected before adding, so that the sums do not depend on how rows were shared out.
        let rows: Vec<Findings> = rows.collect();
        let mut all = rows.iter().fold(Findings::default(), Findings::add);
        let n = all.texels as f64;
        all.mean_length /= n;
        all.mean_xy = all.mean_xy.map(|sum| sum / n);
        all.texels = self.size.texels();
        all
    }

    /// Whether the stored samples alone show that every normal points up with a direction and every roughness is in
    /// 0..1: integers, and no z near or below 0.
    fn texels_are_sound(&self) -> bool {
        let integer = |map: usize| self.maps[map].raster.bits() < 32;
        let normals = self.normal.as_ref().is_none_or(|source| {
            let samples = &self.maps[source.map].raster.samples;
            source.channels[2].is_none_or(|z| {
                // The first stored value whose z = 2 v - 1 exceeds the shortest usable normal.
                let least = |max: f32| (0.5 + 0.5 * SHORTEST_NORMAL) * max;
                match samples {
                    Samples::U8(s) => all_above(s, z, (least(255.0) + 1.0) as u8),
                    Samples::U16(s) => all_above(s, z, (least(65535.0) + 1.0) as u16),
                    Samples::F32(_) => false,
                }
            }) && integer(source.map)
        });
        normals && self.width.iter().chain(&self.others).all(|(map, _)| integer(*map))
    }

    fn inspect_row(&self, y: usize, buffer: &mut [f32]) -> Findings {
        let width = self.size.width;
        let mut found = Findings { texels: width, ..Findings::default() };
        let mut rows = buffer.chunks_exact_mut(width);
        let [nx, ny, nz, roughness] = std::array::from_fn(|_| rows.next().expect("four rows"));
        if let Some(source) = &self.normal {
            let map = &self.maps[source.map];
            for (channel, row) in source.channels.into_iter().zip([&mut *nx, &mut *ny, &mut *nz]) {
                if let Some(channel) = channel {
                    map.raster.read(channel, y, 0, row);
                }
            }
            let (scale, offset) = if map.signed { (1.0, 0.0) } else { (2.0, -1.0) };
            let stored_z = source.channels[2].is_some();
            let (mut length_sum, mut x_sum, mut y_sum) = (0.0f64, 0.0f64, 0.0f64);
            for x in 0..width {
                let [vx, vy] = [nx[x], ny[x]].map(|v| scale * v + offset);
                // A rebuilt z never points down.
                let least = LEAST_REBUILT_Z * LEAST_REBUILT_Z;
                let rebuilt = (1.0 - vx * vx - vy * vy).max(least).sqrt();
                let vz = if stored_z { scale * nz[x] + offset } else { rebuilt };
                let length2 = vx * vx + vy * vy + vz * vz;
                let directed = (length2 > SHORTEST_NORMAL * SHORTEST_NORMAL) & (length2 < f32::MAX);
                found.directionless += usize::from(!directed);
                found.behind += usize::from(directed & (vz <= 0.0));
                if directed {
                    length_sum += f64::from(length2.sqrt());
                    x_sum += f64::from(vx);
                    y_sum += f64::from(vy);
                }
            }
            (found.mean_length, found.mean_xy) = (length_sum, [x_sum, y_sum]);
        }
        if let Some((map, channel)) = self.width {
            self.maps[map].raster.read(channel, y, 0, roughness);
            found.roughness_not_finite = roughness.iter().filter(|v| !v.is_finite()).count();
            found.roughness_outside = roughness.iter().filter(|v| v.is_finite() && !(0.0..=1.0).contains(*v)).count();
        }
        for &(map, channel) in self.others.iter().filter(|(map, _)| self.maps[*map].raster.bits() == 32) {
            self.maps[map].raster.read(channel, y, 0, roughness);
            found.others_not_finite += roughness.iter().filter(|v| !v.is_finite()).count();
        }
        found
    }

    /// Counts what is wrong and says it in the warnings; `normal` is the file of the normals.
    ///
    /// # Errors
    /// [`Error::Invalid`] if no normal is of use.
    pub(super) fn checked(mut self, normal: &Path) -> Result<Self> {
        let found = self.inspect();
        let share = |n: usize, what: &str| {
            format!("{n} of {} {what} ({:.3} %)", found.texels, 100.0 * n as f64 / found.texels as f64)
        };
        if let Some(source) = &self.normal {
            if found.unusable() == found.texels {
                let what = if found.behind == 0 { "no normal with a direction" } else { "no normal that points up" };
                return Err(Error::invalid(normal, what, "a tangent-space normal map"));
            }
            let stem = self.maps[source.map].stem.clone();
            for (count, what) in [
                (found.behind, "do not point out of the surface (z <= 0)"),
                (found.directionless, "have no direction (zero, nearly zero or not a number)"),
            ] {
                if count > 0 {
                    self.warnings.push(format!("{stem}: {} {what}; the fold ignores them", share(count, "normals")));
                }
            }
            if found.looks_srgb() {
                self.warnings.push(format!(
                    "{stem}: looks sRGB-encoded (mean x {:+.2}, y {:+.2}, length {:.2}): flat is stored near 188,188,255 \
                     where it should be 128,128,255. Export it again as linear (non-colour) data",
                    found.mean_xy[0], found.mean_xy[1], found.mean_length
                ));
            }
        }
        for (count, of, what) in [
            (found.roughness_not_finite, "roughness values", "are not a number; taken as 1"),
            (found.roughness_outside, "roughness values", "lie outside 0..1; the fold clamps them"),
            (found.others_not_finite, "texels of other channels", "are not a number; taken as 0"),
        ] {
            if count > 0 {
                self.warnings.push(format!("{} {what}", share(count, of)));
            }
        }
        Ok(self)
    }
}
