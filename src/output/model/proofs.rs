//! Level 0 of new textures beside the images that they stem from: what is not folded must not change.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::image::{Raster, Size, from_rows};
use crate::material::{Encoding, Origin};
use crate::output::sheet::{Sheet, Source};
use crate::output::{ChangeTexel, Rows};

/// A channel of a texture at level 0, before it is compressed, beside the same channel of the image that it stems from.
#[derive(Clone, Debug, Serialize)]
pub struct Proof {
    /// r, g or b.
    pub channel: char,
    /// SHA-256 of the samples in the image.
    pub before: String,
    /// And in the texture, as many bits each.
    pub after: String,
    /// Whether they are the same.
    pub identical: bool,
}

/// The channels of a picture as they were read.
pub struct Seen {
    path: PathBuf,
    pub size: Size,
    bits: u8,
    /// SHA-256 of each.
    channels: Vec<String>,
}

impl Seen {
    pub fn new(path: &Path, picture: &Raster) -> Self {
        let (size, bits) = (picture.size(), picture.bits());
        let channel = |c| digest(size, bits, |y, row| picture.read(c, y, 0, row));
        let channels = (0..picture.channels.len()).into_par_iter().map(channel).collect();
        Self { path: path.to_owned(), size, bits, channels }
    }
}

/// What level 0 has become, channel by channel.
pub fn proofs(rows: &Rows, sheet: &Sheet, seen: &[Seen], change: ChangeTexel) -> Vec<Proof> {
    let channels = sheet.channels.len();
    let proof = |(i, (_, source)): (usize, &(String, Source))| {
        let Source::Channel { map, channel, .. } = *source else { return None };
        let Origin::File { path, .. } = &rows.material.maps[map].origin else { return None };
        let seen = seen.iter().find(|seen| seen.path == *path)?;
        let size = rows.size(0);
        let after = digest(size, seen.bits, |y, out| {
            let read = |channel: usize, _, row: &mut [f32]| rows.row(0, channel, Encoding::Unsigned, y, 0, row);
            let mut texels = from_rows(Size::new(size.width, 1), channels, read);
            for (out, texel) in out.iter_mut().zip(texels.as_slice_mut().expect("just made").chunks_exact_mut(channels))
            {
                change(texel);
                *out = texel[i];
            }
        });
        let before = seen.channels[channel].clone();
        Some(Proof { channel: ['r', 'g', 'b'][i], identical: before == after, before, after })
    };
    sheet.channels.iter().enumerate().filter_map(proof).collect()
}

/// SHA-256 of the samples of a channel, little-endian; `read` gives its rows.
fn digest(size: Size, bits: u8, mut read: impl FnMut(usize, &mut [f32])) -> String {
    let mut hash = Sha256::new();
    let (mut row, mut bytes) = (vec![0.0; size.width], Vec::new());
    for y in 0..size.height {
        read(y, &mut row);
        bytes.clear();
        match bits {
            8 => bytes.extend(row.iter().map(|v| (v * 255.0).round() as u8)),
            16 => bytes.extend(row.iter().flat_map(|v| ((v * 65535.0).round() as u16).to_le_bytes())),
            _ => bytes.extend(row.iter().flat_map(|v| v.to_le_bytes())),
        }
        hash.update(&bytes);
    }
    format!("{:x}", hash.finalize())
}
