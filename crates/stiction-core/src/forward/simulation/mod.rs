//! Simulation of a mechanism over time: steps, events and energy balance.

mod abrupt;
mod between;
mod checkpoint;
mod decide;
mod driven;
mod economy;
mod energies;
mod event;
mod input_change;
mod linearisation;
mod locate;
mod locking;
mod others;
mod packing;
mod passage;
mod payload;
mod prescribed;
mod ranks;
mod rest;
mod runaway;
mod scratch;
mod settings;
mod singular;
mod start;
mod step;
mod stepping;
mod switching;
mod turns;
mod wait;

pub use checkpoint::Checkpoint;
pub use energies::Energies;
pub use event::{Event, EventKind, RateJump};
pub use linearisation::{Linearisation, LinearisationError};
pub use payload::PayloadChange;
pub use settings::{Method, Settings};

use super::Forward;
use super::error::ForwardError;
use super::inputs::{InputState, Inputs};
use super::integrator::Steps;
use super::project::Anchor;
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::instant::Instant;
use between::LastStep;
use economy::Economy;
use scratch::Scratch;

/// Friction interfaces count as at rest if they are slower than this fraction of the largest slip
/// speed.
const REST: f64 = 1e-10;

/// Number of evaluations after which progress is checked. The simulation stalls if time has
/// advanced by less than [`LEAST_PROGRESS`] of the longest step during these evaluations.
const PATIENCE: usize = 5_000;
/// Least advance of time during [`PATIENCE`] evaluations, as a fraction of the longest step.
const LEAST_PROGRESS: f64 = 1e-3;

/// Simulation of a mechanism over time, see [`Forward::start`].
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    model: &'a Forward,
    settings: Settings,
    now: Instant,
    modes: Vec<InterfaceMode>,
    anchors: Vec<Anchor>,
    frozen: Vec<bool>,
    bristles: Vec<[f64; 3]>,
    friction_scales: Vec<f64>,
    reference_frictions: Vec<[f64; 3]>,
    limit_factor: f64,
    /// Internal states of the inputs, sides of their switching functions, and counted angles.
    input: InputState,
    /// Time, s, at which switching functions change their sign; infinite if no change was found in
    /// the last step.
    switch_at: f64,
    /// Flag for each switching function: true if it changes its sign at `switch_at`.
    switching: Vec<bool>,
    /// Number of sign changes of switching functions at one time, and this time, s.
    switches_at_once: (usize, f64),
    /// Start, s, of the time step that was last shortened because of a switching function.
    shortened_at: f64,
    /// Number of changes of sides in quick succession, and the times of the first and the last of them, s.
    chatter: (usize, f64, f64),
    /// Switching function that has ended the simulation, if any.
    ended_by: Option<usize>,
    energies: Energies,
    energy_at_start: f64,
    fastest: f64,
    /// Largest rate of the tree so far, rad/s or characteristic lengths per second.
    fastest_rate: f64,
    /// Largest relative error of a step through a singular position, if above the tolerance; zero otherwise.
    coarsest: f64,
    step: f64,
    events: Vec<Event>,
    /// True if a singular position was reported and the mechanism is still near it.
    in_passage: bool,
    reported_others: bool,
    reported_shares: usize,
    /// Number of decisions between stick and slip since the last step without an event.
    stalled: usize,
    steps: Steps,
    scales: Vec<f64>,
    evaluations: usize,
    stepping: Option<stepping::Stepping>,
    /// Number of events counted for the event rate, and the time, s, at which the count began.
    event_rate: (usize, f64),
    dropped: f64,
    /// Number of steps bounded by stability since the last reset, and number of successive other
    /// steps, see `is_stiff`.
    stiff: (usize, usize),
    /// Number of very short steps in succession, see `is_stiff`.
    crawling: usize,
    /// Number of evaluations, and time in s, at the last check for a stall.
    progress: (usize, f64),
    /// Number of time steps without a change of mode after which the event-driven method is tried again.
    wait: usize,
    economy: Economy,
    workspace: Box<Scratch>,
    /// Unused lists of numbers, kept to reuse their memory.
    lists: Vec<Vec<f64>>,
    last_step: LastStep<'a>,
    /// Time of the next sampled change of the inputs, s; infinite if no change is left.
    change_at: f64,
}

impl<'a> Simulation<'a> {
    /// State, forces and energies at the present instant.
    pub fn instant(&self) -> &Instant {
        &self.shown().now
    }

    /// Returns whether the last solution of the accelerations was sparse.
    #[doc(hidden)]
    pub fn is_sparse(&self) -> bool {
        self.workspace.solved.balance.is_sparse()
    }

    /// Events since the start up to the present instant, in the order of time.
    pub fn events(&self) -> &[Event] {
        let time = self.instant().time;
        match self.last_step.shows {
            true => &self.events[..self.events.partition_point(|event| event.time <= time)],
            false => &self.events,
        }
    }

    /// Mode of each friction interface: stick, slip, or a smooth law.
    pub fn interfaces(&self) -> &[InterfaceMode] {
        &self.shown().modes
    }

    /// Relative change of the requested rates by the projection onto the constraints at the start.
    /// It exceeds rounding if loops, prescribed joints or locked joints do not allow the requested
    /// rates.
    pub fn dropped(&self) -> f64 {
        self.dropped
    }

    /// Largest estimated relative error of a step near a singular position of the loops, where rounding permits no
    /// smaller error; zero if all steps keep the tolerance.
    pub fn coarsest(&self) -> f64 {
        self.coarsest
    }

    /// Number of evaluations of accelerations since the start.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Advances to a time, s. Does nothing if the present instant is at or after that time.
    ///
    /// A simulation that has been ended by a switching function does not advance, see [`Self::ended_by`].
    ///
    /// Steps need not end at this time, since the mechanism and its inputs determine their lengths; results within the
    /// last step are interpolated.
    ///
    /// # Errors
    /// See [`ForwardError`]; the simulation then stays at the last valid instant.
    pub fn advance(&mut self, until: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if until <= self.instant().time || self.is_over() {
            return Ok(());
        }
        while self.now.time < until && self.ended_by.is_none() {
            self.step_once(until, inputs)?;
        }
        if self.now.time > until {
            return self.show(until, inputs);
        }
        self.last_step.shows = false;
        self.take_change(inputs)
    }

    /// Takes one step of integration. If a switching function changes its sign within the step, the step is discarded
    /// and the next one ends there.
    fn step_once(&mut self, until: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        self.last_step.shows = false;
        self.take_change(inputs)?;
        inputs.begin_step(self.now.time);
        self.begin_step();
        let end = self.step_end(until, inputs);
        self.take_step(end, inputs)?;
        if self.goes_back_to_switch(inputs)? {
            return Ok(());
        }
        self.count_turns();
        self.check_speeds()?;
        self.switch(inputs)
    }

    /// Latest end of the next step, s: the next change of the inputs or of a switching function. Results within a step
    /// at rest are not interpolated: it ends at `until` if the inputs are constant until then, otherwise after the
    /// longest step at most.
    fn step_end(&mut self, until: f64, inputs: &mut dyn Inputs) -> f64 {
        let time = self.now.time;
        let change = inputs.next_change(time);
        let mut end = change.unwrap_or(f64::INFINITY);
        let known = inputs.known_until();
        if known < end {
            end = known.max(until);
        }
        let rests = self.stepping.is_none() && self.waits();
        if rests && inputs.steady_until(time) >= until && until < end {
            end = until;
        } else if rests && time + self.settings.longest_step < end {
            end = time + self.settings.longest_step;
        }
        self.change_at = change.unwrap_or(f64::INFINITY);
        end.min(self.switch_at)
    }

    /// Applies the change of the inputs at the present time, if there is one.
    fn take_change(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if self.now.time != self.change_at {
            return Ok(());
        }
        self.change_at = f64::INFINITY;
        inputs.change(&self.view());
        if self.stepping.is_some() {
            return Ok(());
        }
        match self.on_input_change(inputs) {
            Err(error) if self.may_step(&error) => self.begin_stepping(),
            other => other?,
        }
        // Rates may have changed.
        self.count_turns();
        Ok(())
    }

    /// Longest step, s, for which a few samples resolve the inputs.
    fn longest_step(&self, time: f64, inputs: &dyn Inputs) -> f64 {
        let seen = inputs.seen_until(time) - time;
        self.settings.longest_step.min(seen).max(self.settings.shortest_step)
    }

    /// Advances by one step of the present method. The automatic method changes to time stepping if the event-driven
    /// method fails.
    fn take_step(&mut self, end: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if self.is_stalled() {
            let error = self.stalled_error();
            if !self.may_step(&error) {
                return Err(error);
            }
            self.wait_longer();
            self.begin_stepping();
        }
        if self.stepping.is_some() {
            return self.step_through(end, inputs);
        }
        let start = self.now.time;
        match self.advance_once(end, inputs) {
            Err(error) if self.may_step(&error) => {
                self.wait_longer();
                self.begin_stepping();
                if self.now.time > start {
                    // The step reached the event at which no acceleration was found. It ends here, because
                    // results within it come from its own interpolation.
                    return Ok(());
                }
                // If time stepping fails as well, report the error of the event-driven method.
                self.step_through(end, inputs).map_err(|_| error)
            }
            other => other,
        }
    }

    /// Returns whether time has hardly advanced over the last [`PATIENCE`] evaluations.
    fn is_stalled(&mut self) -> bool {
        let (evaluations, since) = self.progress;
        if self.evaluations - evaluations < PATIENCE {
            return false;
        }
        self.progress = (self.evaluations, self.now.time);
        self.now.time - since < LEAST_PROGRESS * self.settings.longest_step
    }

    fn stalled_error(&self) -> ForwardError {
        let load = |c: &usize| self.now.interfaces[*c].load;
        let most = (0..self.modes.len()).max_by(|a, b| load(a).total_cmp(&load(b)));
        ForwardError::Stalled {
            time: self.now.time,
            evaluations: PATIENCE,
            joint: most.map(|c| self.model.joint_name(self.model.parameters.interfaces[c].joint)),
        }
    }
}
