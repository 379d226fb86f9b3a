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
        let topology = &self.topology;
        let value = self.joint_coordinate(state, bodies, joint, dof);
        let Some(own) = topology.joint_types[joint.0].dofs().get(dof) else {
            return Target { value, rate: 0.0, acceleration: 0.0 };
        };
        let (predecessor, successor) = topology.ends[joint.0];
        let bias = bodies.joint_bias(topology, &self.parameters, joint.0);
        let relative = bodies.acceleration[successor] - bodies.acceleration[predecessor] - bias;
        Target {
            value,
            rate: bodies.joint_rates(topology, joint.0)[dof],
            acceleration: relative.power(bodies.effort(own, joint.0)),
        }
    }

    /// Largest loop-closure error for these bodies, m; angles times the characteristic length.
    pub fn closure_error(&self, bodies: &Bodies<f64>) -> f64 {
        closure_error(&self.topology, &self.parameters, bodies)
    }
}
