//! Unwrapping of the angles of cut joints: body poses determine these angles only up to full turns.

use super::Simulation;
use crate::forward::Forward;
use crate::forward::inputs::{Angle, InputState, View};
use crate::kinematics::{Bodies, State, Target};
use crate::mechanism::JointId;

impl Forward {
    /// Returns the angles of cut joints, reduced to the range from -pi to pi, each with its rate.
    pub(super) fn angles(&self, time: f64, state: &State<f64>, bodies: &Bodies<f64>) -> Vec<Angle> {
        let topology = &self.topology;
        let mut angles = Vec::new();
        for (joint, joint_type) in topology.joint_types.iter().enumerate() {
            if !joint_type.has_scalar_coordinates() || topology.node_of(joint).is_some() {
                continue;
            }
            for (dof, own) in joint_type.dofs().iter().enumerate() {
                if !own.translates() {
                    let Target { value, rate, .. } =
                        self.joint_motion(state, bodies, JointId(joint), dof);
                    angles.push(Angle { joint, dof, value, rate, time });
                }
            }
        }
        angles
    }
}

impl Simulation<'_> {
    /// Returns coordinate, rate and acceleration of a degree of freedom of a joint at the present
    /// instant, see [`Forward::joint_motion`]. Angles are unwrapped (continuous over full turns
    /// since the start).
    pub fn joint_motion(&self, joint: JointId, dof: usize) -> Target<f64> {
        let Self { now, input: InputState { angles, .. }, .. } = self.shown();
        let mut motion = self.model.joint_motion(&now.state, &now.bodies, joint, dof);
        let own = |angle: &&Angle| (angle.joint, angle.dof) == (joint.0, dof);
        if let Some(angle) = angles.iter().find(own) {
            motion.value = angle.value;
        }
        motion
    }

    /// Returns the present state in the form that is passed to the inputs.
    pub fn view(&self) -> View<'_> {
        let now = &self.now;
        View {
            time: now.time,
            state: &now.state,
            bodies: &now.bodies,
            topology: &self.model.topology,
            parameters: &self.model.parameters,
            input: &self.input,
        }
    }

    /// Updates the unwrapped angles after a step.
    pub(super) fn count_turns(&mut self) {
        let (model, now) = (self.model, &self.now);
        for angle in &mut self.input.angles {
            let joint = JointId(angle.joint);
            let motion = model.joint_motion(&now.state, &now.bodies, joint, angle.dof);
            angle.value = angle.count_on(now.time, motion.value, motion.rate);
            angle.rate = motion.rate;
            angle.time = now.time;
        }
    }
}
