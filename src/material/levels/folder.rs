//! A chain from a folder that a build wrote, by its manifest.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::further::{FurtherLobe, mixed};
use super::{Files, LevelChain, MapLevels, Maps, read, read_lobes};
use crate::codec;
use crate::error::{Error, Result};
use crate::image::{Size, Wrap};
use crate::material::further::further_role;
use crate::material::{
    ChannelRef, Extra, GENERATOR, Inputs, MANIFEST, Material, MeshAbout, MeshUnder, NormalRange, NormalY, NormalZ,
    RoughnessInput, SCHEMA, load_with,
};
use crate::ndf::{Form, MOST_LOBES, lobes_in_words};
use crate::roughness::PerceptualRoughness;

/// A form in which a build writes a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// One PNG a level of each map.
    Png,
    /// One mip-mapped OpenEXR file of each map.
    Exr,
    /// One KTX 2 texture of each map.
    Ktx2,
    /// One DDS texture of each map.
    Dds,
    /// The lobes in full, 32 bit.
    Lobes,
}

impl Container {
    /// In the order in which they are looked for: what engines load first.
    const ALL: [Container; 5] = [Container::Png, Container::Ktx2, Container::Dds, Container::Exr, Container::Lobes];

    /// On the command line.
    pub fn name(self) -> &'static str {
        match self {
            Container::Png => "png",
            Container::Exr => "exr",
            Container::Ktx2 => "ktx2",
            Container::Dds => "dds",
            Container::Lobes => "lobes",
        }
    }

    /// The container of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|container| container.name() == name)
    }
}

#[derive(Deserialize)]
struct Channel {
    role: String,
}

#[derive(Deserialize)]
struct Map {
    role: String,
    container: String,
    files: Vec<String>,
    channels: Vec<Channel>,
    level_0: String,
}

impl Map {
    /// `None` for slope moments and extra maps, which are no chain of lobes.
    fn container(&self) -> Option<Container> {
        match self.role.as_str() {
            "lobes" => Some(Container::Lobes),
            "slope-moments" => None,
            extra if Extra::by_name(extra).is_some() => None,
            _ => Container::by_name(&self.container),
        }
    }

    fn channel(&self, role: &str) -> Option<usize> {
        self.channels.iter().position(|channel| channel.role == role)
    }
}

#[derive(Deserialize)]
struct Manifest {
    material: String,
    size: Size,
    fold: String,
    lobes: Form,
    // Earlier versions knew no mixtures.
    #[serde(default = "one")]
    count: usize,
    #[serde(default)]
    shared_normal: bool,
    strength: f32,
    normal_y: NormalY,
    // Manifests of earlier versions do not say.
    #[serde(default)]
    normal_z: NormalZ,
    normal_scale: f32,
    wrap: Wrap,
    constant_roughness: Option<f32>,
    #[serde(default)]
    mesh: Option<MeshAbout>,
    maps: Vec<Map>,
}

fn one() -> usize {
    1
}

/// Reads the chain of a folder that a build wrote: its PNGs if there are any, else its KTX 2 or DDS textures as hardware
/// decodes them, else its mip-mapped OpenEXR maps, else its lobes; or the container that is asked for. Conventions come from the manifest. Where the build had one number for
/// the roughness, `level_0` has it as it was given, not as a PNG rounds it.
///
/// # Errors
/// No manifest of a build, or one of another form; a container that was not built; files that are gone or have changed
/// their size; and those of the files.
pub fn read_folder(folder: &Path, container: Option<Container>) -> Result<LevelChain> {
    let manifest = manifest(folder)?;
    let built = Built { folder, path: folder.join(MANIFEST), manifest };
    let there: Vec<Container> = Container::ALL.into_iter().filter(|c| built.has(*c)).collect();
    let names = |list: &[Container]| list.iter().map(|c| c.name()).collect::<Vec<_>>().join(", ");
    let container = match container {
        None => there.first().copied(),
        Some(wanted) => there.iter().copied().find(|c| *c == wanted),
    };
    let Some(container) = container else {
        let expected = if there.is_empty() { "maps of a chain".into() } else { format!("one of {}", names(&there)) };
        return Err(Error::invalid(&built.path, "no chain in the container that is asked for", expected));
    };
    let mut chain = match container {
        Container::Lobes => {
            let mut chain = read_lobes(&built.lobes_file()?)?;
            if let Some(maps) = there.iter().find(|c| **c != Container::Lobes) {
                chain.level_0 = built.level_0(*maps)?;
            }
            chain
        }
        container => {
            let (inputs, maps) = (built.inputs(container)?, built.maps(container)?);
            let mut chain = read(&inputs, &maps)?;
            let further = built.further(container, &inputs)?;
            if !further.is_empty() {
                chain.levels = mixed(chain.levels, &further, &maps)?;
            }
            chain
        }
    };
    let found = chain.levels[0].size();
    let size = built.manifest.size;
    if found != size {
        return Err(Error::invalid(
            folder,
            format!("files of {found} texels"),
            format!("{size}, as its {MANIFEST} says"),
        ));
    }
    built.as_given(&mut chain.level_0);
    // Those of reading name options that do not hold here.
    chain.level_0.notes = vec![format!("normals are {}, as the manifest says", built.manifest.normal_y.describe())];
    if let Some(about) = built.manifest.mesh.clone() {
        let warning =
            format!("the curvature of {} is in this chain, but not in its level 0: it is not judged", about.path);
        chain.level_0.warnings.push(warning);
        chain.level_0.mesh = Some(MeshUnder { about, added: Vec::new() });
    }
    (chain.fold, chain.container) = (Some(built.fold()), Some(container));
    Ok(chain)
}

/// Reads and checks the manifest.
fn manifest(folder: &Path) -> Result<Manifest> {
    let path = folder.join(MANIFEST);
    if !path.is_file() {
        let below = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
        let mut below: Vec<PathBuf> =
            below.filter_map(|entry| Some(entry.ok()?.path())).filter(|sub| sub.join(MANIFEST).is_file()).collect();
        below.sort();
        let expected = if below.is_empty() {
            "a folder that `mipfold build` wrote; other chains are given as normal=FILE_%d.png,roughness=FILE_%d.png"
                .to_owned()
        } else {
            let names: Vec<_> = below.iter().map(|sub| sub.display().to_string()).collect();
            format!("the folder of one material: {}", names.join(", "))
        };
        return Err(Error::invalid(folder, format!("no {MANIFEST}"), expected));
    }
    let text = std::fs::read(&path).map_err(|e| Error::io(&path, e))?;
    let damaged = |e: serde_json::Error| Error::invalid(&path, format!("a damaged manifest ({e})"), "one of a build");
    let value: serde_json::Value = serde_json::from_slice(&text).map_err(damaged)?;
    if value["generator"] != GENERATOR {
        return Err(Error::invalid(&path, "a manifest of another program", "one that `mipfold build` wrote"));
    }
    if value["schema"] != SCHEMA {
        return Err(Error::unsupported(&path, format!("schema {}", value["schema"]), SCHEMA.to_string()));
    }
    serde_json::from_value(value).map_err(damaged)
}

struct Built<'a> {
    folder: &'a Path,
    path: PathBuf,
    manifest: Manifest,
}

impl Built<'_> {
    fn has(&self, container: Container) -> bool {
        self.manifest.maps.iter().any(|map| map.container() == Some(container))
    }

    fn maps_in(&self, container: Container) -> impl Iterator<Item = &Map> {
        self.manifest.maps.iter().filter(move |map| map.container() == Some(container))
    }

    /// Paths of a map's files, all of them there.
    fn files(&self, map: &Map) -> Result<Vec<PathBuf>> {
        let mut paths = Vec::new();
        for name in &map.files {
            // The manifest may have been edited: names must not leave the folder.
            let plain = Path::new(name).components().count() == 1 && Path::new(name).file_name().is_some();
            let path = self.folder.join(name);
            if !plain || !path.is_file() {
                let found = format!("{name} is not there");
                return Err(Error::invalid(&self.path, found, "every file that the manifest lists, in its folder"));
            }
            paths.push(path);
        }
        if paths.is_empty() {
            return Err(Error::invalid(&self.path, format!("a {} map without files", map.role), "its files"));
        }
        Ok(paths)
    }

    fn lobes_file(&self) -> Result<PathBuf> {
        let map = self.maps_in(Container::Lobes).next().expect("asked only where there is one");
        Ok(self.files(map)?.swap_remove(0))
    }

    /// The maps of a chain, each called by its first file.
    fn maps(&self, container: Container) -> Result<Maps> {
        let mut maps = Vec::new();
        for map in self.maps_in(container) {
            let files = self.files(map)?;
            let key = files[0].clone();
            let files = match container {
                Container::Png => Files::Each(files),
                _ => Files::One(codec::read_levels(&key)?),
            };
            maps.push(MapLevels { key, files });
        }
        Ok(Maps(maps))
    }

    /// How to read the maps of a container.
    fn inputs(&self, container: Container) -> Result<Inputs> {
        let manifest = &self.manifest;
        let mut inputs = Inputs {
            name: manifest.material.clone(),
            normal_y: manifest.normal_y,
            normal_z: manifest.normal_z,
            normal_range: if container == Container::Exr { NormalRange::Signed } else { NormalRange::Unsigned },
            normal_scale: Some(manifest.normal_scale),
            wrap: manifest.wrap,
            ..Inputs::default()
        };
        for map in self.maps_in(container) {
            let path = self.files(map)?.swap_remove(0);
            if map.channel("normal.x").is_some() {
                inputs.normal = Some(path.clone());
                if map.channel("normal.z").is_none() {
                    inputs.normal_z = NormalZ::Rebuild;
                }
            }
            if map.channel("anisotropy.direction.x").is_some() {
                inputs.anisotropy = Some(path.clone());
            }
            for (role, smooth) in [("perceptual-roughness", false), ("smoothness", true)] {
                let Some(first) = map.channel(role) else { continue };
                // Gray stored as colour is read from green, as by a build.
                let green = map.channels.get(1).is_some_and(|channel| channel.role == role);
                let channel = Some(if green { 1 } else { first });
                let file = ChannelRef { path: path.clone(), channel };
                inputs.roughness =
                    if smooth { RoughnessInput::Smoothness(file) } else { RoughnessInput::Roughness(file) };
            }
        }
        if inputs.roughness == RoughnessInput::Missing {
            let found = format!("no roughness channel in its {} maps", container.name());
            return Err(Error::invalid(&self.path, found, "a channel of role perceptual-roughness or smoothness"));
        }
        Ok(inputs)
    }

    /// The lobes after the first, whose maps are read as `first` ones are.
    fn further(&self, container: Container, first: &Inputs) -> Result<Vec<FurtherLobe>> {
        let count = self.manifest.count;
        if !(1..=MOST_LOBES).contains(&count) {
            return Err(Error::invalid(&self.path, format!("{count} lobes"), format!("1 to {MOST_LOBES}")));
        }
        let find = |role: String| -> Result<ChannelRef> {
            let map = self.maps_in(container).find(|map| map.channel(&role).is_some()).ok_or_else(|| {
                let found = format!("no channel {role} in its {} maps", container.name());
                Error::invalid(&self.path, found, format!("the maps of {count} lobes"))
            })?;
            Ok(ChannelRef { path: self.files(map)?.swap_remove(0), channel: map.channel(&role) })
        };
        let lobe = |j: usize| -> Result<FurtherLobe> {
            let role = |name: &str| find(further_role(j, name));
            let mut inputs =
                Inputs { roughness: RoughnessInput::Roughness(role("perceptual-roughness")?), ..first.clone() };
            if !self.manifest.shared_normal {
                inputs.normal = Some(role("normal.x")?.path);
                inputs.normal_z = NormalZ::Rebuild;
            }
            if self.manifest.lobes == Form::Anisotropic {
                inputs.anisotropy = Some(role("anisotropy.direction.x")?.path);
            }
            Ok(FurtherLobe { inputs, weight: role("weight")? })
        };
        (1..count).map(lobe).collect()
    }

    /// Level 0 alone.
    fn level_0(&self, container: Container) -> Result<Material> {
        let maps = self.maps(container)?;
        load_with(&maps.inputs(&self.inputs(container)?, 0), &|path| maps.picture(path, 0))
    }

    /// Without what the build added to its inputs: a number where that was the roughness, and no anisotropy where there
    /// was none.
    fn as_given(&self, level_0: &mut Material) {
        if let Some(r) = self.manifest.constant_roughness {
            (level_0.width, level_0.constant) = (None, PerceptualRoughness(r));
        }
        let added = |map: &Map| map.channel("anisotropy.direction.x").is_some() && map.level_0 == "generated";
        if self.manifest.maps.iter().any(added) {
            level_0.anisotropy = None;
        }
    }

    /// The fold in words.
    fn fold(&self) -> String {
        let Manifest { fold, lobes, count, shared_normal, strength, .. } = &self.manifest;
        let strength = if *strength == 1.0 { String::new() } else { format!(", strength {strength}") };
        format!("{fold}{}{strength}", lobes_in_words(*lobes, *count, *shared_normal))
    }
}
