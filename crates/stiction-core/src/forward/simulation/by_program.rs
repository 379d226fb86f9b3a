//! Evaluations by the recorded program of the model, where it is valid.

use super::Simulation;
use super::packing::{append_powers, parts};
use super::scratch::Scratch;
use super::step::NEAR_SINGULAR;
use crate::forward::affine_friction::{InterfaceMode, dot, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::Instant;
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
        // Inputs that only change at samples are those of the last evaluation, and the program
        // needs no poses of the bodies.
        if !(self.workspace.knows_inputs && inputs.are_constant()) {
            self.update_inputs(inputs);
        }
        let Scratch { situation, program: Some(program), loads, least_speeds, .. } =
            &mut *self.workspace
        else {
            return false;
        };
        let found = model.solve_by_program(situation, &self.modes, program);
        let Some(results) = found else { return false };
        let state = &situation.state;
        rates.clear();
        rates.resize(state.coordinates.len(), 0.0);
        model.coordinate_rates(&state.coordinates, &state.rates, rates);
        rates.extend_from_slice(results.accelerations);
        loads.add(time, results.loads);
        for ((least, velocity), mode) in
            least_speeds.iter_mut().zip(results.velocities).zip(&self.modes)
        {
            if let InterfaceMode::Slides(direction) = mode {
                *least = least.min(dot(*velocity, *direction));
            }
        }
        // Sliding interfaces have no bristles.
        rates.extend(self.modes.iter().flat_map(|_| [0.0; 3]));
        let drives = results.actuator_rates.iter().zip(&situation.efforts).map(|(r, e)| r * e);
        let frictions = results.frictions.iter().zip(results.velocities);
        let interfaces = frictions.map(|(friction, velocity)| friction * norm(*velocity));
        append_powers(drives, results.powers, interfaces, rates);
        rates.extend_from_slice(&situation.input_rates);
        self.count_evaluation();
        true
    }

    /// Evaluates accelerations and reactions at a state that closes the loops: by the recorded
    /// program if it is valid there, otherwise by the general solver, which also computes the
    /// uniqueness bound if `measure`. `distance` is the singularity index of the loops there;
    /// `None` if it is not known, or if constraints are redundant.
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
        self.update_inputs(inputs);
        let Scratch { situation, has_masses, mass_loads, program: Some(program), .. } =
            &mut *self.workspace
        else {
            return None;
        };
        model.solve_by_program(situation, &self.modes, program)?;
        if !*has_masses || *mass_loads != situation.loads {
            model.update_masses(situation);
            mass_loads.clone_from(&situation.loads);
            *has_masses = true;
        }
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
        self.set_situation(time, (coordinates, rates, rest));
        // The factorisation of the last evaluation belongs to another state.
        self.workspace.solved_modes.clear();
        self.workspace.conditions_hold = false;
        true
    }

    /// Evaluates the inputs for the state of the next evaluation, and moves the bodies there.
    fn update_inputs(&mut self, inputs: &mut dyn Inputs) {
        let Scratch { situation, is_placed, has_masses, knows_inputs, .. } = &mut *self.workspace;
        if !*is_placed {
            self.model.move_bodies(situation);
            *has_masses = false;
        }
        self.model.update_inputs(situation, inputs);
        (*is_placed, *knows_inputs) = (true, true);
    }

    fn count_evaluation(&mut self) {
        self.evaluations += 1;
        self.economy.spend(0);
    }
}
