//! Coordinates and motion of single joints, and the closure error of the loops.

use super::Forward;
use super::inputs::joint_coordinate;
use crate::kinematics::{Bodies, State, Target, closure_error};
use crate::mechanism::JointId;

impl Forward {
    /// Returns the coordinate of a DOF of a joint, rad or m, for given tree coordinates and body
    /// poses. Angles of cut joints lie within half a turn of zero. Returns zero for joints without
    /// scalar coordinates, and for indices that are not DOFs of the joint.
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

    /// Returns the coordinate (see [`Self::joint_coordinate`]), rate and acceleration of a DOF of a
    /// joint for given tree coordinates and body motions.
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

    /// Returns the largest closure error of loops and gearings, m, for given tree coordinates and
    /// body poses. Angular errors are multiplied by the characteristic length.
    pub fn closure_error(&self, bodies: &Bodies<f64>, state: &State<f64>) -> f64 {
        closure_error(&self.topology, &self.parameters, (bodies, &state.coordinates))
    }
}
