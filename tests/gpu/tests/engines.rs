//! The snippets of `examples/engines`: compilers read them, they compute what their helper's twin says, and three.js's
//! draws nearer to the truth than three.js does.
//!
//! What stands around a snippet in its engine is declared here, as little of it as the snippet uses: no engine but
//! three.js is run. For that, `MIPFOLD_THREE` is the folder of the npm package `three`, and `MIPFOLD_CHROMIUM` the
//! Chromium or Chrome to use, by default `chromium`.

use std::fs;

use glam::DVec3;
use mipfold_gpu_tests::case::SplitMix;
use mipfold_gpu_tests::gpu::{CALLS_AT_ONCE, Gpu, Program, Stage, glslang_with, gpu, has_glslang, say, skipped};
use mipfold_gpu_tests::source::{bundle, kernels};
use mipfold_gpu_tests::translate::Language;
use mipfold_gpu_tests::twins::geometric_aa::{MOST_ADDED, SIGMA2_PEAK, aa_2021_normals};

#[allow(dead_code, reason = "other tests ask for more")]
#[path = "../../common/browser.rs"]
mod browser;
#[path = "engines/files.rs"]
mod files;
use browser::{Seen, Site, below, chromium, three};

fn snippet(path: &str) -> String {
    let path = kernels().with_file_name("examples").join("engines").join(path);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The text that `mipfold kernels SUBJECT --lang LANGUAGE --bundle` prints, but for guards against a second inclusion.
fn helpers(subject: &str, language: Language) -> String {
    bundle(subject, language).unwrap_or_else(|e| panic!("{e}")).text
}

/// A text with its only `part` replaced.
fn replaced(text: &str, part: &str, by: &str) -> String {
    assert_eq!(text.matches(part).count(), 1, "'{part}' in\n{text}");
    text.replace(part, by)
}

/// Unity's include file, with `mf_test_engine(roughness, normal)` over both of its functions.
fn unity() -> String {
    let helpers = helpers("geometric_aa_screen", Language::Hlsl);
    let text = replaced(&snippet("unity/MipfoldCurvature.hlsl"), "#include \"geometric_aa_screen.hlsl\"", &helpers);
    format!(
        "{text}
float mf_test_engine(float roughness, float3 normal) {{
    float filtered;
    MipfoldCurvature_float(1.0 - roughness, normal, filtered);
    half less;
    MipfoldCurvature_half(half(1.0 - roughness), half3(normal), less);
    return abs(filtered - float(less)) < 0.001 ? 1.0 - filtered : -1.0;
}}
"
    )
}

/// Unreal's code, as the body of a function whose arguments are the node's inputs.
fn unreal() -> String {
    let (helpers, body) = (helpers("geometric_aa_screen", Language::Hlsl), snippet("unreal/CustomNode.usf"));
    format!(
        "{helpers}
float CustomExpression0(float3 Normal, float Roughness) {{
{body}
}}
float mf_test_engine(float roughness, float3 normal) {{
    return CustomExpression0(normal, roughness);
}}
"
    )
}

/// A translation of Godot's shader into GLSL: built-ins are variables, hints are left out, maps hold one texel.
fn godot() -> String {
    let mut text = String::from(
        "vec2 UV;\nvec3 NORMAL, NORMAL_MAP, ALBEDO;\nfloat NORMAL_MAP_DEPTH, AO, METALLIC, ROUGHNESS;\nvec4 mf_test_texel;\n\
         vec4 mf_test_texture(int map, vec2 uv) { return mf_test_texel; }\n",
    );
    for line in snippet("godot/curvature.gdshader").lines() {
        if line == "#include \"geometric_aa.gdshaderinc\"" {
            text += &helpers("geometric_aa", Language::Glsl);
        } else if let Some(uniform) = line.strip_prefix("uniform ") {
            let (named, hints) = uniform.split_once(" : ").expect("a hint");
            let value = hints.trim_end_matches(';').split_once(" = ").map_or("0", |(_, value)| value);
            text += &format!("const {} = {value};", named.replace("sampler2D", "int"));
        } else if line != "shader_type spatial;" {
            text += &line.replace("texture(", "mf_test_texture(");
        }
        text += "\n";
    }
    text + "
float mf_test_engine(float roughness, vec3 normal) {
    mf_test_texel = vec4(1.0, roughness, 0.0, 1.0);
    NORMAL = normal;
    fragment();
    return ROUGHNESS;
}
"
}

/// What Bevy's modules declare, with the fields and functions that the snippet uses.
const BEVY: &str = "
struct VertexOutput {
    world_normal: vec3<f32>,
}
struct FragmentOutput {
    color: vec4<f32>,
}
struct StandardMaterial {
    base_color: vec4<f32>,
    perceptual_roughness: f32,
    clearcoat_perceptual_roughness: f32,
    flags: u32,
    alpha_cutoff: f32,
}
struct PbrInput {
    material: StandardMaterial,
    world_normal: vec3<f32>,
}
var<private> mf_test_roughness: f32;
fn pbr_input_from_standard_material(in: VertexOutput, is_front: bool) -> PbrInput {
    var pbr: PbrInput;
    pbr.material.perceptual_roughness = mf_test_roughness;
    pbr.material.clearcoat_perceptual_roughness = mf_test_roughness;
    pbr.world_normal = in.world_normal;
    return pbr;
}
fn alpha_discard(material_flags: u32, alpha_cutoff: f32, output_color: vec4<f32>) -> vec4<f32> {
    return output_color;
}
fn apply_pbr_lighting(in: PbrInput) -> vec4<f32> {
    return vec4<f32>(in.material.perceptual_roughness, in.material.clearcoat_perceptual_roughness, 0.0, 1.0);
}
fn main_pass_post_lighting_processing(pbr_input: PbrInput, input_color: vec4<f32>) -> vec4<f32> {
    return input_color;
}
fn deferred_output(in: VertexOutput, pbr_input: PbrInput) -> FragmentOutput {
    return FragmentOutput(apply_pbr_lighting(pbr_input));
}
";

/// A translation of Bevy's shader from WESL into WGSL, of its forward or its deferred variant: imports are replaced by
/// what they name, and the entry point is a function.
fn bevy(deferred: bool) -> String {
    let text = snippet("bevy/curvature.wesl");
    // Statements of the top level up to the first function, and that with what follows.
    let start = text.find("// Perceptual roughness").expect("a first function");
    let (imports, mut rest) = (&text[..start], text[start..].to_string());
    let code: String = imports.lines().filter(|line| !line.starts_with("//")).collect::<Vec<_>>().join("\n");
    let mut statements: Vec<&str> = code.split(';').map(str::trim).collect();
    assert_eq!(statements.pop(), Some(""), "imports end with semicolons");
    let declared = format!("{}\n{BEVY}", helpers("geometric_aa_screen", Language::Wgsl));
    for statement in statements {
        let (condition, import) = statement.split_once("import ").expect("an import");
        let wanted = match condition.trim() {
            "" => true,
            "@if(PREPASS_PIPELINE)" => deferred,
            "@else" => !deferred,
            other => panic!("{other}"),
        };
        let names = import.split(['{', '}', ',', ' ', '\n']).filter_map(|path| path.rsplit("::").next());
        for name in names.filter(|name| wanted && !name.is_empty()) {
            let starts = ["fn ", "struct ", "const "].map(|word| format!("\n{word}{name}"));
            let found = starts.iter().any(|start| {
                declared.match_indices(start.as_str()).any(|(at, _)| !declared[at + start.len()..].starts_with(is_word))
            });
            assert!(found, "{name} is imported and not declared");
        }
    }
    let (before, branches) = rest.split_once("    @if(PREPASS_PIPELINE) {").expect("a branch");
    let (first, branches) = branches.split_once("} @else {").expect("another branch");
    let (second, after) = branches.split_once('}').expect("its end");
    rest = format!("{before}{}{after}", if deferred { first } else { second });
    rest = replaced(&rest, "@fragment\n", "").replace("@builtin(front_facing) ", "");
    format!(
        "{declared}\n{rest}
fn mf_test_engine(roughness: f32, normal: vec3f) -> f32 {{
    mf_test_roughness = roughness;
    let seen = fragment(VertexOutput(normal), true).color;
    return select(-1.0, seen.x, seen.x == seen.y);
}}
"
    )
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Calls `mf_test_engine` with a roughness and a normal of each pixel.
fn with_entry(language: Language, text: &str) -> String {
    let at_once = CALLS_AT_ONCE.to_string();
    match language {
        Language::Wgsl => WGSL,
        Language::Glsl => GLSL,
        Language::Hlsl => HLSL,
    }
    .replace("AT_ONCE", &at_once)
    .replace("SNIPPET", text)
}

const WGSL: &str = "
@group(0) @binding(0) var<storage, read_write> mf_test_in: array<u32>;
@group(0) @binding(1) var<storage, read_write> mf_test_out: array<u32>;
SNIPPET
fn mf_test_f(i: u32) -> f32 { return bitcast<f32>(mf_test_in[i]); }
@fragment
fn main(@builtin(position) p: vec4f) -> @location(0) vec4f {
    let at = vec2u(p.xy);
    let i = 4u * (at.y / 2u * AT_ONCEu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    let normal = vec3f(mf_test_f(4u * i), mf_test_f(4u * i + 1u), mf_test_f(4u * i + 2u));
    mf_test_out[i] = bitcast<u32>(mf_test_engine(mf_test_f(4u * i + 3u), normal));
    return vec4f(0.0);
}
";
const GLSL: &str = "#version 450
precision highp float;
layout(std430, set = 0, binding = 0) buffer MfTestIn { uint mf_test_in[]; };
layout(std430, set = 0, binding = 1) buffer MfTestOut { uint mf_test_out[]; };
layout(location = 0) out vec4 mf_test_colour;
SNIPPET
float mf_test_f(uint i) { return uintBitsToFloat(mf_test_in[i]); }
void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint i = 4u * (at.y / 2u * AT_ONCEu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    vec3 normal = vec3(mf_test_f(4u * i), mf_test_f(4u * i + 1u), mf_test_f(4u * i + 2u));
    mf_test_out[i] = floatBitsToUint(mf_test_engine(mf_test_f(4u * i + 3u), normal));
    mf_test_colour = vec4(0.0);
}
";
const HLSL: &str = "
RWStructuredBuffer<uint> mf_test_in : register(u0);
RWStructuredBuffer<uint> mf_test_out : register(u1);
SNIPPET
float mf_test_f(uint i) { return asfloat(mf_test_in[i]); }
float4 main(float4 p : SV_Position) : SV_Target0 {
    uint2 at = uint2(p.xy);
    uint i = 4u * (at.y / 2u * AT_ONCEu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    float3 normal = float3(mf_test_f(4u * i), mf_test_f(4u * i + 1u), mf_test_f(4u * i + 2u));
    mf_test_out[i] = asuint(mf_test_engine(mf_test_f(4u * i + 3u), normal));
    return float4(0.0, 0.0, 0.0, 0.0);
}
";

/// Lets the language's front end read the text.
fn compile(language: Language, text: &str) -> Result<(), String> {
    if language == Language::Wgsl {
        use wgpu::naga::{front::wgsl::parse_str, valid};
        let module = parse_str(text).map_err(|e| e.emit_to_string(text))?;
        let mut validator = valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::empty());
        return validator.validate(&module).map(|_| ()).map_err(|e| e.emit_to_string(text));
    }
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let out = folder.path().join("out.spv");
    let out = out.to_str().expect("a path of text");
    let arguments: &[&str] =
        if language == Language::Hlsl { &["-V", "-D", "-e", "main", "-o", out] } else { &["-V", "-o", out] };
    glslang_with(Stage::Fragment, text, arguments)
}

/// Calls of each snippet, in quads of pixels.
const QUADS: usize = 4 * CALLS_AT_ONCE;

/// Compiles a snippet and sees that a wrong name in a `call` is noticed; compares what it computes with the twin, and sees
/// that a wrong formula is noticed: `alpha` in place of `alpha * alpha`.
fn check(name: &str, language: Language, snippet: &str, call: &str) {
    let text = with_entry(language, snippet);
    compile(language, &text).unwrap_or_else(|e| panic!("{name}:\n{e}"));
    let wrong = replaced(&text, call, &call.replace('(', "s("));
    assert!(compile(language, &wrong).is_err(), "{name}: a wrong name goes unnoticed");
    let Some(gpu) = gpu() else { return skipped("no Vulkan adapter") };
    let worst = |text: &str| error(gpu, language, text).unwrap_or_else(|e| panic!("{name}:\n{e}"));
    let most = worst(&text);
    say(&format!("{name}: within {most:.1e} of the twin, over {QUADS} quads\n"));
    assert!(most < 1e-6, "{name}");
    assert!(worst(&replaced(&text, "alpha * alpha", "alpha")) > 0.1, "{name}: a wrong formula goes unnoticed");
}

/// How far the roughness that a shader returns is from the twin's at most; infinite where one is not a number.
fn error(gpu: &Gpu, language: Language, text: &str) -> Result<f64, String> {
    let mut random = SplitMix(0xE6);
    let (mut words, mut expected) = (Vec::new(), Vec::new());
    for _ in 0..QUADS {
        let mut sphere = || DVec3::from_array([0; 3].map(|_| 2.0 * random.unit() - 1.0)).normalize();
        let (n, x, y) = (sphere(), sphere(), sphere());
        // From none to more than the clamp lets through.
        let bend = if random.unit() < 0.1 { 0.0 } else { 2.0 * random.unit().powi(3) };
        let roughness = random.unit() as f32;
        let quad = [n, n + bend * x, n + bend * y, n + bend * (x + y)].map(|n| n.normalize_or(DVec3::Z).as_vec3());
        for n in quad {
            words.extend([n.x, n.y, n.z, roughness].map(f32::to_bits));
        }
        let [n, x, y, _] = quad.map(|n| n.as_dvec3().normalize());
        let alpha2 = f64::from(roughness).powi(4);
        expected.push(aa_2021_normals(alpha2, x - n, y - n, SIGMA2_PEAK, MOST_ADDED).sqrt().sqrt());
    }
    let program = Program::new(language, Stage::Fragment, text)?;
    let out = gpu.run(&program, 0, QUADS, &words, 4 * QUADS)?;
    // Coarse derivatives and fine ones agree at the first pixel of a quad.
    let errors =
        expected.iter().enumerate().map(|(quad, twin)| (f64::from(f32::from_bits(out[4 * quad])) - twin).abs());
    Ok(errors.fold(0.0, |most, e| if e.is_nan() { f64::INFINITY } else { most.max(e) }))
}

#[test]
fn unitys_include_file() {
    if !has_glslang() {
        return skipped("no glslangValidator");
    }
    check("Unity", Language::Hlsl, &unity(), "mf_aa_screen_normal(alpha * alpha");
}

#[test]
fn unreals_custom_node() {
    if !has_glslang() {
        return skipped("no glslangValidator");
    }
    check("Unreal", Language::Hlsl, &unreal(), "mf_aa_screen_normal(alpha * alpha");
}

#[test]
fn godots_shader_translated_into_glsl() {
    if !has_glslang() {
        return skipped("no glslangValidator");
    }
    check("Godot", Language::Glsl, &godot(), "mf_aa_2021_normals(alpha * alpha");
}

#[test]
fn bevys_shader_translated_into_wgsl() {
    check("Bevy", Language::Wgsl, &bevy(false), "apply_pbr_lighting(pbr)");
    check("Bevy, deferred", Language::Wgsl, &bevy(true), "deferred_output(in, pbr)");
}

/// Bevy's Rust: its grammar, and that it names the shader by its name.
#[test]
fn bevys_material_is_rust() {
    let text = snippet("bevy/curvature.rs");
    let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{e}"));
    let implemented = file.items.iter().filter_map(|item| match item {
        syn::Item::Impl(block) => block.trait_.as_ref(),
        _ => None,
    });
    assert!(implemented.into_iter().any(|(path, _)| path.is_ident("MaterialExtension")));
    assert_eq!(text.matches("\"shaders/curvature.wesl\"").count(), 2);
    assert!(syn::parse_file(&text.replace("-> ShaderRef {", "-> ShaderRef")).is_err());
}

#[test]
fn three_draws_nearer_to_the_truth() {
    let (three, chromium) = match (three(), chromium()) {
        (Ok(three), Ok(chromium)) => (three, chromium),
        (Err(why), _) | (_, Err(why)) => return skipped(&why),
    };
    let files = files::all();
    let site = Site::new(move |path| files.get(path).cloned().or_else(|| below(&three, "/three/", path)));
    let Seen { found, console } = site.open(&chromium, "");
    assert!(console.is_empty(), "{console:#?}");
    assert!(found.contains_key("no map"), "the page does not come to its end: {found:#?}");

    // Root mean square error of linear light, and light over that of the truth.
    let mut cases = 0;
    for scene in ["bumpy", "far"] {
        for roughness in ["0.15", "0.25", "0.4"] {
            let [none, three, mipfold] = ["no filter", "three", "mipfold"].map(|kind| {
                let line = &found[&format!("{scene} {roughness} {kind}")];
                let (error, light) = line.split_once(' ').expect("two numbers");
                (error.parse::<f64>().expect("a number"), light.parse::<f64>().expect("a number"))
            });
            say(&format!(
                "three.js, {scene}, roughness {roughness}: {none:?} unfiltered, {three:?} three, {mipfold:?}\n"
            ));
            assert!(mipfold.0 < 0.75 * none.0 && mipfold.0 < 0.98 * three.0 && mipfold.1 <= three.1 + 0.01);
            cases += 1;
        }
    }
    assert_eq!(cases, 6);

    // The mips that were loaded, and what three makes of the first of them.
    assert_eq!(found["folded"], "200 128 255,20 128 255,90 60 255");
    assert_eq!(found["generated"], "200 128 255,200 128 255,200 128 255");
    assert_eq!(found["chained"], "1");
    assert!(found["twice"].contains("has 0 times '#include <lights_physical_fragment>'"), "{}", found["twice"]);
    assert!(found["no map"].contains("no PNG with role 'height'"), "{}", found["no map"]);

    // The console is listened to: a helper that is not there is heard.
    let wrong = site.open(&chromium, "?wrong");
    assert!(wrong.console.iter().any(|line| line.contains("Shader Error")), "{:#?}", wrong.console);
}
