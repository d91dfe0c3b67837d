//! Makes a shader of functions: it reads their arguments from a buffer, calls one of them and writes what comes back.

use std::fmt::Write;

use crate::gpu::{CALLS_AT_ONCE, Stage};
use crate::source::Bundle;
use crate::translate::{Function, Language, Names, translate};

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// As its bits.
    F32,
    /// Itself.
    U32,
    /// As its bits.
    I32,
    /// 0 or 1.
    Bool,
}

impl Scalar {
    /// As its own type holds it; an error if it cannot.
    pub fn rounded(self, v: f64) -> Option<f64> {
        let whole = |low: f64, high: f64| (v.fract() == 0.0 && (low..=high).contains(&v)).then_some(v);
        match self {
            Self::F32 => Some(f64::from(v as f32)),
            Self::U32 => whole(0.0, f64::from(u32::MAX)),
            Self::I32 => whole(f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::Bool => whole(0.0, 1.0),
        }
    }

    /// As a word of a buffer.
    pub fn word(self, v: f64) -> u32 {
        match self {
            Self::F32 => (v as f32).to_bits(),
            Self::U32 | Self::Bool => v as u32,
            Self::I32 => (v as i32).cast_unsigned(),
        }
    }

    /// Of a word of a buffer.
    pub fn value(self, word: u32) -> f64 {
        match self {
            Self::F32 => f64::from(f32::from_bits(word)),
            Self::U32 | Self::Bool => f64::from(word),
            Self::I32 => f64::from(word.cast_signed()),
        }
    }
}

/// The bundle with buffers, a caller for each function, and an entry point `main` that calls the one that the constant
/// `mf_test_which` says. (As an argument, so that no compiler folds expressions of it: naga reads none in SPIR-V.)
pub fn wrapped(bundle: &Bundle, language: Language, stage: Stage, functions: &[Function]) -> Result<String, String> {
    let mut names = bundle.names.clone();
    let helpers = [
        ("f", "f32", vec!["u32"]),
        ("u", "u32", vec!["u32"]),
        ("put_f", "u32", vec!["u32", "f32"]),
        ("put_u", "u32", vec!["u32", "u32"]),
    ];
    for (name, result, arguments) in helpers {
        names.functions.push(Function {
            name: format!("mf_test_{name}"),
            arguments: arguments.into_iter().map(|kind| ("i".to_string(), kind.to_string())).collect(),
            result: result.to_string(),
        });
    }
    let mut text: String = functions.iter().enumerate().map(|(i, f)| caller(&names, i, f)).collect();
    text += "// Calls the one that is chosen.\nfn mf_test_call(which: u32, i: u32) -> u32 {\n    var done: u32 = 0u;\n";
    for (i, function) in functions.iter().enumerate() {
        let count = |kind: &str| {
            let mut all = Vec::new();
            scalars(&names, kind, &mut all);
            all.len()
        };
        let arguments: usize = function.arguments.iter().map(|(_, kind)| count(kind)).sum();
        let call = format!("mf_test_call_{i}(i * {arguments}u, i * {}u)", count(&function.result));
        writeln!(text, "    if (which == {i}u) {{\n        done = {call};\n    }}").expect("text");
    }
    text += "    return done;\n}\n";
    let callers = translate(&text, language, false, &mut names).map_err(|wrong| format!("callers:{wrong}"))?;
    let (start, entry) = match (language, stage) {
        (Language::Wgsl, Stage::Compute) => (WGSL, WGSL_COMPUTE),
        (Language::Wgsl, Stage::Fragment) => (WGSL, WGSL_FRAGMENT),
        (Language::Glsl, Stage::Compute) => (GLSL, GLSL_COMPUTE),
        (Language::Glsl, Stage::Fragment) => (GLSL, GLSL_FRAGMENT),
        (Language::Hlsl, Stage::Compute) => (HLSL, HLSL_COMPUTE),
        (Language::Hlsl, Stage::Fragment) => (HLSL, HLSL_FRAGMENT),
    };
    let entry = entry.replace("AT_ONCE", &CALLS_AT_ONCE.to_string());
    Ok(format!("{start}\n{}\n{callers}\n{entry}", bundle.text))
}

/// In the restricted WGSL: calls one function with the arguments at `i`, and writes the result at `o`.
fn caller(names: &Names, which: usize, function: &Function) -> String {
    let mut body = String::new();
    let mut at = 0;
    for (i, (_, kind)) in function.arguments.iter().enumerate() {
        read(names, &format!("a{i}"), kind, &mut at, &mut body);
    }
    let arguments: Vec<String> = (0..function.arguments.len()).map(|i| format!("a{i}")).collect();
    let (name, kind) = (&function.name, &function.result);
    writeln!(body, "    let r: {kind} = {name}({});\n    var done: u32 = 0u;", arguments.join(", ")).expect("text");
    let mut at = 0;
    store(names, "r", kind, &mut at, &mut body);
    format!("// Calls {name}.\nfn mf_test_call_{which}(i: u32, o: u32) -> u32 {{\n{body}    return done;\n}}\n\n")
}

/// Component type and number of components of a type that is no struct.
fn components(kind: &str) -> (Scalar, usize) {
    let count = kind.strip_prefix("vec").map_or(1, |rest| usize::from(rest.as_bytes()[0] - b'0'));
    let scalar = match kind {
        "u32" => Scalar::U32,
        "i32" => Scalar::I32,
        "bool" => Scalar::Bool,
        _ if kind.ends_with('u') => Scalar::U32,
        _ if kind.ends_with('i') => Scalar::I32,
        _ => Scalar::F32,
    };
    (scalar, count)
}

/// Appends the scalars of a type in order.
pub fn scalars(names: &Names, kind: &str, out: &mut Vec<Scalar>) {
    match names.structs.get(kind) {
        Some(fields) => fields.iter().for_each(|(_, field)| scalars(names, field, out)),
        None => {
            let (scalar, count) = components(kind);
            out.extend(std::iter::repeat_n(scalar, count));
        }
    }
}

/// Statements that make the variable `name` from the words at `at`.
fn read(names: &Names, name: &str, kind: &str, at: &mut usize, out: &mut String) {
    if let Some(fields) = names.structs.get(kind) {
        for (field, field_kind) in fields {
            read(names, &format!("{name}_{field}"), field_kind, at, out);
        }
        writeln!(out, "    var {name}: {kind};").expect("text");
        for (field, _) in fields {
            writeln!(out, "    {name}.{field} = {name}_{field};").expect("text");
        }
        return;
    }
    let (scalar, count) = components(kind);
    let mut next = || {
        *at += 1;
        let at = *at - 1;
        match scalar {
            Scalar::F32 => format!("mf_test_f(i + {at}u)"),
            Scalar::U32 => format!("mf_test_u(i + {at}u)"),
            Scalar::I32 => format!("i32(mf_test_u(i + {at}u))"),
            Scalar::Bool => format!("mf_test_u(i + {at}u) != 0u"),
        }
    };
    let values: Vec<String> = (0..count).map(|_| next()).collect();
    let value = if count == 1 { values[0].clone() } else { format!("{kind}({})", values.join(", ")) };
    writeln!(out, "    let {name}: {kind} = {value};").expect("text");
}

/// Statements that write the value `name` to the words at `at`.
fn store(names: &Names, name: &str, kind: &str, at: &mut usize, out: &mut String) {
    if let Some(fields) = names.structs.get(kind) {
        for (field, field_kind) in fields {
            store(names, &format!("{name}.{field}"), field_kind, at, out);
        }
        return;
    }
    let (scalar, count) = components(kind);
    for i in 0..count {
        let value = if count == 1 { name.to_string() } else { format!("{name}.{}", ["x", "y", "z", "w"][i]) };
        let place = format!("o + {at}u");
        let statement = match scalar {
            Scalar::F32 => format!("done = done + mf_test_put_f({place}, {value});"),
            Scalar::U32 => format!("done = done + mf_test_put_u({place}, {value});"),
            Scalar::I32 => format!("done = done + mf_test_put_u({place}, u32({value}));"),
            Scalar::Bool => {
                let one = format!("if ({value}) {{\n        done = done + mf_test_put_u({place}, 1u);\n    }}");
                format!("done = done + mf_test_put_u({place}, 0u);\n    {one}")
            }
        };
        writeln!(out, "    {statement}").expect("text");
        *at += 1;
    }
}

const WGSL: &str = "
const mf_test_which: u32 = WHICHu;
@group(0) @binding(0) var<storage, read_write> mf_test_in: array<u32>;
@group(0) @binding(1) var<storage, read_write> mf_test_out: array<u32>;
fn mf_test_f(i: u32) -> f32 { return bitcast<f32>(mf_test_in[i]); }
fn mf_test_u(i: u32) -> u32 { return mf_test_in[i]; }
fn mf_test_put_f(i: u32, v: f32) -> u32 { mf_test_out[i] = bitcast<u32>(v); return 0u; }
fn mf_test_put_u(i: u32, v: u32) -> u32 { mf_test_out[i] = v; return 0u; }
";
const WGSL_COMPUTE: &str = "
@compute @workgroup_size(AT_ONCE)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let done = mf_test_call(mf_test_which, id.x);
}
";
const WGSL_FRAGMENT: &str = "
@fragment
fn main(@builtin(position) p: vec4f) -> @location(0) vec4f {
    let at = vec2u(p.xy);
    let i = 4u * (at.y / 2u * AT_ONCEu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    return vec4f(f32(mf_test_call(mf_test_which, i)));
}
";
const GLSL: &str = "#version 450
precision highp float;
layout(constant_id = 0) const uint mf_test_which = 0u;
layout(std430, set = 0, binding = 0) buffer MfTestIn { uint mf_test_in[]; };
layout(std430, set = 0, binding = 1) buffer MfTestOut { uint mf_test_out[]; };
float mf_test_f(uint i) { return uintBitsToFloat(mf_test_in[i]); }
uint mf_test_u(uint i) { return mf_test_in[i]; }
uint mf_test_put_f(uint i, float v) { mf_test_out[i] = floatBitsToUint(v); return 0u; }
uint mf_test_put_u(uint i, uint v) { mf_test_out[i] = v; return 0u; }
";
const GLSL_COMPUTE: &str = "
layout(local_size_x = AT_ONCE) in;
void main() {
    mf_test_call(mf_test_which, gl_GlobalInvocationID.x);
}
";
const GLSL_FRAGMENT: &str = "
layout(location = 0) out vec4 mf_test_colour;
void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint i = 4u * (at.y / 2u * AT_ONCEu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    mf_test_colour = vec4(float(mf_test_call(mf_test_which, i)));
}
";
const HLSL: &str = "
[[vk::constant_id(0)]] const uint mf_test_which = 0u;
RWStructuredBuffer<uint> mf_test_in : register(u0);
RWStructuredBuffer<uint> mf_test_out : register(u1);
float mf_test_f(uint i) { return asfloat(mf_test_in[i]); }
uint mf_test_u(uint i) { return mf_test_in[i]; }
uint mf_test_put_f(uint i, float v) { mf_test_out[i] = asuint(v); return 0u; }
uint mf_test_put_u(uint i, uint v) { mf_test_out[i] = v; return 0u; }
";
const HLSL_COMPUTE: &str = "
[numthreads(AT_ONCE, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    mf_test_call(mf_test_which, id.x);
}
";
const HLSL_FRAGMENT: &str = "
float4 main(float4 p : SV_Position) : SV_Target0 {
    uint2 at = uint2(p.xy);
    uint i = 4u * (at.y / 2u * AT_ONCEu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    float done = float(mf_test_call(mf_test_which, i));
    return float4(done, done, done, done);
}
";
