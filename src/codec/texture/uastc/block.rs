//! The 19 modes, and a block of each taken apart, put together and decoded.

use super::Texels;
use super::bits::{Reader, Writer};
use super::hints::Hints;
use super::scale::{self, Scale, WEIGHTS, between};

/// How a block of a mode is laid out.
pub(super) struct Mode {
    /// The bits it starts with, and how many.
    code: u8,
    pub(super) code_bits: u32,
    pub(super) weight_bits: u32,
    pub(super) scale: &'static Scale,
    /// The texels' shares of lines: one for all, or a pattern.
    pub(super) patterns: Patterns,
    /// One channel has weights of its own.
    pub(super) dual: bool,
    /// Two are gray and alpha.
    pub(super) channels: usize,
    /// Modes 10 to 12 are short of bits: one hint for BC1, and none how to move ETC1's colours.
    pub(super) few_hints: bool,
}

/// Which line of several a texel lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Patterns {
    None,
    /// Those that ASTC and BC7 have in common.
    Two,
    /// Those of ASTC that two of BC7's three sets make.
    TwoOfThree,
    Three,
}

/// A solid colour, which has a layout of its own.
pub(super) const SOLID: usize = 8;

#[rustfmt::skip]
pub(super) static MODES: [Mode; 19] = {
    use Patterns::{None, Three, Two, TwoOfThree};
    const fn mode(
        code: u8, code_bits: u32, weight_bits: u32, scale: &'static Scale, patterns: Patterns, dual: bool, channels: usize,
    ) -> Mode {
        Mode { code, code_bits, weight_bits, scale, patterns, dual, channels, few_hints: false }
    }
    const fn few(mode: Mode) -> Mode {
        Mode { few_hints: true, ..mode }
    }
    [
        mode(0b0001,    4, 4, &scale::OF_192, None,       false, 3),
        mode(0b110101,  6, 2, &scale::OF_256, None,       false, 3),
        mode(0b11101,   5, 3, &scale::OF_16,  Two,        false, 3),
        mode(0b00011,   5, 2, &scale::OF_12,  Three,      false, 3),
        mode(0b10011,   5, 2, &scale::OF_40,  Two,        false, 3),
        mode(0b01011,   5, 3, &scale::OF_256, None,       false, 3),
        mode(0b11011,   5, 2, &scale::OF_160, None,       true,  3),
        mode(0b00111,   5, 2, &scale::OF_40,  TwoOfThree, false, 3),
        mode(0b10111,   5, 0, &scale::OF_256, None,       false, 4),
        mode(0b01111,   5, 2, &scale::OF_16,  Two,        false, 4),
        few(mode(0b010, 3, 4, &scale::OF_48,  None,       false, 4)),
        few(mode(0b00,  2, 2, &scale::OF_48,  None,       true,  4)),
        few(mode(0b110, 3, 3, &scale::OF_192, None,       false, 4)),
        mode(0b11111,   5, 1, &scale::OF_256, None,       true,  4),
        mode(0b01101,   5, 2, &scale::OF_256, None,       false, 4),
        mode(0b0000101, 7, 4, &scale::OF_256, None,       false, 2),
        mode(0b010101,  6, 2, &scale::OF_256, Two,        false, 2),
        mode(0b100101,  6, 2, &scale::OF_256, None,       true,  2),
        mode(0b1001,    4, 5, &scale::OF_32,  None,       false, 3),
    ]
};

/// A bit for each texel, the first of the block the lowest: on the second line or not.
pub(super) static TWO: [u16; 30] = [
    0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f, 0xc800, 0x0013, 0xfe80, 0x17ff, 0x0017, 0x00ff,
    0xfff0, 0x0fff, 0xff71, 0x8eff, 0x08ce, 0x008c, 0x7310, 0xceff, 0x7331, 0x088c, 0xceef, 0x6666, 0xf00f, 0x5555,
    0x0f0f, 0x36c9,
];

/// Likewise.
pub(super) static TWO_OF_THREE: [u16; 19] = [
    0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8, 0xccce, 0x3c03, 0x00ee, 0x7700, 0x3003, 0x00ce, 0xff80,
    0x6fff, 0x1333, 0x11ff, 0x136c, 0x00ef,
];

/// Two bits for each texel: on the first, second or third line.
static THREE: [u32; 11] = [
    0xa5a5_0000,
    0xaa00_5555,
    0xaa00_0055,
    0x0000_aa55,
    0x2525_2525,
    0x9494_9494,
    0x5858_5858,
    0x5656_0202,
    0x9292_9292,
    0x55aa_0055,
    0xa050_50a0,
];

impl Patterns {
    fn count(self) -> usize {
        match self {
            Patterns::None => 1,
            Patterns::Two => TWO.len(),
            Patterns::TwoOfThree => TWO_OF_THREE.len(),
            Patterns::Three => THREE.len(),
        }
    }

    /// Bits that the number of the pattern takes.
    fn bits(self) -> u32 {
        match self {
            Patterns::None => 0,
            Patterns::Two | Patterns::TwoOfThree => 5,
            Patterns::Three => 4,
        }
    }

    fn lines(self) -> usize {
        match self {
            Patterns::None => 1,
            Patterns::Two | Patterns::TwoOfThree => 2,
            Patterns::Three => 3,
        }
    }

    /// The line that a texel lies on.
    pub(super) fn line(self, pattern: usize, texel: usize) -> usize {
        match self {
            Patterns::None => 0,
            Patterns::Two => usize::from(TWO[pattern] >> texel & 1),
            Patterns::TwoOfThree => usize::from(TWO_OF_THREE[pattern] >> texel & 1),
            Patterns::Three => (THREE[pattern] >> (2 * texel) & 3) as usize,
        }
    }
}

/// A block that is not solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) mode: usize,
    pub(super) pattern: usize,
    /// The channel that has weights of its own, if any has.
    pub(super) apart: Option<usize>,
    /// Codes of the ends of each line, low and high, by channel.
    pub(super) ends: [[[u8; 2]; 4]; 3],
    /// Weights of all channels but the one apart, and of that one.
    pub(super) weights: [[u8; 16]; 2],
}

/// What the bytes of a block say.
pub(super) enum Content {
    Solid([u8; 4]),
    Lines(Block),
}

/// The mode that a block's first bits tell; none if they are none.
fn mode(bytes: &[u8; 16]) -> Option<usize> {
    MODES.iter().position(|mode| bytes[0] & ((1 << mode.code_bits) - 1) == mode.code)
}

/// Whether there is such a block. Most bytes are one: 1 mode in 128 and the last of the patterns do not exist.
pub(in crate::codec::texture) fn is_valid(bytes: &[u8; 16]) -> bool {
    unpack(bytes).is_some()
}

/// Whether a valid block may have an alpha below 1.
pub(in crate::codec::texture) fn has_alpha(bytes: &[u8; 16]) -> bool {
    match unpack(bytes) {
        Some(Content::Solid(colour)) => colour[3] < 255,
        Some(Content::Lines(block)) => MODES[block.mode].channels != 3,
        None => false,
    }
}

/// The texels of a block, row by row; magenta, as ASTC has it, if there is no such block.
pub(in crate::codec::texture) fn decode(bytes: &[u8; 16]) -> Texels {
    match unpack(bytes) {
        Some(Content::Solid(colour)) => [colour; 16],
        Some(Content::Lines(block)) => block.texels(),
        None => [[255, 0, 255, 255]; 16],
    }
}

/// Takes a block apart, but for its hints.
pub(super) fn unpack(bytes: &[u8; 16]) -> Option<Content> {
    let number = mode(bytes)?;
    let mode = &MODES[number];
    let mut fields = Reader::new(bytes);
    fields.take(mode.code_bits);
    if number == SOLID {
        return Some(Content::Solid(std::array::from_fn(|_| fields.take(8))));
    }
    Hints::skip(mode, &mut fields);
    let pattern = usize::from(fields.take(mode.patterns.bits()));
    if pattern >= mode.patterns.count() {
        return None;
    }
    let apart = match (mode.dual, mode.channels) {
        (false, _) => None,
        (true, 2) => Some(3),
        (true, _) => Some(usize::from(fields.take(2))),
    };

    let lines = mode.patterns.lines();
    let mut digits = [0; 24];
    let count = 2 * mode.channels * lines;
    for (digits, bits, base) in groups(mode.scale.base, &mut digits[..count]) {
        let mut packed = fields.take(bits);
        for digit in digits {
            (*digit, packed) = (packed % base, packed / base);
        }
    }
    let mut ends = [[[0; 2]; 4]; 3];
    for (i, digit) in digits[..count].iter().enumerate() {
        let code = fields.take(mode.scale.bits) | if mode.scale.base == 1 { 0 } else { digit << mode.scale.bits };
        ends[i / 2 / mode.channels][i / 2 % mode.channels][i % 2] = code;
    }

    let mut block = Block { mode: number, pattern, apart, ends, weights: [[0; 16]; 2] };
    let anchors = block.anchors();
    for i in 0..16 {
        let bits = mode.weight_bits - u32::from(anchors >> i & 1);
        for plane in 0..if mode.dual { 2 } else { 1 } {
            block.weights[plane][i] = fields.take(bits);
        }
    }
    Some(Content::Lines(block))
}

/// A solid block, without hints.
pub(super) fn pack_solid(colour: [u8; 4], fields: &mut Writer) {
    fields.put(MODES[SOLID].code, MODES[SOLID].code_bits);
    colour.iter().for_each(|value| fields.put(*value, 8));
}

/// Digits go before bits, five of base 3 in 8 bits, three of base 5 in 7; the last group has no more bits than it needs.
/// Each group with its bits and its base.
fn groups(base: u8, digits: &mut [u8]) -> impl Iterator<Item = (&mut [u8], u32, u8)> {
    let (length, bits): (usize, &[u32]) = match base {
        3 => (5, &[0, 2, 4, 5, 7, 8]),
        5 => (3, &[0, 3, 5, 7]),
        _ => (digits.len().max(1), &[]),
    };
    digits.chunks_mut(length).filter(move |_| base > 1).map(move |digits| {
        let count = digits.len();
        (digits, bits[count], base)
    })
}

impl Block {
    /// A bit for each texel that is the first on its line: the uppermost bit of its weight is 0 and not stored.
    fn anchors(&self) -> u16 {
        let patterns = MODES[self.mode].patterns;
        let (mut anchors, mut seen) = (1, 1 << patterns.line(self.pattern, 0));
        for texel in 1..if patterns == Patterns::None { 1 } else { 16 } {
            let line = 1 << patterns.line(self.pattern, texel);
            if seen & line == 0 {
                anchors |= 1 << texel;
                seen |= line;
            }
        }
        anchors
    }

    /// Turns lines round whose first texel lies nearer to their high end, as the format wants it. Says the same
    /// as before.
    pub(super) fn anchor(&mut self) {
        let mode = &MODES[self.mode];
        let most = (1 << mode.weight_bits) - 1;
        let anchors = self.anchors();
        for texel in (0..16).filter(|texel| anchors >> texel & 1 == 1) {
            let line = mode.patterns.line(self.pattern, texel);
            for plane in 0..if mode.dual { 2 } else { 1 } {
                if self.weights[plane][texel] <= most / 2 {
                    continue;
                }
                for c in 0..mode.channels {
                    if (plane == 1) == (self.apart == Some(self.channel(c))) {
                        self.ends[line][c].reverse();
                    }
                }
                for i in (0..16).filter(|i| mode.patterns.line(self.pattern, *i) == line) {
                    self.weights[plane][i] = most - self.weights[plane][i];
                }
            }
        }
    }

    /// The channel of the picture that the ends' channel `c` is (the first, where it is gray).
    fn channel(&self, c: usize) -> usize {
        if MODES[self.mode].channels == 2 { 3 * c } else { c }
    }

    /// The bytes of an anchored block.
    pub(super) fn pack(&self, hints: &Hints) -> [u8; 16] {
        let mode = &MODES[self.mode];
        let mut fields = Writer::default();
        fields.put(mode.code, mode.code_bits);
        hints.put(mode, &mut fields);
        fields.put(self.pattern as u8, mode.patterns.bits());
        if let (Some(apart), 3..) = (self.apart, mode.channels) {
            fields.put(apart as u8, 2);
        }
        let count = 2 * mode.channels * mode.patterns.lines();
        let code = |i: usize| self.ends[i / 2 / mode.channels][i / 2 % mode.channels][i % 2];
        let mut digits: [u8; 18] = [0; 18];
        if mode.scale.base > 1 {
            (0..count).for_each(|i| digits[i] = code(i) >> mode.scale.bits);
        }
        for (digits, bits, base) in groups(mode.scale.base, &mut digits[..count]) {
            let packed = digits.iter().rev().fold(0, |packed: u32, digit| packed * u32::from(base) + u32::from(*digit));
            fields.put(packed as u8, bits);
        }
        for i in 0..count {
            fields.put((u32::from(code(i)) & ((1 << mode.scale.bits) - 1)) as u8, mode.scale.bits);
        }
        let anchors = self.anchors();
        for i in 0..16 {
            let bits = mode.weight_bits - u32::from(anchors >> i & 1);
            for plane in 0..if mode.dual { 2 } else { 1 } {
                fields.put(self.weights[plane][i], bits);
            }
        }
        fields.block()
    }

    /// What it decodes to.
    pub(super) fn texels(&self) -> Texels {
        let mode = &MODES[self.mode];
        let weights = &WEIGHTS[mode.weight_bits as usize];
        // The first of three channels, then alpha; gray is all of the first three.
        let mut ends = [[[255; 2]; 4]; 3];
        for (to, from) in ends.iter_mut().zip(&self.ends) {
            for (channel, to) in to.iter_mut().enumerate().take(if mode.channels == 3 { 3 } else { 4 }) {
                let from = from[if mode.channels == 2 { channel / 3 } else { channel }];
                *to = from.map(|code| mode.scale.of_code[usize::from(code)]);
            }
        }
        let mut texels = [[0; 4]; 16];
        for (i, texel) in texels.iter_mut().enumerate() {
            let ends = &ends[mode.patterns.line(self.pattern, i)];
            let weights = [0, 1].map(|plane| weights[usize::from(self.weights[plane][i])]);
            for (channel, (value, [low, high])) in texel.iter_mut().zip(ends).enumerate() {
                *value = between(*low, *high, weights[usize::from(self.apart == Some(channel))]);
            }
        }
        texels
    }
}
