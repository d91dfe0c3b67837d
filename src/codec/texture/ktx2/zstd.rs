//! Zstandard (RFC 8878), written by one crate and read by another.

use std::fmt::Display;
use std::io::Read;

use rusty_zstd::{CompressOptions, compress_with};
use ruzstd::decoding::StreamingDecoder;

use super::Effort;

/// A frame that says how long its content is, for simple decoders allocate as much, and has its checksum.
///
/// Encoder and decoder are of different authors: what both agree on is no mistake of one.
///
/// # Errors
/// That they do not.
pub(super) fn pack(data: &[u8], effort: Effort) -> Result<Vec<u8>, String> {
    let level = match effort {
        Effort::Fast => 6,
        Effort::Slow => 18,
    };
    let frame = compress_with(data, CompressOptions { level, checksum: true }).map_err(words)?;
    if unpack(&frame, data.len())? == data { Ok(frame) } else { Err("it does not unpack to what it is made of".into()) }
}

/// The content of frames, several of which may follow each other.
///
/// # Errors
/// What is wrong with them, in words; or that they do not hold `length` bytes.
pub(super) fn unpack(mut data: &[u8], length: usize) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::new();
    unpacked.try_reserve_exact(length).map_err(words)?;
    while unpacked.len() <= length && !data.is_empty() {
        let mut frame = StreamingDecoder::new(&mut data).map_err(words)?;
        // One byte more, to see whether there is more.
        let most = (length - unpacked.len()) as u64 + 1;
        frame.by_ref().take(most).read_to_end(&mut unpacked).map_err(words)?;
        let sum = frame.decoder.get_checksum_from_data();
        if unpacked.len() <= length && sum.is_some() && sum != frame.decoder.get_calculated_checksum() {
            return Err("its checksum is not that of its content".into());
        }
    }
    if unpacked.len() == length { Ok(unpacked) } else { Err(format!("it does not unpack to {length} bytes")) }
}

fn words(error: impl Display) -> String {
    error.to_string()
}
