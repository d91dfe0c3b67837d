//! Which files a build writes.

use std::path::Path;

use clap::{Args, ValueEnum};

use crate::codec::Depth;
use crate::codec::texture::Effort;
use crate::image::Sides;
use crate::output::preset::{Compress, PRESETS, Preset};
use crate::output::{Format, Request};

#[derive(Args)]
pub struct ContainerArgs {
    /// Write what an engine loads: container, compression, packing and the green of normals, and a README.txt that says how
    /// to load it; mipfold presets lists them
    #[arg(long, value_name = "ENGINE", value_parser = preset)]
    pub preset: Option<&'static Preset>,
    /// Container: png (a file a level), exr (mip-mapped, and the lobes in full), ktx2 or dds (a texture for GPUs with its
    /// mips); may be repeated [default: png, or what the preset wants]
    #[arg(long, value_enum, value_delimiter = ',', hide_possible_values = true, value_name = "png|exr|ktx2|dds")]
    pub format: Vec<Format>,
    /// Write 32-bit floats where --format exr writes 16-bit ones
    #[arg(long)]
    pub float: bool,
    /// Texels of ktx2 and dds: bc (BC5 for normals, BC4 for one channel, BC7 for more), uastc (ktx2 only; for the web), or
    /// none [default: bc, or what the preset wants]
    #[arg(long, value_enum, hide_possible_values = true, value_name = "none|bc|uastc")]
    pub compress: Option<Compress>,
    /// Time that compression may take: slow is for what ships
    #[arg(long, value_enum, default_value = "fast")]
    pub effort: EffortArg,
    /// Write DDS with the header of DirectX 9, uncompressed and in 8 bit, which older readers want (three.js' DDSLoader,
    /// Unreal before its new importer)
    #[arg(long)]
    pub dds9: bool,
    /// Enlarge all maps until their sides are multiples of 4, or powers of two (pot), as engines and compression want them
    #[arg(long, value_enum, default_value = "keep", hide_possible_values = true, value_name = "4|pot")]
    pub resize: Sides,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum EffortArg {
    Fast,
    Slow,
}

impl ContainerArgs {
    /// What is to be written into a folder.
    pub fn request(&self, folder: &Path, force: bool) -> Request {
        let plain = Request::new(folder);
        let wanted = self.preset.map_or_else(|| plain.formats.clone(), |preset| vec![preset.format]);
        let mut formats: Vec<Format> = Vec::new();
        for format in if self.format.is_empty() { &wanted } else { &self.format } {
            if !formats.contains(format) {
                formats.push(*format);
            }
        }
        Request {
            formats,
            depth: if self.float { Depth::Float } else { Depth::Half },
            resize: self.resize,
            compress: self.compress.or(self.preset.map(|preset| preset.compress)).unwrap_or_default(),
            preset: self.preset,
            effort: match self.effort {
                EffortArg::Fast => Effort::Fast,
                EffortArg::Slow => Effort::Slow,
            },
            dds9: self.dds9,
            force,
            ..plain
        }
    }
}

fn preset(name: &str) -> Result<&'static Preset, String> {
    Preset::by_name(name).map_err(|_| {
        let names: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
        format!("expected one of {}", names.join(", "))
    })
}
