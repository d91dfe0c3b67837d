//! EXR files out and in.

use super::super::tests::{Files, exr_of};
use super::*;

/// A value that tells level, channel and place, exact in half.
fn value(level: usize, channel: usize, y: usize, x: usize) -> f32 {
    (level * 8 + channel) as f32 + ((x * 7 + y * 13) % 32) as f32 / 32.0
}

fn levels_of(bytes: &[u8]) -> Vec<Raster> {
    let files = Files::new();
    read_exr_levels(&files.write("a.exr", bytes)).unwrap()
}

#[test]
fn mip_levels_round_trip_with_channels_in_any_order() {
    // In the caller's order; the file sorts them.
    let channels = [("n.y", Depth::Half), ("n.x", Depth::Float), ("alpha", Depth::Half)];
    for (width, height) in [(1, 1), (1, 7), (64, 64), (65, 1), (300, 170)] {
        let size = Size::new(width, height);
        let levels = levels_of(&exr_of(size, &channels, value));
        assert_eq!(levels.len(), size.level_count());
        for (k, level) in levels.iter().enumerate() {
            assert_eq!(level.size(), size.level(k));
            assert_eq!(level.channels, ["alpha", "n.x", "n.y"]);
            for (to, from) in [2, 1, 0].into_iter().enumerate() {
                for (y, x) in (0..level.size().height).flat_map(|y| (0..level.size().width).map(move |x| (y, x))) {
                    assert_eq!(level.at(x, y, to), value(k, from, y, x), "{size} level {k} channel {to} at {x}, {y}");
                }
            }
        }
    }
}

#[test]
fn half_rounds_and_float_is_exact() {
    let levels =
        levels_of(&exr_of(Size::new(3, 1), &[("a", Depth::Half), ("b", Depth::Float)], |_, _, _, x| x as f32 / 3.0));
    assert_eq!(levels[0].at(1, 0, 0), f16::from_f32(1.0 / 3.0).to_f32());
    assert_eq!(levels[0].at(1, 0, 1), 1.0 / 3.0);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let write = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| exr_of(Size::new(500, 300), &[("R", Depth::Half), ("G", Depth::Float)], value))
    };
    assert!(write(1) == write(4));
}

#[test]
fn bad_channels_are_invalid_input() {
    for names in [&[][..], &["a", "a"], &[""], &["\u{4e2d}"]] {
        let channels: Vec<_> = names.iter().map(|n| Channel { name: (*n).to_owned(), depth: Depth::Half }).collect();
        let result = write_exr(Cursor::new(Vec::new()), &channels, Size::new(2, 2), Wrap::Repeat, &|_, _, _, _, _| {});
        assert_eq!(result.unwrap_err().kind(), io::ErrorKind::InvalidInput, "{names:?}");
    }
}

#[test]
fn errors_of_the_disk_are_passed_on() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Seek for Full {
        fn seek(&mut self, _: io::SeekFrom) -> io::Result<u64> {
            Ok(0)
        }
    }
    let channels = [Channel { name: "Y".to_owned(), depth: Depth::Float }];
    let result = write_exr(Full, &channels, Size::new(200, 200), Wrap::Repeat, &|_, _, _, _, out| out.fill(0.5));
    assert_eq!(result.unwrap_err().kind(), io::ErrorKind::StorageFull);
}

#[test]
fn a_picture_has_level_0_and_customary_channels() {
    let files = Files::new();
    let channels = ["R", "G", "B", "A"].map(|name| (name, Depth::Half));
    let decoded = super::super::read(&files.write("a.exr", &exr_of(Size::new(5, 3), &channels, value))).unwrap();
    assert_eq!(decoded.raster.channels, ["R", "G", "B", "A"]);
    assert_eq!(decoded.raster.size(), Size::new(5, 3));
    assert_eq!(decoded.raster.at(2, 1, 2), value(0, 2, 1, 2));
    assert!(decoded.notes.is_empty(), "{:?}", decoded.notes);
}

#[test]
fn customary_order_worked_by_hand() {
    let ordered = |names: &[&str]| {
        let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
        customary_order(&names).into_iter().map(|c| names[c].clone()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(ordered(&["A", "B", "G", "R"]), "R G B A");
    assert_eq!(ordered(&["A", "X", "Y", "Z"]), "X Y Z A");
    assert_eq!(ordered(&["A", "Y"]), "Y A");
    assert_eq!(ordered(&["A", "B", "C"]), "A B C");
    assert_eq!(ordered(&["N.B", "N.G", "N.R", "ndf.Sxx", "ndf.Sxy"]), "N.R N.G N.B ndf.Sxx ndf.Sxy");
    assert_eq!(ordered(&["b", "g", "r"]), "r g b");
}

/// Flat files with a data window of their own, in scan lines, of unsigned integers, compressed otherwise, in two parts.
#[test]
fn foreign_files_are_read() {
    use ::exr::prelude::*;
    let layer = |name: &str, size: usize| {
        let samples: Vec<u32> = (0..size * 3).map(|i| i as u32 * 1000).collect();
        let halves: Vec<f16> = (0..size * 3).map(|i| f16::from_f32(i as f32 / 4.0)).collect();
        let channels =
            [AnyChannel::new("id", FlatSamples::U32(samples)), AnyChannel::new("Y", FlatSamples::F16(halves))];
        let encoding =
            Encoding { compression: Compression::PIZ, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let mut attributes = LayerAttributes::named(name);
        attributes.layer_position = Vec2(-4, 9);
        Layer::new(Vec2(size, 3), attributes, encoding, AnyChannels::sort(channels.into_iter().collect()))
    };
    let mut bytes = Cursor::new(Vec::new());
    let window = ImageAttributes::new(IntegerBounds::from_dimensions((40, 30)));
    Image::empty(window)
        .with_layer(layer("main", 5))
        .with_layer(layer("other", 2))
        .write()
        .to_buffered(&mut bytes)
        .unwrap();
    let files = Files::new();
    let path = files.write("a.exr", bytes.get_ref());
    let decoded = super::super::read(&path).unwrap();
    assert_eq!((decoded.raster.size().width, decoded.raster.size().height), (5, 3));
    assert_eq!(decoded.raster.channels, ["Y", "id"]);
    assert_eq!((decoded.raster.at(3, 2, 0), decoded.raster.at(3, 2, 1)), (3.25, 13000.0));
    assert_eq!(decoded.notes.len(), 2, "{:?}", decoded.notes);
    assert!(decoded.notes[0].contains("2 parts: part 1 \"main\""));
    assert_eq!(read_exr_levels(&path).unwrap().len(), 1);
}
