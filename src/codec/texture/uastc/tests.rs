//! Blocks of every mode; what is written comes back, and how well. That Basis Universal decodes the same is tested with
//! the containers.

use super::bits::Reader;
use super::block::{Block, Content, MODES, SOLID, unpack};
use super::encode::{Search, encode_block};
use super::scale::{self, Scale, WEIGHTS, between};
use super::*;

/// Numbers that look random, 32 bit each.
fn numbers(mut state: u64) -> impl FnMut() -> u32 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as u32
    }
}

#[test]
fn scales_are_those_of_astc() {
    // Khronos Data Format 1.4, section 23.13: a digit, bits and their order.
    assert_eq!(scale::OF_12.of_code[..12], [0, 255, 69, 186, 23, 232, 92, 163, 46, 209, 116, 139]);
    assert_eq!(scale::OF_16.values[..4], [0, 17, 34, 51]);
    assert_eq!(scale::OF_40.of_code[..9], [0, 255, 32, 223, 65, 190, 97, 158, 6]);
    let all = [
        (12, &scale::OF_12),
        (16, &scale::OF_16),
        (32, &scale::OF_32),
        (40, &scale::OF_40),
        (48, &scale::OF_48),
        (160, &scale::OF_160),
        (192, &scale::OF_192),
        (256, &scale::OF_256),
    ];
    for (count, Scale { values, nearest, codes, of_code, count: found, .. }) in all {
        let values = &values[..count];
        assert!(*found == count && values.is_sorted() && values[0] == 0 && values[count - 1] == 255);
        let most = 255.0 / (count - 1) as f64;
        assert!(values.windows(2).all(|pair| (f64::from(pair[1] - pair[0]) - most).abs() < 3.0), "{values:?}");
        assert!((0..count).all(|rank| of_code[usize::from(codes[rank])] == values[rank]));
        for value in 0..=255u8 {
            let off = values[usize::from(nearest[usize::from(value)])].abs_diff(value);
            assert_eq!(Some(off), values.iter().map(|v| v.abs_diff(value)).min());
        }
    }
    assert_eq!(WEIGHTS[2][..4], [0, 21, 43, 64]);
    assert_eq!(WEIGHTS[3][..8], [0, 9, 18, 27, 37, 46, 55, 64]);
    assert_eq!(WEIGHTS[5][15..18], [30, 34, 36]);
    assert_eq!([between(10, 200, 0), between(10, 200, 64), between(0, 255, 32)], [10, 200, 128]);
}

/// Every code is the start of no other, and 1 of 128 is left.
#[test]
fn modes_are_told_apart() {
    let mut counts = [0; 20];
    for first in 0..128u8 {
        let mut block = [0; 16];
        block[0] = first;
        counts[match unpack(&block) {
            Some(Content::Solid(_)) => SOLID,
            Some(Content::Lines(block)) => block.mode,
            None => 19,
        }] += 1;
    }
    assert_eq!(counts, [8, 2, 4, 4, 4, 4, 4, 4, 4, 4, 16, 32, 16, 4, 4, 1, 2, 2, 8, 1]);
}

/// Bytes that are blocks of a mode, and what becomes of them: the same bytes, but for hints, and bits beyond the last.
#[test]
fn blocks_taken_apart_and_put_together_are_the_same() {
    let mut number = numbers(1);
    let mut counts = [0; 19];
    for _ in 0..20_000 {
        let bytes: [u8; 16] = std::array::from_fn(|_| number() as u8);
        let Some(Content::Lines(block)) = unpack(&bytes) else { continue };
        let again = block.pack(&hints::Hints::default());
        let Some(Content::Lines(found)) = unpack(&again) else { panic!("{block:?}") };
        assert_eq!(found, block);
        let mut turned = block.clone();
        turned.anchor();
        assert_eq!(turned, block, "what is unpacked is anchored");
        counts[block.mode] += 1;
    }
    assert!(counts.iter().enumerate().all(|(mode, count)| mode == SOLID || *count > 50), "{counts:?}");
}

/// Turning a line round changes no texel.
#[test]
fn anchors_change_nothing() {
    let mut number = numbers(2);
    for mode in (0..19).filter(|mode| *mode != SOLID) {
        for _ in 0..200 {
            let most = (1 << MODES[mode].weight_bits) - 1;
            let mut value = |most: u32| (number() % (most + 1)) as u8;
            let mut block = Block {
                mode,
                pattern: if MODES[mode].patterns == block::Patterns::None { 0 } else { usize::from(value(10)) },
                apart: MODES[mode].dual.then(|| if MODES[mode].channels == 2 { 3 } else { usize::from(value(3)) }),
                ends: [[[0; 2]; 4]; 3],
                weights: [0, 1].map(|_| std::array::from_fn(|_| value(most))),
            };
            let count = MODES[mode].scale.count as u32 - 1;
            block.ends.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|end| *end = value(count));
            let before = block.texels();
            block.anchor();
            assert_eq!(block.texels(), before, "mode {mode}");
            assert_eq!(decode(&block.pack(&hints::Hints::default())), before, "mode {mode}");
        }
    }
}

fn error(a: &Texels, b: &Texels) -> u32 {
    let squares = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2));
    squares.sum()
}

#[test]
fn what_a_line_holds_is_all_but_exact() {
    let mut all: Vec<(Texels, u32)> = vec![([[1, 2, 3, 4]; 16], 0), ([[255, 255, 255, 255]; 16], 0)];
    // Two colours; four of 8 bit, evenly spaced; sixteen.
    all.push((std::array::from_fn(|i| [[3, 200, 77, 255], [90, 20, 78, 255]][i / 3 % 2]), 24));
    all.push((
        std::array::from_fn(|i| [[10, 20, 30], [73, 83, 93]][usize::from(i > 9)]).map(|[r, g, b]| [r, g, b, 255]),
        24,
    ));
    all.push((std::array::from_fn(|i| [i as u8 * 16, 250 - i as u8 * 16, 7, 255]), 16 * 8));
    all.push((std::array::from_fn(|i| [i as u8 * 16, 250 - i as u8 * 16, 7, i as u8 * 10]), 16 * 24));
    // One channel that goes its own way.
    all.push((std::array::from_fn(|i| [(i as u8 * 7 % 4) * 60, i as u8 / 4 * 30, i as u8 / 4 * 50, 255]), 16 * 2));
    all.push((std::array::from_fn(|i| [i as u8 / 4 * 30, i as u8 / 4 * 50, 9, (i as u8 * 7 % 4) * 60]), 16 * 24));
    for (texels, most) in all {
        for search in [Search::Few, Search::Many] {
            let found = error(&decode(&encode_block(&texels, search)), &texels);
            assert!(found <= most, "{texels:?} {search:?}: {found}");
        }
    }
}

/// More work does not make a block worse than chance, and opaque texels stay so.
#[test]
fn blocks_of_noise_are_valid() {
    let mut number = numbers(3);
    let mut sums = [0; 2];
    for case in 0..400 {
        let (span, alpha) = ([3, 20, 90, 255][case % 4], case % 3 == 0);
        let base: [u32; 4] = std::array::from_fn(|_| number() % (256 - span));
        let texels: Texels = std::array::from_fn(|_| {
            std::array::from_fn(|c| if c == 3 && !alpha { 255 } else { (base[c] + number() % (span + 1)) as u8 })
        });
        for (sum, search) in sums.iter_mut().zip([Search::Few, Search::Many]) {
            let block = encode_block(&texels, search);
            assert!(is_valid(&block));
            let back = decode(&block);
            assert!(alpha || (!has_alpha(&block) && back.iter().all(|texel| texel[3] == 255)));
            *sum += error(&back, &texels);
        }
    }
    assert!(sums[1] < sums[0], "{sums:?}");
}

/// Transcoders divide by it.
#[test]
fn alpha_is_multiplied_by_something() {
    let mut number = numbers(4);
    for case in 0..200 {
        let span = [2, 30, 255][case % 3];
        let texels: Texels = std::array::from_fn(|i| [9, 8, 7, if i == 0 { 0 } else { (number() % span) as u8 }]);
        for search in [Search::Few, Search::Many] {
            let block = encode_block(&texels, search);
            let Some(Content::Lines(lines)) = unpack(&block) else { continue };
            let mode = &MODES[lines.mode];
            let mut fields = Reader::new(&block);
            let before = if mode.few_hints { 9 } else { 15 };
            for bits in [mode.code_bits, before / 2, before - before / 2, 4] {
                fields.take(bits);
            }
            assert!(mode.channels == 4 && fields.take(4) > 0, "{texels:?} {search:?}");
        }
    }
}
