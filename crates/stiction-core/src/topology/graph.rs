//! Spanning trees of the graph of bodies and joints.

use crate::disjoint_sets::DisjointSets;
use crate::random::Random;
use std::collections::VecDeque;

/// Spanning tree of the bodies. The ground and each floating body are roots of separate parts.
#[derive(Debug)]
pub(super) struct Spanning {
    /// All bodies except the ground, parents before children.
    pub(super) order: Vec<Placement>,
}

/// A body, and the joint that connects the body with its parent in the tree; `None` for a floating
/// body.
#[derive(Debug)]
pub(super) struct Placement {
    pub(super) body: usize,
    pub(super) joint: Option<usize>,
}

const GROUND: usize = 0;

impl Spanning {
    /// Builds the tree described in [`super`]: hubs (bodies at which at least three chains meet)
    /// float, and each chain between hubs is cut at the joint with the lowest `cost`. Joints with
    /// `keep` are never cut; they must form no loop. `holds` decides whether a chain from a root to
    /// a hub holds the hub, which then does not float. Its arguments are the joints of the chain
    /// and the number of chains at the hub. At most one chain holds a hub.
    pub(super) fn by_structure(
        bodies: usize,
        ends: &[(usize, usize)],
        (cost, keep): (&[usize], &[bool]),
        holds: impl Fn(&[usize], usize) -> bool,
    ) -> Self {
        let graph = Graph::new(bodies, ends);
        let distance = graph.distances();
        let bridge = graph.bridges();
        let component = graph.components(&bridge);

        // The root of a component is its body closest to the ground.
        let mut root = vec![usize::MAX; bodies];
        let mut nearest_first: Vec<usize> = (0..bodies).collect();
        nearest_first.sort_by_key(|&body| distance[body]);
        for &body in &nearest_first {
            let root = &mut root[component[body]];
            if *root == usize::MAX {
                *root = body;
            }
        }
        let is_root = |body: usize| root[component[body]] == body;
        let loop_joints =
            |body: usize| graph.incident[body].iter().copied().filter(|&j| !bridge[j]);
        let is_hub = |body: usize| !is_root(body) && loop_joints(body).count() >= 3;

        let mut is_cut = vec![false; ends.len()];
        let mut is_held = vec![false; bodies];
        let mut walked = vec![false; ends.len()];
        for start in nearest_first.iter().copied().filter(|&b| is_root(b) || is_hub(b)) {
            for first in loop_joints(start).collect::<Vec<_>>() {
                if walked[first] {
                    continue;
                }
                // Follow the chain of joints to the next root or hub.
                let (mut chain, mut body, mut joint) = (Vec::new(), start, first);
                loop {
                    walked[joint] = true;
                    chain.push(joint);
                    body = graph.other_end(joint, body);
                    if is_root(body) || is_hub(body) {
                        break;
                    }
                    // A body inside a chain has exactly one joint that belongs to a loop and is not
                    // yet part of the chain.
                    match loop_joints(body).find(|&next| !walked[next]) {
                        Some(next) => joint = next,
                        None => break,
                    }
                }
                let reaches_hub = is_root(start) && is_hub(body);
                if reaches_hub && !is_held[body] && holds(&chain, loop_joints(body).count()) {
                    is_held[body] = true;
                    continue;
                }
                // Prefer to cut a chain from a root to a hub at the hub, and other chains in the
                // middle.
                let preferred =
                    if reaches_hub { chain.len() as f64 } else { 0.5 * (chain.len() - 1) as f64 };
                let free = chain.iter().enumerate().filter(|(_, joint)| !keep[**joint]);
                let best = free.min_by(|(i, a), (k, b)| {
                    let off = |i: &usize| (*i as f64 - preferred).abs();
                    cost[**a].cmp(&cost[**b]).then(off(i).total_cmp(&off(k)))
                });
                if let Some((_, &joint)) = best {
                    is_cut[joint] = true;
                }
            }
        }
        let mut floating = nearest_first.iter().copied().filter(|&b| is_hub(b)).collect::<Vec<_>>();
        // If a chain is not cut, the hub at its end does not float but becomes a descendant of this
        // chain.
        if keep.contains(&true) || is_held.contains(&true) {
            let part = graph.components(&is_cut);
            let mut held = vec![part[GROUND]];
            floating.retain(|&hub| {
                let first = !held.contains(&part[hub]);
                held.push(part[hub]);
                first
            });
        }
        Self::grow(&graph, &floating, |joint| !is_cut[joint])
    }

    /// Builds a random tree with random floating bodies. The tree contains all joints with `keep`,
    /// which must form no loop.
    pub(super) fn random(bodies: usize, ends: &[(usize, usize)], keep: &[bool], seed: u64) -> Self {
        let mut random = Random::new(seed);
        let graph = Graph::new(bodies, ends);
        let is_geared = |body: &usize| graph.incident[*body].iter().any(|&joint| keep[joint]);
        let floating: Vec<usize> =
            (1..bodies).filter(|body| random.number() < -0.5 && !is_geared(body)).collect();
        // Kruskal's algorithm over joints in random order; floating bodies already belong to the
        // ground's tree.
        let mut trees = DisjointSets::new(bodies);
        for &body in &floating {
            trees.unite(body, GROUND);
        }
        let mut joints: Vec<usize> = (0..ends.len()).collect();
        let places: Vec<f64> = joints.iter().map(|_| random.number()).collect();
        joints.sort_by(|a, b| keep[*b].cmp(&keep[*a]).then(places[*a].total_cmp(&places[*b])));
        let mut in_tree = vec![false; ends.len()];
        for joint in joints {
            let (a, b) = ends[joint];
            in_tree[joint] = trees.unite(a, b);
        }
        Self::grow(&graph, &floating, |joint| in_tree[joint])
    }

    /// Orders the bodies outwards from the ground and the floating bodies, along the joints for
    /// which `allowed` returns `true`.
    fn grow(graph: &Graph, floating: &[usize], allowed: impl Fn(usize) -> bool) -> Self {
        let mut placed = vec![false; graph.incident.len()];
        placed[GROUND] = true;
        let mut order = Vec::new();
        for &body in floating {
            placed[body] = true;
            order.push(Placement { body, joint: None });
        }
        let mut queue: VecDeque<usize> = floating.iter().copied().chain([GROUND]).collect();
        while let Some(body) = queue.pop_front() {
            for &joint in graph.incident[body].iter().filter(|&&joint| allowed(joint)) {
                let next = graph.other_end(joint, body);
                if !placed[next] {
                    placed[next] = true;
                    order.push(Placement { body: next, joint: Some(joint) });
                    queue.push_back(next);
                }
            }
        }
        Self { order }
    }
}

/// Graph of bodies and the joints between them.
struct Graph<'a> {
    ends: &'a [(usize, usize)],
    /// Indices of the joints attached to each body.
    incident: Vec<Vec<usize>>,
}

impl<'a> Graph<'a> {
    fn new(bodies: usize, ends: &'a [(usize, usize)]) -> Self {
        let mut incident = vec![Vec::new(); bodies];
        for (joint, &(a, b)) in ends.iter().enumerate() {
            incident[a].push(joint);
            incident[b].push(joint);
        }
        Self { ends, incident }
    }

    fn other_end(&self, joint: usize, body: usize) -> usize {
        let (a, b) = self.ends[joint];
        if a == body { b } else { a }
    }

    /// Computes the number of joints on the shortest path from each body to the ground;
    /// `usize::MAX` for a body without a path to the ground.
    fn distances(&self) -> Vec<usize> {
        let mut distance = vec![usize::MAX; self.incident.len()];
        distance[GROUND] = 0;
        let mut queue = VecDeque::from([GROUND]);
        while let Some(body) = queue.pop_front() {
            for &joint in &self.incident[body] {
                let next = self.other_end(joint, body);
                if distance[next] == usize::MAX {
                    distance[next] = distance[body] + 1;
                    queue.push_back(next);
                }
            }
        }
        distance
    }

    /// Returns, for each joint, `true` if the joint belongs to no loop, by Tarjan's low-link
    /// method. The search is not recursive, so that long chains do not overflow the call stack.
    fn bridges(&self) -> Vec<bool> {
        let bodies = self.incident.len();
        let mut bridge = vec![false; self.ends.len()];
        let mut entered = vec![0; bodies];
        let mut low = vec![0; bodies];
        let mut clock = 0;
        for start in 0..bodies {
            if entered[start] != 0 {
                continue;
            }
            clock += 1;
            (entered[start], low[start]) = (clock, clock);
            // Each entry: a body, the joint by which the search reached the body, and the position
            // of its next joint in `incident`.
            let mut stack = vec![(start, usize::MAX, 0)];
            while let Some((body, from, at)) = stack.last_mut() {
                let (body, from) = (*body, *from);
                if let Some(&joint) = self.incident[body].get(*at) {
                    *at += 1;
                    if joint == from {
                        continue;
                    }
                    let next = self.other_end(joint, body);
                    if entered[next] == 0 {
                        clock += 1;
                        (entered[next], low[next]) = (clock, clock);
                        stack.push((next, joint, 0));
                    } else {
                        low[body] = low[body].min(entered[next]);
                    }
                } else {
                    stack.pop();
                    if let Some(&(parent, ..)) = stack.last() {
                        low[parent] = low[parent].min(low[body]);
                        bridge[from] = low[body] > entered[parent];
                    }
                }
            }
        }
        bridge
    }

    /// Computes the connected components that remain without the joints marked in `bridge`.
    /// Returns, for each body, the smallest index of a body in the same component.
    fn components(&self, bridge: &[bool]) -> Vec<usize> {
        let mut component = vec![usize::MAX; self.incident.len()];
        for start in 0..component.len() {
            if component[start] != usize::MAX {
                continue;
            }
            component[start] = start;
            let mut stack = vec![start];
            while let Some(body) = stack.pop() {
                for &joint in self.incident[body].iter().filter(|&&joint| !bridge[joint]) {
                    let next = self.other_end(joint, body);
                    if component[next] == usize::MAX {
                        component[next] = start;
                        stack.push(next);
                    }
                }
            }
        }
        component
    }
}
