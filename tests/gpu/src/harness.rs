//! Calls every function of a file in each language, and compares what comes back with its twin.

use std::fmt::Write;

use crate::case::Case;
use crate::gpu::{Gpu, QUADS_A_ROW, Shader, Stage};
use crate::source::{Bundle, bundle, is_screen};
use crate::translate::{Function, Language, Names, translate};

/// What became of one function.
pub struct Row {
    /// The function.
    pub name: &'static str,
    /// How often it was called.
    pub calls: usize,
    /// The worst call in each language, or what its compiler said.
    pub results: Vec<(Language, Result<Worst, String>)>,
}

/// The call that is the furthest from its twin.
pub struct Worst {
    /// Error as a share of the bound.
    pub share: f64,
    /// Its arguments, as they were rounded.
    pub arguments: Vec<f64>,
    /// What the shader returned.
    pub shader: Vec<f64>,
    /// What the twin returned.
    pub twin: Vec<f64>,
}

impl Row {
    /// One line for each language that is out of bounds or does not compile.
    pub fn failures(&self) -> String {
        let mut out = String::new();
        for (language, result) in &self.results {
            let (name, language) = (self.name, language.name());
            match result {
                Err(wrong) => writeln!(out, "{name} ({language}): {wrong}"),
                Ok(Worst { share, arguments, shader, twin }) if share.is_nan() || *share > 1.0 => {
                    let finite = if shader.iter().all(|v| v.is_finite()) { "" } else { "not finite, " };
                    let at = format!("{arguments:?}: {shader:?}, twin {twin:?}");
                    writeln!(out, "{name} ({language}): {finite}{share:.3} of its bound at {at}")
                }
                Ok(_) => Ok(()),
            }
            .expect("text");
        }
        out
    }
}

/// One table for all functions: the worst error in each language as a share of its bound, and the number of calls.
pub fn table(rows: &[Row]) -> String {
    let width = rows.iter().map(|r| r.name.len()).max().unwrap_or(0).max("function".len());
    let mut out = format!("{:width$}  {:>7}  {:>7}  {:>7}  {:>6}\n", "function", "wgsl", "glsl", "hlsl", "calls");
    for row in rows {
        write!(out, "{:width$}", row.name).expect("text");
        for language in Language::ALL {
            let result = row.results.iter().find(|r| r.0 == language);
            let text = match result {
                None => "-".to_string(),
                Some((_, Err(_))) => "error".to_string(),
                Some((_, Ok(worst))) => format!("{:.3}", worst.share),
            };
            write!(out, "  {text:>7}").expect("text");
        }
        writeln!(out, "  {:>6}", row.calls).expect("text");
    }
    out
}

/// Runs the cases of a file in the languages; `Err` where the file itself cannot be read or has no such function.
pub fn run(gpu: &Gpu, subject: &str, cases: Vec<Case>, languages: &[Language]) -> Result<Vec<Row>, String> {
    let bundles: Vec<Bundle> = languages.iter().map(|&l| bundle(subject, l)).collect::<Result<_, _>>()?;
    let mut rows = Vec::new();
    for case in cases {
        let Some(function) = bundles[0].names.function(case.name) else {
            return Err(format!("kernels/wgsl/{subject}.wgsl has no function {}", case.name));
        };
        let calls = Calls::new(&bundles[0].names, function, &case, is_screen(subject))?;
        let run_in = |(&language, bundle): (&Language, &Bundle)| (language, calls.run(gpu, language, bundle, &case));
        rows.push(Row {
            name: case.name,
            calls: case.inputs.len(),
            results: languages.iter().zip(&bundles).map(run_in).collect(),
        });
    }
    Ok(rows)
}

/// The arguments of all calls as the shader gets them.
struct Calls {
    function: Function,
    stage: Stage,
    arguments: Vec<Scalar>,
    results: Vec<Scalar>,
    /// Rounded as the shader gets them; of a quad of pixels, the four after one another.
    rounded: Vec<Vec<f64>>,
}

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    F32,
    U32,
    I32,
    Bool,
}

impl Scalar {
    /// As its own type holds it; an error if it cannot.
    fn rounded(self, v: f64) -> Option<f64> {
        let whole = |low: f64, high: f64| (v.fract() == 0.0 && (low..=high).contains(&v)).then_some(v);
        match self {
            Self::F32 => Some(f64::from(v as f32)),
            Self::U32 => whole(0.0, f64::from(u32::MAX)),
            Self::I32 => whole(f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::Bool => whole(0.0, 1.0),
        }
    }

    fn word(self, v: f64) -> u32 {
        match self {
            Self::F32 => (v as f32).to_bits(),
            Self::U32 | Self::Bool => v as u32,
            Self::I32 => (v as i32).cast_unsigned(),
        }
    }

    fn value(self, word: u32) -> f64 {
        match self {
            Self::F32 => f64::from(f32::from_bits(word)),
            Self::U32 | Self::Bool => f64::from(word),
            Self::I32 => f64::from(word.cast_signed()),
        }
    }
}

impl Calls {
    fn new(names: &Names, function: &Function, case: &Case, screen: bool) -> Result<Self, String> {
        let mut arguments = Vec::new();
        function.arguments.iter().for_each(|(_, kind)| flatten(names, kind, &mut arguments));
        let mut results = Vec::new();
        flatten(names, &function.result, &mut results);
        let wanted = if screen { 3 * arguments.len() } else { arguments.len() };
        let mut rounded = Vec::new();
        for call in &case.inputs {
            if call.len() != wanted {
                return Err(format!("{} is called with {} scalars, not {wanted}: {call:?}", case.name, call.len()));
            }
            let pixels = if screen { quad(call) } else { vec![call.clone()] };
            let values: Option<Vec<f64>> =
                pixels.iter().flat_map(|p| p.iter().zip(&arguments)).map(|(&v, s)| s.rounded(v)).collect();
            rounded.push(
                values.ok_or_else(|| format!("{}: not a whole number where one is wanted: {call:?}", case.name))?,
            );
        }
        let stage = if screen { Stage::Fragment } else { Stage::Compute };
        Ok(Self { function: function.clone(), stage, arguments, results, rounded })
    }

    fn pixels(&self) -> usize {
        if self.stage == Stage::Fragment { 4 } else { 1 }
    }

    fn run(&self, gpu: &Gpu, language: Language, bundle: &Bundle, case: &Case) -> Result<Worst, String> {
        let shader = Shader::new(language, self.stage, &self.shader_text(language, bundle)?)?;
        // Pixels are drawn in whole rows of quads: the last call fills the row.
        let calls = if self.stage == Stage::Fragment {
            self.rounded.len().next_multiple_of(QUADS_A_ROW)
        } else {
            self.rounded.len()
        };
        let all = (0..calls).map(|i| &self.rounded[i.min(self.rounded.len() - 1)]);
        let words: Vec<u32> =
            all.flat_map(|call| call.iter().zip(self.arguments.iter().cycle()).map(|(&v, s)| s.word(v))).collect();
        let out = gpu.run(&shader, calls, &words, calls * self.pixels() * self.results.len())?;
        let mut worst = Worst { share: -1.0, arguments: Vec::new(), shader: Vec::new(), twin: Vec::new() };
        for (call, words) in self.rounded.iter().zip(out.chunks_exact(self.pixels() * self.results.len())) {
            let arguments = if self.stage == Stage::Fragment { derived(call) } else { call.clone() };
            let twin = (case.twin)(&arguments);
            if twin.len() != self.results.len() {
                return Err(format!("the twin returns {} scalars, not {}", twin.len(), self.results.len()));
            }
            let shader: Vec<f64> = words.iter().zip(&self.results).map(|(&w, s)| s.value(w)).collect();
            let share = shader.iter().zip(&twin).map(|(&s, &t)| case.bound.share(s, t)).fold(0.0, f64::max);
            if share > worst.share {
                worst = Worst { share, arguments, shader, twin };
            }
        }
        Ok(worst)
    }

    /// The bundle with buffers, a function that reads the arguments, calls and writes the result, and an entry point.
    fn shader_text(&self, language: Language, bundle: &Bundle) -> Result<String, String> {
        let mut names = bundle.names.clone();
        for (name, argument, result) in [
            ("mf_test_f", "u32", "f32"),
            ("mf_test_u", "u32", "u32"),
            ("mf_test_put_f", "f32", "u32"),
            ("mf_test_put_u", "u32", "u32"),
        ] {
            let mut arguments = vec![("i".to_string(), argument.to_string())];
            if name.starts_with("mf_test_put") {
                arguments.insert(0, ("i".to_string(), "u32".to_string()));
            }
            names.functions.push(Function { name: name.to_string(), arguments, result: result.to_string() });
        }
        let call = translate(&self.call_text(&names), language, false, &mut names)
            .map_err(|wrong| format!("the call of {}:{wrong}", self.function.name))?;
        let (start, entry) = match (language, self.stage) {
            (Language::Wgsl, Stage::Compute) => (WGSL, WGSL_COMPUTE),
            (Language::Wgsl, Stage::Fragment) => (WGSL, WGSL_FRAGMENT),
            (Language::Glsl, Stage::Compute) => (GLSL, GLSL_COMPUTE),
            (Language::Glsl, Stage::Fragment) => (GLSL, GLSL_FRAGMENT),
            (Language::Hlsl, Stage::Compute) => (HLSL, HLSL_COMPUTE),
            (Language::Hlsl, Stage::Fragment) => (HLSL, HLSL_FRAGMENT),
        };
        let entry = entry
            .replace("CALLS", &self.rounded.len().to_string())
            .replace("QUADS", &QUADS_A_ROW.to_string())
            .replace("ARGUMENTS", &self.arguments.len().to_string())
            .replace("RESULTS", &self.results.len().to_string());
        Ok(format!("{start}\n{}\n{call}\n{entry}", bundle.text))
    }

    /// In the restricted WGSL.
    fn call_text(&self, names: &Names) -> String {
        let mut body = String::new();
        let mut at = 0;
        for (i, (_, kind)) in self.function.arguments.iter().enumerate() {
            read(names, &format!("a{i}"), kind, &mut at, &mut body);
        }
        let arguments: Vec<String> = (0..self.function.arguments.len()).map(|i| format!("a{i}")).collect();
        let (name, kind) = (&self.function.name, &self.function.result);
        writeln!(body, "    let r: {kind} = {name}({});\n    var done: u32 = 0u;", arguments.join(", ")).expect("text");
        let mut at = 0;
        store(names, "r", kind, &mut at, &mut body);
        format!("// Calls once.\nfn mf_test_call(i: u32, o: u32) -> u32 {{\n{body}    return done;\n}}\n")
    }
}

/// The four pixels from a call's value and its steps along x and y.
fn quad(call: &[f64]) -> Vec<Vec<f64>> {
    let n = call.len() / 3;
    let pixel = |x: f64, y: f64| (0..n).map(|i| call[i] + x * call[n + i] + y * call[2 * n + i]).collect();
    vec![pixel(0.0, 0.0), pixel(1.0, 0.0), pixel(0.0, 1.0), pixel(1.0, 1.0)]
}

/// Value and steps again, from the rounded pixels.
fn derived(pixels: &[f64]) -> Vec<f64> {
    let n = pixels.len() / 4;
    let step = |to: usize| (0..n).map(move |i| pixels[to * n + i] - pixels[i]);
    pixels[..n].iter().copied().chain(step(1)).chain(step(2)).collect()
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

fn flatten(names: &Names, kind: &str, out: &mut Vec<Scalar>) {
    match names.structs.get(kind) {
        Some(fields) => fields.iter().for_each(|(_, field)| flatten(names, field, out)),
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
@group(0) @binding(0) var<storage, read_write> mf_test_in: array<u32>;
@group(0) @binding(1) var<storage, read_write> mf_test_out: array<u32>;
fn mf_test_f(i: u32) -> f32 { return bitcast<f32>(mf_test_in[i]); }
fn mf_test_u(i: u32) -> u32 { return mf_test_in[i]; }
fn mf_test_put_f(i: u32, v: f32) -> u32 { mf_test_out[i] = bitcast<u32>(v); return 0u; }
fn mf_test_put_u(i: u32, v: u32) -> u32 { mf_test_out[i] = v; return 0u; }
";
const WGSL_COMPUTE: &str = "
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < CALLSu) {
        let done = mf_test_call(id.x * ARGUMENTSu, id.x * RESULTSu);
    }
}
";
const WGSL_FRAGMENT: &str = "
@fragment
fn main(@builtin(position) p: vec4f) -> @location(0) vec4f {
    let at = vec2u(p.xy);
    let i = 4u * (at.y / 2u * QUADSu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    return vec4f(f32(mf_test_call(i * ARGUMENTSu, i * RESULTSu)));
}
";
const GLSL: &str = "#version 450
precision highp float;
layout(std430, set = 0, binding = 0) buffer MfTestIn { uint mf_test_in[]; };
layout(std430, set = 0, binding = 1) buffer MfTestOut { uint mf_test_out[]; };
float mf_test_f(uint i) { return uintBitsToFloat(mf_test_in[i]); }
uint mf_test_u(uint i) { return mf_test_in[i]; }
uint mf_test_put_f(uint i, float v) { mf_test_out[i] = floatBitsToUint(v); return 0u; }
uint mf_test_put_u(uint i, uint v) { mf_test_out[i] = v; return 0u; }
";
const GLSL_COMPUTE: &str = "
layout(local_size_x = 64) in;
void main() {
    if (gl_GlobalInvocationID.x < CALLSu) {
        mf_test_call(gl_GlobalInvocationID.x * ARGUMENTSu, gl_GlobalInvocationID.x * RESULTSu);
    }
}
";
const GLSL_FRAGMENT: &str = "
layout(location = 0) out vec4 mf_test_colour;
void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint i = 4u * (at.y / 2u * QUADSu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    mf_test_colour = vec4(float(mf_test_call(i * ARGUMENTSu, i * RESULTSu)));
}
";
const HLSL: &str = "
RWStructuredBuffer<uint> mf_test_in : register(u0);
RWStructuredBuffer<uint> mf_test_out : register(u1);
float mf_test_f(uint i) { return asfloat(mf_test_in[i]); }
uint mf_test_u(uint i) { return mf_test_in[i]; }
uint mf_test_put_f(uint i, float v) { mf_test_out[i] = asuint(v); return 0u; }
uint mf_test_put_u(uint i, uint v) { mf_test_out[i] = v; return 0u; }
";
const HLSL_COMPUTE: &str = "
[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    if (id.x < CALLSu) {
        mf_test_call(id.x * ARGUMENTSu, id.x * RESULTSu);
    }
}
";
const HLSL_FRAGMENT: &str = "
float4 main(float4 p : SV_Position) : SV_Target0 {
    uint2 at = uint2(p.xy);
    uint i = 4u * (at.y / 2u * QUADSu + at.x / 2u) + at.y % 2u * 2u + at.x % 2u;
    float done = float(mf_test_call(i * ARGUMENTSu, i * RESULTSu));
    return float4(done, done, done, done);
}
";
