//! Values that stages of a program pass to later stages, and guards that test the assumptions made
//! at recording.

use crate::graph::{Graph, Node, Op, needed};
use crate::value_numbering::Guard;
use rustc_hash::FxHashSet;

/// Returns the nodes that the results `later` of later stages need, and that do not depend on
/// inputs for which `late` is true. An earlier stage can therefore compute these nodes before the
/// late inputs are known. Constants are excluded.
pub(crate) fn early(ops: &[Op], later: &[Node], late: impl Fn(usize) -> bool) -> Vec<Node> {
    let depends = dependent(ops, late);
    let needed = needed(ops, later);
    let is_early =
        |node: &Node| !depends[*node as usize] && !matches!(ops[*node as usize], Op::Constant(_));
    let mut nodes: Vec<Node> = later.iter().copied().filter(is_early).collect();
    for (k, op) in ops.iter().enumerate() {
        if needed[k] && depends[k] {
            nodes.extend(op.operands().filter(is_early));
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Returns the nodes that a stage computes for its results `now`, that the results `later` of later
/// stages need, and that depend on inputs for which `late` is true.
pub(crate) fn passed_on(
    ops: &[Op],
    now: &[Node],
    later: &[Node],
    late: impl Fn(usize) -> bool,
) -> Vec<Node> {
    let depends = dependent(ops, late);
    let (by_now, by_later) = (needed(ops, now), needed(ops, later));
    let is_found = |node: &Node| by_now[*node as usize] && depends[*node as usize];
    let mut nodes: Vec<Node> = later.iter().copied().filter(is_found).collect();
    for (_, op) in ops.iter().enumerate().filter(|(k, _)| by_later[*k] && !by_now[*k]) {
        nodes.extend(op.operands().filter(is_found));
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Marks the nodes that depend on inputs for which `late` is true.
fn dependent(ops: &[Op], late: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut depends = vec![false; ops.len()];
    for (k, op) in ops.iter().enumerate() {
        depends[k] = match op {
            Op::Input(place) => late(*place as usize),
            _ => op.operands().any(|operand| depends[operand as usize]),
        };
    }
    depends
}

/// Adds a guard node to `merged`. The node is positive if the results `stage` of the original graph
/// `of` equal those of the merged graph, because all conditions in `guards` on which these results
/// depend are satisfied.
pub(crate) fn holds(of: &Graph, stage: &[Node], guards: &[Guard], merged: &mut Graph) -> Node {
    let needed = needed(of.ops(), stage);
    let mut holds = merged.number(1.0);
    let none = merged.number(0.0);
    let mut known = FxHashSet::default();
    for guard in guards.iter().filter(|guard| needed[guard.selection as usize]) {
        // A square root is positive where its argument is positive.
        let condition = match merged.ops()[guard.condition as usize] {
            Op::Sqrt(square) => square,
            _ => guard.condition,
        };
        if known.insert((condition, guard.is_positive)) {
            let [yes, no] = if guard.is_positive { [holds, none] } else { [none, holds] };
            holds = merged.add(Op::Select { of: condition, yes, no });
        }
    }
    holds
}

/// Replaces the inputs with index `first` and higher by the nodes `by`. These nodes may depend on
/// replaced inputs, but not on themselves. Returns the new graph, and the new node of each old node.
///
/// # Panics
/// If one of the nodes `by` depends on the input that it replaces.
pub(crate) fn with_inputs_replaced(graph: &Graph, first: usize, by: &[Node]) -> (Graph, Vec<Node>) {
    let ops = graph.ops();
    let replaced = |op: &Op| match op {
        Op::Input(place) => (*place as usize).checked_sub(first).map(|place| by[place]),
        _ => None,
    };
    let mut depends = vec![false; ops.len()];
    for (k, op) in ops.iter().enumerate() {
        depends[k] =
            replaced(op).is_some() || op.operands().any(|operand| depends[operand as usize]);
    }
    let mut new = Graph::default();
    let mut new_of: Vec<Option<Node>> = vec![None; ops.len()];
    // Nodes that do not depend on the inputs keep their places before all others.
    let all = 0..ops.len();
    let roots = all.clone().filter(|k| !depends[*k]).chain(all.filter(|k| depends[*k]));
    let mut open = Vec::new();
    for root in roots {
        open.push(root);
        while let Some(&node) = open.last() {
            let op = ops[node];
            let before = replaced(&op).into_iter().chain(op.operands());
            let missing = before.filter(|other| new_of[*other as usize].is_none());
            let count = open.len();
            // Each node on the path adds at most its operands.
            assert!(count <= 4 * ops.len() + 1, "inputs are replaced by nodes that depend on them");
            open.extend(missing.map(|other| other as usize));
            if open.len() > count {
                continue;
            }
            open.pop();
            let of = |other: Node| made_before(new_of[other as usize]);
            let made = replaced(&op).map_or_else(|| new.add(op.map(of)), of);
            new_of[node] = Some(made);
        }
    }
    (new, new_of.into_iter().map(made_before).collect())
}

/// The new node of an old node.
///
/// # Panics
/// If it has not been made, which would lead to another program.
fn made_before(node: Option<Node>) -> Node {
    assert!(node.is_some(), "a node precedes those on which it depends");
    node.unwrap_or_default()
}
