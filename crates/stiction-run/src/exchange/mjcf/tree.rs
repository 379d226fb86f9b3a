//! Which joints make the tree of nested bodies, and how the others close loops.

use super::Unfit;
use std::cmp::Reverse;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Joint, Mechanism};

/// A body of the file: one of ours, or a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Which body.
    pub(super) body: usize,
    /// The body from which it hangs.
    pub(super) parent: usize,
    /// In how many bodies it is nested: the ground is one, but for what is free.
    pub(super) depth: usize,
    /// It hangs from nothing but the world, with the six coordinates of a free joint.
    pub(super) is_free: bool,
    /// The joint by which it hangs.
    pub(super) joint: usize,
    /// Whether it is that joint's predecessor.
    pub(super) reversed: bool,
    /// Whether it is a further part of a body that is there already, to which it is welded.
    pub(super) is_further: bool,
}

/// How a joint outside the tree is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Closing {
    /// Two points coincide.
    Connect,
    /// Two bodies are one.
    Weld,
    /// A part of a body hangs by it, welded to the rest.
    Part,
    /// Not at all: it carries nothing.
    Nothing,
}

/// What hangs from a body: the bodies at the other ends of its joints.
#[derive(Clone, Copy, Debug)]
struct Hanging {
    joint: usize,
    reversed: bool,
    is_further: bool,
}

/// The tree.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// All bodies of the file, parents before children, depth first.
    pub(super) parts: Vec<Part>,
    /// The joints outside the tree.
    pub(super) closings: Vec<(usize, Closing)>,
    /// For each of our bodies how many parts it has.
    pub(super) count: Vec<usize>,
}

impl Tree {
    /// Leaves over balls where that is possible, as these close loops by three equations between
    /// points; then joints that make two bodies one; then the last ones of all others.
    pub(super) fn new(mechanism: &Mechanism) -> Result<Self, Unfit> {
        let joints = mechanism.joints();
        let mut order: Vec<usize> = (0..joints.len()).collect();
        order.sort_by_key(|&index| rank(mechanism, &joints[index]));
        let mut group: Vec<usize> = (0..mechanism.bodies().len()).collect();
        let mut in_tree = vec![false; joints.len()];
        for index in order {
            let joint = &joints[index];
            let (a, b) = (group[joint.predecessor.0], group[joint.successor.0]);
            if a != b {
                in_tree[index] = true;
                group.iter_mut().filter(|group| **group == b).for_each(|group| *group = a);
            }
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
        Ok(Self { parts: depth_first(mechanism, &hanging), closings, count })
    }
}

/// Joints of lower rank are in the tree rather than others.
fn rank(mechanism: &Mechanism, joint: &Joint) -> (usize, Reverse<usize>) {
    let ends = [joint.predecessor, joint.successor].map(|end| has_mass(mechanism, end));
    let rank = match (closing_of(joint.joint_type), ends) {
        // It cannot be left over; or it holds a body without mass, which must not move by itself.
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

fn has_mass(mechanism: &Mechanism, body: BodyId) -> bool {
    mechanism.bodies()[body.0].mass > 0.0
}

/// From the ground, without recursion: chains may be long.
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
            Part { body: body.0, parent, depth, is_free, joint, reversed, is_further }
        };
        hanging[parent].iter().rev().map(part)
    };
    let mut next: Vec<Part> = below(BodyId::GROUND.0, 1).collect();
    // The last in the list is the next: what is nested in the ground comes before what is not.
    next.sort_by_key(|part| !part.is_free);
    while let Some(part) = next.pop() {
        // From the child's side a joint of the tree leads back.
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
