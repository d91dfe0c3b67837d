//! Faults of roughness and packed maps, and of maps beside each other.

use super::*;

#[test]
fn gloss_is_found_by_name_and_by_the_bumps() {
    let patchy = |x: usize, y: usize| if (x / 64 + y / 64).is_multiple_of(2) { 1.0 } else { 0.15 };
    let normal = map8(3, |x, y| {
        let [_, p, q] = surface(x, y);
        stored(p * patchy(x, y), q * patchy(x, y)).to_vec()
    });
    let rough = |x, y| 0.2 + 0.5 * patchy(x, y) + 0.02 * surface(x, y)[0].sin();
    let set = |name, map| Maps(vec![("normal.png", normal.clone()), (name, map)]);
    only(&set("roughness.png", map8(1, |x, y| vec![rough(x, y)])).audit(), &[]);
    let gloss = || map8(1, |x, y| vec![1.0 - rough(x, y)]);
    let audit = set("roughness.png", gloss()).audit();
    only(&audit, &["gloss"]);
    let finding = found(&audit, "gloss");
    assert!(finding.severity == Severity::Note && finding.confidence < 0.5, "{finding:?}");
    let audit = set("gloss.png", gloss()).audit();
    assert_eq!(found(&audit, "gloss").severity, Severity::Warning);
    let smooth = |inputs: Inputs| Inputs {
        roughness: RoughnessInput::Smoothness(ChannelRef { path: "gloss.png".into(), channel: None }),
        ..inputs
    };
    only(&set("gloss.png", gloss()).audit_as(smooth), &[]);
}

#[test]
fn swapped_channels_of_a_packed_map_are_found() {
    let metal = |x: usize, y: usize| f64::from(u8::from((x / 40 + y / 56).is_multiple_of(3)));
    let occlusion = |x, y| 0.95 + 0.05 * (surface(x, y)[0] / 4.0).tanh();
    let packed = |order: [usize; 3]| {
        map8(3, move |x, y| {
            let texel = [occlusion(x, y), rough(x, y), metal(x, y)];
            order.map(|i| texel[i]).to_vec()
        })
    };
    only(&Maps::of(sound()).with("rough_orm.png", packed([0, 1, 2])).audit(), &[]);
    let audit = Maps::of(sound()).with("rough_orm.png", packed([0, 2, 1])).audit();
    only(&audit, &["packing"]);
    let finding = found(&audit, "packing");
    assert!(finding.severity == Severity::Warning && finding.fix.contains("FILE:b"), "{finding:?}");
    // Occlusion in green can only be supposed.
    let open = |x: usize, y: usize| if (x / 16 + y / 16).is_multiple_of(4) { 0.7 } else { 1.0 };
    let map = map8(3, |x, y| vec![rough(x, y), open(x, y), metal(x, y)]);
    let audit = Maps::of(sound()).with("rough_rma.png", map).audit();
    only(&audit, &["packing"]);
    assert_eq!((found(&audit, "packing").severity, found(&audit, "packing").channel), (Severity::Note, Some("green")));
}

#[test]
fn constants_and_lost_channels_are_found() {
    let map = map8(1, |x, _| vec![0.3 + if x % 2 == 0 { 0.002 } else { -0.002 }]);
    let audit = Maps::of(sound()).with("roughness.png", map).audit();
    only(&audit, &["constant"]);
    assert!(found(&audit, "constant").fix.contains("--roughness 0.3"), "{audit:#?}");
    let two = map8(3, |x, y| {
        let [_, p, q] = surface(x, y);
        let n = stored(p, q);
        vec![n[0], n[1], 1.0]
    });
    let audit = Maps::of(two).audit();
    let finding = found(&audit, "constant");
    assert!(finding.severity == Severity::Warning && finding.fix.contains("--normal-z rebuild"), "{finding:?}");
    let swizzled = map8(4, |x, y| {
        let [_, p, q] = surface(x, y);
        let n = stored(p, q);
        vec![1.0, n[1], 1.0, n[0]]
    });
    assert_eq!(found(&Maps::of(swizzled).audit(), "constant").severity, Severity::Error);
}

#[test]
fn steps_are_found() {
    // A mirror with bumps of a few steps.
    let low = normals(|slopes| slopes.map(|s| 0.02 * s));
    let mirror = map8(1, |x, y| vec![0.02 + 0.08 * rough(x, y)]);
    let audit = Maps::of(low).with("roughness.png", mirror).audit();
    let steps: Vec<_> = audit.findings.iter().filter(|f| f.check == "steps").collect();
    assert_eq!(steps.len(), 2, "{audit:#?}");
    assert!(steps[0].evidence.contains("1.0e-5"), "{steps:?}");
    // 8-bit content in 16 bits, widened both ways.
    for factor in [257, 256] {
        let Samples::U8(samples) = sound().samples else { panic!("8 bit") };
        let wide = Raster::new(Samples::U16(samples.mapv(|v| factor * u16::from(v))));
        let audit = Maps::of(wide).audit();
        assert!(found(&audit, "steps").evidence.starts_with("16 bits a sample"), "{audit:#?}");
    }
    let terraces = map8(1, |x, y| vec![(rough(x, y) * 8.0).round() / 8.0]);
    let audit = Maps::of(sound()).with("roughness.png", terraces).audit();
    assert!(found(&audit, "steps").evidence.contains("different values"), "{audit:#?}");
}

#[test]
fn sizes_are_compared() {
    let small = |width: usize, height: usize| {
        Raster::new(Samples::U8(Array3::from_shape_fn((height, width, 1), |(y, x, _)| byte(rough(x, y)))))
    };
    let audit = Maps::of(sound()).with("roughness.png", small(128, 128)).audit();
    only(&audit, &["set-sizes"]);
    assert_eq!(found(&audit, "set-sizes").severity, Severity::Note);
    let audit = Maps::of(sound()).with("roughness.png", small(128, 64)).audit();
    assert_eq!(found(&audit, "set-sizes").severity, Severity::Warning);
    let cut = |width, height| Maps(vec![("normal.png", cut(&sound(), (0, 0), (width, height)))]).audit();
    assert!(found(&cut(250, 200), "size").evidence.contains("multiples of 4"));
    assert!(found(&cut(252, 200), "size").evidence.contains("powers of two"));
}

#[test]
fn channels_that_nothing_reads_are_found() {
    let map = |alpha: fn(usize) -> f64| {
        map8(4, move |x, y| {
            let [_, p, q] = surface(x, y);
            let [x_, y_, z] = stored(p, q);
            vec![x_, y_, z, alpha(x)]
        })
    };
    only(&Maps::of(map(|_| 1.0)).audit(), &[]);
    let audit = Maps::of(map(|x| 0.3 + 0.001 * x as f64)).audit();
    only(&audit, &["unread"]);
    assert_eq!(found(&audit, "unread").channel, Some("alpha"));
}

#[test]
fn values_that_cannot_be_are_found() {
    let map = |texel: fn(usize) -> f32| {
        let samples = Array3::from_shape_fn((SIDE, SIDE, 1), |(y, x, _)| {
            let odd = texel(SIDE * y + x);
            if odd == 0.0 { rough(x, y) as f32 } else { odd }
        });
        Maps::of(sound()).with("roughness.png", Raster::new(Samples::F32(samples))).audit()
    };
    only(&map(|_| 0.0), &[]);
    assert_eq!(found(&map(|i| if i < 9 { 1.5 } else { 0.0 }), "values").severity, Severity::Warning);
    assert_eq!(found(&map(|i| if i % 2 == 0 { f32::NAN } else { 0.0 }), "values").severity, Severity::Error);
}

/// PNGs that say so, as codecs tell it.
#[test]
fn claims_of_colour_are_told() {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, 4, 4);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    let flat: Vec<u8> = [128, 128, 255].repeat(16);
    encoder.write_header().unwrap().write_image_data(&flat).unwrap();
    let inputs = Inputs {
        name: "set".into(),
        normal: Some("normal.png".into()),
        roughness: RoughnessInput::Constant(PerceptualRoughness(0.4)),
        ..Inputs::default()
    };
    let audit = audit(&inputs, &|path| crate::codec::decode(path, bytes.clone()));
    assert_eq!(found(&audit, "says-colour").evidence, "PNG says its data is sRGB");
}

/// Heights that go against the slopes along v only, where the curl finds nothing wrong with them.
#[test]
fn witnesses_that_differ_make_no_error() {
    let turns = |cycles: f64, x: f64| std::f64::consts::TAU * cycles * x / SIDE as f64;
    let slopes = |x: usize, y: usize| {
        let (u, v) = (x as f64, -(y as f64));
        // Waves along each axis, of which the curl knows nothing, and a few across both, which tell it the signs.
        let both = 0.1 * (turns(7.0, u) + turns(9.0, v)).cos();
        [0.2 * turns(5.0, u).cos() + 7.0 * both / 9.0, 0.2 * turns(5.0, v).cos() + both]
    };
    let normal = map8(3, |x, y| {
        let [p, q] = slopes(x, y);
        stored(p, q).to_vec()
    });
    let height = map8(1, |x, y| vec![0.5 + 0.2 * (turns(5.0, x as f64).sin() - turns(5.0, -(y as f64)).sin())]);
    let audit = Maps::of(normal).with("height.png", height).audit();
    let finding = found(&audit, "green");
    assert!(finding.severity == Severity::Warning && finding.evidence.contains("; but the curl"), "{finding:?}");
    assert!(finding.confidence <= 0.5, "{finding:?}");
}
