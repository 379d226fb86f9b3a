//! State vector of the integrator: coordinates, rates, bristle deflections, energies, and internal
//! states of the inputs.

use super::Simulation;
use crate::forward::instant::{Account, Instant};
use crate::kinematics::State;

impl Simulation<'_> {
    pub(super) fn pack(&self) -> Vec<f64> {
        let mut y = Vec::new();
        self.pack_into(&mut y);
        y
    }

    /// Writes the present state as a state vector to `y`, reusing the buffer.
    pub(super) fn pack_into(&self, y: &mut Vec<f64>) {
        let state = &self.now.state;
        y.clear();
        y.extend_from_slice(&state.coordinates);
        y.extend_from_slice(&state.rates);
        y.extend(self.bristles.iter().flatten());
        let energies = &self.energies;
        y.extend_from_slice(&energies.drives);
        y.extend([energies.loads, energies.dampers, energies.turnover]);
        y.extend_from_slice(&energies.interfaces);
        y.extend_from_slice(&self.input.values);
    }

    pub(super) fn unpack<'y>(&self, y: &'y [f64]) -> (State<f64>, &'y [f64]) {
        let (coordinates, rates, rest) = parts(&self.now, y);
        let accelerations = vec![0.0; rates.len()];
        let (coordinates, rates) = (coordinates.to_vec(), rates.to_vec());
        (State { coordinates, rates, accelerations }, rest)
    }

    pub(super) fn derivative_into(&self, at: &Instant, rates: &mut Vec<f64>) {
        let state = &at.state;
        rates.clear();
        rates.resize(state.coordinates.len(), 0.0);
        self.model.coordinate_rates(&state.coordinates, &state.rates, rates);
        rates.extend_from_slice(&state.accelerations);
        rates.extend(at.bristle_rates.iter().flatten());
        let Account { drives, loads, dampers, exchange, interfaces, .. } = &at.account;
        let (drives, interfaces) = (drives.iter().copied(), interfaces.iter().copied());
        append_powers(drives, [*loads, *dampers, *exchange], interfaces, rates);
        rates.extend_from_slice(&at.input_rates);
    }

    /// Returns an empty vector, which reuses the memory of an unused vector if possible.
    pub(super) fn list(&mut self) -> Vec<f64> {
        self.lists.pop().unwrap_or_default()
    }

    /// Returns the scale of the error estimate for each component of the state vector: one for
    /// angles, the characteristic length for lengths, the largest steady deflection for bristles,
    /// and the magnitudes given by the inputs for their internal states. The scale of energies is
    /// infinite, because energies are integrals that do not affect the motion.
    pub(super) fn error_scales(&self) -> Vec<f64> {
        let (topology, columns) = (&self.model.topology, &self.model.columns);
        let mut scales = vec![1.0; topology.coordinates()];
        for node in &topology.nodes {
            let tree_dofs = node.tree_dofs.clone();
            for (scale, tree_dof) in scales[node.coordinates.clone()].iter_mut().zip(tree_dofs) {
                *scale = columns[tree_dof];
            }
        }
        scales.extend_from_slice(columns);
        for interface in &self.model.parameters.interfaces {
            let bristles = interface.law.bristles.as_ref();
            let size = bristles.map_or(f64::INFINITY, |b| interface.law.at_rest() / b.stiffness);
            scales.extend([size; 3]);
        }
        let energies = self.energies.drives.len() + 3 + self.energies.interfaces.len();
        scales.extend(std::iter::repeat_n(f64::INFINITY, energies));
        scales.extend(&self.input.scales);
        scales
    }
}

/// Appends the time derivatives of the energies: the powers of the actuators, the powers of loads
/// and dampers, the turnover, and the powers of the interfaces. The third of `others` is the rate
/// of the potential energy.
pub(super) fn append_powers(
    drives: impl Iterator<Item = f64> + Clone,
    others: [f64; 3],
    interfaces: impl Iterator<Item = f64> + Clone,
    rates: &mut Vec<f64>,
) {
    let powers = drives.clone().chain(interfaces.clone()).map(f64::abs);
    let turnover = powers.chain(others.map(f64::abs)).sum::<f64>();
    rates.extend(drives);
    rates.extend([others[0], others[1], turnover]);
    rates.extend(interfaces);
}

/// Splits a state vector into coordinates, rates and all other components.
pub(super) fn parts<'y>(at: &Instant, y: &'y [f64]) -> (&'y [f64], &'y [f64], &'y [f64]) {
    let (coordinates, rest) = y.split_at(at.state.coordinates.len());
    let (rates, rest) = rest.split_at(at.state.rates.len());
    (coordinates, rates, rest)
}
