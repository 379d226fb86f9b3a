//! Interpolation of results within the last step.
//!
//! Step sizes depend only on the mechanism and its inputs, never on the times for which results are
//! requested. Results within a step are interpolated.

use super::checkpoint::Tape;
use super::{Energies, Simulation};
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
        // If the mechanism has not moved and no mode has changed, the factorised constraints of the
        // previous request remain valid.
        copy.workspace.conditions_hold &= was_alike && is_alike(copy);
        copy.workspace.loads.clear();
        copy.update_slip_directions();
        let from = copy.now.time;
        let mut y = copy.list();
        match interpolation {
            Interpolation::Chord => {
                copy.between_ends(self, time, inputs)?;
                copy.modes.clone_from(&self.modes);
                copy.stepping.clone_from(&self.stepping);
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
                let is_prepared = std::mem::take(has_curve);
                let crosses = *crosses;
                if !is_prepared {
                    copy.steps.copy_from(&self.steps);
                }
                match copy.on_curve(time, (from, is_prepared, crosses), &mut y, inputs) {
                    Ok(()) => self.last_step.has_curve = true,
                    Err(_) => {
                        copy.take_state(&self.last_step.numbers);
                        copy.between_ends(self, time, inputs)?;
                    }
                }
            }
        }
        copy.lists.push(y);
        copy.count_turns();
        Ok(())
    }

    /// Prepares the dense output of a step that began at `from`, s, with the stick-slip modes of
    /// this step.
    fn prepare_curve(&mut self, from: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
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

    /// Interpolates within an event-driven step by the dense output of the integrator, and evaluates
    /// accelerations and reactions there. Uses `y` as a buffer.
    fn on_curve(
        &mut self,
        time: f64,
        (from, is_prepared, crosses): (f64, bool, bool),
        y: &mut Vec<f64>,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        if !is_prepared {
            self.workspace.crosses = crosses.then_some(0.0);
            self.prepare_curve(from, inputs)?;
            // Newton's method then starts from the same normal loads for every instant of the step.
            self.workspace.loads.clear();
        }
        self.workspace.crosses = crosses.then_some(0.0);
        let part = (time - from) / self.steps.step;
        self.steps.at(part, y);
        let arrived = match crosses {
            true => self.arrive_beside(time, part, y, inputs)?,
            false => self.arrive(time, y, inputs)?,
        };
        self.commit(y, arrived);
        Ok(())
    }

    /// Interpolates between the ends of a step: `self` is at its start, and becomes the results at
    /// `time`, s. Accelerations and reactions are those of the end, `end`. This serves time steps, whose
    /// accelerations and reactions are means, and event-driven steps with instants at which no
    /// accelerations are found: near the end of a branch of solutions, those of the step's stages are
    /// found from each other only.
    fn between_ends(
        &mut self,
        end: &Simulation<'a>,
        time: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let span = end.now.time - self.now.time;
        let part = (time - self.now.time) / span;
        let instant = self.blended(time, part, end, inputs)?;
        self.energies.blend(&end.energies, &end.now.account, (part, span));
        let values = self.input.values.iter_mut().zip(&end.input.values);
        values.for_each(|(value, end)| *value += part * (end - *value));
        self.become_now(instant);
        Ok(())
    }

    /// Returns the results at the fraction `part` of the step from `self` to `end`. In time steps the
    /// rates change linearly; otherwise their curve has the accelerations of both ends.
    fn blended(
        &self,
        time: f64,
        part: f64,
        end: &Simulation<'a>,
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        let (model, from, to) = (self.model, &self.now.state, &end.now.state);
        let span = end.now.time - self.now.time;
        let mut state = from.clone();
        // What the rates of a cubic curve deviate from linear ones, as multiples of the accelerations
        // at both ends less the mean acceleration, and the integrals of these deviations.
        let rest = 1.0 - part;
        let bends = match end.last_step.interpolation {
            Interpolation::Chord => [[0.0; 2]; 2],
            _ => [
                [part * rest * rest, part * part * (0.5 - part * (2.0 / 3.0 - 0.25 * part))],
                [-part * part * rest, -part * part * part * (1.0 / 3.0 - 0.25 * part)],
            ],
        };
        let mut by = vec![0.0; from.rates.len()];
        for (k, by) in by.iter_mut().enumerate() {
            let (v, w) = (from.rates[k], to.rates[k]);
            let beyond = [from, to].map(|end| span * end.accelerations[k] - (w - v));
            let bend = |i: usize| beyond[0] * bends[0][i] + beyond[1] * bends[1][i];
            *by = span * (part * (v + 0.5 * part * (w - v)) + bend(1));
            state.rates[k] = v + part * (w - v) + bend(0);
        }
        state.advance(&model.topology, &by);
        state.accelerations.clone_from(&to.accelerations);
        let moves = |state: &State<f64>| state.rates.iter().any(|rate| *rate != 0.0);
        if moves(from) || moves(to) {
            let targets = model.targets(time, inputs);
            // Interfaces that begin to stick at the end of the step still move within the step.
            let (anchors, frozen) = self.places_of(&self.modes, &end.modes);
            model.project(time, &mut state, &targets, &anchors, &frozen)?;
        }
        let data = model.data(
            time,
            state,
            &end.bristles,
            &FrictionDistribution::default(),
            (&self.input, inputs),
        );
        let mut instant = Instant { time, state: data.state.clone(), ..end.now.clone() };
        instant.bodies = data.bodies.clone();
        instant.bodies.accelerate(&model.topology, &instant.state.accelerations);
        for (interface, velocity) in instant.interfaces.iter_mut().zip(&data.velocities) {
            interface.velocity = *velocity;
        }
        let acting = (&data.masses, &data.loads[..]);
        let Instant { account, bodies, drives, interfaces, .. } = &mut instant;
        account.update(model, acting, bodies, drives, interfaces);
        Ok(instant)
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
