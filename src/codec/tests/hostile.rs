//! Files that are cut short, misnamed, damaged or lying: one clear error each, at once, without much memory.

use super::*;

#[test]
fn what_is_no_picture_is_named() {
    let files = Files::new();
    let cases: [(&str, &[u8], &str); 5] = [
        ("empty.png", b"", "found an empty file"),
        ("notes.png", b"Dear diary, no picture today.", "found a text file"),
        ("a.gif", b"GIF89a\x01\x00\x01\x00", "found a GIF picture"),
        ("noise.bin", &[0, 200, 3, 4, 5], "unknown kind, starting with bytes [00, c8, 03, 04]"),
        ("short.tga", &[0, 0, 2], "TGA data that cannot be decoded"),
    ];
    for (name, bytes, found) in cases {
        let path = files.write(name, bytes);
        let message = message(read(&path));
        assert!(is_about(&message, &path) && message.contains(found) && message.contains("expected"), "{message}");
    }
    let folder = files.write("x", b"").parent().unwrap().to_owned();
    assert!(message(read(&folder)).contains("found a folder; expected a picture file"));
    assert!(matches!(read(&folder.join("none.png")), Err(Error::Io { .. })));
    assert!(read_exr_levels(&files.write("b.exr", &png_of(Samples::U8(bytes_u8(1, 1, 1))))).is_err());
}

#[test]
fn a_file_cut_short_is_an_error() {
    for (name, bytes) in samples_of_all_formats() {
        for keep in [bytes.len() / 2, bytes.len() - bytes.len() / 5] {
            let message = message(read_bytes(name, &bytes[..keep]));
            assert!(message.contains("expected"), "{name} cut to {keep}: {message}");
        }
    }
}

/// Each format's sample with its size overwritten.
fn resized(name: &str, bytes: &[u8], width: u32, height: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    let (w16, h16) = (width as u16, height as u16);
    match name {
        "a.png" => {
            put(16, &width.to_be_bytes());
            put(20, &height.to_be_bytes());
            let crc = formats::crc32(&bytes[12..29]);
            bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        }
        "a.jpg" => {
            let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
            bytes[frame + 5..frame + 7].copy_from_slice(&h16.to_be_bytes());
            bytes[frame + 7..frame + 9].copy_from_slice(&w16.to_be_bytes());
        }
        "a.tga" => {
            put(12, &w16.to_le_bytes());
            put(14, &h16.to_le_bytes());
        }
        "a.bmp" => {
            put(18, &width.to_le_bytes());
            put(22, &height.to_le_bytes());
        }
        // An extended header, whose sides have 24 bits, before the picture.
        "a.webp" => {
            let mut extended = vec![0; 18];
            extended[..8].copy_from_slice(b"VP8X\x0a\0\0\0");
            extended[12..15].copy_from_slice(&(width - 1).to_le_bytes()[..3]);
            extended[15..18].copy_from_slice(&(height - 1).to_le_bytes()[..3]);
            bytes.splice(12..12, extended);
            let length = bytes.len() as u32 - 8;
            bytes[4..8].copy_from_slice(&length.to_le_bytes());
        }
        "a.hdr" => {
            let line = bytes.windows(9).position(|w| w == b"-Y 7 +X 9").unwrap();
            bytes.splice(line..line + 9, format!("-Y {height} +X {width}").into_bytes());
        }
        "a.tif" => {
            // Tags 256 and 257, of type 4 (32 bit) or 3, anywhere in the directory.
            for (tag, value) in [(256u16, width), (257, height)] {
                for kind in [3u16, 4] {
                    let entry = [tag.to_le_bytes(), kind.to_le_bytes()].concat();
                    if let Some(at) = bytes.windows(4).position(|w| w == entry) {
                        bytes[at + 2..at + 4].copy_from_slice(&4u16.to_le_bytes());
                        bytes[at + 8..at + 12].copy_from_slice(&value.to_le_bytes());
                    }
                }
            }
        }
        "a.ktx2" => {
            put(20, &width.to_le_bytes());
            put(24, &height.to_le_bytes());
        }
        "a.dds" => {
            put(12, &height.to_le_bytes());
            put(16, &width.to_le_bytes());
        }
        _ => {
            for window in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
                let at = bytes.windows(window.len()).position(|w| w == window).unwrap() + window.len() + 4;
                bytes[at + 8..at + 12].copy_from_slice(&(width - 1).to_le_bytes());
                bytes[at + 12..at + 16].copy_from_slice(&(height - 1).to_le_bytes());
            }
            let size = Size::new(width as usize, height as usize);
            let tiles = |k| size.level(k).width.div_ceil(64) * size.level(k).height.div_ceil(64);
            let tiles: usize = (0..size.level_count()).map(tiles).sum();
            let name = b"chunkCount\0int\0";
            let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
            bytes[at..at + 4].copy_from_slice(&(tiles as u32).to_le_bytes());
        }
    }
    bytes
}

/// The most memory that this process has ever held, in KiB; nothing where there is no such file.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().trim_end_matches(" kB").parse().ok()
}

#[test]
fn a_small_file_that_claims_to_be_huge_is_an_error_at_once() {
    let before = peak_memory();
    for (name, bytes) in samples_of_all_formats() {
        // Beyond the limit, and within it.
        for (width, height) in [(60_000, 60_000), (30_000, 30_000), (16_000, 16_000)] {
            let message = message(read_bytes(name, &resized(name, &bytes, width, height)));
            assert!(message.contains("expected") || message.contains("supported"), "{name}: {message}");
        }
        // The TIFF crate finds the strips too few before it tells the size.
        if name != "a.tif" {
            let message = message(read_bytes(name, &resized(name, &bytes, 60_000, 60_000)));
            assert!(message.contains("60000x60000 texels is not supported; supported: up to 1073741824"), "{message}");
        }
    }
    if let (Some(before), Some(after)) = (before, peak_memory()) {
        // Other tests run beside this one.
        assert!(after < before + 500_000, "{before} KiB grew to {after} KiB");
    }
}

#[test]
fn no_size_is_invalid() {
    for (name, bytes) in samples_of_all_formats() {
        if ["a.webp", "a.exr"].contains(&name) {
            continue;
        }
        let message = message(read_bytes(name, &resized(name, &bytes, 0, 7)));
        assert!(message.contains("found"), "{name}: {message}");
    }
}

#[test]
fn cmyk_jpeg_is_unsupported() {
    let (_, mut bytes) = samples_of_all_formats().swap_remove(1);
    let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    bytes[frame + 9] = 4;
    assert!(message(read_bytes("a.jpg", &bytes)).contains("JPEG with CMYK colours is not supported"));
}

/// Damaged at random, with a fixed seed: whatever comes out, it is no panic.
#[test]
fn damage_never_panics() {
    let files = Files::new();
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for (name, bytes) in samples_of_all_formats() {
        let path = files.write(name, &bytes);
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random(4) {
                let at = random(damaged.len());
                // Headers are short and matter most.
                let at = if random(2) == 0 { at } else { at.min(random(64)) };
                damaged[at] = match random(3) {
                    0 => 0xff,
                    1 => damaged[at] ^ (1 << random(8)),
                    _ => random(256) as u8,
                };
            }
            if random(8) == 0 {
                damaged.truncate(random(damaged.len()));
            }
            std::fs::write(&path, &damaged).unwrap();
            if let Ok(decoded) = read(&path) {
                assert_eq!(decoded.raster.channels.len(), decoded.raster.samples.channels());
            }
            let _ = read_exr_levels(&path);
        }
    }
}
