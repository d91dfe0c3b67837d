//! Scales of end values, and weights between them, as ASTC has them (Khronos Data Format 1.4, sections 23.13 and 23.17).

/// The values that an end may have: `base << bits` of them, each coded as a few bits below a digit of base 1, 3 or 5.
pub(super) struct Scale {
    pub(super) bits: u32,
    pub(super) base: u8,
    /// Number of values.
    pub(super) count: usize,
    /// 0 to 255, by code.
    pub(super) of_code: [u8; 256],
    /// Codes, by rank: their values ascend.
    pub(super) codes: [u8; 256],
    /// Values, by rank.
    pub(super) values: [u8; 256],
    /// Rank of the value nearest to 0 to 255.
    pub(super) nearest: [u8; 256],
}

pub(super) static OF_12: Scale = Scale::new(2, 3);
pub(super) static OF_16: Scale = Scale::new(4, 1);
pub(super) static OF_32: Scale = Scale::new(5, 1);
pub(super) static OF_40: Scale = Scale::new(3, 5);
pub(super) static OF_48: Scale = Scale::new(4, 3);
pub(super) static OF_160: Scale = Scale::new(5, 5);
pub(super) static OF_192: Scale = Scale::new(6, 3);
pub(super) static OF_256: Scale = Scale::new(8, 1);

impl Scale {
    const fn new(bits: u32, base: u8) -> Self {
        let count = (base as usize) << bits;
        let (mut of_code, mut code_of) = ([0; 256], [None; 256]);
        let mut code = 0;
        while code < count {
            of_code[code] = unquantised(bits, base, code as u32);
            code_of[of_code[code] as usize] = Some(code as u8);
            code += 1;
        }
        let (mut codes, mut values) = ([0; 256], [0; 256]);
        let (mut rank, mut value) = (0, 0);
        while value < 256 {
            if let Some(code) = code_of[value] {
                (codes[rank], values[rank]) = (code, value as u8);
                rank += 1;
            }
            value += 1;
        }
        assert!(rank == count, "no two codes have the same value");
        let mut nearest = [0; 256];
        (rank, value) = (0, 0);
        while value < 256 {
            while rank + 1 < count && 2 * value > values[rank] as usize + values[rank + 1] as usize {
                rank += 1;
            }
            nearest[value] = rank as u8;
            value += 1;
        }
        Self { bits, base, count, of_code, codes, values, nearest }
    }

    /// Rank of the value nearest to any number.
    pub(super) fn rank(&self, value: f32) -> u8 {
        self.nearest[(value + 0.5) as u8 as usize]
    }
}

/// The value of a code. Bits alone are repeated downwards; with a digit, the lowest of them mirrors the scale.
const fn unquantised(bits: u32, base: u8, code: u32) -> u8 {
    let low = code & ((1 << bits) - 1);
    let half = low >> 1;
    let (b, c) = match (base, bits) {
        (1, 4) => return (low * 0x11) as u8,
        (1, 5) => return (low << 3 | low >> 2) as u8,
        (1, 8) => return low as u8,
        (3, 2) => (half * 0b1_0001_0110, 93),
        (3, 4) => (half << 6 | half, 22),
        (3, 6) => (half << 4 | half >> 4, 5),
        (5, 3) => (half << 7 | half << 1 | half >> 1, 26),
        (5, 5) => (half << 5 | half >> 3, 6),
        _ => panic!("not a scale of UASTC"),
    };
    let mirror = if low & 1 == 1 { 0x1ff } else { 0 };
    let found = ((code >> bits) * c + b) ^ mirror;
    (mirror & 0x80 | found >> 2) as u8
}

/// Weights in 64ths of 1 to 5 bits: repeated to 6 bits, and those above a half one more, so that 63 becomes 64.
pub(super) static WEIGHTS: [[u8; 32]; 6] = {
    let mut weights = [[0; 32]; 6];
    let mut bits = 1;
    while bits <= 5 {
        let mut index = 0;
        while index < 1 << bits {
            let (mut six, mut have) = (index as u32, bits as u32);
            while have < 6 {
                six = six << bits | index as u32;
                have += bits as u32;
            }
            six >>= have - 6;
            weights[bits][index] = (six + if six > 32 { 1 } else { 0 }) as u8;
            index += 1;
        }
        bits += 1;
    }
    weights
};

/// What lies between two ends: made of 16 bit each, of which the upper 8 are kept.
pub(super) fn between(low: u8, high: u8, weight: u8) -> u8 {
    let (low, high, weight) = (u32::from(low) * 257, u32::from(high) * 257, u32::from(weight));
    ((low * (64 - weight) + high * weight + 32) >> 14) as u8
}
