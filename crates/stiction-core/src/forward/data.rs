//! Quantities at one instant that do not depend on the stick-slip modes of the interfaces.

use super::Forward;
use super::inputs::{InputState, Inputs, View};
use super::mass_matrix::MassMatrix;
use super::recorded::surface_velocities;
use crate::friction_problem::normal_load::Configuration;
use crate::kinematics::{Bodies, State, Target};
use crate::spatial::Twist;
use crate::statics::AppliedLoad;

/// Configuration, velocity and inputs at one instant, and quantities that depend only on these.
#[derive(Clone, Debug)]
pub(super) struct Data {
    /// Time, s.
    pub(super) time: f64,
    pub(super) state: State<f64>,
    pub(super) bodies: Bodies<f64>,
    pub(super) masses: MassMatrix,
    /// Effort of each actuator, N or N m; zero for actuators with prescribed motion.
    pub(super) efforts: Vec<f64>,
    pub(super) loads: Vec<AppliedLoad<f64>>,
    /// Target coordinates, rates and accelerations of the actuators with prescribed motion.
    pub(super) targets: Vec<Target<f64>>,
    /// Sliding velocity at the surface of each interface along each of its DOFs, m/s.
    pub(super) velocities: Vec<[f64; 3]>,
    /// Bristle deflection of each interface along each of its DOFs, m.
    pub(super) bristles: Vec<[f64; 3]>,
    /// State of the inputs: internal states, signs of the switching functions, unwrapped angles.
    pub(super) input: InputState,
    /// Rates of the internal states of the inputs, per second.
    pub(super) input_rates: Vec<f64>,
    pub(super) distribution: FrictionDistribution,
    /// Factor by which static friction may exceed its limit. The factor exceeds one only in a mode
    /// search that tolerates a small excess of statically indeterminate frictions.
    pub(super) limit_factor: f64,
}

/// Rule that distributes statically indeterminate static frictions. It stays constant while the
/// modes stay the same.
#[derive(Debug, Default, PartialEq)]
pub(super) struct FrictionDistribution {
    /// Estimated friction limit of each interface relative to the largest of these limits.
    /// Frictions are distributed relative to these limits.
    pub(super) scales: Vec<f64>,
    /// Reference static friction of each interface at the surface, N. Frictions deviate from their
    /// references as little as possible.
    pub(super) reference_frictions: Vec<[f64; 3]>,
    /// Weight of the reactions in the sum of frictions that is minimised; zero except close to
    /// singular positions, see [`Forward::limit_preload`].
    pub(super) reaction_weight: f64,
    /// Reference reactions: force, N, and moment divided by the characteristic length, N, in the
    /// axes of each joint, six numbers for each joint. Reactions deviate from them as little as
    /// possible if the weight of the reactions is not zero. An empty list means zero.
    pub(super) reference_reactions: Vec<f64>,
}

impl Clone for FrictionDistribution {
    fn clone(&self) -> Self {
        let Self { scales, reference_frictions, reaction_weight, reference_reactions } = self;
        Self {
            scales: scales.clone(),
            reference_frictions: reference_frictions.clone(),
            reaction_weight: *reaction_weight,
            reference_reactions: reference_reactions.clone(),
        }
    }

    /// Copies another distribution, reusing the buffers.
    fn clone_from(&mut self, other: &Self) {
        self.scales.clone_from(&other.scales);
        self.reference_frictions.clone_from(&other.reference_frictions);
        self.reaction_weight = other.reaction_weight;
        self.reference_reactions.clone_from(&other.reference_reactions);
    }
}

/// Static frictions of a mechanism at rest, and the reactions that act together with them.
#[derive(Debug)]
pub(super) struct KnownForces {
    /// Friction of each interface at the surface, N.
    pub(super) frictions: Vec<[f64; 3]>,
    /// Reactions, see [`FrictionDistribution::reference_reactions`].
    pub(super) reactions: Vec<f64>,
}

impl FrictionDistribution {
    /// Distributes frictions evenly among `count` interfaces.
    pub(super) fn even(count: usize) -> Self {
        Self {
            scales: vec![1.0; count],
            reference_frictions: vec![[0.0; 3]; count],
            ..Self::default()
        }
    }

    /// Makes forces the references. `weight` is the weight of the reactions.
    pub(super) fn refer_to(&mut self, forces: &KnownForces, weight: f64) {
        self.reference_frictions.clone_from(&forces.frictions);
        self.reaction_weight = weight;
        self.reference_reactions.clear();
        if weight > 0.0 {
            self.reference_reactions.extend_from_slice(&forces.reactions);
        }
    }

    /// Makes zero the reference of frictions again, without reactions.
    pub(super) fn refer_to_zero(&mut self) {
        self.reference_frictions.fill([0.0; 3]);
        self.reaction_weight = 0.0;
        self.reference_reactions.clear();
    }
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
            distribution: FrictionDistribution::default(),
            limit_factor: 1.0,
        }
    }
}

impl Forward {
    /// Computes the data at a time, s, from the state of the mechanism and the inputs.
    pub(super) fn data(
        &self,
        time: f64,
        state: State<f64>,
        bristles: &[[f64; 3]],
        distribution: &FrictionDistribution,
        (input, inputs): (&InputState, &mut dyn Inputs),
    ) -> Data {
        let mut data = Data { time, state, input: input.clone(), ..Data::new(self) };
        data.bristles.extend_from_slice(bristles);
        data.distribution.clone_from(distribution);
        self.update_data(&mut data, inputs);
        data
    }

    /// Recomputes the data in place from the time, state, bristle deflections, input states
    /// and distribution of static frictions stored in `data`.
    pub(super) fn update_data(&self, data: &mut Data, inputs: &mut dyn Inputs) {
        self.move_bodies(data);
        self.update_inputs(data, inputs);
        self.update_masses(data);
    }

    /// Recomputes inertias and bias forces for the motion and loads in `data`.
    pub(super) fn update_masses(&self, data: &mut Data) {
        let Data { bodies, masses, loads, .. } = data;
        masses.update(&self.topology, (&self.parameters, &self.rotors), bodies, loads);
    }

    /// Computes poses and twists of all bodies, and sliding velocities, at the state in `data`.
    pub(super) fn move_bodies(&self, data: &mut Data) {
        let Data { state, bodies, .. } = data;
        bodies.place(&self.topology, &self.parameters, &state.coordinates);
        self.move_placed_bodies(data);
    }

    /// Computes twists of all bodies, and sliding velocities, at the state in `data`, at whose
    /// coordinates the bodies are placed.
    pub(super) fn move_placed_bodies(&self, data: &mut Data) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Data { state, bodies, velocities, .. } = data;
        bodies.move_with(topology, &state.rates);
        velocities.clear();
        velocities.extend(surface_velocities(topology, parameters, bodies));
    }

    /// Evaluates the inputs for the motion in `data`.
    pub(super) fn update_inputs(&self, data: &mut Data, inputs: &mut dyn Inputs) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Data { time, state, bodies, efforts, loads, targets, input, input_rates, .. } = data;
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
        data.limit_factor = 1.0;
    }

    /// Returns the targets of the actuators with prescribed motion at a time, s.
    pub(super) fn targets(&self, time: f64, inputs: &mut dyn Inputs) -> Vec<Target<f64>> {
        let mut targets = Vec::new();
        self.targets_into(time, inputs, &mut targets);
        targets
    }

    /// Writes the targets of the actuators with prescribed motion at a time, s, reusing the buffer.
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

    /// Returns the parameters and body poses that determine the normal loads.
    pub(super) fn configuration<'a>(&'a self, data: &'a Data) -> Configuration<'a> {
        Configuration { parameters: &self.parameters, bodies: &data.bodies }
    }

    /// Returns the speed of a body, rad/s: the larger of its angular speed and its linear speed
    /// divided by the characteristic length.
    pub(super) fn twist_rate(&self, twist: &Twist<f64>) -> f64 {
        twist.angular.norm().max(twist.linear.norm() / self.parameters.length)
    }

    /// Returns the largest speed of any body, rad/s, as defined by [`Self::twist_rate`].
    pub(super) fn fastest(&self, data: &Data) -> f64 {
        data.bodies.twist.iter().map(|twist| self.twist_rate(twist)).fold(0.0, f64::max)
    }
}
