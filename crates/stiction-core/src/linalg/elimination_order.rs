//! Elimination order of sparse symmetric matrices, chosen from their nonzero pattern.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
        // Sets of neighbours as ascending lists: most are short.
        let mut neighbours = vec![Vec::new(); count];
        for (a, b) in pairs.filter(|(a, b)| a != b) {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
        for own in &mut neighbours {
            own.sort_unstable();
            own.dedup();
        }
        // The queue also has outdated entries: those of eliminated nodes and of earlier degrees.
        let mut is_left = vec![true; count];
        let mut queue: BinaryHeap<Reverse<(usize, usize)>> =
            (0..count).map(|node| Reverse((neighbours[node].len(), node))).collect();
        let mut order =
            Self { nodes: Vec::with_capacity(count), neighbours: Vec::with_capacity(count) };
        while let Some(Reverse((degree, node))) = queue.pop() {
            if !is_left[node] || degree != neighbours[node].len() {
                continue;
            }
            is_left[node] = false;
            let around = core::mem::take(&mut neighbours[node]);
            order.nodes.push(node);
            if order.nodes.len() + degree == count {
                // All remaining nodes are neighbours of each other, so their order does not matter.
                order.nodes.extend(&around);
                order.neighbours.extend((0..=degree).map(|k| around[k..].to_vec()));
                break;
            }
            for &a in &around {
                let own = &mut neighbours[a];
                let before = own.len();
                if let Ok(place) = own.binary_search(&node) {
                    own.remove(place);
                }
                for &b in around.iter().filter(|b| **b != a) {
                    if let Err(place) = own.binary_search(&b) {
                        own.insert(place, b);
                    }
                }
                if own.len() != before {
                    queue.push(Reverse((own.len(), a)));
                }
            }
            order.neighbours.push(around);
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::EliminationOrder;
    use crate::random::Random;
    use std::collections::BTreeSet;

    /// Each step eliminates a node with the fewest neighbours, the first of these, and its
    /// neighbours become neighbours of each other. Only the end, where all nodes are neighbours of
    /// each other, has another order.
    #[test]
    fn each_step_eliminates_a_node_with_the_fewest_neighbours() {
        let mut random = Random::new(3);
        for count in [1, 2, 7, 30, 60] {
            for density in [0.5, 1.5, 4.0] {
                let pairs: Vec<(usize, usize)> = (0..(density * count as f64) as usize)
                    .map(|_| {
                        let mut node = || (0.5 * (random.number() + 1.0) * count as f64) as usize;
                        (node(), node())
                    })
                    .collect();
                let order = EliminationOrder::new(count, pairs.iter().copied());
                let mut around = vec![BTreeSet::new(); count];
                for (a, b) in pairs.into_iter().filter(|(a, b)| a != b) {
                    around[a].insert(b);
                    around[b].insert(a);
                }
                let mut left: BTreeSet<usize> = (0..count).collect();
                for (step, &node) in order.nodes.iter().enumerate() {
                    let expected = left.iter().min_by_key(|own| (around[**own].len(), **own));
                    let is_clique = left.iter().all(|own| around[*own].len() + 1 == left.len());
                    assert!(is_clique || expected == Some(&node), "{count} {step}");
                    let own = core::mem::take(&mut around[node]);
                    assert!(order.neighbours[step].iter().eq(&own), "{count} {step}");
                    left.remove(&node);
                    for &a in &own {
                        around[a].remove(&node);
                        around[a].extend(own.iter().filter(|b| **b != a));
                    }
                }
                assert!(left.is_empty() && order.nodes.len() == count);
            }
        }
    }
}
