//! What the page of three.js asks for.

use std::collections::BTreeMap;

use mipfold_gpu_tests::translate::Language;

use super::{helpers, snippet};

/// By the paths of a site.
pub fn all() -> BTreeMap<&'static str, Vec<u8>> {
    let manifest = r#"{ "wrap": "repeat", "maps": [
        { "role": "normal", "container": "png", "files": ["0.png", "1.png", "2.png"] },
        { "role": "roughness", "container": "png", "files": ["0.png", "1.png", "2.png"] }
    ] }"#;
    BTreeMap::from([
        ("/", include_bytes!("three.html").to_vec()),
        ("/mipfold.js", snippet("three/mipfold.js").into_bytes()),
        ("/helpers.glsl", helpers("geometric_aa_screen", Language::Glsl).into_bytes()),
        ("/mips/manifest.json", manifest.into()),
        ("/mips/0.png", png(4, [200, 128, 255])),
        ("/mips/1.png", png(2, [20, 128, 255])),
        ("/mips/2.png", png(1, [90, 60, 255])),
    ])
}

/// A square PNG of one colour.
fn png(side: u32, colour: [u8; 3]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, side, side);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&colour.repeat((side * side) as usize)).expect("texels");
    writer.finish().expect("an end");
    file
}
