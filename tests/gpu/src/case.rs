//! What a function is called with, and how far from its twin it may be.

use std::f64::consts::{FRAC_PI_2, TAU};

/// One function of the shader text, its arguments, and the twin that says what should come back.
pub struct Case {
    /// The function's name in the shader text.
    pub name: &'static str,
    /// One entry per call: all arguments as scalars in order, vectors and structs by component. Rounded to f32 before
    /// the shader and the twin get them. In a file `*_screen.wgsl`, all arguments at a pixel, then how much each of them
    /// grows to the next pixel along x, then to the next along y.
    pub inputs: Vec<Vec<f64>>,
    /// From the (rounded) arguments to the result, as scalars in order.
    pub twin: fn(&[f64]) -> Vec<f64>,
    /// How far each component may be from the twin's.
    pub bound: Bound,
}

/// `|shader - twin| <= absolute + relative |twin|`.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// In the result's own unit.
    pub absolute: f64,
    /// A share of the twin's result.
    pub relative: f64,
}

impl Bound {
    /// The error as a share of what is allowed: at most 1 passes. Infinite where the shader's value is not finite and
    /// the twin's is.
    pub fn share(self, shader: f64, twin: f64) -> f64 {
        if shader == twin || (shader.is_nan() && twin.is_nan()) {
            return 0.0;
        }
        let share = (shader - twin).abs() / (self.absolute + self.relative * twin.abs());
        if share.is_nan() { f64::INFINITY } else { share }
    }
}

/// Arguments for a number of calls, the same in every run: first combinations of the arguments' edges, then pseudo-random
/// ones with an edge here and there.
///
/// ```
/// # use mipfold_gpu_tests::case::Sweep;
/// let inputs = Sweep::new(500).log(0.001, 1.0).hemisphere().linear(-1.0, 1.0).edges(&[0.0]).inputs();
/// assert!(inputs.len() == 500 && inputs[0].len() == 5);
/// ```
#[derive(Clone, Debug)]
pub struct Sweep {
    count: usize,
    arguments: Vec<Argument>,
    more: Vec<Vec<f64>>,
}

#[derive(Clone, Debug)]
struct Argument {
    kind: Kind,
    edges: Vec<Vec<f64>>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Linear(f64, f64),
    Log(f64, f64),
    SignedLog(f64, f64),
    Integer(u32, u32),
    Edges,
    Disk,
    Circle,
    Sphere,
    Hemisphere,
}

impl Sweep {
    /// This many calls, and those of [`Sweep::and`].
    pub fn new(count: usize) -> Self {
        Self { count, arguments: Vec::new(), more: Vec::new() }
    }

    /// A scalar, evenly spread; edges are both ends.
    pub fn linear(self, low: f64, high: f64) -> Self {
        self.argument(Kind::Linear(low, high), vec![vec![low], vec![high]])
    }

    /// A scalar above 0 with an evenly spread logarithm; edges are both ends.
    pub fn log(self, low: f64, high: f64) -> Self {
        self.argument(Kind::Log(low, high), vec![vec![low], vec![high]])
    }

    /// A scalar of either sign with an evenly spread logarithm of its size; edges are all four ends, and 0.
    pub fn signed_log(self, low: f64, high: f64) -> Self {
        let edges = [0.0, low, -low, high, -high];
        self.argument(Kind::SignedLog(low, high), edges.map(|v| vec![v]).to_vec())
    }

    /// A whole number (u32, or bool as 0 and 1), both ends included, which are its edges.
    pub fn integer(self, low: u32, high: u32) -> Self {
        self.argument(Kind::Integer(low, high), vec![vec![f64::from(low)], vec![f64::from(high)]])
    }

    /// Scalars out of a list.
    pub fn one_of(self, values: &[f64]) -> Self {
        self.argument(Kind::Edges, values.iter().map(|&v| vec![v]).collect())
    }

    /// Two components within the unit disk; edges are the centre and points of the rim.
    pub fn disk(self) -> Self {
        self.argument(Kind::Disk, vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![0.0, -1.0], vec![-0.6, 0.8]])
    }

    /// A unit vector of two components; edges are the axes.
    pub fn circle(self) -> Self {
        self.argument(Kind::Circle, vec![vec![1.0, 0.0], vec![0.0, 1.0], vec![-1.0, 0.0], vec![0.0, -1.0]])
    }

    /// A unit vector; edges are the axes.
    pub fn sphere(self) -> Self {
        let axes =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        self.argument(Kind::Sphere, axes.map(Vec::from).to_vec())
    }

    /// A unit vector with z at least 0, half of them within a few degrees of the pole or of the horizon; edges are the
    /// pole and directions near (1e-3) and on the horizon.
    pub fn hemisphere(self) -> Self {
        let near = 1e-3f64;
        let edges = [[0.0, 0.0, 1.0], [(1.0 - near * near).sqrt(), 0.0, near], [-0.6, 0.8, 0.0]];
        self.argument(Kind::Hemisphere, edges.map(Vec::from).to_vec())
    }

    /// More edges for the last argument, all its components one after the other.
    pub fn edges(mut self, values: &[f64]) -> Self {
        let last = self.arguments.last_mut().expect("an argument before its edges");
        let width = last.edges[0].len();
        assert!(values.len().is_multiple_of(width), "edges of {width} components each");
        last.edges.extend(values.chunks(width).map(<[f64]>::to_vec));
        self
    }

    /// One more call with exactly these arguments.
    pub fn and(mut self, call: &[f64]) -> Self {
        self.more.push(call.to_vec());
        self
    }

    /// The calls. At most half of them are combinations of edges; where there are more, a pseudo-random choice of them.
    pub fn inputs(&self) -> Vec<Vec<f64>> {
        let mut random = SplitMix(0x5EED);
        let combinations = self.arguments.iter().fold(1usize, |n, a| n.saturating_mul(a.edges.len()));
        let (at_edges, all) = (combinations.min(self.count / 2), combinations <= self.count / 2);
        let mut calls = Vec::with_capacity(self.count + self.more.len());
        for i in 0..self.count {
            let mut rest = i;
            let mut call = Vec::new();
            for argument in &self.arguments {
                let edges = argument.edges.len();
                if i < at_edges {
                    let edge = if all { rest % edges } else { random.below(edges) };
                    rest /= edges;
                    call.extend(&argument.edges[edge]);
                } else if random.unit() < 0.06 || matches!(argument.kind, Kind::Edges) {
                    call.extend(&argument.edges[random.below(edges)]);
                } else {
                    argument.kind.draw(&mut random, &mut call);
                }
            }
            calls.push(call);
        }
        calls.extend(self.more.iter().cloned());
        calls
    }

    fn argument(mut self, kind: Kind, edges: Vec<Vec<f64>>) -> Self {
        self.arguments.push(Argument { kind, edges });
        self
    }
}

impl Kind {
    fn draw(self, random: &mut SplitMix, out: &mut Vec<f64>) {
        let log = |u: f64, low: f64, high: f64| (low.ln() + u * (high / low).ln()).exp();
        match self {
            Self::Linear(low, high) => out.push(low + random.unit() * (high - low)),
            Self::Log(low, high) => out.push(log(random.unit(), low, high)),
            Self::SignedLog(low, high) => {
                let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                out.push(sign * log(random.unit(), low, high));
            }
            Self::Integer(low, high) => {
                let span = f64::from(high) - f64::from(low) + 1.0;
                out.push(f64::from(low) + (random.unit() * span).floor());
            }
            Self::Edges => unreachable!("drawn from its edges"),
            Self::Disk => {
                let (radius, (sin, cos)) = (random.unit().sqrt(), (TAU * random.unit()).sin_cos());
                out.extend([radius * cos, radius * sin]);
            }
            Self::Circle => {
                let (sin, cos) = (TAU * random.unit()).sin_cos();
                out.extend([cos, sin]);
            }
            Self::Sphere => {
                let (z, (sin, cos)) = (2.0 * random.unit() - 1.0, (TAU * random.unit()).sin_cos());
                let p = (1.0 - z * z).max(0.0).sqrt();
                out.extend([p * cos, p * sin, z]);
            }
            Self::Hemisphere => {
                let u = random.unit();
                let theta = match random.below(4) {
                    0 => log(u, 1e-5, 0.1),
                    1 => FRAC_PI_2 - log(u, 1e-5, 0.1),
                    _ => (1.0 - u).acos(),
                };
                let (sin, cos) = (TAU * random.unit()).sin_cos();
                out.extend([theta.sin() * cos, theta.sin() * sin, theta.cos()]);
            }
        }
    }
}

/// Steele, Lea, Flood: "Fast Splittable Pseudorandom Number Generators", 2014.
#[derive(Clone, Debug)]
pub struct SplitMix(pub u64);

impl SplitMix {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 to 1, 1 left out.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A whole number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_repeat_and_begin_with_every_combination_of_edges() {
        let sweep = Sweep::new(100).log(0.001, 1.0).signed_log(1e-3, 2.0).and(&[0.5, 0.5]);
        let inputs = sweep.inputs();
        assert_eq!(inputs, sweep.inputs());
        assert_eq!(inputs.len(), 101);
        for alpha in [0.001, 1.0] {
            for other in [0.0, 1e-3, -1e-3, 2.0, -2.0] {
                assert!(inputs[..10].contains(&vec![alpha, other]));
            }
        }
        assert!(inputs.iter().all(|call| (0.001 - 1e-12..=1.0).contains(&call[0]) && call[1].abs() <= 2.0));
    }

    #[test]
    fn directions_are_unit() {
        for call in Sweep::new(300).hemisphere().sphere().circle().inputs() {
            let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(call[2] >= 0.0);
            assert!([&call[..3], &call[3..6], &call[6..]].iter().all(|v| (length(v) - 1.0).abs() < 1e-12));
        }
    }

    #[test]
    fn bounds_are_absolute_and_relative() {
        let bound = Bound { absolute: 0.1, relative: 0.01 };
        assert!((bound.share(10.1, 10.0) - 0.5).abs() < 1e-9);
        assert!(bound.share(f64::NAN, 1.0) > 1.0 && bound.share(f64::INFINITY, 1.0) > 1.0);
        assert!(bound.share(1.0, f64::NAN) > 1.0 && bound.share(f64::INFINITY, f64::INFINITY) == 0.0);
    }
}
