//! BC7, by the `block_compression` crate.

use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};

use super::Effort;

/// Encodes four rows of RGBA, a multiple of 4 texels wide, to a row of blocks. `opaque` rows have an alpha of 1; it
/// comes back as 1 or 254/255, for in one of the modes all channels of an end share their lowest bit.
pub(super) fn encode(strip: &[u8], opaque: bool, effort: Effort, blocks: &mut [u8]) {
    let settings = match (effort, opaque) {
        (Effort::Fast, true) => BC7Settings::opaque_ultra_fast(),
        (Effort::Fast, false) => BC7Settings::alpha_ultrafast(),
        (Effort::Slow, true) => BC7Settings::opaque_fast(),
        (Effort::Slow, false) => BC7Settings::alpha_fast(),
    };
    let stride = (strip.len() / 4) as u32;
    compress_rgba8(CompressionVariant::BC7(settings), strip, blocks, stride / 4, 4, stride);
}
