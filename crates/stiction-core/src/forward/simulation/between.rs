//! Interpolation of results within the last step.
//!
//! Step sizes depend only on the mechanism and its inputs, never on the times for which results are
//! requested. Results within a step are interpolated.

use super::checkpoint::Tape;
use super::method_change::is_without_acceleration;
use super::packing::parts;
use super::{Energies, REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::data::FrictionDistribution;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::{Account, Instant};
use crate::kinematics::State;

/// Type of interpolation within the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Interpolation {
    /// Dense output of the Runge-Kutta method, for an event-driven step.
    #[default]
    Curve,
    /// Extrapolation with the rates at the start of the step, for a short step at the end of which
    /// a plate or ball stops sliding.
    Line,
    /// Constant configuration, for a mechanism at rest under changing forces.
    Rest,
    /// Interpolation within a step of the time-stepping method, with linearly changing rates and
    /// constant mean forces.
    Chord,
}

/// Data for interpolation in the last step: the state at the start of the step, and a copy of the
/// simulation at a requested instant within the step.
#[derive(Clone, Debug, Default)]
pub(super) struct LastStep<'a> {
    /// State at the start of the step, in the format of [`Simulation::checkpoint`] without its
    /// first number.
    pub(super) numbers: Vec<f64>,
    /// Number of events before the step.
    pub(super) events: usize,
    pub(super) interpolation: Interpolation,
    /// True if the step crosses a singular configuration.
    pub(super) crosses: bool,
    /// Copy of the simulation with the state at the requested instant. The copy stays allocated
    /// between requests.
    copy: Option<Box<Simulation<'a>>>,
    /// True if the copy contains the dense output of this step.
    has_curve: bool,
    /// True if results are taken from the copy, false if they are those at the end of the step.
    pub(super) shows: bool,
}

/// To differentiate rates numerically at an instant, the rates are sampled at this distance before
/// and after the instant, as a fraction of the integration step.
const BESIDE: f64 = 1e-4;

impl<'a> Simulation<'a> {
    /// Saves the state at the start of a step.
    pub(super) fn begin_step(&mut self) {
        let mut numbers = std::mem::take(&mut self.last_step.numbers);
        numbers.clear();
        self.pass(&mut Tape::Out(&mut numbers));
        let events = self.events.len();
        let LastStep { numbers: kept, events: count, has_curve, shows, .. } = &mut self.last_step;
        (*kept, *count, *has_curve, *shows) = (numbers, events, false, false);
    }

    /// Returns the simulation at the requested instant: the copy for an instant within the last
    /// step, or `self` for the end of the step.
    pub(super) fn shown(&self) -> &Simulation<'a> {
        match &self.last_step.copy {
            Some(copy) if self.last_step.shows => copy,
            _ => self,
        }
    }

    /// Evaluates the results at `time`, s, within the last step.
    pub(super) fn show(&mut self, time: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let mut copy = match self.last_step.copy.take() {
            Some(copy) => copy,
            None => {
                let mut copy = Box::new(self.clone());
                copy.events = Vec::new();
                copy.last_step = LastStep::default();
                copy
            }
        };
        let done = self.copy_at(time, &mut copy, inputs);
        self.last_step.copy = Some(copy);
        self.last_step.shows = done.is_ok();
        done
    }

    /// Writes the state at `time`, s, within the last step to `copy`.
    fn copy_at(
        &mut self,
        time: f64,
        copy: &mut Simulation<'a>,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let LastStep { numbers, interpolation, crosses, has_curve, .. } = &mut self.last_step;
        copy.events.clear();
        let is_alike = |copy: &Self| {
            copy.now.state.coordinates == self.now.state.coordinates
                && copy.modes == self.modes
                && copy.distribution == self.distribution
        };
        let was_alike = is_alike(copy);
        copy.take_state(numbers);
        copy.workspace.knows_inputs = false;
        // If the mechanism has not moved and no mode has changed, the factorised constraints of the
        // previous request remain valid.
        copy.workspace.conditions_hold &= was_alike && is_alike(copy);
        copy.workspace.loads.clear();
        copy.update_slip_directions();
        let from = copy.now.time;
        let mut y = copy.list();
        match interpolation {
            Interpolation::Chord => {
                let part = (time - from) / (self.now.time - from);
                let instant = copy.on_chord(time, part, self, inputs)?;
                let span = self.now.time - from;
                copy.energies.blend(&self.energies, &self.now.account, (part, span));
                let values = copy.input.values.iter_mut().zip(&self.input.values);
                values.for_each(|(value, end)| *value += part * (end - *value));
                copy.modes.clone_from(&self.modes);
                copy.stepping.clone_from(&self.stepping);
                copy.become_now(instant);
            }
            Interpolation::Rest => {
                copy.pack_into(&mut y);
                let instant = copy.watch(time, &y, true, inputs)?;
                copy.become_now(instant);
                copy.still();
            }
            Interpolation::Line => {
                let mut rates = copy.list();
                copy.pack_into(&mut y);
                copy.derivative_into(&copy.now, &mut rates);
                y.iter_mut().zip(&rates).for_each(|(y, rate)| *y += (time - from) * rate);
                copy.lists.push(rates);
                let arrived = copy.arrive(time, &y, inputs)?;
                copy.commit(&y, arrived);
            }
            Interpolation::Curve => {
                let crosses = *crosses;
                if !*has_curve {
                    copy.steps.copy_from(&self.steps);
                    copy.workspace.crosses = crosses.then_some(0.0);
                    copy.prepare_curve(self, inputs)?;
                    self.last_step.has_curve = true;
                    // Newton's method then starts from the same normal loads for every instant of
                    // the step.
                    copy.workspace.loads.clear();
                }
                copy.workspace.crosses = crosses.then_some(0.0);
                let part = (time - from) / copy.steps.step;
                copy.steps.at(part, &mut y);
                let arrived = match crosses {
                    true => copy.arrive_beside(time, part, &y, inputs),
                    false => copy.arrive(time, &y, inputs),
                };
                let arrived = match arrived {
                    Err(error) if is_without_acceleration(&error) => {
                        copy.arrive_between(self, time, &y, inputs)?
                    }
                    other => other?,
                };
                copy.commit(&y, arrived);
            }
        }
        copy.lists.push(y);
        copy.count_turns();
        copy.show_onsets();
        Ok(())
    }

    /// Shows interfaces at their limit as sliding where they move: within the step that begins with
    /// the slip onset, which keeps the modes of its start.
    fn show_onsets(&mut self) {
        let rest = REST * self.fastest;
        for interface in &mut self.now.interfaces {
            if let InterfaceMode::AtLimit(direction) = interface.interface
                && norm(interface.velocity) > rest
            {
                interface.interface = InterfaceMode::Slides(direction);
            }
        }
    }

    /// Prepares the interpolation of the last step of `end`, at whose start `self` is, with the
    /// stick-slip modes of this step: the dense output of the integrator or, if no accelerations
    /// are found at one of its stages, a curve through both ends. Near the end of a branch of
    /// solutions, accelerations may be found at the end of the step only from those before it.
    fn prepare_curve(
        &mut self,
        end: &Simulation<'a>,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let prepared = self.prepare_dense_output(inputs);
        if !prepared.as_ref().is_err_and(is_without_acceleration) {
            return prepared;
        }
        let mut last = self.list();
        let keeps_modes = end.modes == self.modes;
        if keeps_modes {
            self.derivative_into(&end.now, &mut last);
        }
        self.steps.join_ends(keeps_modes.then_some(&last));
        self.lists.push(last);
        Ok(())
    }

    /// Prepares the dense output of the step that begins at the present instant.
    fn prepare_dense_output(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let from = self.now.time;
        let mut end = self.list();
        end.clone_from(&self.steps.end);
        let arrived = self.arrive_with(from + self.steps.step, &end, inputs, false)?;
        let mut last = self.list();
        self.derivative_into(&arrived, &mut last);
        self.workspace.spare(arrived);
        let mut steps = std::mem::take(&mut self.steps);
        let prepared =
            steps.interpolate(from, &last, |t, y, rates| self.derivative(t, y, rates, inputs));
        self.steps = steps;
        self.lists.extend([last, end]);
        prepared
    }

    /// Returns the results at an instant of an event-driven step from `self` to `end` at which no
    /// accelerations are found: accelerations, reactions and frictions are those at the nearer end
    /// that has the modes of the step.
    fn arrive_between(
        &mut self,
        end: &Simulation<'a>,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        let mut moved = self.list();
        moved.extend_from_slice(y);
        self.onto_the_loops(time, &mut moved, inputs)?;
        let (coordinates, rates, _) = parts(&self.now, &moved);
        let is_late = 2.0 * (time - self.now.time) > end.now.time - self.now.time;
        let nearer = if is_late && end.modes == self.modes { end } else { &*self };
        let mut state = nearer.now.state.clone();
        state.coordinates.copy_from_slice(coordinates);
        state.rates.copy_from_slice(rates);
        let instant = self.with_forces_of(&nearer.now, (time, state), &self.bristles, inputs);
        self.lists.push(moved);
        Ok(instant)
    }

    /// Evaluates the results at the fraction `part` of a step across a singular configuration. Near
    /// this configuration the loop constraints determine the accelerations only with large
    /// round-off, so the accelerations are derivatives of the interpolated rates.
    fn arrive_beside(
        &mut self,
        time: f64,
        part: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        let mut instant = self.evaluate(time, y, inputs, false)?;
        if self.is_resolved_at(instant.distance) {
            return self.arrive(time, y, inputs);
        }
        let (mut before, mut after) = (self.list(), self.list());
        self.steps.at(part - BESIDE, &mut before);
        self.steps.at(part + BESIDE, &mut after);
        let first = instant.state.coordinates.len();
        let span = 2.0 * BESIDE * self.steps.step;
        for (k, acceleration) in instant.state.accelerations.iter_mut().enumerate() {
            *acceleration = (after[first + k] - before[first + k]) / span;
        }
        self.lists.extend([before, after]);
        let topology = &self.model.topology;
        instant.bodies.accelerate(topology, &instant.state.accelerations);
        Ok(instant)
    }

    /// Interpolates within a step of the time-stepping method: returns the results at the fraction
    /// `part` of the step from `self` to `end`.
    fn on_chord(
        &self,
        time: f64,
        part: f64,
        end: &Simulation<'a>,
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        let (model, to) = (self.model, &end.now);
        let span = to.time - self.now.time;
        let mut state = self.now.state.clone();
        let passed = part * span;
        let by: Vec<f64> = state
            .rates
            .iter()
            .zip(&to.state.rates)
            .map(|(v, w)| passed * (v + 0.5 * part * (w - v)))
            .collect();
        state.advance(&model.topology, &by);
        state.rates.iter_mut().zip(&to.state.rates).for_each(|(a, b)| *a += part * (b - *a));
        state.accelerations.clone_from(&to.state.accelerations);
        let moves = |state: &State<f64>| state.rates.iter().any(|rate| *rate != 0.0);
        if moves(&self.now.state) || moves(&to.state) {
            let targets = model.targets(time, inputs);
            // Interfaces that begin to stick at the end of the step still move within the step.
            let (anchors, frozen) = self.places_of(&self.modes, &end.modes);
            model.project(time, &mut state, &targets, &anchors, &frozen)?;
        }
        Ok(self.with_forces_of(to, (time, state), &end.bristles, inputs))
    }

    /// Returns the results at `time`, s, with the given state, and with the accelerations,
    /// reactions and frictions of another instant.
    fn with_forces_of(
        &self,
        forces: &Instant,
        (time, state): (f64, State<f64>),
        bristles: &[[f64; 3]],
        inputs: &mut dyn Inputs,
    ) -> Instant {
        let model = self.model;
        let distribution = FrictionDistribution::default();
        let data = model.data(time, state, bristles, &distribution, (&self.input, inputs));
        let mut instant = Instant { time, state: data.state.clone(), ..forces.clone() };
        instant.bodies = data.bodies.clone();
        instant.bodies.accelerate(&model.topology, &instant.state.accelerations);
        for (interface, velocity) in instant.interfaces.iter_mut().zip(&data.velocities) {
            interface.velocity = *velocity;
        }
        let acting = (&data.masses, &data.loads[..]);
        let Instant { account, bodies, drives, interfaces, .. } = &mut instant;
        account.update(model, acting, bodies, drives, interfaces);
        instant
    }
}

impl Energies {
    /// Adds the work in the fraction `part` of a step of the time-stepping method. `to` contains
    /// the energies at the end of the step, and `span` is the length of the step, s. `account`
    /// contains the powers at the end of the step; powers change linearly over the step.
    fn blend(&mut self, to: &Self, account: &Account, (part, span): (f64, f64)) {
        let between = |a: &mut f64, b: &f64, power: &f64| {
            let all = b - *a;
            // The mean force of a velocity jump does no work after the jump. The work per step at
            // the final power is therefore limited to between zero and twice the work in this step.
            let last = (span * power).clamp((2.0 * all).min(0.0), (2.0 * all).max(0.0));
            *a += part * (2.0 * all - last + part * (last - all));
        };
        let each = |a: &mut [f64], b: &[f64], powers: &[f64]| {
            a.iter_mut().zip(b).zip(powers).for_each(|((a, b), power)| between(a, b, power));
        };
        each(&mut self.drives, &to.drives, &account.drives);
        each(&mut self.interfaces, &to.interfaces, &account.interfaces);
        between(&mut self.loads, &to.loads, &account.loads);
        between(&mut self.dampers, &to.dampers, &account.dampers);
        self.turnover += part * (to.turnover - self.turnover);
    }
}
