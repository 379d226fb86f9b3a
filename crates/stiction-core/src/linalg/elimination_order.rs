//! Elimination order of sparse symmetric matrices, chosen from their nonzero pattern.

use std::collections::BTreeSet;

/// Minimum-degree order (Tinney and Walker 1967). At each step, the node with the fewest neighbours
/// is eliminated, and its neighbours become neighbours of each other.
#[derive(Clone, Debug)]
pub(crate) struct EliminationOrder {
    /// Nodes in the order of their elimination.
    pub(crate) nodes: Vec<usize>,
    /// Neighbours that each node of `nodes` has at its elimination, in ascending order of index.
    pub(crate) neighbours: Vec<Vec<usize>>,
}

impl EliminationOrder {
    /// Orders the nodes `0..count`. `pairs` contains the pairs of neighbours, in any order and
    /// possibly repeated.
    pub(crate) fn new(count: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut neighbours = vec![BTreeSet::new(); count];
        for (a, b) in pairs.filter(|(a, b)| a != b) {
            neighbours[a].insert(b);
            neighbours[b].insert(a);
        }
        let mut queue: BTreeSet<(usize, usize)> =
            (0..count).map(|node| (neighbours[node].len(), node)).collect();
        let mut order =
            Self { nodes: Vec::with_capacity(count), neighbours: Vec::with_capacity(count) };
        while let Some((degree, node)) = queue.pop_first() {
            if degree == queue.len() {
                // All remaining nodes are neighbours of each other, so their order does not matter.
                let mut rest: Vec<usize> = queue.iter().map(|(_, node)| *node).collect();
                rest.sort_unstable();
                order.nodes.push(node);
                order.nodes.extend(&rest);
                order.neighbours.extend((0..=rest.len()).map(|k| rest[k..].to_vec()));
                break;
            }
            let around = core::mem::take(&mut neighbours[node]);
            for &a in &around {
                queue.remove(&(neighbours[a].len(), a));
                neighbours[a].remove(&node);
                neighbours[a].extend(around.iter().copied().filter(|b| *b != a));
                queue.insert((neighbours[a].len(), a));
            }
            order.nodes.push(node);
            order.neighbours.push(around.into_iter().collect());
        }
        order
    }
}
