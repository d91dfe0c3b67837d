//! What was built, for other programs.

use serde::Serialize;

use super::exr::{MOMENT_CHANNELS, lobe_count, role_name};
use super::extra;
use super::plan::{Content, Format, Output, Plan, Request};
use crate::codec::Depth;
use crate::fold::{Chain, Options};
use crate::image::{Size, Wrap};
use crate::material::{
    Encoding, Extra, FlakesAbout, FurtherMap, GENERATOR, MapFile, Material, MeshAbout, NormalY, NormalZ, Origin, Role,
    SCHEMA, lobe_channels,
};
use crate::ndf::Form;

/// `manifest.json`: no times and no machine facts, so that the same build gives the same bytes.
#[derive(Debug, Serialize)]
pub struct Manifest {
    schema: u32,
    generator: &'static str,
    version: &'static str,
    material: String,
    size: Size,
    fold: &'static str,
    cite: &'static str,
    lobes: Form,
    /// Lobes a texel from level 1 on.
    count: usize,
    /// Whether these differ in width alone.
    shared_normal: bool,
    strength: f32,
    at_least_average: bool,
    min_alpha: f32,
    max_alpha: f32,
    normal_y: NormalY,
    normal_z: NormalZ,
    normal_scale: f32,
    wrap: Wrap,
    constant_roughness: Option<f32>,
    mesh: Option<MeshAbout>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flakes: Option<FlakesAbout>,
    inputs: Vec<Input>,
    maps: Vec<OutputMap>,
    /// For people.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pictures: Vec<String>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

/// An input file.
#[derive(Debug, Serialize)]
pub struct Input {
    /// As given; what is not Unicode in it is replaced.
    path: String,
    sha256: String,
    format: &'static str,
    size: Size,
    channels: Vec<ChannelRole>,
}

#[derive(Debug, Serialize)]
struct ChannelRole {
    name: String,
    role: String,
}

/// An output map: one file a level, or one file.
#[derive(Debug, Serialize)]
pub struct OutputMap {
    role: &'static str,
    container: Format,
    /// One a level, finest first; or a single mip-mapped file.
    files: Vec<String>,
    /// Bits and kind of a sample.
    encoding: &'static str,
    channels: Vec<ChannelRole>,
    levels: Vec<Size>,
    /// Where level 0 comes from.
    level_0: &'static str,
    /// How to read the channels r, g, b, in the order of `channels`, where their roles do not say it.
    #[serde(skip_serializing_if = "Option::is_none")]
    decode: Option<String>,
}

impl Manifest {
    /// Describes a build.
    pub fn new(material: &Material, chain: &Chain, options: &Options, plan: &Plan, request: &Request) -> Self {
        let constant = material
            .maps
            .iter()
            .any(|m| matches!(&m.origin, Origin::Generated(_)) && m.channel(Role::Roughness).is_some());
        Self {
            schema: SCHEMA,
            generator: GENERATOR,
            version: env!("CARGO_PKG_VERSION"),
            material: material.name.clone(),
            size: material.size,
            fold: options.fold.name,
            cite: options.fold.cite,
            lobes: options.form,
            count: options.lobes,
            shared_normal: options.shared_normal,
            strength: options.strength,
            at_least_average: options.at_least_average,
            min_alpha: options.min_alpha.0,
            max_alpha: options.max_alpha.0,
            normal_y: material.normal_y,
            normal_z: material.normal_z(),
            normal_scale: material.normal_scale,
            wrap: material.wrap,
            constant_roughness: constant.then_some(material.constant.0),
            mesh: material.mesh.as_ref().map(|mesh| mesh.about.clone()),
            flakes: material.flakes.as_ref().map(|flakes| flakes.about.clone()),
            inputs: inputs(material),
            maps: maps(material, chain, plan, request),
            pictures: request.pictures.clone(),
            notes: material.notes.clone(),
            warnings: material.warnings.clone(),
        }
    }
}

fn channels(material: &Material, map: usize) -> Vec<ChannelRole> {
    let file = &material.maps[map];
    let named = file.raster.channels.iter().zip(&file.roles);
    named.map(|(name, role)| ChannelRole { name: name.clone(), role: role_name(*role).into() }).collect()
}

fn height_channel() -> ChannelRole {
    ChannelRole { name: "first".into(), role: "height".into() }
}

fn inputs(material: &Material) -> Vec<Input> {
    let files = material.maps.iter().enumerate();
    files
        .filter_map(|(i, map)| match &map.origin {
            Origin::File { path, sha256, size, format, derived, .. } => Some(Input {
                path: path.to_string_lossy().into_owned(),
                sha256: sha256.clone(),
                format,
                size: *size,
                channels: if *derived { vec![height_channel()] } else { channels(material, i) },
            }),
            Origin::Generated(_) => None,
        })
        .collect()
}

fn maps(material: &Material, chain: &Chain, plan: &Plan, request: &Request) -> Vec<OutputMap> {
    let levels: Vec<Size> = (0..=chain.levels.len()).map(|k| chain.size.level(k)).collect();
    let mut out: Vec<OutputMap> = Vec::new();
    for (map, file) in material.maps.iter().enumerate() {
        let png = if file.bits == 8 { "unorm8" } else { "unorm16" };
        let exr = if request.depth == Depth::Half { "float16" } else { "float32" };
        for (container, encoding) in [(Format::Png, png), (Format::Exr, exr)] {
            let wanted = |o: &&Output| match o.content {
                Content::Level { map: m, .. } => m == map && container == Format::Png,
                Content::Levels { map: m } => m == map && container == Format::Exr,
                _ => false,
            };
            let files: Vec<_> = plan.outputs.iter().filter(wanted).map(|o| o.name.clone()).collect();
            if !files.is_empty() {
                out.push(OutputMap {
                    role: map_role(&file.roles),
                    container,
                    files,
                    encoding,
                    channels: channels(material, map),
                    levels: levels.clone(),
                    level_0: level_0(file, encoding),
                    decode: None,
                });
            }
        }
    }
    out.extend(further_maps(material, plan, request, &levels));
    for output in &plan.outputs {
        let (role, names) = match output.content {
            Content::Lobes => ("lobes", lobe_channels(lobe_count(chain))),
            Content::Moments => ("slope-moments", MOMENT_CHANNELS.map(String::from).to_vec()),
            _ => continue,
        };
        out.push(OutputMap {
            role,
            container: Format::Exr,
            files: vec![output.name.clone()],
            encoding: "float32",
            channels: names.into_iter().map(|name| ChannelRole { role: name.clone(), name }).collect(),
            levels: levels.clone(),
            level_0: "folded inputs",
            decode: None,
        });
    }
    out.extend(extras(material, &levels, plan, request));
    out
}

fn extras(material: &Material, levels: &[Size], plan: &Plan, request: &Request) -> Vec<OutputMap> {
    let mut out = Vec::new();
    let png = if extra::bits(material) == 8 { "unorm8" } else { "unorm16" };
    let exr = if request.depth == Depth::Half { "float16" } else { "float32" };
    for wanted in Extra::ALL {
        let in_png = |o: &&Output| matches!(o.content, Content::ExtraLevel { extra, .. } if extra == wanted);
        let in_exr = |o: &&Output| o.content == Content::ExtraLevels { extra: wanted };
        let name = |o: &Output| o.name.clone();
        let files: [Vec<String>; 2] = [
            plan.outputs.iter().filter(in_png).map(name).collect(),
            plan.outputs.iter().filter(in_exr).map(name).collect(),
        ];
        let kinds = [(Format::Png, Encoding::Unsigned, png), (Format::Exr, Encoding::Signed, exr)];
        for (files, (container, form, encoding)) in files.into_iter().zip(kinds) {
            let channels = wanted.channels(form);
            let names: &[&str] = match container {
                Format::Png if channels.len() == 1 => &["Y"],
                Format::Png => &["R", "G", "B"],
                Format::Exr => &[],
            };
            let named = |(i, (name, role)): (usize, &(&'static str, &'static str))| ChannelRole {
                name: names.get(i).unwrap_or(name).to_string(),
                role: (*role).to_owned(),
            };
            if !files.is_empty() {
                out.push(OutputMap {
                    role: wanted.name(),
                    container,
                    files,
                    encoding,
                    channels: channels.iter().enumerate().map(named).collect(),
                    levels: levels.to_vec(),
                    level_0: match wanted {
                        Extra::Curvature => "the mesh",
                        Extra::Flakes => "maps of the flakes",
                        _ => "the inputs' own lobes",
                    },
                    decode: Some(wanted.decode(form).to_owned()),
                });
            }
        }
    }
    out
}

/// The maps of the lobes after the first.
fn further_maps(material: &Material, plan: &Plan, request: &Request, levels: &[Size]) -> Vec<OutputMap> {
    let mut out: Vec<(FurtherMap, OutputMap)> = Vec::new();
    for output in &plan.outputs {
        let (map, container) = match output.content {
            Content::FurtherLevel { map, .. } => (map, Format::Png),
            Content::FurtherLevels { map } => (map, Format::Exr),
            _ => continue,
        };
        // The plan goes level by level.
        if let Some((_, known)) = out.iter_mut().find(|(other, known)| *other == map && known.container == container) {
            known.files.push(output.name.clone());
            continue;
        }
        let encoding = match (container, map.depth(material), request.depth) {
            (Format::Png, 8, _) => "unorm8",
            (Format::Png, ..) => "unorm16",
            (Format::Exr, _, Depth::Half) => "float16",
            (Format::Exr, ..) => "float32",
        };
        let channels = map.channels().zip(map.roles(role_name));
        let described = OutputMap {
            role: match map {
                FurtherMap::Lobe(_) => "lobe",
                FurtherMap::Haze(_) => "haze",
                FurtherMap::Anisotropy(_) => "lobe-anisotropy",
            },
            container,
            files: vec![output.name.clone()],
            encoding,
            channels: channels.map(|(name, role)| ChannelRole { name: name.into(), role }).collect(),
            levels: levels.to_vec(),
            level_0: "the first lobe, of weight 0",
            decode: Some(decode(map, container)),
        };
        out.push((map, described));
    }
    out.into_iter().map(|(_, map)| map).collect()
}

/// How a shader reads a map of a further lobe. The lobe of the ordinary maps has the weight that the others leave.
fn decode(map: FurtherMap, container: Format) -> String {
    let signed = if container == Format::Png { "2 * rg - 1" } else { "rg" };
    match map {
        FurtherMap::Lobe(_) => format!(
            "n.xy = {signed}, in the convention normal_y; n.z = sqrt(max(0, 1 - n.x^2 - n.y^2)); weight = b; alpha = a^2; \
             weight of the first lobe = 1 - the sum of the others'"
        ),
        FurtherMap::Haze(_) => {
            "n = that of the first lobe; alpha = r^2; weight = g; weight of the first lobe = 1 - the sum \
                                of the others'"
                .into()
        }
        FurtherMap::Anisotropy(_) => {
            "direction = 2 * rg - 1; alpha across = that of the lobe's own map; alpha along = \
                                      mix(alpha across, 1, b^2), as KHR_materials_anisotropy"
                .into()
        }
    }
}

/// Where level 0 of a map comes from.
fn level_0(file: &MapFile, encoding: &str) -> &'static str {
    match &file.origin {
        Origin::Generated(_) => "generated",
        Origin::File { derived: true, .. } => "derived from heights",
        Origin::File { scaled: true, .. } => "the input, its roughness times a factor",
        Origin::File { size, .. } if *size != file.raster.size() => "the input, enlarged",
        Origin::File { .. } if encoding == "unorm16" && file.bits == 32 => "the input, rounded to 16 bit",
        Origin::File { .. } if encoding == "float16" => "the input, rounded to half floats",
        Origin::File { .. } if encoding == "float32" && !file.signed && file.channel(Role::NormalX).is_some() => {
            "the input's own pixels, normals as -1..1"
        }
        Origin::File { .. } => "the input's own pixels",
    }
}

/// One word for a map: what it holds first.
fn map_role(roles: &[Role]) -> &'static str {
    let has = |role| roles.contains(&role);
    if has(Role::NormalX) && (has(Role::Roughness) || has(Role::Smoothness)) {
        "normal-roughness"
    } else if has(Role::NormalX) {
        "normal"
    } else if has(Role::AnisotropyX) {
        "anisotropy"
    } else if has(Role::Smoothness) {
        "smoothness"
    } else {
        "roughness"
    }
}
