//! What a build will write, decided before anything is decoded to the end or folded.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::layer::{Layer, Rows};
use super::manifest::layer_role;
use super::may_build;
use super::preset::{Aside, Compress, Preset, Written, WrittenMap};
use super::sheet::Sheet;
use super::texture::texel_format;
use crate::codec::Depth;
use crate::codec::texture::{Effort, TexelFormat};
use crate::error::{Error, Result};
use crate::fold::{Chain, Options};
use crate::image::{Sides, Size};
use crate::material::{ChannelRef, Extra, FurtherMap, Inputs, MapFile, Material, NormalY, Origin, same_path};

/// A container.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// One file a level, in the input's packing and depth.
    Png,
    /// One mip-mapped file a map, signed normals; and the lobes in full.
    Exr,
    /// One texture a map, with its levels, for GPUs.
    Ktx2,
    /// The same in DirectX's container.
    Dds,
}

impl Format {
    /// Of its files' names, and in options.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Exr => "exr",
            Format::Ktx2 => "ktx2",
            Format::Dds => "dds",
        }
    }

    /// Whether its files are textures for GPUs.
    pub fn is_texture(self) -> bool {
        matches!(self, Format::Ktx2 | Format::Dds)
    }
}

/// What to write, and where.
#[derive(Clone)]
pub struct Request {
    /// Folder of the material's files.
    pub folder: PathBuf,
    /// Containers.
    pub formats: Vec<Format>,
    /// Depth of the mip-mapped OpenEXR maps; lobes and moments are always 32 bit.
    pub depth: Depth,
    /// What the maps' sides are brought to.
    pub resize: Sides,
    /// How texels of KTX 2 and DDS are compressed.
    pub compress: Compress,
    /// How much time that may take.
    pub effort: Effort,
    /// Whether DDS has the header of DirectX 9, and 8 bit RGBA under it.
    pub dds9: bool,
    /// The engine that reads the files, if one was named: it decides on packing and on the green of normals.
    pub preset: Option<&'static Preset>,
    /// Whether to write the raw slope moments.
    pub moments: bool,
    /// Further maps, in each container.
    pub extras: Vec<Extra>,
    /// Names of PNG pictures for people, which whoever writes brings along; see [`super::write_with`].
    pub pictures: Vec<String>,
    /// Whether files that mipfold did not write may be replaced.
    pub force: bool,
    /// All that the build is made of as one number, by which a later one knows that nothing has changed: see
    /// [`super::key`].
    pub key: Option<String>,
}

impl Request {
    /// PNGs of the material's own maps.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            formats: vec![Format::Png],
            depth: Depth::Half,
            resize: Sides::Any,
            compress: Compress::default(),
            effort: Effort::default(),
            dds9: false,
            preset: None,
            moments: false,
            extras: Vec::new(),
            pictures: Vec::new(),
            force: false,
            key: None,
        }
    }

    /// What is read for it: occlusion and metal of their own only where they are packed.
    pub fn inputs(&self, inputs: &Inputs) -> Inputs {
        let rough = inputs.roughness.file();
        let packs = self.preset.is_some_and(|preset| preset.packed.is_some());
        let plain = |channel: &Option<ChannelRef>| channel.clone().filter(|c| packs || Some(c.path.as_path()) == rough);
        let (occlusion, metal) = (plain(&inputs.occlusion), plain(&inputs.metal));
        Inputs { occlusion, metal, sides: self.resize, ..inputs.clone() }
    }

    /// Which way green points in the normal maps that are written.
    pub fn normal_y(&self, material: &Material) -> NormalY {
        self.preset.map_or(material.normal_y, |preset| preset.normal_y)
    }

    /// The texel format of a map in a container for GPUs.
    pub fn texels(&self, rows: &Rows, format: Format) -> TexelFormat {
        if self.dds9 && format == Format::Dds {
            return TexelFormat::Rgba8;
        }
        texel_format(rows, self.compress, self.two_channel_normals())
    }

    /// Whether normals lose their z to block compression that has two channels.
    pub fn two_channel_normals(&self) -> bool {
        self.preset.is_none_or(|preset| !preset.normal_z)
    }
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
    /// A level of a map, as PNG.
    Level {
        /// The map.
        layer: Layer,
        /// 0 is the input.
        level: usize,
    },
    /// All levels of a map.
    Levels {
        /// The map.
        layer: Layer,
        /// In which container.
        format: Format,
    },
    /// Normal, widths and angle of every texel, of every lobe.
    Lobes,
    /// LEAN moments in the order of OpenImageIO's bumpslopes.
    Moments,
    /// A picture for people.
    Picture {
        /// Index in [`Request::pictures`].
        index: usize,
    },
    /// A text beside the maps, for people or for the engine.
    Aside {
        /// Index in [`Plan::asides`].
        index: usize,
    },
}

/// All files of a material, level 0 of the largest maps first.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The material's maps as they are written.
    pub sheets: Vec<Sheet>,
    /// The files, without the manifest.
    pub outputs: Vec<Output>,
    /// Texts that the preset wants beside them.
    pub asides: Vec<Aside>,
    /// What of the material is not in them.
    pub warnings: Vec<String>,
}

impl Plan {
    /// Decides the files of a material that is folded with `options`.
    pub fn new(material: &Material, options: &Options, request: &Request) -> Self {
        let levels = material.size.level_count();
        let sheets = sheets(material, request);
        let further = FurtherMap::all(options.form, options.lobes, options.shared_normal);
        let mut outputs = Vec::new();
        let mut push = |name: String, content| outputs.push(Output { name, content });
        // A map may be called like the lobes.
        let prefix = safe_name(&material.name);
        let free = |suffix: &str| {
            let mut names =
                (1..).map(|n| if n == 1 { format!("{prefix}_{suffix}") } else { format!("{prefix}_{suffix}_{n}") });
            let taken = |name: &String| sheets.iter().any(|sheet| sheet.stem.eq_ignore_ascii_case(name));
            names.find(|name| !taken(name)).expect("some number is free")
        };
        let own = sheets.iter().enumerate().map(|(i, sheet)| (sheet.stem.clone(), Layer::Sheet(i)));
        let lobes = further.into_iter().map(|map| (free(&map.suffix()), Layer::Further(map)));
        let folded: Vec<(String, Layer)> = own.chain(lobes).collect();
        let extras = Extra::ALL.into_iter().filter(|extra| request.extras.contains(extra));
        let extras: Vec<_> = extras.map(|extra| (free(extra.name()), Layer::Extra(extra))).collect();
        let packed = request.formats.iter().filter(|format| **format != Format::Png);
        for maps in [&folded, &extras] {
            if request.formats.contains(&Format::Png) {
                for level in 0..levels {
                    maps.iter().for_each(|(stem, layer)| {
                        push(png_name(stem, level), Content::Level { layer: *layer, level });
                    });
                }
            }
            for format in packed.clone().copied() {
                for (stem, layer) in maps {
                    push(format!("{stem}.{}", format.extension()), Content::Levels { layer: *layer, format });
                }
            }
        }
        if request.formats.contains(&Format::Exr) {
            push(free("lobes") + ".exr", Content::Lobes);
        }
        if request.moments {
            push(free("moments") + ".exr", Content::Moments);
        }
        for (index, name) in request.pictures.iter().enumerate() {
            push(name.clone(), Content::Picture { index });
        }
        let asides =
            request.preset.map_or_else(Vec::new, |preset| asides(material, &sheets, &outputs, request, preset));
        for (index, aside) in asides.iter().enumerate() {
            outputs.push(Output { name: aside.name.clone(), content: Content::Aside { index } });
        }
        let warnings = match request.preset {
            Some(_) => super::sheet::left_out(material, &sheets),
            None => Vec::new(),
        };
        Self { sheets, outputs, asides, warnings }
    }

    /// The rows of one of its maps.
    pub fn rows<'a>(&'a self, material: &'a Material, chain: &'a Chain, request: &Request, layer: Layer) -> Rows<'a> {
        let flipped = request.normal_y(material) != material.normal_y;
        Rows { material, chain, sheets: &self.sheets, layer, flipped }
    }

    /// Refuses to write over an input, or over files that no earlier build wrote; and maps that a container cannot hold.
    ///
    /// # Errors
    /// [`Error::Invalid`] that names the file.
    pub fn check(&self, material: &Material, request: &Request) -> Result<()> {
        for output in &self.outputs {
            let path = request.folder.join(&output.name);
            if reads(material, &path) {
                return Err(Error::invalid(&path, "an output that is also an input", "another folder for -o"));
            }
            let (layer, format) = match output.content {
                Content::Level { layer, .. } => (layer, Format::Png),
                Content::Levels { layer, format } => (layer, format),
                _ => continue,
            };
            if let (Layer::Sheet(i), true) = (layer, format != Format::Exr)
                && self.sheets[i].channels.len() > 4
            {
                let found = format!("{} channels", self.sheets[i].channels.len());
                let expected = format!("up to 4 in a {}; --format exr holds more", format.extension().to_uppercase());
                return Err(Error::unsupported(&path, found, expected));
            }
            if let Some((found, expected)) = wrong_sides(material.size, format, request) {
                return Err(Error::unsupported(&path, found, expected));
            }
            if format == Format::Dds && request.compress == Compress::Uastc && !request.dds9 {
                return Err(Error::unsupported(&path, "UASTC in a DDS", "--compress bc or none, or --format ktx2"));
            }
        }
        let names = self.outputs.iter().map(|output| output.name.as_str());
        may_build(&request.folder, &material.name, names, request.force)
    }
}

/// What the sides of level 0 are and what the container and the engine want, where that is not the same.
fn wrong_sides(size: Size, format: Format, request: &Request) -> Option<(String, String)> {
    let plain = request.compress == Compress::None || (request.dds9 && format == Format::Dds);
    let blocks = format.is_texture() && !plain;
    let engine = request.preset.map_or(Sides::Any, |preset| preset.sides);
    let sides = if engine.holds(size) && blocks { Sides::MultipleOf4 } else { engine };
    if sides.holds(size) {
        return None;
    }
    let option = if sides == Sides::PowerOfTwo { "pot" } else { "4" };
    let why = if blocks { ", since texels are compressed in blocks of 4x4" } else { "" };
    let or = if blocks && engine == Sides::Any { ", or --compress none" } else { "" };
    let expected = format!("sides that are {}{why}; --resize {option} enlarges the maps{or}", sides.describe());
    Some((format!("{size} texels"), expected))
}

/// The material's maps as they are written: as they came, or as the preset packs them.
fn sheets(material: &Material, request: &Request) -> Vec<Sheet> {
    match request.preset {
        Some(preset) => super::sheet::arrange(material, preset),
        None => (0..material.maps.len()).map(|map| Sheet::own(material, map)).collect(),
    }
}

/// What the preset says beside the maps.
fn asides(material: &Material, sheets: &[Sheet], outputs: &[Output], request: &Request, preset: &Preset) -> Vec<Aside> {
    // They tell how to load files of the preset's own container.
    if !request.formats.contains(&preset.format) {
        return Vec::new();
    }
    let mut maps: Vec<(Layer, Vec<String>)> = Vec::new();
    for output in outputs {
        let layer = match output.content {
            Content::Level { layer, .. } if preset.format == Format::Png => layer,
            Content::Levels { layer, format } if preset.format == format => layer,
            _ => continue,
        };
        match maps.iter_mut().find(|(known, _)| *known == layer) {
            Some((_, files)) => files.push(output.name.clone()),
            None => maps.push((layer, vec![output.name.clone()])),
        }
    }
    let Size { width, height } = material.size;
    let levels = material.size.level_count();
    let written = maps.iter().map(|(layer, files)| {
        let role = match layer {
            Layer::Sheet(i) => sheets[*i].describe(material),
            layer => layer_role(material, sheets, *layer),
        };
        WrittenMap { role, files, levels, width, height }
    });
    let maps: Vec<_> = written.collect();
    preset.asides(&Written { material: &material.name, maps: &maps, wrap: material.wrap })
}

/// The name of a level of a map.
pub fn png_name(stem: &str, level: usize) -> String {
    format!("{stem}_mip{level}.png")
}

/// A name that every file system takes.
pub fn safe_name(name: &str) -> String {
    let safe: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    // Suffixes and endings come after it, and file systems end at 255 bytes.
    let end = safe.char_indices().map(|(i, c)| i + c.len_utf8()).take_while(|end| *end <= 120).last().unwrap_or(0);
    let safe = safe[..end].to_owned();
    if safe.trim_matches('.').is_empty() { "material".into() } else { safe }
}

/// Whether a file is an input of the material.
pub fn reads(material: &Material, file: &Path) -> bool {
    let input = |map: &MapFile| matches!(&map.origin, Origin::File { path, .. } if same_path(path, file));
    let flakes = material.flakes.iter().flat_map(|flakes| &flakes.about.files);
    material.maps.iter().any(input) || flakes.into_iter().any(|read| same_path(Path::new(&read.path), file))
}
