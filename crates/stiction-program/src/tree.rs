//! Inputs of forward-dynamics programs, which receive coordinates and rates of the tree, then
//! loads.

use crate::program_inputs::load_to_array;
use crate::recording::Counts;
use crate::samples::Sample;

impl Counts {
    /// Number of inputs of a forward-dynamics program, without efforts and estimated normal loads.
    pub(crate) fn inputs(&self) -> usize {
        self.coordinates + self.dofs + 6 * self.loads
    }
}

impl Sample {
    /// Returns the values of the inputs of a forward-dynamics program at this sample, in the order
    /// of the inputs, without efforts and estimated normal loads.
    pub(crate) fn of_tree(&self) -> Vec<f64> {
        let Self { state, loads, .. } = self;
        let mut all = [&state.coordinates[..], &state.rates].concat();
        all.extend(loads.iter().flat_map(load_to_array));
        all
    }
}
