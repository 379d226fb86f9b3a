//! Inputs of programs that are given the whole state of the tree: coordinates, rates, accelerations, then
//! prescribed values and loads.

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
