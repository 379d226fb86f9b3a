//! Buffers of evaluations.

use super::ranks::Ranks;
use crate::forward::Forward;
use crate::forward::data::Data;
use crate::forward::instant::Instant;
use crate::forward::project::Projection;
use crate::forward::solve::Solved;
use crate::kinematics::State;

/// Largest number of unused instants that are kept.
const MOST_SPARE: usize = 8;

/// Buffers of evaluations. They are no part of the state of a simulation.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    pub(super) situation: Data,
    pub(super) solved: Solved,
    pub(super) projection: Projection,
    /// Normal forces at which Newton's method starts.
    pub(super) loads: Vec<f64>,
    /// True if the constraint matrix of the present position at rest is decomposed.
    pub(super) conditions_hold: bool,
    /// Smallest relative margin to the friction limit of any sticking interface at the stages of a step.
    pub(super) margin: f64,
    /// Smallest singularity distance at the stages of a step, see [`Instant::distance`].
    pub(super) nearest: f64,
    /// Relative error expected of the present step, if it crosses a singular position.
    pub(super) crosses: Option<f64>,
    /// State vector that is projected onto the loop constraints.
    pub(super) y: Vec<f64>,
    /// State at the start of the last step.
    pub(super) before: State<f64>,
    pub(super) ranks: Ranks,
    /// Unused instants, kept to reuse their memory.
    spare: Vec<Instant>,
}

impl Scratch {
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            situation: Data::new(model),
            solved: Solved::default(),
            projection: Projection::new(model),
            loads: Vec::new(),
            conditions_hold: false,
            margin: f64::INFINITY,
            nearest: f64::INFINITY,
            crosses: None,
            y: Vec::new(),
            before: State::new(&model.topology),
            ranks: Ranks::new(model),
            spare: Vec::new(),
        }
    }

    /// Returns an unused instant, or a new one.
    pub(super) fn instant(&mut self, model: &Forward) -> Instant {
        self.spare.pop().unwrap_or_else(|| Instant::new(model))
    }

    /// Returns an instant that is no longer used. Some instants are created anew, and only a few are needed at
    /// once.
    pub(super) fn spare(&mut self, instant: Instant) {
        if self.spare.len() < MOST_SPARE {
            self.spare.push(instant);
        }
    }
}
