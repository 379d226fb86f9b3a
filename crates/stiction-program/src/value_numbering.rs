//! Value numbering: merges nodes of a graph that have equal values at all samples, within bounds of
//! the rounding errors.
//!
//! Equation (P2) of the book's theory.

use crate::graph::{Function, Graph, Node, Op};
use crate::sampled_values::{Row, SampledValues};
use rustc_hash::FxHashMap;

/// Two values count as different if they differ by more than this factor times the sum of their
/// error bounds.
const APART: f64 = 64.0;

/// Two values also count as different if their relative difference exceeds this limit, regardless
/// of their error bounds. The bounds grow with every operation, even if the errors do not, and
/// eventually exceed the values.
const CLOSE: f64 = 1e-9;

/// Returns true if the value `a` equals `sign` times the value `b`; both are pairs of value and
/// error bound.
fn agree(a: (f64, f64), b: (f64, f64), sign: f64) -> bool {
    let apart = (a.0 - sign * b.0).abs();
    apart <= APART * (a.1 + b.1) && apart <= CLOSE * a.0.abs().max(b.0.abs())
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
/// must be as generic as the inputs permit. Exponentials and logarithms of different arguments have
/// random values: an exponential vanishes within rounding at most samples, such as the Stribeck term
/// at speeds far above the Stribeck velocity, but not everywhere. Selections that take both branches
/// in the samples are decided at random, so that conditions which mostly agree are not merged; this
/// needs some thirty samples. Where the condition is exactly zero, the branch is the actual one,
/// because the other one may have a pole there. A selection that takes the same branch in all
/// samples is replaced by this branch, and its condition becomes a guard. A square root that equals
/// another node up to sign also adds a guard.
pub(crate) fn merge(graph: &Graph, samples: &[Vec<f64>]) -> Merged {
    let ops = graph.ops();
    let ways = ways_of_conditions(ops, samples);
    let goes_both_ways = |of: Node| ways.get(&of) == Some(&[true, true]);
    let is_positive = |of: Node| ways.get(&of).is_some_and(|[_, positive]| *positive);
    let mut values = SampledValues::with_capacity(ops.len(), samples.len());
    let mut own = Row::default();
    let mut merged = Graph::default();
    let mut new_of: Vec<Node> = Vec::with_capacity(ops.len());
    let mut guards = Vec::new();
    let mut by_value: FxHashMap<i64, Vec<(Node, Node)>> = FxHashMap::default();
    for (k, op) in ops.iter().enumerate() {
        let square = match *op {
            Op::Sqrt(a) => match merged.ops()[new_of[a as usize] as usize] {
                Op::Mul(x, y) if x == y => Some(x),
                _ => None,
            },
            _ => None,
        };
        // Random choice of a branch, which is the same for conditions that have been merged.
        let takes = |sample: usize, condition: f64| match *op {
            Op::Select { of, .. } if goes_both_ways(of) => {
                condition != 0.0 && mixed(u64::from(new_of[of as usize]), sample as u64) & 1 == 0
            }
            Op::Select { of, .. } => is_positive(of),
            _ => false,
        };
        values.evaluate(*op, samples, takes, &mut own);
        if let Op::Call(function @ (Function::Exp | Function::Ln), of, _) = *op
            && merged.constant(new_of[of as usize]).is_none()
        {
            let kind = u64::from(function == Function::Exp) << 32;
            let of = u64::from(new_of[of as usize]) | kind;
            for (sample, x) in own.x.iter_mut().enumerate() {
                *x = 0.25 + 0.5 * (mixed(of, sample as u64) as f64 / u64::MAX as f64);
            }
            own.error.fill(f64::EPSILON);
        }
        if let Some(of) = square {
            // The root of a square is a magnitude, so a random sign distinguishes it from the
            // squared expression.
            for (sample, x) in own.x.iter_mut().enumerate() {
                if mixed(u64::from(of), sample as u64) & 1 == 0 {
                    *x = -*x;
                }
            }
        }
        let first = (own.x[0], own.error[0]);
        let is_finite = own.x.iter().chain(&own.error).all(|number| number.is_finite());
        let is_given = matches!(op, Op::Input(_) | Op::Constant(_));
        let is_zero = || {
            own.x.iter().zip(&own.error).enumerate().all(|(sample, (x, error))| {
                x.abs() <= (APART * error).min(CLOSE * values.size_of(*op, sample))
            })
        };
        let agrees_with = |x: &[f64], error: &[f64], sign: f64| {
            let each = own.x.iter().zip(&own.error).zip(x.iter().zip(error));
            each.into_iter().all(|((a, of_a), (b, of_b))| agree((*a, *of_a), (*b, *of_b), sign))
        };
        let is_constant =
            || own.x.iter().zip(&own.error).all(|(x, error)| agree((*x, *error), first, 1.0));
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
        } else if is_finite && !is_given && (is_zero() || is_constant()) {
            let number = if is_zero() { 0.0 } else { first.0 };
            known = Some(merged.number(number));
            own.fill(number);
        } else if is_finite && !matches!(op, Op::Constant(_)) {
            let key = bucket(first.0);
            let candidates = (key - 1..=key + 1).filter_map(|key| by_value.get(&key)).flatten();
            for &(node, other) in candidates {
                let (x, error) = (values.x(other), values.error(other));
                let sign = if (first.0 > 0.0) == (x[0] > 0.0) { 1.0 } else { -1.0 };
                if agrees_with(x, error, sign) {
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
                        let is_positive = first.0 > 0.0;
                        guards.push(Guard { selection: k as Node, condition, is_positive });
                    }
                    known = Some(if sign > 0.0 { node } else { merged.add(Op::Neg(node)) });
                    // The node inherits the rounding errors of its replacement, so that a long
                    // derivation of a known value does not make later nodes less certain.
                    own.x.iter_mut().zip(x).for_each(|(own, x)| *own = sign * x);
                    own.error.copy_from_slice(error);
                    break;
                }
            }
        }
        let node = known.unwrap_or_else(|| {
            let node = merged.add(op.map(|operand| new_of[operand as usize]));
            if is_finite && !matches!(op, Op::Constant(_)) {
                by_value.entry(bucket(first.0)).or_default().push((node, k as Node));
            }
            node
        });
        new_of.push(node);
        values.push(&own);
    }
    Merged { graph: merged, new_of, guards }
}

/// Returns for each condition of a selection whether it is ever not positive, and whether it is
/// ever positive, at the samples.
fn ways_of_conditions(ops: &[Op], samples: &[Vec<f64>]) -> FxHashMap<Node, [bool; 2]> {
    // Only nodes on which a condition depends are evaluated.
    let mut is_needed = vec![false; ops.len()];
    for (k, op) in ops.iter().enumerate().rev() {
        if let Op::Select { of, .. } = op {
            is_needed[*of as usize] = true;
        }
        if is_needed[k] {
            op.operands().for_each(|operand| is_needed[operand as usize] = true);
        }
    }
    let count = is_needed.iter().filter(|needed| **needed).count();
    let mut values = SampledValues::with_capacity(count, samples.len());
    let mut own = Row::default();
    // Place of each needed node among the evaluated nodes.
    let mut places = vec![0; ops.len()];
    let mut ways: FxHashMap<Node, [bool; 2]> = FxHashMap::default();
    let mut next = 0;
    for (k, op) in ops.iter().enumerate() {
        if let Op::Select { of, .. } = op {
            let way = ways.entry(*of).or_default();
            for x in values.x(places[*of as usize]) {
                way[usize::from(*x > 0.0)] = true;
            }
        }
        if is_needed[k] {
            let op = op.map(|operand| places[operand as usize]);
            values.evaluate(op, samples, |_, x| x > 0.0, &mut own);
            values.push(&own);
            places[k] = next;
            next += 1;
        }
    }
    ways
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

    /// Checks that a term that vanishes within rounding at all samples, but not everywhere, is kept:
    /// the Stribeck term, and the two forms `1/(1 + e)` and `1 - e`.
    #[test]
    fn exponentials_that_vanish_at_the_samples_are_kept() {
        let (graph, nodes) = record(1, |inputs| {
            let decay = (-inputs[0] * inputs[0]).exp();
            let one = crate::recorded::Recorded::one();
            let half = crate::recorded::Recorded::from_f64(0.5);
            vec![half + half * decay, one / (one + decay), one - decay]
        });
        let samples: Vec<Vec<f64>> = (0..40).map(|k| vec![100.0 + f64::from(k)]).collect();
        let Merged { graph: merged, new_of, .. } = merge(&graph, &samples);
        let mut found: Vec<Node> = nodes.iter().map(|node| new_of[*node as usize]).collect();
        assert!(found.iter().all(|node| merged.constant(*node).is_none()));
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), 3);
    }

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
