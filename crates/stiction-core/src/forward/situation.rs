//! What is the same for all choices of sticking and sliding: where the mechanism is, how it moves, what acts.

use super::Forward;
use super::balance::Scene;
use super::inputs::{Inputs, View};
use super::mass_matrix::MassMatrix;
use crate::kinematics::{Bodies, State, Target};
use crate::statics::AppliedLoad;

/// What is the same for all choices of sticking and sliding at one position and velocity.
#[derive(Clone, Debug)]
pub(super) struct Situation {
    pub(super) time: f64,
    pub(super) state: State<f64>,
    pub(super) bodies: Bodies<f64>,
    pub(super) masses: MassMatrix,
    pub(super) efforts: Vec<f64>,
    pub(super) loads: Vec<AppliedLoad<f64>>,
    pub(super) targets: Vec<Target<f64>>,
    pub(super) velocities: Vec<[f64; 3]>,
    pub(super) bristles: Vec<[f64; 3]>,
    /// The greatest friction of each contact, roughly: by it shares of friction are measured where they
    /// are not unique. They must not change while contacts do what they do.
    pub(super) grips: Vec<f64>,
    /// Frictions at the surface about which shares are least, N.
    pub(super) shares: Vec<[f64; 3]>,
    /// Friction that holds may exceed its limit by this factor; one but for rare moments.
    pub(super) overload: f64,
}

impl Situation {
    /// Room for it.
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
            grips: Vec::new(),
            shares: Vec::new(),
            overload: 1.0,
        }
    }
}

impl Forward {
    /// Positions, velocities and inputs of an instant.
    pub(super) fn situation(
        &self,
        time: f64,
        state: State<f64>,
        bristles: &[[f64; 3]],
        (grips, shares): (&[f64], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Situation {
        let mut situation = Situation { time, state, ..Situation::new(self) };
        situation.bristles.extend_from_slice(bristles);
        situation.grips.extend_from_slice(grips);
        situation.shares.extend_from_slice(shares);
        self.look(&mut situation, inputs);
        situation
    }

    /// The same in the room that is there, where time, state, bristles, grips and shares are.
    pub(super) fn look(&self, situation: &mut Situation, inputs: &mut dyn Inputs) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Situation { time, state, bodies, masses, efforts, loads, targets, velocities, .. } =
            situation;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let pitch = &parameters.pitch;
        let view = View { time: *time, state, bodies, topology, pitch, angles: &[] };
        efforts.clear();
        efforts.resize(topology.actuators.len(), 0.0);
        inputs.efforts(&view, efforts);
        loads.clear();
        inputs.loads(&view, loads);
        self.targets_into(*time, inputs, targets);
        for &actuator in &self.prescribed {
            efforts[actuator] = 0.0;
        }
        masses.update(topology, parameters, bodies, loads);
        velocities.clear();
        let interfaces = parameters.interfaces.iter();
        velocities.extend(interfaces.map(|c| bodies.surface_velocity(topology, c, pitch[c.joint])));
        situation.overload = 1.0;
    }

    pub(super) fn targets(&self, time: f64, inputs: &mut dyn Inputs) -> Vec<Target<f64>> {
        let mut targets = Vec::new();
        self.targets_into(time, inputs, &mut targets);
        targets
    }

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

    pub(super) fn scene<'a>(&'a self, situation: &'a Situation) -> Scene<'a> {
        Scene {
            topology: &self.topology,
            parameters: &self.parameters,
            bodies: &situation.bodies,
            masses: &situation.masses,
            columns: &self.columns,
        }
    }
}
