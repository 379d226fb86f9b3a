//! Reference configuration of a model: `home` poses of bodies, `start` coordinates of joints, and
//! the prescribed coordinates.
//!
//! Prescribed coordinates take precedence over `start` coordinates, and these over `home` poses. A
//! missing `start` coordinate follows from home poses, from neighbouring bodies and from prescribed
//! poses.

use super::super::bodies::{Bodies, State, write_floating};
use super::super::coordinate::{Coordinate, Target};
use super::known_poses::CONFLICT;
use super::metric::{Metric, rms};
use super::report::Conflict;
use crate::joint::Motion;
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::{Link, Topology};
use core::f64::consts::TAU;

/// Given data from which the reference configuration is built.
#[derive(Clone, Copy)]
pub(in crate::kinematics) struct Given<'a> {
    pub(in crate::kinematics) mechanism: &'a Mechanism,
    pub(in crate::kinematics) topology: &'a Topology,
    pub(in crate::kinematics) parameters: &'a Parameters<f64>,
    /// Home poses of bodies in the ground's frame.
    pub(in crate::kinematics) homes: &'a [(BodyId, Pose<f64>)],
    /// Prescribed coordinates, with one target for each in `targets`.
    pub(in crate::kinematics) coordinates: &'a [Coordinate],
    pub(in crate::kinematics) targets: &'a [Target<f64>],
}

/// Reference configuration. The loops are closed only to the accuracy of the given numbers.
#[derive(Clone, Debug)]
pub(in crate::kinematics) struct Reference {
    /// State of the spanning tree at the reference configuration.
    pub(in crate::kinematics) state: State<f64>,
    /// Pose of each body relative to the reference point; `None` if the given data do not determine
    /// the pose.
    poses: Vec<Option<Pose<f64>>>,
    /// True for each body whose pose follows from the given data alone. Poses that follow from loop
    /// closure are not certain, because loop closure may have several solutions.
    is_certain: Vec<bool>,
    /// Contradictions among home poses, start coordinates and prescribed coordinates.
    pub(super) conflicts: Vec<Conflict>,
}

/// Given or assumed coordinates of one joint.
pub(super) struct JointCoordinates {
    pub(super) values: Vec<f64>,
    /// True if every coordinate is prescribed or has a start value.
    pub(super) are_given: bool,
}

impl Given<'_> {
    /// Builds the reference configuration. If `prescribed` is false, ignores the prescribed
    /// coordinates and uses only start coordinates (modulo whole turns) and home poses.
    pub(in crate::kinematics) fn reference(&self, prescribed: bool) -> Reference {
        let mut conflicts = Vec::new();
        let joints = self.joint_coordinates(prescribed, &mut conflicts);
        let mut bodies = self.body_poses(prescribed, &joints, &mut conflicts);
        let is_certain = bodies.is_known.clone();
        self.close_loops(prescribed, &joints, &mut bodies);
        let mut state = State::new(self.topology);
        let mut is_given = vec![true; state.coordinates.len()];
        for node in &self.topology.nodes {
            let q = &mut state.coordinates[node.coordinates.clone()];
            match node.link {
                Link::Floating => write_floating(bodies.poses[node.body], q),
                Link::Joint { joint, .. } => {
                    q.copy_from_slice(&joints[joint].values);
                    let (predecessor, successor) = self.topology.ends[joint];
                    if joints[joint].are_given
                        || !bodies.is_placed[predecessor]
                        || !bodies.is_placed[successor]
                    {
                        let values = self.prescribed_values(joint).into_iter();
                        for (is_given, value) in
                            is_given[node.coordinates.clone()].iter_mut().zip(values)
                        {
                            *is_given = joints[joint].are_given || (prescribed && value.is_some());
                        }
                        continue;
                    }
                    let j = bodies.poses[predecessor] * self.parameters.frame_j[joint];
                    let k = bodies.poses[successor] * self.parameters.frame_k[joint];
                    let joint_type = self.topology.joint_types[joint];
                    let pitch = self.parameters.pitch[joint];
                    joint_type.write_coordinates(j.inverse() * k, pitch, q);
                    if joint_type.has_scalar_coordinates() {
                        for (q, value) in q.iter_mut().zip(self.prescribed_values(joint)) {
                            *q = value.filter(|_| prescribed).unwrap_or(*q);
                        }
                    }
                }
            }
        }
        self.follow_gearings(&mut is_given, &mut state);
        let poses = bodies.poses.into_iter().zip(bodies.is_known);
        let poses = poses.map(|(pose, is_known)| is_known.then_some(pose)).collect();
        Reference { state, poses, is_certain, conflicts }
    }

    /// Computes each coordinate that is not given itself but follows from given coordinates by a
    /// gearing.
    fn follow_gearings(&self, is_given: &mut [bool], state: &mut State<f64>) {
        for gearing in &self.topology.gearings {
            let coefficients = &self.parameters.gearings[gearing.gearing].coefficients;
            let terms = gearing.dofs.iter().zip(coefficients);
            let mut open = terms.filter(|((_, coordinate), _)| !is_given[*coordinate]);
            let (Some((&(_, coordinate), coefficient)), None) = (open.next(), open.next()) else {
                continue;
            };
            state.coordinates[coordinate] -=
                gearing.error(self.parameters, &state.coordinates) / coefficient;
            is_given[coordinate] = true;
        }
    }

    /// Prescribed value of each scalar coordinate of a joint; `None` for a coordinate that is not
    /// prescribed.
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

    /// Returns the coordinates of all joints: prescribed values (ignored if `prescribed` is false),
    /// otherwise start coordinates, otherwise zero. Start angles are shifted by whole turns to be
    /// nearest to the prescribed value. Adds start coordinates that contradict prescribed values to
    /// `conflicts`.
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
}

impl Reference {
    /// Computes the root-mean-square displacement of the bodies from their given poses, in
    /// characteristic lengths. Returns `None` if no poses are given.
    pub(super) fn distance(&self, bodies: &Bodies<f64>, metric: &Metric<'_>) -> Option<f64> {
        let pairs = self.poses.iter().zip(&bodies.pose).enumerate().skip(1);
        rms(pairs.filter_map(|(body, (given, found))| {
            Some(metric.displacement(body, given.as_ref()?, found))
        }))
    }

    /// Returns `true` if the pose of a body follows from the given data alone, without loop
    /// closure.
    pub(super) fn is_certain(&self, body: usize) -> bool {
        self.is_certain[body]
    }

    /// Computes the root-mean-square displacement, from their given poses, of the bodies for which
    /// [`Self::is_certain()`] is true; zero if there is no such body.
    pub(super) fn certain_distance(&self, bodies: &Bodies<f64>, metric: &Metric<'_>) -> f64 {
        let pairs = self.poses.iter().zip(&bodies.pose).enumerate().skip(1);
        let certain = pairs.filter(|(body, _)| self.is_certain[*body]);
        rms(certain.filter_map(|(body, (given, found))| {
            Some(metric.displacement(body, given.as_ref()?, found))
        }))
        .unwrap_or(0.0)
    }

    /// Finds the body farthest from its given pose. Returns the index of the body and its
    /// displacement in m and rad; `None` if no body has a given pose.
    pub(super) fn farthest(
        &self,
        bodies: &Bodies<f64>,
        metric: &Metric<'_>,
    ) -> Option<(usize, f64, f64)> {
        let pairs = self.poses.iter().zip(&bodies.pose).enumerate().skip(1);
        let each = pairs.filter_map(|(body, (given, found))| {
            let (moved, turned) = metric.parts(body, given.as_ref()?, found);
            Some((body, moved, turned))
        });
        let size = |moved: f64, turned: f64| (moved / metric.length).hypot(turned);
        each.max_by(|a, b| size(a.1, a.2).total_cmp(&size(b.1, b.2)))
    }

    /// Rotates bodies about the axes of their passive spins towards their given poses, and updates
    /// the coordinates of the spanning tree in `state`.
    pub(super) fn turn_spins(
        &self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        metric: &Metric<'_>,
        bodies: &Bodies<f64>,
        state: &mut State<f64>,
    ) {
        let turned: Vec<Option<Pose<f64>>> = (0..bodies.pose.len())
            .map(|body| metric.turned(body, self.poses[body].as_ref()?, &bodies.pose[body]))
            .collect();
        let pose = |body: usize| turned[body].unwrap_or(bodies.pose[body]);
        for node in &topology.nodes {
            let Link::Joint { joint, .. } = node.link else { continue };
            let (predecessor, successor) = topology.ends[joint];
            if turned[predecessor].is_none() && turned[successor].is_none() {
                continue;
            }
            let j = pose(predecessor) * parameters.frame_j[joint];
            let k = pose(successor) * parameters.frame_k[joint];
            topology.joint_types[joint].write_coordinates(
                j.inverse() * k,
                parameters.pitch[joint],
                &mut state.coordinates[node.coordinates.clone()],
            );
        }
        self.unwind(topology, state);
    }

    /// Adds whole turns to angles of the spanning tree, so that they are nearest to those of the
    /// reference configuration.
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
