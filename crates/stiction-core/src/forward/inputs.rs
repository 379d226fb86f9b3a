//! What acts on a mechanism from outside, as functions of time and state.

use crate::kinematics::{Bodies, State, Target};
use crate::statics::AppliedLoad;
use crate::topology::Topology;

/// What inputs may look at.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// s.
    pub time: f64,
    /// Coordinates and rates of the tree.
    pub state: &'a State<f64>,
    /// Poses and twists of the bodies, about the kernel origin.
    pub bodies: &'a Bodies<f64>,
    pub(super) topology: &'a Topology,
    /// Of each joint, m/rad; zero but for helical ones.
    pub(super) pitch: &'a [f64],
    /// Counted on; none within a step.
    pub(super) angles: &'a [Angle],
}

/// An angle that is counted on over full turns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Angle {
    pub(super) joint: usize,
    pub(super) dof: usize,
    /// rad.
    pub(super) value: f64,
    /// rad/s.
    pub(super) rate: f64,
    /// When it was so, s.
    pub(super) time: f64,
}

impl View<'_> {
    /// The rate of an actuator, rad/s or m/s.
    pub fn actuator_rate(&self, actuator: usize) -> f64 {
        self.bodies.actuator_rate(self.topology, self.topology.actuators[actuator])
    }

    /// The coordinate of an actuator, rad or m. In [`Inputs::change`] angles are counted on over full turns
    /// since the start; elsewhere those of joints that close a loop lie within half a turn, but those of
    /// helical ones, which their advance tells.
    pub fn actuator_coordinate(&self, actuator: usize) -> f64 {
        let actuator = self.topology.actuators[actuator];
        let at = (actuator.joint, actuator.dof);
        if let Some(angle) = self.angles.iter().find(|angle| (angle.joint, angle.dof) == at) {
            return angle.value;
        }
        joint_coordinate((self.topology, self.pitch), self.state, self.bodies, at)
    }
}

/// The coordinate of a joint's freedom; zero of joints without scalar coordinates, and of freedoms that are not there.
pub(super) fn joint_coordinate(
    (topology, pitch): (&Topology, &[f64]),
    state: &State<f64>,
    bodies: &Bodies<f64>,
    (joint, dof): (usize, usize),
) -> f64 {
    let joint_type = topology.joint_types[joint];
    if !joint_type.has_scalar_coordinates() {
        return 0.0;
    }
    if let Some(node) = topology.node_of(joint) {
        let own = &state.coordinates[node.coordinates.clone()];
        return own.get(dof).copied().unwrap_or(0.0);
    }
    let relative = bodies.frame_j[joint].inverse() * bodies.frame_k[joint];
    let nearest = joint_type.nearest(relative, pitch[joint]).1;
    nearest.get(dof).copied().unwrap_or(0.0)
}

/// What acts from outside. All methods must answer from their arguments alone: a step is tried, and
/// tried again. What changes suddenly does so at [`Self::next_change`].
pub trait Inputs {
    /// Efforts of all actuators, N or N m, in their order; those of prescribed ones are not read.
    /// `efforts` are zeros.
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]);

    /// Where prescribed actuators are, in the order in which they were named. `targets` are zeros.
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let _ = (time, targets);
    }

    /// Loads on bodies; the list is empty.
    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        let _ = (view, loads);
    }

    /// The next time after `time` at which an input jumps or a controller samples; steps end there.
    fn next_change(&self, time: f64) -> Option<f64> {
        let _ = time;
        None
    }

    /// Until when, from `time` on, efforts and loads stay as they are while the mechanism stands still, s: before
    /// that they are not asked for where everything sticks. By default they may change at once.
    fn steady_until(&self, time: f64) -> f64 {
        time
    }

    /// Up to when, from `time` on, looks at a few instants tell what acts, s. No step goes further; what is shorter
    /// than a step, and over between two looks, would be missed.
    fn seen_until(&self, time: f64) -> f64 {
        let _ = time;
        f64::INFINITY
    }

    /// Called once at each such time, and at the start, with the state that it may sample.
    fn change(&mut self, view: &View<'_>) {
        let _ = view;
    }
}

/// Constant efforts and nothing else, N or N m, in the order of [`Mechanism::actuators`]; actuators beyond the list
/// exert none.
///
/// [`Mechanism::actuators`]: crate::mechanism::Mechanism::actuators
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantEfforts(pub Vec<f64>);

impl Inputs for ConstantEfforts {
    fn efforts(&mut self, _view: &View<'_>, efforts: &mut [f64]) {
        efforts.iter_mut().zip(&self.0).for_each(|(effort, constant)| *effort = *constant);
    }

    fn steady_until(&self, _time: f64) -> f64 {
        f64::INFINITY
    }
}
