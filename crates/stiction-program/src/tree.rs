//! What programs are recorded from that are given the whole state of the tree: coordinates, rates,
//! accelerations, then prescribed values and loads.

use crate::samples::Sample;
use stiction::dynamics::{AppliedLoad, InverseDynamics, Kernel};
use stiction::kinematics::{State, Target};

/// Sizes of such a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub(crate) coordinates: usize,
    pub(crate) freedoms: usize,
    pub(crate) targets: usize,
    pub(crate) loads: usize,
    pub(crate) contacts: usize,
    /// Contacts whose friction changes some load.
    pub(crate) coupled: usize,
    pub(crate) drives: usize,
    pub(crate) joints: usize,
}

impl Counts {
    /// Inputs but for those of a program's own.
    pub(crate) fn inputs(&self) -> usize {
        self.coordinates + 2 * self.freedoms + 3 * self.targets + 6 * self.loads
    }
}

/// Everything that is recorded from.
pub(crate) struct Recipe<'a> {
    pub(crate) kernel: &'a Kernel,
    pub(crate) solver: &'a InverseDynamics,
    pub(crate) loads: &'a [AppliedLoad<f64>],
}

impl Recipe<'_> {
    pub(crate) fn counts(&self, coupled: usize) -> Counts {
        let (solver, state) = (self.solver, self.solver.assembly().state());
        Counts {
            coordinates: state.coordinates.len(),
            freedoms: state.rates.len(),
            targets: solver.assembly().prescription().coordinates().len(),
            loads: self.loads.len(),
            contacts: solver.parameters().contacts.len(),
            coupled,
            drives: solver.mechanism().actuators().count(),
            joints: solver.mechanism().joints().len(),
        }
    }
}

/// All numbers in the order of inputs.
pub(crate) fn numbers_of<'a>(
    state: &'a State<f64>,
    targets: &'a [Target<f64>],
    loads: &'a [AppliedLoad<f64>],
) -> impl Iterator<Item = f64> + 'a {
    let State { coordinates, rates, accelerations } = state;
    let tree = coordinates.iter().chain(rates).chain(accelerations).copied();
    let targets = targets.iter().flat_map(|t| [t.value, t.rate, t.acceleration]);
    let wrench = |load: &AppliedLoad<f64>| [load.force.to_array(), load.moment.to_array()];
    tree.chain(targets).chain(loads.iter().flat_map(wrench).flatten())
}

impl Sample {
    /// All its numbers.
    pub(crate) fn of_tree(&self) -> Vec<f64> {
        numbers_of(&self.state, &self.targets, &self.loads).collect()
    }
}
