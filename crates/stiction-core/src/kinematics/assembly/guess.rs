//! Where a search begins.

use super::super::bodies::{State, write_floating};
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::{Link, Topology};

/// A first state from start coordinates and guessed poses.
pub(in crate::kinematics) fn guess(
    mechanism: &Mechanism,
    topology: &Topology,
    parameters: &Parameters<f64>,
    initial_poses: &[(BodyId, Pose<f64>)],
) -> State<f64> {
    // Poses outwards from the ground along any joints, at their start coordinates.
    let mut pose = vec![None; mechanism.bodies().len()];
    pose[BodyId::GROUND.0] = Some(parameters.ground);
    for &(body, home) in initial_poses {
        pose[body.0] = Some(parameters.ground * home);
    }
    loop {
        let mut grew = false;
        for joint in mechanism.joints() {
            let step = || {
                let across = joint.joint_type.pose(&joint.start, joint.pitch);
                joint.frame_j * across * joint.frame_k.inverse()
            };
            let (predecessor, successor) = (joint.predecessor.0, joint.successor.0);
            match (pose[predecessor], pose[successor]) {
                (Some(known), None) => pose[successor] = Some(known * step()),
                (None, Some(known)) => pose[predecessor] = Some(known * step().inverse()),
                _ => continue,
            }
            grew = true;
        }
        if !grew {
            break;
        }
    }
    let mut state = State::new(topology);
    for node in &topology.nodes {
        let q = &mut state.coordinates[node.coordinates.clone()];
        match node.link {
            Link::Joint { joint, .. } => q.copy_from_slice(&mechanism.joints()[joint].start),
            Link::Floating => {
                write_floating(pose[node.body].unwrap_or(Pose::identity()), q);
            }
        }
    }
    state
}
