//! Mip chains back from files, as the lobes that a renderer shades. Every convention is read as [`super::load`] reads
//! it: a level is loaded like a material of its own, with what level 0 has settled.

mod folder;
mod further;
mod lobes_file;

pub use folder::{Container, read_folder};
pub use lobes_file::{LOBE_CHANNELS, lobe_channels, read_lobes};

use std::path::{Path, PathBuf};

use super::load::load_level;
use super::source::Origin;
use super::{ChannelRef, Inputs, Material, NormalRange, RoughnessInput, Texels, base_lobes, load_with};
use crate::codec::{self, Decoded};
use crate::error::{Error, Result};
use crate::image::Size;
use crate::ndf::{Form, Lobes};

/// A mip chain that was read.
#[derive(Clone, Debug)]
pub struct LevelChain {
    /// Level 0 first; sizes as [`Size::level`]. May stop before 1x1.
    pub levels: Vec<Lobes>,
    /// The surface as the chain's own level 0 has it, with the notes and warnings of reading.
    pub level_0: Material,
    /// How it was folded, if the files say.
    pub fold: Option<String>,
    /// Which of the containers of a build's folder was read.
    pub container: Option<Container>,
}

/// What level 0 of a mixture must have, for it is a surface to judge against.
const ONE_LOBE_AT_LEVEL_0: &str = "one lobe at level 0: weight 0 for all others";

/// The most levels that are looked for: the longest side that a picture may have is 2^30.
const MOST_LEVELS: usize = 31;

/// Reads a chain from maps in files. Paths of `inputs` with `%d` in them (or `%02d`, ...) stand for one file a level,
/// from 0 on; other paths are mip-mapped OpenEXR files. The roughness may be a number. There must be no gap, all maps
/// must have the same levels, and their sizes must be those of [`Size::level`].
///
/// # Errors
/// As [`load_with`]; levels that are missing or have the wrong size; pictures that are no chain; a roughness that is not
/// given.
pub fn read_maps(inputs: &Inputs) -> Result<LevelChain> {
    if inputs.roughness == RoughnessInput::Missing {
        let expected = "roughness=FILE or smoothness=FILE, for a renderer needs one; or roughness=NUMBER";
        return Err(Error::invalid_option(&inputs.name, "a chain without roughness", expected));
    }
    if let Some(height) = &inputs.height {
        return Err(Error::unsupported(height, "a chain of height maps", "normal maps"));
    }
    let mut maps = Vec::new();
    for path in paths(inputs) {
        maps.push(MapLevels { key: path.to_owned(), files: Files::find(path)? });
    }
    read(inputs, &Maps(maps))
}

/// The files of the maps.
fn paths(inputs: &Inputs) -> Vec<&Path> {
    let mut paths: Vec<&Path> = Vec::new();
    for path in [inputs.normal.as_deref(), inputs.roughness.file(), inputs.anisotropy.as_deref()].into_iter().flatten()
    {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
    paths
}

/// Where the levels of a map are.
enum Files {
    /// One file a level.
    Each(Vec<PathBuf>),
    /// All in one file, decoded.
    One(Vec<Decoded>),
}

impl Files {
    /// By a pattern, or in one mip-mapped file.
    fn find(path: &Path) -> Result<Self> {
        let Some(file) = pattern(path) else {
            if !path.is_file() && path.to_string_lossy().contains('%') {
                let expected = "%d for the level, or %02d with leading zeros (%% for a percent sign beside it)";
                return Err(Error::invalid(path, "no such file, and a % that stands for no level", expected));
            }
            let pictures = codec::read_levels(path)?;
            let size = pictures[0].raster.size();
            if pictures.len() == 1 && size.level_count() > 1 {
                let found = format!("one {} picture of {size}, without further levels", pictures[0].format);
                let expected = "a pattern with %d for one file a level, as wall_%d.png, or a file with mips: OpenEXR, KTX 2 or DDS";
                return Err(Error::invalid(path, found, expected));
            }
            return Ok(Files::One(pictures));
        };
        let there: Vec<bool> = (0..MOST_LEVELS).map(|k| file(k).is_file()).collect();
        let Some(last) = there.iter().rposition(|there| *there) else {
            return Err(Error::invalid(path, format!("no file {}", file(0).display()), "one file a level, from 0 on"));
        };
        if let Some(missing) = there[..last].iter().position(|there| !there) {
            let found = format!("no such file, though there is a level {last}");
            return Err(Error::invalid(&file(missing), found, "a file for every level from 0 on"));
        }
        Ok(Files::Each((0..=last).map(file).collect()))
    }

    fn len(&self) -> usize {
        match self {
            Files::Each(files) => files.len(),
            Files::One(pictures) => pictures.len(),
        }
    }
}

/// The file of a level, if a path is a pattern: `%d`, or `%02d` with leading zeros. The last one counts, and beside it
/// `%%` is a percent sign.
fn pattern(path: &Path) -> Option<impl Fn(usize) -> PathBuf + use<>> {
    let text = path.to_str()?;
    let (mut place, mut from) = (None, 0);
    while let Some(at) = text[from..].find('%').map(|at| from + at) {
        let rest = &text[at + 1..];
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let number = digits == 0 || (digits <= 3 && rest.starts_with('0'));
        from = at + 1;
        if rest.starts_with('%') {
            from += 1;
        } else if number && rest[digits..].starts_with('d') {
            place = Some((at, digits));
        }
    }
    let (at, digits) = place?;
    let width: usize = text[at + 1..at + 1 + digits].parse().unwrap_or(0);
    let (head, tail) = (text[..at].replace("%%", "%"), text[at + digits + 2..].replace("%%", "%"));
    Some(move |k: usize| PathBuf::from(format!("{head}{k:0width$}{tail}")))
}

/// All levels of one map.
struct MapLevels {
    /// As the inputs call it.
    key: PathBuf,
    files: Files,
}

/// The maps of a chain.
struct Maps(Vec<MapLevels>);

impl Maps {
    /// The number of levels, which all maps share.
    fn count(&self) -> Result<usize> {
        let most = self.0.iter().max_by_key(|map| map.files.len());
        let Some(most) = most else { return Ok(0) };
        let count = most.files.len();
        match self.0.iter().find(|map| map.files.len() < count) {
            None => Ok(count),
            Some(short) => {
                let found = format!("{} levels", short.files.len());
                let expected = format!("{count} levels, as {} has", most.key.display());
                Err(Error::invalid(&short.key, found, expected))
            }
        }
    }

    /// The file of a level of a map, as [`Maps::picture`] takes it.
    fn file(&self, path: &Path, level: usize) -> PathBuf {
        match self.0.iter().find(|map| map.key == path).map(|map| &map.files) {
            Some(Files::Each(files)) => files[level].clone(),
            _ => path.to_owned(),
        }
    }

    /// The inputs of a level.
    fn inputs(&self, inputs: &Inputs, level: usize) -> Inputs {
        let file = |path: &Path| self.file(path, level);
        let channel = |c: &ChannelRef| ChannelRef { path: file(&c.path), channel: c.channel };
        Inputs {
            normal: inputs.normal.as_deref().map(file),
            roughness: match &inputs.roughness {
                RoughnessInput::Roughness(c) => RoughnessInput::Roughness(channel(c)),
                RoughnessInput::Smoothness(c) => RoughnessInput::Smoothness(channel(c)),
                other => other.clone(),
            },
            anisotropy: inputs.anisotropy.as_deref().map(file),
            ..inputs.clone()
        }
    }

    /// The picture of a file that [`Maps::file`] named for a level.
    fn picture(&self, path: &Path, level: usize) -> Result<Decoded> {
        for map in &self.0 {
            if let Files::One(pictures) = &map.files
                && map.key == path
            {
                return Ok(pictures[level].clone());
            }
        }
        codec::read(path)
    }
}

/// Reads all levels. What level 0 settles by its values (the range of float normals, where z is) holds for the others.
fn read(inputs: &Inputs, maps: &Maps) -> Result<LevelChain> {
    let count = maps.count()?;
    if count == 0 {
        let expected = "a normal map or a roughness map with %d for the level, or a mip-mapped OpenEXR file";
        return Err(Error::invalid_option(&inputs.name, "a chain without maps", expected));
    }
    let level_0 = load_with(&maps.inputs(inputs, 0), &|path| maps.picture(path, 0))?;
    let size = level_0.size;
    for map in &level_0.maps {
        if let Origin::File { path, size: own, .. } = &map.origin {
            right_size(path, *own, size, 0)?;
        }
    }
    if count > size.level_count() {
        let key = &maps.0[0].key;
        return Err(Error::invalid(
            key,
            format!("{count} levels"),
            format!("{} at most for {size}", size.level_count()),
        ));
    }
    let settled = settle(inputs, &level_0);
    let form = if level_0.is_anisotropic() { Form::Anisotropic } else { Form::Isotropic };
    let mut levels = vec![base_lobes(&level_0, form)];
    for k in 1..count {
        let material = load_level(&maps.inputs(&settled, k), &|path| {
            let picture = maps.picture(path, k)?;
            right_size(path, picture.raster.size(), size, k)?;
            Ok(picture)
        })?;
        levels.push(base_lobes(&material, form));
    }
    Ok(LevelChain { levels, level_0, fold: None, container: None })
}

/// The inputs with what level 0 has settled.
fn settle(inputs: &Inputs, level_0: &Material) -> Inputs {
    let signed = level_0.normal.as_ref().is_some_and(|source| level_0.maps[source.map].signed);
    Inputs {
        normal_range: if signed { NormalRange::Signed } else { NormalRange::Unsigned },
        normal_z: level_0.normal_z(),
        ..inputs.clone()
    }
}

fn right_size(path: &Path, found: Size, base: Size, level: usize) -> Result<()> {
    let expected = base.level(level);
    if found == expected {
        return Ok(());
    }
    let found = format!("{found} texels in level {level}");
    let expected = if level == 0 {
        format!("{expected}, as the largest map of the chain has")
    } else {
        format!("{expected}, since level 0 is {base} and sides halve and round down")
    };
    Err(Error::invalid(path, found, expected))
}

#[cfg(test)]
mod tests;
