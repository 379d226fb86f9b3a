//! Reference configuration of a model: `home` poses of bodies, `start` coordinates of joints, and
//! the prescribed coordinates.
//!
//! Prescribed coordinates take precedence over starts, starts over homes. A missing start follows
//! from homes, from neighbours and from prescribed poses.

use super::super::bodies::{Bodies, State, write_floating};
use super::super::coordinate::{Coordinate, Target};
use super::super::least_squares::PositionEquations;
use super::super::measure::intrinsic_angles;
use super::super::motion_constraints::MotionConstraints;
use super::super::rotation_vector::RotationVector;
use super::super::system::Kinematics;
use super::report::Conflict;
use crate::joint::Motion;
use crate::linalg::StaticLu;
use crate::mechanism::{BodyId, JointId, Mechanism};
use crate::parameters::Parameters;
use crate::random::Random;
use crate::spatial::{Mat3, Pose, Vec3};
use crate::topology::{Cut, Link, Role, Topology};
use core::cmp::Reverse;
use core::f64::consts::{PI, TAU};
use std::collections::BinaryHeap;

/// Path costs for the choice of a body's pose: across a joint with given coordinates, by the body's
/// home, and across a joint without any information.
const ACROSS: u64 = 1;
const HOME: u64 = 1 << 20;
const UNKNOWN: u64 = 1 << 40;
/// Differences between given quantities beyond this are conflicts, rad or characteristic lengths.
const CONFLICT: f64 = 1.0;
/// Closure tolerance of loops while missing coordinates are completed, rad or characteristic
/// lengths: homes and starts have few digits.
const ROUGHLY_CLOSED: f64 = 0.05;
/// Number of starts of the search for missing coordinates of a chain, and of steps per start.
const FILL_STARTS: usize = 16;
const FILL_STEPS: usize = 60;

/// Given data of the configuration.
#[derive(Clone, Copy)]
pub(in crate::kinematics) struct Given<'a> {
    pub(in crate::kinematics) mechanism: &'a Mechanism,
    pub(in crate::kinematics) topology: &'a Topology,
    pub(in crate::kinematics) parameters: &'a Parameters<f64>,
    /// Poses of bodies in the ground's frame.
    pub(in crate::kinematics) homes: &'a [(BodyId, Pose<f64>)],
    /// Prescribed coordinates, and one target for each.
    pub(in crate::kinematics) coordinates: &'a [Coordinate],
    pub(in crate::kinematics) targets: &'a [Target<f64>],
}

/// Reference configuration. Its loops are open to the accuracy of the given numbers.
#[derive(Clone, Debug)]
pub(in crate::kinematics) struct Reference {
    /// Coordinates of the tree.
    pub(in crate::kinematics) state: State<f64>,
    /// Pose of each body relative to the reference point; `None` if the given data do not determine
    /// it.
    poses: Vec<Option<Pose<f64>>>,
    /// Contradictions among homes, starts and prescribed coordinates.
    pub(super) conflicts: Vec<Conflict>,
}

/// The prescribed coordinates of one body.
#[derive(Clone, Default)]
struct PrescribedPose {
    position: [Option<f64>; 3],
    angles: Vec<(crate::kinematics::AngleOrder, usize, f64)>,
    rotation_vector: [Option<f64>; 3],
}

impl PrescribedPose {
    fn is_whole(&self) -> bool {
        let turned = self.rotation_vector.iter().all(Option::is_some)
            || (0..3).all(|index| {
                self.angles.iter().any(|(order, k, _)| *order == self.angles[0].0 && *k == index)
            });
        turned && self.position.iter().all(Option::is_some)
    }

    /// The pose in the ground's frame with the prescribed components inserted.
    fn applied_to(&self, pose: Pose<f64>) -> Pose<f64> {
        let mut position = pose.position.to_array();
        for (x, prescribed) in position.iter_mut().zip(self.position) {
            *x = prescribed.unwrap_or(*x);
        }
        let mut rotation = pose.rotation;
        if let Some((order, ..)) = self.angles.first().copied() {
            let mut angles = intrinsic_angles(rotation, order);
            for (_, index, value) in self.angles.iter().filter(|(other, ..)| *other == order) {
                angles[*index] = *value;
            }
            let turn = |k: usize| Mat3::about_axis(order.axes()[k], angles[k].sin_cos());
            rotation = turn(0) * turn(1) * turn(2);
        }
        if self.rotation_vector.iter().any(Option::is_some) {
            let mut vector = RotationVector::of(rotation).value.to_array();
            for (x, prescribed) in vector.iter_mut().zip(self.rotation_vector) {
                *x = prescribed.unwrap_or(*x);
            }
            let vector = Vec3::from(vector);
            if vector.norm() > 0.0 {
                rotation = Mat3::rotation(vector, vector.norm());
            }
        }
        Pose { position: Vec3::from(position), rotation }
    }
}

/// The coordinates of one joint.
struct JointCoordinates {
    values: Vec<f64>,
    /// True if every coordinate is prescribed or has a start.
    are_given: bool,
}

impl<'a> Given<'a> {
    /// Builds the reference configuration. If `prescribed` is false, prescribed coordinates are
    /// used only where neither starts nor homes give a value.
    pub(in crate::kinematics) fn reference(&self, prescribed: bool) -> Reference {
        let mut conflicts = Vec::new();
        let joints = self.joint_coordinates(prescribed, &mut conflicts);
        let (poses, costs) = self.body_poses(prescribed, &joints, &mut conflicts);
        let is_known = |body: usize| costs[body] < UNKNOWN;
        let mut state = State::new(self.topology);
        let mut is_open = vec![false; self.topology.nodes.len()];
        for (open, node) in is_open.iter_mut().zip(&self.topology.nodes) {
            let q = &mut state.coordinates[node.coordinates.clone()];
            match node.link {
                Link::Joint { joint, .. } => {
                    q.copy_from_slice(&joints[joint].values);
                    let (predecessor, successor) = self.topology.ends[joint];
                    if joints[joint].are_given {
                        continue;
                    }
                    if !is_known(predecessor) || !is_known(successor) {
                        *open = true;
                        continue;
                    }
                    let j = poses[predecessor] * self.parameters.frame_j[joint];
                    let k = poses[successor] * self.parameters.frame_k[joint];
                    let joint_type = self.topology.joint_types[joint];
                    let pitch = self.parameters.pitch[joint];
                    joint_type.write_coordinates(j.inverse() * k, pitch, q);
                    if joint_type.has_scalar_coordinates() {
                        for (q, value) in q.iter_mut().zip(self.prescribed_values(joint)) {
                            *q = value.filter(|_| prescribed).unwrap_or(*q);
                        }
                    }
                }
                Link::Floating => {
                    write_floating(poses[node.body], q);
                    *open = !is_known(node.body);
                }
            }
        }
        let filled = self.fill(&joints, &mut state, &mut is_open);
        let mut bodies = Bodies::new(self.topology);
        bodies.place(self.topology, self.parameters, &state.coordinates);
        let mut known: Vec<Option<Pose<f64>>> =
            (0..poses.len()).map(|body| is_known(body).then_some(poses[body])).collect();
        for (node, content) in self.topology.nodes.iter().enumerate() {
            // A body connected to a known one by known coordinates is known, too.
            let parent = content.parent.map_or(0, |parent| self.topology.nodes[parent].body);
            let hangs = matches!(content.link, Link::Joint { .. }) && known[parent].is_some();
            let follows = filled[node] || (!is_open[node] && hangs);
            if known[content.body].is_none() && follows {
                known[content.body] = Some(bodies.pose[content.body]);
            }
        }
        Reference { state, poses: known, conflicts }
    }

    /// The prescribed value of each scalar coordinate of a joint.
    fn prescribed_values(&self, joint: usize) -> Vec<Option<f64>> {
        let mut values = vec![None; self.topology.joint_types[joint].dofs().len()];
        for (coordinate, target) in self.coordinates.iter().zip(self.targets) {
            if let Coordinate::Joint { joint: id, dof } = coordinate
                && id.0 == joint
            {
                values[*dof] = Some(target.value);
            }
        }
        values
    }

    /// Coordinates of all joints: prescribed values, else starts, else zero. Starts of angles are
    /// shifted by whole turns to the nearest prescribed value.
    fn joint_coordinates(
        &self,
        prescribed: bool,
        conflicts: &mut Vec<Conflict>,
    ) -> Vec<JointCoordinates> {
        let length = self.parameters.length;
        let mut targets = vec![Vec::new(); self.mechanism.joints().len()];
        for (coordinate, target) in self.coordinates.iter().zip(self.targets) {
            if let Coordinate::Joint { joint, dof } = coordinate {
                targets[joint.0].push((*dof, target.value));
            }
        }
        let each = self.mechanism.joints().iter().zip(targets);
        each.map(|(joint, targets)| {
            let mut values = joint.start_or_zero();
            let dofs = joint.joint_type.dofs();
            let mut count = 0;
            for (dof, value) in targets {
                let turns = dofs[dof].motion == Motion::Rotation;
                let off = value - values[dof];
                let off = if turns { off - TAU * (off / TAU).round() } else { off };
                let scale = if dofs[dof].translates() { length } else { 1.0 };
                if joint.start.is_some() && off.abs() > CONFLICT * scale {
                    conflicts.push(Conflict::StartAndPrescribed {
                        joint: joint.dof_name(dof),
                        by: off.abs(),
                        is_angle: !dofs[dof].translates(),
                    });
                }
                let keep = joint.start.is_some() && !prescribed;
                values[dof] = if keep { value - off } else { value };
                if !prescribed && !keep {
                    values[dof] = 0.0;
                }
                count += usize::from(prescribed || keep);
            }
            let scalars = joint.joint_type.has_scalar_coordinates();
            let are_given = joint.start.is_some() || (scalars && count == dofs.len());
            JointCoordinates { values, are_given }
        })
        .collect()
    }

    /// Poses of all bodies relative to the reference point, along the cheapest paths from the
    /// ground, from prescribed poses and from homes; also the costs.
    fn body_poses(
        &self,
        prescribed: bool,
        joints: &[JointCoordinates],
        conflicts: &mut Vec<Conflict>,
    ) -> (Vec<Pose<f64>>, Vec<u64>) {
        let bodies = self.mechanism.bodies();
        let ground = self.parameters.ground;
        let mut prescribed_poses = vec![PrescribedPose::default(); bodies.len()];
        for (coordinate, target) in self.coordinates.iter().zip(self.targets) {
            match *coordinate {
                Coordinate::Position { body, axis } => {
                    prescribed_poses[body.0].position[axis] = Some(target.value);
                }
                Coordinate::Angle { body, order, index } => {
                    prescribed_poses[body.0].angles.push((order, index, target.value));
                }
                Coordinate::RotationVector { body, axis } => {
                    prescribed_poses[body.0].rotation_vector[axis] = Some(target.value);
                }
                Coordinate::Joint { .. } => {}
            }
        }
        let mut pose = vec![ground; bodies.len()];
        let mut cost = vec![u64::MAX; bodies.len()];
        let mut queue = BinaryHeap::new();
        let mut homes = vec![None; bodies.len()];
        cost[0] = 0;
        queue.push(Reverse((0, 0)));
        for &(body, home) in self.homes {
            homes[body.0] = Some(ground * home);
            (pose[body.0], cost[body.0]) = (ground * home, HOME);
            queue.push(Reverse((HOME, body.0)));
        }
        for (body, parts) in prescribed_poses.iter().enumerate() {
            if prescribed && parts.is_whole() {
                cost[body] = 0;
                queue.push(Reverse((0, body)));
            }
        }
        let mut at = vec![Vec::new(); bodies.len()];
        for (joint, (predecessor, successor)) in self.topology.ends.iter().enumerate() {
            at[*predecessor].push(joint);
            at[*successor].push(joint);
        }
        let mut is_done = vec![false; bodies.len()];
        let mut unreached = 1..bodies.len();
        loop {
            let Some(Reverse((_, body))) = queue.pop() else {
                // A body without a chain of joints to the ground.
                let Some(body) = unreached.find(|body| cost[*body] == u64::MAX) else { break };
                cost[body] = UNKNOWN;
                queue.push(Reverse((UNKNOWN, body)));
                continue;
            };
            if core::mem::replace(&mut is_done[body], true) {
                continue;
            }
            if prescribed && body > 0 {
                let seen = prescribed_poses[body].applied_to(ground.inverse() * pose[body]);
                pose[body] = ground * seen;
            }
            if let Some(home) = homes[body] {
                let by = displacement(&home, &pose[body], self.parameters.length);
                if by > CONFLICT {
                    let body = bodies[body].name.clone();
                    conflicts.push(Conflict::Home { body, by: by * self.parameters.length });
                }
            }
            for &joint in &at[body] {
                let across = if joints[joint].are_given { ACROSS } else { UNKNOWN };
                let (predecessor, successor) = self.topology.ends[joint];
                let other = if predecessor == body { successor } else { predecessor };
                let through = cost[body].saturating_add(across);
                if is_done[other] || through >= cost[other] {
                    continue;
                }
                let joint_type = self.topology.joint_types[joint];
                let q = &joints[joint].values;
                let step = self.parameters.frame_j[joint]
                    * joint_type.pose(q, self.parameters.pitch[joint])
                    * self.parameters.frame_k[joint].inverse();
                let step = if other == successor { step } else { step.inverse() };
                (pose[other], cost[other]) = (pose[body] * step, through);
                queue.push(Reverse((through, other)));
            }
        }
        (pose, cost)
    }

    /// Computes open coordinates from the closure of loops with otherwise known coordinates: of
    /// floating bodies on known chains, and of chains between known bodies. Returns a success flag
    /// for each node.
    fn fill(
        &self,
        joints: &[JointCoordinates],
        state: &mut State<f64>,
        is_open: &mut [bool],
    ) -> Vec<bool> {
        let topology = self.topology;
        let mut filled = vec![false; topology.nodes.len()];
        if !is_open.iter().any(|open| *open) || topology.cuts.is_empty() {
            return filled;
        }
        let (coordinates, targets) = self.with_starts_of_cuts(joints);
        let constraints = MotionConstraints::new(topology, &coordinates, &[]);
        let mut kinematics = Kinematics::new(topology, &constraints, &StaticLu::default());
        // The closure of a cut joint, and its coordinates as far as they are given.
        let rows_of = |cut: &Cut| -> Vec<usize> {
            let own = coordinates.iter().enumerate().filter(|(_, coordinate)| {
                matches!(coordinate, Coordinate::Joint { joint, .. } if joint.0 == cut.joint)
            });
            cut.constraints.clone().chain(own.map(|(k, _)| topology.constraints + k)).collect()
        };
        let is_floating = |node: usize| topology.nodes[node].link == Link::Floating;
        let mut random = Random::new(11);
        loop {
            let mut changed = false;
            let open_nodes = |path: &[(usize, f64)], is_open: &[bool]| -> Vec<usize> {
                path.iter().map(|(node, _)| *node).filter(|node| is_open[*node]).collect()
            };
            for node in (0..topology.nodes.len()).filter(|node| is_floating(*node)) {
                if !is_open[node] {
                    continue;
                }
                let alone = |path: &[(usize, f64)]| open_nodes(path, is_open) == [node];
                let mut rows: Vec<usize> = Vec::new();
                for cut in topology.cuts.iter().filter(|cut| alone(&cut.path)) {
                    rows.extend(rows_of(cut));
                }
                if rows.len() >= 6 {
                    let own = (topology.constraints..constraints.row_count())
                        .filter(|row| alone(&constraints.rows[*row].path));
                    rows.extend(own.collect::<Vec<_>>());
                    let equations = (&constraints, targets.as_slice());
                    let nodes = [node];
                    self.fill_nodes(&mut kinematics, equations, state, &rows, &nodes, &mut random);
                    (is_open[node], filled[node], changed) = (false, true, true);
                }
            }
            for cut in &topology.cuts {
                let nodes = open_nodes(&cut.path, is_open);
                if nodes.is_empty() || nodes.iter().any(|node| is_floating(*node)) {
                    continue;
                }
                let rows = rows_of(cut);
                let equations = (&constraints, targets.as_slice());
                self.fill_nodes(&mut kinematics, equations, state, &rows, &nodes, &mut random);
                for node in nodes {
                    (is_open[node], filled[node], changed) = (false, true, true);
                }
            }
            if !changed {
                return filled;
            }
        }
    }

    /// Prescribed coordinates, and starts of cut joints, which are not coordinates of the tree.
    fn with_starts_of_cuts(
        &self,
        joints: &[JointCoordinates],
    ) -> (Vec<Coordinate>, Vec<Target<f64>>) {
        let (mut coordinates, mut targets) = (self.coordinates.to_vec(), self.targets.to_vec());
        for cut in &self.topology.cuts {
            let joint_type = self.topology.joint_types[cut.joint];
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

    /// Adjusts the coordinates of some nodes to minimise the errors of the rows: first from the
    /// current values, then, if the loops remain open, from random values.
    fn fill_nodes(
        &self,
        kinematics: &mut Kinematics<f64>,
        (constraints, targets): (&MotionConstraints, &[Target<f64>]),
        state: &mut State<f64>,
        rows: &[usize],
        nodes: &[usize],
        random: &mut Random,
    ) {
        let topology = self.topology;
        let mut moves = vec![false; topology.dofs()];
        for &node in nodes {
            moves[topology.nodes[node].tree_dofs.clone()].fill(true);
        }
        for coordinate in self.coordinates {
            if let Coordinate::Joint { joint, dof } = coordinate
                && let Role::Tree { node } = topology.role[joint.0]
            {
                moves[topology.nodes[node].tree_dofs.start + dof] = false;
            }
        }
        let mut counts = vec![0.0; constraints.row_count()];
        rows.iter().for_each(|row| counts[*row] = 1.0);
        let equations = PositionEquations::new(topology, self.parameters, constraints, targets)
            .weighted(|row| counts[row])
            .moving(|dof| moves[dof]);
        let begin = state.clone();
        let mut best: Option<(f64, State<f64>)> = None;
        for attempt in 0..FILL_STARTS {
            let mut trial = begin.clone();
            if attempt > 0 {
                let jump: Vec<f64> = topology
                    .tree_dofs
                    .iter()
                    .zip(&moves)
                    .map(|(tree_dof, moves)| {
                        let size = match topology.tree_dof_translates(tree_dof) {
                            true => self.parameters.length,
                            false => PI,
                        };
                        if *moves { size * random.number() } else { 0.0 }
                    })
                    .collect();
                trial.advance(topology, &jump);
            }
            let descent = equations.solve(kinematics, &mut trial, 1e-9, FILL_STEPS);
            if best.as_ref().is_none_or(|(error, _)| descent.error < *error) {
                best = Some((descent.error, trial));
            }
            if descent.error < ROUGHLY_CLOSED {
                break;
            }
        }
        if let Some((_, found)) = best {
            *state = found;
        }
    }
}

impl Reference {
    /// Root mean square displacement of the bodies from their given poses over the characteristic
    /// length; `None` without given poses.
    pub(super) fn distance(&self, bodies: &Bodies<f64>, length: f64) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0);
        for (given, found) in self.poses.iter().zip(&bodies.pose).skip(1) {
            if let Some(given) = given {
                sum += displacement(given, found, length).powi(2);
                count += 1;
            }
        }
        (count > 0).then(|| (sum / f64::from(count)).sqrt())
    }

    /// Body farthest from its given pose: its index, and its displacement, m and rad.
    pub(super) fn farthest(&self, bodies: &Bodies<f64>, length: f64) -> Option<(usize, f64, f64)> {
        let pairs = self.poses.iter().zip(&bodies.pose).enumerate().skip(1);
        let each = pairs.filter_map(|(body, (given, found))| {
            let apart = given.as_ref()?.inverse() * *found;
            let (moved, turned) = (apart.position.norm(), apart.rotation.rotation_vector().norm());
            Some((body, moved, turned))
        });
        each.max_by(|a, b| (a.1 / length).hypot(a.2).total_cmp(&(b.1 / length).hypot(b.2)))
    }

    /// Adds whole turns to angles of the tree to bring them nearest to those of the reference.
    pub(super) fn unwind(&self, topology: &Topology, state: &mut State<f64>) {
        for node in &topology.nodes {
            let Link::Joint { joint, .. } = node.link else { continue };
            let joint_type = topology.joint_types[joint];
            if !joint_type.has_scalar_coordinates() {
                continue;
            }
            for (place, dof) in node.coordinates.clone().zip(joint_type.dofs()) {
                if dof.motion == Motion::Rotation {
                    let off = self.state.coordinates[place] - state.coordinates[place];
                    let turns = (off / TAU).round();
                    if turns != 0.0 {
                        state.coordinates[place] += TAU * turns;
                    }
                }
            }
        }
    }
}

/// Displacement of a body between two poses over the characteristic length: the distance of its
/// origins and, as an orthogonal component, the rotation angle times the characteristic length.
fn displacement(a: &Pose<f64>, b: &Pose<f64>, length: f64) -> f64 {
    let apart = a.inverse() * *b;
    (apart.position.norm() / length).hypot(apart.rotation.rotation_vector().norm())
}

/// Displacement between two placements of all bodies: root mean square over the bodies, with the
/// rotations of some ignored.
pub(super) fn apart(
    a: &Bodies<f64>,
    b: &Bodies<f64>,
    length: f64,
    turns: impl Fn(usize) -> bool,
) -> f64 {
    let count = a.pose.len().saturating_sub(1).max(1) as f64;
    let each =
        a.pose.iter().zip(&b.pose).enumerate().skip(1).map(|(body, (a, b))| match turns(body) {
            true => displacement(a, b, length).powi(2),
            false => ((a.inverse() * *b).position.norm() / length).powi(2),
        });
    (each.sum::<f64>() / count).sqrt()
}
