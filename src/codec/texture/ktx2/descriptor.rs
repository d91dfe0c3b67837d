//! The data format descriptor of KTX 2: what the bits of a texel or of a block mean (Khronos Data Format 1.4, chapter 5).

use std::num::NonZeroU8;

use ::ktx2::dfd::{Basic, Block, ChannelTypeQualifiers, DataFormatFlags, SampleInformation};
use ::ktx2::{ColorModel, Format, TransferFunction};
use rayon::prelude::*;

use crate::codec::texture::{Texture, uastc};

/// The data format descriptor with its length.
pub(super) fn write(texture: &Texture) -> Vec<u8> {
    let linear = Some(TransferFunction::Linear);
    let mut basic = match texture.format.vk_format().and_then(Format::new) {
        Some(number) => Basic::from_format_with(number, false, linear, None, None).expect("a common format").0,
        None => universal(texture),
    };
    // Not the primaries of a display: these are no colours.
    basic.color_primaries = None;
    let block = Block::Basic(basic).to_vec();
    [&(block.len() as u32 + 4).to_le_bytes(), block.as_slice()].concat()
}

/// Of UASTC: one sample of 128 bit, whatever its channels are (KTX 2.0.4, 3.10.2; Khronos Data Format 1.4, 5.6.15).
fn universal(texture: &Texture) -> Basic {
    let has_alpha = texture.levels.par_iter().any(|level| level.as_chunks().0.iter().any(uastc::has_alpha));
    let side = NonZeroU8::new(4).expect("4 is not 0");
    let one = NonZeroU8::MIN;
    Basic {
        color_model: Some(ColorModel::UASTC),
        color_primaries: None,
        transfer_function: Some(TransferFunction::Linear),
        flags: DataFormatFlags::STRAIGHT_ALPHA,
        texel_block_dimensions: [side, side, one, one],
        bytes_planes: [16, 0, 0, 0, 0, 0, 0, 0],
        sample_information: vec![SampleInformation {
            bit_offset: 0,
            bit_length: NonZeroU8::new(128).expect("128 is not 0"),
            channel_type: if has_alpha { RGBA } else { RGB },
            channel_type_qualifiers: ChannelTypeQualifiers::empty(),
            sample_positions: [0; 4],
            lower: 0,
            upper: u32::MAX,
        }],
    }
}

/// Channels of UASTC: of three, of four, and two of which the second is in alpha.
const RGB: u8 = 0;
const RGBA: u8 = 3;
const RRRG: u8 = 5;

/// Where a descriptor has its colour model: after its length and two words of a block's header.
const MODEL_AT: usize = 12;
/// Where it has its transfer function.
const TRANSFER_AT: usize = 14;
/// Where it has the channel of its first sample.
const CHANNEL_AT: usize = 31;

/// The colour model that a descriptor tells, if it is long enough and the model known.
pub(super) fn model(descriptor: &[u8]) -> Option<ColorModel> {
    descriptor.get(MODEL_AT).and_then(|model| ColorModel::new(*model))
}

/// Whether texels are said to be sRGB.
pub(super) fn is_srgb(descriptor: &[u8]) -> bool {
    descriptor.get(TRANSFER_AT) == Some(&TransferFunction::SRGB.value())
}

/// Whether UASTC is said to have its second channel in alpha.
pub(super) fn has_second_in_alpha(descriptor: &[u8]) -> bool {
    descriptor.get(CHANNEL_AT).is_some_and(|channel| channel & 15 == RRRG)
}
