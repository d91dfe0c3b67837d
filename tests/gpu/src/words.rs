//! Words that differ between the languages, and words that one of them keeps for itself.

use crate::translate::Language;

/// Types in WGSL, GLSL and HLSL.
pub const TYPES: [[&str; 3]; 13] = [
    ["f32", "float", "float"],
    ["u32", "uint", "uint"],
    ["i32", "int", "int"],
    ["bool", "bool", "bool"],
    ["vec2f", "vec2", "float2"],
    ["vec3f", "vec3", "float3"],
    ["vec4f", "vec4", "float4"],
    ["vec2u", "uvec2", "uint2"],
    ["vec3u", "uvec3", "uint3"],
    ["vec4u", "uvec4", "uint4"],
    ["vec2i", "ivec2", "int2"],
    ["vec3i", "ivec3", "int3"],
    ["vec4i", "ivec4", "int4"],
];

/// Built-in functions in WGSL, GLSL and HLSL.
pub const FUNCTIONS: [[&str; 3]; 27] = [
    ["abs", "abs", "abs"],
    ["min", "min", "min"],
    ["max", "max", "max"],
    ["clamp", "clamp", "clamp"],
    ["mix", "mix", "lerp"],
    ["sqrt", "sqrt", "sqrt"],
    ["inverseSqrt", "inversesqrt", "rsqrt"],
    ["exp", "exp", "exp"],
    ["exp2", "exp2", "exp2"],
    ["log", "log", "log"],
    ["log2", "log2", "log2"],
    ["pow", "pow", "pow"],
    ["sin", "sin", "sin"],
    ["cos", "cos", "cos"],
    ["tan", "tan", "tan"],
    ["asin", "asin", "asin"],
    ["acos", "acos", "acos"],
    ["atan", "atan", "atan"],
    ["atan2", "atan", "atan2"],
    ["floor", "floor", "floor"],
    ["ceil", "ceil", "ceil"],
    ["fract", "fract", "frac"],
    ["sign", "sign", "sign"],
    ["dot", "dot", "dot"],
    ["cross", "cross", "cross"],
    ["length", "length", "length"],
    ["normalize", "normalize", "normalize"],
];

/// Built-in functions of fragment shaders.
pub const DERIVATIVES: [[&str; 3]; 2] = [["dpdx", "dFdx", "ddx"], ["dpdy", "dFdy", "ddy"]];

/// Number of arguments of a built-in function.
pub fn arguments(name: &str) -> usize {
    match name {
        "clamp" | "mix" => 3,
        "min" | "max" | "pow" | "atan2" | "dot" | "cross" => 2,
        _ => 1,
    }
}

/// The word of a table in a language.
pub fn in_language(table: &[[&'static str; 3]], name: &str, language: Language) -> Option<&'static str> {
    table.iter().find(|row| row[0] == name).map(|row| row[language as usize])
}

/// Why a name cannot be given to anything, if so.
pub fn taken(name: &str) -> Option<&'static str> {
    let built_in = |table: &[[&str; 3]]| table.iter().flatten().any(|w| *w == name);
    let numbered = |stem: &str| {
        name.strip_prefix(stem)
            .is_some_and(|rest| !rest.is_empty() && rest.chars().all(|c| c.is_ascii_digit() || c == 'x'))
    };
    if built_in(&TYPES) || built_in(&FUNCTIONS) || built_in(&DERIVATIVES) {
        Some("a type or function of a language")
    } else if name.contains("__") || name.starts_with("gl_") || name.starts_with('_') {
        Some("kept by GLSL, or by WGSL")
    } else if ["float", "int", "uint", "bool", "half", "double", "vec", "mat", "dvec", "bvec", "dmat"]
        .iter()
        .any(|s| numbered(s))
        || RESERVED.split_whitespace().any(|word| word == name)
    {
        Some("reserved in a language")
    } else {
        None
    }
}

/// Keywords and reserved words of WGSL, GLSL (450, ES 3.00) and HLSL.
const RESERVED: &str = "
alias array async atomic attribute auto await become binding buffer break builtin bitcast active asm case cast catch
cbuffer centroid char class column_major coherent common compile compute const const_cast const_assert constexpr continue
default delete demote diagnostic discard do double dword dynamic_cast dxbc else enable enum explicit export extern external
f16 f32 false filter final fixed flat float fn for fragment friend from fvec2 fvec3 fvec4 function global globallycoherent
goto group groupshared half handle highp hvec2 hvec3 hvec4 i32 if image impl implements import in inline inout input
instanceof instance int interface invariant isampler2D isolate iimage2D layout let line linear lineadj loop long lowp
mat2x2f mat3x3f mat4x4f matrix mediump meta mod module move mutable mut namespace new nil noinline nointerpolation
noncoherent noncentroid noperspective null nullptr NULL of operator out output override package packed packoffset partition
pass patch pixelfragment pointfragment point precise precision premerge priv private program protected ptr pub public pixel
readonly ref register regardless reinterpret_cast require requires resource restrict return row_major sample sampler
sampler1D sampler2D sampler3D samplerCube sampler_state sampler_comparison self set shader shared short signed sizeof
smooth snorm stateblock static static_assert static_cast std storage string struct subroutine super superp switch
target tbuffer technique template texture texture1D texture2D texture3D textureCube this thread_local throw trait
triangle triangleadj true try type typedef typeid typename typeof u32 uint uniform union unless unorm unsafe unsigned
unsized use using usampler2D uimage2D var varying vec2 vec3 vec4 vector vertex vertexfragment virtual void volatile wgsl
where while with workgroup write writeonly yield lowp bool saturate lerp rcp
";
