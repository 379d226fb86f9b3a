//! Inputs of forward-dynamics programs, which receive the whole state of the tree: coordinates,
//! rates, accelerations, then prescribed values and loads.

use crate::program_inputs::{load_to_array, target_to_array};
use crate::recording::Counts;
use crate::samples::Sample;

impl Counts {
    /// Number of inputs of a forward-dynamics program, without efforts and estimated normal loads.
    pub(crate) fn inputs(&self) -> usize {
        self.coordinates + 2 * self.dofs + 3 * self.targets + 6 * self.loads
    }
}

impl Sample {
    /// Returns the values of the inputs of a forward-dynamics program at this sample, in the order
    /// of the inputs, without efforts and estimated normal loads.
    pub(crate) fn of_tree(&self) -> Vec<f64> {
        let Self { state, targets, loads } = self;
        let mut all = [&state.coordinates[..], &state.rates, &state.accelerations].concat();
        all.extend(targets.iter().flat_map(target_to_array));
        all.extend(loads.iter().flat_map(load_to_array));
        all
    }
}
