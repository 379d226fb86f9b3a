//! Inputs of a simulation: efforts, loads and prescribed motions as functions of time and state.

use crate::kinematics::{Bodies, State, Target};
use crate::statics::AppliedLoad;
use crate::topology::Topology;

/// State that inputs may depend on.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Time, s.
    pub time: f64,
    /// Coordinates and rates of the tree.
    pub state: &'a State<f64>,
    /// Poses and twists of the bodies, about the reference point.
    pub bodies: &'a Bodies<f64>,
    pub(super) topology: &'a Topology,
    /// Pitch of each joint, m/rad; zero except for helical joints.
    pub(super) pitch: &'a [f64],
    /// Angles counted over full turns; empty within a step.
    pub(super) angles: &'a [Angle],
}

/// Angle counted over full turns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Angle {
    pub(super) joint: usize,
    pub(super) dof: usize,
    /// Angle at the last update, rad.
    pub(super) value: f64,
    /// Rate at the last update, rad/s.
    pub(super) rate: f64,
    /// Time of the last update, s.
    pub(super) time: f64,
}

impl View<'_> {
    /// Rate of an actuator, rad/s or m/s.
    pub fn actuator_rate(&self, actuator: usize) -> f64 {
        self.bodies.actuator_rate(self.topology, self.topology.actuators[actuator])
    }

    /// Coordinate of an actuator, rad or m. In [`Inputs::change`] angles are counted over full turns
    /// since the start. Elsewhere angles of joints that close a loop lie within half a turn; those of helical joints
    /// follow from their advance.
    pub fn actuator_coordinate(&self, actuator: usize) -> f64 {
        let actuator = self.topology.actuators[actuator];
        let at = (actuator.joint, actuator.dof);
        if let Some(angle) = self.angles.iter().find(|angle| (angle.joint, angle.dof) == at) {
            return angle.value;
        }
        joint_coordinate((self.topology, self.pitch), self.state, self.bodies, at)
    }
}

/// Coordinate of a joint's DOF; zero for joints without scalar coordinates, and for indices without a DOF.
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

/// Inputs of a simulation. The results of all methods may depend on their arguments only, since
/// steps are repeated. Jumps are allowed only at [`Self::next_change`].
pub trait Inputs {
    /// Writes the efforts of all actuators, N or N m, in their order; those of prescribed actuators are ignored.
    /// `efforts` contains zeros.
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]);

    /// Writes the targets of the prescribed actuators at a time, s, in the order given to the model. `targets` contains
    /// zeros.
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let _ = (time, targets);
    }

    /// Appends the loads on bodies to the empty list.
    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        let _ = (view, loads);
    }

    /// Next time after `time`, s, at which an input jumps or a controller samples; steps end there.
    fn next_change(&self, time: f64) -> Option<f64> {
        let _ = time;
        None
    }

    /// Time, s, up to which efforts and loads stay constant from `time` on while the mechanism is
    /// at rest. A simulation at rest does not evaluate them before that time. By default they may
    /// change at any time.
    fn steady_until(&self, time: f64) -> f64 {
        time
    }

    /// Time, s, up to which a few samples from `time` on resolve the inputs; no step exceeds it. A
    /// pulse shorter than a step could otherwise be missed.
    fn seen_until(&self, time: f64) -> f64 {
        let _ = time;
        f64::INFINITY
    }

    /// Time, s, up to which the inputs are known; steps end there. By default they are known
    /// beyond the end of every simulation.
    fn known_until(&self) -> f64 {
        f64::INFINITY
    }

    /// A step begins at this time, s. Inputs whose evaluation depends on earlier ones start from
    /// their state of this moment until the next step begins.
    fn begin_step(&mut self, time: f64) {
        let _ = time;
    }

    /// Updates sampled inputs; called once at the start and at each [`Self::next_change`].
    fn change(&mut self, view: &View<'_>) {
        let _ = view;
    }
}

/// Constant efforts without loads, N or N m, in the order of [`Mechanism::actuators`]; zero for actuators beyond the list.
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
