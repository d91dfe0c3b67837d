//! The words of `mipfold compare`.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::args::{MapArgs, ReadingArgs, entry, fold_list, fold_name};
use super::lobes_arg::LobesArg;
use crate::compare::{Limit, Metric, Settings, level_range};
use crate::error::{Error, Result};
use crate::fold::Fold;
use crate::image::Size;
use crate::reference::{Interpolation, Reading};

/// Places along one side of a texel where `--interpolation bilinear` looks: the reference's error from their number is
/// then far below what 80 directions leave.
const PER_SIDE: usize = 4;

/// What stands below the help.
fn after_help() -> String {
    let metrics: Vec<String> = Metric::ALL.iter().map(|metric| entry(metric.name, metric.about)).collect();
    let chains = [
        ("FOLDER", "that `mipfold build` wrote; FOLDER,container=png|ktx2|dds|exr|lobes chooses among what is there"),
        ("NAME_lobes.exr", "that `mipfold build --format exr` wrote"),
        (
            "KEY=VALUE,...",
            "maps: normal=n_%d.png,roughness=orm_%d.png:g has one file a level, from 0 on; \
             normal=n.exr,roughness=r.exr:r are mip-mapped OpenEXR files",
        ),
    ];
    format!(
        "CHAIN is one of\n{}\n\n\
         Levels are written %d, or %02d with leading zeros; %% is a percent sign beside them. A path may hold commas, \
         but no = after one.\n\n\
         Keys of maps: normal, roughness (or a number), smoothness, orm, anisotropy, normal-y, normal-z, normal-range, \
         normal-scale, name. Keys of a FOLDER: container, name.\n\n\
         Metrics for --limit:\n{}\n\n{}",
        chains.map(|(form, about)| entry(form, about)).join("\n"),
        metrics.join("\n"),
        fold_list()
    )
}

#[derive(Args)]
#[command(after_help = after_help())]
pub struct CompareArgs {
    /// Mip chains to judge, side by side; what a chain may be is said below
    #[arg(value_name = "CHAIN")]
    pub chains: Vec<String>,
    /// Folder with the texture set of level 0, found as `build` finds it [default: level 0 of the first FOLDER, or else of
    /// the first chain]
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["normal", "orm", "height", "anisotropy"])]
    pub base: Option<PathBuf>,
    /// Judge these folds of level 0 as well: names separated by commas, or all (but slow ones) [default, without CHAIN: ggx]
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = fold_choice)]
    pub fold: Vec<FoldChoice>,
    /// Lobes of --fold: iso, aniso, 2, 3, 4, 2-aniso, 3-aniso, 4-aniso or haze, as in `build`; chains keep theirs
    /// [default: iso, or aniso if there is an anisotropy map]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "LOBES")]
    pub lobes: Option<LobesArg>,
    /// Leave out the baseline: plain mips of level 0
    #[arg(long)]
    pub no_plain: bool,
    /// Folder for report.html, report.json and report.csv; without it only text is printed
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Largest mean that passes, by metric (default lobe-error) and level: 0.15, ndf-tv=0.1, lobe-error@3=0.2, @1-4=0.1;
    /// may be repeated. A chain past it makes the exit code 1; plain mips are not held to it
    #[arg(long, value_name = "[METRIC[@LEVELS]=]VALUE", value_parser = Limit::from_str)]
    pub limit: Vec<Limit>,
    /// Leave the moving pictures out of the report
    #[arg(long)]
    pub no_motion: bool,
    #[command(flatten)]
    pub looking: LookArgs,
    #[command(flatten)]
    pub maps: MapArgs,
    #[command(flatten)]
    pub reading: ReadingArgs,
}

#[derive(Args)]
#[command(next_help_heading = "How closely to look")]
pub struct LookArgs {
    /// Levels to judge: 3, 1-6, or 1,4- [default: all]
    #[arg(long, value_name = "LEVELS", value_parser = LevelList::from_str)]
    pub levels: Option<LevelList>,
    /// Texels judged in each level at most: a number, or all
    #[arg(long, value_name = "N|all", default_value = "64", value_parser = texels)]
    pub texels: usize,
    /// Half vectors drawn from each footprint
    #[arg(long, value_name = "N", default_value = "80", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub directions: u32,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value = "1")]
    pub seed: u64,
    /// Look at N texels of each footprint at most [default: at all of them]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub subset: Option<u32>,
    /// What lies between the centres of the texels of level 0
    #[arg(long, value_enum, default_value = "constant")]
    pub interpolation: InterpolationArg,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum InterpolationArg {
    /// Each texel is a square of one lobe
    Constant,
    /// Normals and roughness are interpolated, with --wrap at the border
    Bilinear,
}

/// A fold by name, or every one.
#[derive(Clone, Copy)]
pub enum FoldChoice {
    All,
    One(&'static Fold),
}

fn fold_choice(name: &str) -> std::result::Result<FoldChoice, String> {
    if name == "all" { Ok(FoldChoice::All) } else { fold_name(name).map(FoldChoice::One) }
}

fn texels(text: &str) -> std::result::Result<usize, String> {
    match text {
        "all" => Ok(usize::MAX),
        _ => text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "expected a number from 1 up, or all".into()),
    }
}

/// Ranges of levels.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelList {
    text: String,
    ranges: Vec<RangeInclusive<usize>>,
}

impl FromStr for LevelList {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let expected = || format!("'{text}': expected levels, as 3, 1-6 or 1,4-");
        let ranges = text.split(',').map(level_range).collect::<Option<Vec<_>>>().ok_or_else(expected)?;
        Ok(Self { text: text.into(), ranges })
    }
}

impl LevelList {
    /// The levels of a texture that are listed, in order.
    fn of(&self, size: Size) -> Result<Vec<usize>> {
        let count = size.level_count();
        let within = |k: &usize| self.ranges.iter().any(|range| range.contains(k));
        if self.ranges.iter().any(|range| *range.start() >= count) {
            let expected = format!("levels from 0 to {}, as {size} has", count - 1);
            return Err(Error::invalid_option("--levels", self.text.clone(), expected));
        }
        Ok((0..count).filter(within).collect())
    }
}

impl LookArgs {
    /// As the judge takes it.
    pub fn settings(&self, size: Size, reading: &ReadingArgs) -> Result<Settings> {
        let interpolation = match self.interpolation {
            InterpolationArg::Constant => Interpolation::Constant,
            InterpolationArg::Bilinear => Interpolation::Bilinear { per_side: PER_SIDE, wrap: reading.wrap() },
        };
        Ok(Settings {
            texels: (self.texels < usize::MAX).then_some(self.texels),
            directions: self.directions as usize,
            reading: Reading { interpolation, most_texels: self.subset.map(|n| n as usize) },
            levels: self.levels.as_ref().map(|levels| levels.of(size)).transpose()?.unwrap_or_default(),
            seed: self.seed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines that are aligned by hand must not be broken again; keys that the parser knows are listed.
    #[test]
    fn help_fits_a_terminal() {
        let help = after_help();
        let aligned: Vec<&str> = help.lines().filter(|line| line.starts_with(' ')).collect();
        assert!(aligned.len() > 15 && aligned.iter().all(|line| line.chars().count() <= 80), "{help}");
        for key in crate::cli::chains::KEYS.split(", ") {
            assert!(
                help.contains(&format!(" {key},")) || help.contains(&format!(" {key}.")) || key == "roughness",
                "{key}"
            );
        }
    }

    #[test]
    fn levels_are_read_as_written() {
        let of = |text: &str| text.parse::<LevelList>().unwrap().of(Size::new(64, 16)).ok();
        assert_eq!(of("3"), Some(vec![3]));
        assert_eq!(of("1-3"), Some(vec![1, 2, 3]));
        assert_eq!(of("4-,1,4"), Some(vec![1, 4, 5, 6]));
        assert_eq!(of("5-99"), Some(vec![5, 6]));
        assert_eq!(of("7"), None);
        assert_eq!(of("0,7-"), None);
        for wrong in ["", "x", "1-x", "-1", "3-1", "1,,2", "1-2-3"] {
            assert!(wrong.parse::<LevelList>().is_err(), "{wrong}");
        }
    }
}
