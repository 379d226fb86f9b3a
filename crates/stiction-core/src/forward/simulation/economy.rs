//! Choice of the integration scheme by its work for each second of simulated time.
//!
//! Event-driven steps are short where stability bounds them, beside folds of the friction problem
//! and where many interfaces change their modes. Time stepping may then need far less work for its
//! own tolerance. A trial time step decides.

use super::stepping::{LONGEST_WAIT, QUIET};
use super::{Method, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::inputs::Inputs;

/// Work of the event-driven method, in evaluations of accelerations, after which its progress is
/// compared with that of time stepping.
const WINDOW: usize = 2400;
/// Evaluations in a step of the event-driven method. A time step, with its two halves, costs about
/// as many.
const EVALUATIONS: f64 = 12.0;
/// Longest mean step of the event-driven method that counts as slow, s. Longer ones are short because of the
/// motion, its events or a controller, not of stability.
const SLOW: f64 = 2e-4;
/// Time stepping takes over if a step that is longer by this factor keeps its tolerance.
const PAYS: f64 = 3.0;
/// Steps of the continuation from zero friction that cost as much as an evaluation.
const CONTINUATION_STEPS: usize = 4;
/// The event-driven method has recovered if it has covered this many times the time that was covered by time
/// stepping before.
const RECOVERED: f64 = 10.0;

/// Work of the event-driven method, and durations of the phases of both methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Economy {
    /// Work so far, in evaluations of accelerations.
    pub(super) work: usize,
    /// Work and time, s, at the start of the present comparison.
    pub(super) window: (usize, f64),
    /// Start of the present phase and duration of the one before, s.
    pub(super) phase: (f64, f64),
}

impl Economy {
    /// Economy of a simulation that starts at `time`, s.
    pub(super) fn new(time: f64) -> Self {
        Self { work: 0, window: (0, time), phase: (time, 0.0) }
    }

    /// Adds an evaluation of accelerations with this many steps of the continuation from zero
    /// friction.
    pub(super) fn spend(&mut self, continuation_steps: usize) {
        self.work += 1 + continuation_steps / CONTINUATION_STEPS;
    }

    /// Begins a phase of the other method.
    pub(super) fn change(&mut self, time: f64) {
        self.phase = (time, time - self.phase.0);
        self.window = (self.work, time);
    }
}

impl Simulation<'_> {
    /// Doubles the number of quiet time steps before the next return to the event-driven method, or
    /// resets it if that method has covered [`RECOVERED`] times the duration of the time stepping before.
    pub(super) fn wait_longer(&mut self) {
        let (began, stepped) = self.economy.phase;
        let recovered = self.now.time - began >= RECOVERED * stepped;
        self.wait = if recovered { QUIET } else { (2 * self.wait).min(LONGEST_WAIT) };
    }

    /// Returns whether time stepping would proceed faster than the event-driven method did in the
    /// present window, at its end.
    pub(super) fn is_costly(&mut self, end: f64, inputs: &mut dyn Inputs) -> bool {
        let time = self.now.time;
        let (work, since) = self.economy.window;
        let spent = self.economy.work - work;
        if spent < WINDOW {
            return false;
        }
        self.economy.window = (self.economy.work, time);
        let step = EVALUATIONS * (time - since) / spent as f64;
        step <= SLOW && self.pays_to_step(step, end, inputs)
    }

    /// Returns whether a time step much longer than a `step` of the event-driven method, s, keeps its
    /// tolerance.
    fn pays_to_step(&mut self, step: f64, end: f64, inputs: &mut dyn Inputs) -> bool {
        let time = self.now.time;
        let longer = PAYS * step;
        let possible = self.settings.method == Method::Automatic
            && self.has_friction()
            && self.stepping.is_none()
            && longer <= end - time
            && longer <= self.longest_step(time, inputs);
        if !possible {
            return false;
        }
        let from = self.now.state.clone();
        let (modes, bristles) = (self.modes.clone(), self.bristles.clone());
        // Without a solution the event-driven method stays.
        let tried = self.two_halves(time, 0.5 * longer, &from, (&modes, &bristles), inputs);
        let Ok((whole, _, halves)) = tried else { return false };
        // Beyond a change of mode the trial says nothing about the steps before it.
        let keeps = |after: &[InterfaceMode]| {
            let each = modes.iter().zip(after);
            each.into_iter().all(|(a, b)| std::mem::discriminant(a) == std::mem::discriminant(b))
        };
        keeps(&halves.time_step.modes) && self.apart(&whole, &halves, longer) <= 1.0
    }
}
