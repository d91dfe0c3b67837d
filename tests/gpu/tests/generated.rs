//! `kernels/glsl` and `kernels/hlsl` are what the translator makes of `kernels/wgsl`, and compilers read them.
//!
//! `BLESS=1` writes the files anew.

use std::collections::BTreeSet;
use std::fs;

use mipfold_gpu_tests::gpu::{Stage, glslang_with, has_glslang, skipped};
use mipfold_gpu_tests::source::{bundle, generated, is_screen, kernels, subjects};
use mipfold_gpu_tests::translate::{Language, Names, translate};

const GENERATED: [Language; 2] = [Language::Glsl, Language::Hlsl];

/// The subjects to look at: `MIPFOLD_ONLY` names one.
fn chosen() -> Vec<String> {
    let only = std::env::var("MIPFOLD_ONLY").ok();
    subjects().into_iter().filter(|s| only.as_ref().is_none_or(|only| only == s)).collect()
}

#[test]
fn generated_files_are_up_to_date() {
    let bless = std::env::var_os("BLESS").is_some();
    let mut wrong = String::new();
    for language in GENERATED {
        let folder = kernels().join(language.name());
        fs::create_dir_all(&folder).expect("the folder of a language");
        let mut wanted = BTreeSet::new();
        for subject in chosen() {
            let name = format!("{subject}.{}", language.name());
            wanted.insert(name.clone());
            let text = match generated(&subject, language) {
                Ok(text) => text,
                Err(error) => {
                    wrong += &format!("{error}\n");
                    continue;
                }
            };
            let path = folder.join(&name);
            if fs::read_to_string(&path).is_ok_and(|old| old == text) {
                continue;
            }
            if bless {
                fs::write(&path, text).expect("a generated file");
            } else {
                wrong += &format!("kernels/{}/{name} is not up to date: run this test with BLESS=1\n", language.name());
            }
        }
        for file in fs::read_dir(&folder).expect("the folder of a language") {
            let path = file.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            if wanted.contains(&name) || chosen().len() < subjects().len() {
                continue;
            }
            if bless {
                fs::remove_file(&path).expect("removing a file without a source");
            } else {
                wrong += &format!("kernels/{}/{name} has no source\n", language.name());
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The hand-written text through the translator is the hand-written text, so nothing is lost on the way.
#[test]
fn wgsl_to_wgsl_changes_nothing() {
    for subject in chosen() {
        let text = fs::read_to_string(kernels().join("wgsl").join(format!("{subject}.wgsl"))).expect("a source");
        assert!(bundle(&subject, Language::Wgsl).unwrap_or_else(|e| panic!("{e}")).own == text, "{subject}");
    }
}

/// Comments and the number of lines are those of the source.
#[test]
fn comments_and_lines_stay() {
    for subject in chosen() {
        let own = |language| bundle(&subject, language).unwrap_or_else(|e| panic!("{e}")).own;
        let source = own(Language::Wgsl);
        for language in GENERATED {
            let made = own(language);
            assert_eq!(made.lines().count(), source.lines().count(), "{subject}");
            let comment = |line: &str| line.find("//").map(|at| line[at..].to_string());
            assert!(made.lines().map(comment).eq(source.lines().map(comment)), "{subject}");
        }
    }
}

/// Any files can be used together.
#[test]
fn names_are_declared_once() {
    let mut seen = BTreeSet::new();
    for subject in subjects() {
        let path = kernels().join("wgsl").join(format!("{subject}.wgsl"));
        for line in fs::read_to_string(path).expect("a source").lines() {
            let declared = ["fn ", "struct ", "const "].iter().find_map(|word| line.strip_prefix(word));
            if let Some(rest) = declared {
                let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                assert!(seen.insert(name.clone()), "{name} of {subject} is declared elsewhere too");
            }
        }
    }
}

#[test]
fn glsl_compiles_in_its_versions() {
    if !has_glslang() {
        return skipped("no glslangValidator");
    }
    let mut wrong = String::new();
    for subject in chosen() {
        let text = match bundle(&subject, Language::Glsl) {
            Ok(bundle) => bundle.text,
            Err(error) => {
                wrong += &format!("{error}\n");
                continue;
            }
        };
        for version in ["450", "330", "300 es"] {
            let stage = if version == "450" && !is_screen(&subject) { Stage::Compute } else { Stage::Fragment };
            let main = if stage == Stage::Compute { "layout(local_size_x = 1) in;\n" } else { "" };
            let text = format!(
                "#version {version}\nprecision highp float;\nprecision highp int;\n{text}\n{main}void main() {{\n}}\n"
            );
            if let Err(error) = glslang_with(stage, &text, &[]) {
                wrong += &format!("{subject}, version {version}:\n{error}");
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn hlsl_compiles() {
    if !has_glslang() {
        return skipped("no glslangValidator");
    }
    let mut wrong = String::new();
    for subject in chosen() {
        let main = "float4 main() : SV_Target0 {\n    return float4(0.0, 0.0, 0.0, 0.0);\n}\n";
        let done = bundle(&subject, Language::Hlsl).and_then(|bundle| {
            let out = tempfile::tempdir().map_err(|e| e.to_string())?;
            let out = out.path().join("out.spv");
            let text = format!("{}\n{main}", bundle.text);
            glslang_with(
                Stage::Fragment,
                &text,
                &["-V", "-D", "-e", "main", "-o", out.to_str().expect("a path of text")],
            )
        });
        if let Err(error) = done {
            wrong += &format!("{subject}:\n{error}");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

const SMALL: &str = "// A test.
// Needs: nothing

// Pi.
const MF_PI: f32 = 3.14159265;

// Two things.
struct MfTwo {
    a: f32, // radians
    b: vec3f,
}

// Both, from `x`.
fn mf_two(x: f32, n: vec3f) -> MfTwo {
    var o: MfTwo;
    let y: f32 = mix(x, inverseSqrt(abs(x)), fract(MF_PI)); // a note
    o.a = atan2(y, x);
    o.b = vec3f(x, x, x) + n.zyx;
    for (var i: u32 = 0u; i < 4u; i = i + 1u) {
        if (f32(i) > x) {
            o.a = o.a + 1.0;
        } else {
            o.b.x = 0.0;
        }
    }
    return o;
}
";

#[test]
fn each_language_as_expected() {
    let glsl = translate(SMALL, Language::Glsl, false, &mut Names::default()).expect("of the style");
    let hlsl = translate(SMALL, Language::Hlsl, false, &mut Names::default()).expect("of the style");
    let same = |text: &str| {
        text.replace("a: f32,", "float a;")
            .replace("}\n\n// Both", "};\n\n// Both")
            .replace("fn mf_two(x: f32, n: vec3f) -> MfTwo", "MfTwo mf_two(float x, vec3f n)")
            .replace("var o: MfTwo", "MfTwo o")
            .replace("let y: f32", "float y")
            .replace("var i: u32", "uint i")
            .replace("f32(i)", "float(i)")
            .replace("b: vec3f,", "vec3f b;")
    };
    let expected = same(SMALL)
        .replace("const MF_PI: f32", "const float MF_PI")
        .replace("vec3f", "vec3")
        .replace("inverseSqrt", "inversesqrt")
        .replace("atan2", "atan");
    assert_eq!(glsl, expected);
    let expected = same(SMALL)
        .replace("const MF_PI: f32", "static const float MF_PI")
        .replace("vec3f", "float3")
        .replace("inverseSqrt", "rsqrt")
        .replace("mix", "lerp")
        .replace("fract", "frac");
    assert_eq!(hlsl, expected);
}

/// Each of these is WGSL, or nearly, and outside of the style; the error names its line.
#[test]
fn what_is_outside_of_the_style_is_refused() {
    let refused = [
        "let y = x;",
        "var y: f32;",
        "let half: f32 = x;",
        "let mix: f32 = x;",
        "let x: f32 = 1.0;",
        "let y: f32 = select(x, 1.0, true);",
        "let y: f32 = fma(x, x, x);",
        "let y: f32 = dpdx(x);",
        "let y: f32 = mf_later(x);",
        "let y: f32 = z;",
        "let y: vec3f = vec3f(x);",
        "let y: array<f32, 2> = x;",
        "let y: f32 = n[0];",
        "let y: f32 = 1.0f;",
        "let y: f32 = n.wxyzx;",
        "let y: f32 = min(x);",
        "let y: u32 = 1u & 2u == 2u;",
        "let y: bool = x > 1.0 && x < 2.0 || x > 3.0;",
        "x = 1.0;",
        "let y: f32 = x; y = 2.0;",
        "var y: vec3f = n; y.xy = n.xy;",
        "var y: MfOne; y.a = x;",
        "while (true) { }",
        "switch (1) { }",
        "if (x > 0.0) return x;",
        "mf_one(x);",
        "let y: f32 = x; /* a note */",
        "let y: f32 = x; // \u{b5}",
        "let y: f32 = x; // joined \\",
        "if (x > 0.0) { return x; } }",
    ];
    let with = |body: &str| {
        format!(
            "// A.\nstruct MfOne {{\n    a: f32,\n    b: f32,\n}}\n// B.\nfn mf_one(x: f32, n: vec3f) -> f32 {{\n{body}\nreturn x;\n}}\n"
        )
    };
    let of = |text: &str| translate(text, Language::Glsl, false, &mut Names::default());
    assert!(of(&with("let y: f32 = x;")).is_ok());
    for body in refused {
        let error = of(&with(body)).expect_err(body);
        let line: usize = error.split(':').next().and_then(|n| n.parse().ok()).expect("a line");
        assert!((8..=9).contains(&line), "{body}: {error}");
    }
    for text in [
        "fn mf_one(x: f32) -> f32 {\n    return x;\n}\n",
        "// A.\n\nfn mf_one(x: f32) -> f32 {\n    return x;\n}\n",
        "// A.\nfn one(x: f32) -> f32 {\n    return x;\n}\n",
        "// A.\nfn mf_one(x: f32,\n    y: f32) -> f32 {\n    return x;\n}\n",
        "// A.\nfn mf_one(x: f32) {\n    return;\n}\n",
        "// A.\nfn mf_one(x: f32) -> f32 {\n}\n",
        "const PI: f32 = 3.1;\n",
        "@compute fn main() {}\n",
        "enable f16;\n",
    ] {
        assert!(of(text).is_err(), "{text}");
    }
}
