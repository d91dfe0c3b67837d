//! How values are read where a file leaves it open, and constants that must stay themselves.

mod common;

use common::desk::Desk;
use common::{channel, exr_levels, exr32, integers, png_levels, png8};

/// A float file says by its values which reading is meant, also where nothing is negative.
#[test]
fn float_normals_are_read_as_what_is_more_nearly_unit() {
    let desk = Desk::empty();
    let lobe = |args: &str| {
        let out = desk.build("out", &format!("{args} --format exr --name m --force"));
        let base = exr_levels(&out.join("m_lobes.exr")).swap_remove(0);
        ["n.x", "n.y", "n.z"].map(|c| channel(&base, c)[0])
    };
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
    exr32(&desk.at("flat.exr"), (4, 4), &["R", "G", "B"], |_, _, c| [0.0, 0.0, 1.0][c]);
    assert!(close(lobe("--normal @flat.exr"), [0.0, 0.0, 1.0]));
    exr32(
        &desk.at("packed.exr"),
        (4, 4),
        &["R", "G", "B"],
        |x, _, c| if (x, c) == (3, 0) { -0.02 } else { [0.5, 0.5, 1.0][c] },
    );
    assert!(close(lobe("--normal @packed.exr"), [0.0, 0.0, 1.0]));
    exr32(&desk.at("lean.exr"), (4, 4), &["X", "Y"], |_, _, c| [0.6, 0.0][c]);
    assert!(close(lobe("--normal @lean.exr --normal-range signed"), [0.6, 0.0, 0.8]));
    // x = 0.2 and y = -1 leave nothing for z.
    assert!(close(
        lobe("--normal @lean.exr --normal-range unsigned"),
        [0.2 / 1.04f32.sqrt(), -1.0 / 1.04f32.sqrt(), 0.001]
    ));
}

/// A map of two widths that is the same everywhere is the same at every level, in every container.
#[test]
fn a_constant_anisotropy_map_stays_itself() {
    let desk = Desk::empty();
    png8(&desk.at("n.png"), (8, 8), |_, _| vec![128, 128, 255]);
    // All four quadrants: the two directions of an axis must not change from level to level.
    for (k, texel) in [[230, 203, 160], [26, 203, 160], [26, 52, 160], [230, 52, 160]].into_iter().enumerate() {
        png8(&desk.at("a.png"), (8, 8), |_, _| texel.to_vec());
        let out =
            desk.build(&format!("out{k}"), "--normal @n.png --anisotropy @a.png --roughness 0.4 --format exr,png");
        let levels = exr_levels(&out.join("a.exr"));
        assert_eq!(levels.len(), 4);
        for level in &levels {
            for (name, value) in ["R", "G", "B"].into_iter().zip(texel) {
                let stored = channel(level, name)[0] * 255.0;
                assert!((stored - f32::from(value)).abs() < 1.0, "{texel:?}, {name}: {stored}");
            }
        }
        for level in png_levels(&out, "a") {
            let (samples, _) = integers(&level);
            let close = samples[..3].iter().zip(texel).all(|(s, v)| (s - i64::from(v)).abs() <= 1);
            assert!(close, "{texel:?}: {samples:?}");
        }
    }
}

/// Blue may hold something else than z.
#[test]
fn rebuilt_z_leaves_a_used_blue_channel_alone() {
    let desk = Desk::empty();
    png8(&desk.at("nr.png"), (8, 8), |x, _| vec![120 + x as u8, 128, 77]);
    let out = desk.build("out", "--normal @nr.png --normal-z rebuild --roughness @nr.png:b");
    let blue = integers(&png_levels(&out, "nr")[3]).0[2];
    assert!((77..90).contains(&blue), "{blue}");
}
