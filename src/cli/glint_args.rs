//! The words of `mipfold glint`.

use std::path::PathBuf;

use clap::Args;

use super::args::{FoldArgs, MapArgs, ReadingArgs, entry, fold_list, number};
use super::container_args::ContainerArgs;
use crate::error::{self, Error};
use crate::glint::{EVALUATORS, Evaluator, evaluator};
use crate::image::{Size, Wrap};
use crate::material::{ChannelRef, Extra, FlakePlaces, FlakesAbout, MaterialFlakes, ReadPicture};

/// Flakes a texel where their number is not given.
const FLAKES_A_TEXEL: f64 = 2.0;

#[derive(Args)]
#[command(after_help = glint_help())]
pub struct GlintArgs {
    /// Folder of a texture set, found by file name (NAME_normal.png, NAME_roughness.png, NAME_orm.png, ...)
    #[arg(value_name = "FOLDER", conflicts_with_all = ["normal", "orm", "height", "anisotropy"])]
    pub input: Option<PathBuf>,
    /// Folder for the chain, the maps of flakes and the pictures
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    pub flakes: FlakeArgs,
    #[command(flatten)]
    pub preview: PreviewArgs,
    #[command(flatten)]
    pub maps: MapArgs,
    #[command(flatten)]
    pub reading: ReadingArgs,
    #[command(flatten)]
    pub folding: FoldArgs,
    #[command(flatten)]
    pub containers: ContainerArgs,
    /// Further maps, each at every level; may be repeated
    #[arg(long, value_enum, value_name = "MAP", value_delimiter = ',')]
    pub extra: Vec<Extra>,
}

#[derive(Args)]
#[command(next_help_heading = "Flakes")]
pub struct FlakeArgs {
    /// Flakes on one repeat of the texture [default: two a texel]
    #[arg(long, value_name = "N", value_parser = many)]
    pub flakes: Option<f64>,
    /// Perceptual roughness of one flake: small ones are tiny mirrors, seldom seen and bright
    #[arg(long, default_value = "0.2", value_name = "R", value_parser = flake_roughness)]
    pub flake_roughness: f32,
    /// How unequal the flakes are: standard deviation of their areas over the mean, 0 to 3
    #[arg(long, default_value = "0.5", value_name = "V", value_parser = variation)]
    pub size_variation: f64,
    /// Share of the surface that flakes cover: the size at which close-ups show them
    #[arg(long, default_value = "1", value_name = "C", value_parser = coverage)]
    pub coverage: f64,
    /// Seed; another one is another surface
    #[arg(long, default_value = "1", value_name = "N")]
    pub seed: u32,
    /// Make scratches: flakes so many times longer than wide
    #[arg(long, value_name = "RATIO", value_parser = streak)]
    pub streak: Option<f64>,
    /// Direction of scratches, degrees from u towards v
    #[arg(long, default_value = "0", value_name = "DEGREES", requires = "streak", allow_negative_numbers = true,
          value_parser = degrees)]
    pub streak_angle: f64,
    /// Where flakes are: a map, or a channel of one (of colours, green); white is all flakes, black none, grays are shares of the
    /// surface (linear)
    #[arg(long, value_name = "FILE[:r|g|b|a]")]
    pub flake_mask: Option<String>,
    /// How densely they lie there, of a map as above: white is --flakes, black a thousandth of it (linear)
    #[arg(long, value_name = "FILE[:r|g|b|a]")]
    pub flake_density: Option<String>,
}

#[derive(Args)]
#[command(next_help_heading = "Pictures")]
pub struct PreviewArgs {
    /// Write the maps only
    #[arg(long)]
    pub no_pictures: bool,
    /// Pixels along each side of a picture
    #[arg(long, default_value = "256", value_name = "N", value_parser = clap::value_parser!(u16).range(32..=2048))]
    pub pixels: u16,
    /// Frames of each animation
    #[arg(long, default_value = "24", value_name = "N", value_parser = clap::value_parser!(u16).range(2..=600))]
    pub frames: u16,
    /// How flakes are counted; the ways are below
    #[arg(long, value_name = "NAME", default_value = EVALUATORS[0].name, value_parser = evaluator_name)]
    pub evaluator: &'static Evaluator,
    /// Half the angle under which a lamp is seen, in degrees: a large one lights more flakes, each less
    #[arg(long, default_value = "0.5", value_name = "DEGREES", value_parser = lamp)]
    pub lamp: f64,
}

impl FlakeArgs {
    /// The flakes of a material.
    pub fn load(&self, size: Size, wrap: Wrap, read: ReadPicture) -> error::Result<MaterialFlakes> {
        let about = FlakesAbout {
            density: self.flakes.unwrap_or(FLAKES_A_TEXEL * size.texels() as f64),
            roughness: self.flake_roughness,
            size_variation: self.size_variation,
            coverage: self.coverage,
            seed: self.seed,
            streak: self.streak,
            streak_angle: self.streak_angle,
            files: Vec::new(),
        };
        let flakes = self.places().load(about, size, wrap, read)?;
        if flakes.levels.last().is_some_and(|top| top[(0, 0, 0)] <= 0.0) {
            let options = [("--flake-mask", &self.flake_mask), ("--flake-density", &self.flake_density)];
            let given: Vec<_> = options.iter().filter(|(_, file)| file.is_some()).map(|(option, _)| *option).collect();
            let found = "maps of flakes without any flake";
            return Err(Error::invalid_option(given.join(" and "), found, "some place that is not black"));
        }
        Ok(flakes)
    }

    fn places(&self) -> FlakePlaces {
        let channel = |text: &Option<String>| text.as_deref().map(ChannelRef::parse);
        FlakePlaces { density: channel(&self.flake_density), mask: channel(&self.flake_mask) }
    }
}

fn glint_help() -> String {
    let ways: Vec<_> = EVALUATORS.iter().map(|way| entry(way.name, way.about)).collect();
    format!("Ways to count flakes:\n{}\n\n{}", ways.join("\n"), fold_list())
}

fn evaluator_name(name: &str) -> Result<&'static Evaluator, String> {
    evaluator(name).ok_or_else(|| {
        let names: Vec<_> = EVALUATORS.iter().map(|way| way.name).collect();
        format!("expected one of {}", names.join(", "))
    })
}

fn many(text: &str) -> Result<f64, String> {
    number(text, |v| (1.0..=1e12).contains(&v), "a number from 1 to 1e12")
}

fn flake_roughness(text: &str) -> Result<f32, String> {
    number(text, |v| (0.01..=1.0).contains(&v), "a number from 0.01 to 1")
}

fn variation(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=3.0).contains(&v), "a number from 0 to 3")
}

fn coverage(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v <= 1.0, "a number above 0, at most 1")
}

fn streak(text: &str) -> Result<f64, String> {
    number(text, |v| (1.0..=1000.0).contains(&v), "a number from 1 to 1000")
}

fn degrees(text: &str) -> Result<f64, String> {
    number(text, |v: f64| v.abs() <= 360.0, "an angle from -360 to 360 degrees")
}

fn lamp(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=20.0).contains(&v), "an angle from 0 to 20 degrees")
}
