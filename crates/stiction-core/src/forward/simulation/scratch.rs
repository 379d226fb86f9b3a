//! Room that evaluations use again and again.

use super::ranks::Ranks;
use crate::forward::Forward;
use crate::forward::data::Data;
use crate::forward::instant::Instant;
use crate::forward::project::Projection;
use crate::forward::solve::Solved;
use crate::kinematics::State;

/// Room that evaluations use again and again. Nothing in it is part of a simulation's state.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    pub(super) situation: Data,
    pub(super) solved: Solved,
    pub(super) projection: Projection,
    /// Loads nearby, where Newton's method starts.
    pub(super) loads: Vec<f64>,
    /// Whether conditions are decomposed where the mechanism stands still.
    pub(super) conditions_hold: bool,
    /// The least part of its limit that any contact which sticks had left at the stages of a step.
    pub(super) margin: f64,
    /// Coordinates and rates that are moved onto the loops, and all that goes with them.
    pub(super) y: Vec<f64>,
    /// Where the last step began.
    pub(super) before: State<f64>,
    pub(super) ranks: Ranks,
    /// Instants that nobody needs any more.
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
            y: Vec::new(),
            before: State::new(&model.topology),
            ranks: Ranks::new(model),
            spare: Vec::new(),
        }
    }

    /// Room for an instant.
    pub(super) fn instant(&mut self, model: &Forward) -> Instant {
        self.spare.pop().unwrap_or_else(|| Instant::new(model))
    }

    /// Takes it back.
    pub(super) fn spare(&mut self, instant: Instant) {
        self.spare.push(instant);
    }
}
