//! How single joints move.

use super::Forward;
use super::inputs::joint_coordinate;
use crate::kinematics::{Bodies, State, Target, closure_error};
use crate::mechanism::JointId;

impl Forward {
    /// The coordinate of a joint's freedom, rad or m, where the tree and the bodies are like this. Angles
    /// of joints that close a loop lie within half a turn; joints without scalar coordinates have the
    /// coordinate zero, and so have freedoms that are not there.
    pub fn joint_coordinate(
        &self,
        state: &State<f64>,
        bodies: &Bodies<f64>,
        joint: JointId,
        dof: usize,
    ) -> f64 {
        let pitch = &self.parameters.pitch;
        joint_coordinate((&self.topology, pitch), state, bodies, (joint.0, dof))
    }

    /// Coordinate, as [`Self::joint_coordinate`], rate and acceleration of a joint's freedom where the tree
    /// and the bodies move like this.
    pub fn joint_motion(
        &self,
        state: &State<f64>,
        bodies: &Bodies<f64>,
        joint: JointId,
        dof: usize,
    ) -> Target<f64> {
        let value = self.joint_coordinate(state, bodies, joint, dof);
        bodies.joint_motion(&self.topology, &self.parameters, (joint.0, dof), value)
    }

    /// The largest loop-closure error where bodies are like this, m; angles times the characteristic length.
    pub fn closure_error(&self, bodies: &Bodies<f64>) -> f64 {
        closure_error(&self.topology, &self.parameters, bodies)
    }
}
