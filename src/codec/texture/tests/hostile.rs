//! Files that are cut short, damaged or lying: one clear error each.

use proptest::prelude::*;

use super::*;

/// A KTX 2 file of given levels, packed as they are; each with the length that it claims to unpack to.
fn ktx2(format: u32, size: (u32, u32), scheme: u32, levels: &[(&[u8], u64)]) -> Vec<u8> {
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let header = [format, 1, size.0, size.1, 0, 0, 1, levels.len() as u32, scheme, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend(header.iter().flat_map(|word| word.to_le_bytes()));
    let mut at = (80 + 24 * levels.len()) as u64;
    for (data, unpacked) in levels {
        bytes.extend([at, data.len() as u64, *unpacked].iter().flat_map(|word| word.to_le_bytes()));
        at += data.len() as u64;
    }
    levels.iter().for_each(|(data, _)| bytes.extend(*data));
    bytes
}

/// A DDS file with the older header: flags, letters or number, bits, masks.
fn dds(size: (u32, u32), flags: u32, code: u32, bits: u32, masks: [u32; 4], data: &[u8]) -> Vec<u8> {
    let mut bytes = b"DDS ".to_vec();
    let mut words = vec![124, 0x1007, size.1, size.0, 0, 0, 0];
    words.extend([0; 11]);
    words.extend([32, flags, code, bits]);
    words.extend(masks);
    words.extend([0x1000, 0, 0, 0, 0]);
    bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend(data);
    bytes
}

fn first(bytes: Vec<u8>) -> Decoded {
    read_all(bytes).unwrap().swap_remove(0)
}

fn texel(decoded: &Decoded) -> Vec<f32> {
    (0..decoded.raster.samples.channels()).map(|c| decoded.raster.at(0, 0, c)).collect()
}

const LINEAR: &str = "says its data is sRGB: ignored, data is taken as linear";

#[test]
fn further_ktx_2_formats_are_read() {
    let bytes: Vec<u8> = (0..16).map(|i| 3 * i).collect();
    let of = |format, texel: &[u8]| first(ktx2(format, (1, 1), 0, &[(texel, texel.len() as u64)]));
    let byte = |v: u8| f32::from(v) / 255.0;

    for (format, srgb) in [(23, false), (27, false), (29, true)] {
        let found = of(format, &bytes[..3]);
        assert_eq!(texel(&found), [byte(0), byte(3), byte(6)]);
        assert_eq!(found.raster.channels, ["R", "G", "B"]);
        assert_eq!(found.notes.iter().any(|note| note.ends_with(LINEAR)), srgb);
    }
    assert_eq!(texel(&of(44, &bytes[..4])), [byte(6), byte(3), byte(0), byte(9)]);
    assert_eq!(texel(&of(41, &bytes[..4])), [byte(0), byte(3), byte(6), byte(9)]);
    assert_eq!(of(43, &bytes[..4]).notes.len(), 1);
    assert_eq!(texel(&of(17, &[127, 0x80])), [1.0, -1.0]);
    assert_eq!(texel(&of(78, &[0, 0xc0, 0xff, 0x7f])), [-16384.0 / 32767.0, 1.0]);
    assert_eq!(texel(&of(103, &[1.5f32.to_le_bytes(), (-2f32).to_le_bytes()].concat())), [1.5, -2.0]);
    // Signed BC5: ends 127 and -127, every texel the first, then the second.
    let block = [0x7f, 0x81, 0, 0, 0, 0, 0, 0, 0x7f, 0x81, 0x49, 0x92, 0x24, 0x49, 0x92, 0x24];
    assert_eq!(texel(&of(142, &block)), [1.0, -1.0]);
    // Blue in 5 bits, all of it, in BC1; the same with an alpha of 0 in BC3.
    let blue = [0x1f, 0, 0, 0, 0, 0, 0, 0];
    assert_eq!(texel(&of(131, &blue)), [0.0, 0.0, 1.0]);
    assert_eq!(texel(&of(137, &[[0; 8], blue].concat())), [0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn further_dds_formats_are_read() {
    let of = |flags, code: &[u8; 4], bits, masks, texel: &[u8]| {
        first(dds((1, 1), flags, u32::from_le_bytes(*code), bits, masks, texel))
    };
    let masked = |flags, bits, masks: [u32; 4], bytes: &[u8]| {
        let found = texel(&of(flags, &[0; 4], bits, masks, bytes));
        found.iter().map(|v| (v * 255.0).round() as u8).collect::<Vec<_>>()
    };
    let [r, g, b, a] = [0xff_0000, 0xff00, 0xff, 0xff00_0000];
    assert_eq!(masked(0x41, 32, [r, g, b, a], &[3, 2, 1, 4]), [1, 2, 3, 4]);
    assert_eq!(masked(0x41, 32, [b, g, r, a], &[3, 2, 1, 4]), [3, 2, 1, 4]);
    assert_eq!(masked(0x40, 32, [r, g, b, 0], &[3, 2, 1, 4]), [1, 2, 3]);
    assert_eq!(masked(0x40, 24, [r, g, b, 0], &[3, 2, 1]), [1, 2, 3]);
    assert_eq!(masked(0x2_0000, 8, [0xff, 0, 0, 0], &[77]), [77]);
    assert_eq!(masked(0x2_0001, 16, [0xff, 0, 0, 0xff00], &[77, 99]), [77, 99]);
    assert_eq!(masked(0x2, 8, [0, 0, 0, 0xff], &[50]), [50]);
    assert_eq!(texel(&of(0x40, &[0; 4], 32, [0xffff, 0xffff_0000, 0, 0], &[255, 255, 0, 0])), [1.0, 0.0]);

    // Red and blue, or red and alpha, are no red and green.
    for (flags, masks) in [(0x40, [r, 0, b, 0]), (0x41, [r, 0, 0, a]), (0x40, [0, g, b, 0])] {
        assert!(message(dds((1, 1), flags, 0, 32, masks, &[0; 4])).contains("32 bit with masks"), "{masks:x?}");
    }

    let ends = [255, 0, 0, 0, 0, 0, 0, 0];
    for code in [b"ATI1", b"BC4U"] {
        assert_eq!(texel(&of(4, code, 0, [0; 4], &ends)), [1.0]);
    }
    for code in [b"ATI2", b"BC5U"] {
        assert_eq!(texel(&of(4, code, 0, [0; 4], &[ends, [0; 8]].concat())), [1.0, 0.0]);
    }
    assert_eq!(texel(&of(4, b"BC5S", 0, [0; 4], &[[0x7f, 0x81, 0, 0, 0, 0, 0, 0]; 2].concat())), [1.0, 1.0]);
    assert_eq!(texel(&of(4, b"DXT5", 0, [0; 4], &[ends, [0x1f, 0, 0, 0, 0, 0, 0, 0]].concat())), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(texel(&of(4, &[113, 0, 0, 0], 0, [0; 4], &[0, 0x3c, 0, 0xbc, 0, 0, 0, 0x40])), [1.0, -1.0, 0.0, 2.0]);

    let refused = |flags, code: &[u8; 4], bits, masks| {
        message(dds((1, 1), flags, u32::from_le_bytes(*code), bits, masks, &[0; 16]))
    };
    assert!(refused(4, b"UYVY", 0, [0; 4]).contains("DDS with texels of format UYVY is not supported"));
    let found = refused(0x40, &[0; 4], 16, [0xf800, 0x7e0, 0x1f, 0]);
    assert!(found.contains("16 bit with masks 0xf800, 0x7e0, 0x1f and none"), "{found}");
}

#[test]
fn packed_levels_are_read() {
    let texels: Vec<u8> = (0..64).collect();
    let [a, b] = [&texels[..40], &texels[40..]]
        .map(|part| ruzstd::encoding::compress_to_vec(part, ruzstd::encoding::CompressionLevel::Fastest));
    let two_frames = [a, b].concat();
    let zlib = miniz_oxide::deflate::compress_to_vec_zlib(&texels, 6);
    for (scheme, data) in [(2, &two_frames), (3, &zlib)] {
        let found = first(ktx2(9, (8, 8), scheme, &[(data, 64)]));
        assert_eq!(found.raster.at(7, 7, 0), 63.0 / 255.0);
        for length in [63, 65] {
            let size = (length, 1);
            let message = message(ktx2(9, size, scheme, &[(data, length.into())]));
            assert!(message.contains("data of level 0"), "{message}");
        }
    }
    // The last four bytes are a checksum.
    let mut damaged = two_frames.clone();
    *damaged.last_mut().unwrap() ^= 1;
    assert!(message(ktx2(9, (8, 8), 2, &[(&damaged, 64)])).contains("its checksum is not that of its content"));
}

#[test]
fn what_a_ktx_2_file_asks_for_is_said() {
    let mut file = ktx2_of(&texture(Size::new(4, 4), TexelFormat::R8), None);
    let at = file.windows(3).position(|w| w == b"rd\0").unwrap();
    file[at + 1] = b'u';
    assert_eq!(first(file.clone()).notes, ["KTX 2 asks to be turned or mirrored (orientation \"ru\"): ignored"]);
    file[at + 1] = b'd';
    // UNORM, but with sRGB's curve in the descriptor.
    let descriptor = u32::from_le_bytes(file[48..52].try_into().unwrap()) as usize;
    file[descriptor + 14] = 2;
    assert!(first(file).notes[0].ends_with(LINEAR));
}

#[test]
fn what_a_ktx_2_file_repeats_is_said_once() {
    let mut file = ktx2_of(&texture(Size::new(4, 4), TexelFormat::R8), None);
    let entries: Vec<u8> = [&b"\x14\0\0\0KTXorientation\0lurd\0"[..]; 500].concat();
    let at = file.len() as u32;
    file.extend(&entries);
    put(&mut file, 56, at);
    put(&mut file, 60, entries.len() as u32);
    assert_eq!(first(file).notes, ["KTX 2 asks to be turned or mirrored (orientation \"lurd\"): ignored"]);
}

#[test]
fn a_uastc_file_that_lies_is_an_error() {
    let whole = ktx2_of(&texture(Size::new(16, 8), TexelFormat::Uastc), None);
    let descriptor = 80 + 5 * 24;
    let with = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut file = whole.clone();
        change(&mut file);
        file
    };
    let level_0 = whole.len() - 8 * 16;
    // A mode that there is not, and a pattern.
    let nothing = message(with(&|file| file[level_0 + 16 * 3] = 0x45));
    assert!(nothing.contains("block 3 of level 0 is none of UASTC"), "{nothing}");
    let pattern = message(with(&|file| put(file, level_0 + 16 * 7, 0x13 | 30 << 20)));
    assert!(pattern.contains("block 7 of level 0 is none of UASTC"), "{pattern}");
    let last = message(with(&|file| file[level_0 - 16] = 0x45));
    assert!(last.contains("block 1 of level 1 is none of UASTC"), "{last}");

    let model = |model: u8| message(with(&|file| file[descriptor + 12] = model));
    assert!(model(163).contains("texels of Basis Universal's ETC1S is not supported"), "{}", model(163));
    assert!(model(162).contains("of no VkFormat and colour model ASTC is not supported"), "{}", model(162));
    assert!(model(0).contains("of no VkFormat and no colour model is not supported"), "{}", model(0));
    let cut = message(with(&|file| put(file, 52, 8)));
    assert!(cut.contains("of no VkFormat and no colour model is not supported"), "{cut}");

    let split = first(with(&|file| file[descriptor + 31] = 5));
    assert_eq!(split.notes, ["KTX 2 has its second channel in alpha: left there"]);
}

#[test]
fn a_ktx_2_file_that_lies_is_an_error() {
    let whole = ktx2_of(&texture(Size::new(64, 16), TexelFormat::Bc5), None);
    let with = |at: usize, value: u32| {
        let mut bytes = whole.clone();
        put(&mut bytes, at, value);
        message(bytes)
    };
    let found = |at, value, expected: &str| {
        let message = with(at, value);
        assert!(message.contains(expected), "{message}");
    };
    found(12, 0, "KTX 2 with texels of no VkFormat and colour model BC5 is not supported");
    found(12, 143, "KTX 2 with texels of VkFormat 143, BC6H_UFLOAT_BLOCK is not supported");
    found(12, 4_000_000, "texels of VkFormat 4000000");
    found(20, 0, "KTX 2 data that cannot be decoded (zero pixel width)");
    found(20, 128, "level 0 of 128x16 texels has 1024 bytes, not 2048");
    found(20, u32::MAX, "4294967295x16 texels");
    found(24, 0, "KTX 2 with a 1D texture");
    found(28, 2, "KTX 2 with a 3D texture");
    found(32, 5, "KTX 2 with 5 layers");
    found(36, 6, "KTX 2 with 6 faces (a cube map)");
    found(40, 8, "8 levels, where 64x16 texels have 7");
    found(40, u32::MAX, "4294967295 levels");
    found(44, 1, "Basis Universal");
    found(44, 9, "supercompression");
    // Level 0: beyond the end, within the header, not of its length; level 3 far away.
    found(80, whole.len() as u32, "is not within its");
    found(80, 0, "level 0, 1024 bytes from byte 0, is not within its");
    found(84, u32::MAX, "is not within its");
    found(88, 1008, "level 0 of 64x16 texels has 1008 bytes, not 1024");
    found(96, 1040, "level 0 of 64x16 texels has 1040 bytes, not 1024");
    found(80 + 3 * 24 + 4, 1, "level 3, 32 bytes from byte");
}

#[test]
fn a_small_file_that_claims_to_be_huge_is_an_error_at_once() {
    let side = 32768u32;
    let bytes = u64::from(side) * u64::from(side);
    for scheme in [2, 3] {
        let found = message(ktx2(9, (side, side), scheme, &[(&[0; 900], bytes)]));
        assert!(found.contains("level 0 has 900 bytes, too few for 1073741824 of texels"), "{found}");
    }
    let found = message(dds((side, side), 4, u32::from_le_bytes(*b"ATI2"), 0, [0; 4], &[0; 900]));
    assert!(found.contains("900 bytes of texels, where its 1 levels need 1073741824"), "{found}");
    let found = message(dds((side, 2 * side), 4, u32::from_le_bytes(*b"ATI2"), 0, [0; 4], &[]));
    assert!(found.contains("32768x65536 texels is not supported"), "{found}");
}

#[test]
fn a_dds_file_that_lies_is_an_error() {
    let whole = dds_of(&texture(Size::new(64, 16), TexelFormat::Bc7));
    let found = |at, value, expected: &str| {
        let mut bytes = whole.clone();
        put(&mut bytes, at, value);
        let message = message(bytes);
        assert!(message.contains(expected), "{message}");
    };
    found(4, 123, "Header struct size");
    found(12, 0, "found a size of 64x0");
    found(12, 64, "bytes of texels, where its 7 levels need");
    found(16, u32::MAX, "4294967295x16 texels is not supported");
    found(28, 8, "8 levels, where 64x16 texels have 7");
    found(28, u32::MAX, "4294967295 levels");
    found(112, 0x200, "DDS with a cube map is not supported");
    found(112, 0x20_0000, "DDS with a texture that is not 2D");
    found(128, 95, "DDS with texels of format BC6H_UF16 is not supported");
    found(128, 9999, "DDS with format 9999, resource dimension 3 and alpha mode 0 is not supported");
    found(132, 4, "DDS with a texture that is not 2D");
    found(136, 4, "DDS with a cube map");
    found(140, 3, "DDS with an array of textures");
}

#[test]
fn a_file_cut_short_is_an_error_wherever_it_ends() {
    let texture = texture(Size::new(8, 4), TexelFormat::Bc5);
    for file in [ktx2_of(&texture, None), ktx2_of(&texture, Some(Effort::Fast)), dds_of(&texture)] {
        for keep in 12..file.len() {
            assert!(message(file[..keep].to_vec()).contains("expected"), "{keep} of {}", file.len());
        }
    }
}

/// A whole file of some kind.
fn files() -> Vec<Vec<u8>> {
    let of = |format| texture(Size::new(20, 12), format);
    let formats = [TexelFormat::R8, TexelFormat::Rgba16f, TexelFormat::Bc5, TexelFormat::Bc7];
    let all =
        formats.into_iter().flat_map(|f| [ktx2_of(&of(f), None), ktx2_of(&of(f), Some(Effort::Fast)), dds_of(&of(f))]);
    all.chain([None, Some(Effort::Fast)].map(|zstd| ktx2_of(&of(TexelFormat::Uastc), zstd))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Whatever comes out, it is no panic, and an error names the file. Headers are short and matter most.
    #[test]
    fn damage_never_panics(
        file in 0usize..14,
        edits in prop::collection::vec((0usize..4000, any::<u32>(), 0usize..3), 1..5),
        keep in prop::option::of(0usize..4000),
    ) {
        thread_local!(static FILES: Vec<Vec<u8>> = files());
        let mut bytes = FILES.with(|files| files[file].clone());
        for (at, value, kind) in edits {
            let at = match kind {
                0 => 12 + at % 240,
                _ => 12 + at,
            } % (bytes.len() - 4);
            match kind {
                0 | 1 => put(&mut bytes, at, value >> (value % 32)),
                _ => bytes[at] = value as u8,
            }
        }
        // (The magic numbers stay.)
        let start = if bytes[0] == b'D' { &b"DDS "[..] } else { b"\xabKTX 20\xbb\r\n\x1a\n" };
        bytes[..start.len()].copy_from_slice(start);
        bytes.truncate(keep.unwrap_or(usize::MAX).max(12));
        match read_all(bytes) {
            Ok(levels) => prop_assert!(levels.iter().all(|level| level.raster.channels.len() == level.raster.samples.channels())),
            Err(error) => prop_assert!(error.to_string().starts_with("a.texture: "), "{}", error),
        }
    }

    #[test]
    fn garbage_after_the_magic_number_never_panics(ktx in any::<bool>(), garbage in prop::collection::vec(any::<u8>(), 0..400)) {
        let start = if ktx { &b"\xabKTX 20\xbb\r\n\x1a\n"[..] } else { b"DDS " };
        let message = message([start, &garbage].concat());
        prop_assert!(message.contains("expected") || message.contains("supported"), "{}", message);
    }
}
