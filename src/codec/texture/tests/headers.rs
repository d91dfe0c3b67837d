//! Headers, byte by byte, from the specifications.

use super::*;

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// KTX 2.0.4, section 3; Khronos Data Format 1.4, section 5.
#[test]
fn a_ktx_2_file_byte_by_byte() {
    let texture = Texture { size: Size::new(3, 1), format: TexelFormat::R8, levels: vec![vec![1, 2, 3], vec![9]] };
    let mut expected = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    // Format, type size, width, height, depth, layers, faces, levels, scheme.
    expected.extend(words(&[9, 1, 3, 1, 0, 0, 1, 2, 0]));
    // Descriptor at 128, values at 172, no global data.
    expected.extend(words(&[128, 44, 172, 52, 0, 0, 0, 0]));
    // Level 0 after level 1, at a multiple of 4: offset, length, unpacked length, of 64 bit.
    expected.extend(words(&[228, 0, 3, 0, 3, 0]));
    expected.extend(words(&[224, 0, 1, 0, 1, 0]));
    // Length; vendor and kind; version 2, 40 bytes; RGBSDA, no primaries, linear; 1x1; one byte a plane.
    expected.extend(words(&[44, 0, 40 << 16 | 2, 1 << 16 | 1, 0, 1, 0]));
    // Red, 8 bits from bit 0, 0 to 255.
    expected.extend(words(&[7 << 16, 0, 0, 255]));
    expected.extend(b"\x12\0\0\0KTXorientation\0rd\0\0\0");
    expected.extend(b"\x18\0\0\0KTXwriter\0mipfold 0.1.0\0");
    expected.extend([9, 0, 0, 0, 1, 2, 3]);
    assert_eq!(env!("CARGO_PKG_VERSION"), "0.1.0", "the length of the version is part of the bytes above");
    assert_eq!(ktx2_of(&texture, None), expected);
}

/// Colour model, bytes a plane, type size and samples (offset, bits, channel and qualifiers, most) of each format.
#[test]
fn every_descriptor_fits_its_format() {
    const FLOAT: u32 = 0xc0;
    let unorm = |bits: u32, channels: &[u32]| {
        let most = (1u64 << bits) - 1;
        (0..).zip(channels).map(|(i, c)| (i * bits, bits, *c, 0, most as u32)).collect::<Vec<_>>()
    };
    let half = |channels: &[u32]| {
        let (minus_one, one) = ((-1f32).to_bits(), 1f32.to_bits());
        (0..).zip(channels).map(|(i, c)| (i * 16, 16, *c | FLOAT, minus_one, one)).collect::<Vec<_>>()
    };
    const RGBSDA: u32 = 1;
    const RGBA: [u32; 4] = [0, 1, 2, 15];
    let expected = [
        (RGBSDA, 1, unorm(8, &RGBA[..1])),
        (RGBSDA, 1, unorm(8, &RGBA[..2])),
        (RGBSDA, 1, unorm(8, &RGBA)),
        (RGBSDA, 2, unorm(16, &RGBA[..1])),
        (RGBSDA, 2, unorm(16, &RGBA[..2])),
        (RGBSDA, 2, unorm(16, &RGBA)),
        (RGBSDA, 2, half(&RGBA[..1])),
        (RGBSDA, 2, half(&RGBA[..2])),
        (RGBSDA, 2, half(&RGBA)),
        (131, 1, vec![(0, 64, 0, 0, u32::MAX)]),
        (132, 1, vec![(0, 64, 0, 0, u32::MAX), (64, 64, 1, 0, u32::MAX)]),
        (134, 1, vec![(0, 128, 0, 0, u32::MAX)]),
        // With alpha.
        (166, 1, vec![(0, 128, 3, 0, u32::MAX)]),
    ];
    for (format, (model, type_size, samples)) in TexelFormat::all().zip(expected) {
        let file = ktx2_of(&texture(Size::new(8, 8), format), None);
        let at = 80 + 4 * 24;
        let block = 24 + 16 * samples.len() as u32;
        let sides = if format.block_side() == 4 { 0x0303 } else { 0 };
        let mut expected = vec![block + 4, 0, block << 16 | 2, 1 << 16 | model, sides, format.block_bytes() as u32, 0];
        for (offset, bits, channel, least, most) in samples {
            expected.extend([offset | (bits - 1) << 16 | channel << 24, 0, least, most]);
        }
        assert_eq!(file[at..at + 4 * expected.len()], words(&expected), "{format:?}");
        assert_eq!(file[12..20], words(&[format.vk_format().unwrap_or(0), type_size]), "{format:?}");
    }
}

#[test]
fn uastc_without_alpha_says_so() {
    let channel = |alpha: u8| {
        let samples =
            Array3::from_shape_fn((8, 8, 4), |(y, x, c)| if c == 3 { 255 } else { (9 * x + 3 * y + c) as u8 });
        let solid = Array3::from_shape_fn((4, 4, 4), |(_, _, c)| if c == 3 { alpha } else { 9 });
        let levels = [Raster::new(Samples::U8(samples)), Raster::new(Samples::U8(solid))];
        ktx2_of(&Texture::encode(&levels, TexelFormat::Uastc, Effort::Fast), None)[80 + 2 * 24 + 31]
    };
    assert_eq!([channel(255), channel(254)], [0, 3]);
}

/// Multiples of a block, of 4 at least; or none where packed.
#[test]
fn ktx_2_levels_are_aligned_and_the_smallest_comes_first() {
    for (format, zstd) in TexelFormat::all().flat_map(|format| PACKINGS.map(|zstd| (format, zstd))) {
        let file = ktx2_of(&texture(Size::new(100, 36), format), zstd);
        let word = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap());
        let levels: Vec<_> = (0..7).map(|k| (word(80 + 24 * k), word(88 + 24 * k), word(96 + 24 * k))).collect();
        let alignment = if zstd.is_some() { 1 } else { format.block_bytes().max(4) as u64 };
        for (k, (offset, length, unpacked)) in levels.iter().enumerate() {
            assert_eq!(offset % alignment, 0);
            assert_eq!(*unpacked, format.bytes(Size::new(100, 36).level(k)) as u64);
            assert!(zstd.is_some() || length == unpacked);
            let next = if k == 0 { file.len() as u64 } else { levels[k - 1].0 };
            assert_eq!((offset + length).next_multiple_of(if k == 0 { 1 } else { alignment }), next);
        }
        assert_eq!(file[44], if zstd.is_some() { 2 } else { 0 });
        if zstd.is_some() {
            // A frame says how long its content is (RFC 8878, 3.1.1.1): after magic number, descriptor and, unless all is
            // one segment, a byte about the window; in 1, 2, 4 or 8 bytes, of which 2 begin at 256.
            let frame = &file[levels[0].0 as usize..];
            assert_eq!(frame[..4], [0x28, 0xb5, 0x2f, 0xfd]);
            let (code, segment) = (frame[4] >> 6, frame[4] >> 5 & 1);
            assert!(code > 0 || segment == 1, "no content size");
            let length = 1 << code;
            let mut field = [0; 8];
            field[..length].copy_from_slice(&frame[6 - usize::from(segment)..][..length]);
            assert_eq!(u64::from_le_bytes(field) + if code == 1 { 256 } else { 0 }, levels[0].2);
            // And has a checksum.
            assert_eq!(frame[4] >> 2 & 1, 1);
        }
    }
}

/// Microsoft's DDS reference: `DDS_HEADER`, `DDS_PIXELFORMAT`, `DDS_HEADER_DXT10`.
#[test]
fn a_dds_header_byte_by_byte() {
    let header = |flags: u32, pitch: u32, levels: u32, caps: u32, dxgi: u32| {
        let mut expected = b"DDS ".to_vec();
        // Size, flags, height, width, pitch or size of level 0, depth, levels, 11 words of nothing.
        expected.extend(words(&[124, flags, 16, 64, pitch, 0, levels]));
        expected.extend([0; 44]);
        // A format in four letters; no masks.
        expected.extend(words(&[32, 4]));
        expected.extend(b"DX10");
        expected.extend([0; 20]);
        expected.extend(words(&[caps, 0, 0, 0, 0]));
        // Format, 2D, no cube, one texture, nothing about alpha.
        expected.extend(words(&[dxgi, 3, 0, 1, 0]));
        expected
    };
    let start = |texture: &Texture| dds_of(texture)[..148].to_vec();
    let size = Size::new(64, 16);
    // Caps, height, width, pixel format, levels, and linear size or pitch; a texture, complex, with levels.
    let chain = |format| texture(size, format);
    assert_eq!(start(&chain(TexelFormat::Bc5)), header(0xa_1007, 1024, 7, 0x40_1008, 83));
    assert_eq!(start(&chain(TexelFormat::Rgba16f)), header(0x2_100f, 512, 7, 0x40_1008, 10));
    let one = Texture { levels: chain(TexelFormat::R8).levels[..1].to_vec(), ..chain(TexelFormat::R8) };
    assert_eq!(start(&one), header(0x100f, 64, 1, 0x1000, 61));

    for (format, number) in TexelFormat::all().filter_map(|format| Some((format, format.dxgi_format()?))) {
        let texture = texture(size, format);
        let file = dds_of(&texture);
        assert_eq!(file[128..132], number.to_le_bytes(), "{format:?}");
        assert_eq!(file[148..], texture.levels.concat());
    }
}
