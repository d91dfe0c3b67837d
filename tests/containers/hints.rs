//! Our hints beside all others: what Basis Universal's transcoder makes of them in ETC1 and in the alpha of ETC2.

use std::path::Path;

use mipfold::codec::texture::{Effort, TexelFormat, Texture, decode, encode, write_ktx2};
use mipfold::image::{Raster, Samples, Size};
use mipfold::sample::by_name;
use ndarray::Array3;

use super::{MODES, three};

type Texels = [[u8; 4]; 16];

/// How far texels move from their average in ETC1 (Khronos Data Format 1.4, table 21.5).
const MOVES: [[i32; 2]; 8] = [[2, 8], [5, 17], [9, 29], [13, 42], [18, 60], [24, 80], [33, 106], [47, 183]];

/// Likewise alpha in ETC2, up; down it is one more (table 22.9).
#[rustfmt::skip]
const ALPHA_MOVES: [[i32; 4]; 16] = [
    [2, 5, 8, 14], [2, 6, 9, 12], [1, 4, 7, 12], [1, 3, 5, 12], [2, 5, 7, 11], [2, 6, 8, 10], [3, 6, 7, 10], [2, 4, 7, 10],
    [1, 5, 7, 9], [1, 4, 7, 9], [1, 3, 7, 9], [1, 4, 6, 9], [2, 3, 6, 9], [0, 1, 2, 9], [3, 5, 7, 8], [2, 4, 6, 8],
];

/// A block of ETC1, its alpha left at 255.
fn etc1(block: &[u8; 8]) -> Texels {
    let (near, flip) = (block[3] & 2 > 0, block[3] & 1 > 0);
    let base = |half: usize, c: usize| -> i32 {
        let byte = i32::from(block[c]);
        if !near {
            return (if half == 0 { byte >> 4 } else { byte & 15 }) * 17;
        }
        // Five bits, and three of a difference with its sign.
        let difference = ((byte & 7) ^ 4) - 4;
        let five = (byte >> 3) + if half == 0 { 0 } else { difference };
        five << 3 | five >> 2
    };
    let indices = u32::from_be_bytes([block[4], block[5], block[6], block[7]]);
    std::array::from_fn(|i| {
        let (x, y) = (i % 4, i / 4);
        let half = if flip { y / 2 } else { x / 2 };
        let row = MOVES[usize::from(block[3] >> (5 - 3 * half) & 7)];
        let at = 4 * x + y;
        let by = row[(indices >> at & 1) as usize] * if indices >> (at + 16) & 1 == 1 { -1 } else { 1 };
        std::array::from_fn(|c| if c == 3 { 255 } else { (base(half, c) + by).clamp(0, 255) as u8 })
    })
}

/// A block of the alpha of ETC2.
fn alpha(block: &[u8; 8]) -> [u8; 16] {
    let (base, times, row) = (i32::from(block[0]), i32::from(block[1] >> 4), usize::from(block[1] & 15));
    let indices = u64::from_be_bytes(*block);
    std::array::from_fn(|i| {
        let index = (indices >> (45 - 3 * (i % 4 * 4 + i / 4)) & 7) as usize;
        let up = ALPHA_MOVES[row][index % 4];
        (base + times * if index < 4 { -1 - up } else { up }).clamp(0, 255) as u8
    })
}

/// The same blocks in another format, by the transcoder.
fn transcoded(three: &Path, blocks: &[u128], format: &str) -> Vec<u8> {
    const ROW: usize = 512;
    let folder = tempfile::tempdir().unwrap();
    let (path, dump) = (folder.path().join("a.ktx2"), folder.path().join("a.bin"));
    let size = Size::new(4 * ROW, 4 * blocks.len().div_ceil(ROW));
    let mut level: Vec<u8> = blocks.iter().flat_map(|block| block.to_le_bytes()).collect();
    level.resize(TexelFormat::Uastc.bytes(size), 0);
    let texture = Texture { size, format: TexelFormat::Uastc, levels: vec![level] };
    write_ktx2(std::fs::File::create(&path).unwrap(), &texture, None).unwrap();
    super::common::script(Path::new("node"), "basis_dump.mjs", &[three, &path, &dump, Path::new(format)]);
    std::fs::read(&dump).unwrap()
}

fn texels(block: u128) -> Texels {
    let Samples::U8(texels) = decode(&block.to_le_bytes(), Size::new(4, 4), TexelFormat::Uastc).samples else {
        unreachable!("8 bit")
    };
    std::array::from_fn(|i| std::array::from_fn(|c| texels[(i / 4, i % 4, c)]))
}

/// Some of the blocks of a raster that are of no single colour.
fn some_blocks(raster: &Raster, effort: Effort, count: usize) -> Vec<u128> {
    let bytes = encode(raster, TexelFormat::Uastc, effort);
    let blocks = bytes.as_chunks().0.iter().map(|block| u128::from_le_bytes(*block));
    let blocks: Vec<_> = blocks.filter(|block| mode(*block) != SOLID).collect();
    blocks.iter().step_by(blocks.len() / count).take(count).copied().collect()
}

const SOLID: usize = 8;

fn mode(block: u128) -> usize {
    MODES.iter().position(|(code, bits, ..)| block & ((1 << bits) - 1) == *code).unwrap()
}

/// A block's field of hints for ETC1, its first bit and its length; hints for alpha, of 8 bit, come next.
fn field(block: u128) -> (u32, u32) {
    let (mode, code_bits) = (mode(block), MODES[mode(block)].1);
    // These are short of bits: one for BC1, and no bias.
    if (10..=12).contains(&mode) { (code_bits + 1, 8) } else { (code_bits + 2, 13) }
}

/// The block with each of the values of a field.
fn all_of(block: u128, (at, length): (u32, u32)) -> impl Iterator<Item = u128> {
    let mask = ((1 << length) - 1) << at;
    (0..1 << length).map(move |value| block & !mask | value << at)
}

/// Root mean square differences of values.
#[derive(Debug)]
struct Errors {
    ours: f64,
    best: f64,
    zero: f64,
}

/// What is lost by our hints, by the best there are, and by hints of zeros: `error` tells it of texels and transcoded
/// bytes, `bytes` a block, of as many values as `values`.
fn errors(
    three: &Path,
    blocks: &[u128],
    format: &str,
    field: impl Fn(u128) -> (u32, u32),
    error: impl Fn(&Texels, &[u8]) -> u64,
) -> Errors {
    let (bytes, values) = if format == "ETC1" { (8, 48) } else { (16, 16) };
    let of = |blocks: &[u128]| -> Vec<u64> {
        let found = transcoded(three, blocks, format);
        blocks.iter().zip(found.chunks_exact(bytes)).map(|(block, found)| error(&texels(*block), found)).collect()
    };
    let ours: u64 = of(blocks).iter().sum();
    let all: Vec<_> = blocks.iter().flat_map(|block| all_of(*block, field(*block))).collect();
    let mut rest = of(&all).into_iter();
    let (mut best, mut zero) = (0, 0);
    for block in blocks {
        let found: Vec<_> = rest.by_ref().take(1 << field(*block).1).collect();
        best += found.iter().min().unwrap();
        zero += found[0];
    }
    let [ours, best, zero] = [ours, best, zero].map(|sum| (sum as f64 / (values * blocks.len()) as f64).sqrt());
    Errors { ours, best, zero }
}

fn squares<'a>(a: impl IntoIterator<Item = &'a u8>, b: impl IntoIterator<Item = &'a u8>) -> u64 {
    a.into_iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum()
}

fn colour_error(texels: &Texels, block: &[u8]) -> u64 {
    squares(texels.as_flattened(), etc1(block.try_into().unwrap()).as_flattened())
}

/// `most`: parts of the error of the best hints that ours may have.
fn hold(what: &str, found: &Errors, most: f64, than_zero: f64) {
    let Errors { ours, best, zero } = found;
    assert!(*ours <= most * best && *zero >= than_zero * ours, "{what}: {found:?}, {} {}", ours / best, zero / ours);
}

#[test]
fn hints_for_etc1_are_near_the_best_there_are() {
    let Some(three) = three() else { return };
    for (name, fast, slow, than_zero) in [("hammered-metal", 1.08, 1.06, 1.5), ("tiles", 1.06, 1.04, 4.0)] {
        let normals = (by_name(name).unwrap().make)(64, 1).normal;
        for (effort, most) in [(Effort::Fast, fast), (Effort::Slow, slow)] {
            let found = errors(&three, &some_blocks(&normals, effort, 12), "ETC1", field, colour_error);
            hold(&format!("{name} {effort:?}"), &found, most, than_zero);
        }
    }
}

#[test]
fn hints_for_alpha_are_all_but_the_best_there_are() {
    let Some(three) = three() else { return };
    let normals = (by_name("hammered-metal").unwrap().make)(64, 1).normal;
    let samples = Array3::from_shape_fn((64, 64, 4), |(y, x, c)| normals.at(x, y, if c < 3 { c } else { 0 }));
    let four = Raster::new(Samples::F32(samples));
    for effort in [Effort::Fast, Effort::Slow] {
        let after = |block| (field(block).0 + field(block).1, 8);
        let found = errors(&three, &some_blocks(&four, effort, 24), "ETC2", after, |texels, block| {
            squares(&texels.map(|texel| texel[3]), &alpha(block[..8].try_into().unwrap()))
        });
        hold(&format!("{effort:?}"), &found, 1.01, 20.0);
    }
}

/// The least squared difference of one colour that ETC1 has: exact or 4 bit averages, moved all alike.
fn least(colour: [u8; 4]) -> u64 {
    let moves = MOVES.iter().flatten().flat_map(|by| [*by, -by]);
    let ways = moves.flat_map(|by| [(15, by), (31, by)]);
    let error = |(most, by): (i32, i32)| -> u64 {
        let value = |base: i32| if most == 15 { base * 17 } else { base << 3 | base >> 2 };
        let one = |wanted: u8| {
            (0..=most).map(|base| ((value(base) + by).clamp(0, 255) as u8).abs_diff(wanted)).min().unwrap()
        };
        colour[..3].iter().map(|wanted| u64::from(one(*wanted)).pow(2)).sum()
    };
    ways.map(error).min().unwrap()
}

#[test]
fn single_colours_are_the_nearest_of_etc1() {
    let Some(three) = three() else { return };
    let colours = Array3::from_shape_fn((4, 4 * 400, 3), |(_, x, c)| ((x / 4 + 1) * [37, 91, 151][c] % 256) as u8);
    let bytes = encode(&Raster::new(Samples::U8(colours)), TexelFormat::Uastc, Effort::Fast);
    let blocks: Vec<_> = bytes.as_chunks().0.iter().map(|block| u128::from_le_bytes(*block)).collect();
    assert!(blocks.iter().all(|block| mode(*block) == SOLID));
    let found = transcoded(&three, &blocks, "ETC1");
    for (block, found) in blocks.iter().zip(found.chunks_exact(8)) {
        let texels = texels(*block);
        assert_eq!(colour_error(&texels, found), 16 * least(texels[0]), "{:?}", texels[0]);
    }
}
