//! Choice between the event-driven and the time-stepping method by the computing work per second of
//! simulated time.
//!
//! Event-driven steps are short where stability limits them, near folds of the friction problem
//! (where two solutions merge and vanish), and where many interfaces change their modes. The
//! time-stepping method may then need far less work for its own tolerance. The decision is based on
//! a trial time step several times as long as the event-driven steps.

use super::method_change::{LONGEST_WAIT, QUIET};
use super::{Method, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::inputs::Inputs;

/// Work of the event-driven method, in evaluations of accelerations, after which the method is
/// compared with a trial step of the time-stepping method.
const WINDOW: usize = 2400;
/// Number of evaluations in a step of the event-driven method. A step of the time-stepping method,
/// including its two half steps, costs about the same.
const EVALUATIONS: f64 = 12.0;
/// Mean step size of the event-driven method, s, above which stability does not limit the steps.
/// Longer steps are limited by the motion, by its events or by a controller, which limit the
/// time-stepping method as well.
const SLOW: f64 = 2e-4;
/// Length of the trial step, as a multiple of the mean event-driven step. The simulation changes to
/// time stepping if the trial step meets its tolerance.
const PAYS: f64 = 3.0;
/// Number of continuation steps from zero friction that cost as much as one evaluation of
/// accelerations.
const CONTINUATION_STEPS: usize = 4;
/// Largest number of time steps without a stick-slip transition after which the event-driven method is
/// tried again if it was too costly.
const COSTLY_WAIT: usize = 512;
/// The event-driven method counts as recovered if its present phase lasts at least this many times
/// as long as the preceding phase of time stepping.
const RECOVERED: f64 = 10.0;

/// Work of the event-driven method, and durations of the phases of both methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Economy {
    /// Work since the start of the simulation, in evaluations of accelerations.
    pub(super) work: usize,
    /// Work (evaluations of accelerations) and time (s) at the start of the present comparison.
    pub(super) window: (usize, f64),
    /// Start time of the present phase and duration of the previous phase, s.
    pub(super) phase: (f64, f64),
}

impl Economy {
    /// Creates the record of work and phases for a simulation that starts at `time`, s.
    pub(super) fn new(time: f64) -> Self {
        Self { work: 0, window: (0, time), phase: (time, 0.0) }
    }

    /// Adds the work of one evaluation of accelerations that needed `continuation_steps`
    /// continuation steps from zero friction.
    pub(super) fn spend(&mut self, continuation_steps: usize) {
        self.work += 1 + continuation_steps / CONTINUATION_STEPS;
    }

    /// Records a change of the integration method at `time`, s.
    pub(super) fn change(&mut self, time: f64) {
        self.phase = (time, time - self.phase.0);
        self.window = (self.work, time);
    }
}

impl Simulation<'_> {
    /// Doubles the number of time steps without a stick-slip transition after which the simulation
    /// returns to the event-driven method. Resets this number if the event-driven method has lasted
    /// [`RECOVERED`] times as long as the preceding phase of time stepping.
    pub(super) fn wait_longer(&mut self) {
        let (began, stepped) = self.economy.phase;
        let recovered = self.now.time - began >= RECOVERED * stepped;
        self.wait = if recovered { QUIET } else { (2 * self.wait).min(LONGEST_WAIT) };
    }

    /// Doubles the same number, up to [`COSTLY_WAIT`], because the event-driven method is too costly. How
    /// long it has lasted does not count: the costs of the next phase will probably be alike.
    pub(super) fn wait_out_costs(&mut self) {
        self.wait = self.wait.max((2 * self.wait).min(COSTLY_WAIT));
    }

    /// Returns true if time stepping would advance faster than the event-driven method has done
    /// since the start of the comparison. Returns false until the comparison has accumulated enough
    /// work. `end` is the latest end of a trial step, s.
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

    /// Returns true if a trial step of the time-stepping method meets its tolerance. The length of
    /// the trial step is [`PAYS`] times the length `step`, s, of an event-driven step.
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
        // If the trial step has no solution, the event-driven method continues.
        let tried = self.two_halves(time, 0.5 * longer, &from, (&modes, &bristles), inputs);
        let Ok((whole, _, halves)) = tried else { return false };
        // A trial step with a stick-slip transition does not predict the steps before this
        // transition.
        let keeps = |after: &[InterfaceMode]| {
            let each = modes.iter().zip(after);
            each.into_iter().all(|(a, b)| std::mem::discriminant(a) == std::mem::discriminant(b))
        };
        keeps(&halves.time_step.modes) && self.apart(&whole, &halves, longer) <= 1.0
    }
}
