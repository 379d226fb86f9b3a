//! Values of the nodes of a graph at many samples, with bounds of their rounding errors.
//!
//! The values of a node at all samples are computed together, so that most operations use vector
//! registers.

use crate::graph::{Function, Node, Op};

const EPSILON: f64 = f64::EPSILON / 2.0;

/// Values of one node at all samples, with bounds of their rounding errors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub(crate) x: Vec<f64>,
    pub(crate) error: Vec<f64>,
}

/// Values of the nodes of a graph, one row of samples after the other.
#[derive(Clone, Debug)]
pub(crate) struct SampledValues {
    /// Number of samples.
    count: usize,
    x: Vec<f64>,
    error: Vec<f64>,
}

impl Row {
    /// Replaces all values by a number, with the rounding error of this number.
    pub(crate) fn fill(&mut self, number: f64) {
        self.x.fill(number);
        self.error.fill(number.abs() * EPSILON);
    }

    /// Adds the rounding of the values to their error bounds.
    fn round(&mut self) {
        self.error.iter_mut().zip(&self.x).for_each(|(error, x)| *error += x.abs() * EPSILON);
    }
}

impl SampledValues {
    /// Allocates values at `count` samples for `nodes` nodes.
    pub(crate) fn with_capacity(nodes: usize, count: usize) -> Self {
        let numbers = nodes * count;
        Self { count, x: Vec::with_capacity(numbers), error: Vec::with_capacity(numbers) }
    }

    /// Adds the values of the next node.
    pub(crate) fn push(&mut self, row: &Row) {
        self.x.extend_from_slice(&row.x);
        self.error.extend_from_slice(&row.error);
    }

    /// Values of a node at all samples.
    pub(crate) fn x(&self, node: Node) -> &[f64] {
        &self.x[node as usize * self.count..][..self.count]
    }

    /// Error bounds of the values of a node.
    pub(crate) fn error(&self, node: Node) -> &[f64] {
        &self.error[node as usize * self.count..][..self.count]
    }

    /// Writes the values of an operation, computed from the values of its operands, to `row`.
    /// `is_positive` decides which branch a selection takes; its arguments are the index of the
    /// sample, and the value of the condition.
    pub(crate) fn evaluate(
        &self,
        op: Op,
        samples: &[Vec<f64>],
        is_positive: impl Fn(usize, f64) -> bool,
        row: &mut Row,
    ) {
        let of = |node: Node| self.x(node).iter().zip(self.error(node));
        let pairs = |a: Node, b: Node| of(a).zip(of(b));
        row.x.resize(self.count, 0.0);
        row.error.resize(self.count, 0.0);
        let out = row.x.iter_mut().zip(&mut row.error);
        match op {
            Op::Constant(bits) => {
                row.fill(f64::from_bits(bits));
                return;
            }
            Op::Input(k) => {
                for ((x, error), inputs) in out.zip(samples) {
                    (*x, *error) = (inputs[k as usize], 0.0);
                }
            }
            Op::Add(a, b) => {
                for ((x, error), ((a, of_a), (b, of_b))) in out.zip(pairs(a, b)) {
                    (*x, *error) = (a + b, of_a + of_b);
                }
            }
            Op::Sub(a, b) => {
                for ((x, error), ((a, of_a), (b, of_b))) in out.zip(pairs(a, b)) {
                    (*x, *error) = (a - b, of_a + of_b);
                }
            }
            Op::Mul(a, b) => {
                for ((x, error), ((a, of_a), (b, of_b))) in out.zip(pairs(a, b)) {
                    (*x, *error) = (a * b, of_a * b.abs() + of_b * a.abs());
                }
            }
            Op::Div(a, b) => {
                for ((x, error), ((a, of_a), (b, of_b))) in out.zip(pairs(a, b)) {
                    *x = a / b;
                    *error = (of_a + x.abs() * of_b) / b.abs();
                }
            }
            Op::Held(a) => {
                out.zip(of(a)).for_each(|((x, error), (a, of_a))| (*x, *error) = (*a, *of_a));
                return;
            }
            Op::Neg(a) => {
                out.zip(of(a)).for_each(|((x, error), (a, of_a))| (*x, *error) = (-a, *of_a));
                return;
            }
            Op::Sqrt(a) => {
                // The root of the magnitude, because arguments can be negative in branches that are
                // not taken.
                for ((x, error), (a, of_a)) in out.zip(of(a)) {
                    *x = a.abs().sqrt();
                    *error = if *x > 0.0 { of_a / (2.0 * *x) } else { of_a.sqrt() };
                }
            }
            Op::Select { of: condition, yes, no } => {
                for (sample, (x, error)) in out.enumerate() {
                    let is_yes = is_positive(sample, self.x(condition)[sample]);
                    let node = if is_yes { yes } else { no };
                    (*x, *error) = (self.x(node)[sample], self.error(node)[sample]);
                }
                return;
            }
            Op::Call(function, a, b) => {
                for ((x, error), ((a, of_a), (b, of_b))) in out.zip(pairs(a, b)) {
                    (*x, *error) = called(function, (*a, *of_a), (*b, *of_b));
                }
            }
        }
        row.round();
    }

    /// Returns the magnitude relative to which the result of an operation at a sample counts as
    /// zero: that of the larger operand for a sum or difference, in which the operands may cancel,
    /// and one for sine and cosine. It is zero for all other operations, whose results do not
    /// vanish by cancellation.
    pub(crate) fn size_of(&self, op: Op, sample: usize) -> f64 {
        match op {
            Op::Add(a, b) | Op::Sub(a, b) => self.x(a)[sample].abs().max(self.x(b)[sample].abs()),
            Op::Call(Function::Sin | Function::Cos, ..) => 1.0,
            _ => 0.0,
        }
    }
}

/// Value of a function, and the bound of its error that the errors of its arguments cause.
fn called(function: Function, (a, of_a): (f64, f64), (b, of_b): (f64, f64)) -> (f64, f64) {
    let x = function.of(a, b);
    // Derivatives of the function by finite differences; the step is at least as large as the error
    // of the argument.
    let step = of_a.max(a.abs() * 1e-8).max(1e-12);
    let other = of_b.max(b.abs() * 1e-8).max(1e-12);
    let by_first = (function.of(a + step, b) - x).abs() / step;
    let by_other = (function.of(a, b + other) - x).abs() / other;
    (x, by_first * of_a + by_other * of_b)
}
