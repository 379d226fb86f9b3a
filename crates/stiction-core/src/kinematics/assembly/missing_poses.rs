//! Poses of bodies that follow from the given data only together with loop closure.

use super::super::bodies::{Bodies, State, write_floating};
use super::super::coordinate::{Coordinate, Target};
use super::super::least_squares::PositionEquations;
use super::super::motion_constraints::MotionConstraints;
use super::super::system::Kinematics;
use super::known_poses::BodyPoses;
use super::reference::{Given, JointCoordinates};
use crate::disjoint_sets::DisjointSets;
use crate::linalg::StaticLu;
use crate::mechanism::JointId;
use crate::random::Random;
use crate::topology::{Link, Role, Topology};
use core::f64::consts::PI;

/// Tolerance of loop closure, in rad or characteristic lengths. It is large because home poses and
/// start coordinates are given with few digits.
const ROUGHLY_CLOSED: f64 = 0.05;
/// Maximum number of initial guesses from which the coordinates of a [`Group`] are searched.
const STARTS: usize = 16;
/// Maximum number of steps of the search from each initial guess.
const STEPS: usize = 60;
/// The loops of groups with more degrees of freedom than this are closed one at a time.
const LARGE: usize = 60;

/// Group of undetermined coordinates that loop closure determines together.
#[derive(Default)]
struct Group {
    /// Spanning-tree nodes with undetermined coordinates.
    nodes: Vec<usize>,
    /// Rows of the position equations that determine the coordinates.
    rows: Vec<usize>,
}

impl Given<'_> {
    /// Computes the poses of bodies with unknown poses by closing their loops with bodies whose
    /// poses are known. The poses of bodies whose loops close become known. If `prescribed` is
    /// false, ignores the prescribed coordinates.
    ///
    /// The spanning tree used here follows [`BodyPoses::paths`], so the result does not depend on
    /// the mechanism's own spanning tree.
    pub(super) fn close_loops(
        &self,
        prescribed: bool,
        joints: &[JointCoordinates],
        bodies: &mut BodyPoses,
    ) {
        if bodies.is_known.iter().all(|is_known| *is_known) {
            return;
        }
        let topology = &Topology::with_paths(self.mechanism, &bodies.paths);
        let mut state = State::new(topology);
        let mut is_open = vec![false; topology.nodes.len()];
        for (open, node) in is_open.iter_mut().zip(&topology.nodes) {
            let q = &mut state.coordinates[node.coordinates.clone()];
            match node.link {
                Link::Floating => write_floating(bodies.poses[node.body], q),
                Link::Joint { joint, .. } => {
                    q.copy_from_slice(&joints[joint].values);
                    *open = !joints[joint].are_given;
                }
            }
        }
        let (coordinates, targets) = self.given_coordinates(prescribed, topology, joints);
        let constraints = MotionConstraints::new(topology, &coordinates, &[]);
        let mut kinematics = Kinematics::new(topology, &constraints, &StaticLu::default());
        let mut is_closed: Vec<bool> = is_open.iter().map(|open| !open).collect();
        let mut is_solved = is_closed.clone();
        let mut random = Random::new(11);
        // Each group moves only the bodies on the paths of its rows.
        kinematics.place(topology, self.parameters, &constraints, &state, &targets);
        for group in groups(topology, &constraints, &is_open) {
            let moves = self.moving_dofs(topology, &coordinates, &group);
            let mut counts = vec![0.0; constraints.row_count()];
            group.rows.iter().for_each(|row| counts[*row] = 1.0);
            let equations =
                PositionEquations::new(topology, self.parameters, &constraints, &targets)
                    .weighted(|row| counts[row])
                    .moving(|dof| moves[dof])
                    .in_part();
            let jump = |random: &mut Random| -> Vec<f64> {
                let size = |dof| match topology.tree_dof_translates(dof) {
                    true => self.parameters.length,
                    false => PI,
                };
                let each = topology.tree_dofs.iter().zip(&moves);
                each.map(|(dof, moves)| if *moves { size(dof) * random.number() } else { 0.0 })
                    .collect()
            };
            // Start first from the present coordinates, then from random coordinates.
            let mut best: Option<(f64, State<f64>)> = None;
            for attempt in 0..STARTS {
                let mut trial = state.clone();
                if attempt > 0 {
                    trial.advance(topology, &jump(&mut random));
                }
                let error = equations.solve(&mut kinematics, &mut trial, 1e-9, STEPS).error;
                if best.as_ref().is_none_or(|(least, _)| error < *least) {
                    best = Some((error, trial));
                }
                if error < ROUGHLY_CLOSED {
                    break;
                }
            }
            let Some((error, found)) = best else { continue };
            state = found;
            for &node in &group.nodes {
                (is_solved[node], is_closed[node]) = (true, error < ROUGHLY_CLOSED);
            }
        }
        let mut placed = Bodies::new(topology);
        placed.place(topology, self.parameters, &state.coordinates);
        for (node, content) in topology.nodes.iter().enumerate() {
            if content.link != Link::Floating {
                let (body, parent) =
                    (content.body, content.parent.map_or(0, |parent| topology.nodes[parent].body));
                bodies.poses[body] = placed.pose[body];
                bodies.is_placed[body] = is_solved[node] && bodies.is_placed[parent];
                bodies.is_known[body] = is_closed[node] && bodies.is_known[parent];
            }
        }
    }

    /// Collects the prescribed coordinates (none if `prescribed` is false) and the start
    /// coordinates of cut joints, with their targets. Cut joints are not in the spanning tree, so
    /// their start coordinates are prescribed as well.
    fn given_coordinates(
        &self,
        prescribed: bool,
        topology: &Topology,
        joints: &[JointCoordinates],
    ) -> (Vec<Coordinate>, Vec<Target<f64>>) {
        let (mut coordinates, mut targets) = match prescribed {
            true => (self.coordinates.to_vec(), self.targets.to_vec()),
            false => (Vec::new(), Vec::new()),
        };
        for cut in &topology.cuts {
            let joint_type = topology.joint_types[cut.joint];
            if !joints[cut.joint].are_given || !joint_type.has_scalar_coordinates() {
                continue;
            }
            for (dof, &value) in joints[cut.joint].values.iter().enumerate() {
                let coordinate = Coordinate::Joint { joint: JointId(cut.joint), dof };
                if !coordinates.contains(&coordinate) {
                    coordinates.push(coordinate);
                    targets.push(Target { value, rate: 0.0, acceleration: 0.0 });
                }
            }
        }
        (coordinates, targets)
    }

    /// Returns a flag for each degree of freedom of the spanning tree: `true` if it belongs to the
    /// group and its coordinate is not given.
    fn moving_dofs(
        &self,
        topology: &Topology,
        coordinates: &[Coordinate],
        group: &Group,
    ) -> Vec<bool> {
        let mut moves = vec![false; topology.dofs()];
        for &node in &group.nodes {
            moves[topology.nodes[node].tree_dofs.clone()].fill(true);
        }
        for coordinate in coordinates {
            if let Coordinate::Joint { joint, dof } = coordinate
                && let Role::Tree { node } = topology.role[joint.0]
            {
                moves[topology.nodes[node].tree_dofs.start + dof] = false;
            }
        }
        moves
    }
}

/// Forms groups of nodes with undetermined coordinates that are connected by common rows of the
/// position equations; each group includes these rows. Divides large groups into parts; the rows of
/// a part connect its nodes only to each other and to nodes of earlier parts.
fn groups(topology: &Topology, constraints: &MotionConstraints, is_open: &[bool]) -> Vec<Group> {
    let open_nodes: Vec<Vec<usize>> = constraints
        .rows
        .iter()
        .map(|row| row.path.iter().map(|(node, _)| *node).filter(|node| is_open[*node]).collect())
        .collect();
    let mut sets = DisjointSets::new(is_open.len());
    for nodes in &open_nodes {
        for pair in nodes.windows(2) {
            sets.unite(pair[0], pair[1]);
        }
    }
    let group_of: Vec<usize> = (0..is_open.len()).map(|node| sets.least(node)).collect();
    let mut dofs = vec![0; is_open.len()];
    for ((node, &group), is_open) in topology.nodes.iter().zip(&group_of).zip(is_open) {
        dofs[group] += if *is_open { node.tree_dofs.len() } else { 0 };
    }
    let is_large: Vec<bool> = dofs.into_iter().map(|dofs| dofs > LARGE).collect();
    // Index of the part of each node, and of each small group.
    let mut part_of = vec![None; is_open.len()];
    let mut whole = vec![None; is_open.len()];
    let mut parts: Vec<Group> = Vec::new();
    for (row, nodes) in open_nodes.iter().enumerate() {
        let Some(&first) = nodes.first() else { continue };
        let group = group_of[first];
        let known = if is_large[group] {
            let each: Option<Vec<usize>> = nodes.iter().map(|node| part_of[*node]).collect();
            each.and_then(|each| each.into_iter().max())
        } else {
            whole[group]
        };
        let part = known.unwrap_or(parts.len());
        if part == parts.len() {
            parts.push(Group::default());
            whole[group] = Some(part);
        }
        parts[part].rows.push(row);
        for &node in nodes {
            if part_of[node].is_none() {
                part_of[node] = Some(part);
                parts[part].nodes.push(node);
            }
        }
    }
    parts
}
