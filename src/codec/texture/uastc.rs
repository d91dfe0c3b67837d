//! UASTC LDR 4x4: blocks of 4x4 texels of 8 bit in 16 bytes that are turned into whatever blocks a GPU samples, when they
//! are loaded. What `KHR_texture_basisu` of glTF asks for, inside KTX 2.
//!
//! A block holds ends of lines through colour space and where each texel lies between them, as ASTC does, but in one of
//! 19 ways that BC7 has too, and hints for the way to ETC1 (Binomial, UASTC LDR 4x4 Texture Specification; Khronos Data
//! Format 1.4, chapter 25). Ends and weights are those of ASTC (Khronos Data Format 1.4, sections 23.12 to 23.19).
//!
//! All of the 19 are read. Written are solid blocks, and lines of three or four channels: one through all texels, two
//! through the two sides of a pattern, or one channel apart from the others. Not written are those of gray and alpha, and
//! of three lines.

mod bits;
mod block;
mod encode;
mod fit;
mod hints;
mod scale;
mod statistics;

#[cfg(test)]
mod tests;

pub(super) use block::{decode, has_alpha, is_valid};
pub(super) use encode::encode;

/// Texels of a block, row by row.
type Texels = [[u8; 4]; 16];
