//! Maps that no input brought, but that the fold writes to.

use ndarray::Array3;

use super::Role;
use super::source::{MapFile, Material, Origin};
use crate::image::{Raster, Samples, Size};

impl Material {
    /// Adds the map that folded anisotropy is written to, in glTF's form, if no input brought one: isotropic at
    /// level 0.
    pub fn ensure_anisotropy_map(&mut self) {
        let roles = vec![Role::AnisotropyX, Role::AnisotropyY, Role::AnisotropyStrength];
        if self.maps.iter().any(|map| map.channel(Role::AnisotropyX).is_some()) {
            return;
        }
        let Size { width, height } = self.size;
        // Direction (1, 0), strength 0.
        let samples = Array3::from_shape_fn((height, width, 3), |(_, _, c)| [255, 128, 0][c]);
        self.maps.push(MapFile {
            stem: "anisotropy".into(),
            origin: Origin::Generated("isotropic at level 0".into()),
            raster: Raster::new(Samples::U8(samples)),
            bits: 8,
            roles,
            signed: false,
        });
        distinct_stems(&mut self.maps);
    }

    /// The folded roughness needs a map to live in.
    pub(super) fn add_constant_roughness(&mut self) {
        let Size { width, height } = self.size;
        let r = self.constant.0;
        let wide = self.maps.iter().any(|map| map.bits == 16);
        let dim = (height, width, 1);
        let samples = if wide {
            Samples::U16(Array3::from_elem(dim, (r * 65535.0).round() as u16))
        } else {
            Samples::U8(Array3::from_elem(dim, (r * 255.0).round() as u8))
        };
        let raster = Raster::new(samples);
        self.maps.push(MapFile {
            stem: "roughness".into(),
            origin: Origin::Generated(format!("constant perceptual roughness {r}")),
            bits: raster.bits(),
            raster,
            roles: vec![Role::Roughness],
            signed: false,
        });
    }
}

/// Two files of the same name from different folders must not write over each other.
pub(super) fn distinct_stems(maps: &mut [MapFile]) {
    for i in 1..maps.len() {
        let mut stem = maps[i].stem.clone();
        let mut n = 2;
        // File systems that ignore case exist.
        while maps[..i].iter().any(|other| other.stem.to_lowercase() == stem.to_lowercase()) {
            stem = format!("{}_{n}", maps[i].stem);
            n += 1;
        }
        maps[i].stem = stem;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stems_are_kept_apart() {
        let map = |stem: &str| MapFile {
            stem: stem.into(),
            origin: Origin::Generated(String::new()),
            raster: Raster::new(Samples::U8(Array3::zeros((1, 1, 1)))),
            bits: 8,
            roles: vec![Role::Roughness],
            signed: false,
        };
        let mut maps = [map("a"), map("a"), map("a_2"), map("a")];
        distinct_stems(&mut maps);
        assert_eq!(maps.map(|m| m.stem), ["a", "a_2", "a_2_2", "a_3"]);
    }
}
