//! Rest of the whole mechanism: time advances without integration as long as friction locks the
//! mechanism.

use super::Simulation;
use super::between::Interpolation;
use super::locate::{Ending, falls_below};
use super::scratch::Scratch;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::Instant;

/// Number of checks of the friction limits within an interval of the length of the longest step.
const SAMPLES: f64 = 4.0;

impl Simulation<'_> {
    /// Returns true if the whole mechanism is locked and no joint is prescribed.
    pub(super) fn is_still(&self) -> bool {
        self.model.prescribed.is_empty()
            && !self.frozen.is_empty()
            && self.frozen.iter().all(|frozen| *frozen)
    }

    /// Returns true if the mechanism is locked at rest and the inputs have no internal states, so
    /// that only time and forces change.
    pub(super) fn waits(&self) -> bool {
        self.is_still() && self.input.values.is_empty()
    }

    /// Advances to `end`, s, or to the next slip onset if that is earlier.
    pub(super) fn wait_through(
        &mut self,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let time = self.now.time;
        self.last_step.interpolation = Interpolation::Rest;
        if inputs.steady_until(time) >= end {
            // Constant inputs do not change any force.
            self.now.time = end;
            self.stalled = 0;
            return Ok(());
        }
        let count = ((end - time) * SAMPLES / self.settings.longest_step).ceil().max(1.0);
        let piece = (end - time) / count;
        let mut y = self.list();
        self.pack_into(&mut y);
        let mut before = (time, self.least_margin(&self.now).max(f64::MIN_POSITIVE));
        let mut ending = Ending::Smooth;
        while before.0 < end && matches!(ending, Ending::Smooth) {
            let most = piece.min(self.longest_step(before.0, inputs));
            let mut at = before.0 + most;
            if end - at < 0.01 * most {
                at = end;
            }
            let others = self.settings.look_for_others && at == end;
            let mut instant = self.watch(at, &y, others, inputs)?;
            let margin = self.least_margin(&instant);
            let fine = (4.0 * f64::EPSILON * at.abs()).max(1e-13 * (at - before.0));
            let slip_onset = falls_below(before, (at, margin), fine, |at| {
                let instant = self.watch(at, &y, false, inputs)?;
                let margin = self.least_margin(&instant);
                self.workspace.spare(instant);
                Ok(margin)
            })?;
            if let Some(slip_onset) = slip_onset {
                at = slip_onset;
                self.workspace.spare(instant);
                instant = self.watch(at, &y, self.settings.look_for_others, inputs)?;
                ending = Ending::SlipOnset;
            }
            before = (at, margin);
            self.become_now(instant);
        }
        self.lists.push(y);
        self.step = self.step.max(piece.min(self.settings.longest_step));
        self.follow_up(ending, time, inputs)
    }

    /// Evaluates accelerations and reactions at the time `time`, s, in the present configuration,
    /// which does not change during rest. Reuses the factorisation of the constraints if it is
    /// valid.
    pub(super) fn watch(
        &mut self,
        time: f64,
        y: &[f64],
        measure: bool,
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        if !self.workspace.conditions_hold {
            let instant = self.evaluate(time, y, inputs, measure)?;
            self.workspace.conditions_hold = true;
            return Ok(instant);
        }
        self.evaluations += 1;
        let model = self.model;
        if self.workspace.loads.is_empty() {
            self.start_near_present_loads();
        }
        let mut instant = self.workspace.instant(model);
        self.choose_load_iteration();
        let Scratch { situation, solved, loads, .. } = &mut *self.workspace;
        situation.time = time;
        situation.input.clone_from(&self.input);
        let states = y.len() - self.input.values.len();
        situation.input.values.copy_from_slice(&y[states..]);
        model.update_data(situation, inputs);
        let done = model.couple(situation, &self.modes, Some(loads.at(time)), measure, solved);
        // The computing work is counted as in `evaluate`, so that a simulation resumed from a
        // checkpoint counts the same work.
        self.economy.spend(solved.continuation_steps());
        done.map_err(|u| model.unsolved(time, u))?;
        model.instant_into(situation, &self.modes, solved, &mut instant);
        instant.state.accelerations.fill(0.0);
        match instant.nonfinite() {
            Some(what) => Err(ForwardError::NotFinite { time, what }),
            None => Ok(instant),
        }
    }
}
