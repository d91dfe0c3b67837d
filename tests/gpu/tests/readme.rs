//! The README's shaders compile.

use std::fs;

use mipfold_gpu_tests::gpu::{Stage, glslang_with, has_glslang, skipped};
use mipfold_gpu_tests::source::{bundle, generated, kernels};
use mipfold_gpu_tests::translate::Language;

/// What the README takes from the shader around it.
const AROUND: &str = "\
uniform sampler2D normal_map, roughness_map, flakes_map;
uniform float density, size_variation;
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
    let (lobe, rest) = rest.split_once("```").expect("its end");
    let (_, rest) = rest.split_once("```glsl\nvec2 place").expect("a shader of flakes after it");
    let (flakes, _) = rest.split_once("```").expect("its end");
    let helpers = |subject| bundle(subject, Language::Glsl).unwrap_or_else(|e| panic!("{e}")).text;
    let smooth = format!("MfFootprint{lobe}colour = vec4(seen.specular + seen.diffuse, 1.0);");
    let glints = format!("MfFootprint{lobe}vec2 place{flakes}colour = vec4(glinting.specular, 1.0);");
    let more = ["glint_chance", "glint", "glint_field"]
        .map(|s| generated(s, Language::Glsl).unwrap_or_else(|e| panic!("{e}")));
    let both = helpers("footprint") + &more.concat();
    for (helpers, shader) in [(helpers("footprint"), smooth), (both, glints)] {
        for version in ["330", "300 es"] {
            let text = format!(
                "#version {version}\nprecision highp float;\nprecision highp int;\n{helpers}\n{AROUND}void main() {{\n{shader}\n}}\n"
            );
            glslang_with(Stage::Fragment, &text, &[]).unwrap_or_else(|e| panic!("{version}:\n{e}"));
            // A name that is not there is noticed.
            let wrong = text.replace("mf_footprint_normals(f)", "mf_footprint_normal(f)");
            assert!(glslang_with(Stage::Fragment, &wrong, &[]).is_err());
        }
    }
}
