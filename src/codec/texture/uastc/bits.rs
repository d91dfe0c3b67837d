//! Fields of a block: from its lowest bit upwards.

/// Reads fields one after the other.
pub(super) struct Reader {
    rest: u128,
}

impl Reader {
    pub(super) fn new(block: &[u8; 16]) -> Self {
        Self { rest: u128::from_le_bytes(*block) }
    }

    /// The next `count` bits, up to 8.
    pub(super) fn take(&mut self, count: u32) -> u8 {
        let field = (self.rest & ((1 << count) - 1)) as u8;
        self.rest >>= count;
        field
    }
}

/// Writes fields one after the other.
#[derive(Default)]
pub(super) struct Writer {
    bits: u128,
    length: u32,
}

impl Writer {
    /// Adds `count` bits.
    pub(super) fn put(&mut self, field: u8, count: u32) {
        debug_assert!(u32::from(field) >> count == 0 && self.length + count <= 128);
        self.bits |= u128::from(field) << self.length;
        self.length += count;
    }

    /// The block; bits that were not written are 0.
    pub(super) fn block(&self) -> [u8; 16] {
        self.bits.to_le_bytes()
    }
}
