//! Maps as they are written: the material's own, or packed anew as an engine wants them.

use super::exr::role_name;
use super::plan::safe_name;
use super::preset::{Preset, Slot};
use crate::image::Size;
use crate::material::{Encoding, LevelView, MapFile, Material, NormalY, Origin, Role, colour};

/// What a channel of an output map shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A channel of one of the material's maps.
    Channel {
        /// Index of the map.
        map: usize,
        /// Index of the channel.
        channel: usize,
        /// Whether its other end is 0: roughness as smoothness and back, a normal's green the other way.
        inverted: bool,
    },
    /// z of the normals of a map that has only x and y.
    NormalZ {
        /// Index of the map.
        map: usize,
    },
    /// The same everywhere.
    Constant(f32),
}

/// A map as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Base name of its files.
    pub stem: String,
    /// Its channels: their names, and what each shows.
    pub channels: Vec<(String, Source)>,
    /// The map whose channels these are, in their order and as they are.
    pub map: Option<usize>,
}

impl Sheet {
    /// A map of the material as it came.
    pub fn own(material: &Material, map: usize) -> Self {
        let file = &material.maps[map];
        let channels = file.raster.channels.iter().enumerate();
        let source = |channel| Source::Channel { map, channel, inverted: false };
        Self {
            stem: file.stem.clone(),
            channels: channels.map(|(i, name)| (name.clone(), source(i))).collect(),
            map: Some(map),
        }
    }

    /// Another arrangement, of up to four channels.
    pub fn arranged(stem: String, sources: &[Source]) -> Self {
        let names = ["R", "G", "B", "A"].map(String::from);
        Self { stem, channels: names.into_iter().zip(sources.iter().copied()).collect(), map: None }
    }

    /// Bits of a sample in integer files: those of the finest map that is in it, at most 16.
    pub fn bits(&self, material: &Material) -> u8 {
        let bits = self.channels.iter().map(|(_, source)| match source {
            Source::Channel { map, .. } | Source::NormalZ { map } => material.maps[*map].bits.min(16),
            Source::Constant(_) => 8,
        });
        bits.max().unwrap_or(8)
    }

    /// The role of a channel, as the material's maps have it.
    pub fn role(&self, material: &Material, channel: usize) -> Option<Role> {
        match self.channels[channel].1 {
            Source::Channel { map, channel, inverted } => Some(match material.maps[map].roles[channel] {
                Role::Roughness if inverted => Role::Smoothness,
                Role::Smoothness if inverted => Role::Roughness,
                role => role,
            }),
            Source::NormalZ { .. } => Some(Role::NormalZ),
            Source::Constant(_) => None,
        }
    }

    /// What a channel holds, in a manifest's words.
    pub fn role_name(&self, material: &Material, channel: usize) -> &'static str {
        match (self.channels[channel].1, self.role(material, channel)) {
            (Source::Channel { map, channel, .. }, _) if material.occlusion == Some((map, channel)) => "occlusion",
            (Source::Channel { map, channel, .. }, _) if material.metal == Some((map, channel)) => "metalness",
            (_, Some(role)) => role_name(role),
            (_, None) => "constant",
        }
    }

    /// One word for a map of an engine: "packed" where the roughness shares it.
    pub fn describe(&self, material: &Material) -> &'static str {
        let roles = (0..self.channels.len()).map(|c| (self.role_name(material, c), self.role(material, c)));
        let mut shared = false;
        let mut kind = "roughness";
        for (name, role) in roles {
            shared |= matches!(name, "occlusion" | "metalness" | "constant");
            kind = match role {
                Some(Role::NormalX) => return "normal",
                Some(Role::AnisotropyX) => return "anisotropy",
                Some(Role::Smoothness) => "smoothness",
                _ => kind,
            };
        }
        if shared { "packed" } else { kind }
    }

    /// The first channel of a role.
    pub fn channel(&self, material: &Material, role: Role) -> Option<usize> {
        (0..self.channels.len()).find(|i| self.role(material, *i) == Some(role))
    }

    /// Part of row `y` of a channel at a level, from column `x` on.
    pub fn row(&self, view: &LevelView, channel: usize, encoding: Encoding, y: usize, x: usize, out: &mut [f32]) {
        match self.channels[channel].1 {
            Source::Constant(value) => out.fill(value),
            Source::NormalZ { map } => {
                let mut nx = vec![0.0; out.len()];
                for (role, row) in [(Role::NormalX, &mut nx[..]), (Role::NormalY, &mut *out)] {
                    let channel = view.material.maps[map].channel(role).expect("a normal map");
                    view.row(map, channel, Encoding::Signed, y, x, row);
                }
                let (scale, offset) = if encoding == Encoding::Signed { (1.0, 0.0) } else { (0.5, 0.5) };
                for (z, nx) in out.iter_mut().zip(nx) {
                    *z = offset + scale * (1.0 - nx * nx - *z * *z).max(0.0).sqrt();
                }
            }
            Source::Channel { map, channel, inverted } => {
                view.row(map, channel, encoding, y, x, out);
                if inverted {
                    let normal = view.material.maps[map].roles[channel] == Role::NormalY;
                    let sum = if normal && encoding == Encoding::Signed { 0.0 } else { 1.0 };
                    out.iter_mut().for_each(|v| *v = sum - *v);
                }
            }
        }
    }
}

/// Whether a channel is an alpha that says nothing: no role, and 1 everywhere.
pub fn is_opaque(material: &Material, map: usize, channel: usize) -> bool {
    let file = &material.maps[map];
    if file.raster.channels[channel] != "A" || !matches!(file.roles[channel], Role::Other(_)) {
        return false;
    }
    let Size { width, height } = file.raster.size();
    let mut row = vec![0.0; width];
    (0..height).all(|y| {
        file.raster.read(channel, y, 0, &mut row);
        row.iter().all(|v| *v == 1.0)
    })
}

/// A material's maps as an engine packs them: normals with their green its way, and the roughness in its packed map.
/// A map that has that form already stays what it is.
pub fn arrange(material: &Material, preset: &Preset) -> Vec<Sheet> {
    let prefix = safe_name(&material.name);
    let normal = |file: &MapFile| file.channel(Role::NormalX).is_some();
    let width = |file: &MapFile| file.channel(Role::Roughness).or(file.channel(Role::Smoothness));
    let mut sheets: Vec<Sheet> = Vec::new();
    for (map, file) in material.maps.iter().enumerate() {
        if normal(file) {
            sheets.push(normal_sheet(material, map, preset, &prefix));
        } else if file.channel(Role::AnisotropyX).is_some() || preset.packed.is_none() && width(file).is_some() {
            sheets.push(Sheet::own(material, map));
        }
    }
    let rough = material.maps.iter().enumerate().find_map(|(map, file)| Some((map, width(file)?)));
    if let (Some(slots), Some((map, channel))) = (preset.packed, rough) {
        let smooth = material.maps[map].roles[channel] == Role::Smoothness;
        let plain = |channel: Option<(usize, usize)>, missing: f32| match channel {
            Some((map, channel)) => Source::Channel { map, channel, inverted: false },
            None => Source::Constant(missing),
        };
        let source = |slot: &Slot| match slot {
            Slot::Roughness => Source::Channel { map, channel, inverted: smooth },
            Slot::Smoothness => Source::Channel { map, channel, inverted: !smooth },
            Slot::Occlusion => plain(material.occlusion, 1.0),
            Slot::Metal => plain(material.metal, preset.without_metal),
            Slot::Zero => Source::Constant(0.0),
            Slot::One => Source::Constant(1.0),
        };
        let sources: Vec<_> = slots.iter().map(source).collect();
        let own = Sheet::own(material, map);
        let as_it_is = own.channels.iter().map(|(_, source)| *source).eq(sources.iter().copied());
        let stem = format!("{prefix}_{}", preset.packed_suffix);
        sheets.push(if as_it_is { own } else { Sheet::arranged(stem, &sources) });
    }
    for i in 1..sheets.len() {
        let taken = |stem: &str| sheets[..i].iter().any(|other| other.stem.eq_ignore_ascii_case(stem));
        let stem = sheets[i].stem.clone();
        let mut names = (1..).map(|n| if n == 1 { stem.clone() } else { format!("{stem}_{n}") });
        sheets[i].stem = names.find(|name| !taken(name)).expect("some number is free");
    }
    sheets
}

/// Channels of the material's maps that no sheet shows, in words: a map and the colours that are left out of it.
pub fn left_out(material: &Material, sheets: &[Sheet]) -> Vec<String> {
    let shown = |map: usize, channel: usize| {
        sheets.iter().flat_map(|sheet| &sheet.channels).any(
            |(_, source)| matches!(source, Source::Channel { map: m, channel: c, .. } if (*m, *c) == (map, channel)),
        )
    };
    let maps = material.maps.iter().enumerate().filter(|(_, file)| matches!(file.origin, Origin::File { .. }));
    let words = maps.filter_map(|(map, file)| {
        // Gray stored as colour is the same three times.
        let lost = |c: &usize| {
            !shown(map, *c) && matches!(file.roles[*c], Role::Other(_)) && !is_opaque(material, map, *c)
        };
        let lost: Vec<_> = (0..file.roles.len()).filter(lost).map(colour).collect();
        (!lost.is_empty()).then(|| {
            format!("{}: {} left out, for the preset's maps have no place for it; --occlusion and --metal name what is packed",
                file.stem, lost.join(" and "))
        })
    });
    words.collect()
}

fn normal_sheet(material: &Material, map: usize, preset: &Preset, prefix: &str) -> Sheet {
    let file = &material.maps[map];
    let flipped = material.normal_y != preset.normal_y;
    let own = Sheet::own(material, map);
    let source = |channel: usize| Source::Channel { map, channel, inverted: false };
    let mut sources = Vec::new();
    let normal = |role| file.channel(role).expect("a normal map");
    sources.push(source(normal(Role::NormalX)));
    sources.push(Source::Channel { map, channel: normal(Role::NormalY), inverted: flipped });
    match file.channel(Role::NormalZ) {
        Some(z) => sources.push(source(z)),
        None if preset.normal_z || file.roles.len() > 2 => sources.push(Source::NormalZ { map }),
        None => {}
    }
    // One more channel, which is not packed elsewhere, has room in alpha.
    let kept = |role: &Role| match role {
        Role::Roughness | Role::Smoothness => preset.packed.is_none(),
        Role::Other(_) => true,
        _ => false,
    };
    let packed =
        |channel| preset.packed.is_some() && [material.occlusion, material.metal].contains(&Some((map, channel)));
    let alpha = (0..file.roles.len()).find(|c| kept(&file.roles[*c]) && !packed(*c) && !is_opaque(material, map, *c));
    sources.extend(alpha.map(source));
    if own.channels.iter().map(|(_, source)| *source).eq(sources.iter().copied()) {
        return own;
    }
    // Its own name may say which way its green points.
    let way = if preset.normal_y == NormalY::OpenGl { "gl" } else { "dx" };
    let named = flipped || sources.len() < own.channels.len();
    let stem = match (flipped, named) {
        (true, _) => format!("{prefix}_normal_{way}"),
        (false, true) => format!("{prefix}_normal"),
        (false, false) => own.stem,
    };
    Sheet::arranged(stem, &sources)
}
