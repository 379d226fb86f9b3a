//! Mechanism at given poses of its bodies, with the resulting poses of the joint frames.

use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::Pose;

/// Mechanism with the poses of its bodies, the ground first, and the poses of both frames of each
/// joint. All poses are in world axes, relative to a common origin, m.
#[derive(Clone, Debug)]
pub(super) struct Placed<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) pose: Vec<Pose<f64>>,
    pub(super) frame_j: Vec<Pose<f64>>,
    pub(super) frame_k: Vec<Pose<f64>>,
}

impl<'a> Placed<'a> {
    pub(super) fn new(mechanism: &'a Mechanism, poses: &[Pose<f64>]) -> Self {
        let joints = mechanism.joints();
        let frame_j = joints.iter().map(|joint| poses[joint.predecessor.0] * joint.frame_j);
        let frame_k = joints.iter().map(|joint| poses[joint.successor.0] * joint.frame_k);
        Self {
            mechanism,
            pose: poses.to_vec(),
            frame_j: frame_j.collect(),
            frame_k: frame_k.collect(),
        }
    }
}
