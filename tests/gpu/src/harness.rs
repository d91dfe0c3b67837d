//! Calls every function of a file in each language, and compares what comes back with its twin.

use std::fmt::Write;

use crate::case::Case;
use crate::gpu::{CALLS_AT_ONCE, Gpu, Program, Stage};
use crate::source::{bundle, is_screen};
use crate::translate::{Function, Language, Names};
use crate::wrapper::{Scalar, scalars, wrapped};

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
    let first = bundle(subject, languages[0])?;
    let stage = if is_screen(subject) { Stage::Fragment } else { Stage::Compute };
    let mut functions: Vec<Function> = Vec::new();
    let mut calls = Vec::new();
    for case in cases {
        let Some(function) = first.names.function(case.name) else {
            return Err(format!("kernels/wgsl/{subject}.wgsl has no function {}", case.name));
        };
        let which = functions.iter().position(|f| f.name == case.name).unwrap_or(functions.len());
        if which == functions.len() {
            functions.push(function.clone());
        }
        calls.push(Calls::new(&first.names, function, case, stage, which)?);
    }
    let mut programs = Vec::new();
    for &language in languages {
        let text = wrapped(&bundle(subject, language)?, language, stage, &functions)?;
        programs.push((language, Program::new(language, stage, &text)));
    }
    let row = |calls: &Calls| {
        let run = |(language, program): &(Language, Result<Program, String>)| {
            (*language, program.as_ref().map_err(Clone::clone).and_then(|program| calls.run(gpu, program)))
        };
        Row { name: calls.case.name, calls: calls.case.inputs.len(), results: programs.iter().map(run).collect() }
    };
    Ok(calls.iter().map(row).collect())
}

/// What a function of a file returns for these arguments, in one language.
pub fn results(
    gpu: &Gpu,
    subject: &str,
    name: &str,
    inputs: &[Vec<f64>],
    language: Language,
) -> Result<Vec<Vec<f64>>, String> {
    let bundle = bundle(subject, language)?;
    let function = bundle.names.function(name).ok_or_else(|| format!("{subject} has no function {name}"))?.clone();
    let (mut given, mut returned) = (Vec::new(), Vec::new());
    function.arguments.iter().for_each(|(_, kind)| scalars(&bundle.names, kind, &mut given));
    scalars(&bundle.names, &function.result, &mut returned);
    let text = wrapped(&bundle, language, Stage::Compute, std::slice::from_ref(&function))?;
    let program = Program::new(language, Stage::Compute, &text)?;
    let calls = inputs.len().next_multiple_of(CALLS_AT_ONCE);
    let all = (0..calls).flat_map(|i| inputs[i.min(inputs.len() - 1)].iter().zip(given.iter().cycle()));
    let words: Vec<u32> = all.map(|(&v, s)| s.word(v)).collect();
    assert_eq!(words.len(), calls * given.len(), "{name} takes {} scalars", given.len());
    let out = gpu.run(&program, 0, calls, &words, calls * returned.len())?;
    let value = |words: &[u32]| words.iter().zip(&returned).map(|(&w, s)| s.value(w)).collect();
    Ok(out.chunks_exact(returned.len()).take(inputs.len()).map(value).collect())
}

/// The arguments of all calls as the shader gets them.
struct Calls {
    case: Case,
    /// Which of the program's functions.
    which: u32,
    stage: Stage,
    arguments: Vec<Scalar>,
    results: Vec<Scalar>,
    /// Rounded as the shader gets them; of a quad of pixels, the four after one another.
    rounded: Vec<Vec<f64>>,
}

impl Calls {
    fn new(names: &Names, function: &Function, case: Case, stage: Stage, which: usize) -> Result<Self, String> {
        let mut arguments = Vec::new();
        function.arguments.iter().for_each(|(_, kind)| scalars(names, kind, &mut arguments));
        let mut results = Vec::new();
        scalars(names, &function.result, &mut results);
        let screen = stage == Stage::Fragment;
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
        Ok(Self { case, which: which as u32, stage, arguments, results, rounded })
    }

    fn pixels(&self) -> usize {
        if self.stage == Stage::Fragment { 4 } else { 1 }
    }

    fn run(&self, gpu: &Gpu, program: &Program) -> Result<Worst, String> {
        // The last call fills up the last group of threads, or row of pixels.
        let calls = self.rounded.len().next_multiple_of(CALLS_AT_ONCE);
        let all = (0..calls).map(|i| &self.rounded[i.min(self.rounded.len() - 1)]);
        let words: Vec<u32> =
            all.flat_map(|call| call.iter().zip(self.arguments.iter().cycle()).map(|(&v, s)| s.word(v))).collect();
        let out = gpu.run(program, self.which, calls, &words, calls * self.pixels() * self.results.len())?;
        let mut worst = Worst { share: -1.0, arguments: Vec::new(), shader: Vec::new(), twin: Vec::new() };
        for (call, words) in self.rounded.iter().zip(out.chunks_exact(self.pixels() * self.results.len())) {
            let arguments = if self.stage == Stage::Fragment { derived(call) } else { call.clone() };
            let twin = (self.case.twin)(&arguments);
            if twin.len() != self.results.len() {
                return Err(format!("the twin returns {} scalars, not {}", twin.len(), self.results.len()));
            }
            let shader: Vec<f64> = words.iter().zip(&self.results).map(|(&w, s)| s.value(w)).collect();
            let share = shader.iter().zip(&twin).map(|(&s, &t)| self.case.bound.share(s, t)).fold(0.0, f64::max);
            if share > worst.share {
                worst = Worst { share, arguments, shader, twin };
            }
        }
        Ok(worst)
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
