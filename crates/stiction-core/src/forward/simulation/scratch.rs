//! Buffers for evaluations of the equations of motion.

use super::load_prediction::LoadPrediction;
use super::ranks::Ranks;
use crate::forward::Forward;
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::data::Data;
use crate::forward::instant::Instant;
use crate::forward::project::Projection;
use crate::forward::recorded::{ProgramBuffers, Recorded};
use crate::forward::solve::Solved;
use crate::kinematics::State;
use crate::statics::AppliedLoad;

/// Largest number of unused [`Instant`]s that are stored for reuse.
const MOST_SPARE: usize = 8;

/// Buffers for evaluations of the equations of motion. They are not part of the state of a
/// simulation.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    pub(super) situation: Data,
    /// True if the motion of the bodies in `situation` is that of its state.
    pub(super) is_placed: bool,
    /// True if inertias and bias forces in `situation` are those of the motion of the bodies under
    /// the loads `mass_loads`.
    pub(super) has_masses: bool,
    pub(super) mass_loads: Vec<AppliedLoad<f64>>,
    /// True if efforts and loads in `situation` are those of the present inputs at the last
    /// evaluation.
    pub(super) knows_inputs: bool,
    pub(super) solved: Solved,
    /// Modes for which `solved` contains the solution at the state in `situation`; empty if there
    /// is no solution.
    pub(super) solved_modes: Vec<InterfaceMode>,
    pub(super) projection: Projection,
    /// Buffers of the recorded program; `None` if the model has no program.
    pub(super) program: Option<ProgramBuffers>,
    pub(super) loads: LoadPrediction,
    /// Relative error of normal loads that the next evaluation may have, if it exceeds that at the
    /// end of a step.
    pub(super) load_tolerance: f64,
    /// True if the stored factorisation of the constraint matrix is valid for the present
    /// configuration of a mechanism at rest.
    pub(super) conditions_hold: bool,
    /// Smallest relative margin to the friction limit among all sticking interfaces and all stages
    /// of a step.
    pub(super) margin: f64,
    /// For each sliding interface, the smallest speed along its direction of slip among the stages
    /// of a step, m/s; empty if it is not known at all stages.
    pub(super) least_speeds: Vec<f64>,
    /// Smallest singularity index among the stages of a step, see [`Instant::distance`].
    pub(super) nearest: f64,
    /// Expected relative error of the present step if it crosses a singular configuration,
    /// otherwise `None`.
    pub(super) crosses: Option<f64>,
    /// Buffer for a state vector while it is projected onto the loop constraints.
    pub(super) y: Vec<f64>,
    /// State at the start of the last step.
    pub(super) before: State<f64>,
    pub(super) ranks: Ranks,
    /// Unused [`Instant`]s, stored for reuse of their memory.
    spare: Vec<Instant>,
}

impl Scratch {
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            situation: Data::new(model),
            is_placed: false,
            has_masses: false,
            mass_loads: Vec::new(),
            knows_inputs: false,
            solved: Solved::default(),
            solved_modes: Vec::new(),
            projection: Projection::new(model),
            program: model.recorded.as_ref().map(Recorded::buffers),
            loads: LoadPrediction::default(),
            load_tolerance: 0.0,
            conditions_hold: false,
            margin: f64::INFINITY,
            least_speeds: Vec::new(),
            nearest: f64::INFINITY,
            crosses: None,
            y: Vec::new(),
            before: State::new(&model.topology),
            ranks: Ranks::new(model),
            spare: Vec::new(),
        }
    }

    /// Returns an [`Instant`] with arbitrary values, which reuses the memory of an unused instant
    /// if possible.
    pub(super) fn instant(&mut self, model: &Forward) -> Instant {
        self.spare.pop().unwrap_or_else(|| Instant::new(model))
    }

    /// Keeps an unused [`Instant`], so that its memory can be reused. Stores at most [`MOST_SPARE`]
    /// instants, since only a few are needed at the same time.
    pub(super) fn spare(&mut self, instant: Instant) {
        if self.spare.len() < MOST_SPARE {
            self.spare.push(instant);
        }
    }
}
