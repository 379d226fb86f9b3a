//! Changes between the event-driven and the time-stepping method.

use super::stepping::{FIRST, REFINEMENTS, Stepping};
use super::{Event, EventKind, Method, Simulation};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::project::YIELDS;

/// Initial and smallest number of time steps without a stick-slip transition after which the
/// simulation tries the event-driven method again.
pub(super) const QUIET: usize = 8;
/// Upper limit of the number of time steps without a stick-slip transition that must pass before
/// the event-driven method is tried again. The number doubles after each failure of the
/// event-driven method, up to this limit.
pub(super) const LONGEST_WAIT: usize = 4096;
/// Number of events after which their mean interval is compared with [`DENSE`].
const MANY: usize = 40;
/// Mean interval between events, s, below which the simulation changes to time stepping.
pub(super) const DENSE: f64 = 5e-5;

impl Simulation<'_> {
    /// Returns true if time stepping may continue the simulation after this error of the
    /// event-driven method. This is so in the automatic method if no accelerations or no modes were
    /// found, or if the steps have become too short: velocities at the end of a time step that
    /// satisfy all friction laws may still exist.
    pub(super) fn may_step(&self, error: &ForwardError) -> bool {
        self.settings.method == Method::Automatic
            && self.stepping.is_none()
            && is_without_acceleration(error)
    }

    /// Counts an event, and returns true if events are too frequent for the event-driven method.
    pub(super) fn is_dense(&mut self) -> bool {
        let (count, since) = self.event_rate;
        self.event_rate.0 += 1;
        if count < MANY {
            return false;
        }
        let time = self.now.time;
        self.event_rate = (0, time);
        self.settings.method == Method::Automatic && time - since < MANY as f64 * DENSE
    }

    /// Changes to the time-stepping method at the present instant.
    pub(super) fn begin_stepping(&mut self) {
        self.economy.change(self.now.time);
        let (wait, refinements) = (self.wait, REFINEMENTS);
        self.stepping = Some(Stepping { step: FIRST, quiet: 0, wait, refinements });
        let kind = EventKind::Method { method: Method::TimeStepping };
        self.events.push(Event { time: self.now.time, kind });
    }

    /// Returns to the event-driven method after enough steps without a stick-slip transition, if
    /// the event-driven method finds accelerations at the present instant.
    pub(super) fn leave_stepping(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let Some(stepping) = &self.stepping else { return Ok(()) };
        if self.settings.method != Method::Automatic {
            return Ok(());
        }
        let interfaces = &self.now.interfaces;
        let rests = self.is_at_rest(&self.now.state.rates, interfaces.iter().map(|c| c.velocity));
        // At rest accelerations may exist that did not exist before, and steps are long. After a phase
        // of the event-driven method that has failed almost at once, it would probably fail again.
        let is_early = stepping.quiet < stepping.wait;
        let failed_at_once = self.wait > QUIET && self.economy.phase.1 < DENSE;
        if is_early && !(rests && stepping.quiet == 1 && !failed_at_once) {
            return Ok(());
        }
        let last_step = std::mem::take(&mut self.last_step);
        let kept = self.clone();
        self.last_step = last_step;
        self.stepping = None;
        self.stalled = 0;
        self.event_rate = (0, self.now.time);
        self.step = 1e-4 * self.settings.longest_step.min(1.0);
        let known = rests.then(|| {
            let frictions = self.now.interfaces.iter().map(|c| c.friction).collect();
            self.model.known_forces(frictions, &self.now.bodies, &self.now.wrenches)
        });
        if self.decide(inputs, None, known).is_ok() {
            self.economy.change(self.now.time);
            let kind = EventKind::Method { method: Method::EventDriven };
            self.events.push(Event { time: self.now.time, kind });
            return Ok(());
        }
        let last_step = std::mem::take(&mut self.last_step);
        *self = kept;
        self.last_step = last_step;
        if let Some(stepping) = &mut self.stepping
            && !is_early
        {
            stepping.quiet = 0;
            stepping.wait = (2 * stepping.wait).min(LONGEST_WAIT);
        }
        Ok(())
    }
}

/// Returns true if an error of the event-driven method means that no accelerations that satisfy all
/// laws were found, or that the method could not continue the motion.
pub(super) fn is_without_acceleration(error: &ForwardError) -> bool {
    matches!(
        error,
        ForwardError::NoChoice { .. }
            | ForwardError::NoAcceleration { .. }
            | ForwardError::Stiff { .. }
            | ForwardError::Stalled { .. }
            // Near a singular configuration, the loops may require a change of the rates that
            // exceeds round-off.
            | ForwardError::Impact { by_loop: true, .. }
    )
    // Locks of sticking joints yield to the loops in time steps only.
    || matches!(error, ForwardError::Open { gap, .. } if *gap < YIELDS)
}
