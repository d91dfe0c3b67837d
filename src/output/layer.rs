//! Whatever has levels and channels, as rows: one form for all containers.

use std::borrow::Cow;
use std::io::{Seek, Write};

use super::exr::{further, role_name, view};
use super::extra::{self, ExtraLevel};
use super::sheet::{Sheet, Source, is_opaque};
use crate::codec::{Channel, Depth, write_exr};
use crate::fold::Chain;
use crate::image::{Raster, Samples, Size};
use crate::material::{Encoding, Extra, FurtherMap, Material, Role, quantised};

/// A map that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// One of the plan's sheets, by its index.
    Sheet(usize),
    /// A map of a further lobe.
    Further(FurtherMap),
    /// An extra map.
    Extra(Extra),
}

/// The rows of a layer.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    /// What is shown.
    pub material: &'a Material,
    /// Its levels from 1 on.
    pub chain: &'a Chain,
    /// The plan's.
    pub sheets: &'a [Sheet],
    /// Which of its maps.
    pub layer: Layer,
    /// Whether the normals of further lobes have their green the other way than the material's: sheets say it themselves.
    pub flipped: bool,
}

impl Rows<'_> {
    /// Its channels: name and role.
    pub fn channels(&self, encoding: Encoding) -> Vec<(String, String)> {
        match self.layer {
            Layer::Sheet(i) => {
                let sheet = &self.sheets[i];
                let names = sheet.channels.iter().enumerate();
                names.map(|(c, (name, _))| (name.clone(), sheet.role_name(self.material, c).to_owned())).collect()
            }
            Layer::Further(map) => map.channels().map(String::from).zip(map.roles(role_name)).collect(),
            Layer::Extra(extra) => {
                let channels = extra.channels(encoding);
                // An integer picture of one channel is gray.
                let plain: &[&str] = match (encoding, channels.len()) {
                    (Encoding::Signed, _) => &[],
                    (_, 1) => &["Y"],
                    _ => &["R", "G", "B"],
                };
                let named = channels.iter().enumerate();
                named.map(|(i, (name, role))| ((*plain.get(i).unwrap_or(name)).into(), (*role).into())).collect()
            }
        }
    }

    /// The channels that a texture for GPUs has of it: all but an alpha that is 1 everywhere.
    pub fn texture_channels(&self) -> Vec<(String, String)> {
        let mut channels = self.channels(Encoding::Unsigned);
        if let Layer::Sheet(i) = self.layer
            && let Some((_, Source::Channel { map, channel, inverted: false })) = self.sheets[i].channels.last()
            && channels.len() > 1
            && is_opaque(self.material, *map, *channel)
        {
            channels.pop();
        }
        channels
    }

    /// Which channels are x and y of a normal, of which a shader makes z.
    pub fn normal_xy(&self) -> Option<(usize, usize)> {
        match self.layer {
            Layer::Sheet(i) => {
                let channel = |role| self.sheets[i].channel(self.material, role);
                channel(Role::NormalX).zip(channel(Role::NormalY))
            }
            Layer::Further(FurtherMap::Lobe(_)) => Some((0, 1)),
            Layer::Further(_) | Layer::Extra(_) => None,
        }
    }

    /// Bits of a sample in integer files.
    pub fn bits(&self) -> u8 {
        match self.layer {
            Layer::Sheet(i) => self.sheets[i].bits(self.material),
            Layer::Further(map) => map.depth(self.material),
            Layer::Extra(_) => extra::bits(self.material),
        }
    }

    /// Part of row `y` of a channel at a level, from column `x` on.
    pub fn row(&self, level: usize, channel: usize, encoding: Encoding, y: usize, x: usize, out: &mut [f32]) {
        match self.layer {
            Layer::Sheet(i) => {
                self.sheets[i].row(&view(self.material, self.chain, level), channel, encoding, y, x, out);
            }
            Layer::Further(map) => {
                further(self.material, self.chain, level, map).row(channel, encoding, y, x, out);
                if self.flips(channel) {
                    let sum = if encoding == Encoding::Signed { 0.0 } else { 1.0 };
                    out.iter_mut().for_each(|v| *v = sum - *v);
                }
            }
            Layer::Extra(extra) => {
                ExtraLevel::new(self.material, self.chain, extra, level).row(channel, encoding, y, x, out);
            }
        }
    }

    fn flips(&self, channel: usize) -> bool {
        self.flipped && self.normal_xy().is_some_and(|(_, y)| y == channel)
    }

    /// A whole level as an integer raster; level 0 of a map that comes back as it came is its own raster.
    pub fn raster(&self, level: usize) -> Cow<'_, Raster> {
        match self.layer {
            Layer::Sheet(i) => {
                let (sheet, view) = (&self.sheets[i], view(self.material, self.chain, level));
                if let Some(map) = sheet.map {
                    return view.raster(map);
                }
                // Level 0 is the input's own pixels, however long its normals are.
                let xy = if level == 0 { None } else { self.normal_xy() };
                let row = |channel: usize, y: usize, row: &mut [f32]| {
                    sheet.row(&view, channel, Encoding::Unsigned, y, 0, row)
                };
                let samples = quantised(view.size(), sheet.channels.len(), self.bits(), xy, row);
                Cow::Owned(Raster::new(samples))
            }
            Layer::Further(map) => {
                let mut raster = further(self.material, self.chain, level, map).raster();
                (0..raster.channels.len()).filter(|c| self.flips(*c)).for_each(|c| invert(&mut raster.samples, c));
                Cow::Owned(raster)
            }
            Layer::Extra(extra) => Cow::Owned(ExtraLevel::new(self.material, self.chain, extra, level).raster()),
        }
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.chain.levels.len() + 1
    }

    /// Size of a level.
    pub fn size(&self, level: usize) -> Size {
        self.material.size.level(level)
    }

    /// All levels as mip-mapped EXR; normals signed.
    ///
    /// # Errors
    /// Whatever `out` returns.
    pub fn write_exr(&self, out: impl Write + Seek, depth: Depth) -> std::io::Result<()> {
        let channels = self.channels(Encoding::Signed).into_iter();
        let channels: Vec<_> = channels.map(|(name, _)| Channel { name, depth }).collect();
        write_exr(out, &channels, self.material.size, self.material.wrap, &|level, channel, y, x, row| {
            self.row(level, channel, Encoding::Signed, y, x, row);
            if depth == Depth::Half {
                row.iter_mut().for_each(|v| *v = v.clamp(-LARGEST_HALF, LARGEST_HALF));
            }
        })
    }
}

/// What is larger would become infinite.
const LARGEST_HALF: f32 = 65504.0;

/// The other way round, exactly, in integers.
fn invert(samples: &mut Samples, channel: usize) {
    match samples {
        Samples::U8(s) => s.index_axis_mut(ndarray::Axis(2), channel).mapv_inplace(|v| 255 - v),
        Samples::U16(s) => s.index_axis_mut(ndarray::Axis(2), channel).mapv_inplace(|v| 65535 - v),
        Samples::F32(s) => s.index_axis_mut(ndarray::Axis(2), channel).mapv_inplace(|v| 1.0 - v),
    }
}
