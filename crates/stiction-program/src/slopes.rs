//! Derivatives of a recorded graph along a direction of its inputs (forward mode).

use crate::graph::{Function, Graph, Node, Op};

/// Adds the derivatives (slopes) of all nodes to the graph. Returns the node of the slope of each
/// node; `None` for a node that does not vary. `given` are the slopes of the inputs.
///
/// Differentiation must precede value numbering. At closed loops, a Newton step does not change the
/// position, so value numbering would remove the step. The derivative of the position, however, is
/// the derivative of this step.
pub(crate) fn slopes(graph: &mut Graph, given: &[Option<Node>]) -> Vec<Option<Node>> {
    let ops = graph.ops().to_vec();
    let mut slopes: Vec<Option<Node>> = Vec::with_capacity(ops.len());
    for (k, op) in ops.iter().enumerate() {
        let of = |node: Node| slopes[node as usize];
        let own = k as Node;
        let slope = match *op {
            Op::Constant(_) | Op::Held(_) => None,
            Op::Input(place) => given.get(place as usize).copied().flatten(),
            Op::Add(a, b) => match (of(a), of(b)) {
                (Some(da), Some(db)) => Some(graph.add(Op::Add(da, db))),
                (da, db) => da.or(db),
            },
            Op::Sub(a, b) => match (of(a), of(b)) {
                (Some(da), Some(db)) => Some(graph.add(Op::Sub(da, db))),
                (None, Some(db)) => Some(graph.add(Op::Neg(db))),
                (da, None) => da,
            },
            Op::Mul(a, b) => {
                let of_first = of(a).map(|da| graph.add(Op::Mul(da, b)));
                let of_second = of(b).map(|db| graph.add(Op::Mul(a, db)));
                match (of_first, of_second) {
                    (Some(da), Some(db)) => Some(graph.add(Op::Add(da, db))),
                    (da, db) => da.or(db),
                }
            }
            Op::Div(a, b) => quotient(graph, of(a), of(b), own, b),
            Op::Neg(a) => of(a).map(|da| graph.add(Op::Neg(da))),
            Op::Sqrt(a) => of(a).map(|da| {
                let half = graph.number(0.5);
                let factor = graph.add(Op::Div(half, own));
                graph.add(Op::Mul(da, factor))
            }),
            Op::Select { of: condition, yes, no } => match (of(yes), of(no)) {
                (None, None) => None,
                (yes, no) => {
                    let zero = graph.number(0.0);
                    let [yes, no] = [yes, no].map(|slope| slope.unwrap_or(zero));
                    Some(graph.add(Op::Select { of: condition, yes, no }))
                }
            },
            Op::Call(function, a, b) => {
                let (da, db) = (of(a), of(b));
                called(graph, function, own, [(a, da), (b, db)])
            }
        };
        // A slope that is always zero is omitted.
        slopes.push(slope.filter(|slope| graph.constant(*slope) != Some(0.0)));
    }
    slopes
}

/// Derivative of a quotient, `(da - (a / b) db) / b`. `of_first` and `of_second` are the
/// derivatives `da` and `db` of the operands, `None` for constants; `quotient` is `a / b`, and `by`
/// is `b`.
fn quotient(
    graph: &mut Graph,
    of_first: Option<Node>,
    of_second: Option<Node>,
    quotient: Node,
    by: Node,
) -> Option<Node> {
    let taken = of_second.map(|db| graph.add(Op::Mul(quotient, db)));
    let change = match (of_first, taken) {
        (Some(da), Some(taken)) => graph.add(Op::Sub(da, taken)),
        (None, Some(taken)) => graph.add(Op::Neg(taken)),
        (da, None) => da?,
    };
    let one = graph.number(1.0);
    let over = graph.add(Op::Div(one, by));
    Some(graph.add(Op::Mul(change, over)))
}

fn called(
    graph: &mut Graph,
    function: Function,
    own: Node,
    [(a, da), (b, db)]: [(Node, Option<Node>); 2],
) -> Option<Node> {
    if function == Function::Atan2 {
        // Derivative of the angle of (x, y): (x dy - y dx) / (x x + y y).
        let of_y = da.map(|dy| graph.add(Op::Mul(b, dy)));
        let of_x = db.map(|dx| graph.add(Op::Mul(a, dx)));
        let change = match (of_y, of_x) {
            (Some(y), Some(x)) => graph.add(Op::Sub(y, x)),
            (None, Some(x)) => graph.add(Op::Neg(x)),
            (y, None) => y?,
        };
        let squares = [a, b].map(|x| graph.add(Op::Mul(x, x)));
        let square = graph.add(Op::Add(squares[0], squares[1]));
        return Some(graph.add(Op::Div(change, square)));
    }
    let da = da?;
    let factor = match function {
        Function::Sin => graph.add(Op::Call(Function::Cos, a, a)),
        Function::Cos => {
            let sine = graph.add(Op::Call(Function::Sin, a, a));
            graph.add(Op::Neg(sine))
        }
        Function::Exp => own,
        Function::Ln => {
            let one = graph.number(1.0);
            graph.add(Op::Div(one, a))
        }
        Function::Atan2 => return None,
    };
    Some(graph.add(Op::Mul(da, factor)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recorded::{record, with_slopes};
    use stiction_core::scalar::{Dual, Scalar};

    /// Returns expressions in `x` and `y` that together use all operations of a graph.
    fn mixture<T: Scalar>(x: T, y: T) -> Vec<T> {
        let (sine, cosine) = (x * y).sin_cos();
        let root = (x * x + y).sqrt();
        vec![
            sine / root - cosine,
            y.atan2(x) + (x / y).exp(),
            (-y).if_positive(x, y * root).ln(),
            T::one() / (x - T::from_f64(3.0)) - root,
            (x - T::from_f64(9.0)).abs(),
            x.held() * y,
        ]
    }

    /// Checks that derivatives in the graph agree with those of dual numbers.
    #[test]
    fn slopes_are_those_of_dual_numbers() {
        let (mut graph, nodes) = record(4, |inputs| with_slopes(|| mixture(inputs[0], inputs[1])));
        let slope_inputs = [2, 3].map(|place| graph.add(Op::Input(place)));
        let found = slopes(&mut graph, &[Some(slope_inputs[0]), Some(slope_inputs[1]), None, None]);
        let inputs = [0.7, 1.3, 0.4, -0.9];
        let mut values: Vec<f64> = Vec::new();
        for op in graph.ops() {
            let of = |node: Node| values[node as usize];
            values.push(match *op {
                Op::Constant(bits) => f64::from_bits(bits),
                Op::Input(place) => inputs[place as usize],
                Op::Add(a, b) => of(a) + of(b),
                Op::Sub(a, b) => of(a) - of(b),
                Op::Mul(a, b) => of(a) * of(b),
                Op::Div(a, b) => of(a) / of(b),
                Op::Neg(a) => -of(a),
                Op::Held(a) => of(a),
                Op::Sqrt(a) => of(a).sqrt(),
                Op::Select { of: c, yes, no } => of(if of(c) > 0.0 { yes } else { no }),
                Op::Call(function, a, b) => function.of(of(a), of(b)),
            });
        }
        let variable = |value, slope| Dual { value, slope: [slope] };
        let wanted = mixture(variable(0.7, 0.4), variable(1.3, -0.9));
        for (node, wanted) in nodes.iter().zip(wanted) {
            let slope = found[*node as usize].map_or(0.0, |slope| values[slope as usize]);
            assert!((slope - wanted.slope[0]).abs() < 1e-14, "{slope} {wanted:?}");
        }
    }
}
