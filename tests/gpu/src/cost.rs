//! What a shader function costs, counted in its text: no device is asked, and no compiler's cleverness is counted.

use std::collections::BTreeMap;
use std::ops::{Add, AddAssign, Mul};

use wgpu::naga::valid::{Capabilities, FunctionInfo, ValidationFlags, Validator};
use wgpu::naga::{
    BinaryOperator, Block, Expression, Function, Handle, MathFunction, Module, Scalar, ScalarKind, Statement,
    TypeInner, VectorSize, front::wgsl,
};

/// Operations on single numbers, of all branches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Additions, multiplications, comparisons, minima and the like: one instruction each.
    pub plain: u32,
    /// Divisions, roots, powers, exponentials, logarithms, angles: on graphics hardware run at a quarter of the rate or
    /// less. A power is two, and so is a tangent; inverse angles count as one and take more.
    pub special: u32,
}

/// How many plain operations a special one is weighed as.
pub const SPECIAL: u32 = 4;

impl Cost {
    /// In plain operations.
    pub fn weight(self) -> u32 {
        self.plain + SPECIAL * self.special
    }
}

impl Add for Cost {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { plain: self.plain + other.plain, special: self.special + other.special }
    }
}

impl AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<u32> for Cost {
    type Output = Self;
    fn mul(self, n: u32) -> Self {
        Self { plain: self.plain * n, special: self.special * n }
    }
}

fn plain(n: u32) -> Cost {
    Cost { plain: n, special: 0 }
}

fn special(n: u32) -> Cost {
    Cost { plain: 0, special: n }
}

/// The cost of every function of a program, with all that it calls; both sides of an `if` count, and a loop's body as often as
/// a comment `// turns: 4` after its head says.
pub fn costs(text: &str) -> BTreeMap<String, Cost> {
    let module = wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    let info = validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let mut known: BTreeMap<Handle<Function>, Cost> = BTreeMap::new();
    let mut named = BTreeMap::new();
    // A function stands after those that it calls.
    for (handle, function) in module.functions.iter() {
        let count = Count { module: &module, function, info: &info[handle], known: &known, text };
        let cost = count.block(&function.body);
        known.insert(handle, cost);
        named.extend(function.name.clone().map(|name| (name, cost)));
    }
    named
}

/// How often the loop with this head turns.
fn turns(head: &str) -> u32 {
    let said = head.split_once("{ // turns: ").and_then(|(_, n)| n.parse().ok());
    said.unwrap_or_else(|| panic!("no `// turns: ` after the head of a loop: {head}"))
}

struct Count<'a> {
    module: &'a Module,
    function: &'a Function,
    info: &'a FunctionInfo,
    known: &'a BTreeMap<Handle<Function>, Cost>,
    text: &'a str,
}

impl Count<'_> {
    fn block(&self, block: &Block) -> Cost {
        let mut sum = Cost::default();
        for (statement, span) in block.span_iter() {
            sum += match statement {
                Statement::Emit(range) => range.clone().fold(Cost::default(), |sum, e| sum + self.expression(e)),
                Statement::Call { function, .. } => self.known[function],
                Statement::Block(inner) => self.block(inner),
                Statement::If { accept, reject, .. } => self.block(accept) + self.block(reject),
                Statement::Loop { body, continuing, .. } => {
                    let head =
                        self.text.lines().nth(span.location(self.text).line_number as usize - 1).unwrap_or_default();
                    (self.block(body) + self.block(continuing)) * turns(head)
                }
                _ => Cost::default(),
            };
        }
        sum
    }

    /// Numbers of a value: 1 to 4; whether they are floats.
    fn shape(&self, e: Handle<Expression>) -> (u32, bool) {
        let float = |s: &Scalar| s.kind == ScalarKind::Float;
        match self.info[e].ty.inner_with(&self.module.types) {
            TypeInner::Vector { size, scalar } => (
                match size {
                    VectorSize::Bi => 2,
                    VectorSize::Tri => 3,
                    VectorSize::Quad => 4,
                },
                float(scalar),
            ),
            TypeInner::Scalar(scalar) => (1, float(scalar)),
            _ => (1, false),
        }
    }

    fn expression(&self, e: Handle<Expression>) -> Cost {
        let n = self.shape(e).0;
        match &self.function.expressions[e] {
            Expression::Binary { op: BinaryOperator::Divide, .. } if self.shape(e).1 => plain(n) + special(n),
            Expression::Binary { .. } | Expression::Select { .. } | Expression::Derivative { .. } => plain(n),
            // Signs are free: instructions take negated operands.
            Expression::Math { fun, arg, .. } => math(*fun, n, self.shape(*arg).0),
            _ => Cost::default(),
        }
    }
}

/// A built-in function with a result of `n` numbers from arguments of `of`.
fn math(fun: MathFunction, n: u32, of: u32) -> Cost {
    use MathFunction as F;
    match fun {
        F::Abs => Cost::default(),
        F::Clamp | F::Mix => plain(2 * n),
        F::Min | F::Max | F::Sign | F::Floor | F::Ceil | F::Fract | F::Fma => plain(n),
        F::Dot => plain(2 * of - 1),
        F::Cross => plain(9),
        F::Length => plain(2 * of - 1) + special(1),
        F::Normalize => plain(3 * of - 1) + special(1),
        F::Pow => plain(n) + special(2 * n),
        F::Tan => special(2 * n),
        F::Sqrt | F::InverseSqrt | F::Exp | F::Exp2 | F::Log | F::Log2 | F::Sin | F::Cos => special(n),
        F::Asin | F::Acos | F::Atan | F::Atan2 => special(n),
        other => panic!("{other:?} has no cost yet"),
    }
}
