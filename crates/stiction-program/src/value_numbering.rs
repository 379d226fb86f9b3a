//! Value numbering: merges nodes of a graph that have equal values at all samples, within bounds of
//! the rounding errors.
//!
//! Equation (P2) of the book's theory.

use crate::graph::{Function, Graph, Node, Op};
use std::collections::HashMap;

/// Value of a node at one sample, with a bound of its rounding error.
#[derive(Clone, Copy, Debug)]
struct Value {
    x: f64,
    error: f64,
}

const EPSILON: f64 = f64::EPSILON / 2.0;

/// Two values count as different if they differ by more than this factor times the sum of their
/// error bounds.
const APART: f64 = 64.0;

/// Two values also count as different if their relative difference exceeds this limit, regardless
/// of their error bounds. The bounds grow with every operation, even if the errors do not, and
/// eventually exceed the values.
const CLOSE: f64 = 1e-9;

impl Value {
    fn new(x: f64, error: f64) -> Self {
        Self { x, error: error + x.abs() * EPSILON }
    }

    fn is(self, other: Self, sign: f64) -> bool {
        let apart = (self.x - sign * other.x).abs();
        apart <= APART * (self.error + other.error)
            && apart <= CLOSE * self.x.abs().max(other.x.abs())
    }
}

/// Value of an operation, computed from the values of its operands. `chance` decides which branch a
/// selection takes; its arguments are the node of the condition and the sign of the condition
/// (`true` if positive).
fn value_of(
    op: Op,
    inputs: &[f64],
    of: impl Fn(Node) -> Value,
    chance: impl Fn(Node, bool) -> bool,
) -> Value {
    match op {
        Op::Constant(bits) => Value::new(f64::from_bits(bits), 0.0),
        Op::Input(k) => Value::new(inputs[k as usize], 0.0),
        Op::Add(a, b) => {
            let (a, b) = (of(a), of(b));
            Value::new(a.x + b.x, a.error + b.error)
        }
        Op::Sub(a, b) => {
            let (a, b) = (of(a), of(b));
            Value::new(a.x - b.x, a.error + b.error)
        }
        Op::Mul(a, b) => {
            let (a, b) = (of(a), of(b));
            Value::new(a.x * b.x, a.error * b.x.abs() + b.error * a.x.abs())
        }
        Op::Div(a, b) => {
            let (a, b) = (of(a), of(b));
            let x = a.x / b.x;
            Value::new(x, (a.error + x.abs() * b.error) / b.x.abs())
        }
        Op::Held(a) => of(a),
        Op::Neg(a) => Value { x: -of(a).x, error: of(a).error },
        Op::Sqrt(a) => {
            // The root of the magnitude, because arguments can be negative in branches that are not
            // taken.
            let (a, root) = (of(a), of(a).x.abs().sqrt());
            let error = if root > 0.0 { a.error / (2.0 * root) } else { a.error.sqrt() };
            Value::new(root, error)
        }
        Op::Select { of: condition, yes, no } => {
            if chance(condition, of(condition).x > 0.0) {
                of(yes)
            } else {
                of(no)
            }
        }
        Op::Call(function, a, b) => {
            let (a, b) = (of(a), of(b));
            let x = function.of(a.x, b.x);
            // Derivatives of the function by finite differences; the step is at least as large as
            // the error of the argument.
            let step = a.error.max(a.x.abs() * 1e-8).max(1e-12);
            let other = b.error.max(b.x.abs() * 1e-8).max(1e-12);
            let by_first = (function.of(a.x + step, b.x) - x).abs() / step;
            let by_other = (function.of(a.x, b.x + other) - x).abs() / other;
            Value::new(x, by_first * a.error + by_other * b.error)
        }
    }
}

/// Magnitude relative to which the result of an operation counts as zero: that of the larger
/// operand for a sum or difference, in which the operands may cancel, and one for sine and cosine.
/// It is zero for all other operations, whose results do not vanish by cancellation.
fn size_of(op: Op, of: impl Fn(Node) -> Value) -> f64 {
    match op {
        Op::Add(a, b) | Op::Sub(a, b) => of(a).x.abs().max(of(b).x.abs()),
        Op::Call(Function::Sin | Function::Cos, ..) => 1.0,
        _ => 0.0,
    }
}

/// Hash of two integers.
fn mixed(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ b.wrapping_mul(0xD1B5_4A32_D192_ED03);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Assumption under which nodes of the graph were merged. Either a selection takes the branch that
/// it took in all samples, or a square root equals an expression of constant sign.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Guard {
    /// Node of the original graph that depends on the assumption.
    pub(crate) selection: Node,
    /// Node of the merged graph whose sign must not change.
    pub(crate) condition: Node,
    /// Required sign of `condition`: `true` if it must be positive.
    pub(crate) is_positive: bool,
}

/// Graph after merging, with fewer nodes.
pub(crate) struct Merged {
    pub(crate) graph: Graph,
    /// For each node of the original graph, the node of the merged graph that replaces it.
    pub(crate) new_of: Vec<Node>,
    /// Conditions under which the original and the merged graph are equivalent.
    pub(crate) guards: Vec<Guard>,
}

/// Merges nodes that have the same value, up to sign and rounding, for all `samples` of the inputs.
/// Of several equal nodes, the first one remains.
///
/// Two different polynomials of the inputs agree at random points with probability zero. Samples
/// must be as generic as the inputs permit. Selections that take both branches in the samples are
/// decided at random, so that conditions which mostly agree are not merged; this needs some thirty
/// samples. A selection that takes the same branch in all samples is replaced by this branch, and
/// its condition becomes a guard. A square root that equals another node up to sign also adds a
/// guard.
pub(crate) fn merge(graph: &Graph, samples: &[Vec<f64>]) -> Merged {
    let ops = graph.ops();
    let mut ways: HashMap<Node, [bool; 2]> = HashMap::new();
    for inputs in samples {
        let mut values: Vec<Value> = Vec::with_capacity(ops.len());
        for op in ops {
            let of = |node: Node| values[node as usize];
            let value = value_of(*op, inputs, of, |_, is_positive| is_positive);
            if let Op::Select { of: condition, .. } = *op {
                let is_positive = values[condition as usize].x > 0.0;
                ways.entry(condition).or_default()[usize::from(is_positive)] = true;
            }
            values.push(value);
        }
    }
    let goes_both_ways = |of: Node| ways.get(&of) == Some(&[true, true]);
    let is_positive = |of: Node| ways.get(&of).is_some_and(|[_, positive]| *positive);
    // For each node, its values at all samples.
    let mut values: Vec<Vec<Value>> = Vec::with_capacity(ops.len());
    let mut merged = Graph::default();
    let mut new_of: Vec<Node> = Vec::with_capacity(ops.len());
    let mut guards = Vec::new();
    let mut by_value: HashMap<i64, Vec<(Node, usize)>> = HashMap::new();
    for (k, op) in ops.iter().enumerate() {
        let square = match *op {
            Op::Sqrt(a) => match merged.ops()[new_of[a as usize] as usize] {
                Op::Mul(x, y) if x == y => Some(x),
                _ => None,
            },
            _ => None,
        };
        let mut own: Vec<Value> = samples
            .iter()
            .enumerate()
            .map(|(sample, inputs)| {
                // Random choice of a branch, which is the same for conditions that have been
                // merged.
                let chance = |of: Node, _| match goes_both_ways(of) {
                    true => mixed(u64::from(new_of[of as usize]), sample as u64) & 1 == 0,
                    false => is_positive(of),
                };
                let value = value_of(*op, inputs, |node| values[node as usize][sample], chance);
                // The root of a square is a magnitude, so a random sign distinguishes it from the
                // squared expression.
                let flips = square.is_some_and(|of| mixed(u64::from(of), sample as u64) & 1 == 0);
                if flips { Value { x: -value.x, ..value } } else { value }
            })
            .collect();
        let first = own[0];
        let is_finite = own.iter().all(|value| value.x.is_finite() && value.error.is_finite());
        let is_given = matches!(op, Op::Input(_) | Op::Constant(_));
        let is_zero = || {
            own.iter().enumerate().all(|(sample, value)| {
                let size = size_of(*op, |node| values[node as usize][sample]);
                value.x.abs() <= (APART * value.error).min(CLOSE * size)
            })
        };
        let mut known = None;
        if let Op::Select { of, yes, no } = *op
            && !goes_both_ways(of)
        {
            let is_positive = is_positive(of);
            let condition = new_of[of as usize];
            if merged.constant(condition).is_none() {
                guards.push(Guard { selection: k as Node, condition, is_positive });
            }
            known = Some(new_of[if is_positive { yes } else { no } as usize]);
        } else if is_finite && !is_given && (is_zero() || own.iter().all(|v| v.is(first, 1.0))) {
            let number = if is_zero() { 0.0 } else { first.x };
            known = Some(merged.number(number));
            own.fill(Value::new(number, 0.0));
        } else if is_finite && !matches!(op, Op::Constant(_)) {
            let key = bucket(first.x);
            let candidates = (key - 1..=key + 1).filter_map(|key| by_value.get(&key)).flatten();
            for &(node, other) in candidates {
                let sign = if (first.x > 0.0) == (values[other][0].x > 0.0) { 1.0 } else { -1.0 };
                if own.iter().zip(&values[other]).all(|(a, b)| a.is(*b, sign)) {
                    // The root equals the other node only as long as the other node keeps its sign.
                    let is_root = |op: &Op| matches!(op, Op::Sqrt(_));
                    if is_root(op) && !is_root(&merged.ops()[node as usize]) {
                        let selection = k as Node;
                        guards.push(Guard { selection, condition: node, is_positive: sign > 0.0 });
                    }
                    // An expression that equals an earlier root does so only as long as it keeps
                    // its sign.
                    if !is_root(op) && is_root(&merged.ops()[node as usize]) {
                        let condition = merged.add(op.map(|operand| new_of[operand as usize]));
                        let is_positive = first.x > 0.0;
                        guards.push(Guard { selection: k as Node, condition, is_positive });
                    }
                    known = Some(if sign > 0.0 { node } else { merged.add(Op::Neg(node)) });
                    // The node inherits the rounding errors of its replacement, so that a long
                    // derivation of a known value does not make later nodes less certain.
                    for (value, other) in own.iter_mut().zip(&values[other]) {
                        *value = Value { x: sign * other.x, error: other.error };
                    }
                    break;
                }
            }
        }
        let node = known.unwrap_or_else(|| {
            let node = merged.add(op.map(|operand| new_of[operand as usize]));
            if is_finite && !matches!(op, Op::Constant(_)) {
                by_value.entry(bucket(first.x)).or_default().push((node, k));
            }
            node
        });
        new_of.push(node);
        values.push(own);
    }
    Merged { graph: merged, new_of, guards }
}

/// Index of the logarithmic bucket that contains `x`. Numbers whose magnitudes differ only by
/// rounding are in the same bucket or in neighbouring buckets.
fn bucket(x: f64) -> i64 {
    (x.abs().max(1e-300).ln() * 1e9).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recorded::record;
    use stiction_core::random::Random;
    use stiction_core::scalar::Scalar;

    /// Checks that different values are not merged in a long recurrence, in which error bounds grow
    /// beyond the values although errors do not.
    #[test]
    fn wide_bounds_do_not_merge_different_values() {
        const LONG: usize = 100;
        let (graph, nodes) = record(2, |inputs| {
            let mut all = inputs.to_vec();
            for k in 0..LONG {
                let next = all[k + 1] * crate::recorded::Recorded::from_f64(1.8) - all[k];
                all.push(next);
            }
            all
        });
        let mut random = Random::new(3);
        let samples: Vec<Vec<f64>> =
            (0..40).map(|_| vec![random.number(), random.number()]).collect();
        let Merged { graph: merged, new_of, .. } = merge(&graph, &samples);
        let mut found: Vec<Node> = nodes.iter().map(|node| new_of[*node as usize]).collect();
        assert!(found.iter().all(|node| merged.constant(*node).is_none()));
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), LONG + 2);
    }
}
