//! Inputs of programs that are given the whole state of the tree: coordinates, rates, accelerations, then
//! prescribed values and loads.

use crate::given::{load_to_array, target_to_array};
use crate::recipe::Counts;
use crate::samples::Sample;
use stiction::dynamics::AppliedLoad;
use stiction::kinematics::{State, Target};

impl Counts {
    /// Inputs but for those of a program's own.
    pub(crate) fn inputs(&self) -> usize {
        self.coordinates + 2 * self.freedoms + 3 * self.targets + 6 * self.loads
    }
}

/// Puts all numbers in the order of inputs, a piece at a time.
#[inline]
pub(crate) fn put_tree(
    state: &State<f64>,
    targets: &[Target<f64>],
    loads: &[AppliedLoad<f64>],
    mut put: impl FnMut(&[f64]),
) {
    put(&state.coordinates);
    put(&state.rates);
    put(&state.accelerations);
    for target in targets {
        put(&target_to_array(target));
    }
    for load in loads {
        put(&load_to_array(load));
    }
}

impl Sample {
    /// All its numbers.
    pub(crate) fn of_tree(&self) -> Vec<f64> {
        let mut all = Vec::new();
        put_tree(&self.state, &self.targets, &self.loads, |numbers| all.extend(numbers));
        all
    }
}
