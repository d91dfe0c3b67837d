//! The lobes after the first, from their own maps.

use std::path::{Path, PathBuf};

use super::{Maps, ONE_LOBE_AT_LEVEL_0, read};
use crate::error::{Error, Result};
use crate::material::{ChannelRef, Inputs};
use crate::ndf::{Form, Lobe, Lobes};

/// The weights of three lobes, each rounded up by half a step of 8 bits, may sum to this much more than 1. Ours do not.
const ROUNDING: f32 = 1.5 / 255.0;

/// A further lobe of a chain: its normals and widths are read as if it were a chain of its own.
pub(super) struct FurtherLobe {
    /// Its maps.
    pub inputs: Inputs,
    /// Where its weight is.
    pub weight: ChannelRef,
}

/// The levels of a chain with further lobes. The first lobe has the weight that they leave.
///
/// # Errors
/// As [`read`]; weights below 0, or that leave less than nothing; a weight at level 0.
pub(super) fn mixed(first: Vec<Lobes>, further: &[FurtherLobe], maps: &Maps) -> Result<Vec<Lobes>> {
    let mut slots = vec![first];
    for lobe in further {
        slots.push(read(&lobe.inputs, maps)?.levels);
    }
    let two = slots.iter().any(|levels| levels[0].form() == Form::Anisotropic);
    let form = if two { Form::Anisotropic } else { Form::Isotropic };
    let mut levels = vec![slots[0][0].clone().in_form(form)];
    for k in 0..slots[0].len() {
        let size = slots[0][k].size();
        let mut weights = Vec::new();
        let mut files: Vec<PathBuf> = Vec::new();
        for ChannelRef { path, channel } in further.iter().map(|lobe| &lobe.weight) {
            let (file, channel) = (maps.file(path, k), channel.unwrap_or(0));
            let raster = maps.picture(&file, k)?.raster;
            let mut plane = vec![0.0; size.texels()];
            for (y, row) in plane.chunks_exact_mut(size.width).enumerate() {
                raster.read(channel, y, 0, row);
            }
            weights.push(plane);
            files.push(file);
        }
        for i in 0..size.texels() {
            sound(&weights, i, k).map_err(|(j, found, expected)| {
                let found = format!("{found} at column {}, row {} of level {k}", i % size.width, i / size.width);
                Error::invalid(Path::new(&files[j]), found, expected)
            })?;
        }
        if k > 0 {
            levels.push(Lobes::mixed_from_fn(form, slots.len(), size, |j, x, y| {
                let lobe: Lobe = slots[j][k].at(x, y);
                let others: f32 = weights.iter().map(|plane| plane[y * size.width + x]).sum();
                // Where rounding leaves less than nothing, the others share what there is.
                let weight = if j == 0 { 1.0 - others } else { weights[j - 1][y * size.width + x] };
                (lobe, weight.max(0.0) / others.max(1.0))
            }));
        }
    }
    Ok(levels)
}

/// What is wrong with the weights of a texel: of which lobe, what, and what would be right.
fn sound(weights: &[Vec<f32>], i: usize, level: usize) -> std::result::Result<(), (usize, String, &'static str)> {
    let mut sum = 0.0;
    for (j, plane) in weights.iter().enumerate() {
        let weight = plane[i];
        sum += weight;
        if !(weight >= 0.0 && sum <= 1.0 + ROUNDING) {
            return Err((j, format!("weight {weight}"), "weights of further lobes from 0 up, that sum to 1 at most"));
        }
        if level == 0 && weight > 0.0 {
            return Err((j, format!("weight {weight}"), ONE_LOBE_AT_LEVEL_0));
        }
    }
    Ok(())
}
