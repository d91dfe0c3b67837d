//! What a build will write, decided before anything is decoded to the end or folded.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::may_build;
use crate::codec::Depth;
use crate::error::{Error, Result};
use crate::fold::Options;
use crate::material::{Extra, FurtherMap, MapFile, Material, Origin, same_path};

/// A container.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// One file a level, in the input's packing and depth.
    Png,
    /// One mip-mapped file a map, signed normals; and the lobes in full.
    Exr,
}

/// What to write, and where.
#[derive(Clone)]
pub struct Request {
    /// Folder of the material's files.
    pub folder: PathBuf,
    /// Containers.
    pub formats: Vec<Format>,
    /// Depth of the mip-mapped maps; lobes and moments are always 32 bit.
    pub depth: Depth,
    /// Whether to write the raw slope moments.
    pub moments: bool,
    /// Further maps, in each container.
    pub extras: Vec<Extra>,
    /// Names of PNG pictures for people, which whoever writes brings along; see [`super::write_with`].
    pub pictures: Vec<String>,
    /// Whether files that mipfold did not write may be replaced.
    pub force: bool,
}

/// One file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Name inside the folder.
    pub name: String,
    /// What it holds.
    pub content: Content,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A level of a map.
    Level {
        /// Index of the map.
        map: usize,
        /// 0 is the input.
        level: usize,
    },
    /// All levels of a map.
    Levels {
        /// Index of the map.
        map: usize,
    },
    /// A level of a map of a further lobe.
    FurtherLevel {
        /// The map.
        map: FurtherMap,
        /// 0 is the input.
        level: usize,
    },
    /// All levels of a map of a further lobe.
    FurtherLevels {
        /// The map.
        map: FurtherMap,
    },
    /// Normal, widths and angle of every texel, of every lobe.
    Lobes,
    /// LEAN moments in the order of OpenImageIO's bumpslopes.
    Moments,
    /// A level of an extra map.
    ExtraLevel {
        /// Which.
        extra: Extra,
        /// 0 is that of the input.
        level: usize,
    },
    /// All levels of an extra map.
    ExtraLevels {
        /// Which.
        extra: Extra,
    },
    /// A picture for people.
    Picture {
        /// Index in [`Request::pictures`].
        index: usize,
    },
}

/// All files of a material, level 0 of the largest maps first.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The files, without the manifest.
    pub outputs: Vec<Output>,
}

impl Plan {
    /// Decides the files of a material that is folded with `options`.
    pub fn new(material: &Material, options: &Options, request: &Request) -> Self {
        let levels = material.size.level_count();
        let further = FurtherMap::all(options.form, options.lobes, options.shared_normal);
        let mut outputs = Vec::new();
        let mut push = |name: String, content| outputs.push(Output { name, content });
        // A map may be called like the lobes.
        let prefix = safe_name(&material.name);
        let free = |suffix: &str| {
            let mut names =
                (1..).map(|n| if n == 1 { format!("{prefix}_{suffix}") } else { format!("{prefix}_{suffix}_{n}") });
            let taken = |name: &String| material.maps.iter().any(|map| map.stem.eq_ignore_ascii_case(name));
            names.find(|name| !taken(name)).expect("some number is free")
        };
        for level in 0..levels {
            for (map, file) in material.maps.iter().enumerate() {
                if request.formats.contains(&Format::Png) {
                    push(png_name(&file.stem, level), Content::Level { map, level });
                }
            }
            for map in further.iter().copied().filter(|_| request.formats.contains(&Format::Png)) {
                push(png_name(&free(&map.suffix()), level), Content::FurtherLevel { map, level });
            }
        }
        if request.formats.contains(&Format::Exr) {
            for (map, file) in material.maps.iter().enumerate() {
                push(format!("{}.exr", file.stem), Content::Levels { map });
            }
            for map in further {
                push(free(&map.suffix()) + ".exr", Content::FurtherLevels { map });
            }
            push(free("lobes") + ".exr", Content::Lobes);
        }
        if request.moments {
            push(free("moments") + ".exr", Content::Moments);
        }
        for extra in Extra::ALL.into_iter().filter(|extra| request.extras.contains(extra)) {
            let stem = free(extra.name());
            if request.formats.contains(&Format::Png) {
                (0..levels).for_each(|level| push(png_name(&stem, level), Content::ExtraLevel { extra, level }));
            }
            if request.formats.contains(&Format::Exr) {
                push(format!("{stem}.exr"), Content::ExtraLevels { extra });
            }
        }
        for (index, name) in request.pictures.iter().enumerate() {
            push(name.clone(), Content::Picture { index });
        }
        Self { outputs }
    }

    /// Refuses to write over an input, or over files that no earlier build wrote.
    ///
    /// # Errors
    /// [`Error::Invalid`] that names the file.
    pub fn check(&self, material: &Material, request: &Request) -> Result<()> {
        for output in &self.outputs {
            let path = request.folder.join(&output.name);
            if reads(material, &path) {
                return Err(Error::invalid(&path, "an output that is also an input", "another folder for -o"));
            }
            if let Content::Level { map, .. } = output.content
                && material.maps[map].roles.len() > 4
            {
                let found = format!("{} channels", material.maps[map].roles.len());
                return Err(Error::unsupported(&path, found, "up to 4 in a PNG; --format exr holds more"));
            }
        }
        let names = self.outputs.iter().map(|output| output.name.as_str());
        may_build(&request.folder, &material.name, names, request.force)
    }
}

/// The name of a level of a map.
pub fn png_name(stem: &str, level: usize) -> String {
    format!("{stem}_mip{level}.png")
}

/// A name that every file system takes.
pub fn safe_name(name: &str) -> String {
    let safe: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    // Suffixes and endings come after it, and file systems end at 255 bytes.
    let safe: String = safe.chars().take(120).collect();
    if safe.trim_matches('.').is_empty() { "material".into() } else { safe }
}

/// Whether a file is an input of the material.
pub fn reads(material: &Material, file: &Path) -> bool {
    let input = |map: &MapFile| matches!(&map.origin, Origin::File { path, .. } if same_path(path, file));
    let flakes = material.flakes.iter().flat_map(|flakes| &flakes.about.files);
    material.maps.iter().any(input) || flakes.into_iter().any(|read| same_path(Path::new(&read.path), file))
}
