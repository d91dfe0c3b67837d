//! The command line's words.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::audit::AuditArgs;
use super::compare_args::CompareArgs;
use super::container_args::ContainerArgs;
use super::glint_args::GlintArgs;
use super::lobes_arg::LobesArg;
use super::model::ModelArgs;
use crate::curvature::LONGEST_SIDE;
use crate::fold::{DEFAULT_FOLD, FOLDS, Fold, Options};
use crate::image::{Size, Wrap};
use crate::kernels::Language;
use crate::material::{DEFAULT_HEIGHT_SCALE, DEFAULT_ROUGHNESS, Extra, NormalRange, NormalY, NormalZ};
use crate::ndf::Form;
use crate::roughness::Alpha;

/// For the ends of helps.
pub const EXIT_CODES: &str = "Exit codes: 0 done, 1 a check failed, 2 bad usage or input.";

/// Mip chains that keep a material looking the same at every distance.
///
/// When a normal map is minified its bumps average away, and the far surface turns too smooth and too shiny. mipfold
/// folds the lost bumps into the roughness of each mip level.
#[derive(Parser)]
#[command(name = "mipfold", version, max_term_width = 100)]
#[command(after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub global: Global,
}

#[derive(Args)]
pub struct Global {
    /// Print one JSON object for programs instead of text
    #[arg(long, global = true)]
    pub json: bool,
    /// Print nothing but warnings and errors
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Worker threads [default: one a core]; the outputs are the same for any number
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Read and check everything, say what would be written, write nothing
    #[arg(long, global = true)]
    pub dry_run: bool,
    /// Replace files that mipfold did not write, and build what is unchanged again
    #[arg(long, short, global = true)]
    pub force: bool,
}

#[derive(Subcommand)]
pub enum Command {
    /// Build a folded mip chain from a normal map and a roughness map, or from a folder of texture sets
    Build(BuildArgs),
    /// Say what is wrong with a material's maps, how sure that is, and what mends it
    Audit(AuditArgs),
    /// Judge mip chains, of whatever origin, against the exact truth of their level 0
    Compare(CompareArgs),
    /// Bake the curvature of a mesh into the roughness of mips, together with the material's own maps
    BakeCurvature(BakeArgs),
    /// Make a sample material, build and judge its chain, and draw it from near to far
    Demo(DemoArgs),
    /// Put flakes on a material: its chain, maps of where the flakes are, and pictures of it glinting
    Glint(GlintArgs),
    /// Print shader helpers to include: what reads the maps, filters geometry and shades
    Kernels(KernelsArgs),
    /// List what engines want, and tell why and how to load it
    Presets(PresetsArgs),
}

#[derive(Args)]
#[command(after_help = fold_list())]
pub struct BakeArgs {
    /// Mesh: .glb, .gltf, .obj or .ply. The maps of glTF materials are found in it
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Folder for the outputs; several materials get a folder each below it
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// Only the triangles of this material; may be repeated [default: all]
    #[arg(long, value_name = "NAME")]
    pub part: Vec<String>,
    /// Texels along each side, where no map gives them
    #[arg(long, default_value = "1024", value_name = "N[xN]", value_parser = size)]
    pub size: Size,
    /// Set of texture coordinates to bake into (glTF's TEXCOORD_n), where no texture of the material names it
    #[arg(long, default_value = "0", value_name = "N")]
    pub uv_set: usize,
    /// Where the mesh has no normals: the angle from which two faces get an edge, in degrees; 0 shades every face flat
    #[arg(long, default_value = "60", value_name = "DEGREES", value_parser = degrees)]
    pub crease: f64,
    /// Texels beside the surface that are filled from their neighbours, at every level
    #[arg(long, default_value = "8", value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub padding: u16,
    #[command(flatten)]
    pub maps: MapArgs,
    #[command(flatten)]
    pub reading: ReadingArgs,
    #[command(flatten)]
    pub folding: FoldArgs,
    #[command(flatten)]
    pub containers: ContainerArgs,
}

#[derive(Args)]
pub struct KernelsArgs {
    /// Files to print [default: their list]
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Shading language
    #[arg(long, value_enum, default_value = "wgsl")]
    pub lang: Language,
    /// Print the files that these need too, before them
    #[arg(long)]
    pub bundle: bool,
}

#[derive(Args)]
pub struct PresetsArgs {
    /// Preset to tell all about [default: their list]
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
}

/// A name and what is said of it, in lines that fit a terminal of 80 columns, so that nothing else breaks them.
pub fn entry(name: &str, about: &str) -> String {
    const NAME: usize = 18;
    const ABOUT: usize = 80 - NAME - 3;
    let mut lines = vec![String::new()];
    for word in about.split(' ') {
        let last = lines.last_mut().expect("never empty");
        if last.is_empty() {
            *last = word.into();
        } else if last.chars().count() + 1 + word.chars().count() <= ABOUT {
            *last = format!("{last} {word}");
        } else {
            lines.push(word.into());
        }
    }
    format!("  {name:<NAME$} {}", lines.join(&format!("\n{:1$}", "", NAME + 3)))
}

/// Names of folds, for the help.
pub fn fold_list() -> String {
    let lines = FOLDS.iter().map(|fold| {
        let form = if fold.has_two_widths() { "" } else { " (one width only)" };
        entry(fold.name, &format!("{}{form}", fold.about))
    });
    format!("Folds:\n{}\n\n{EXIT_CODES}", lines.collect::<Vec<_>>().join("\n"))
}

#[derive(Args)]
#[command(after_help = fold_list())]
pub struct BuildArgs {
    /// Folders of texture sets, found by file name (NAME_normal.png, NAME_roughness.png, NAME_orm.png, ...), with all
    /// folders below; or one model, .glb or .gltf
    #[arg(value_name = "FOLDER|MODEL", conflicts_with_all = ["normal", "orm", "height", "anisotropy"])]
    pub inputs: Vec<PathBuf>,
    /// Folder for the outputs; several materials get a folder each below it. Of a model: the new one, .glb or .gltf
    #[arg(long, short, value_name = "DIR|MODEL")]
    pub output: PathBuf,
    /// Options for all materials or for some of them, in place of the files mipfold.toml of the folders
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub maps: MapArgs,
    #[command(flatten)]
    pub reading: ReadingArgs,
    #[command(flatten)]
    pub folding: FoldArgs,
    #[command(flatten)]
    pub containers: ContainerArgs,
    #[command(flatten)]
    pub model: ModelArgs,
    /// Also write the raw LEAN slope moments as mip-mapped EXR (OpenImageIO's bumpslopes channels)
    #[arg(long)]
    pub moments: bool,
    /// Write nothing for a material whose roughness folding changes by less than this (in 99 of 100 texels)
    #[arg(long, value_name = "R", value_parser = unit)]
    pub skip_if_below: Option<f32>,
    /// Further maps, each at every level; may be repeated
    #[arg(long, value_enum, value_name = "MAP", value_delimiter = ',')]
    pub extra: Vec<Extra>,
}

#[derive(Args)]
#[command(next_help_heading = "Maps of one material")]
pub struct MapArgs {
    /// Tangent-space normal map
    #[arg(long, value_name = "FILE")]
    pub normal: Option<PathBuf>,
    #[arg(long, value_name = "FILE[:r|g|b|a]|NUMBER", help = format!(
        "Perceptual roughness: a map, a channel of one (orm.png:g), or one number [default: {}]", DEFAULT_ROUGHNESS.0))]
    pub roughness: Option<String>,
    /// Gloss or smoothness (1 - roughness): a map, a channel of one (mask.png:a), or one number
    #[arg(
        long,
        alias = "smoothness",
        visible_alias = "smoothness",
        value_name = "FILE[:r|g|b|a]",
        conflicts_with = "roughness"
    )]
    pub gloss: Option<String>,
    /// Packed occlusion, roughness, metal; the same as --roughness FILE:g
    #[arg(long, value_name = "FILE", conflicts_with_all = ["roughness", "gloss"])]
    pub orm: Option<PathBuf>,
    /// Ambient occlusion, for a --preset that packs it: a map or a channel of one
    #[arg(long, value_name = "FILE[:r|g|b|a]")]
    pub occlusion: Option<String>,
    /// Metalness, likewise
    #[arg(long, value_name = "FILE[:r|g|b|a]")]
    pub metal: Option<String>,
    /// Anisotropy map in glTF's form: direction in red and green, strength in blue
    #[arg(long, value_name = "FILE")]
    pub anisotropy: Option<PathBuf>,
    /// Height map, from which normals are derived if there is no normal map
    #[arg(long, value_name = "FILE")]
    pub height: Option<PathBuf>,
    /// Name of the material [default: from the files]
    #[arg(long)]
    pub name: Option<String>,
}

#[derive(Args)]
#[command(next_help_heading = "How to read them")]
pub struct ReadingArgs {
    /// Which way the normal map's green points: opengl is up (+Y), directx is down (-Y)
    #[arg(long, value_enum, ignore_case = true, default_value = "opengl", value_name = "CONVENTION")]
    pub normal_y: NormalY,
    /// Where z comes from: stored, rebuilt from x and y, or auto: stored if there is a third channel
    #[arg(long, value_enum, default_value = "auto")]
    pub normal_z: NormalZ,
    /// How a float file stores normals: signed (-1..1), unsigned (0..1), or auto: whichever is more nearly unit
    #[arg(long, value_enum, default_value = "auto", value_name = "RANGE")]
    pub normal_range: NormalRange,
    /// Normal strength that the renderer applies (glTF's normalTexture.scale), 0.001 to 1000
    #[arg(long, value_name = "K", default_value = "1", value_parser = scale)]
    pub normal_scale: f32,
    #[arg(long, value_name = "H", value_parser = positive,
          help = format!("Height of white over black, in widths of the texture [default: {DEFAULT_HEIGHT_SCALE}]"))]
    pub height_scale: Option<f32>,
    /// What lies beyond the border [default: repeat, but clamp for UDIM tiles]
    #[arg(long, value_enum)]
    pub wrap: Option<WrapArg>,
}

#[derive(Args)]
#[command(next_help_heading = "Folding")]
pub struct FoldArgs {
    #[arg(long, value_name = "NAME", default_value = DEFAULT_FOLD.name, value_parser = fold_name, help = "How a footprint becomes one lobe; the names are below")]
    pub fold: &'static Fold,
    /// Lobes of a texel: iso (drop-in roughness), aniso (roughness and an anisotropy map), 2, 3 or 4 (a map more for each
    /// further lobe), the same with -aniso, or haze (two lobes sharing a normal) [default: iso, or aniso if there is an
    /// anisotropy map]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "LOBES")]
    pub lobes: Option<LobesArg>,
    /// Share of the lost bumps that is folded in: 0 none, 1 all; more exaggerates
    #[arg(long, value_name = "S", default_value = "1", value_parser = not_negative)]
    pub strength: f32,
    /// Make no level smoother than the plain average of the roughness; where smooth and rough texels meet, 'ggx' may be
    #[arg(long)]
    pub at_least_average: bool,
    /// Smallest alpha (perceptual roughness squared) in any level but the first
    #[arg(long, value_name = "A", default_value = "0", value_parser = unit)]
    pub min_alpha: f32,
    /// Largest alpha in any level but the first
    #[arg(long, value_name = "A", default_value = "1", value_parser = unit)]
    pub max_alpha: f32,
}

#[derive(Args)]
pub struct DemoArgs {
    /// Sample to make; --list names them
    #[arg(default_value = "woven-cloth", value_name = "SAMPLE")]
    pub sample: String,
    /// Make every sample
    #[arg(long)]
    pub all: bool,
    /// Name the samples and stop
    #[arg(long)]
    pub list: bool,
    /// Folder for the sample's maps, its chain, the picture and the report
    #[arg(long, short, value_name = "DIR", default_value = "mipfold-demo")]
    pub output: PathBuf,
    /// Texels along each side
    #[arg(long, default_value = "512", value_name = "N", value_parser = clap::value_parser!(u16).range(16..=4096))]
    pub size: u16,
    /// Seed of the sample
    #[arg(long, default_value = "1")]
    pub seed: u64,
    #[command(flatten)]
    pub folding: FoldArgs,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum WrapArg {
    Repeat,
    Mirror,
    Clamp,
}

impl From<WrapArg> for Wrap {
    fn from(wrap: WrapArg) -> Self {
        match wrap {
            WrapArg::Repeat => Wrap::Repeat,
            WrapArg::Mirror => Wrap::Mirror,
            WrapArg::Clamp => Wrap::Clamp,
        }
    }
}

impl ReadingArgs {
    /// What lies beyond the border, where no name tells.
    pub fn wrap(&self) -> Wrap {
        self.wrap.map_or(Wrap::default(), Into::into)
    }
}

impl FoldArgs {
    /// As asked for, if it was.
    pub fn form(&self) -> Option<Form> {
        self.lobes.map(LobesArg::form)
    }

    pub fn options(&self, slope_moments: bool) -> crate::error::Result<Options> {
        let lobes = self.lobes.unwrap_or(LobesArg::Iso);
        lobes.check(self.fold)?;
        if self.min_alpha > self.max_alpha {
            return Err(crate::Error::invalid_option(
                "--min-alpha",
                format!("{} above --max-alpha {}", self.min_alpha, self.max_alpha),
                "a smaller one",
            ));
        }
        Ok(Options {
            fold: self.fold,
            form: lobes.form(),
            lobes: lobes.count(),
            shared_normal: lobes.shared_normal(),
            strength: self.strength,
            at_least_average: self.at_least_average,
            min_alpha: Alpha(self.min_alpha),
            max_alpha: Alpha(self.max_alpha),
            slope_moments,
            mean_length: false,
        })
    }
}

pub fn fold_name(name: &str) -> Result<&'static Fold, String> {
    Fold::by_name(name).map_err(|_| {
        let names: Vec<_> = FOLDS.iter().map(|fold| fold.name).collect();
        format!("expected one of {}", names.join(", "))
    })
}

/// A finite number, `f32` or `f64`.
pub fn number<T>(text: &str, ok: impl Fn(T) -> bool, expected: &str) -> Result<T, String>
where
    T: FromStr + Copy + Into<f64>,
{
    let value = text.parse().ok().filter(|value: &T| (*value).into().is_finite() && ok(*value));
    value.ok_or_else(|| format!("expected {expected}"))
}

/// `1024` or `1024x512`.
fn size(text: &str) -> Result<Size, String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    match (width.parse(), height.parse()) {
        (Ok(width @ 1..=LONGEST_SIDE), Ok(height @ 1..=LONGEST_SIDE)) => Ok(Size::new(width, height)),
        _ => Err(format!("expected a side, or WIDTHxHEIGHT, of 1 to {LONGEST_SIDE} texels")),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    number(text, |v: f32| (0.0..=180.0).contains(&v), "an angle from 0 to 180 degrees").map(f64::from)
}

fn positive(text: &str) -> Result<f32, String> {
    number(text, |v| v > 0.0, "a number above 0")
}

fn scale(text: &str) -> Result<f32, String> {
    number(text, |v| (0.001..=1000.0).contains(&v), "a number from 0.001 to 1000")
}

fn not_negative(text: &str) -> Result<f32, String> {
    number(text, |v| v >= 0.0, "a number from 0 up")
}

fn unit(text: &str) -> Result<f32, String> {
    number(text, |v| (0.0..=1.0).contains(&v), "a number from 0 to 1")
}
