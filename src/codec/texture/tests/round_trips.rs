//! What goes in comes out.

use super::*;

fn sizes() -> impl Iterator<Item = Size> {
    SIZES.iter().map(|(width, height)| Size::new(*width, *height))
}

#[test]
fn every_format_comes_back_from_every_container() {
    for (format, size) in TexelFormat::all().flat_map(|format| sizes().map(move |size| (format, size))) {
        let texture = texture(size, format);
        let mut files = PACKINGS.map(|zstd| ("KTX 2", ktx2_of(&texture, zstd))).to_vec();
        if fits_dds(&texture) {
            files.push(("DDS", dds_of(&texture)));
        }
        for (name, file) in files {
            let levels = read_all(file.clone()).unwrap();
            assert_eq!(levels.len(), size.level_count());
            for (k, (level, bytes)) in levels.iter().zip(&texture.levels).enumerate() {
                assert_eq!(level.raster, decode(bytes, size.level(k), format), "{name} {format:?} {size} level {k}");
                assert_eq!((level.format, level.notes.as_slice()), (name, [].as_slice()));
            }
            let first = read_bytes(Path::new("a"), file).unwrap();
            assert_eq!(first.raster, levels[0].raster);
        }
    }
}

#[test]
fn formats_without_blocks_lose_nothing() {
    for (format, size) in TexelFormat::all().flat_map(|format| sizes().map(move |size| (format, size))) {
        if format.block_side() == 1 {
            let raster = picture(size, format);
            assert_eq!(decode(&encode(&raster, format, Effort::Fast), size, format), raster, "{format:?} {size}");
        }
    }
}

/// The first `width` by `height` texels of a picture, the rest repeating the last.
fn padded(raster: &Raster, width: usize, height: usize) -> Raster {
    let size = raster.size();
    let samples = Array3::from_shape_fn((height, width, raster.samples.channels()), |(y, x, c)| {
        raster.at(x.min(size.width - 1), y.min(size.height - 1), c)
    });
    Raster { samples: Samples::F32(samples), channels: raster.channels.clone() }
}

#[test]
fn blocks_that_stick_out_repeat_the_border() {
    for format in [TexelFormat::Bc4, TexelFormat::Bc5, TexelFormat::Bc7, TexelFormat::Uastc] {
        for (width, height) in [(1, 1), (5, 3), (2, 7), (9, 4)] {
            let raster = picture(Size::new(width, height), format);
            let whole = padded(&raster, width.next_multiple_of(4), height.next_multiple_of(4));
            let [found, expected] = [&raster, &whole].map(|raster| encode(raster, format, Effort::Fast));
            assert_eq!(found, expected, "{format:?} {width}x{height}");
        }
    }
}

#[test]
fn channels_are_filled_up_and_dropped_as_hardware_does() {
    let size = Size::new(3, 2);
    let rgb = picture(size, TexelFormat::Rgba8);
    let Samples::U8(all) = &rgb.samples else { unreachable!() };
    let first = |n: usize| {
        let samples = Array3::from_shape_fn((2, 3, n), |(y, x, c)| all[(y, x, c)]);
        Raster::new(Samples::U8(samples))
    };
    let texel = |n: usize, format| decode(&encode(&first(n), format, Effort::Fast), size, format);
    let four = |n: usize| {
        let (texel, own) = (texel(n, TexelFormat::Rgba8), |c: usize| f32::from(all[(1, 2, c)]) / 255.0);
        let expected = [own(0), own(1), own(2), 1.0];
        (0..4).for_each(|c| {
            let expected = if c < n || c == 3 { expected[c] } else { 0.0 };
            assert_eq!(texel.at(2, 1, c), expected, "{n} channels, channel {c}");
        });
    };
    (1..=3).for_each(four);
    assert_eq!(texel(3, TexelFormat::Rg8).channels, ["R", "G"]);
    assert_eq!(texel(3, TexelFormat::R8).at(2, 1, 0), f32::from(all[(1, 2, 0)]) / 255.0);

    // A BC7 block whose ends share their lowest bits may have 254 of 255.
    for effort in [Effort::Fast, Effort::Slow] {
        let picture = picture(Size::new(64, 64), TexelFormat::Rgba8);
        let three = Array3::from_shape_fn((64, 64, 3), |(y, x, c)| picture.at(x, y, c));
        let bytes = encode(&Raster::new(Samples::F32(three)), TexelFormat::Bc7, effort);
        let back = decode(&bytes, Size::new(64, 64), TexelFormat::Bc7);
        let Samples::U8(back) = back.samples else { unreachable!() };
        let least = back.indexed_iter().filter(|((_, _, c), _)| *c == 3).map(|(_, v)| *v).min();
        assert!(least >= Some(254), "{effort:?}: {least:?}");
    }
}

#[test]
fn floats_are_rounded_and_clamped() {
    let values = [-1.0, 0.0, 0.5, 1.0, 7.0, f32::NAN, f32::INFINITY];
    let raster = Raster::new(Samples::F32(Array3::from_shape_vec((1, 7, 1), values.to_vec()).unwrap()));
    let bytes = |format| encode(&raster, format, Effort::Fast);
    assert_eq!(bytes(TexelFormat::R8), [0, 0, 128, 255, 255, 0, 255]);
    let words: Vec<u8> = [0u16, 0, 32768, 65535, 65535, 0, 65535].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(bytes(TexelFormat::R16), words);
    let blocks = decode(&bytes(TexelFormat::Bc4), raster.size(), TexelFormat::Bc4);
    assert_eq!([blocks.at(0, 0, 0), blocks.at(3, 0, 0), blocks.at(4, 0, 0), blocks.at(5, 0, 0)], [0.0, 1.0, 1.0, 0.0]);
    // Half floats are what they are.
    let halves = decode(&bytes(TexelFormat::R16f), raster.size(), TexelFormat::R16f);
    assert_eq!([halves.at(0, 0, 0), halves.at(4, 0, 0), halves.at(6, 0, 0)], [-1.0, 7.0, f32::INFINITY]);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let size = Size::new(100, 36);
    for format in TexelFormat::all() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let texture = texture(size, format);
                (PACKINGS.map(|zstd| ktx2_of(&texture, zstd)), fits_dds(&texture).then(|| dds_of(&texture)))
            })
        };
        assert_eq!(on(1), on(3), "{format:?}");
    }
}

/// All in all harder packed if that may take time: smooth pictures, of which little can be found twice, gain least.
#[test]
fn slow_packing_is_smaller_than_fast_and_fast_than_none() {
    let formats = [TexelFormat::Bc5, TexelFormat::Bc7, TexelFormat::Uastc, TexelFormat::Rgba8];
    let textures = formats.map(|format| texture(Size::new(256, 256), format));
    let bytes = |zstd| textures.iter().map(|texture| ktx2_of(texture, zstd).len()).sum::<usize>();
    let [none, fast, slow] = PACKINGS.map(bytes);
    assert!(slow < fast && 11 * fast < 10 * none, "{slow}, {fast}, {none}");
}

/// From 16 MiB on the encoder goes another way; and what it did before may not show.
#[test]
fn large_levels_are_packed_alike_whatever_was_packed_before() {
    let level = |seed: u32| (0..1u32 << 24).map(|i| ((i.wrapping_mul(seed) >> 13) ^ (i / 77)) as u8).collect();
    let large = |seed| Texture { size: Size::new(4096, 4096), format: TexelFormat::R8, levels: vec![level(seed)] };
    let [first, other] = [large(2_654_435_761), large(40_503)];
    let packed = ktx2_of(&first, Some(Effort::Fast));
    assert_ne!(packed, ktx2_of(&other, Some(Effort::Fast)));
    assert_eq!(packed, ktx2_of(&first, Some(Effort::Fast)));
    let read = read_bytes(Path::new("a.ktx2"), packed).unwrap().raster;
    let Samples::U8(samples) = read.samples else { panic!("8 bit") };
    assert_eq!(samples.as_slice().unwrap(), first.levels[0]);
}

#[test]
fn names_lead_back_and_the_list_is_in_order() {
    for (i, format) in TexelFormat::all().enumerate() {
        assert_eq!(format as usize, i);
        assert_eq!(TexelFormat::by_name(&format.name().to_uppercase()), Some(format));
    }
    assert_eq!(TexelFormat::by_name("bc6h"), None);
    let bytes = |format: TexelFormat| format.bytes(Size::new(5, 3));
    let expected = [15, 30, 60, 30, 60, 120, 30, 60, 120, 16, 32, 32, 32];
    assert_eq!(TexelFormat::all().map(bytes).collect::<Vec<_>>(), expected);
}

#[test]
fn writers_check_levels() {
    let whole = texture(Size::new(8, 4), TexelFormat::Bc7);
    let refused = |change: fn(&mut Texture), expected: &str| {
        let mut texture = whole.clone();
        change(&mut texture);
        let written = [write_ktx2(Vec::new(), &texture, None), write_dds(Vec::new(), &texture)];
        for error in written.map(|written| written.unwrap_err()) {
            assert_eq!((error.kind(), error.to_string().as_str()), (io::ErrorKind::InvalidInput, expected));
        }
    };
    refused(|texture| texture.levels.clear(), "0 levels, where 8x4 texels have 1 to 4");
    refused(|texture| texture.levels.push(vec![0; 16]), "5 levels, where 8x4 texels have 1 to 4");
    refused(|texture| texture.size.height = 0, "a texture of 8x0 texels");
    refused(|texture| texture.levels[1].truncate(15), "level 1 of 4x2 texels in bc7 has 15 bytes, not 16");
    refused(|texture| texture.format = TexelFormat::Bc4, "level 0 of 8x4 texels in bc4 has 32 bytes, not 16");
}

#[test]
fn dds_refuses_what_it_cannot_hold() {
    for (format, (width, height), expected) in [
        (TexelFormat::Uastc, (8, 4), "DDS cannot hold uastc: "),
        (TexelFormat::Bc4, (8, 6), "DDS with bc4 has sides that are multiples of 4 texels, not 8x6"),
        (TexelFormat::Bc7, (1, 4), "DDS with bc7 has sides that are multiples of 4 texels, not 1x4"),
    ] {
        let mut bytes = Vec::new();
        let error = write_dds(&mut bytes, &texture(Size::new(width, height), format)).unwrap_err();
        assert_eq!((error.kind(), bytes.len()), (io::ErrorKind::Unsupported, 0));
        assert!(error.to_string().starts_with(expected), "{error}");
    }
}

#[test]
#[should_panic(expected = "level 1 of 8x4 is 3x2")]
fn levels_of_wrong_sizes_are_refused() {
    let levels = [(8, 4), (3, 2)].map(|(w, h)| picture(Size::new(w, h), TexelFormat::R8));
    Texture::encode(&levels, TexelFormat::R8, Effort::Fast);
}
