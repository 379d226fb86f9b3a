//! Data types that the recordings of all kinds of programs use.

use crate::recorded::Recorded;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Model};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::spatial::Vec3;

/// Numbers of coordinates, joints, interfaces and other parts of a mechanism and its program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub(crate) coordinates: usize,
    pub(crate) dofs: usize,
    pub(crate) targets: usize,
    pub(crate) loads: usize,
    pub(crate) interfaces: usize,
    /// Number of interfaces whose friction changes a normal load.
    pub(crate) coupled: usize,
    pub(crate) drives: usize,
    pub(crate) joints: usize,
}

/// Data from which a program is recorded: the model, its solver and the loads.
#[derive(Clone, Copy)]
pub(crate) struct RecordingSource<'a> {
    pub(crate) model: &'a Model,
    pub(crate) solver: &'a InverseDynamics,
    pub(crate) loads: &'a [AppliedLoad<f64>],
}

/// Inputs of a recorded evaluation of inverse dynamics.
pub(crate) struct Followed {
    pub(crate) coordinates: Vec<Recorded>,
    pub(crate) targets: Vec<Target<Recorded>>,
    pub(crate) loads: Vec<AppliedLoad<Recorded>>,
    /// Parameters of the mechanism. Tunable parameters are inputs of the graph, all others
    /// constants.
    pub(crate) parameters: Parameters<Recorded>,
}

impl RecordingSource<'_> {
    /// Reads the loads from the inputs of a recording, which follow one after the other.
    pub(crate) fn read_loads(
        &self,
        mut next: impl FnMut() -> Recorded,
    ) -> Vec<AppliedLoad<Recorded>> {
        let mut vector = || Vec3::new(next(), next(), next());
        let each = self.loads.iter();
        each.map(|load| AppliedLoad { force: vector(), moment: vector(), ..load.lift() }).collect()
    }

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
