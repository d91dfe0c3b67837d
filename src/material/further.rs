//! Maps of the lobes after the first. The first lobe of a mixture lives in the ordinary maps.

use super::lobes::BaseRows;
use super::pack::quantised;
use super::{Encoding, LevelView, Material, Role};
use crate::image::{Raster, Size};
use crate::ndf::{Form, Lobes};

/// A map of one further lobe: `j` counts from 1, and names count from 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FurtherMap {
    /// Red and green: x and y of the normal, stored as in the normal map. Blue: weight. Alpha: perceptual roughness, of two
    /// widths that of the smaller one. (Alpha is 0 for mirrors alone: where it is, some tools erase the other channels.)
    Lobe(usize),
    /// Of a lobe that has the first one's normal. Red: perceptual roughness. Green: weight. Blue: nothing.
    Haze(usize),
    /// Direction and strength of its anisotropy, in glTF's form.
    Anisotropy(usize),
}

/// What a channel holds.
#[derive(Clone, Copy)]
enum Part {
    Of(Role),
    Weight,
    Unused,
}

impl FurtherMap {
    /// The maps that lobes need beside the ordinary ones.
    pub fn all(form: Form, count: usize, shared_normal: bool) -> Vec<Self> {
        let maps = |j| {
            let lobe = if shared_normal { Self::Haze(j) } else { Self::Lobe(j) };
            std::iter::once(lobe).chain((form == Form::Anisotropic).then_some(Self::Anisotropy(j)))
        };
        (1..count).flat_map(maps).collect()
    }

    /// Which lobe it is about, from 1 on.
    pub fn lobe(self) -> usize {
        let (Self::Lobe(j) | Self::Haze(j) | Self::Anisotropy(j)) = self;
        j
    }

    /// Behind the material's name: "lobe2", "lobe2_anisotropy", "haze" (and "haze3" for one more).
    pub fn suffix(self) -> String {
        match self {
            Self::Lobe(j) => format!("lobe{}", j + 1),
            Self::Haze(1) => "haze".into(),
            Self::Haze(j) => format!("haze{}", j + 1),
            Self::Anisotropy(j) => format!("lobe{}_anisotropy", j + 1),
        }
    }

    fn parts(self) -> &'static [Part] {
        use Part::{Of, Unused, Weight};
        match self {
            Self::Lobe(_) => &[Of(Role::NormalX), Of(Role::NormalY), Weight, Of(Role::Roughness)],
            Self::Haze(_) => &[Of(Role::Roughness), Weight, Unused],
            Self::Anisotropy(_) => &[Of(Role::AnisotropyX), Of(Role::AnisotropyY), Of(Role::AnisotropyStrength)],
        }
    }

    /// Bits of a sample in a PNG: those of the normal map, and 8 without one; 16 for float maps.
    pub fn depth(self, material: &Material) -> u8 {
        material.maps.iter().find(|map| map.channel(Role::NormalX).is_some()).map_or(8, |map| map.bits.min(16))
    }

    /// Names of its channels.
    pub fn channels(self) -> impl Iterator<Item = &'static str> {
        ["R", "G", "B", "A"].into_iter().take(self.parts().len())
    }

    /// What each channel holds, as the names of [`Role`]s in a manifest (`role_name`), for this lobe: "lobe2.normal.x", ...
    pub fn roles(self, role_name: impl Fn(Role) -> &'static str) -> Vec<String> {
        let name = |part: &Part| match part {
            Part::Of(role) => further_role(self.lobe(), role_name(*role)),
            Part::Weight => further_role(self.lobe(), "weight"),
            Part::Unused => "unused".into(),
        };
        self.parts().iter().map(name).collect()
    }
}

/// A role in a manifest of further lobe `j`.
pub(super) fn further_role(j: usize, role: &str) -> String {
    format!("lobe{}.{role}", j + 1)
}

/// One level of a map of a further lobe. At level 0, and wherever texels have fewer lobes, it is the first lobe again, with
/// weight 0: what the levels above are mixed with.
#[derive(Clone, Copy)]
pub struct FurtherView<'a> {
    /// The level; its main axis is that of this lobe.
    pub level: LevelView<'a>,
    /// The map.
    pub map: FurtherMap,
    /// One width or two, which level 0 does not say.
    pub form: Form,
}

impl<'a> FurtherView<'a> {
    /// The lobes, where they have this one.
    fn lobes(&self) -> Option<&'a Lobes> {
        self.level.folded.map(|(lobes, _)| lobes).filter(|lobes| self.map.lobe() < lobes.count())
    }

    /// Part of row `y` of a channel, from column `x` on.
    pub fn row(&self, channel: usize, encoding: Encoding, y: usize, x: usize, out: &mut [f32]) {
        let n = out.len();
        let role = match self.map.parts()[channel] {
            Part::Of(role) => role,
            Part::Weight => {
                match self.lobes() {
                    None => out.fill(0.0),
                    Some(lobes) => out.copy_from_slice(&lobes.row(weight_plane(lobes, self.map.lobe()), y)[x..x + n]),
                }
                return;
            }
            Part::Unused => {
                out.fill(0.0);
                return;
            }
        };
        match self.level.folded {
            None => {
                let mut rows = BaseRows::default();
                let rows = rows.read(self.level.material, self.form, y, x, n);
                self.level.of_lobe(role, encoding, self.form, |plane| &rows[plane], out);
            }
            Some((lobes, _)) => {
                let first = self.lobes().map_or(0, |lobes| self.map.lobe() * lobes.stride());
                let part = |plane: usize| &lobes.row(first + plane, y)[x..x + n];
                self.level.of_lobe(role, encoding, lobes.form(), part, out);
            }
        }
    }

    /// The whole level as an integer raster, of the normal map's depth, 16 bit for float maps. Weights are rounded so that
    /// those of all further lobes never sum to more than 1.
    pub fn raster(&self) -> Raster {
        let (parts, bits) = (self.map.parts(), self.map.depth(self.level.material));
        let xy = matches!(self.map, FurtherMap::Lobe(_)).then_some((0, 1));
        let row = |channel: usize, y: usize, row: &mut [f32]| match (parts[channel], self.lobes()) {
            (Part::Weight, Some(lobes)) => rounded_weights(lobes, self.map.lobe(), y, bits, row),
            _ => self.row(channel, Encoding::Unsigned, y, 0, row),
        };
        let samples = quantised(self.size(), parts.len(), bits, xy, row);
        Raster { samples, channels: self.map.channels().map(String::from).collect() }
    }

    fn size(&self) -> Size {
        self.level.size()
    }
}

fn weight_plane(lobes: &Lobes, j: usize) -> usize {
    j * lobes.stride() + lobes.form().planes()
}

/// A row of weights of lobe `j`, as steps of a file of so many bits.
fn rounded_weights(lobes: &Lobes, j: usize, y: usize, bits: u8, out: &mut [f32]) {
    let most = ((1u32 << bits) - 1) as f32;
    let rows: Vec<&[f32]> = (1..lobes.count()).map(|k| lobes.row(weight_plane(lobes, k), y)).collect();
    for (x, out) in out.iter_mut().enumerate() {
        let exact: Vec<f32> = rows.iter().map(|row| row[x].clamp(0.0, 1.0) * most).collect();
        *out = rounded_shares(&exact, most)[j - 1] / most;
    }
}

/// Whole numbers next to `exact` with a sum of at most `most`: what was rounded up most is rounded down first.
fn rounded_shares(exact: &[f32], most: f32) -> Vec<f32> {
    let mut whole: Vec<f32> = exact.iter().map(|v| v.round()).collect();
    while whole.iter().sum::<f32>() > most {
        let up = |k: &usize| whole[*k] - exact[*k];
        let k = (0..whole.len()).max_by(|a, b| up(a).total_cmp(&up(b))).expect("a sum above 0 has a part");
        whole[k] -= 1.0;
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn maps_follow_the_lobes() {
        use FurtherMap::{Anisotropy, Haze, Lobe};
        assert_eq!(FurtherMap::all(Form::Anisotropic, 1, false), []);
        assert_eq!(FurtherMap::all(Form::Isotropic, 3, false), [Lobe(1), Lobe(2)]);
        assert_eq!(FurtherMap::all(Form::Isotropic, 2, true), [Haze(1)]);
        assert_eq!(FurtherMap::all(Form::Anisotropic, 2, false), [Lobe(1), Anisotropy(1)]);
        assert_eq!([Lobe(1), Haze(1), Anisotropy(2)].map(FurtherMap::suffix), ["lobe2", "haze", "lobe3_anisotropy"]);
    }

    proptest! {
        #[test]
        fn rounded_weights_leave_the_first_lobe_its_share(parts in prop::collection::vec(0.0f32..1.0, 2..=4)) {
            let sum: f32 = parts.iter().sum::<f32>().max(1e-6);
            let exact: Vec<f32> = parts[1..].iter().map(|v| v / sum * 255.0).collect();
            let whole = rounded_shares(&exact, 255.0);
            prop_assert!(whole.iter().sum::<f32>() <= 255.0);
            // No weight is off by more than a step, and the first one, the rest, by half a step for each other.
            prop_assert!(whole.iter().zip(&exact).all(|(w, e)| (w - e).abs() <= 1.0));
            let first = 255.0 - whole.iter().sum::<f32>();
            prop_assert!(first >= 0.0 && (first - parts[0] / sum * 255.0).abs() <= 1.5 + 1e-3);
        }
    }
}
