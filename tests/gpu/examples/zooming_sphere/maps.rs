//! Texture maps in memory, and the mip chain that an engine makes of them.

use std::error::Error;

/// One level of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Texels across.
    pub width: usize,
    /// Texels down.
    pub height: usize,
    /// 0 to 1, the channels of a texel side by side, rows from the top.
    pub values: Vec<f32>,
}

/// A map with its mip levels, as a texture of the GPU holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// 1 or 4.
    pub channels: usize,
    /// Bits of a channel, 8 or 16.
    pub bits: u32,
    /// Finest first.
    pub levels: Vec<Level>,
}

/// Maps of a material, and how to read them.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Normals in red, green and (unless `two_channels`) blue.
    pub normal: Map,
    /// Perceptual roughness, or gloss.
    pub roughness: Map,
    /// Of glTF's form: direction in red and green, strength in blue.
    pub anisotropy: Option<Map>,
    /// Green is up: an OpenGL map.
    pub y_up: bool,
    /// By which x and y of normals are multiplied.
    pub normal_scale: f32,
    /// z is rebuilt from x and y.
    pub two_channels: bool,
    /// `roughness` is 1 - roughness.
    pub gloss: bool,
    /// Every second repeat is mirrored.
    pub mirrored: bool,
}

impl Map {
    /// Of this level 0, which is averaged down to a single texel: each texel is the mean of those under it, channel by
    /// channel, as engines do. Sides halve and round down, so that texels of odd sides have shares in two.
    pub fn averaged(channels: usize, bits: u32, level_0: Level) -> Self {
        let mut levels = vec![level_0];
        while levels[levels.len() - 1].width.max(levels[levels.len() - 1].height) > 1 {
            levels.push(levels[levels.len() - 1].halved(channels));
        }
        Self { channels, bits, levels }
    }

    /// The same map with mips that are plain means of level 0.
    pub fn with_plain_mips(&self) -> Self {
        Self::averaged(self.channels, self.bits, self.levels[0].clone())
    }

    /// All levels as a texture holds them, little-endian.
    pub fn bytes(&self, level: usize) -> Vec<u8> {
        let values = &self.levels[level].values;
        if self.bits == 8 {
            return values.iter().map(|v| (v * 255.0).round() as u8).collect();
        }
        values.iter().flat_map(|v| ((v * 65535.0).round() as u16).to_le_bytes()).collect()
    }

    /// Complains about levels that a texture cannot have.
    pub fn check(&self, name: &str) -> Result<(), Box<dyn Error>> {
        let first = self.levels.first().ok_or_else(|| format!("the {name} map has no levels"))?;
        for (k, level) in self.levels.iter().enumerate() {
            let (width, height) = ((first.width >> k).max(1), (first.height >> k).max(1));
            if (level.width, level.height) != (width, height) {
                let found = format!("{} x {}", level.width, level.height);
                return Err(format!("level {k} of the {name} map is {found}, expected {width} x {height}").into());
            }
        }
        let last = &self.levels[self.levels.len() - 1];
        if (last.width, last.height) != (1, 1) {
            return Err(format!("the {name} map ends at {} x {}, expected 1 x 1", last.width, last.height).into());
        }
        Ok(())
    }
}

impl Material {
    /// As an engine would have it that is given level 0 alone.
    pub fn with_plain_mips(&self) -> Self {
        Self {
            normal: self.normal.with_plain_mips(),
            roughness: self.roughness.with_plain_mips(),
            anisotropy: self.anisotropy.as_ref().map(Map::with_plain_mips),
            ..*self
        }
    }
}

impl Level {
    fn halved(&self, channels: usize) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let (across, down) = (shares(self.width, width), shares(self.height, height));
        let mut values = vec![0.0; width * height * channels];
        for (texel, out) in values.chunks_exact_mut(channels).enumerate() {
            for &(y, share_y) in &down[texel / width] {
                for &(x, share_x) in &across[texel % width] {
                    let from = (y * self.width + x) * channels;
                    for (out, v) in out.iter_mut().zip(&self.values[from..from + channels]) {
                        *out += share_x * share_y * v;
                    }
                }
            }
        }
        Self { width, height, values }
    }
}

/// Which of `fine` texels in a row lie under each of `coarse` ones, with shares that sum to 1.
fn shares(fine: usize, coarse: usize) -> Vec<Vec<(usize, f32)>> {
    let size = fine as f32 / coarse as f32;
    let row = |i: usize| {
        let (from, to) = (i as f32 * size, (i + 1) as f32 * size);
        let under = (from as usize)..fine.min(to.ceil() as usize);
        under.map(|x| (x, (to.min(x as f32 + 1.0) - from.max(x as f32)) / size)).filter(|(_, s)| *s > 0.0).collect()
    };
    (0..coarse).map(row).collect()
}
