//! Result of a whole simulation.

use super::checkpoint::RunCheckpoint;
use super::sampled_loop::Tuning;
use crate::error::Error;
use stiction_core::forward::Event;

/// Reason why a simulation ended.
#[derive(Debug)]
pub enum Ending {
    /// The simulation reached its end time.
    Reached,
    /// A stop condition became true. The variant contains the text of the condition.
    Stopped(String),
    /// The user stopped the simulation.
    Interrupted,
    /// The simulation failed.
    Failed(Box<Error>),
}

/// Result of a whole simulation.
#[derive(Debug)]
pub struct Outcome {
    /// Reason why the simulation ended.
    pub ending: Ending,
    /// Number of samples of the results.
    pub samples: usize,
    /// Events of the simulation in chronological order.
    pub events: Vec<Event>,
    /// Time of the last sample, s.
    pub last: f64,
    /// Largest number of redundant constraints at any sample, including the constraints of sticking
    /// friction interfaces.
    pub redundant: usize,
    /// Largest number of statically indeterminate efforts of prescribed or locked actuators at any sample.
    pub open_drives: usize,
    /// Number of evaluations of the accelerations during the simulation.
    pub evaluations: usize,
    /// Largest relative error of an integration step near a singular configuration; zero if all
    /// steps meet the tolerance.
    pub coarsest: f64,
    /// Checkpoint at the last sample, if the user stopped the simulation.
    pub checkpoint: Option<RunCheckpoint>,
    /// True if the actuators determine the motion, so that inverse dynamics can recompute it.
    pub invertible: bool,
    /// True if the simulation starts with other rates than requested, because loops, prescribed
    /// actuators or locked actuators do not allow the requested rates.
    pub rates_changed: bool,
    /// Stability of the controller at the start; all `None` without a controller.
    pub tuning: Tuning,
    /// Notes for the user on the assembly of the initial configuration.
    pub assembly_notes: Vec<String>,
}
