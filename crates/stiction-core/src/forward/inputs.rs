//! Inputs of a simulation: efforts, loads and prescribed motions as functions of time and state.

use crate::kinematics::{Bodies, Coordinate, State, Target, measure_motion};
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;
use crate::topology::Topology;
use std::f64::consts::TAU;

/// View of the present state of a simulation, passed to the methods of [`Inputs`].
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Time, s.
    pub time: f64,
    /// Coordinates and rates of the spanning tree.
    pub state: &'a State<f64>,
    /// Poses of the bodies, and twists about the reference point.
    pub bodies: &'a Bodies<f64>,
    pub(super) topology: &'a Topology,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) input: &'a InputState,
}

/// State of the inputs that is part of the state of a simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct InputState {
    /// Internal states of the inputs, see [`Inputs::initial_states`].
    pub(super) values: Vec<f64>,
    /// Magnitude of each internal state: its absolute tolerance is a fraction of this magnitude.
    pub(super) scales: Vec<f64>,
    /// Side of each switching function: true if the value counts as positive, see
    /// [`Inputs::switches`].
    pub(super) sides: Vec<bool>,
    /// Unwrapped angles of cut joints.
    pub(super) angles: Vec<Angle>,
}

/// Unwrapped angle (continuous over full turns) of a cut joint at the start of the present step.
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
    /// Returns the angle that differs from `nearest`, rad, by full turns and is closest to the
    /// predicted angle. The prediction uses the mean of the rate at the last update and `rate`, the
    /// rate at `time`, rad/s. Rates change little within a step, so the prediction error is much
    /// less than half a turn.
    pub(super) fn count_on(&self, time: f64, nearest: f64, rate: f64) -> f64 {
        if time == self.time {
            return self.value;
        }
        let expected = self.value + 0.5 * (time - self.time) * (self.rate + rate);
        nearest + TAU * ((expected - nearest) / TAU).round()
    }
}

impl<'a> View<'a> {
    /// Returns the internal states of the inputs, see [`Inputs::initial_states`].
    pub fn states(&self) -> &'a [f64] {
        &self.input.values
    }

    /// Returns the side of each switching function: true if its value counts as positive, see
    /// [`Inputs::switches`].
    pub fn sides(&self) -> &'a [bool] {
        &self.input.sides
    }

    /// Returns the rate of an actuator, rad/s or m/s.
    pub fn actuator_rate(&self, actuator: usize) -> f64 {
        self.bodies.actuator_rate(self.topology, self.topology.actuators[actuator])
    }

    /// Returns the coordinate of an actuator, rad or m. Angles are unwrapped (continuous over full
    /// turns since the start).
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

    /// Returns value and rate of a coordinate; the returned acceleration is zero. Joint angles are
    /// unwrapped (continuous over full turns since the start).
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

/// Returns the coordinate of a DOF of a joint, rad or m. Returns zero for joints without scalar
/// coordinates, and for indices that are not DOFs of the joint.
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

/// Inputs of a simulation: actuator efforts, prescribed motions and external loads. The results of
/// all methods must depend only on their arguments, since a simulation repeats steps. Inputs may
/// jump only at the times that [`Self::next_change`] returns and where a switching function changes
/// its sign, see [`Self::switches`].
pub trait Inputs {
    /// Writes the efforts of all actuators, N or N m, in the order of
    /// [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators). The simulation ignores the
    /// efforts of actuators with prescribed motion. `efforts` is initially zero.
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]);

    /// Writes the targets of the actuators with prescribed motion at a time, s, in the order passed
    /// to [`Forward::new`](super::Forward::new). `targets` is initially zero.
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let _ = (time, targets);
    }

    /// Appends the external loads on bodies to `loads`, which is initially empty.
    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        let _ = (view, loads);
    }

    /// Returns the internal states of the inputs, such as the integral term of a controller, as
    /// pairs of initial value and magnitude. The absolute tolerance of a state is proportional to
    /// this magnitude. The simulation integrates the states together with the mechanism, under the
    /// same error control.
    fn initial_states(&self) -> Vec<(f64, f64)> {
        Vec::new()
    }

    /// Writes the time derivatives of the internal states, per second. `rates` is initially zero.
    fn state_rates(&mut self, view: &View<'_>, rates: &mut [f64]) {
        let _ = (view, rates);
    }

    /// Appends the values of the switching functions to `values`, which is initially empty. The
    /// number of switching functions must be constant.
    ///
    /// Efforts, loads and rates of internal states must be smooth functions of time and state while
    /// [`View::sides`] stays the same, even beyond the zero of a switching function. An example of
    /// a switching function is an effort minus its limit. A step ends where a switching function
    /// changes its sign, and the entry of this function in [`View::sides`] changes at the end of
    /// this step.
    fn switches(&mut self, view: &View<'_>, values: &mut Vec<f64>) {
        let _ = (view, values);
    }

    /// Returns true if the simulation ends as soon as the switching function with the index
    /// `switch` is negative.
    fn ends_at(&self, switch: usize) -> bool {
        let _ = switch;
        false
    }

    /// Returns the name of a switching function for messages, such as "the effort of `A`".
    fn switch_name(&self, switch: usize) -> String {
        format!("switching function {switch} of the inputs")
    }

    /// Returns the next time after `time`, s, at which an input jumps or a controller samples;
    /// `None` if there is no such time. A step ends at this time.
    fn next_change(&self, time: f64) -> Option<f64> {
        let _ = time;
        None
    }

    /// Returns the time, s, until which efforts and loads stay constant after `time`, provided that
    /// the mechanism stays at rest. A simulation at rest does not evaluate the inputs before the
    /// returned time. The default is `time`: the inputs may change at any moment.
    fn steady_until(&self, time: f64) -> f64 {
        time
    }

    /// Returns true if efforts, loads and rates of internal states keep the values of the last
    /// evaluation until the next change ([`Self::next_change`]) or the next sign change of a
    /// switching function, however the mechanism moves. They need not be evaluated again until
    /// then. The default is false.
    fn are_constant(&self) -> bool {
        false
    }

    /// Returns the latest time, s, for which a few samples between `time` and this time resolve all
    /// changes of the inputs. No step extends beyond this time, because a longer step could miss a
    /// short pulse.
    fn seen_until(&self, time: f64) -> f64 {
        let _ = time;
        f64::INFINITY
    }

    /// Returns the time, s, until which the inputs are known. A step extends beyond this time only
    /// if the caller advances the simulation beyond it. The default is infinity.
    fn known_until(&self) -> f64 {
        f64::INFINITY
    }

    /// Notifies the inputs that a step begins at `time`, s. If the value of an input depends on
    /// earlier evaluations, every evaluation until the next call must start from the state of the
    /// input at this time.
    fn begin_step(&mut self, time: f64) {
        let _ = time;
    }

    /// Updates sampled inputs. The simulation calls this method once at the start and at each
    /// [`Self::next_change`].
    fn change(&mut self, view: &View<'_>) {
        let _ = view;
    }
}

/// Inputs with constant efforts, N or N m, in the order of [`Mechanism::actuators`], and no loads.
/// Actuators beyond the end of the list exert no effort.
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

    fn are_constant(&self) -> bool {
        true
    }
}
