//! The text beside the maps.

use super::{Preset, Written};

pub fn readme(preset: &Preset, written: &Written) -> String {
    format!("{} for {}\n", written.material, preset.engine)
}
