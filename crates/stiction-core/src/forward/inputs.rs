//! Inputs of a simulation: efforts, loads and prescribed motions as functions of time and state.

use crate::kinematics::{Bodies, Coordinate, State, Target, measure_motion};
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;
use crate::topology::Topology;
use std::f64::consts::TAU;

/// Present state of a simulation, as an argument of the inputs.
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

/// State of the inputs that a simulation stores.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct InputState {
    /// Internal states of the inputs, see [`Inputs::initial_states`].
    pub(super) values: Vec<f64>,
    /// Scale of each internal state: its absolute tolerance is a fraction of this scale.
    pub(super) scales: Vec<f64>,
    /// Side of each switching function, see [`Inputs::switches`].
    pub(super) sides: Vec<bool>,
    /// Angles of joints that close a loop, counted over full turns.
    pub(super) angles: Vec<Angle>,
}

/// Angle of a joint, counted over full turns up to the start of the present step.
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
    /// Returns the angle that equals `nearest`, rad, up to full turns and is closest to the angle predicted with the
    /// mean of the rates before and now. Rates change little within a step, so that the prediction errs by much less
    /// than half a turn.
    pub(super) fn count_on(&self, time: f64, nearest: f64, rate: f64) -> f64 {
        if time == self.time {
            return self.value;
        }
        let expected = self.value + 0.5 * (time - self.time) * (self.rate + rate);
        nearest + TAU * ((expected - nearest) / TAU).round()
    }
}

impl<'a> View<'a> {
    /// Internal states of the inputs, see [`Inputs::initial_states`].
    pub fn states(&self) -> &'a [f64] {
        &self.input.values
    }

    /// Side of each switching function: true if its value counts as positive, see [`Inputs::switches`].
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

    /// Value and rate of a coordinate; the acceleration is set to zero. Angles of joints are counted over full turns
    /// since the start.
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

/// Coordinate of a joint's DOF, rad or m; zero for joints without scalar coordinates, and for indices that are not DOFs
/// of the joint.
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

/// Inputs of a simulation. The results of all methods must depend on their arguments only, since a simulation repeats
/// steps. Inputs may jump only at [`Self::next_change`].
pub trait Inputs {
    /// Writes the efforts of all actuators, N or N m, in the order of
    /// [`Mechanism::actuators`](crate::mechanism::Mechanism::actuators). The simulation ignores those of prescribed
    /// actuators. `efforts` contains zeros at first.
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]);

    /// Writes the targets of the prescribed actuators at a time, s, in the order given to
    /// [`Forward::new`](super::Forward::new). `targets` contains zeros at first.
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let _ = (time, targets);
    }

    /// Appends the loads on bodies to `loads`, which is empty at first.
    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        let _ = (view, loads);
    }

    /// Returns the internal states of the inputs, such as the integral of a controller: for each
    /// one its initial value, and the magnitude to which the absolute tolerance refers. The
    /// simulation integrates them with the mechanism, under the same error control.
    fn initial_states(&self) -> Vec<(f64, f64)> {
        Vec::new()
    }

    /// Writes the rates of the internal states, per second. `rates` contains zeros at first.
    fn state_rates(&mut self, view: &View<'_>, rates: &mut [f64]) {
        let _ = (view, rates);
    }

    /// Appends the values of the switching functions to `values`, which is empty at first; their number must be
    /// constant.
    ///
    /// Efforts, loads and rates of internal states must be smooth functions of time and state while
    /// [`View::sides`] stays the same, even beyond the zero of a switching function. An example of a
    /// switching function is an effort minus its limit. A step ends where the function changes its
    /// sign; from there on, the function has its other side.
    fn switches(&mut self, view: &View<'_>, values: &mut Vec<f64>) {
        let _ = (view, values);
    }

    /// Returns whether the simulation ends where this switching function is or becomes negative.
    fn ends_at(&self, switch: usize) -> bool {
        let _ = switch;
        false
    }

    /// Name of a switching function for messages, such as "the effort of `A`".
    fn switch_name(&self, switch: usize) -> String {
        format!("switching function {switch} of the inputs")
    }

    /// Returns the next time after `time`, s, at which an input jumps or a controller samples. Steps end there.
    fn next_change(&self, time: f64) -> Option<f64> {
        let _ = time;
        None
    }

    /// Returns the time, s, until which efforts and loads stay constant from `time` on as long as the mechanism is at
    /// rest. A simulation at rest does not evaluate them before that time. By default they may change at any time.
    fn steady_until(&self, time: f64) -> f64 {
        time
    }

    /// Returns the time, s, until which a few samples from `time` on resolve the inputs. No step exceeds it; a longer
    /// step could miss a short pulse.
    fn seen_until(&self, time: f64) -> f64 {
        let _ = time;
        f64::INFINITY
    }

    /// Returns the time, s, until which the inputs are known. Steps end there. By default it is infinite.
    fn known_until(&self) -> f64 {
        f64::INFINITY
    }

    /// Receives the time, s, at which a step begins. Inputs whose value depends on earlier evaluations must start from
    /// their state at this time in every evaluation until the next step begins.
    fn begin_step(&mut self, time: f64) {
        let _ = time;
    }

    /// Updates sampled inputs. The simulation calls it once at the start and at each [`Self::next_change`].
    fn change(&mut self, view: &View<'_>) {
        let _ = view;
    }
}

/// Constant efforts, N or N m, in the order of [`Mechanism::actuators`], without loads. Actuators beyond the end of the
/// list exert no effort.
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
