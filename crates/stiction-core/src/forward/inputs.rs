//! Inputs of a simulation: efforts, loads and prescribed motions as functions of time and state.

use crate::kinematics::{Bodies, Coordinate, State, Target, measure_motion};
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;
use crate::topology::Topology;
use std::f64::consts::TAU;

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
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) input: &'a InputState,
}

/// State that a simulation keeps for its inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct InputState {
    /// Own states of the inputs, see [`Inputs::initial_states`].
    pub(super) values: Vec<f64>,
    /// Sizes of these states at which the absolute tolerance counts.
    pub(super) scales: Vec<f64>,
    /// Side of each switching function, see [`Inputs::switches`].
    pub(super) sides: Vec<bool>,
    /// Angles of joints that close a loop, counted over full turns.
    pub(super) angles: Vec<Angle>,
}

/// Angle counted over full turns up to the start of the present step.
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

impl Angle {
    /// Among the angles that differ from `nearest` by full turns, the one nearest to that predicted by
    /// the mean rate. Rates change little within a step compared with half a turn.
    pub(super) fn count_on(&self, time: f64, nearest: f64, rate: f64) -> f64 {
        if time == self.time {
            return self.value;
        }
        let expected = self.value + 0.5 * (time - self.time) * (self.rate + rate);
        nearest + TAU * ((expected - nearest) / TAU).round()
    }
}

impl<'a> View<'a> {
    /// Own states of the inputs, see [`Inputs::initial_states`].
    pub fn states(&self) -> &'a [f64] {
        &self.input.values
    }

    /// Side of each switching function: true where its value counts as positive, see
    /// [`Inputs::switches`].
    pub fn sides(&self) -> &'a [bool] {
        &self.input.sides
    }

    /// Rate of an actuator, rad/s or m/s.
    pub fn actuator_rate(&self, actuator: usize) -> f64 {
        self.bodies.actuator_rate(self.topology, self.topology.actuators[actuator])
    }

    /// Coordinate of an actuator, rad or m; angles are counted over full turns since the start.
    pub fn actuator_coordinate(&self, actuator: usize) -> f64 {
        let actuator = self.topology.actuators[actuator];
        let at = (actuator.joint, actuator.dof);
        let place = (self.topology, &self.parameters.pitch[..]);
        let nearest = joint_coordinate(place, self.state, self.bodies, at);
        let own = |angle: &&Angle| (angle.joint, angle.dof) == at;
        match self.input.angles.iter().find(own) {
            None => nearest,
            Some(angle) => {
                let rate = self.bodies.actuator_rate(self.topology, actuator);
                angle.count_on(self.time, nearest, rate)
            }
        }
    }

    /// Value and rate of a coordinate; the acceleration is zero. Angles of joints are counted over full
    /// turns since the start.
    pub fn measure(&self, coordinate: Coordinate) -> Target<f64> {
        let (topology, parameters) = (self.topology, self.parameters);
        let tree = &self.state.coordinates;
        let mut motion = measure_motion(coordinate, topology, parameters, self.bodies, tree);
        if let Coordinate::Joint { joint, dof } = coordinate {
            let own = |angle: &&Angle| (angle.joint, angle.dof) == (joint.0, dof);
            if let Some(angle) = self.input.angles.iter().find(own) {
                motion.value = angle.count_on(self.time, motion.value, motion.rate);
            }
        }
        motion
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

    /// Own states of the inputs, such as the integral of a controller: for each its value at the start and
    /// the size at which the absolute tolerance counts. They are integrated with the mechanism, under
    /// the same error control.
    fn initial_states(&self) -> Vec<(f64, f64)> {
        Vec::new()
    }

    /// Writes the rates of the own states, per second. `rates` contains zeros.
    fn state_rates(&mut self, view: &View<'_>, rates: &mut [f64]) {
        let _ = (view, rates);
    }

    /// Appends the values of the switching functions to the empty list, always the same number.
    ///
    /// Efforts, loads and rates of own states must be smooth functions on the side
    /// [`View::sides`] of each, also beyond its zero. A step ends where one changes its sign, and the side
    /// changes there; an effort limit is an example.
    fn switches(&mut self, view: &View<'_>, values: &mut Vec<f64>) {
        let _ = (view, values);
    }

    /// Returns true if the simulation ends where this switching function is or becomes negative.
    fn ends_at(&self, switch: usize) -> bool {
        let _ = switch;
        false
    }

    /// Description of a switching function in messages, such as "the effort of `A`".
    fn switch_name(&self, switch: usize) -> String {
        format!("switching function {switch} of the inputs")
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
