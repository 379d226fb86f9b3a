//! Spanning tree of nested MJCF bodies, and loop closures for the joints outside the tree.

use super::{Unfit, between};
use std::cmp::Reverse;
use stiction_core::disjoint_sets::DisjointSets;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Joint, Mechanism};

/// MJCF body: a body of the mechanism, or one part of a split body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Index of the body in the mechanism.
    pub(super) body: usize,
    /// Index, in the mechanism, of the nearest body towards the ground that is an MJCF body.
    pub(super) parent: usize,
    /// Nesting depth: number of enclosing bodies including the ground. It is zero for a body with a
    /// free joint.
    pub(super) depth: usize,
    /// True for a body connected to the world by a free joint, with six coordinates.
    pub(super) is_free: bool,
    /// Index of the joint that connects this MJCF body to its parent.
    pub(super) joint: usize,
    /// True if the body is the predecessor of `joint`, so that the joint is reversed.
    pub(super) reversed: bool,
    /// True for each part of a split body except the first part, to which all others are welded.
    pub(super) is_further: bool,
    /// True for a massless body between two joints, which is no MJCF body: its joint is one of several joints of the MJCF
    /// body that it carries.
    pub(super) is_between: bool,
    /// Indices of the parts between the parent and this MJCF body, whose joints this body has before its own.
    pub(super) before: Vec<usize>,
}

/// MJCF element that replaces a joint outside the spanning tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Closing {
    /// Makes two points of different bodies coincide.
    Connect,
    /// Welds two bodies.
    Weld,
    /// Splits a body. The joint carries the new part, which is welded to the first part of the
    /// body.
    Part,
    /// No element, because the joint transmits no force.
    Nothing,
}

/// Neighbour of a body, reached through one of its joints.
#[derive(Clone, Copy, Debug)]
struct Hanging {
    joint: usize,
    reversed: bool,
    is_further: bool,
}

/// Spanning tree of the mechanism, and loop closures for the joints outside the tree.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// All MJCF bodies, parents before children, depth first.
    pub(super) parts: Vec<Part>,
    /// Joints outside the spanning tree, each with the element that replaces it.
    pub(super) closings: Vec<(usize, Closing)>,
    /// Number of MJCF bodies that represent each body of the mechanism.
    pub(super) count: Vec<usize>,
}

impl Tree {
    /// Chooses the spanning tree and the loop closures. Loops are preferably closed at spherical
    /// joints, where three equations between points suffice, then at fixed joints, and otherwise at
    /// joints of other types.
    pub(super) fn new(mechanism: &Mechanism) -> Result<Self, Unfit> {
        let joints = mechanism.joints();
        let mut order: Vec<usize> = (0..joints.len()).collect();
        // Geared joints enter the tree first, because the file expresses a gearing as an equation
        // between MJCF joints.
        let geared = mechanism.gearings().iter().flat_map(|gearing| &gearing.dofs);
        let geared: Vec<usize> = geared.map(|dof| dof.joint.0).collect();
        order.sort_by_key(|&index| (!geared.contains(&index), rank(mechanism, &joints[index])));
        let mut trees = DisjointSets::new(mechanism.bodies().len());
        let mut in_tree = vec![false; joints.len()];
        for index in order {
            let joint = &joints[index];
            in_tree[index] = trees.unite(joint.predecessor.0, joint.successor.0);
        }
        let mut count = vec![1; mechanism.bodies().len()];
        let mut closings = Vec::new();
        let mut hanging: Vec<Vec<Hanging>> = vec![Vec::new(); count.len()];
        for (index, joint) in joints.iter().enumerate() {
            let (from, to) = (joint.predecessor.0, joint.successor.0);
            if in_tree[index] {
                let hang = |reversed| Hanging { joint: index, reversed, is_further: false };
                hanging[from].push(hang(false));
                hanging[to].push(hang(true));
                continue;
            }
            let closing = closing_of(joint.joint_type);
            closings.push((index, closing));
            if closing == Closing::Part {
                let reversed = !has_mass(mechanism, joint.successor);
                let (above, below) = if reversed { (to, from) } else { (from, to) };
                if !has_mass(mechanism, BodyId(below)) {
                    return Err(Unfit::CannotClose { joint: joint.name.clone() });
                }
                count[below] += 1;
                hanging[above].push(Hanging { joint: index, reversed, is_further: true });
            }
        }
        let mut parts = depth_first(mechanism, &hanging);
        between::mark(mechanism, &closings, &mut parts);
        Ok(Self { parts, closings, count })
    }
}

/// Returns the rank of a joint; joints of lower rank enter the spanning tree first.
fn rank(mechanism: &Mechanism, joint: &Joint) -> (usize, Reverse<usize>) {
    let ends = [joint.predecessor, joint.successor].map(|end| has_mass(mechanism, end));
    let rank = match (closing_of(joint.joint_type), ends) {
        // The joint cannot close a loop, or it connects a body without mass, which must not move
        // freely.
        (Closing::Part, [false, false]) | (Closing::Weld, [false, _] | [_, false]) => 0,
        (Closing::Part, _) => 1,
        (Closing::Weld, _) => 2,
        (Closing::Connect, _) => 3,
        (Closing::Nothing, _) => 4,
    };
    (rank, Reverse(joint.actuated_dofs().count()))
}

fn closing_of(joint_type: JointType) -> Closing {
    match joint_type {
        JointType::Spherical => Closing::Connect,
        JointType::Fixed => Closing::Weld,
        JointType::Free => Closing::Nothing,
        _ => Closing::Part,
    }
}

pub(super) fn has_mass(mechanism: &Mechanism, body: BodyId) -> bool {
    mechanism.bodies()[body.0].mass > 0.0
}

/// Lists the MJCF bodies depth first from the ground. The function does not recurse, because chains
/// of bodies may be long.
fn depth_first(mechanism: &Mechanism, hanging: &[Vec<Hanging>]) -> Vec<Part> {
    let joints = mechanism.joints();
    let mut parts = Vec::new();
    let mut placed = vec![false; hanging.len()];
    placed[BodyId::GROUND.0] = true;
    let below = |parent: usize, depth: usize| {
        let is_ground = parent == BodyId::GROUND.0;
        let part = move |&Hanging { joint, reversed, is_further }: &Hanging| {
            let content = &joints[joint];
            let body = if reversed { content.predecessor } else { content.successor };
            let is_free = is_ground && content.joint_type == JointType::Free;
            let depth = if is_free { 0 } else { depth };
            let (is_between, before) = (false, Vec::new());
            Part {
                body: body.0,
                parent,
                depth,
                is_free,
                joint,
                reversed,
                is_further,
                is_between,
                before,
            }
        };
        hanging[parent].iter().rev().map(part)
    };
    let mut next: Vec<Part> = below(BodyId::GROUND.0, 1).collect();
    // The last entry is processed next, so bodies nested in the ground precede free bodies.
    next.sort_by_key(|part| !part.is_free);
    while let Some(part) = next.pop() {
        // The joint that connects a body to its parent also appears at the body itself, where it
        // leads back to the parent.
        if !part.is_further && std::mem::replace(&mut placed[part.body], true) {
            continue;
        }
        if !part.is_further {
            next.extend(below(part.body, part.depth + 1));
        }
        parts.push(part);
    }
    parts
}
