//! What is told of the whole simulation.

use super::checkpoint::Mark;
use super::error::Error;
use stiction_core::forward::Event;

/// How a simulation ended.
#[derive(Debug)]
pub enum Ending {
    /// It reached its last instant.
    Reached,
    /// The user stopped it.
    Interrupted,
    /// It cannot go on.
    Failed(Box<Error>),
}

/// What holds of the whole.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// Number of samples.
    pub samples: usize,
    /// What happened.
    pub events: Vec<Event>,
    /// The instant of the last sample, s.
    pub last: f64,
    /// Redundant constraints, those of contacts that stick among them, the most at any sample.
    pub redundant: usize,
    /// Efforts of what is prescribed or locked that are open, the most at any sample.
    pub open_drives: usize,
    /// How often accelerations were computed.
    pub evaluations: usize,
    /// The state at the last sample, if the user stopped it.
    pub mark: Option<Mark>,
    /// Whether the actuators determine the motion, so that inverse dynamics can be asked for it.
    pub invertible: bool,
    /// Whether the rates at the start are others than was asked for, since what is prescribed or locked does
    /// not allow those.
    pub rates_changed: bool,
}
