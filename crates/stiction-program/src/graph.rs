//! Expression graph without duplicate nodes.

use rustc_hash::FxHashMap;

/// Index of a node in a [`Graph`].
pub(crate) type Node = u32;

/// Operation of a node. All operands are earlier nodes of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    /// Number, stored by its bit pattern.
    Constant(u64),
    /// Input of the program, by its index.
    Input(u32),
    Add(Node, Node),
    Sub(Node, Node),
    Mul(Node, Node),
    Div(Node, Node),
    Neg(Node),
    Sqrt(Node),
    /// Selection: the value of `yes` if `of` is positive, otherwise that of `no`.
    Select {
        of: Node,
        yes: Node,
        no: Node,
    },
    /// Function that has no single machine instruction and is called.
    Call(Function, Node, Node),
    /// Value that differentiation treats as constant. [`Graph::released`] replaces such a node by
    /// its operand afterwards.
    Held(Node),
}

/// Functions that are computed by calls. A function of one argument receives this argument twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Function {
    Sin,
    Cos,
    Exp,
    Ln,
    /// Angle of the vector (x, y), from the arguments y and x.
    Atan2,
}

impl Function {
    pub(crate) fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Sin => a.sin(),
            Self::Cos => a.cos(),
            Self::Exp => a.exp(),
            Self::Ln => a.ln(),
            Self::Atan2 => a.atan2(b),
        }
    }
}

impl Op {
    /// Operands of the operation, as node indices.
    pub(crate) fn operands(self) -> impl Iterator<Item = Node> {
        let all = match self {
            Self::Constant(_) | Self::Input(_) => [None; 3],
            Self::Neg(a) | Self::Sqrt(a) | Self::Held(a) => [Some(a), None, None],
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => {
                [Some(a), Some(b), None]
            }
            Self::Call(Function::Atan2, a, b) => [Some(a), Some(b), None],
            Self::Call(_, a, _) => [Some(a), None, None],
            Self::Select { of, yes, no } => [Some(of), Some(yes), Some(no)],
        };
        all.into_iter().flatten()
    }

    /// Returns the operation with each operand replaced by `to(operand)`.
    pub(crate) fn map(self, to: impl Fn(Node) -> Node) -> Self {
        match self {
            Self::Constant(_) | Self::Input(_) => self,
            Self::Add(a, b) => Self::Add(to(a), to(b)),
            Self::Sub(a, b) => Self::Sub(to(a), to(b)),
            Self::Mul(a, b) => Self::Mul(to(a), to(b)),
            Self::Div(a, b) => Self::Div(to(a), to(b)),
            Self::Neg(a) => Self::Neg(to(a)),
            Self::Held(a) => Self::Held(to(a)),
            Self::Sqrt(a) => Self::Sqrt(to(a)),
            Self::Select { of, yes, no } => Self::Select { of: to(of), yes: to(yes), no: to(no) },
            Self::Call(function, a, b) => Self::Call(function, to(a), to(b)),
        }
    }
}

/// Expression graph: operations in topological order, in which operands precede the operations that
/// read them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    ops: Vec<Op>,
    known: FxHashMap<Op, Node>,
}

impl Graph {
    pub(crate) fn ops(&self) -> &[Op] {
        &self.ops
    }

    /// Replaces each [`Op::Held`] node by its operand. Returns the new graph and the new node of
    /// each old node.
    pub(crate) fn released(&self) -> (Self, Vec<Node>) {
        let mut new = Self::default();
        let mut new_of = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            new_of.push(match *op {
                Op::Held(node) => new_of[node as usize],
                op => new.add(op.map(|operand| new_of[operand as usize])),
            });
        }
        (new, new_of)
    }

    /// Returns the node of an operation, and adds it to the graph if necessary. The operation is
    /// simplified where constants or signs permit.
    pub(crate) fn add(&mut self, op: Op) -> Node {
        match op {
            Op::Add(a, b) => self.sum(a, b),
            Op::Sub(a, b) => self.difference(a, b),
            Op::Mul(a, b) => self.product(a, b),
            Op::Div(a, b) => self.quotient(a, b),
            Op::Neg(a) => self.negative(a),
            Op::Sqrt(a) => self.root(a),
            Op::Call(function, a, b) => match (self.constant(a), self.constant(b)) {
                (Some(x), Some(y)) => self.number(function.of(x, y)),
                _ => self.call(function, a, b),
            },
            Op::Select { of, yes, no } => match self.constant(of) {
                Some(x) => {
                    if x > 0.0 {
                        yes
                    } else {
                        no
                    }
                }
                None if yes == no => yes,
                None => self.place(op),
            },
            Op::Held(a) if self.constant(a).is_some() => a,
            Op::Constant(_) | Op::Input(_) | Op::Held(_) => self.place(op),
        }
    }

    /// Returns the node of a constant; positive and negative zero share one node.
    pub(crate) fn number(&mut self, x: f64) -> Node {
        self.place(Op::Constant((x + 0.0).to_bits()))
    }

    pub(crate) fn constant(&self, node: Node) -> Option<f64> {
        match self.ops[node as usize] {
            Op::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn place(&mut self, op: Op) -> Node {
        let ops = &mut self.ops;
        *self.known.entry(op).or_insert_with(|| {
            ops.push(op);
            (ops.len() - 1) as Node
        })
    }

    /// Operand of a node that is a negation; `None` for any other node.
    fn negated(&self, node: Node) -> Option<Node> {
        match self.ops[node as usize] {
            Op::Neg(a) => Some(a),
            _ => None,
        }
    }

    fn sum(&mut self, a: Node, b: Node) -> Node {
        match (self.constant(a), self.constant(b)) {
            (Some(x), Some(y)) => return self.number(x + y),
            (Some(0.0), _) => return b,
            (_, Some(0.0)) => return a,
            _ => {}
        }
        match (self.negated(a), self.negated(b)) {
            (_, Some(b)) => self.difference(a, b),
            (Some(a), None) => self.difference(b, a),
            (None, None) => self.place(Op::Add(a.min(b), a.max(b))),
        }
    }

    fn difference(&mut self, a: Node, b: Node) -> Node {
        if a == b {
            return self.number(0.0);
        }
        match (self.constant(a), self.constant(b)) {
            (Some(x), Some(y)) => return self.number(x - y),
            (Some(0.0), _) => return self.negative(b),
            (_, Some(0.0)) => return a,
            _ => {}
        }
        match (self.negated(a), self.negated(b)) {
            (_, Some(b)) => self.sum(a, b),
            // The sign moves outwards, until a sum absorbs it.
            (Some(a), None) => {
                let sum = self.sum(a, b);
                self.negative(sum)
            }
            (None, None) => self.place(Op::Sub(a, b)),
        }
    }

    fn product(&mut self, a: Node, b: Node) -> Node {
        match (self.constant(a), self.constant(b)) {
            (Some(x), Some(y)) => return self.number(x * y),
            (Some(0.0), _) | (_, Some(0.0)) => return self.number(0.0),
            (Some(1.0), _) => return b,
            (_, Some(1.0)) => return a,
            (Some(-1.0), _) => return self.negative(b),
            (_, Some(-1.0)) => return self.negative(a),
            _ => {}
        }
        let (own, other) = (self.negated(a), self.negated(b));
        let turned = own.is_some() != other.is_some();
        let (a, b) = (own.unwrap_or(a), other.unwrap_or(b));
        let product = self.place(Op::Mul(a.min(b), a.max(b)));
        if turned { self.negative(product) } else { product }
    }

    fn quotient(&mut self, a: Node, b: Node) -> Node {
        match (self.constant(a), self.constant(b)) {
            (Some(x), Some(y)) => self.number(x / y),
            (Some(0.0), _) => self.number(0.0),
            (Some(1.0), _) => self.place(Op::Div(a, b)),
            // The product with the reciprocal differs from the quotient by at most a unit in the
            // last place, and other quotients may share the reciprocal.
            (_, Some(y)) => {
                let over = self.number(1.0 / y);
                self.product(a, over)
            }
            _ => {
                let one = self.number(1.0);
                let over = self.place(Op::Div(one, b));
                self.product(a, over)
            }
        }
    }

    /// Returns the node of a square root. The root of a square is recorded as the absolute value of
    /// the squared expression: a selection by the sign of this expression.
    fn root(&mut self, a: Node) -> Node {
        match self.ops[a as usize] {
            Op::Constant(bits) => self.number(f64::from_bits(bits).sqrt()),
            Op::Mul(x, y) if x == y => {
                let no = self.negative(x);
                self.add(Op::Select { of: x, yes: x, no })
            }
            _ => self.place(Op::Sqrt(a)),
        }
    }

    fn negative(&mut self, a: Node) -> Node {
        match self.ops[a as usize] {
            Op::Constant(bits) => self.number(-f64::from_bits(bits)),
            Op::Neg(a) => a,
            Op::Sub(a, b) => self.place(Op::Sub(b, a)),
            _ => self.place(Op::Neg(a)),
        }
    }

    /// Returns the node of a function call. The sine and cosine of an angle that `atan2` returns
    /// are computed from the arguments of `atan2` without a call.
    fn call(&mut self, function: Function, a: Node, b: Node) -> Node {
        let (Function::Sin | Function::Cos, Op::Call(Function::Atan2, y, x)) =
            (function, self.ops[a as usize])
        else {
            return self.place(Op::Call(function, a, b));
        };
        let (xx, yy) = (self.product(x, x), self.product(y, y));
        let sum = self.sum(xx, yy);
        let radius = self.add(Op::Sqrt(sum));
        self.quotient(if function == Function::Sin { y } else { x }, radius)
    }
}

/// Marks the nodes on which the nodes `by` depend, including `by` themselves.
pub(crate) fn needed(ops: &[Op], by: &[Node]) -> Vec<bool> {
    let mut needed = vec![false; ops.len()];
    by.iter().for_each(|node| needed[*node as usize] = true);
    for k in (0..ops.len()).rev() {
        if needed[k] {
            ops[k].operands().for_each(|operand| needed[operand as usize] = true);
        }
    }
    needed
}
