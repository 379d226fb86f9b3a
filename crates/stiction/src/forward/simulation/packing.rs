//! State, bristles and energies as one list of numbers for the integrator.

use super::Simulation;
use crate::forward::evaluate::Instant;
use crate::kinematics::State;

impl Simulation<'_> {
    pub(super) fn pack(&self) -> Vec<f64> {
        let state = &self.now.state;
        let mut y = state.coordinates.clone();
        y.extend_from_slice(&state.rates);
        y.extend(self.bristles.iter().flatten());
        let energies = &self.energies;
        y.extend_from_slice(&energies.drives);
        y.extend([energies.loads, energies.dampers, energies.turnover]);
        y.extend_from_slice(&energies.contacts);
        y
    }

    pub(super) fn unpack<'y>(&self, y: &'y [f64]) -> (State<f64>, &'y [f64]) {
        let coordinates = self.now.state.coordinates.len();
        let rates = self.now.state.rates.len();
        let state = State {
            coordinates: y[..coordinates].to_vec(),
            rates: y[coordinates..coordinates + rates].to_vec(),
            accelerations: vec![0.0; rates],
        };
        (state, &y[coordinates + rates..])
    }

    pub(super) fn derivative_of(&self, at: &Instant) -> Vec<f64> {
        let state = &at.state;
        let mut rates = vec![0.0; state.coordinates.len()];
        self.model.coordinate_rates(&state.coordinates, &state.rates, &mut rates);
        rates.extend_from_slice(&state.accelerations);
        rates.extend(at.bristle_rates.iter().flatten());
        let account = &at.account;
        rates.extend_from_slice(&account.drives);
        rates.push(account.loads);
        rates.push(account.dampers);
        let powers = account.drives.iter().chain(&account.contacts).map(|p| p.abs());
        let others = [account.loads, account.dampers, account.exchange];
        rates.push(powers.chain(others.map(f64::abs)).sum::<f64>());
        rates.extend_from_slice(&account.contacts);
        rates
    }

    /// Errors of coordinates and rates count, lengths in characteristic lengths; bristles by their own
    /// size; energies are quadratures of the same and do not count.
    pub(super) fn error_scales(&self) -> Vec<f64> {
        let (topology, columns) = (&self.model.topology, &self.model.columns);
        let mut scales = vec![1.0; topology.coordinates()];
        for node in &topology.nodes {
            let dofs = node.dofs.clone();
            for (scale, dof) in scales[node.coordinates.clone()].iter_mut().zip(dofs) {
                *scale = columns[dof];
            }
        }
        scales.extend_from_slice(columns);
        for contact in &self.model.parameters.contacts {
            let bristles = contact.law.bristles.as_ref();
            let size = bristles.map_or(f64::INFINITY, |b| contact.law.at_rest() / b.stiffness);
            scales.extend([size; 3]);
        }
        let energies = self.energies.drives.len() + 3 + self.energies.contacts.len();
        scales.extend(std::iter::repeat_n(f64::INFINITY, energies));
        scales
    }
}
