//! Quantities at an instant that do not depend on the modes of the interfaces.

use super::Forward;
use super::inputs::{InputState, Inputs, View};
use super::mass_matrix::MassMatrix;
use crate::friction_problem::normal_load::Configuration;
use crate::kinematics::{Bodies, State, Target};
use crate::spatial::Twist;
use crate::statics::AppliedLoad;

/// Position, velocity and inputs at an instant, and quantities that depend on them alone.
#[derive(Clone, Debug)]
pub(super) struct Data {
    /// Time, s.
    pub(super) time: f64,
    pub(super) state: State<f64>,
    pub(super) bodies: Bodies<f64>,
    pub(super) masses: MassMatrix,
    /// Effort of each actuator, N or N m; zero for prescribed ones.
    pub(super) efforts: Vec<f64>,
    pub(super) loads: Vec<AppliedLoad<f64>>,
    /// Targets of the prescribed actuators.
    pub(super) targets: Vec<Target<f64>>,
    /// Surface velocity of each interface, m/s.
    pub(super) velocities: Vec<[f64; 3]>,
    /// Bristle deflections of each interface, m.
    pub(super) bristles: Vec<[f64; 3]>,
    /// State of the inputs: internal states, sides of the switching functions, counted angles.
    pub(super) input: InputState,
    /// Rates of the internal states of the inputs, per second.
    pub(super) input_rates: Vec<f64>,
    /// Estimated friction limit of each interface relative to the largest: the scale of statically indeterminate static
    /// frictions. Stays constant while the modes stay the same.
    pub(super) friction_scales: Vec<f64>,
    /// Reference static friction of each interface, N: statically indeterminate frictions deviate
    /// from it as little as possible.
    pub(super) reference_frictions: Vec<[f64; 3]>,
    /// Factor by which static friction may exceed its limit; one except in a search that allows for statically
    /// indeterminate frictions.
    pub(super) limit_factor: f64,
}

impl Data {
    /// Allocates the data of a model; all quantities are empty or zero.
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            time: 0.0,
            state: State::new(&model.topology),
            bodies: Bodies::new(&model.topology),
            masses: MassMatrix::default(),
            efforts: Vec::new(),
            loads: Vec::new(),
            targets: Vec::new(),
            velocities: Vec::new(),
            bristles: Vec::new(),
            input: InputState::default(),
            input_rates: Vec::new(),
            friction_scales: Vec::new(),
            reference_frictions: Vec::new(),
            limit_factor: 1.0,
        }
    }
}

impl Forward {
    /// Computes the data at a time, s, from the state and the inputs.
    pub(super) fn data(
        &self,
        time: f64,
        state: State<f64>,
        bristles: &[[f64; 3]],
        (friction_scales, reference_frictions): (&[f64], &[[f64; 3]]),
        (input, inputs): (&InputState, &mut dyn Inputs),
    ) -> Data {
        let mut data = Data { time, state, input: input.clone(), ..Data::new(self) };
        data.bristles.extend_from_slice(bristles);
        data.friction_scales.extend_from_slice(friction_scales);
        data.reference_frictions.extend_from_slice(reference_frictions);
        self.update_data(&mut data, inputs);
        data
    }

    /// Recomputes the data in place. Uses the values that `data` holds for time, state, bristles, states of the inputs,
    /// friction scales and reference frictions.
    pub(super) fn update_data(&self, data: &mut Data, inputs: &mut dyn Inputs) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Data {
            time,
            state,
            bodies,
            masses,
            efforts,
            loads,
            targets,
            velocities,
            input,
            input_rates,
            ..
        } = data;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let pitch = &parameters.pitch;
        let view = View { time: *time, state, bodies, topology, parameters, input };
        efforts.clear();
        efforts.resize(topology.actuators.len(), 0.0);
        inputs.efforts(&view, efforts);
        loads.clear();
        inputs.loads(&view, loads);
        input_rates.clear();
        input_rates.resize(input.values.len(), 0.0);
        inputs.state_rates(&view, input_rates);
        self.targets_into(*time, inputs, targets);
        for &actuator in &self.prescribed {
            efforts[actuator] = 0.0;
        }
        masses.update(topology, (parameters, &self.rotors), bodies, loads);
        velocities.clear();
        let interfaces = parameters.interfaces.iter();
        velocities.extend(interfaces.map(|c| bodies.surface_velocity(topology, c, pitch[c.joint])));
        data.limit_factor = 1.0;
    }

    /// Targets of the prescribed actuators at a time, s.
    pub(super) fn targets(&self, time: f64, inputs: &mut dyn Inputs) -> Vec<Target<f64>> {
        let mut targets = Vec::new();
        self.targets_into(time, inputs, &mut targets);
        targets
    }

    /// Writes the targets of the prescribed actuators at a time, s, reusing the buffer.
    pub(super) fn targets_into(
        &self,
        time: f64,
        inputs: &mut dyn Inputs,
        targets: &mut Vec<Target<f64>>,
    ) {
        let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        targets.clear();
        targets.resize(self.prescribed.len(), zero);
        inputs.targets(time, targets);
    }

    /// Returns the parameters and poses from which normal loads follow.
    pub(super) fn configuration<'a>(&'a self, data: &'a Data) -> Configuration<'a> {
        Configuration { parameters: &self.parameters, bodies: &data.bodies }
    }

    /// Speed of a body, rad/s: the larger of its angular velocity and its linear velocity over the characteristic
    /// length.
    pub(super) fn twist_rate(&self, twist: &Twist<f64>) -> f64 {
        twist.angular.norm().max(twist.linear.norm() / self.parameters.length)
    }

    /// Largest speed of any body, see [`Self::twist_rate`], rad/s.
    pub(super) fn fastest(&self, data: &Data) -> f64 {
        data.bodies.twist.iter().map(|twist| self.twist_rate(twist)).fold(0.0, f64::max)
    }
}
