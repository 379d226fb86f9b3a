//! Motion of single joints.

use super::Forward;
use super::inputs::joint_coordinate;
use crate::kinematics::{Bodies, State, Target, closure_error};
use crate::mechanism::JointId;

impl Forward {
    /// Coordinate of a joint's DOF, rad or m, for this state of the tree and of the bodies. Angles
    /// of joints that close a loop lie within half a turn. Zero for joints without scalar coordinates, and for indices
    /// without a DOF.
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

    /// Coordinate, as [`Self::joint_coordinate`], rate and acceleration of a joint's DOF for this motion of the tree and of
    /// the bodies.
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

    /// Largest error of loops and gearings for these bodies and this state, m; angles times the characteristic length.
    pub fn closure_error(&self, bodies: &Bodies<f64>, state: &State<f64>) -> f64 {
        closure_error(&self.topology, &self.parameters, (bodies, &state.coordinates))
    }
}
