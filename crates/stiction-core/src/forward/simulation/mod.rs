//! Simulation of a mechanism over time: steps, events and energy balance.

mod abrupt;
mod between;
mod bound;
mod by_program;
mod checkpoint;
mod decide;
mod driven;
mod economy;
mod energies;
mod event;
mod halving;
mod input_change;
mod linearisation;
mod load_prediction;
mod locate;
mod locking;
mod method_change;
mod order;
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
use super::data::{Data, FrictionDistribution};
use super::error::ForwardError;
use super::inputs::{InputState, Inputs};
use super::integrator::Steps;
use super::project::Anchor;
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::instant::Instant;
use crate::kinematics::State;
use between::LastStep;
use economy::Economy;
use scratch::Scratch;

/// A friction interface counts as at rest below this fraction of the largest sliding velocity since
/// the start of the simulation.
const REST: f64 = 1e-10;

/// Number of evaluations after which progress is checked. The simulation stalls if time has
/// advanced by less than [`LEAST_PROGRESS`] times the longest step during these evaluations.
const PATIENCE: usize = 5_000;
/// Number of evaluations that take as much time as the search for a solution of a time step that has
/// none.
const UNSOLVED: usize = 50;
/// Smallest advance of time during [`PATIENCE`] evaluations, as a fraction of the longest step.
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
    distribution: FrictionDistribution,
    limit_factor: f64,
    /// Internal states of the inputs, signs of their switching functions, and unwrapped angles.
    input: InputState,
    /// Time, s, at which switching functions change their sign; infinite if no change was found in
    /// the last step.
    switch_at: f64,
    /// Flag for each switching function: true if it changes its sign at `switch_at`.
    switching: Vec<bool>,
    /// Number of sign changes of switching functions that occurred at the same time, and this time,
    /// s.
    switches_at_once: (usize, f64),
    /// Start, s, of the last time step that was shortened because of a switching function.
    shortened_at: f64,
    /// Number of sign changes of switching functions in rapid succession, and the times of the
    /// first and last change, s.
    chatter: (usize, f64, f64),
    /// Switching function that has ended the simulation, if any.
    ended_by: Option<usize>,
    energies: Energies,
    energy_at_start: f64,
    fastest: f64,
    /// Largest rate of any degree of freedom of the spanning tree since the start, rad/s or
    /// characteristic lengths per second.
    fastest_rate: f64,
    /// Largest relative error of a step through a singular configuration, if above the tolerance;
    /// zero otherwise.
    coarsest: f64,
    step: f64,
    /// Longest step, s, for which the integration methods of orders four and five are expected to
    /// meet their part of the tolerance.
    longest_of_lower_order: [f64; 2],
    /// True once results of the recorded program have not satisfied all equations. The general
    /// solver then computes the rest of the simulation.
    program_failed: bool,
    /// Motion since the uniqueness bound was computed last, rad or characteristic lengths.
    motion_since_bound: f64,
    /// Motion after which the bound is computed again, as a multiple of the motion that suffices if
    /// the bound changes fast.
    bound_reach: f64,
    events: Vec<Event>,
    /// True if a singular configuration was reported and the mechanism is still near it.
    in_passage: bool,
    reported_others: bool,
    reported_shares: usize,
    /// Number of decisions between stick and slip since the last step without an event.
    stalled: usize,
    steps: Steps,
    scales: Vec<f64>,
    evaluations: usize,
    stepping: Option<stepping::Stepping>,
    /// Number of events in the current count for the event rate, and the time at which this count
    /// began, s.
    event_rate: (usize, f64),
    dropped: f64,
    /// Number of velocity jumps that may still be located, and the time of the last one that was, s;
    /// see [`Simulation::jumps_left`].
    jumps: (f64, f64),
    /// Number of steps limited by stability since the last reset, and number of consecutive steps
    /// not limited by stability; see `is_stiff`.
    stiff: (usize, usize),
    /// Number of consecutive very short steps, see `is_stiff`.
    crawling: usize,
    /// Number of evaluations, and the time in s, at the last check for a stall.
    progress: (usize, f64),
    /// Number of time steps without a solution since that check.
    unsolved_steps: usize,
    /// Number of time steps without a stick-slip transition after which the simulation tries the
    /// event-driven method again.
    wait: usize,
    economy: Economy,
    workspace: Box<Scratch>,
    /// Unused vectors, stored for reuse of their memory.
    lists: Vec<Vec<f64>>,
    last_step: LastStep<'a>,
    /// Time, s, of the next jump of an input or controller sample, see [`Inputs::next_change`];
    /// infinite if none follows.
    change_at: f64,
}

impl<'a> Simulation<'a> {
    /// Returns the state, forces and energies at the present instant.
    pub fn instant(&self) -> &Instant {
        &self.shown().now
    }

    /// Returns true if the last solution of the equations of motion used the sparse solver.
    #[doc(hidden)]
    pub fn is_sparse(&self) -> bool {
        self.workspace.solved.balance.is_sparse()
    }

    /// Returns the events up to the present instant, in chronological order.
    pub fn events(&self) -> &[Event] {
        let time = self.instant().time;
        match self.last_step.shows {
            true => &self.events[..self.events.partition_point(|event| event.time <= time)],
            false => &self.events,
        }
    }

    /// Returns the mode of each friction interface: stick, slip, or a smooth law.
    pub fn interfaces(&self) -> &[InterfaceMode] {
        &self.shown().modes
    }

    /// Returns the relative change of the initial rates due to their projection onto the
    /// constraints. The value exceeds round-off if loops, prescribed joints or locked joints do not
    /// allow the given initial rates.
    pub fn dropped(&self) -> f64 {
        self.dropped
    }

    /// Returns the largest estimated relative error of all steps near singular configurations of
    /// the loops, at which round-off prevents a smaller error. Returns zero if all steps meet the
    /// tolerance.
    pub fn coarsest(&self) -> f64 {
        self.coarsest
    }

    /// Returns the number of evaluations of accelerations since the start.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Advances to the time `until`, s. Does nothing if the present instant is at or after this
    /// time.
    ///
    /// This method also does nothing if a switching function has ended the simulation, see
    /// [`Self::ended_by`].
    ///
    /// Steps need not end at this time, since only the mechanism and its inputs determine the step
    /// sizes. Results within the last step are interpolated.
    ///
    /// # Errors
    /// See [`ForwardError`]. After an error the simulation stays at the last valid instant.
    pub fn advance(&mut self, until: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if until <= self.instant().time || self.is_over() {
            return Ok(());
        }
        self.workspace.knows_inputs = false;
        while self.now.time < until && self.ended_by.is_none() {
            self.step_once(until, inputs)?;
        }
        if self.now.time > until {
            return self.show(until, inputs);
        }
        self.last_step.shows = false;
        self.take_change(inputs)
    }

    /// Evaluates positions, velocities and inputs of a state at the present time.
    fn situation_of(&self, state: State<f64>, inputs: &mut dyn Inputs) -> Data {
        self.model.data(
            self.now.time,
            state,
            &self.bristles,
            &self.distribution,
            (&self.input, inputs),
        )
    }

    /// Takes one integration step. If a switching function changes its sign within the step, the
    /// step is discarded, and the next step ends at the sign change.
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

    /// Returns the latest time, s, at which the next step may end: the next change of the inputs or
    /// of a switching function. A step at rest is shorter, because results within it are not
    /// interpolated: it ends at `until` if the inputs are constant until then, and otherwise
    /// extends over at most the longest step.
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

    /// Applies the change of the inputs at the present time, if any.
    fn take_change(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if self.now.time != self.change_at {
            return Ok(());
        }
        self.change_at = f64::INFINITY;
        self.workspace.knows_inputs = false;
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

    /// Returns the longest step from `time`, s, that the settings allow and for which a few samples
    /// resolve the inputs (see [`Inputs::seen_until`]).
    fn longest_step(&self, time: f64, inputs: &dyn Inputs) -> f64 {
        let seen = inputs.seen_until(time) - time;
        self.settings.longest_step.min(seen).max(self.settings.shortest_step)
    }

    /// Advances by one step of the present integration method. The automatic method changes to time
    /// stepping if the event-driven method fails.
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
                    // The step reached the event at which no accelerations were found. The step
                    // ends there, because results within a step are interpolated by the method of
                    // this step.
                    return Ok(());
                }
                // If time stepping fails as well, report the error of the event-driven method.
                self.step_through(end, inputs).map_err(|_| error)
            }
            other => other,
        }
    }

    /// Returns true if time has hardly advanced over the last [`PATIENCE`] evaluations.
    fn is_stalled(&mut self) -> bool {
        let (evaluations, since) = self.progress;
        let unsolved = UNSOLVED * self.unsolved_steps;
        if self.evaluations - evaluations + unsolved < PATIENCE {
            return false;
        }
        self.progress = (self.evaluations, self.now.time);
        self.unsolved_steps = 0;
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
