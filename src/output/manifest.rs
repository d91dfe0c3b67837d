//! What was built, for other programs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::exr::{MOMENT_CHANNELS, lobe_count, role_name};
use super::layer::{Layer, Rows};
use super::plan::{Content, Format, Plan, Request};
use super::sheet::Sheet;
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
    /// Texts beside the maps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    asides: Vec<String>,
    notes: Vec<String>,
    warnings: Vec<String>,
    /// All that the build is made of, as one number.
    #[serde(skip_serializing_if = "Option::is_none")]
    key: Option<String>,
    /// SHA-256 of each file, hexadecimal.
    sha256: BTreeMap<String, String>,
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
    /// Describes a build, with the SHA-256 of each of its files.
    pub fn new(
        material: &Material,
        chain: &Chain,
        options: &Options,
        plan: &Plan,
        request: &Request,
        sha256: BTreeMap<String, String>,
    ) -> Self {
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
            normal_y: request.normal_y(material),
            normal_z: material.normal_z(),
            normal_scale: material.normal_scale,
            wrap: material.wrap,
            constant_roughness: constant.then_some(material.constant.0),
            mesh: material.mesh.as_ref().map(|mesh| mesh.about.clone()),
            flakes: material.flakes.as_ref().map(|flakes| flakes.about.clone()),
            inputs: inputs(material),
            maps: maps(material, chain, plan, request),
            pictures: request.pictures.clone(),
            asides: plan.asides.iter().map(|aside| aside.name.clone()).collect(),
            notes: material.notes.clone(),
            warnings: material.warnings.iter().chain(&plan.warnings).cloned().collect(),
            key: request.key.clone(),
            sha256,
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
    let mut out: Vec<((Layer, Format), OutputMap)> = Vec::new();
    for output in &plan.outputs {
        let (layer, container) = match output.content {
            Content::Level { layer, .. } => (layer, Format::Png),
            Content::Levels { layer, format } => (layer, format),
            _ => continue,
        };
        // The plan goes level by level.
        if let Some((_, known)) = out.iter_mut().find(|(key, _)| *key == (layer, container)) {
            known.files.push(output.name.clone());
            continue;
        }
        let rows = plan.rows(material, chain, request, layer);
        let form = if container == Format::Exr { Encoding::Signed } else { Encoding::Unsigned };
        let encoding = match (container, rows.bits(), request.depth) {
            (Format::Png, 8, _) => "unorm8",
            (Format::Png, ..) => "unorm16",
            (Format::Exr, _, Depth::Half) => "float16",
            (Format::Exr, ..) => "float32",
            (Format::Ktx2 | Format::Dds, ..) => request.texels(&rows, container).name(),
        };
        let described = OutputMap {
            role: layer_role(material, &plan.sheets, layer),
            container,
            files: vec![output.name.clone()],
            encoding,
            channels: stored(&rows, container, form, request),
            levels: levels.clone(),
            level_0: layer_level_0(material, plan, layer, encoding),
            decode: match layer {
                Layer::Sheet(_) => None,
                Layer::Further(map) => Some(decode(map, form)),
                Layer::Extra(extra) => Some(extra.decode(form).to_owned()),
            },
        };
        out.push(((layer, container), described));
    }
    // Extra maps come last.
    let folded = out.iter().take_while(|((layer, _), _)| !matches!(layer, Layer::Extra(_))).count();
    let mut out: Vec<OutputMap> = out.into_iter().map(|(_, map)| map).collect();
    let extras = out.split_off(folded);
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
    out.extend(extras);
    out
}

/// The channels of a map that a container holds.
fn stored(rows: &Rows, container: Format, form: Encoding, request: &Request) -> Vec<ChannelRole> {
    let mut channels = rows.channels(form);
    if container.is_texture() {
        channels = rows.texture_channels();
        let texels = request.texels(rows, container);
        channels.truncate(texels.channels());
        let used = channels.len();
        let names = ["R", "G", "B", "A"].into_iter().take(texels.channels());
        channels.extend(names.skip(used).map(|name| (name.to_owned(), "unused".to_owned())));
    }
    channels.into_iter().map(|(name, role)| ChannelRole { name, role }).collect()
}

/// One word for a map.
pub fn layer_role(material: &Material, sheets: &[Sheet], layer: Layer) -> &'static str {
    match layer {
        Layer::Sheet(i) => {
            let sheet = &sheets[i];
            map_role(&(0..sheet.channels.len()).filter_map(|c| sheet.role(material, c)).collect::<Vec<_>>())
        }
        Layer::Further(FurtherMap::Lobe(_)) => "lobe",
        Layer::Further(FurtherMap::Haze(_)) => "haze",
        Layer::Further(FurtherMap::Anisotropy(_)) => "lobe-anisotropy",
        Layer::Extra(extra) => extra.name(),
    }
}

fn layer_level_0(material: &Material, plan: &Plan, layer: Layer, encoding: &str) -> &'static str {
    match layer {
        Layer::Sheet(i) => match plan.sheets[i].map {
            Some(map) => level_0(&material.maps[map], encoding),
            None => "the inputs, packed anew",
        },
        Layer::Further(_) => "the first lobe, of weight 0",
        Layer::Extra(Extra::Curvature) => "the mesh",
        Layer::Extra(Extra::Flakes) => "maps of the flakes",
        Layer::Extra(_) => "the inputs' own lobes",
    }
}

/// How a shader reads a map of a further lobe. The lobe of the ordinary maps has the weight that the others leave.
fn decode(map: FurtherMap, form: Encoding) -> String {
    let signed = if form == Encoding::Unsigned { "2 * rg - 1" } else { "rg" };
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
        Origin::File { .. } if ["bc4", "bc5", "bc7", "uastc"].contains(&encoding) => "the input, compressed in blocks",
        Origin::File { .. } if matches!(encoding, "unorm16" | "r16" | "rg16" | "rgba16") && file.bits == 32 => {
            "the input, rounded to 16 bit"
        }
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
