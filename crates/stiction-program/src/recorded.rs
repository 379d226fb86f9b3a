//! Scalar type that records operations in an expression graph instead of computing numbers.

use crate::graph::{Function, Graph, Node, Op};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use std::cell::{Cell, RefCell};
use stiction_core::scalar::Scalar;

thread_local! {
    // Scalars must be `Copy`, so they cannot own the graph.
    static GRAPH: RefCell<Graph> = RefCell::default();
    // `true` during a recording that will be differentiated.
    static WITH_SLOPES: Cell<bool> = const { Cell::new(false) };
}

/// Symbolic number: a node of the graph that this thread records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Recorded(Node);

/// Records the operations of `f` on `inputs` inputs. Returns the graph, and the nodes of the
/// results of `f`.
pub(crate) fn record(
    inputs: usize,
    f: impl FnOnce(&[Recorded]) -> Vec<Recorded>,
) -> (Graph, Vec<Node>) {
    let before = GRAPH.take();
    let inputs: Vec<Recorded> = (0..inputs as u32).map(|k| node_of(Op::Input(k))).collect();
    let outputs = f(&inputs).into_iter().map(|recorded| recorded.0).collect();
    (GRAPH.replace(before), outputs)
}

/// Calls `f` so that its recordings can be differentiated: values that differentiation treats as
/// constant become [`Op::Held`] nodes, see [`Graph::released`].
pub(crate) fn with_slopes<T>(f: impl FnOnce() -> T) -> T {
    let before = WITH_SLOPES.replace(true);
    let result = f();
    WITH_SLOPES.set(before);
    result
}

/// Records the operations of `f` as [`record`] does, with `N` groups of results.
pub(crate) fn record_groups<const N: usize>(
    inputs: usize,
    f: impl FnOnce(&[Recorded]) -> [Vec<Recorded>; N],
) -> (Graph, [Vec<Node>; N]) {
    let mut sizes = [0; N];
    let (graph, nodes) = record(inputs, |inputs| {
        let groups = f(inputs);
        sizes = groups.each_ref().map(Vec::len);
        groups.into_iter().flatten().collect()
    });
    let mut left = nodes.into_iter();
    (graph, sizes.map(|size| left.by_ref().take(size).collect()))
}

/// Extends a graph: records the operations of `f` on the given nodes of the graph. Returns the
/// extended graph, and the nodes of the results of `f`.
pub(crate) fn extend_graph(
    graph: Graph,
    nodes: &[Node],
    f: impl FnOnce(&[Recorded]) -> Vec<Recorded>,
) -> (Graph, Vec<Node>) {
    let before = GRAPH.replace(graph);
    let nodes: Vec<Recorded> = nodes.iter().map(|node| Recorded(*node)).collect();
    let outputs = f(&nodes).into_iter().map(|recorded| recorded.0).collect();
    (GRAPH.replace(before), outputs)
}

fn node_of(op: Op) -> Recorded {
    GRAPH.with_borrow_mut(|graph| Recorded(graph.add(op)))
}

macro_rules! records {
    ($($operator:ident :: $method:ident),*) => {$(
        impl $operator for Recorded {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                node_of(Op::$operator(self.0, other.0))
            }
        }
    )*};
}
records!(Add::add, Sub::sub, Mul::mul, Div::div);

impl Neg for Recorded {
    type Output = Self;
    fn neg(self) -> Self {
        node_of(Op::Neg(self.0))
    }
}

macro_rules! by_operator {
    ($($operator:ident :: $method:ident by $symbol:tt),*) => {$(
        impl $operator for Recorded {
            fn $method(&mut self, other: Self) {
                *self = *self $symbol other;
            }
        }
    )*};
}
by_operator!(AddAssign::add_assign by +, SubAssign::sub_assign by -, MulAssign::mul_assign by *);

impl Scalar for Recorded {
    fn has_slope() -> bool {
        WITH_SLOPES.get()
    }

    fn held(self) -> Self {
        if WITH_SLOPES.get() { node_of(Op::Held(self.0)) } else { self }
    }

    fn from_f64(value: f64) -> Self {
        GRAPH.with_borrow_mut(|graph| Self(graph.number(value)))
    }

    fn sqrt(self) -> Self {
        node_of(Op::Sqrt(self.0))
    }

    fn sin_cos(self) -> (Self, Self) {
        let of = |function| node_of(Op::Call(function, self.0, self.0));
        (of(Function::Sin), of(Function::Cos))
    }

    fn atan2(self, x: Self) -> Self {
        node_of(Op::Call(Function::Atan2, self.0, x.0))
    }

    fn exp(self) -> Self {
        node_of(Op::Call(Function::Exp, self.0, self.0))
    }

    fn ln(self) -> Self {
        node_of(Op::Call(Function::Ln, self.0, self.0))
    }

    fn if_positive(self, yes: Self, no: Self) -> Self {
        node_of(Op::Select { of: self.0, yes: yes.0, no: no.0 })
    }

    /// Returns infinity: values are unknown during the recording, so an iteration must not count as
    /// converged.
    fn largest(self) -> f64 {
        f64::INFINITY
    }
}
