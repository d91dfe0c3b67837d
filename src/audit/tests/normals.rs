//! Faults of normal maps.

use std::io::Cursor;

use super::*;
use crate::material::NormalY;

#[test]
fn a_flipped_green_is_found_by_curl_heights_and_name() {
    let flipped = || normals(|[p, q]| [p, -q]);
    let audit = Maps::of(flipped()).audit();
    only(&audit, &["green"]);
    let finding = found(&audit, "green");
    assert_eq!(finding.severity, Severity::Warning);
    assert!(finding.confidence > 0.9 && finding.fix.contains("--normal-y directx"), "{finding:?}");
    let directx = |inputs| Inputs { normal_y: NormalY::DirectX, ..inputs };
    only(&Maps::of(flipped()).audit_as(directx), &[]);
    assert!(found(&Maps::of(sound()).audit_as(directx), "green").fix.contains("--normal-y opengl"));
    // A second witness makes it an error.
    let with_heights = Maps::of(flipped()).with("height.png", heights()).audit();
    assert_eq!(found(&with_heights, "green").severity, Severity::Error);
    let mut named = Maps::of(flipped());
    named.0[0].0 = "wall_normal_dx.png";
    assert_eq!(found(&named.audit(), "green").severity, Severity::Error);
    // A name alone does not, least of all against the slopes.
    let named = |map| {
        let mut named = Maps::of(map);
        named.0[0].0 = "wall_normal_dx.png";
        let audit = named.audit();
        only(&audit, &["green"]);
        assert_eq!(audit.findings[0].severity, Severity::Warning);
        audit.findings[0].confidence
    };
    assert!(named(sound()) < 0.5);
    assert!(named(noise()) > 0.7);
}

#[test]
fn swapped_channels_are_found() {
    for (bend, what) in [
        ((|[p, q]: [f64; 2]| [q, p]) as fn([f64; 2]) -> [f64; 2], "swapped"),
        (|[p, q]| [-q, p], "swapped and one of them turned"),
    ] {
        let audit = Maps::of(normals(bend)).audit();
        only(&audit, &["green"]);
        assert!(found(&audit, "green").evidence.ends_with(what), "{audit:#?}");
        assert_eq!(found(&audit, "green").channel, Some("red green"));
        let audit = Maps::of(normals(bend)).with("height.png", heights()).audit();
        assert_eq!(found(&audit, "green").severity, Severity::Error);
    }
}

#[test]
fn inverted_heights_are_a_note() {
    let deep = map8(1, |x, y| vec![0.5 - surface(x, y)[0] / 30.0]);
    let audit = Maps::of(sound()).with("height.png", deep).audit();
    only(&audit, &["green"]);
    assert_eq!(found(&audit, "green").severity, Severity::Note);
    assert_eq!(found(&audit, "green").map, "height.png");
}

/// Every texel for itself.
fn noise() -> Raster {
    let mut random = Random::new(3, 4);
    let noise: Vec<f64> = (0..2 * SIDE * SIDE).map(|_| 0.4 * (random.uniform() - 0.5)).collect();
    let texel = |x: usize, y: usize| [noise[2 * (y * SIDE + x)], noise[2 * (y * SIDE + x) + 1]];
    map8(3, |x, y| stored(texel(x, y)[0], texel(x, y)[1]).to_vec())
}

#[test]
fn noise_and_flat_maps_have_no_convention() {
    only(&Maps::of(noise()).audit(), &[]);
    let flat = map8(3, |_, _| vec![0.5, 0.5, 1.0]);
    only(&Maps::of(flat).audit(), &["constant"]);
}

#[test]
fn srgb_normals_are_an_error_and_not_also_long() {
    let encode = |v: f64| if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    let map = map8(3, |x, y| {
        let [_, p, q] = surface(x, y);
        stored(p, q).map(encode).to_vec()
    });
    let audit = Maps::of(map).audit();
    only(&audit, &["srgb-normals"]);
    assert_eq!(audit.count(Severity::Error), 1);
}

#[test]
fn short_normals_are_found() {
    let map = |length: f64| {
        map8(3, move |x, y| {
            let [_, p, q] = surface(x, y);
            stored(p, q).map(|v| 0.5 + length * (v - 0.5)).to_vec()
        })
    };
    let audit = Maps::of(map(0.95)).audit();
    only(&audit, &["unit-length"]);
    assert_eq!(found(&audit, "unit-length").severity, Severity::Note);
    assert!(found(&audit, "unit-length").evidence.contains("mean length 0.95"), "{audit:#?}");
    let audit = Maps::of(map(0.8)).audit();
    assert_eq!(found(&audit, "unit-length").severity, Severity::Warning);
}

#[test]
fn normals_that_point_down_are_found() {
    let map = |rows: usize| {
        map8(3, move |x, y| {
            let [_, p, q] = surface(x, y);
            let n = stored(p, q);
            vec![n[0], n[1], if y < rows { 1.0 - n[2] } else { n[2] }]
        })
    };
    let audit = Maps::of(map(2)).audit();
    assert_eq!(found(&audit, "behind").severity, Severity::Warning);
    assert!(found(&audit, "behind").evidence.starts_with(&format!("{} of ", 2 * SIDE)), "{audit:#?}");
    assert_eq!(found(&Maps::of(map(SIDE / 4)).audit(), "behind").severity, Severity::Error);
}

#[test]
fn leaning_normals_are_found() {
    let audit = Maps::of(normals(|[p, q]| [p + 0.1, q])).audit();
    only(&audit, &["lean"]);
    assert_eq!(found(&audit, "lean").severity, Severity::Note);
    let audit = Maps::of(normals(|[p, q]| [p, q - 0.3])).audit();
    assert_eq!(found(&audit, "lean").severity, Severity::Warning);
}

fn through_jpeg(raster: &Raster, quality: u8) -> Raster {
    let Samples::U8(samples) = &raster.samples else { panic!("8 bit") };
    let mut bytes = Vec::new();
    let encoder = ::image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality);
    let colour = if samples.dim().2 == 1 { ::image::ExtendedColorType::L8 } else { ::image::ExtendedColorType::Rgb8 };
    let pixels = samples.as_slice().unwrap();
    ::image::ImageEncoder::write_image(encoder, pixels, SIDE as u32, SIDE as u32, colour).unwrap();
    let picture = ::image::ImageReader::with_format(Cursor::new(bytes), ::image::ImageFormat::Jpeg).decode().unwrap();
    let channels = samples.dim().2;
    let pixels = if channels == 1 { picture.into_luma8().into_raw() } else { picture.into_rgb8().into_raw() };
    Raster::new(Samples::U8(Array3::from_shape_vec((SIDE, SIDE, channels), pixels).unwrap()))
}

#[test]
fn jpeg_blocks_are_found_in_pngs_wherever_they_begin() {
    for quality in [40, 60, 80] {
        let whole = through_jpeg(&sound(), quality);
        let audit = Maps::of(whole.clone()).audit();
        assert_eq!(found(&audit, "jpeg").map, "normal.png", "quality {quality}");
        let cut = Maps(vec![("normal.png", cut(&whole, (3, 5), (SIDE - 3, SIDE - 5)))]).audit();
        assert!(found(&cut, "jpeg").evidence.contains("column 5, row 3"), "{cut:#?}");
    }
    // Other periods of 8 are not blocks: a weave changes smoothly, and joints of tiles lie at every second border.
    let weave = map8(3, |x, y| {
        let wave = |i: usize| 0.3 * (std::f64::consts::TAU * i as f64 / 8.0).cos();
        stored(wave(x), wave(y)).to_vec()
    });
    only(&Maps::of(weave).audit(), &[]);
    for period in [16, 32, 64] {
        let tiled = map8(3, |x, y| {
            let [_, p, q] = surface(x, y);
            let joint = |i: usize| if i.is_multiple_of(period) { 0.5 } else { 0.0 };
            stored(p + joint(x) - joint(x + 1), q + joint(y) - joint(y + 1)).to_vec()
        });
        only(&Maps::of(tiled).audit(), &[]);
    }
}
