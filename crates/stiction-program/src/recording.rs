//! What all programs are recorded from, and its sizes.

use crate::recorded::Recorded;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Model};
use stiction_core::kinematics::Target;

/// Sizes of a mechanism and of what is asked of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub(crate) coordinates: usize,
    pub(crate) dofs: usize,
    pub(crate) targets: usize,
    pub(crate) loads: usize,
    pub(crate) interfaces: usize,
    /// Contacts whose friction changes some load.
    pub(crate) coupled: usize,
    pub(crate) drives: usize,
    pub(crate) joints: usize,
}

/// Everything that is recorded from.
#[derive(Clone, Copy)]
pub(crate) struct Recipe<'a> {
    pub(crate) model: &'a Model,
    pub(crate) solver: &'a InverseDynamics,
    pub(crate) loads: &'a [AppliedLoad<f64>],
}

/// What inverse dynamics was recorded from.
pub(crate) struct Followed {
    pub(crate) coordinates: Vec<Recorded>,
    pub(crate) targets: Vec<Target<Recorded>>,
    pub(crate) loads: Vec<AppliedLoad<Recorded>>,
}

impl Recipe<'_> {
    pub(crate) fn counts(&self, coupled: usize) -> Counts {
        let (solver, state) = (self.solver, self.solver.state());
        Counts {
            coordinates: state.coordinates.len(),
            dofs: state.rates.len(),
            targets: solver.constraints().coordinates().len(),
            loads: self.loads.len(),
            interfaces: solver.parameters().interfaces.len(),
            coupled,
            drives: solver.mechanism().actuators().count(),
            joints: solver.mechanism().joints().len(),
        }
    }
}
