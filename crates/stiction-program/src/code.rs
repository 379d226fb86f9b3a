//! Straight-line code, and its compilation from expression graphs. The operands of a step are
//! memory slots, constants and the results of earlier steps.

use crate::error::RecordError;
use crate::graph::{Function, Node, Op, needed};
use core::ops::Range;
use rustc_hash::FxHashMap;

/// Operand of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Source {
    /// Memory slot, by its index. Slots keep their values after the code has run.
    Slot(u32),
    /// Constant of the code, by its index.
    Constant(u32),
    /// Number that all lanes share, by its index in a separate read-only memory.
    Common(u32),
    /// Result of an earlier step, by the index of the step.
    Step(u32),
}

/// Operation that is computed by one or a few machine instructions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    Add(Source, Source),
    Sub(Source, Source),
    Mul(Source, Source),
    Div(Source, Source),
    Neg(Source),
    Sqrt(Source),
    Select {
        of: Source,
        yes: Source,
        no: Source,
    },
    /// Sum or difference of a product and a third operand, rounded once.
    Fused(Fused, [Source; 3]),
}

/// Kind of fused multiply-add, with the three operands `a`, `b`, `c`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fused {
    /// Sum `a b + c`.
    Add,
    /// Difference `a b - c`.
    Sub,
    /// Difference `c - a b`.
    From,
}

impl Fused {
    pub(crate) fn of(self, a: f64, b: f64, c: f64) -> f64 {
        match self {
            Self::Add => a.mul_add(b, c),
            Self::Sub => a.mul_add(b, -c),
            Self::From => (-a).mul_add(b, c),
        }
    }
}

impl Step {
    /// Returns the step with each operand replaced by `to(operand)`.
    pub(crate) fn map(self, to: impl Fn(Source) -> Source) -> Self {
        match self {
            Self::Add(a, b) => Self::Add(to(a), to(b)),
            Self::Sub(a, b) => Self::Sub(to(a), to(b)),
            Self::Mul(a, b) => Self::Mul(to(a), to(b)),
            Self::Div(a, b) => Self::Div(to(a), to(b)),
            Self::Neg(a) => Self::Neg(to(a)),
            Self::Sqrt(a) => Self::Sqrt(to(a)),
            Self::Select { of, yes, no } => Self::Select { of: to(of), yes: to(yes), no: to(no) },
            Self::Fused(kind, operands) => Self::Fused(kind, operands.map(to)),
        }
    }

    pub(crate) fn operands(self) -> impl Iterator<Item = Source> {
        let all = match self {
            Self::Fused(_, operands) => operands.map(Some),
            Self::Neg(a) | Self::Sqrt(a) => [Some(a), None, None],
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => {
                [Some(a), Some(b), None]
            }
            Self::Select { of, yes, no } => [Some(of), Some(yes), Some(no)],
        };
        all.into_iter().flatten()
    }
}

/// Straight-line code: steps in the order of their execution, constants, and the slots to which
/// values are stored at the end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Code {
    pub(crate) steps: Vec<Step>,
    pub(crate) constants: Vec<f64>,
    pub(crate) stores: Vec<(Source, u32)>,
}

/// Call of a mathematical function between two blocks of straight-line code. Arguments and result
/// are given by the indices of their slots.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Call {
    pub(crate) function: Function,
    pub(crate) arguments: [u32; 2],
    pub(crate) result: u32,
}

/// Part of a program: a block of straight-line code, or function calls between two blocks.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    Code(Code),
    Calls(Vec<Call>),
}

impl Part {
    /// Number of arithmetic operations, including function calls.
    pub(crate) fn operations(&self) -> usize {
        match self {
            Self::Code(code) => code.steps.len(),
            Self::Calls(calls) => calls.len(),
        }
    }
}

/// Assignment of memory slots to the nodes of a graph. Nodes whose values are the same in all lanes
/// can have an index in the shared memory instead of a slot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Slots {
    of_node: FxHashMap<Node, u32>,
    common: FxHashMap<Node, u32>,
    count: u32,
}

impl Slots {
    /// Reserves `count` consecutive slots and returns the index of the first one.
    pub(crate) fn reserve(&mut self, count: usize) -> u32 {
        let first = self.count;
        self.count += count as u32;
        first
    }

    /// Creates an assignment in which the inputs with indices in `inputs` have the first slots, in
    /// the order of their indices.
    pub(crate) fn of_inputs(ops: &[Op], inputs: Range<usize>) -> Self {
        let mut slots = Self::default();
        slots.reserve(inputs.len());
        for (node, op) in ops.iter().enumerate() {
            match op {
                Op::Input(place) if inputs.contains(&(*place as usize)) => {
                    slots.assign(node as Node, place - inputs.start as u32);
                }
                _ => {}
            }
        }
        slots
    }

    /// Assigns a slot to a node.
    pub(crate) fn assign(&mut self, node: Node, slot: u32) {
        self.of_node.insert(node, slot);
    }

    /// Assigns to a node the index `place` in the memory that all lanes share.
    pub(crate) fn assign_common(&mut self, node: Node, place: u32) {
        self.common.insert(node, place);
    }

    pub(crate) fn of(&self, node: Node) -> Option<u32> {
        self.of_node.get(&node).copied()
    }

    /// Returns the slots of the results `nodes`, which must have been compiled.
    ///
    /// # Errors
    /// [`RecordError::NotConfirmed`] if a node has no slot.
    pub(crate) fn places(&self, nodes: &[Node]) -> Result<Vec<u32>, RecordError> {
        nodes.iter().map(|node| self.of(*node).ok_or(RecordError::NotConfirmed)).collect()
    }

    /// Returns the slot of one compiled result, see [`Self::places`].
    pub(crate) fn place(&self, node: Node) -> Result<u32, RecordError> {
        self.of(node).ok_or(RecordError::NotConfirmed)
    }

    /// Returns the slot or the shared number that is already assigned to a node; `None` if there is
    /// none.
    fn known(&self, node: Node) -> Option<Source> {
        let common = || self.common.get(&node).map(|place| Source::Common(*place));
        self.of(node).map(Source::Slot).or_else(common)
    }

    fn made(&mut self, node: Node) -> u32 {
        if let Some(slot) = self.of(node) {
            return slot;
        }
        let slot = self.reserve(1);
        self.assign(node, slot);
        slot
    }

    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }
}

/// Finds pairs of operations that can be combined into one step. Returns the partner of each node;
/// `None` for a node without partner. If `fuse` is true, a product and the only sum or difference
/// that reads the product form a fused step, unless a function call lies between them. A reciprocal
/// and the only product that reads the reciprocal form a quotient.
fn pairs(
    ops: &[Op],
    needed: &[bool],
    level: &[usize],
    crosses: &[bool],
    fuse: bool,
) -> Vec<Option<Node>> {
    let mut readers = vec![0_u32; ops.len()];
    for (_, op) in ops.iter().enumerate().filter(|(k, _)| needed[*k]) {
        op.operands().for_each(|operand| readers[operand as usize] += 1);
    }
    let mut with = vec![None; ops.len()];
    let alone = |node: Node, by: usize| {
        let at = node as usize;
        readers[at] == 1 && !crosses[at] && level[at] == level[by]
    };
    for (k, op) in ops.iter().enumerate().filter(|(k, _)| fuse && needed[*k]) {
        let (Op::Add(a, b) | Op::Sub(a, b)) = *op else { continue };
        let serves = |node: &Node| alone(*node, k) && matches!(ops[*node as usize], Op::Mul(..));
        // If both operands are suitable products, the later one is preferred, because its own
        // operands are closer.
        if let Some(product) = [a.max(b), a.min(b)].into_iter().find(serves) {
            with[k] = Some(product);
            with[product as usize] = Some(k as Node);
        }
    }
    for (k, op) in ops.iter().enumerate().filter(|(k, _)| needed[*k]) {
        let Op::Mul(a, b) = *op else { continue };
        let is_reciprocal = |node: &Node| alone(*node, k) && is_reciprocal(ops, *node);
        if let (None, Some(over)) = (with[k], [a, b].into_iter().find(is_reciprocal)) {
            with[k] = Some(over);
            with[over as usize] = Some(k as Node);
        }
    }
    with
}

fn is_reciprocal(ops: &[Op], node: Node) -> bool {
    let one = Op::Constant(1.0_f64.to_bits());
    matches!(ops[node as usize], Op::Div(a, _) if ops[a as usize] == one)
}

/// Compiles code for those `results` that have no slot yet, and assigns slots to these results. If
/// `fuse` is true, products and sums are combined into fused multiply-adds.
pub(crate) fn compile(ops: &[Op], results: &[Node], slots: &mut Slots, fuse: bool) -> Vec<Part> {
    // Results with a slot need no code.
    let open: Vec<Node> = results.iter().copied().filter(|n| slots.of(*n).is_none()).collect();
    let cut: Vec<Op> = ops
        .iter()
        .enumerate()
        .map(|(k, op)| if slots.known(k as Node).is_some() { Op::Input(u32::MAX) } else { *op })
        .collect();
    let needed = needed(&cut, &open);
    // For each node, the largest number of successive function calls on which it depends.
    let mut level = vec![0_usize; ops.len()];
    let mut most = 0;
    for (k, op) in cut.iter().enumerate().filter(|(k, _)| needed[*k]) {
        let before = op.operands().map(|operand| {
            let is_call = matches!(cut[operand as usize], Op::Call(..));
            level[operand as usize] + usize::from(is_call)
        });
        level[k] = before.max().unwrap_or(0);
        most = most.max(level[k] + usize::from(matches!(op, Op::Call(..))));
    }
    // Values that a later level or a call reads need slots.
    let mut crosses = vec![false; ops.len()];
    open.iter().for_each(|node| crosses[*node as usize] = true);
    for (k, op) in cut.iter().enumerate().filter(|(k, _)| needed[*k]) {
        for operand in op.operands() {
            let is_call =
                matches!(op, Op::Call(..)) || matches!(cut[operand as usize], Op::Call(..));
            if is_call || level[operand as usize] < level[k] {
                crosses[operand as usize] = true;
            }
        }
    }
    let with = pairs(&cut, &needed, &level, &crosses, fuse);
    let mut parts = Vec::new();
    for now in 0..=most {
        let (mut code, mut calls) = (Code::default(), Vec::new());
        let mut steps: FxHashMap<Node, u32> = FxHashMap::default();
        let mut constants: FxHashMap<u64, u32> = FxHashMap::default();
        for (k, op) in cut.iter().enumerate().filter(|(k, _)| needed[*k]) {
            let node = k as Node;
            if level[k] != now || slots.of(node).is_some() && !matches!(op, Op::Call(..)) {
                continue;
            }
            if let Some(source @ Source::Common(_)) = slots.known(node) {
                if crosses[k] {
                    code.stores.push((source, slots.made(node)));
                }
                continue;
            }
            if let Op::Call(function, a, b) = *op {
                let arguments = [a, b].map(|node| slots.made(node));
                calls.push(Call { function, arguments, result: slots.made(node) });
                continue;
            }
            let source = |node: Node, code: &mut Code, constants: &mut FxHashMap<u64, u32>| {
                if let Op::Constant(bits) = ops[node as usize] {
                    let place = *constants.entry(bits).or_insert_with(|| {
                        code.constants.push(f64::from_bits(bits));
                        code.constants.len() as u32 - 1
                    });
                    return Source::Constant(place);
                }
                match steps.get(&node) {
                    Some(step) => Source::Step(*step),
                    None => slots.known(node).unwrap_or(Source::Slot(0)),
                }
            };
            let mut of = |node: Node| source(node, &mut code, &mut constants);
            let pair = with[k].map(|other| (other, cut[other as usize]));
            let step = match (*op, pair) {
                // This operation is already part of the step of its partner.
                (Op::Mul(..), Some((_, Op::Add(..) | Op::Sub(..)))) | (Op::Div(..), Some(_)) => {
                    continue;
                }
                (Op::Mul(a, b), Some((over, Op::Div(_, by)))) => {
                    Step::Div(of(if over == a { b } else { a }), of(by))
                }
                (Op::Add(x, y) | Op::Sub(x, y), Some((product, Op::Mul(a, b)))) => {
                    let (kind, c) = match op {
                        Op::Add(..) => (Fused::Add, if product == x { y } else { x }),
                        _ if product == x => (Fused::Sub, y),
                        _ => (Fused::From, x),
                    };
                    Step::Fused(kind, [of(a), of(b), of(c)])
                }
                (Op::Add(a, b), _) => Step::Add(of(a), of(b)),
                (Op::Sub(a, b), _) => Step::Sub(of(a), of(b)),
                (Op::Mul(a, b), _) => Step::Mul(of(a), of(b)),
                (Op::Div(a, b), _) => Step::Div(of(a), of(b)),
                (Op::Neg(a), _) => Step::Neg(of(a)),
                (Op::Sqrt(a), _) => Step::Sqrt(of(a)),
                (Op::Select { of: c, yes, no }, _) => {
                    Step::Select { of: of(c), yes: of(yes), no: of(no) }
                }
                (Op::Constant(_), _) => {
                    if crosses[k] {
                        let from = of(node);
                        let slot = slots.made(node);
                        code.stores.push((from, slot));
                    }
                    continue;
                }
                (Op::Input(_) | Op::Call(..) | Op::Held(_), _) => continue,
            };
            code.steps.push(step);
            let place = code.steps.len() as u32 - 1;
            steps.insert(node, place);
            if crosses[k] {
                code.stores.push((Source::Step(place), u32::MAX - node));
            }
        }
        // Results receive their slots last, because operands refer to them as steps until then.
        for (_, slot) in &mut code.stores {
            if *slot > u32::MAX / 2 {
                *slot = slots.made(u32::MAX - *slot);
            }
        }
        if !code.steps.is_empty() || !code.stores.is_empty() {
            parts.push(Part::Code(code));
        }
        if !calls.is_empty() {
            parts.push(Part::Calls(calls));
        }
    }
    parts
}

impl Code {
    /// Length of the memory shared by all lanes that the code reads: one more than the largest
    /// index of a shared number.
    pub(crate) fn common(&self) -> usize {
        let operands = self.steps.iter().flat_map(|step| step.operands());
        let all = operands.chain(self.stores.iter().map(|(source, _)| *source));
        let places = all.filter_map(|source| match source {
            Source::Common(place) => Some(place as usize + 1),
            _ => None,
        });
        places.max().unwrap_or(0)
    }

    /// Interprets the code for `L` states in parallel lanes. Each slot holds `L` numbers, one for
    /// each lane, and all lanes share the numbers in `common`. `values` is scratch memory for the
    /// results of all steps.
    pub(crate) fn interpret<const L: usize>(
        &self,
        slots: &mut [f64],
        common: &[f64],
        values: &mut [f64],
    ) {
        let (values, _) = values.as_chunks_mut::<L>();
        for (k, step) in self.steps.iter().enumerate() {
            let of = |source: Source| self.read::<L>(source, slots, common, values);
            let (a, b) = match *step {
                Step::Add(a, b) | Step::Sub(a, b) | Step::Mul(a, b) | Step::Div(a, b) => {
                    (of(a), of(b))
                }
                Step::Neg(a) | Step::Sqrt(a) => (of(a), [0.0; L]),
                Step::Select { yes, no, .. } => (of(yes), of(no)),
                Step::Fused(_, [a, b, _]) => (of(a), of(b)),
            };
            let each = |f: fn(f64, f64) -> f64| core::array::from_fn(|l| f(a[l], b[l]));
            values[k] = match *step {
                Step::Add(..) => each(|a, b| a + b),
                Step::Sub(..) => each(|a, b| a - b),
                Step::Mul(..) => each(|a, b| a * b),
                Step::Div(..) => each(|a, b| a / b),
                Step::Neg(_) => each(|a, _| -a),
                Step::Sqrt(_) => each(|a, _| a.sqrt()),
                Step::Fused(kind, [.., c]) => {
                    let c = of(c);
                    core::array::from_fn(|l| kind.of(a[l], b[l], c[l]))
                }
                Step::Select { of: condition, .. } => {
                    let c = of(condition);
                    core::array::from_fn(|l| if c[l] > 0.0 { a[l] } else { b[l] })
                }
            };
        }
        for &(source, slot) in &self.stores {
            let value = self.read::<L>(source, slots, common, values);
            slots[slot as usize * L..][..L].copy_from_slice(&value);
        }
    }

    fn read<const L: usize>(
        &self,
        source: Source,
        slots: &[f64],
        common: &[f64],
        values: &[[f64; L]],
    ) -> [f64; L] {
        match source {
            Source::Common(place) => [common[place as usize]; L],
            Source::Slot(slot) => core::array::from_fn(|l| slots[slot as usize * L + l]),
            Source::Constant(place) => [self.constants[place as usize]; L],
            Source::Step(place) => values[place as usize],
        }
    }
}
