//! Poses of bodies from prescribed and home poses, along chains of joints with given coordinates.

use super::metric::displacement;
use super::prescribed_pose::PrescribedPose;
use super::reference::{Given, JointCoordinates};
use super::report::Conflict;
use crate::spatial::Pose;
use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cost of a path segment across a joint with given coordinates, when a body's pose is computed
/// along the cheapest path.
const ACROSS: u64 = 1;
/// Cost of a path that begins at a body's home pose.
const HOME: u64 = 1 << 20;
/// Cost of a path segment across a joint whose coordinates are not all given.
const UNKNOWN: u64 = 1 << 40;
/// Two values given for the same quantity are reported as a conflict if they differ by more than
/// this threshold, in rad or characteristic lengths.
pub(super) const CONFLICT: f64 = 1.0;

/// Poses of all bodies relative to the reference point.
pub(super) struct BodyPoses {
    pub(super) poses: Vec<Pose<f64>>,
    /// True for each body whose pose the given data determine.
    pub(super) is_known: Vec<bool>,
    /// True for each body with a known pose, and for each body placed such that its loops close as
    /// far as possible.
    pub(super) is_placed: Vec<bool>,
    /// All bodies except the ground, each listed after its parent body, with the joint to the
    /// parent. The joint is `None` if the pose of the body is known.
    pub(super) paths: Vec<(usize, Option<usize>)>,
}

impl Given<'_> {
    /// Computes the poses of all bodies relative to the reference point. Each pose follows along
    /// the cheapest path from the ground, a prescribed pose or a home pose. If `prescribed` is
    /// false, ignores prescribed poses. Adds contradictory home poses to `conflicts`.
    pub(super) fn body_poses(
        &self,
        prescribed: bool,
        joints: &[JointCoordinates],
        conflicts: &mut Vec<Conflict>,
    ) -> BodyPoses {
        let bodies = self.mechanism.bodies();
        let ground = self.parameters.ground;
        let prescribed_poses =
            PrescribedPose::of_bodies(bodies.len(), self.coordinates, self.targets);
        let mut pose = vec![ground; bodies.len()];
        let mut cost = vec![u64::MAX; bodies.len()];
        let mut via = vec![None; bodies.len()];
        let mut paths = Vec::with_capacity(bodies.len());
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
        while let Some(Reverse((_, body))) = queue.pop() {
            if core::mem::replace(&mut is_done[body], true) {
                continue;
            }
            if body > 0 {
                paths.push((body, via[body].filter(|_| cost[body] >= UNKNOWN)));
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
                (pose[other], cost[other], via[other]) = (pose[body] * step, through, Some(joint));
                queue.push(Reverse((through, other)));
            }
        }
        let is_known: Vec<bool> = cost.iter().map(|cost| *cost < UNKNOWN).collect();
        BodyPoses { poses: pose, is_placed: is_known.clone(), is_known, paths }
    }
}
