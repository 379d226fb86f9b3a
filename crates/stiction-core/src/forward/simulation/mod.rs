//! A mechanism on its way through time: steps, events, and the account of energy.

mod abrupt;
mod checkpoint;
mod decide;
mod energies;
mod event;
mod input_change;
mod locate;
mod locking;
mod others;
mod packing;
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
mod turns;
mod wait;

pub use checkpoint::Checkpoint;
pub use energies::Energies;
pub use event::{Event, EventKind};
pub use settings::{Method, Settings};

use super::Forward;
use super::error::ForwardError;
use super::inputs::{Angle, Inputs};
use super::integrator::Steps;
use super::project::Anchor;
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::instant::Instant;
use scratch::Scratch;

/// Contacts slower than this part of the fastest rest.
const REST: f64 = 1e-10;

/// A mechanism on its way through time.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    model: &'a Forward,
    settings: Settings,
    now: Instant,
    modes: Vec<InterfaceMode>,
    anchors: Vec<Anchor>,
    frozen: Vec<bool>,
    bristles: Vec<[f64; 3]>,
    grips: Vec<f64>,
    shares: Vec<[f64; 3]>,
    overload: f64,
    /// Of joints that close a loop.
    angles: Vec<Angle>,
    energies: Energies,
    energy_at_start: f64,
    fastest: f64,
    /// Of the tree, lengths in characteristic lengths.
    fastest_rate: f64,
    step: f64,
    events: Vec<Event>,
    /// A singular position was reported and the mechanism is still near it.
    in_passage: bool,
    told_of_others: bool,
    told_of_shares: usize,
    stalled: usize,
    steps: Steps,
    scales: Vec<f64>,
    evaluations: usize,
    stepping: Option<stepping::Stepping>,
    /// Events since some time, and that time.
    pace: (usize, f64),
    dropped: f64,
    /// Steps in a row that stability bounds, and such that it does not since.
    stiff: (usize, usize),
    /// How many quiet steps of the time stepper it takes before events are tried again.
    wait: usize,
    room: Box<Scratch>,
    /// Lists of numbers that nobody needs any more.
    lists: Vec<Vec<f64>>,
}

impl Simulation<'_> {
    /// Everything at the present instant.
    pub fn instant(&self) -> &Instant {
        &self.now
    }

    /// What happened since the start.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// What each contact does.
    pub fn interfaces(&self) -> &[InterfaceMode] {
        &self.modes
    }

    /// By how much rates at the start are others than was asked for, as a part of the largest: loops and
    /// what is prescribed or locked do not allow all. Zero but for rounding where they do.
    pub fn dropped(&self) -> f64 {
        self.dropped
    }

    /// How often accelerations were computed.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Goes on to a time, s; nothing happens if that is past.
    ///
    /// # Errors
    /// See [`ForwardError`]; the last good instant stays.
    pub fn advance(&mut self, until: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        while self.now.time < until {
            let change = inputs.next_change(self.now.time).filter(|t| *t <= until);
            let end = change.unwrap_or(until);
            while self.now.time < end {
                self.go_on(end, inputs)?;
                self.count_turns();
                self.check_speeds()?;
            }
            if change.is_some() {
                inputs.change(&self.view());
                if self.stepping.is_none() {
                    match self.heed_change(inputs) {
                        Err(error) if self.may_step(&error) => self.begin_stepping(),
                        other => other?,
                    }
                    // Rates may be others.
                    self.count_turns();
                }
            }
        }
        Ok(())
    }

    /// How long a step may be at most, so that it sees what acts.
    fn longest_step(&self, time: f64, inputs: &dyn Inputs) -> f64 {
        let seen = inputs.seen_until(time) - time;
        self.settings.longest_step.min(seen).max(self.settings.shortest_step)
    }

    /// One step, by whichever method goes.
    fn go_on(&mut self, end: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if self.stepping.is_some() {
            return self.step_through(end, inputs);
        }
        match self.advance_once(end, inputs) {
            Err(error) if self.may_step(&error) => {
                self.begin_stepping();
                // Where steps do not go either the first reason is the better one.
                if self.now.time < end {
                    self.step_through(end, inputs).map_err(|_| error)
                } else {
                    Ok(())
                }
            }
            other => other,
        }
    }
}
