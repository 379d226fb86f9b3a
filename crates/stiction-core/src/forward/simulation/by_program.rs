//! Evaluations by the recorded program of the model, where it is valid.

use super::Simulation;
use super::packing::parts;
use super::scratch::Scratch;
use super::step::NEAR_SINGULAR;
use crate::forward::affine_friction::norm;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::Instant;
use crate::forward::mass_matrix;
use crate::forward::recorded::all_slide;

impl Simulation<'_> {
    /// Computes the time derivative at a stage of a step by the recorded program. Returns false if
    /// the model has no program, or if the program is not valid there.
    pub(super) fn derivative_by_program(
        &mut self,
        time: f64,
        y: &[f64],
        rates: &mut Vec<f64>,
        inputs: &mut dyn Inputs,
    ) -> bool {
        let model = self.model;
        if !self.begin_by_program(time, y) {
            return false;
        }
        let Scratch { situation, program: Some(program), loads, .. } = &mut *self.workspace else {
            return false;
        };
        let found = model.solve_by_program(situation, &self.modes, program, inputs);
        let Some(mut results) = found else { return false };
        let (topology, parameters) = (&model.topology, &model.parameters);
        let state = &situation.state;
        rates.clear();
        rates.resize(state.coordinates.len(), 0.0);
        model.coordinate_rates(&state.coordinates, &state.rates, rates);
        let accelerations = results.take(state.rates.len());
        if !accelerations.iter().all(|a| a.is_finite()) {
            return false;
        }
        rates.extend_from_slice(accelerations);
        loads.add(time, results.take(self.modes.len()));
        // Sliding interfaces have no bristles.
        rates.extend(self.modes.iter().flat_map(|_| [0.0; 3]));
        let bodies = &situation.bodies;
        let drives = topology.actuators.iter().zip(&situation.efforts);
        let first = rates.len();
        rates.extend(drives.map(|(a, effort)| effort * bodies.actuator_rate(topology, *a)));
        rates.push(mass_matrix::power_of_loads(&situation.loads, bodies));
        rates.push(mass_matrix::damped(parameters, bodies));
        let turnover = rates.len();
        rates.push(0.0);
        let frictions = results.take(self.modes.len()).iter().zip(&situation.velocities);
        rates.extend(frictions.map(|(friction, velocity)| friction * norm(*velocity)));
        let powers = rates[first..].iter().map(|power| power.abs()).sum::<f64>();
        rates[turnover] = powers + mass_matrix::exchange(parameters, bodies).abs();
        rates.extend_from_slice(&situation.input_rates);
        self.count_evaluation();
        true
    }

    /// Evaluates accelerations and reactions at a state that closes the loops: by the recorded
    /// program if it is valid there, otherwise by the general solver, which also computes the
    /// uniqueness bound if `measure`. `distance` is the singularity index of the loops there; `None`
    /// if it is not known, or if constraints are redundant.
    ///
    /// # Errors
    /// See [`Self::evaluate`].
    pub(super) fn evaluate_at(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
        (measure, distance): (bool, Option<f64>),
    ) -> Result<Instant, ForwardError> {
        let distance = distance.filter(|_| !measure);
        match self.evaluate_by_program(time, y, inputs, distance) {
            Some(instant) => Ok(instant),
            None => self.evaluate(time, y, inputs, measure),
        }
    }

    /// Evaluates by the recorded program as [`Self::evaluate_at`] does. Returns `None` if the model
    /// has no program, if the program is not valid there, or if its results do not satisfy all
    /// equations.
    fn evaluate_by_program(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
        distance: Option<f64>,
    ) -> Option<Instant> {
        let model = self.model;
        let distance = distance.filter(|distance| *distance >= NEAR_SINGULAR)?;
        if !self.begin_by_program(time, y) {
            return None;
        }
        let Scratch { situation, program: Some(program), .. } = &mut *self.workspace else {
            return None;
        };
        model.solve_by_program(situation, &self.modes, program, inputs)?;
        model.update_masses(situation);
        let mut instant = self.workspace.instant(model);
        let Scratch { situation, program: Some(program), .. } = &mut *self.workspace else {
            return None;
        };
        instant.distance = distance;
        let is_verified = model.instant_by_program(situation, &self.modes, program, &mut instant);
        if !is_verified || instant.nonfinite().is_some() {
            self.program_failed = true;
            self.workspace.spare(instant);
            return None;
        }
        self.count_evaluation();
        Some(instant)
    }

    /// Prepares an evaluation by the program. Returns false if there is no program, if it may not
    /// be used near the present state, or if the state is not finite.
    fn begin_by_program(&mut self, time: f64, y: &[f64]) -> bool {
        // Where several normal loads satisfy the friction laws, only the general solver stays with
        // the present ones.
        let is_unique = self.now.coupling.is_some_and(|bound| bound < 1.0);
        let is_regular = self.now.redundant == 0 && self.now.distance >= NEAR_SINGULAR;
        let (coordinates, rates, rest) = parts(&self.now, y);
        let is_finite = coordinates.iter().chain(rates).all(|x| x.is_finite());
        let Some(recorded) = &self.model.recorded else { return false };
        let is_used = !self.program_failed && self.now.time >= recorded.from;
        if !is_used || !is_unique || !is_regular || !is_finite || !all_slide(&self.modes) {
            return false;
        }
        // Where only inputs have changed, the motion of the bodies is known.
        let Scratch { situation, is_placed, .. } = &*self.workspace;
        let is_known = *is_placed
            && situation.state.coordinates == coordinates
            && situation.state.rates == rates;
        self.set_situation(time, (coordinates, rates, rest));
        // The factorisation of the last evaluation belongs to another state.
        self.workspace.solved_modes.clear();
        self.workspace.conditions_hold = false;
        if !is_known {
            self.model.move_bodies(&mut self.workspace.situation);
            self.workspace.is_placed = true;
        }
        true
    }

    fn count_evaluation(&mut self) {
        self.evaluations += 1;
        self.economy.spend(0);
    }
}
