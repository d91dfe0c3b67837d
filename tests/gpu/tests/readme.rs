//! The README's shader compiles.

use std::fs;

use mipfold_gpu_tests::gpu::{Stage, glslang_with, has_glslang, skipped};
use mipfold_gpu_tests::source::{bundle, kernels};
use mipfold_gpu_tests::translate::Language;

/// What the README takes from the shader around it.
const AROUND: &str = "\
uniform sampler2D normal_map, roughness_map;
uniform vec3 view, light, f0;
in vec2 uv;
in vec3 n, t, b;
out vec4 colour;
";

#[test]
fn the_readmes_shader_compiles() {
    if !has_glslang() {
        return skipped("no glslangValidator");
    }
    let readme = fs::read_to_string(kernels().with_file_name("README.md")).expect("the README");
    let (_, rest) = readme.split_once("```glsl\nMfFootprint").expect("a shader in the README");
    let shader = format!("MfFootprint{}", rest.split_once("```").expect("its end").0);
    let helpers = bundle("footprint", Language::Glsl).unwrap_or_else(|e| panic!("{e}")).text;
    for version in ["330", "300 es"] {
        let colour = "colour = vec4(seen.specular + seen.diffuse, 1.0);";
        let text = format!(
            "#version {version}\nprecision highp float;\nprecision highp int;\n{helpers}\n{AROUND}void main() {{\n{shader}{colour}\n}}\n"
        );
        glslang_with(Stage::Fragment, &text, &[]).unwrap_or_else(|e| panic!("{version}:\n{e}"));
        // A name that is not there is noticed.
        let wrong = text.replace("mf_footprint_normals(f)", "mf_footprint_normal(f)");
        assert!(glslang_with(Stage::Fragment, &wrong, &[]).is_err());
    }
}
