//! How texels lie in memory, and what they are as samples: of the formats written here and of more that are only read.

use half::f16;
use ndarray::Array3;
use rayon::prelude::*;

use super::uastc;
use crate::image::{Raster, Samples, Size};

/// How the samples of a texel, or of a block, are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Unorm8,
    Snorm8,
    Unorm16,
    Snorm16,
    Half,
    Float,
    Bc1,
    Bc3,
    Bc4,
    Bc4Signed,
    Bc5,
    Bc5Signed,
    Bc7,
    Uastc,
}

impl Kind {
    /// Bytes of a block, or else of a sample.
    fn bytes(self) -> usize {
        match self {
            Kind::Unorm8 | Kind::Snorm8 => 1,
            Kind::Unorm16 | Kind::Snorm16 | Kind::Half => 2,
            Kind::Float => 4,
            Kind::Bc1 | Kind::Bc4 | Kind::Bc4Signed => 8,
            Kind::Bc3 | Kind::Bc5 | Kind::Bc5Signed | Kind::Bc7 | Kind::Uastc => 16,
        }
    }

    fn is_block(self) -> bool {
        !matches!(self, Kind::Unorm8 | Kind::Snorm8 | Kind::Unorm16 | Kind::Snorm16 | Kind::Half | Kind::Float)
    }
}

/// Samples of a texel, and which of them are wanted as channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    kind: Kind,
    /// Samples a texel has in memory.
    stored: usize,
    /// Where each channel is among them.
    order: [u8; 4],
    /// Channels wanted.
    channels: usize,
}

impl Layout {
    /// Channels as they are stored.
    pub(super) const fn plain(kind: Kind, channels: usize) -> Self {
        Self { kind, stored: channels, order: [0, 1, 2, 3], channels }
    }

    /// Blue first, of `stored` samples; the last `stored - channels` mean nothing.
    pub(super) const fn bgr(stored: usize, channels: usize) -> Self {
        Self { kind: Kind::Unorm8, stored, order: [2, 1, 0, 3], channels }
    }

    /// Some of the samples, in an order of their own.
    pub(super) fn ordered(kind: Kind, stored: usize, order: &[u8]) -> Self {
        let mut all = [0; 4];
        all[..order.len()].copy_from_slice(order);
        Self { kind, stored, order: all, channels: order.len() }
    }

    pub(super) fn block_side(self) -> usize {
        if self.kind.is_block() { 4 } else { 1 }
    }

    /// Bytes of a block, or of a texel where there are no blocks.
    pub(super) fn block_bytes(self) -> usize {
        if self.kind.is_block() { self.kind.bytes() } else { self.kind.bytes() * self.stored }
    }

    fn row_bytes(self, size: Size) -> usize {
        size.width.div_ceil(self.block_side()) * self.block_bytes()
    }

    pub(super) fn bytes(self, size: Size) -> usize {
        self.row_bytes(size) * size.height.div_ceil(self.block_side())
    }

    /// Bytes of a texel once decoded.
    pub(super) fn sample_bytes(self) -> usize {
        self.channels
            * match self.kind {
                Kind::Unorm8 | Kind::Bc1 | Kind::Bc3 | Kind::Bc7 | Kind::Uastc => 1,
                Kind::Unorm16 | Kind::Bc4 | Kind::Bc5 => 2,
                _ => 4,
            }
    }

    /// The first block that is none, of a format that does not give every one a meaning.
    pub(super) fn no_block(self, bytes: &[u8]) -> Option<usize> {
        match self.kind {
            Kind::Uastc => bytes.as_chunks::<16>().0.par_iter().position_first(|block| !uastc::is_valid(block)),
            _ => None,
        }
    }

    /// The samples: 8 and 16 bit as they are, signed integers and floats as floats, BC4 and BC5 as 16 bit.
    pub(super) fn decode(self, bytes: &[u8], size: Size) -> Raster {
        assert_eq!(bytes.len(), self.bytes(size), "bytes of {size} texels");
        let le16 = |b: &[u8]| u16::from_le_bytes([b[0], b[1]]);
        let samples = match self.kind {
            Kind::Unorm8 => Samples::U8(self.texels(bytes, size, |b| b[0])),
            Kind::Snorm8 => Samples::F32(self.texels(bytes, size, |b| snorm(b[0].cast_signed().into(), 127.0))),
            Kind::Unorm16 => Samples::U16(self.texels(bytes, size, le16)),
            Kind::Snorm16 => Samples::F32(self.texels(bytes, size, |b| snorm(le16(b).cast_signed().into(), 32767.0))),
            Kind::Half => Samples::F32(self.texels(bytes, size, |b| f16::from_bits(le16(b)).to_f32())),
            Kind::Float => Samples::F32(self.texels(bytes, size, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
            Kind::Bc1 => Samples::U8(self.blocks(bytes, size, 4, |block, out| bcdec_rs::bc1(block, out, 16))),
            Kind::Bc3 => Samples::U8(self.blocks(bytes, size, 4, |block, out| bcdec_rs::bc3(block, out, 16))),
            Kind::Bc7 => Samples::U8(self.blocks(bytes, size, 4, |block, out| bcdec_rs::bc7(block, out, 16))),
            Kind::Uastc => Samples::U8(self.blocks(bytes, size, 4, |block, out| {
                let block = block.first_chunk().expect("a block has 16 bytes");
                out.copy_from_slice(uastc::decode(block).as_flattened());
            })),
            Kind::Bc4 | Kind::Bc5 => Samples::U16(self.blocks(bytes, size, self.stored, |block, out| {
                let mut values = [0.0; 32];
                self.channel_blocks(block, &mut values);
                out.iter_mut().zip(values).for_each(|(out, v)| *out = (v * 65535.0 + 0.5) as u16);
            })),
            Kind::Bc4Signed | Kind::Bc5Signed => {
                Samples::F32(self.blocks(bytes, size, self.stored, |block, out| self.channel_blocks(block, out)))
            }
        };
        let names: &[&str] = match self.channels {
            1 => &["Y"],
            n => &["R", "G", "B", "A"][..n],
        };
        Raster { samples, channels: names.iter().map(|name| (*name).to_owned()).collect() }
    }

    fn channel_blocks(self, block: &[u8], out: &mut [f32]) {
        let signed = matches!(self.kind, Kind::Bc4Signed | Kind::Bc5Signed);
        if self.stored == 1 {
            bcdec_rs::bc4_float(block, out, 4, signed);
        } else {
            bcdec_rs::bc5_float(block, out, 8, signed);
        }
    }

    fn texels<T: Copy + Default + Send>(
        self,
        bytes: &[u8],
        size: Size,
        sample: impl Fn(&[u8]) -> T + Sync,
    ) -> Array3<T> {
        let (length, texel) = (self.kind.bytes(), self.block_bytes());
        let mut samples = vec![T::default(); size.texels() * self.channels];
        let rows = samples.par_chunks_exact_mut(size.width * self.channels);
        rows.zip(bytes.par_chunks_exact(self.row_bytes(size))).for_each(|(row, bytes)| {
            for (out, texel) in row.chunks_exact_mut(self.channels).zip(bytes.chunks_exact(texel)) {
                for (out, from) in out.iter_mut().zip(self.order) {
                    *out = sample(&texel[usize::from(from) * length..]);
                }
            }
        });
        self.array(size, samples)
    }

    /// `decode` makes 16 texels of `decoded` samples from a block.
    fn blocks<T: Copy + Default + Send>(
        self,
        bytes: &[u8],
        size: Size,
        decoded: usize,
        decode: impl Fn(&[u8], &mut [T]) + Sync,
    ) -> Array3<T> {
        let mut samples = vec![T::default(); size.texels() * self.channels];
        // The last row of blocks may have fewer than four rows of texels.
        let strips = samples.par_chunks_mut(4 * size.width * self.channels);
        strips.zip(bytes.par_chunks_exact(self.row_bytes(size))).for_each(|(strip, bytes)| {
            let mut texels = vec![T::default(); 16 * decoded];
            for (x, block) in (0..).step_by(4).zip(bytes.chunks_exact(self.block_bytes())) {
                decode(block, &mut texels);
                let rows = strip.chunks_exact_mut(size.width * self.channels);
                for (row, texels) in rows.zip(texels.chunks_exact(4 * decoded)) {
                    let row = row[x * self.channels..].chunks_exact_mut(self.channels);
                    row.zip(texels.chunks_exact(decoded))
                        .for_each(|(to, from)| to.copy_from_slice(&from[..self.channels]));
                }
            }
        });
        self.array(size, samples)
    }

    fn array<T>(self, size: Size, samples: Vec<T>) -> Array3<T> {
        Array3::from_shape_vec((size.height, size.width, self.channels), samples).expect("made for this size")
    }
}

/// -1 to 1; the least integer is -1 too (Vulkan 1.3, 3.10.1).
fn snorm(value: f32, most: f32) -> f32 {
    (value / most).max(-1.0)
}
