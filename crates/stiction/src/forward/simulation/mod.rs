//! A mechanism on its way through time: steps, events, and the account of energy.

mod decide;
mod energies;
mod event;
mod hold;
mod locate;
mod others;
mod packing;
mod settings;
mod start;
mod step;

pub use energies::Energies;
pub use event::{Event, EventKind};
pub use settings::Settings;

use super::Forward;
use super::error::ForwardError;
use super::inputs::{Inputs, View};
use super::integrator::Steps;
use super::project::Anchor;
use crate::forward::evaluate::Instant;
use crate::forward::rub::Contact;

/// Contacts slower than this part of the fastest rest.
const REST: f64 = 1e-10;

/// A mechanism on its way through time.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    model: &'a Forward,
    settings: Settings,
    now: Instant,
    modes: Vec<Contact>,
    anchors: Vec<Anchor>,
    frozen: Vec<bool>,
    bristles: Vec<[f64; 3]>,
    grips: Vec<f64>,
    shares: Vec<[f64; 3]>,
    overload: f64,
    energies: Energies,
    energy_at_start: f64,
    fastest: f64,
    /// Of the tree, lengths in characteristic lengths.
    fastest_rate: f64,
    step: f64,
    events: Vec<Event>,
    told_of_others: bool,
    told_of_shares: usize,
    stalled: usize,
    steps: Steps,
    scales: Vec<f64>,
    evaluations: usize,
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
    pub fn contacts(&self) -> &[Contact] {
        &self.modes
    }

    /// How often accelerations were computed.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Goes on to a time.
    ///
    /// # Errors
    /// See [`ForwardError`]; the last good instant stays.
    pub fn advance(&mut self, until: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        while self.now.time < until {
            let change = inputs.next_change(self.now.time).filter(|t| *t <= until);
            let end = change.unwrap_or(until);
            while self.now.time < end {
                self.advance_once(end, inputs)?;
            }
            if change.is_some() {
                let (state, bodies) = (&self.now.state, &self.now.bodies);
                let topology = &self.model.topology;
                inputs.change(&View { time: end, state, bodies, topology });
                self.reconsider(inputs, None)?;
            }
        }
        Ok(())
    }
}
